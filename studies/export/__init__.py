"""Observers for programs of others."""
