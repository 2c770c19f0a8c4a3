"""The same on the workers of a dask cluster."""
