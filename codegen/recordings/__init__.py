"""What runs over the samples of a recording."""
