"""Figures of a damaged result are refused in one sentence, and the reader does not hang."""

from pathlib import Path

import pytest

from command_line import CHANGED, SHORT
from forks import Forks

DAMAGE = {
    "empty": lambda raw: b"",
    "cut": lambda raw: raw[: len(raw) // 2],
    "a page of zeros": lambda raw: raw[:4096] + bytes(4096) + raw[8192:],
    "zeros at the end": lambda raw: raw[:-4096] + bytes(4096),
    "text": lambda raw: b"t,x1\n0,1\n",
}


@pytest.mark.parametrize("how", DAMAGE)
def test_figures_of_a_damaged_result_are_refused(how: str, command, forks: Forks, tmp_path: Path) -> None:
    command("simulate", "paper-clean", *SHORT, "--no-figures", "--out", ".")
    path = tmp_path / f"paper-clean{CHANGED}.nc"
    path.write_bytes(DAMAGE[how](path.read_bytes()))
    # a reader that is led astray by the damage may never come back: an alarm ends the fork
    done = forks.run(tmp_path, "figures", str(path))
    assert (done.code, done.out) == (2, "")
    assert done.err.startswith(f"hillobs: {path} ")
    assert done.err.count("\n") == 1
    assert not list(tmp_path.glob("*.p*f"))
