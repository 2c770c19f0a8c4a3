"""What moves the world from outside, as functions of time: reference, uncertainty, given activations, pulses."""
