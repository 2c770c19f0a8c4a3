"""What makes muscles move on purpose: the paper's controller of the pair, and one that tracks with any system."""
