"""A user's mistake is one sentence and exit code 2, and the same one in every locale and under python -O."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

BAD = [
    ["simulate", "nothing"],
    ["simulate", "--observer", "luenberger"],
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
    ["estimat"],
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


def test_the_place_of_a_syntax_error_is_named(command, tmp_path: Path) -> None:
    (tmp_path / "x.toml").write_text("duration = 1.0\nstep = = 3\n")
    assert "x.toml: not valid TOML: Invalid value (at line 2" in command("simulate", "x.toml")[2]


def test_a_mistake_in_the_second_scenario_runs_nothing(command, tmp_path: Path) -> None:
    code, out, _ = command("simulate", "paper-clean", "nothing", "--no-figures")
    assert (code, out) == (2, "")
    assert list(tmp_path.iterdir()) == []


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
    mistakes = [*BAD, *(["simulate", "--", name] for name in FILES)]
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
        input=repr(mistakes),
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,
        env=environment,
        errors="replace",
    )
    assert done.stdout == ""
    assert "Traceback" not in done.stderr
    assert [line for line in done.stderr.splitlines() if line.isdigit()] == ["2"] * len(mistakes), done.stderr
