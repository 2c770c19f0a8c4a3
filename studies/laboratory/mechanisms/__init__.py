"""Mechanisms in SI: described in Python or TOML, or taken from an OpenSim model."""
