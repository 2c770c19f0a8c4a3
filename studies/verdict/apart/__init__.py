"""The verdict on a recording of a mechanism."""
