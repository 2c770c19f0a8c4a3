"""How fast the closed loop is, beside what else could run it: `make bench`."""
