"""`--observer FILE.py:NAME`: a user's own observer in every study; no file but that one is ever run."""

import itertools
import json
from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest

import hillobs
from command_line import CHANGED, SHORT
from hillobs.model.curves import DEGROOTE_FREGLY2016
from hillobs.model.system import pair_system
from hillobs.observers import OBSERVERS
from hillobs.studies.cli.shell.own_observers import loaded
from hillobs.studies.estimate.follow import fitted_blocks, follower_bank
from hillobs.studies.scenarios.prepare import prepare
from hillobs.studies.sweep.cluster.plan_text import plan_of, text_of
from hillobs.studies.sweep.plan import plan
from written_files import inputs

Command = Callable[..., tuple[int, str, str]]

# a smoother in continuous time, and one that moves at samples; each start of the file leaves a mark
FILE = """
from __future__ import annotations
from dataclasses import dataclass
from hillobs import Block, Parameter, Symbols, symbols

with open("ran.txt", "a") as marks:
    marks.write("x")

@dataclass
class Names:
    all: str = "x1_hat x2_hat Delta_hat x3_hat u1_hat x4_hat u2_hat"

x, u = symbols(Names().all), symbols("y1 L_S1 L_S2")
about = {"rate": Parameter(5.0, "of all", "a test", above=0)}
p = symbols(about)
seen = dict(x1_hat=u.y1, x3_hat=u.L_S1, x4_hat=u.L_S2)
dx = Symbols({name: p.rate * (seen.get(name, 0) - state) for name, state in x.items()})
smooth = Block("smooth", x=x, u=u, p=p, parameters=about, dx=dx, x0=seen, y=x)
wide = Block("wide", u=symbols("y4"), y=Symbols(dict.fromkeys(x, 1.0)))
few = Block("few", y=Symbols(x1_hat=1.0))
high_gain = Block("high_gain", y=Symbols(dict.fromkeys(x, 1.0)))
again = Block("smooth", y=Symbols(dict.fromkeys(x, 1.0)))

def halving():
    "Goes half the way to what is measured, at each sample."
    x, u = symbols(Names().all), symbols("y1 L_S1 L_S2")
    to = dict(x1_hat=u.y1, x3_hat=u.L_S1, x4_hat=u.L_S2)
    next = Symbols({name: (state + to.get(name, 0)) / 2 for name, state in x.items()})
    return Block("halving", x=x, u=u, next=next, x0=to, y=x)

def counting():
    x, n = symbols(Names().all), symbols("n")
    still = dict.fromkeys(x, 0.0)
    return Block("counting", x={**x, **n}, dx=still, per_step={"n": n.n + 1}, y=x)

def failing():
    return 1 / 0

number = 3
"""
BOTH = ["--observer", "own.py:smooth", "--observer", "own.py:halving"]
ESTIMATE = ["estimate", "short.csv", "--muscles", "pair.toml"]


@pytest.fixture
def own(command: Command, tmp_path: Path) -> Command:
    """The command line in a folder with the file, a scenario, a recording and its muscles."""
    (tmp_path / "own.py").write_text(FILE)
    inputs(tmp_path)
    return command


def halved(measured: np.ndarray) -> np.ndarray:
    steps = itertools.accumulate(measured[1:].tolist(), lambda x, y: (x + y) / 2, initial=measured[0])
    return np.array(list(steps))


def runs() -> int:
    return len(Path("ran.txt").read_text()) if Path("ran.txt").exists() else 0


