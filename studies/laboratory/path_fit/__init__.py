"""Polynomials for muscles that wrap: OpenSim fits them, in a process of its own, and they are tried here."""
