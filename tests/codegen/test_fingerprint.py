"""A loop is known by its expressions: the C that the cache has under them is the C that an export would give."""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import casadi as ca
import pytest

from hillobs.codegen import fingerprint as module
from hillobs.codegen import own_code
from hillobs.codegen.fingerprint import exported, fingerprint
from hillobs.codegen.loop import Loop, export_loop
from hillobs.model.block import EXPRESSIONS, STEP, Block, Parameter, Symbols
from hillobs.model.curves import DEGROOTE_FREGLY2016, NGUYEN2019
from hillobs.observers import OBSERVERS, Observer
from hillobs.studies.scenarios.loops import paper_loop

OWN = (OBSERVERS["high_gain"],)


def fresh(observers: tuple[Observer, ...] = OWN, **given: object) -> Loop:
    """A small loop, of symbols that no other one has."""
    return paper_loop.__wrapped__("given", given.pop("curves", NGUYEN2019), observers, **given)


def with_observer(change: Callable[[Block], Block]) -> Loop:
    loop = fresh()
    return replace(loop, bank=replace(loop.bank, observers=(loop.observers[0], change(loop.observers[1]))))


def added(group: str) -> Loop:
    """The loop with 1 added to the last entry of a group of expressions."""

    def change(block: Block) -> Block:
        entries = getattr(block, group)
        *rest, (name, last) = entries.items()
        return replace(block, **{group: Symbols([*rest, (name, last + 1)])})

    if group in ("next", "per_step"):
        loop = fresh()
        return replace(loop, score=change(loop.score))
    if group == "domain":
        loop = fresh()
        return replace(loop, truth=change(loop.truth))
    return with_observer(change)


def key(loop: Loop) -> str:
    return fingerprint(loop, "code")


def renamed_state(block: Block) -> Block:
    def renamed(entries: Symbols) -> Symbols:
        return Symbols({name if name != "x2_hat" else "z": value for name, value in entries.items()})

    return replace(block, **{group: renamed(getattr(block, group)) for group in ("x", "dx", "x0", "limits")})


def reversed_inputs(block: Block) -> Block:
    return replace(block, u=Symbols(reversed(block.u.items())))


OTHERS: dict[str, Callable[[], Loop]] = {
    **{group: lambda group=group: added(group) for group in ("x0", "limits", *EXPRESSIONS)},
    "curves": lambda: fresh(curves=DEGROOTE_FREGLY2016),
    "layers": lambda: fresh((OBSERVERS["sliding_mode"],), corrected=True),
    "one more observer": lambda: fresh((*OWN, OBSERVERS["high_gain_3"])),
    "measures": lambda: fresh(measures=("rmse",)),
    "a name": lambda: with_observer(lambda block: replace(block, name="mine")),
    "a state's name": lambda: with_observer(renamed_state),
    "the order of inputs": lambda: with_observer(reversed_inputs),
    "a held input": lambda: with_observer(lambda block: replace(block, held=frozenset(["y1"]))),
    "a step in a limit": lambda: with_observer(
        lambda block: replace(block, limits=Symbols({**block.limits, "x1_hat": 2 / STEP}))
    ),
    "no quick front": lambda: replace(loop := fresh(), bank=replace(loop.bank, near=None)),
    "noise": lambda: replace(loop := fresh(), noise=tuple(reversed(loop.noise))),
    "numbers in the code": lambda: with_numbers(fresh()),
}


def with_numbers(loop: Loop) -> Loop:
    return loop.with_numbers({block.name: dict.fromkeys(list(block.p)[:1], 1.0) for block in loop.blocks})


def test_the_same_equations_have_the_same_fingerprint() -> None:
    assert key(fresh()) == key(fresh())


def test_a_default_is_no_part_of_the_code() -> None:
    """Loops that differ in usual numbers alone have one library."""

    def of(number: Parameter) -> Parameter:
        return replace(number, default=1.01 * number.default)

    other = with_observer(lambda block: replace(block, parameters={n: of(p) for n, p in block.parameters.items()}))
    assert key(other) == key(fresh())
    assert export_loop(other) == export_loop(fresh())


@pytest.mark.parametrize("other", OTHERS.values(), ids=OTHERS)
def test_another_loop_has_another_fingerprint(other: Callable[[], Loop]) -> None:
    assert key(other()) != key(fresh())


def test_the_code_that_exports_counts() -> None:
    loop = fresh()
    assert fingerprint(loop, "code") != fingerprint(loop, "other code")


def test_how_casadi_writes_counts() -> None:
    loop = fresh()
    before = key(loop)
    ca.GlobalOptions.setSimplificationOnTheFly(False)
    try:
        assert key(loop) != before
    finally:
        ca.GlobalOptions.setSimplificationOnTheFly(True)


@pytest.fixture
def empty(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> Path:
    """An empty cache, of code that is as old as the process."""
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(module, "own_code", lambda *packages: "code")
    return tmp_path / "cache"


def test_a_loop_is_exported_once(empty: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    first = exported(fresh())
    assert first == export_loop(fresh())
    monkeypatch.setattr(module, "export_loop", lambda loop: pytest.fail("exported again"))
    assert exported(fresh()) == first


def test_another_observer_of_the_same_name_is_exported_anew(empty: Path) -> None:
    exported(fresh())
    other = added("dx")
    assert exported(other) == export_loop(other) != exported(fresh())


@pytest.mark.parametrize("damage", [b"", b"\n", b"{}", b"0" * 64 + b"\n{}"], ids=["empty", "line", "object", "no seal"])
def test_what_is_damaged_is_exported_again(empty: Path, damage: bytes) -> None:
    first = exported(fresh())
    (kept,) = empty.glob("*.kept")
    whole = kept.read_bytes()
    kept.write_bytes(damage)
    assert exported(fresh()) == first
    assert kept.read_bytes() == whole


def test_code_that_changes_while_it_is_imported_keeps_nothing(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """What a process runs may then not be what is on the disk, and its C not that of the code there."""
    monkeypatch.setenv("HILLOBS_CACHE", str(tmp_path / "cache"))
    changed = max(path.stat().st_ctime for path in Path(module.__file__).parents[1].glob("codegen/*.py"))
    own_code.own_code.cache_clear()
    try:
        monkeypatch.setattr(own_code, "_IMPORTED", changed)
        assert own_code.own_code("codegen") == ""
        exported(fresh())
        assert not (tmp_path / "cache").exists()
        own_code.own_code.cache_clear()
        monkeypatch.setattr(own_code, "_IMPORTED", changed + 1000)
        assert own_code.own_code("codegen") != own_code.own_code("codegen", "model") != ""
    finally:
        own_code.own_code.cache_clear()
