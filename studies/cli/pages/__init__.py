"""`make sweep` and `make observability`."""
