"""A Dataset as sentences and tables."""
