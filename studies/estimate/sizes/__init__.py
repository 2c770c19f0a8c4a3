"""How noisy, how fast and how large a recording is."""
