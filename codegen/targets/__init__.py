"""Observers for other programs: what is written of one, and the writers."""
