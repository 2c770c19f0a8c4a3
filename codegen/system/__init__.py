"""What the operating system is asked for: locks, signals that wait, the processor, and whose a file is."""