def test_an_own_observer_runs_in_every_study_and_only_when_it_is_named(own: Command, tmp_path: Path) -> None:
    scenario = ["paper-noisy", *SHORT, *BOTH]
    assert own("simulate", *scenario, "--set", "record=0.005", "--no-figures")[::2] == (0, "")
    swept = ["--over", "smooth.rate=1,5", "--workers", "2", "--out", "sweep.nc", "--no-figures"]
    assert own("sweep", *scenario, *swept)[::2] == (0, "")
    assert own(*ESTIMATE, *BOTH, "--set", "smooth.rate=8", "--no-figures")[::2] == (0, "")
    assert runs() == 3
    (result,) = Path("results").glob("*.nc")
    assert result.name == f"paper-noisy{CHANGED},record=0.005,smooth,halving.nc"
    run, swept, found = map(hillobs.load, (result, "sweep.nc", "estimates/estimates.nc"))
    # what is measured is the same at each sample but the last, when no sample is taken any more
    np.testing.assert_allclose(
        run.x_hat.sel(observer="halving", state="x1"), halved(run.y.sel(sensor="y1").values), rtol=1e-12
    )
    np.testing.assert_allclose(found.position_hat.sel(observer="halving"), halved(found.position.values), rtol=1e-12)
    # a low pass with the rate 8 follows a slow motion with a lag of 1/8
    assert abs(found.position_innovation.sel(observer="smooth")).max() < 0.002
    assert json.loads(found.attrs["settings"])["changes"] == {"smooth.rate": 8.0}
    assert swept.observer.values.tolist() == run.observer.values.tolist() == ["smooth", "halving"]
    assert swept.rmse.notnull().all()
    assert not list(tmp_path.rglob("__pycache__"))

    # nothing that was written, and nothing that is read, names code
    assert "own.py" not in "".join(map(str, (run.attrs, swept.attrs, found.attrs)))
    assert own("figures", "sweep.nc", "--out", "drawn")[::2] == (0, "")
    with pytest.raises(hillobs.ScenarioError, match=r"unknown observer 'smooth'; there are .* given as its Block"):
        hillobs.estimate("short.csv", **hillobs.arguments(found))
    forged = found.assign_coords(observer=["own.py:smooth", "own.py:halving"])
    with pytest.raises(hillobs.ResultError, match="its observer must be different names, not"):
        hillobs.arguments(forged)
    with pytest.raises(hillobs.ScenarioError, match=r"unknown observer 'own\.py:smooth'; there are"):
        hillobs.estimate("short.csv", "pair.toml", "own.py:smooth")
    for name, text in {"s.toml": 'observer = "own.py:smooth"', "m.toml": '[muscle1]\ncurves = "own.py:smooth"'}.items():
        Path(name).write_text(text)
    assert own("simulate", "s.toml")[0] == own("estimate", "short.csv", "--muscles", "m.toml")[0] == 2
    assert own("simulate", *BOTH, "--help")[0] == 0
    assert runs() == 3
    block = loaded(["own.py:smooth"])
    again = hillobs.estimate("short.csv", **{**hillobs.arguments(found), "observers": [*block, *loaded(BOTH[3:])]})
    assert again.identical(found)


@pytest.mark.parametrize(
    ("given", "sentence"),
    [
        ("nowhere.py:x", "nowhere.py: cannot be read: No such file or directory"),
        ("folder.py:x", "folder.py: cannot be read: Is a directory"),
        ("own.py:nothing", "own.py has nothing called nothing; its Blocks are smooth, wide, few, high_gain, again"),
        ("own.py:number", "number in own.py is no Block and no function that returns one; its Blocks are smooth, "),
        ("own.py:Names", "Names in own.py is no Block and no function that returns one"),
        ("own.py:failing", "own.py, line 37: ZeroDivisionError: division by zero"),
        ("own.py", "'own.py' names no observer; an observer of your own is FILE.py:NAME, the name of a Block in"),
        ("own.py:", "'own.py:' names no observer; an observer of your own is FILE.py:NAME"),
        ("own.txt:x", "'own.txt:x' names no observer; an observer of your own is FILE.py:NAME"),
        ("syntax.py:x", "syntax.py, line 2: SyntaxError: invalid syntax"),
        ("absent.py:x", "absent.py, line 1: ModuleNotFoundError: No module named 'nothing_like_it'"),
        ("raises.py:x", r"raises.py, line 1: ValueError: two\nlines \x1b[31m"),
        ("exits.py:x", "exits.py, line 1: SystemExit: 0"),
        ("interrupts.py:x", "interrupts.py, line 2: KeyboardInterrupt"),
        ("base.py:x", "base.py, line 1: GeneratorExit: no"),
        ("deep.py:x", "deep.py, line 1: RecursionError: maximum recursion depth exceeded"),
        ("bytes.py:x", "bytes.py, line 1: SyntaxError: (unicode error) 'utf-8' codec can't decode byte 0xff"),
    ],
)
def test_a_file_without_such_a_block_is_a_sentence(given: str, sentence: str, own: Command, tmp_path: Path) -> None:
    (tmp_path / "folder.py").mkdir()
    for name, text in {
        "syntax.py": b"x = 1\ny = = 2\n",
        "absent.py": b"import nothing_like_it\n",
        "raises.py": b'raise ValueError("two\\nlines \\x1b[31m")\n',
        "exits.py": b"raise SystemExit(0)\n",
        "interrupts.py": b"import time\nraise KeyboardInterrupt\n",
        "base.py": b"raise GeneratorExit('no')\n",
        "deep.py": b"def f(): f()\nf()\n",
        "bytes.py": b"x = '\xff'\n",
    }.items():
        (tmp_path / name).write_bytes(text)
    code, out, err = own("simulate", "--observer", given, "--no-figures")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith(f"hillobs: {sentence}")


