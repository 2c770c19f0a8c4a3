"""`hillobs live`: a line of estimates for each line of samples, whatever else comes between; ends well."""

import csv
import io
import json
import math
import os
import signal
import subprocess
import sys
from collections.abc import Callable
from pathlib import Path

import pytest

import hillobs
from hillobs.studies.laboratory.recording import read_recording
from live_samples import rows, stepped
from shipped_recording import HINGE, MUSCLES, SHIPPED, part, write_measured

Run = Callable[..., tuple[int, str, str]]
GAINS = {"high_gain.eps_h": 0.2, "high_gain.eps_L": 0.05}
LIVE = ["live", "--muscles", str(MUSCLES), "--observer", "high_gain"]
GIVEN = [*LIVE, "--period", "5ms", *(word for path, value in GAINS.items() for word in ("--set", f"{path}={value}"))]
HEAD = "time,position,force_1,force_2\n"


@pytest.fixture
def live(command: Run, monkeypatch: pytest.MonkeyPatch) -> Run:
    """The command with a text or bytes on its standard input."""

    def run(given: str | bytes, *arguments: str) -> tuple[int, str, str]:
        content = given.encode() if isinstance(given, str) else given
        monkeypatch.setattr(sys, "stdin", io.TextIOWrapper(io.BytesIO(content)))
        return command(*arguments)

    return run


def table(out: str) -> list[dict[str, str]]:
    return list(csv.DictReader(io.StringIO(out)))


def test_each_line_is_followed_as_the_recording_is_and_a_state_goes_on(live: Run, tmp_path: Path) -> None:
    short = part(read_recording(SHIPPED), slice(0, 200))
    write_measured(short, tmp_path / "short.csv")
    head, *lines = (tmp_path / "short.csv").read_text().splitlines(keepends=True)
    follower = hillobs.follow(MUSCLES, "high_gain", learning=0.5)
    told = [estimate for estimate in stepped(follower, rows(short)) if estimate.position == estimate.position]
    begin = [*LIVE, "--learning", "500ms", "--save-state", "kept"]
    code, out, err = live("".join([head, *lines[:150]]), *begin)
    learnt = ", ".join(f"{path}={value!r}" for path, value in follower.gains.items())
    assert (code, err) == (0, f"hillobs: learning gains in the first 0.5 s\nhillobs: learnt: {learnt}\n")
    code, rest, err = live("".join([head, *lines[150:]]), *LIVE, "--state", "kept")
    assert (code, err) == (0, "")
    written = [*table(out), *table(rest)]
    for column, values in {
        "time [s]": [estimate.time for estimate in told],
        "velocity_hat [m/s]": [estimate.velocity for estimate in told],
        "fibre_velocity_2_hat [m/s]": [estimate.fibre_velocity[2] for estimate in told],
        "activation_1_hat": [estimate.activation[1] for estimate in told],
    }.items():
        assert [float(row[column]) for row in written] == values, column


def test_what_is_no_sample_is_left_out_with_a_word(live: Run) -> None:
    # time and millimetres by a row of units; a hanging cell, a gap, a blank line, a remark, a cut line, zero bytes
    given = b"time,position,force_1,force_2\ns,mm,N,N\n0,310,380,380\n0.005,310,abc,380\n0.01,310.1,380,380\n"
    given += b"0.01,310,380,380\n0.015,,380,380\n\n# words\n0.02,310,380\n\0\0\n\xff\n0.025,310,380,38"
    code, out, err = live(given, *GIVEN)
    follower = hillobs.follow(MUSCLES, "high_gain", period=0.005, gains=GAINS)
    samples = [[0.0, 0.31, 380.0, 380.0], [0.01, 310.1 / 1000, 380.0, 380.0], [0.025, 0.31, 380.0, 38.0]]
    told = stepped(follower, samples)
    assert [float(row["activation_2_hat"]) for row in table(out)] == [estimate.activation[2] for estimate in told]
    assert code == 0
    assert err.splitlines() == [
        "hillobs: left out: row 4, column 'force_1': 'abc' is no number",
        "hillobs: left out: row 6: time must rise from sample to sample: 0.01 s comes after 0.01 s",
        "hillobs: left out: row 10 has 3 cells; the header names 4 columns",
        "hillobs: left out: row 11 holds zero bytes: it is no text",
        "hillobs: left out: row 12 has 1 cell; the header names 4 columns",
    ]


