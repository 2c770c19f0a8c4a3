"""Estimates while the samples come: one observer, sample by sample."""
