"""How cases are drawn, a file for each kind of thing that can be wrong."""