def test_objects_of_json_are_answered_by_objects(live: Run) -> None:
    sample = {"position [mm]": 310, "force_1": 380, "force_2": 380.5}
    lines = [json.dumps(sample), "", "{", "[1]", "1e999", json.dumps({**sample, "force_1": None})]
    lines += [json.dumps({**sample, "force_2": value}) for value in ("x", 10**400, [1], True)]
    code, out, err = live("\n".join([*lines, json.dumps(sample)]), *GIVEN)
    first, last = map(json.loads, out.splitlines())
    assert (code, first["time"], last["time"], first["position_hat"]) == (0, 0.0, 0.01, 0.31)
    assert last.keys() == first.keys() >= {"activation_1_hat", "disturbance_hat"}
    assert [line.removeprefix("hillobs: left out: ") for line in err.splitlines()] == [
        "row 3 is no JSON",
        'row 4 is no object such as {"time": 0.1}, but [1]',
        'row 5 is no object such as {"time": 0.1}, but inf',
        "row 7: force_2 must be a number, not 'x'",
        "row 8: force_2 must be a finite number, not inf",
        "row 9: force_2 must be a number, not [1]",
        "row 10: force_2 must be a number, not true",
    ]


def test_a_stream_of_nonsense_does_not_flood_the_terminal(live: Run) -> None:
    code, out, err = live(HEAD + "nonsense\n" * 500 + "0,0.31,380,380\n", *GIVEN)
    assert (code, len(table(out))) == (0, 1)
    assert len(err.splitlines()) == 22
    assert err.endswith("hillobs: 500 lines were left out\n")


def test_after_a_long_gap_a_word_says_that_observers_begin_anew(live: Run) -> None:
    code, out, err = live(HEAD + "0,0.31,380,380\n0.005,0.31,380,380\n0.3,0.31,380,380\n", *GIVEN)
    assert (code, len(table(out))) == (0, 3)
    assert err == "hillobs: row 4: no sample came for too long to bridge it: the observers begin anew\n"


def test_gains_and_period_are_those_of_estimates(live: Run, command: Run, tmp_path: Path) -> None:
    write_measured(part(read_recording(SHIPPED), slice(0, 100)), tmp_path / "short.csv")
    assert command("estimate", "short.csv", *LIVE[1:], "--no-figures")[0] == 0
    code, out, err = live((tmp_path / "short.csv").read_text(), *LIVE, "--gains", "estimates/estimates.nc")
    assert (code, err) == (0, "")
    known = hillobs.load("estimates/estimates.nc")
    assert [float(row["activation_1_hat"]) for row in table(out)] == known.activation_hat[0, :, 0].values.tolist()


def test_several_observers_of_a_mechanism_stand_side_by_side(live: Run) -> None:
    observers = ["--observer", "high_gain", "--observer", "kalman_constant"]
    begin = ["live", "--mechanism", str(HINGE), *observers, "--learning", "100ms"]
    angles = "".join(f"{i * 0.005},{40 + i / 10},100,{100 + i}\n" for i in range(40))
    code, out, err = live(f"time,angle_elbow [deg],force_TRIlat,force_BRA\n{angles}", *begin)
    first, *_, last = table(out)
    assert code == 0
    assert len(err.splitlines()) == 3
    assert float(first["time [s]"]) == 0.1
    assert math.isclose(float(last["high_gain.angle_elbow_hat [rad]"]), math.radians(43.9), rel_tol=0.01)
    assert last.keys() >= {"kalman_constant.disturbance_elbow_hat [N m]", "kalman_constant.activation_BRA_hat"}


