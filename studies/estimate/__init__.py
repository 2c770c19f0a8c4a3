"""A recording, followed by observers."""
