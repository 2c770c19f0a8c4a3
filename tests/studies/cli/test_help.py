"""What the command line says of itself: help, completion, lists, scenarios, version; quickly."""

import os
import re
import subprocess
import sys
from pathlib import Path

import pytest
from click.shell_completion import shell_complete

from command_line import SHORT, in_a_process
from hillobs.studies.cli.main import commands
from places import DOCS, RECORDINGS


def test_alone_it_shows_its_help(command) -> None:
    assert command() == command("--help")
    code, out, err = command()
    assert (code, err) == (0, "")
    assert out.count("\n") > 10
    for name in ("simulate", "sweep", "estimate", "observability"):
        assert re.search(rf"^  {name} +\S", out, re.MULTILINE)


COMPLETED = {
    "hillobs sim": {"simulate"},
    "hillobs simulate sla": {"slack", "slack-deep", "sla"},
    "hillobs show act": {"activation", "act"},
    "hillobs simulate --observer s": {"sliding_mode", "s"},
    "hillobs simulate --set high_gain.eps": {"high_gain.eps_h=", "high_gain.eps_L="},
    "hillobs simulate --set muscle.curves=m": {"muscle.curves=millard2012"},
    "hillobs imp": {"import"},
    "hillobs import --pa": {"--paths"},
    "hillobs sweep --over noise.": {"noise.x1=", "noise.force=", "noise.drift=", "noise.period="},
}


VARIABLE = "_HILLOBS_COMPLETE"


def asked(words: str) -> dict[str, str]:
    """What a shell asks by, in the environment."""
    return {VARIABLE: "bash_complete", "COMP_WORDS": words, "COMP_CWORD": str(words.count(" "))}


def completed(out: str) -> set[str]:
    return {line.partition(",")[2] for line in out.splitlines()}


@pytest.mark.parametrize("words", COMPLETED)
def test_a_shell_completes(
    words: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    for name, value in asked(words).items():
        monkeypatch.setenv(name, value)
    assert shell_complete(commands, {}, "hillobs", VARIABLE, "bash_complete") == 0
    assert completed(capsys.readouterr().out) == COMPLETED[words]


def test_completion_does_not_run_the_file_of_an_observer(tmp_path: Path) -> None:
    """The program itself, as a shell starts it."""
    (tmp_path / "own.py").write_text("open('ran', 'w')")
    environment = os.environ | asked("hillobs simulate --observer own.py:x sla")
    program = Path(sys.executable).parent / "hillobs"
    done = subprocess.run([program], capture_output=True, text=True, check=True, env=environment, cwd=tmp_path)
    assert completed(done.stdout) == COMPLETED["hillobs simulate sla"]
    assert [path.name for path in tmp_path.iterdir()] == ["own.py"]


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
    assert f"shipped   {RECORDINGS}\n" in out
    assert command("--version")[1].startswith("hillobs, version ")


def test_docs_tells_where_a_page_is(command) -> None:
    code, out, _ = command("docs")
    assert (code, out) == (0, f"{DOCS}\n")
    for name, place in (
        ("observers", "observers.md"),
        ("messages", "how-to/messages.md"),
        ("first-run", "tutorials/first-run.md"),
    ):
        code, out, _ = command("docs", name)
        assert (code, out) == (0, f"{DOCS / place}\n")
    code, out, err = command("docs", "observer")
    assert (code, out, err) == (2, "", "hillobs: there is no page 'observer'; there are observers, own-observer\n")


def test_help_is_quick_because_heavy_modules_wait() -> None:
    heavy = "('casadi', 'matplotlib', 'xarray')"
    code = f"import sys, hillobs.studies.cli.main; print([m for m in {heavy} if m in sys.modules])"
    assert in_a_process("-c", code).stdout == "[]\n"


def test_a_run_without_figures_waits_for_neither_matplotlib_nor_dask(tmp_path: Path) -> None:
    code = f"""
import atexit, sys
from hillobs.__main__ import main
atexit.register(lambda: print(sorted({{"dask", "matplotlib"}} & {{name for name, it in sys.modules.items() if it}})))
sys.argv = ["hillobs", "simulate", "paper-clean", "--no-figures", "--out", {str(tmp_path)!r}, *{SHORT!r}]
main()
"""
    assert in_a_process("-c", code).stdout.endswith("\n[]\n")


def test_the_file_of_an_observer_may_import_dask(tmp_path: Path) -> None:
    (tmp_path / "my.py").write_text("import dask, hillobs\nmine = hillobs.Block('mine')\n", encoding="utf-8")
    code = f"""
from hillobs.studies.files.dask import leave_out
leave_out()
from hillobs.studies.cli.shell.own_observers import loaded
print(loaded([{str(tmp_path / "my.py:mine")!r}])[0].name)
"""
    assert in_a_process("-c", code).stdout == "mine\n"


def test_a_process_that_has_xarray_already_keeps_dask(tmp_path: Path) -> None:
    code = f"""
import sys, hillobs.studies.cli.simulate
from hillobs.__main__ import main
sys.argv = ["hillobs", "simulate", "paper-clean", "--no-figures", "--out", {str(tmp_path)!r}, *{SHORT!r}]
main()
"""
    assert in_a_process("-c", code).stderr == ""