@pytest.mark.parametrize("study", [["simulate"], ["sweep"], ESTIMATE], ids=lambda words: words[0])
@pytest.mark.parametrize(
    ("names", "sentence"),
    [
        (["wide"], "wide: an observer sees t, y1, y2, y3, L_S1, L_S2, slope1, slope2 only, not y4"),
        (["few"], "few: an observer must estimate x2_hat, x3_hat, x4_hat, Delta_hat, u1_hat, u2_hat as well"),
        (["high_gain"], "the name 'high_gain' is taken; give your observer another one"),
        (["smooth", "again"], "two observers are called 'smooth'; give one another name"),
    ],
    ids=lambda value: "+".join(value) if isinstance(value, list) else "",
)
def test_a_block_that_is_no_observer_is_the_same_sentence_in_every_study(
    study: list[str], names: list[str], sentence: str, own: Command
) -> None:
    code, out, err = own(*study, *(word for name in names for word in ("--observer", f"own.py:{name}")))
    assert (code, out, err) == (2, "", f"hillobs: {sentence}\n")


def test_what_only_some_studies_can_do_is_a_sentence(own: Command) -> None:
    code, _, err = own(*ESTIMATE, "--observer", "own.py:counting")
    assert (code, err) == (2, "hillobs: counting moves at the points of a time grid, and a recording has none\n")
    planned = plan("paper-noisy", {}, 1, loaded(["own.py:smooth"]))
    with pytest.raises(hillobs.ScenarioError, match="smooth is a Block of this process, which no text can send; sweep"):
        text_of(planned)


@pytest.mark.parametrize("corrected", [False, True])
def test_scenarios_and_recordings_have_the_same_observers_with_the_same_option(corrected: bool) -> None:
    prepared = prepare("paper-noisy", list(OBSERVERS), {}, corrected=corrected)
    of_recordings = (pair_system(DEGROOTE_FREGLY2016), corrected, tuple(OBSERVERS.values()))
    blocks = prepared.loop.observers, [*follower_bank(*of_recordings).observers, *fitted_blocks(*of_recordings)]
    simulated, followed = ({b.name: list(b.x) for b in observers} for observers in blocks)
    assert {name: simulated[name] for name in OBSERVERS} == {name: followed[name] for name in OBSERVERS}
    assert ("sliding_mode.tau_c" in prepared.paths.parameters) == corrected
    assert prepared.label.endswith(",corrected") == corrected
    # a worker of a cluster makes the same
    planned = plan("paper-noisy", {}, 1, ["sliding_mode"], corrected=corrected)
    (there,) = (b for b in plan_of(text_of(planned)).prepared.loop.observers if b.name == "sliding_mode")
    assert list(there.x) == simulated["sliding_mode"]
