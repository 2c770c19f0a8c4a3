"""What each misprint of the paper changes."""
