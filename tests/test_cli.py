"""The command line as a user meets it: exit codes, sentences, files."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

from hillobs.studies import cli

SHORT = ["--set", "duration=0.2", "--set", "score.start=0.1"]


def hillobs(
    *arguments: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> tuple[int, str, str]:
    monkeypatch.setattr(sys, "argv", ["hillobs", *arguments])
    code = 0
    try:
        cli.main()
    except SystemExit as end:
        code = int(end.code or 0)
    captured = capsys.readouterr()
    return code, captured.out, captured.err


@pytest.fixture
def command(monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path):
    monkeypatch.chdir(tmp_path)
    return lambda *arguments: hillobs(*arguments, monkeypatch=monkeypatch, capsys=capsys)


def test_without_an_argument_the_papers_two_are_run(command, tmp_path: Path) -> None:
    code, out, err = command("simulate", *SHORT, "--no-figures")
    assert (code, err) == (0, "")
    names = sorted(path.name for path in (tmp_path / "results").iterdir())
    assert names == [f"paper-{kind}{end}" for kind in ("clean", "noisy") for end in ("-measures.csv", ".csv", ".nc")]
    assert "root mean square error over [0.1, 0.2]" in out
    assert "28.17 > 28.17446 does not hold" in out


def test_figures_are_written_and_drawn_again(command, tmp_path: Path) -> None:
    code, *_ = command("simulate", "paper-clean", *SHORT, "--out", "here")
    assert code == 0
    first = {path.name: path.read_bytes() for path in (tmp_path / "here").glob("*.p*")}
    assert len(first) == 10
    code, out, _ = command("figures", "here/paper-clean.nc", "--out", "again")
    assert (code, out) == (0, "written to again/: 5 figures as PNG and PDF\n")
    assert {path.name: path.read_bytes() for path in (tmp_path / "again").glob("*.p*")} == first


def test_only_the_observers_asked_for_run(command) -> None:
    code, out, _ = command(
        "simulate", "paper-noisy", *SHORT, "--no-figures", "--observer", "sliding_mode", "--seed", "4"
    )
    assert code == 0
    assert "seed 4" in out
    assert "SMO" in out
    assert "HGO" not in out


BAD = [
    ["simulate", "nothing"],
    ["simulate", "--observer", "kalman"],
    ["simulate", "--set", "plant.mass=1"],
    ["simulate", "--set", "plant.m=0"],
    ["simulate", "--set", "plant.m=true"],
    ["simulate", "--set", "high_gain.eps_h=-1"],
    ["simulate", "--set", "duration=nan"],
    ["simulate", "--step", "30"],
    ["simulate", "--step", "0.0003"],
    ["simulate", "--step", "x"],
    ["simulate", "--seed", "-1"],
    ["simulate", "--out", "/dev/null"],
    ["simulate", "--no-such-option"],
    ["simulate", "a[/x].toml"],
    ["simulate", "bad.toml"],
    ["show", "nothing"],
    ["list", "nothing"],
    ["figures", "nothing.nc"],
    ["figures", "bad.toml"],
    ["observability", "--outputs", "y9"],
    ["observability", "--outputs", ","],
    ["observability", "--at", "x9=1"],
    ["observability", "--at", "x3=-1"],
    ["observability", "--at", "x1=1.5"],
    ["observability", "--order", "-1"],
    ["observability", "--order", "1.5"],
    ["observability", "--unknown", "z"],
    ["observability", "--signals", "-2"],
    ["observability", "--tolerance", "2"],
    ["observability", "--map", "x3"],
    ["observability", "--map", "x3,q"],
    ["nonsense"],
]


@pytest.mark.parametrize("arguments", BAD, ids=" ".join)
def test_a_mistake_is_one_sentence_and_exit_code_2(arguments: list[str], command, tmp_path: Path) -> None:
    (tmp_path / "bad.toml").write_text("[plant\n")
    code, out, err = command(*arguments, *(["--no-figures"] if arguments[0] == "simulate" else []))
    assert code == 2
    assert out == ""
    assert err.startswith("hillobs: ")
    assert err.count("\n") == 1
    assert "Traceback" not in err


def test_an_observer_that_fails_is_named_and_the_others_are_kept(command, tmp_path: Path) -> None:
    settings = ["--set", "sliding_mode.tau_s=1e-5", "--set", "duration=2", "--set", "score.start=1"]
    code, out, err = command("simulate", "paper-noisy", *settings, "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: sliding_mode: ")
    assert "is not a finite number at τ = " in err
    assert "HGO" in out
    text = (tmp_path / "results" / "paper-noisy-measures.csv").read_text()
    assert "high_gain,x2,0.00" in text
    assert "sliding_mode,x2,,,,," in text


def test_a_number_that_nothing_takes_is_named(command) -> None:
    settings = [*SHORT, "--set", "plant.drive=given", "--set", "reference.offset=2.7", "--set", "plant.m=1.1"]
    code, out, _ = command("simulate", "paper-clean", *settings, "--no-figures")
    assert code == 0
    assert "without effect while plant.drive = given: reference.offset\n" in out
    assert "without effect" not in command("simulate", "challenge", *SHORT, "--no-figures")[1]


def test_a_mass_out_of_reach_is_named(command) -> None:
    far = ["--set", "initial.x2=-40", "--set", "duration=2", "--set", "score.start=1"]
    code, _, err = command("simulate", "paper-clean", *far, "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: the plant: the tendon length x3 reached 0 at τ = 0.0")


def test_show_list_info_and_version_speak(command) -> None:
    code, out, _ = command("show", "challenge")
    assert code == 0
    assert "k_c = 5.0  # gain of the pretension" in out
    code, out, _ = command("list")
    assert code == 0
    assert all(word in out for word in ("slack-deep", "adaptive_sliding_mode", "nguyen2019", "high_gain.eps_h"))
    code, out, _ = command("info")
    assert code == 0
    assert "compiler" in out
    assert command("--version")[1].startswith("hillobs, version ")


def test_observability_answers_with_its_exit_code(command, tmp_path: Path) -> None:
    code, out, _ = command("observability", "--unknown", "u")
    assert code == 0
    assert "rank 7 of 7, observable" in out
    code, out, _ = command("observability", "--unknown", "a", "--at", "x3=1.99", "--json")
    assert code == 1
    import json

    answer = json.loads(out)
    assert {key: answer[key] for key in ("rank", "n", "structural_rank", "unobservable")} == {
        "rank": 5,
        "n": 7,
        "structural_rank": 7,
        "unobservable": ["x3", "a1"],
    }
    code, out, _ = command("observability", "--at", "x3=2")
    assert code == 1
    assert "warning: the derivatives jump at x3 = 2 (rank 3 below, 4 above)" in out
    code, out, _ = command(
        "observability", "slack", "--set", "duration=8", "--along", "--map", "x1,tension", "--out", "o"
    )
    assert code == 0
    assert "along the run, rank 4 for 6." in out
    assert "over the map, rank 4 on 9" in out
    assert len(list((tmp_path / "o").iterdir())) == 6


def in_a_process(*arguments: str, **environment: str) -> subprocess.CompletedProcess[str]:
    return subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
        encoding="utf-8",
    )


def test_it_is_the_same_without_asserts(tmp_path: Path) -> None:
    """python -O: nothing a user can reach is guarded by an assert."""
    for option in ([], ["-O"]):
        done = in_a_process(*option, "-m", "hillobs", "simulate", "--set", "plant.m=0", "--out", str(tmp_path))
        assert (done.returncode, done.stderr) == (2, "hillobs: plant.m must be above 0, not 0\n")


def test_a_german_locale_keeps_the_point(tmp_path: Path) -> None:
    if not shutil.which("localedef"):
        pytest.skip("no localedef to make a German locale with")
    made = subprocess.run(
        ["localedef", "-i", "de_DE", "-f", "UTF-8", tmp_path / "de_DE.UTF-8"], capture_output=True, check=False
    )
    if not (tmp_path / "de_DE.UTF-8").is_dir():
        pytest.skip(f"localedef has no German locale: {made.stderr.decode()[:80]}")
    german = {"LOCPATH": str(tmp_path), "LC_ALL": "de_DE.UTF-8"}
    results = []
    for name, environment in (("de", german), ("c", {})):
        done = in_a_process(
            "-m",
            "hillobs",
            "simulate",
            "paper-noisy",
            *SHORT,
            "--no-figures",
            "--out",
            str(tmp_path / name),
            **environment,
        )
        assert done.returncode == 0, done.stderr
        results.append((tmp_path / name / "paper-noisy.csv").read_text())
    assert results[0] == results[1]
    done = in_a_process("-m", "hillobs", "simulate", "--set", "plant.m=1,5", **german)
    assert (done.returncode, done.stderr) == (2, "hillobs: plant.m must be a number, not '1,5'\n")


def test_without_a_compiler_it_says_what_to_install(tmp_path: Path) -> None:
    (tmp_path / "empty").mkdir()
    environment = {"PATH": str(tmp_path / "empty"), "HILLOBS_CACHE": str(tmp_path / "cache"), "CXX": "", "CC": ""}
    done = in_a_process("-m", "hillobs", "simulate", *SHORT, "--no-figures", "--out", str(tmp_path), **environment)
    if "ziglang" in in_a_process("-m", "pip", "list").stdout:
        pytest.skip("the compiler wheel is installed")
    assert done.returncode == 2
    assert "apt install g++" in done.stderr
    assert "hillobs[compiler]" in done.stderr


def test_a_closed_pipe_is_silent() -> None:
    done = subprocess.run(
        ["bash", "-c", f"{sys.executable} -m hillobs list | head -1"], capture_output=True, text=True, check=False
    )
    assert (done.stdout, done.stderr) == ("scenarios:\n", "")


def test_help_is_quick_because_heavy_modules_wait() -> None:
    code = "import sys, hillobs.studies.cli; print([m for m in ('casadi', 'matplotlib', 'xarray') if m in sys.modules])"
    assert in_a_process("-c", code).stdout == "[]\n"


def test_ascii_output_degrades() -> None:
    done = in_a_process("-m", "hillobs", "list", "observers", PYTHONIOENCODING="ascii")
    assert done.returncode == 0
    assert "high_gain" in done.stdout
