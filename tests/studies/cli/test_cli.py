"""The command line as a user meets it: exit codes, sentences, files."""

import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

SHORT = ["--set", "duration=0.2", "--set", "score.start=0.1"]
# what is changed beside a scenario is in the names of its files
CHANGED = ",duration=0.2,score.start=0.1"


def measures_in(folder: Path) -> str:
    """The measures of the one run in a folder."""
    (path,) = folder.glob("*-measures.csv")
    return path.read_text()


def test_without_an_argument_the_papers_two_are_run(command, tmp_path: Path) -> None:
    code, out, err = command("simulate", *SHORT, "--no-figures")
    assert (code, err) == (0, "")
    names = {path.name for path in (tmp_path / "results").iterdir()}
    endings = ("-measures.csv", ".csv", ".nc")
    assert names == {f"paper-{kind}{CHANGED}{ending}" for kind in ("clean", "noisy") for ending in endings}
    assert "root mean square error over [0.1, 0.2]" in out
    assert "28.17 > 28.17446 does not hold" in out


def test_figures_are_written_and_drawn_again(command, tmp_path: Path) -> None:
    code, *_ = command("simulate", "paper-clean", *SHORT, "--out", "here")
    assert code == 0
    first = {path.name: path.read_bytes() for path in (tmp_path / "here").glob("*.p*")}
    assert len(first) == 10
    code, out, _ = command("figures", f"here/paper-clean{CHANGED}.nc", "--out", "again")
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


def test_alone_it_shows_its_help(command) -> None:
    assert command() == command("--help")
    code, out, err = command()
    assert (code, err) == (0, "")
    assert out.count("\n") > 10
    for name in ("simulate", "sweep", "estimate", "observability"):
        assert re.search(rf"^  {name} +\S", out, re.MULTILINE)


def test_a_changed_run_does_not_replace_the_run_as_shipped(command, tmp_path: Path) -> None:
    for changes in ([], ["--set", "high_gain.eps_h=0.2"], ["--observer", "high_gain"]):
        command("simulate", "paper-clean", "--no-figures", *changes)
    names = {path.name for path in (tmp_path / "results").glob("*.nc")}
    assert names == {"paper-clean.nc", "paper-clean,high_gain.eps_h=0.2.nc", "paper-clean,high_gain.nc"}
    many = [
        word for path in ("h11", "h12", "h13", "h21", "h22", "h31", "h32") for word in ("--set", f"high_gain.{path}=2")
    ]
    code, out, _ = command("simulate", "paper-clean", "--no-figures", *many)
    assert code == 0
    assert re.search(r"paper-clean,7 changes,[0-9a-f]{8}\.nc", out)


def test_a_shown_scenario_says_nothing_of_numbers_that_nobody_touched(command, tmp_path: Path) -> None:
    _, text, _ = command("show", "activation")
    (tmp_path / "my.toml").write_text(text)
    assert "without effect" not in command("simulate", "my.toml", *SHORT, "--no-figures")[1]
    (tmp_path / "my.toml").write_text(text.replace("k_c = 0.0", "k_c = 5.0"))
    assert (
        "without effect while plant.drive = given: controller.k_c\n"
        in command("simulate", "my.toml", *SHORT, "--no-figures")[1]
    )


COMPLETED = {
    "hillobs sim": {"simulate"},
    "hillobs simulate sla": {"slack", "slack-deep", "sla"},
    "hillobs show act": {"activation", "act"},
    "hillobs simulate --observer s": {"sliding_mode"},
    "hillobs simulate --set high_gain.eps": {"high_gain.eps_h=", "high_gain.eps_L="},
    "hillobs simulate --set muscle.curves=m": {"muscle.curves=millard2012"},
    "hillobs sweep --over noise.": {"noise.x1=", "noise.force=", "noise.drift=", "noise.period="},
}


