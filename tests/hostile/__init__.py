"""The hostile test: drawn commands, files, surroundings, signals and limits, and what must hold after each."""
