"""Many runs of one scenario, over parameters and seeds."""