@pytest.mark.parametrize("words", COMPLETED)
def test_a_shell_completes(words: str) -> None:
    asked = {"_HILLOBS_COMPLETE": "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}
    done = subprocess.run(
        [Path(sys.executable).parent / "hillobs"], capture_output=True, text=True, check=True, env=os.environ | asked
    )
    assert {line.partition(",")[2] for line in done.stdout.splitlines()} == COMPLETED[words]


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
    ["observability", "--map", "x3,x4", "--out", "/dev/null"],
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


LONG = "k" * 3000
ECHOES = [
    ["simulate", LONG],
    ["simulate", "--set", LONG],
    ["simulate", "--set", f"{LONG}=1"],
    ["simulate", "--set", f"plant.m={LONG}"],
    ["simulate", "--observer", LONG],
    ["observability", "--at", LONG],
    ["observability", "--outputs", LONG],
    ["observability", "--unknown", LONG],
    ["observability", "--order", LONG],
    ["observability", "--map", LONG],
    ["observability", "--map", f"x3,{LONG}"],
]


@pytest.mark.parametrize("arguments", ECHOES, ids=lambda words: " ".join(words).replace(LONG, "LONG"))
def test_a_long_word_is_quoted_short(arguments: list[str], command) -> None:
    code, _, err = command(*arguments)
    assert code == 2
    assert len(err) < 500


def test_an_observer_that_fails_is_named_and_the_others_are_kept(command, tmp_path: Path) -> None:
    settings = ["--set", "sliding_mode.tau_s=1e-5", "--set", "duration=2", "--set", "score.start=1"]
    code, out, err = command("simulate", "paper-noisy", *settings, "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: sliding_mode: ")
    assert "is not a finite number at τ = " in err
    assert "HGO" in out
    text = measures_in(tmp_path / "results")
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


def in_a_process(*arguments: str, timeout: float | None = None, **environment: str) -> subprocess.CompletedProcess[str]:
    done = subprocess.run(
        [sys.executable, *arguments],
        env={**os.environ, **environment},
        capture_output=True,
        text=True,
        check=False,
        encoding="utf-8",
        timeout=timeout,
    )
    # which test is the first to compile a library is chance
    complaints = [line for line in done.stderr.splitlines(keepends=True) if "hillobs: compiling " not in line]
    done.stderr = "".join(complaints)
    return done


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
        results.append((tmp_path / name / f"paper-noisy{CHANGED}.csv").read_text())
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
    heavy = "('casadi', 'matplotlib', 'xarray')"
    code = f"import sys, hillobs.studies.cli.main; print([m for m in {heavy} if m in sys.modules])"
    assert in_a_process("-c", code).stdout == "[]\n"


def test_ascii_output_degrades() -> None:
    done = in_a_process("-m", "hillobs", "list", "observers", PYTHONIOENCODING="ascii")
    assert done.returncode == 0
    assert "high_gain" in done.stdout


FILES = {
    "syntax.toml": b"[plant]\nm = \n",
    "bom.toml": b"\xef\xbb\xbf[plant]\n",
    "bytes.toml": b"# \xff\n",
    "deep.toml": b"a = " + b"[" * 3000,
    "digits.toml": b"plant.m = " + b"9" * 5000,
    "hexadecimal.toml": b"seed = 0x" + b"f" * 5000,
    "logical.toml": b"plant.m = true\n",
    "text.toml": b'plant.m = "1.5"\n',
    "date.toml": b"plant.m = 2020-01-01\n",
    "array.toml": b"plant.m = [1.5]\n",
    "table.toml": b"[plant.m]\nx = 1\n",
    "number.toml": b"plant = 1\n",
    "nan.toml": b"plant.m = nan\n",
    "huge.toml": b"#" * 2_000_000,
    "zero.toml": b'description = "a\\u0000b"\nduration = 0.1\n',
    "run[bold].toml": b"plant.m = 0\n",
    "new\nline.toml": b"plant.m = 0\n",
    "red\x1b[31m.toml": b"plant.m = 0\n",
    "-dash.toml": b"plant.m = 0\n",
    "=1+1.toml": b"plant.m = 0\n",
}


@pytest.mark.parametrize("name", FILES, ids=ascii)
def test_a_bad_file_is_one_line_and_exit_code_2(name: str, command, tmp_path: Path) -> None:
    (tmp_path / name).write_bytes(FILES[name])
    code, out, err = command("simulate", "--no-figures", "--", name)
    assert (code, out) == (2, "")
    assert err.startswith("hillobs: ")
    assert err.count("\n") == 1
    assert err.rstrip("\n").isprintable()
    assert not (tmp_path / "results").exists()


ODD_NAMES = ["a[/x].toml", "run[bold].toml", "-dash.toml", "sp ace.toml", "$(touch made).toml", "ü😀.toml", "...toml"]


@pytest.mark.parametrize("name", ODD_NAMES)
def test_a_good_file_with_an_odd_name_runs(name: str, command, tmp_path: Path) -> None:
    path = tmp_path / name
    path.parent.mkdir(exist_ok=True)
    path.write_text("duration = 0.1\nscore.start = 0.05\n")
    code, out, err = command("simulate", "--no-figures", "--out", "o", "--", name)
    assert (code, err) == (0, "")
    assert out.startswith(f"{path.stem}, seed 0")
    assert sorted(p.name for p in (tmp_path / "o").iterdir()) == [
        f"{path.stem}{end}" for end in ("-measures.csv", ".csv", ".nc")
    ]
    assert not (tmp_path / "made").exists()


@pytest.mark.parametrize(
    "name", ["red\x1b[31m.toml", "bell\a.toml", "back\r.toml", "\x9b31m.toml", os.fsdecode(b"\xff.toml")]
)
def test_a_name_cannot_send_control_characters_to_the_terminal(name: str, command, tmp_path: Path) -> None:
    (tmp_path / name).write_text("duration = 0.1\nscore.start = 0.05\n")
    code, out, err = command("simulate", "--no-figures", "--", name)
    assert code in (0, 2)
    assert (out + err).replace("\n", "").isprintable()


@pytest.mark.parametrize("character", ["\\u001b", "\\r", "\\u0007", "\\u009b", "\\u007f"])
def test_a_description_cannot_send_control_characters_to_the_terminal(character: str, command, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text(f'description = "a{character}b"\nduration = 0.1\nscore.start = 0.05\n')
    code, out, err = command("simulate", "--no-figures", "x.toml")
    assert code in (0, 2)
    assert (out + err).replace("\n", "").isprintable()


def test_a_description_that_is_no_text_is_a_sentence(command, tmp_path: Path) -> None:
    """An argument in another encoding than the terminal's reaches Python as lone surrogates."""
    change = os.fsdecode(b"description=\xff")
    code, out, err = command("simulate", *SHORT, "--set", change, "--no-figures", "--out", str(tmp_path))
    assert (code, out) == (2, "")
    assert err == "hillobs: description must be a text of whole characters without \\0, not '\\udcff'\n"


def test_the_place_of_a_syntax_error_is_named(command, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text("duration = 1.0\nstep = = 3\n")
    assert "x.toml: not valid TOML: Invalid value (at line 2" in command("simulate", "x.toml")[2]


def test_two_scenarios_of_one_name_do_not_overwrite_each_other(command, tmp_path: Path) -> None:
    for folder in ("a", "b"):
        (tmp_path / folder).mkdir()
        (tmp_path / folder / "x.toml").write_text("duration = 0.1\n")
    code, out, err = command("simulate", "a/x.toml", "b/x.toml", "--no-figures")
    assert (code, out) == (2, "")
    assert "x" in err


def test_a_mistake_in_the_second_scenario_runs_nothing(command, tmp_path: Path) -> None:
    code, out, _ = command("simulate", "paper-clean", "nothing", "--no-figures")
    assert (code, out) == (2, "")
    assert list(tmp_path.iterdir()) == []


@pytest.mark.parametrize("place", ["file", "file/below", os.devnull, "/dev/full", "/proc/nothing", "x" * 300])
def test_an_output_that_is_no_folder_is_a_sentence(place: str, command, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    code, out, err = command("simulate", *SHORT, "--no-figures", "--out", place)
    assert (code, out) == (2, "")
    assert err.startswith(f"hillobs: {place} cannot be written to: ")
    assert (tmp_path / "file").read_text() == "mine"


def test_an_output_that_is_a_file_is_called_one(command, tmp_path: Path) -> None:
    (tmp_path / "file").write_text("mine")
    err = command("simulate", *SHORT, "--no-figures", "--out", "file")[2]
    assert err == "hillobs: file cannot be written to: it is not a folder\n"


def test_a_folder_without_rights_is_a_sentence(tmp_path: Path) -> None:
    """As a user who may not write there; an administrator may write everywhere."""
    locked = tmp_path / "locked"
    locked.mkdir()
    locked.chmod(0o555)
    code = (
        "import os; from pathlib import Path; from hillobs.studies.files.writing import ResultError, writable_folder\n"
        "os.chdir('locked')\n"
        "if os.geteuid() == 0: os.setgid(65534); os.setuid(65534)\n"
        "try: writable_folder(Path('out'))\nexcept ResultError as error: print(error)"
    )
    done = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=False, cwd=tmp_path)
    assert done.stdout == "out cannot be written to: Permission denied\n", done.stderr


def test_a_result_that_cannot_be_replaced_leaves_nothing_partial(command, tmp_path: Path) -> None:
    (tmp_path / "o" / f"paper-clean{CHANGED}.csv").mkdir(parents=True)
    code, _, err = command("simulate", "paper-clean", *SHORT, "--no-figures", "--out", "o")
    assert code == 2
    assert err == f"hillobs: o/paper-clean{CHANGED}.csv cannot be written: Is a directory\n"
    assert not [p.name for p in (tmp_path / "o").iterdir() if p.name.startswith(".")]


DAMAGE = {
    "empty": lambda raw: b"",
    "cut": lambda raw: raw[: len(raw) // 2],
    "a page of zeros": lambda raw: raw[:4096] + bytes(4096) + raw[8192:],
    "zeros at the end": lambda raw: raw[:-4096] + bytes(4096),
    "text": lambda raw: b"t,x1\n0,1\n",
}


@pytest.mark.parametrize("how", DAMAGE)
def test_figures_of_a_damaged_result_are_refused(how: str, command, tmp_path: Path) -> None:
    command("simulate", "paper-clean", *SHORT, "--no-figures", "--out", ".")
    path = tmp_path / f"paper-clean{CHANGED}.nc"
    path.write_bytes(DAMAGE[how](path.read_bytes()))
    # in a process of its own: a reader that is led astray by the damage may never come back
    try:
        done = in_a_process("-m", "hillobs", "figures", str(path), timeout=20)
    except subprocess.TimeoutExpired:
        pytest.fail("the reader hangs")
    assert (done.returncode, done.stdout) == (2, "")
    assert done.stderr.startswith(f"hillobs: {path} ")
    assert done.stderr.count("\n") == 1
    assert not list(tmp_path.glob("*.p*f"))


NUMERICAL = {
    "adaptive_sliding_mode": ["--set", "adaptive_sliding_mode.tau_a=1e-5"],
    "sliding_mode": ["--set", "sliding_mode.tau_s=1e-5"],
    "high_gain": ["--set", "high_gain.eps_h=1e-150"],
}


@pytest.mark.parametrize("observer", NUMERICAL)
def test_each_observer_that_fails_leaves_the_others_as_they_were(observer: str, command, tmp_path: Path) -> None:
    command("simulate", "paper-noisy", *SHORT, "--no-figures", "--out", "good")
    code, _, err = command("simulate", "paper-noisy", *SHORT, "--no-figures", "--out", "bad", *NUMERICAL[observer])
    assert code == 1
    assert err.startswith(f"hillobs: {observer}: ")
    assert err.count("\n") == 1
    rows = [measures_in(tmp_path / f).splitlines() for f in ("good", "bad")]
    for good, bad in zip(*rows, strict=True):
        if f",{observer}," in good:
            assert bad.endswith(",,,,,"), bad
        else:
            assert good == bad


def test_an_unstable_gain_is_not_blamed_on_the_step(command) -> None:
    """h11 < 0 is unstable for every step; its gain condition is violated and says so."""
    run = ["simulate", "paper-clean", "--set", "high_gain.h11=-5", "--observer", "high_gain", "--no-figures"]
    code, out, err = command(*run)
    assert code == 1
    assert "gain condition of HGO: h11 > 0" in out or "h₁₁" in out
    assert "gain" in err
    assert "step" not in err


def test_a_plant_outside_its_domain_is_named_and_has_no_measures(command, tmp_path: Path) -> None:
    far = ["--set", "plant.C=2", *SHORT]
    code, out, err = command("simulate", "paper-clean", *far, "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: the plant: it starts outside its domain, the fibre length L_C2")
    text = measures_in(tmp_path / "results").splitlines()[1:]
    assert all(row.endswith(",,,,,") for row in text)
    assert "nan" not in out


def test_a_fibre_that_reaches_0_on_the_way_is_named(command, tmp_path: Path) -> None:
    pulse = ["pulse1.amplitude=5", "pulse1.start=0.1", "pulse1.stop=1", "duration=1", "score.start=0.05"]
    code, out, err = command("simulate", "paper-clean", *[x for p in pulse for x in ("--set", p)], "--no-figures")
    assert code == 1
    assert err.startswith("hillobs: the plant: the fibre length L_C1 reached 0 at τ = 0.")
    assert "was slack" not in out
    assert all(row.endswith(",,,,,") for row in measures_in(tmp_path / "results").split()[1:])


def test_a_short_run_says_nothing_of_conditions_it_cannot_check(command) -> None:
    code, out, _ = command("simulate", "paper-clean", "--set", "duration=0.01", "--set", "record=0.01", "--no-figures")
    assert code == 0
    code, out, _ = command(
        "simulate", "paper-clean", "--set", "duration=0.005", "--set", "record=0.005", "--no-figures"
    )
    assert code == 0
    assert "nan" not in out


def test_no_number_of_a_table_is_cut_in_a_narrow_terminal(command, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("COLUMNS", "40")
    _, out, _ = command("simulate", "paper-noisy", *SHORT, "--no-figures")
    assert "…" not in out


def test_what_did_not_settle_keeps_its_column(command) -> None:
    _, out, _ = command("simulate", "paper-noisy", *SHORT, "--no-figures")
    table = out.partition("settling time")[2].splitlines()
    assert table[1].split() == ["x1", "x2", "x3", "x4", "Delta", "u1", "u2", "a1", "a2"]
    assert "–" in table[2]


CLOSED = ["list", "show paper-clean", "info", "simulate paper-clean --no-figures --set duration=0.1 --out OUT"]


@pytest.mark.parametrize("words", CLOSED)
def test_a_full_stdout_is_a_sentence(words: str, tmp_path: Path) -> None:
    if not os.path.exists("/dev/full"):
        pytest.skip("no /dev/full here")
    line = f"{sys.executable} -m hillobs {words} >/dev/full".replace("OUT", str(tmp_path))
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.returncode in (1, 2)
    assert "Traceback" not in done.stderr
    assert "No space left" in done.stderr


@pytest.mark.parametrize("stream", [">&-", "2>&-", ">&- 2>&-"])
@pytest.mark.parametrize("words", CLOSED[:1] + CLOSED[-1:], ids=["list", "simulate"])
def test_a_closed_stream_does_no_harm(words: str, stream: str, tmp_path: Path) -> None:
    line = f"{sys.executable} -m hillobs {words} {stream}".replace("OUT", str(tmp_path))
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert (done.returncode, done.stderr) == (0, "")


@pytest.mark.parametrize("words", [*CLOSED, "--help", "--version"])
def test_a_reader_that_leaves_is_no_failure(words: str, tmp_path: Path) -> None:
    """Exit code 0 or that of SIGPIPE: 1 would say that numbers failed."""
    line = f"{sys.executable} -m hillobs {words} | true; exit ${{PIPESTATUS[0]}}".replace("OUT", str(tmp_path))
    done = subprocess.run(["bash", "-c", line], capture_output=True, text=True, check=False)
    assert done.stderr == ""
    assert done.returncode in (0, 141)


@pytest.mark.parametrize("stream", ["2>/dev/full", "2>&1 | true; exit ${PIPESTATUS[0]}"])
@pytest.mark.parametrize("words", ["simulate nothing", "--no-such-option"])
def test_a_mistake_that_nobody_hears_has_its_exit_code(words: str, stream: str) -> None:
    done = subprocess.run(["bash", "-c", f"{sys.executable} -m hillobs {words} {stream}"], check=False)
    assert done.returncode == 2


IN_ONE_PROCESS = """
import sys
from hillobs.studies.cli.main import main
for arguments in eval(sys.stdin.read()):
    sys.argv = ["hillobs", *arguments]
    try:
        main()
        code = 0
    except SystemExit as end:
        code = end.code
    print(code, file=sys.stderr)
"""


@pytest.mark.parametrize("surroundings", ["-O", "de_DE", "C"])
def test_every_mistake_is_the_same_in_other_surroundings(surroundings: str, tmp_path: Path) -> None:
    for name, content in FILES.items():
        (tmp_path / name).write_bytes(content)
    every = [*BAD, *(["simulate", "--", name] for name in FILES)]
    environment = {"PATH": os.environ["PATH"], "HILLOBS_CACHE": os.environ["HILLOBS_CACHE"]}
    options = [surroundings] if surroundings == "-O" else []
    if surroundings == "de_DE":
        if not shutil.which("localedef"):
            pytest.skip("no localedef to make a German locale with")
        made = ["localedef", "-i", "de_DE", "-f", "UTF-8", str(tmp_path / "de_DE.UTF-8")]
        subprocess.run(made, capture_output=True, check=False)
        if not (tmp_path / "de_DE.UTF-8").is_dir():
            pytest.skip("localedef has no German locale")
        environment |= {"LOCPATH": str(tmp_path), "LC_ALL": "de_DE.UTF-8"}
    if surroundings == "C":
        environment |= {"LC_ALL": "C", "PYTHONUTF8": "0", "PYTHONCOERCECLOCALE": "0"}
    done = subprocess.run(
        [sys.executable, *options, "-c", IN_ONE_PROCESS],
        input=repr(every),
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=environment,
        errors="replace",
    )
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    assert [line for line in done.stderr.splitlines() if line.isdigit()] == ["2"] * len(every), done.stderr
