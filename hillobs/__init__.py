"""Observers for a pair of Hill muscles."""
