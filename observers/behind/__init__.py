"""What follows from an observer's estimates, and how sure that is."""
