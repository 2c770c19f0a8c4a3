"""FMUs as FMPy drives them, in one way for both versions."""

import contextlib
import subprocess
from collections.abc import Iterator, Mapping, Sequence
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave, fmi2CallbackFunctions, fmi2CallbackLoggerTYPE, fmi2ComponentEnvironment
from fmpy.fmi3 import FMU3Slave

from hillobs.codegen.targets import platforms
from hillobs.codegen.toolchain import C_FLAGS, find_compiler
from hillobs.studies.export.files import save_c, save_fmus
from hillobs.studies.export.prepare import exported

VERSIONS = ("fmi2", "fmi3")


@pytest.fixture
def this_machine_only(monkeypatch: pytest.MonkeyPatch) -> None:
    """Where the extra `compiler` is installed, other machines' libraries would take a minute."""
    monkeypatch.setattr(platforms, "zig", lambda: None)


def saved_fmus(folder: Path, observer: str, **asked) -> Path:
    """The FMUs of an observer and its C, in one folder."""
    manifest = exported(observer, asked.pop("period", 0.005), **asked)
    save_fmus(manifest, folder)
    save_c(manifest, folder)
    return folder


def program_like(folder: Path, name: str) -> Path:
    """The program that reads CSV, by the compiler and with the flags of an FMU's library."""
    program = folder / "program"
    sources = [word for source in ("main.c", f"{name}.c") for word in ("-x", "c", source)]
    flags = [flag for flag in C_FLAGS if flag != "-shared"]
    command = [*find_compiler().command, *flags, *sources, "-lm", "-o", str(program)]
    subprocess.run(command, cwd=folder, check=True)
    return program


def samples(n: int) -> np.ndarray:
    """(n × 3) a position and two forces that might be measured."""
    t = np.arange(n)[:, None] * 0.005
    return np.hstack([2.6 + 0.01 * np.sin(2 * t), 0.1 + 0.02 * np.sin(3 * t), 0.1 - 0.02 * np.cos(3 * t)])


class Instance:
    """One instance of an FMU, with numbers by name; `told` is what it has complained of."""

    def __init__(self, path: Path, unpacked: Path) -> None:
        self.description = read_model_description(path)
        self.second = self.description.fmiVersion == "2.0"
        self.references = {v.name: v.valueReference for v in self.description.modelVariables}
        self.told: list[str] = []
        # several instances are of one library
        if not unpacked.exists():
            extract(path, unzipdir=unpacked)
        kind = FMU2Slave if self.second else FMU3Slave
        self.fmu = kind(
            guid=self.description.guid or self.description.instantiationToken,
            unzipDirectory=str(unpacked),
            modelIdentifier=self.description.coSimulation.modelIdentifier,
        )
        if self.second:
            log = fmi2CallbackLoggerTYPE(lambda *told: self.told.append(told[-1].decode()))
            self.callbacks = fmi2CallbackFunctions(logger=log, componentEnvironment=fmi2ComponentEnvironment(None))
            self.fmu.instantiate(callbacks=self.callbacks)
        else:
            self.fmu.instantiate(logMessage=lambda *told: self.told.append(told[-1].decode()))

    def begin(self, start: float = 0.0, **numbers: float) -> None:
        if self.second:
            self.fmu.setupExperiment(startTime=start)
            self.fmu.enterInitializationMode()
        else:
            self.fmu.enterInitializationMode(startTime=start)
        self.set(numbers)
        self.fmu.exitInitializationMode()

    def set(self, numbers: Mapping[str, float]) -> None:
        self.set_references([self.references[name] for name in numbers], list(numbers.values()))

    def set_references(self, references: Sequence[int], values: Sequence[float]) -> None:
        (self.fmu.setReal if self.second else self.fmu.setFloat64)(references, values)

    def get(self, names: Sequence[str]) -> list[float]:
        return self.get_references([self.references[name] for name in names])

    def get_references(self, references: Sequence[int]) -> list[float]:
        return list((self.fmu.getReal if self.second else self.fmu.getFloat64)(references))

    def step(self, start: float, size: float) -> None:
        self.fmu.doStep(currentCommunicationPoint=start, communicationStepSize=size)

    def save(self) -> object:
        return self.fmu.getFMUstate() if self.second else self.fmu.getFMUState()

    def restore(self, state: object) -> None:
        (self.fmu.setFMUstate if self.second else self.fmu.setFMUState)(state)

    def to_bytes(self, state: object) -> bytes:
        return bytes((self.fmu.serializeFMUstate if self.second else self.fmu.serializeFMUState)(state))

    def of_bytes(self, serialized: bytes) -> object:
        return (self.fmu.deSerializeFMUstate if self.second else self.fmu.deserializeFMUState)(serialized)

    def forget(self, state: object) -> None:
        (self.fmu.freeFMUstate if self.second else self.fmu.freeFMUState)(state)

    @property
    def outputs(self) -> list[str]:
        return [v.name for v in self.description.modelVariables if v.causality == "output"]

    def run(self, samples: np.ndarray, step: float, begins: float = 0.0) -> np.ndarray:
        """(n × outputs) after each step, of which each begins with a row of y1, y2, y3."""
        rows = []
        for k, row in enumerate(samples):
            self.set(dict(zip(("y1", "y2", "y3"), row.tolist(), strict=True)))
            self.step(begins + k * step, step)
            rows.append(self.get(self.outputs))
        return np.array(rows)


@contextlib.contextmanager
def instance(folder: Path, name: str, version: str) -> Iterator[Instance]:
    """An instance of an FMU, unpacked beside it; it is freed, and its library closed."""
    made = Instance(folder / f"{name}-{version}.fmu", folder / f"{name}-{version}")
    try:
        yield made
    finally:
        made.fmu.freeInstance()
