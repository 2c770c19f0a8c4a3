"""A recording that comes with hillobs, and the muscles of the three public ones."""
