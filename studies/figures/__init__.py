"""A Dataset as figures."""
