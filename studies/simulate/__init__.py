"""One run of one scenario."""