@pytest.mark.parametrize(
    ("given", "arguments", "sentence"),
    [
        ("", GIVEN, "standard input ended before there was a sample"),
        (HEAD, GIVEN, "standard input ended before there was a sample"),
        ("time,position\n0,1\n", GIVEN, "standard input: there is no column force_1; there are 'time', 'position'"),
        ("{}", GIVEN, "standard input: there is no column position; no column has a name"),
        ("1,2,3\n1,2,3\n", GIVEN, "standard input: row 1 holds numbers where the names of the columns should be"),
        (HEAD + "0,0.31,380,380\n", LIVE, "standard input ended while the gains of high_gain were learnt"),
        ("", LIVE[:1], "a recording needs either --muscles FILE.toml, a pair, or --mechanism FILE.toml"),
        ("", [*LIVE, "--set", "sliding_mode.rho=1"], "'sliding_mode.rho' is no gain of high_gain; the muscle file"),
        ("", [*LIVE, "--period", "1h"], "--period must be a time in ms or s, such as 20ms or 0.02s, not '1h'"),
        ("", [*LIVE, "--state", "nothing"], "nothing cannot be read: No such file or directory"),
        ("", [*LIVE, "--state", str(MUSCLES)], "dgf_smooth.toml cannot be read: it is no state of hillobs"),
        ("", [*GIVEN, "--state", "nothing"], "a state knows its gains and its period; leave out --gains, --set"),
        ("", [*LIVE, "--gains", str(MUSCLES)], "dgf_smooth.toml cannot be read: it is no result of hillobs"),
        ("", [*LIVE, "--save-state", str(MUSCLES)], "dgf_smooth.toml is read by this command and would be lost"),
        ("", [*LIVE, "--save-state", "no/such"], "no/such cannot be written: No such file or directory"),
    ],
)
def test_a_mistake_is_a_sentence(live: Run, given: str, arguments: list[str], sentence: str) -> None:
    code, out, err = live(given, *arguments)
    assert (code, out) == (2, "")
    assert err.splitlines()[-1].startswith("hillobs: ")
    assert sentence in err.splitlines()[-1]


def test_an_estimate_is_there_before_the_next_sample_and_a_signal_keeps_the_state(tmp_path: Path) -> None:
    pipe = subprocess.PIPE
    words = [sys.executable, "-m", "hillobs", *GIVEN, "--save-state", "kept"]
    with subprocess.Popen(words, stdin=pipe, stdout=pipe, stderr=pipe, text=True, cwd=tmp_path) as process:
        assert process.stdin is not None
        assert process.stdout is not None
        assert process.stderr is not None
        process.stdin.write(HEAD + "0,0.31,380,380\n")
        process.stdin.flush()
        assert process.stdout.readline().startswith("time [s],position_hat [m]")
        assert process.stdout.readline().startswith("0,0.31,")
        process.stdin.write("0.005,0.31,380,380\n")
        process.stdin.flush()
        assert process.stdout.readline().startswith("0.005,0.31,")
        process.send_signal(signal.SIGINT)
        assert process.wait() == 128 + signal.SIGINT
        complaints = process.stderr.read()
    assert complaints.endswith("hillobs: stopped; the state is in kept\n")
    assert (tmp_path / "kept").read_bytes().count(b"\n") == 1


def test_a_reader_that_leaves_ends_it_without_a_word(tmp_path: Path) -> None:
    (tmp_path / "samples.csv").write_text(HEAD + "".join(f"{i * 0.005},0.31,380,380\n" for i in range(2000)))
    line = f"{sys.executable} -m hillobs {' '.join(GIVEN)} < samples.csv | head -2; exit ${{PIPESTATUS[0]}}"
    done = subprocess.run(
        ["bash", "-c", line], capture_output=True, text=True, check=False, cwd=tmp_path, env=os.environ
    )
    assert (done.returncode, done.stderr) == (141, "")
    assert len(done.stdout.splitlines()) == 2
