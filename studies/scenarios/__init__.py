"""A scenario, checked, and the Blocks that run it; the TOML files beside this one are the shipped ones."""
