"""Figures of a damaged result are refused in one sentence, and the reader does not hang."""

import subprocess
from pathlib import Path

import pytest

from command_line import CHANGED, SHORT, in_a_process

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
