"""A muscle's numbers from trials in which its activation is known."""
