"""Gains by trial: many candidates at once over training runs, judged by runs that none of them has seen."""

import importlib

from ..files.errors import ScenarioError

try:
    importlib.import_module("optuna")
except ImportError as error:
    raise ScenarioError("tuning needs Optuna: pip install 'hillobs[tune]'") from error
