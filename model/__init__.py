"""What the world does: the pair of muscles, its load, its controller, its sensors."""
