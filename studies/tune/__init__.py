"""Gains by trial: many candidates at once over training runs, judged by runs that none of them has seen."""
