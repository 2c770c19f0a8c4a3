"""Datasets as files: NetCDF under a seal, read with the care that a stranger's file needs."""
