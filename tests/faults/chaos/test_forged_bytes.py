"""Bytes of results as someone might forge them, sealed again: each is read or refused, in time and within memory."""

import json
import os
import resource
import signal
from collections.abc import Iterator
from pathlib import Path
from random import Random
from typing import Any

import pytest

from forgeries import opened, with_table
from hillobs import Error, load
from hillobs.studies.estimate.schema import check_estimates
from hillobs.studies.simulate.schema import check_run
from hillobs.studies.sweep.schema import check_sweep
from hostile.results import result

pytestmark = pytest.mark.chaos

FORGED = int(os.environ.get("FORGED", "800"))
# seconds and bytes, a thousand times what a good result takes
LONGEST, LARGEST = 20, 2_000_000_000
CHECKS = {"run": check_run, "sweep": check_sweep, "estimates": check_estimates}
NONSENSE = (
    *(-1, 0, 1, 7, 2**31, 2**63, 2**64, 10**30, 1.5, float("nan"), True, None, "", "x", "text", "<f8", "\ud800", "\0"),
    *([], {}, [[]], [0], [0, 8, 0], [0, 10**9, 1], [10**9] * 40, "00" * 500, {"x": 1}, "\x1b[31m", "ff" * 8),
)


@pytest.fixture
def bounded() -> Iterator[None]:
    """A process that may not grow by much."""
    pages = int(Path("/proc/self/statm").read_text().split()[0])
    soft, hard = resource.getrlimit(resource.RLIMIT_AS)
    resource.setrlimit(resource.RLIMIT_AS, (pages * resource.getpagesize() + LARGEST, hard))
    yield
    resource.setrlimit(resource.RLIMIT_AS, (soft, hard))


@pytest.mark.parametrize("where", ["anywhere", "in the table", "in what the table says"])
@pytest.mark.parametrize("kind", CHECKS)
@pytest.mark.usefixtures("bounded")
def test_forged_bytes_are_read_or_refused(kind: str, where: str, tmp_path: Path, record_property) -> None:
    dice, path = Random(f"{kind} {where}"), tmp_path / "x.nc"
    netcdf, table = opened(result(kind))
    sentences = []
    path.write_bytes(with_table(netcdf, table))
    CHECKS[kind](load(path))
    for _ in range(FORGED):
        if where == "anywhere":
            forged = with_table(_damaged(netcdf, dice), table)
        elif where == "in the table":
            forged = with_table(netcdf, _damaged(table, dice))
        else:
            forged = with_table(netcdf, json.dumps(_changed(json.loads(table), dice)).encode())
        path.write_bytes(forged)
        # nothing handles the alarm: it ends a loop in C too
        signal.setitimer(signal.ITIMER_REAL, LONGEST)
        try:
            CHECKS[kind](load(path))
        except Error as error:
            sentences.append(str(error))
        finally:
            signal.setitimer(signal.ITIMER_REAL, 0)
    assert all(sentence.isprintable() for sentence in sentences)
    assert sentences
    record_property("faults", FORGED)


def _damaged(raw: bytes, dice: Random) -> bytes:
    """Some places of a file with other bytes, or with those of another place, or the file cut."""
    if dice.random() < 0.1:
        return raw[: dice.randrange(len(raw))]
    damaged = bytearray(raw)
    for _ in range(dice.choice((1, 1, 1, 2, 5, 20))):
        place, other, size = dice.randrange(len(raw)), dice.randrange(len(raw)), dice.choice((1, 2, 4, 8, 60, 500))
        match dice.randrange(5):
            case 0:
                damaged[place] ^= 1 << dice.randrange(8)
            case 1:
                damaged[place : place + size] = bytes(size)
            case 2:
                damaged[place : place + size] = b"\xff" * size
            case 3:
                damaged[place : place + size] = dice.randbytes(size)
            case 4:
                damaged[place : place + size] = raw[other : other + size]
    return bytes(damaged)


def _changed(table: Any, dice: Random) -> Any:
    """A table with one to three of its values replaced, gone, or another one of it."""
    for _ in range(dice.choice((1, 1, 2, 3))):
        holder, key = dice.choice(list(_places(table)))
        match dice.randrange(4):
            case 0:
                del holder[key]
            case 1:
                other, place = dice.choice(list(_places(table)))
                holder[key] = json.loads(json.dumps(other[place]))
            case _:
                holder[key] = dice.choice(NONSENSE)
    return table


def _places(value: Any) -> Iterator[tuple[Any, Any]]:
    """Each container within `value`, with each of its keys or indices."""
    for key in list(value) if isinstance(value, dict) else range(len(value)) if isinstance(value, list) else ():
        yield value, key
        yield from _places(value[key])
