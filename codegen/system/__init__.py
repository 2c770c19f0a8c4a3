"""What the operating system is asked for: locks, signals that wait, memory, the processor, and whose a file is."""
