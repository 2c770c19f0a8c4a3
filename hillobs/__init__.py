"""Observers for Hill muscles: states, unknown inputs and activations from positions and tendon forces.

    run = hillobs.simulate("paper-noisy")                       # one scenario, all observers
    errors = hillobs.sweep("paper-noisy", {"high_gain.eps_h": [0.05, 0.1, 0.2]}, seeds=16)
    estimates = hillobs.estimate("run.csv", "pair.toml")         # from a recording, in SI
    estimates = hillobs.estimate("arm.sto", "arm.toml")          # of joints and any number of muscles
    follower = hillobs.follow("pair.toml", "high_gain")          # sample by sample, as they come
    hillobs.export_fmu("high_gain", 0.005, "fmu")               # for other programs; `export_c` for boards
    hillobs.observability(place={"x3": 1.99}).verdict            # can these sensors see this state?

Results are xarray.Datasets. Your own observer is a `Block`; `conformance(block)` says what is wrong with one.
What is not listed here is private and may change.
"""

from __future__ import annotations

import importlib

TYPE_CHECKING = False  # `typing` takes longer to import than all of this
if TYPE_CHECKING:
    from .codegen.cache import BuildError, CacheWarning
    from .model.block import Block, BlockError, Parameter, Symbols, symbols
    from .model.curves import CURVES
    from .model.errors import Error
    from .model.skeleton.paths import Path, constant_moment_arms, polynomial
    from .model.skeleton.points import Point
    from .model.skeleton.tree import Joint, Link, Tree, TreeError
    from .studies.calibrate.result import Calibration
    from .studies.calibrate.run import calibrate
    from .studies.calibrate.trial import Trial
    from .studies.conformance import conformance
    from .studies.estimate.fit import fit
    from .studies.estimate.run import estimate
    from .studies.estimate.schema import arguments
    from .studies.export.pages import export_page
    from .studies.export.run import export_c, export_fmu, export_plant
    from .studies.files.datasets.netcdf import load
    from .studies.files.errors import ClusterError, RecordingError, ResultError, ScenarioError
    from .studies.files.versions import __version__
    from .studies.laboratory.mechanisms.mechanism import Mechanism
    from .studies.laboratory.mechanisms.reading import read_mechanism
    from .studies.laboratory.muscles import Muscle, MusclePair, read_muscles
    from .studies.laboratory.recording import Recording, read_recording
    from .studies.live.estimate import Estimate
    from .studies.live.follower import Follower
    from .studies.live.run import follow
    from .studies.observability.point import observability
    from .studies.simulate.run import RunWarning, simulate
    from .studies.sweep.axes import Range
    from .studies.sweep.cluster.client import ClusterWarning
    from .studies.sweep.computing import SweepWarning
    from .studies.sweep.run import sweep
    from .studies.tune.run import Tuned, tune
    from .studies.verdict.run import verdict

_NAMES = {
    ".codegen.cache": ("BuildError", "CacheWarning"),
    ".model.block": ("Block", "BlockError", "Parameter", "Symbols", "symbols"),
    ".model.curves": ("CURVES",),
    ".model.errors": ("Error",),
    ".model.skeleton.paths": ("Path", "constant_moment_arms", "polynomial"),
    ".model.skeleton.points": ("Point",),
    ".model.skeleton.tree": ("Joint", "Link", "Tree", "TreeError"),
    ".studies.calibrate.result": ("Calibration",),
    ".studies.calibrate.run": ("calibrate",),
    ".studies.calibrate.trial": ("Trial",),
    ".studies.conformance": ("conformance",),
    ".studies.estimate.fit": ("fit",),
    ".studies.estimate.run": ("estimate",),
    ".studies.estimate.schema": ("arguments",),
    ".studies.export.pages": ("export_page",),
    ".studies.export.run": ("export_c", "export_fmu", "export_plant"),
    ".studies.files.errors": ("ClusterError", "RecordingError", "ResultError", "ScenarioError"),
    ".studies.files.datasets.netcdf": ("load",),
    ".studies.files.versions": ("__version__",),
    ".studies.laboratory.mechanisms.mechanism": ("Mechanism",),
    ".studies.laboratory.mechanisms.reading": ("read_mechanism",),
    ".studies.laboratory.muscles": ("Muscle", "MusclePair", "read_muscles"),
    ".studies.laboratory.recording": ("Recording", "read_recording"),
    ".studies.live.estimate": ("Estimate",),
    ".studies.live.follower": ("Follower",),
    ".studies.live.run": ("follow",),
    ".studies.observability.point": ("observability",),
    ".studies.simulate.run": ("RunWarning", "simulate"),
    ".studies.sweep.axes": ("Range",),
    ".studies.sweep.cluster.client": ("ClusterWarning",),
    ".studies.sweep.computing": ("SweepWarning",),
    ".studies.sweep.run": ("sweep",),
    ".studies.tune.run": ("Tuned", "tune"),
    ".studies.verdict.run": ("verdict",),
}
_PLACES = {name: module for module, names in _NAMES.items() for name in names}


def __getattr__(name: str) -> object:
    """What stands behind a name, imported when it is first used: CasADi and xarray take a second."""
    if name not in _PLACES:
        raise AttributeError(f"module 'hillobs' has no attribute {name!r}; there are {', '.join(__all__)}")
    globals()[name] = getattr(importlib.import_module(_PLACES[name], __name__), name)
    return globals()[name]


def __dir__() -> list[str]:
    """The public names, for completion and help."""
    return sorted(__all__)


__all__ = [
    "CURVES",
    "Block",
    "BlockError",
    "BuildError",
    "CacheWarning",
    "Calibration",
    "ClusterError",
    "ClusterWarning",
    "Error",
    "Estimate",
    "Follower",
    "Joint",
    "Link",
    "Mechanism",
    "Muscle",
    "MusclePair",
    "Parameter",
    "Path",
    "Point",
    "Range",
    "Recording",
    "RecordingError",
    "ResultError",
    "RunWarning",
    "ScenarioError",
    "SweepWarning",
    "Symbols",
    "Tree",
    "TreeError",
    "Trial",
    "Tuned",
    "__version__",
    "arguments",
    "calibrate",
    "conformance",
    "constant_moment_arms",
    "estimate",
    "export_c",
    "export_fmu",
    "export_page",
    "export_plant",
    "fit",
    "follow",
    "load",
    "observability",
    "polynomial",
    "read_mechanism",
    "read_muscles",
    "read_recording",
    "simulate",
    "sweep",
    "symbols",
    "tune",
    "verdict",
]
