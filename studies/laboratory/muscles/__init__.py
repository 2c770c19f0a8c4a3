"""Muscles in SI, from a TOML file, checked key by key, and as such a file again."""

from .muscle import SCALED, SIZES, Muscle, numbers_of
from .pair import PAIR, MusclePair, muscle_file, muscle_pair, read_muscles

__all__ = [
    "PAIR",
    "SCALED",
    "SIZES",
    "Muscle",
    "MusclePair",
    "muscle_file",
    "muscle_pair",
    "numbers_of",
    "read_muscles",
]
