"""`hillobs sweep` in the hands of a hostile user: every mistake is one sentence and exit code 2, and leaves no file."""

from pathlib import Path

import pytest

from forks import TINY
from hillobs.studies.files.datasets.netcdf import LARGEST_RESULT
from hillobs.studies.sweep import plan

NUMBER = "must be a number, not"
WHOLE = "must be a whole number of at least"
COUNT = "the number of values must be a whole number from 1 to 1,000,000, not"
DESIGN = "--design must be latin:N or sobol:N, not"
NO_FILE = "is no name for a result: it must be that of a file"
EPS = "--over high_gain.eps_h="

MISTAKES = {
    "--over high_gain.eps_h": "'high_gain.eps_h' is not PATH=VALUES, such as",
    "--over =0.1": "'=0.1' is not PATH=VALUES",
    EPS: "is not PATH=VALUES",
    f"{EPS}0.1,": f"{NUMBER} ''",
    f"{EPS}0.1;0.2": f"{NUMBER} '0.1;0.2'",
    f"{EPS}nan": f"{NUMBER} 'nan'",
    f"{EPS}1_0": f"{NUMBER} '1_0'",
    f"{EPS}٠.١": f"{NUMBER} '٠.١'",
    f"{EPS}[/x]": f"{NUMBER} '[/x]'",
    f"{EPS}1e400": "must be a finite number, not inf",
    f"{EPS}0.1,0.1": "has a value twice",
    f"{EPS}0.1,0.10000000000000001": "has a value twice",
    f"{EPS}lin:0.1:0.2": "only a design can do without",
    f"{EPS}lin:0.1:0.2:0": f"{COUNT} '0'",
    f"{EPS}lin:0.1:0.2:1e3": f"{COUNT} '1e3'",
    f"{EPS}lin:0.1:0.2:1_0": f"{COUNT} '1_0'",
    f"{EPS}lin:0.1:0.2:²": f"{COUNT} '²'",
    f"{EPS}lin:0.1:0.2:{'9' * 5000}": COUNT,
    f"{EPS}log:0:1:3": "needs ends above 0, not 0 and 1",
    f"{EPS}lin:1:0.1:3": "the range from 1 to 0.1 is empty",
    f"{EPS}lin:0.1:1e400:3": "high_gain.eps_h must be a finite number, not inf",
    "--over high_gain.h11=lin:-1e308:1e308:3": "is beyond all numbers",
    f"{EPS}LIN:0.1:0.2:3": "a range is lin:LOW:HIGH:COUNT or log:LOW:HIGH:COUNT",
    "--over \x1b[31m=1": r"unknown path '\x1b[31m'",
    "--over high_gain.eps_h\n=1": r"unknown path 'high_gain.eps_h\n'",
    f"--over {'x' * 10_000}=1": "unknown path 'xxx",
    "--over seed=1,2": "seed cannot be swept; use seeds",
    "--set seed=5": "a sweep has seeds of its own",
    "--over record=0.01,0.02": "record cannot be swept",
    f"{EPS}0.1 {EPS}0.2": "a path is given to --over twice",
    "--over muscle.k=19,20 --over muscle1.k=18 --over muscle2.k=18": "muscle.k changes nothing here",
    "--over activation1.offset=0.1,0.2": "activation1.offset changes nothing here",
    "--over duration=0.05,1e9": "at duration = 1e+09: duration = 1e+09 at step = 0.0005 is more than",
    "--over step=1e-20,1e-3": "at step = 1e-20",
    "--over muscle.k=lin:1:20:1000 --over muscle.toe=lin:0.01:0.04:1000": "are too many",
    "--seeds 0": f"--seeds {WHOLE} 1, not '0'",
    "--seeds -1": f"--seeds {WHOLE} 1, not '-1'",
    "--seeds 1e3": f"--seeds {WHOLE} 1, not '1e3'",
    "--seeds 1_0": f"--seeds {WHOLE} 1, not '1_0'",
    "--seeds ٣": f"--seeds {WHOLE} 1, not '٣'",
    "--seeds 999999999999": "seeds must be a whole number from 1 to 100,000,000, not 999999999999",
    f"--design latin:0 {EPS}lin:0.1:0.2": "a design has 1 to 1,000,000 samples, not 0",
    f"--design latin {EPS}lin:0.1:0.2": f"{DESIGN} 'latin'",
    f"--design grid:3 {EPS}0.1": f"{DESIGN} 'grid:3'",
    f"--design latin:4:4 {EPS}lin:0.1:0.2": f"--design {WHOLE} 0, not '4:4'",
    f"--design sobol:3 {EPS}lin:0.1:0.2": "balanced for powers of two only, not for 3 samples",
    f"--design latin:4 {EPS}0.1,0.2": "a design needs a range",
    f"--design latin:4 {EPS}lin:0.1:0.2:7": "leave out the range's 7",
    "--design latin:4": "a design needs at least one range to sample",
    f"--design latin:4 --zip {EPS}lin:0.1:0.2": "--zip and --design exclude each other",
    f"--zip {EPS}0.1,0.2 --over plant.m=1": "equally many values: high_gain.eps_h 2, plant.m 1",
    "--out .": f"'.' {NO_FILE}",
    "--out /": f"'/' {NO_FILE}",
    "--out ..": f"'..' {NO_FILE}",
    "--out /dev/null": "/dev/null cannot be read: it is no regular file",
    "--out /dev/null/x.nc": "/dev/null cannot be written to: it is not a folder",
    f"--out {'x' * 252}.nc": "cannot be written to: File name too long",
    "--workers 0": f"--workers {WHOLE} 1, not '0'",
    "--target nonsense": "Unknown target 'nonsense'; there are native",
    "--observer [/x]": "unknown observer '[/x]'; there are high_gain",
    "--quantity x9": "unknown quantity 'x9'; there are x1",
    "--measure x9": "unknown measure 'x9'; there are rmse",
}


