"""Expressions to machine code."""
