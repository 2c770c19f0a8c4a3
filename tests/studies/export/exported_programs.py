"""Exports compiled as a user would, and the follower of `estimate` beside them."""

import shutil
import subprocess
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from hillobs.codegen.recordings.filters import CompiledBank
from hillobs.codegen.toolchain import SINGLE
from hillobs.model.block import Block
from hillobs.observers import OBSERVERS
from hillobs.studies.estimate.follow import compiled_bank, follower_bank, measured_tendons
from hillobs.studies.estimate.start import at_rest
from hillobs.studies.export.files import save_c
from hillobs.studies.export.prepare import exported
from hillobs.studies.scenarios.paths import paths_of
from hillobs.studies.scenarios.prepare import Prepared, prepare
from hillobs.studies.simulate.run import simulate

CC = shutil.which("cc")
needs_cc = pytest.mark.skipif(CC is None, reason="there is no C compiler called cc")
STRICT = ["-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Wdouble-promotion", "-Wvla", "-Werror"]
PERIOD = 0.005
# another order of operations rounds otherwise, 2e-16 each, which the slopes of the estimates, up to 10³, make larger;
# Δ̂ is a second difference of positions while a filter knows little: 4e-16/PERIOD² is 2e-11
DOUBLE, DOUBLE_DELTA = 1e-12, 1e-11
# the same of float's 1.2e-7, with what averages out over a chain's memory of some ten samples
FLOAT = {"a1_hat": 1e-4, "a2_hat": 1e-4, "Delta_hat": 1e-3}


def assert_same(theirs: Mapping[str, np.ndarray], ours: Mapping[str, np.ndarray], single: bool) -> None:
    assert [*theirs] == [*ours]
    doubles = {**dict.fromkeys(ours, DOUBLE), "Delta_hat": DOUBLE_DELTA}
    for name, tolerance in (FLOAT if single else doubles).items():
        # where g⁻¹ is steepest a float is off by more, in one sample of thousands
        usual = np.quantile(np.abs(theirs[name] - ours[name]), 0.999) if single else 0.0
        assert usual <= tolerance, name
        np.testing.assert_allclose(theirs[name], ours[name], rtol=0, atol=tolerance * (1 + single), err_msg=name)


def built(folder: Path, name: str, *flags: str) -> Path:
    """The program of an export. A warning is an error."""
    program = folder / "program"
    command = [str(CC), *STRICT, *(flags or ["-O0"]), "main.c", f"{name}.c", "-lm", "-o", str(program)]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    assert done.returncode == 0, done.stderr
    assert done.stderr == ""
    return program


def answered(program: Path, columns: str, rows: np.ndarray) -> subprocess.CompletedProcess[str]:
    text = "\n".join([columns, *(",".join(map(repr, row)) for row in rows.tolist())]) + "\n"
    return subprocess.run([program], input=text, capture_output=True, text=True, check=False)


def estimates(program: Path, columns: str, rows: np.ndarray) -> dict[str, np.ndarray]:
    """The columns that a program writes, by name. It complains of nothing."""
    done = answered(program, columns, rows)
    assert (done.returncode, done.stderr) == (0, "")
    names, *lines = done.stdout.splitlines()
    table = np.array([[float(cell) for cell in line.split(",")] for line in lines])
    columns = dict(zip(names.split(","), table.T, strict=True))
    assert set(columns.pop("status")) <= {0, 2}
    return columns


def recorded(scenario: str, changes: Mapping[str, float | str] | None = None) -> np.ndarray:
    """(n × 3) what the sensors of a scenario measure, a row each period."""
    return simulate(scenario, changes={"record": PERIOD, **(changes or {})}).y.values


def compiled(scenario: str, changes: Mapping[str, str], corrected: bool, target: str = SINGLE) -> CompiledBank:
    system = prepare(scenario, "high_gain", changes).system
    every = tuple(replace(observer, fitted=False) for observer in OBSERVERS.values())
    bank = follower_bank(system, corrected, every)
    return compiled_bank(bank) if target == SINGLE else CompiledBank(bank, target)


def followed(
    bank: CompiledBank, observer: str, scenario: str, changes: Mapping[str, str], y: np.ndarray, substeps: int
) -> dict[str, np.ndarray]:
    """What the follower of `estimate` makes of the same samples with the same numbers."""
    prepared = prepare(scenario, observer, changes)
    (block,) = (block for block in bank.bank.observers if block.name == observer)
    lengths, _ = measured_tendons(bank, numbers(prepared, bank.bank.observers[0], {}), y[:1])
    start = at_rest(prepared.system, [*y[0, :1], *lengths[0]])
    period = OBSERVERS[observer].period
    given = {**start, **({f"{observer}.{period}": PERIOD} if period else {})}
    filter_ = bank.follow(observer, numbers(prepared, block, given), max(substeps, 1))
    result = filter_.samples(np.arange(len(y)) * PERIOD, y)
    assert filter_.failure is None
    table = np.hstack([result.y, result.guards])
    return dict(zip((*block.y, *block.guards), table.T, strict=True))


def numbers(prepared: Prepared, block: Block, given: Mapping[str, float]) -> np.ndarray:
    return np.array(paths_of([block]).values(block, {**prepared.scenario.given, **given}))


def saved(folder: Path, observer: str | Block, *, single: bool = False, **asked) -> int:
    """An export in a folder; how many steps it makes from sample to sample."""
    manifest = exported(observer, asked.pop("period", PERIOD), **asked)
    save_c(manifest, folder, single)
    return manifest.substeps
