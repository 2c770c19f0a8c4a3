"""Exports from Python: an observer, or the plant it observes, as files for other programs."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from ...model.block import Block
from ..laboratory.mechanisms.mechanism import Mechanism
from ..laboratory.muscles import MusclePair
from ..laboratory.subject import Subject
from ..scenarios.layers import Value
from .files import save_c, save_fmus
from .plant import exported_plant
from .prepare import exported

Muscles = str | Path | MusclePair | Mechanism | Subject | None
Changes = Mapping[str, Value] | None


def export_c(
    observer: str | Block,
    period: float,
    out: str | Path,
    scenario: str | Path = "paper-clean",
    muscles: Muscles = None,
    changes: Changes = None,
    corrected: bool = True,
    steps: int | None = None,
    single: bool = False,
) -> list[Path]:
    """Write an observer as C99 into the folder `out`, which is made if need be, and return the paths.

    observer: a registered name, or a Block of your own. period: from sample to sample, in s with `muscles` (a file or
    what was read of one), else in the paper's time. scenario: whose numbers it has without muscles. changes: path →
    value, such as {"high_gain.eps_h": 0.05}. corrected: the layers of the sliding mode observers are corrected.
    steps: of RK4 from sample to sample, by the rule of docs/gains.md if not given. single: numbers are float.
    ScenarioError, BlockError or ResultError says what is wrong, and then nothing is written.

    >>> [path.name for path in hillobs.export_c("high_gain", 0.005, "c", muscles="pair.toml")]
    ['high_gain.h', 'high_gain.c', 'main.c', 'CMakeLists.txt', 'README.md']
    """
    return save_c(exported(observer, period, scenario, muscles, changes, corrected, steps), Path(out), single)


def export_fmu(
    observer: str | Block,
    period: float,
    out: str | Path,
    scenario: str | Path = "paper-clean",
    muscles: Muscles = None,
    changes: Changes = None,
    corrected: bool = True,
    steps: int | None = None,
) -> list[Path]:
    """Write an observer as FMUs for Co-Simulation, of FMI 2.0 and of FMI 3.0, and return their paths.

    The arguments are those of `export_c`. BuildError too if there is no compiler.

    >>> [path.name for path in hillobs.export_fmu("high_gain", 0.005, "fmu")]
    ['high_gain-fmi2.fmu', 'high_gain-fmi3.fmu']
    """
    return save_fmus(exported(observer, period, scenario, muscles, changes, corrected, steps), Path(out))


def export_plant(
    out: str | Path, scenario: str | Path = "paper-clean", changes: Mapping[str, Value] | None = None
) -> list[Path]:
    """Write the plant of a scenario with its controller as FMUs, `plant-fmi2.fmu` and `plant-fmi3.fmu`; their paths.

    out: a folder, which is made if need be. Their outputs are what is true, and what the sensors measure of it without
    noise, in the paper's units. changes: path → value, such as {"plant.m": 1.2}. ScenarioError, ResultError, BuildError
    as with `export_fmu`.

    >>> [path.name for path in hillobs.export_plant("fmu", "paper-clean")]
    ['plant-fmi2.fmu', 'plant-fmi3.fmu']
    """
    return save_fmus(exported_plant(scenario, changes), Path(out))
