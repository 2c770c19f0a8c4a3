"""The Dataset of a sweep as figures."""