@pytest.mark.parametrize("words", MISTAKES, ids=lambda words: repr(words[:60]))
def test_a_mistake_is_one_sentence_and_leaves_nothing(words: str, command, tmp_path: Path) -> None:
    code, out, err = command("sweep", "paper-noisy", *TINY, *words.split(" "))
    assert (code, out) == (2, "")
    assert err.startswith("hillobs: ")
    assert MISTAKES[words] in err
    assert err.endswith("\n")
    assert err[:-1].isprintable()
    assert len(err) < 600
    assert not list(tmp_path.rglob("*.part*"))
    assert not list(tmp_path.glob("*.nc"))


NAMES = ["x\ny.nc", "x].nc", "-x.nc", "\x1b[31mred.nc", "é.nc", "x", "lock", "$(touch z).nc", "x y"]


@pytest.mark.parametrize("name", NAMES, ids=repr)
def test_a_result_may_have_any_name_that_a_file_may_have(name: str, command, tmp_path: Path) -> None:
    given = ["sweep", "paper-noisy", *TINY, f"--out={name}", "--no-figures"]
    code, out, err = command(*given)
    assert (code, err) == (0, "")
    assert "".join(out.split("\n")).isprintable()
    assert [path.name for path in tmp_path.iterdir()] == [name]
    assert command(*given)[0] == 0


def test_an_observer_named_twice_is_there_once(command) -> None:
    code, out, _ = command("sweep", "paper-noisy", *TINY, "--observer", "high_gain")
    assert code == 0
    assert sum(line.startswith("HGO") for line in out.splitlines()) == 1


def test_what_is_no_result_is_not_overwritten(command, tmp_path: Path) -> None:
    (tmp_path / "mine.nc").write_text("mine")
    code, _, err = command("sweep", "paper-noisy", *TINY, "--out", "mine.nc")
    assert (code, err) == (2, "hillobs: mine.nc cannot be read: it is no result of hillobs, or it is damaged\n")
    assert (tmp_path / "mine.nc").read_text() == "mine"


def test_more_runs_than_can_be_meant_are_asked_for_twice(command) -> None:
    many = ["--over", "plant.m=lin:1:1.2:20000", "--over", "high_gain.h11=lin:3:4:20000"]
    code, _, err = command("sweep", "paper-noisy", *TINY, *many)
    assert (code, err) == (2, "hillobs: 400,000,000 runs are more than 100,000,000; say --yes if they are meant\n")
    code, _, err = command("sweep", "paper-noisy", *TINY, *many, "--yes")
    assert (code, err) == (2, "hillobs: 400,000,000 runs make a result of 21 GB; cut the sweep into several\n")


def test_a_very_large_sweep_is_run_if_it_is_meant(command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(plan, "MANY_RUNS", 1)
    assert command("sweep", "paper-noisy", *TINY, "--seeds", "2", "--yes")[0] == 0
    monkeypatch.undo()
    # such a result fits into a file
    few = {"observers": "high_gain", "quantities": ["x2"], "measures": ["rmse"]}
    assert (plan.MANY_RUNS + 1) * plan.plan("paper-noisy", {}, 1, **few).row.itemsize < LARGEST_RESULT
