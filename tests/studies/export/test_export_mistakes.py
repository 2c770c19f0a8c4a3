"""`hillobs export`: what cannot be exported is said in one sentence, and nothing of a user's is replaced."""

from pathlib import Path

import pytest

from exported_programs import built, needs_cc

BLOCK = """
from hillobs import Block, Parameter, Symbols, symbols
ESTIMATES = ("x1_hat", "x2_hat", "x3_hat", "x4_hat", "Delta_hat", "u1_hat", "u2_hat")
def mine(states=(), sentence="a number", grid=False):
    x, u = symbols(states), symbols("y1")
    parameters = {{"gain": Parameter(1.0, sentence, "mine")}}
    moves = Symbols({{name: -x[name] for name in states}})
    y = Symbols(dict.fromkeys(ESTIMATES, u.y1))
    common = {{"x": x, "u": u, "p": symbols(parameters), "parameters": parameters, "y": y}}
    return Block("mine", **common, **{{"per_step" if grid else "dx": moves}})
block = mine({})
"""
USUAL = ["export", "c", "--observer", "high_gain", "--period", "0.005"]

BAD = {
    "unknown observer": ["export", "c", "--observer", "luenberger", "--period", "0.005"],
    "must be above 0": ["export", "c", "--observer", "high_gain", "--period", "0"],
    "must be a number": ["export", "c", "--observer", "high_gain", "--period", "5ms"],
    "at most 0.7": ["export", "c", "--observer", "high_gain", "--period", "1"],
    "too fast": [*USUAL, "--set", "high_gain.eps_h=1e-6"],
    "may be unstable with 1 step": [*USUAL[:3], "adaptive_sliding_mode", *USUAL[4:], "--substeps", "1"],
    "moves at samples only": [*USUAL[:3], "kalman", *USUAL[4:], "--substeps", "2"],
    "one of them": [*USUAL, "--scenario", "slack", "--muscles", "pair.toml"],
    "no such file": [*USUAL, "--muscles", "nothing.toml"],
    "not a folder": [*USUAL, "--out", "/dev/null"],
}


@pytest.mark.parametrize("words", BAD)
def test_a_mistake_is_one_sentence_and_exit_code_2(words: str, command, tmp_path: Path) -> None:
    code, out, err = command("export", "c", "--out", "c", *BAD[words][2:])
    assert (code, out) == (2, "")
    assert err.startswith("hillobs: ")
    assert words in err.lower() or words in err
    assert err.count("\n") == 1
    assert not (tmp_path / "c").exists()


@pytest.mark.parametrize(
    ("block", "words"),
    [
        ("['a.b', 'a_b']", "would both be called a_b"),
        ("['é']", "no name in C"),
        ("['count'], grid=True", "samples have none"),
    ],
)
def test_a_block_that_c_cannot_express_is_named(block: str, words: str, command, tmp_path: Path) -> None:
    (tmp_path / "own.py").write_text(BLOCK.format(block), encoding="utf-8")
    code, out, err = command("export", "c", "--observer", "own.py:block", "--period", "0.01", "--out", "c")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("hillobs: mine: ")
    assert words in err


@needs_cc
def test_words_of_a_block_are_harmless_in_c(command, tmp_path: Path) -> None:
    words = r"""['int', 'exp', 'errno', 'NULL'], '*/ #error /* // \\ \n??/ \u202e ε "%s" ${x}'"""
    (tmp_path / "own.py").write_text(BLOCK.format(words), encoding="utf-8")
    assert command("export", "c", "--observer", "own.py:block", "--period", "0.01", "--out", "c")[0] == 0
    built(tmp_path / "c", "mine", "-O0")


def test_what_is_there_already_stays_unless_it_is_ours(command, tmp_path: Path) -> None:
    (tmp_path / "c").mkdir()
    (tmp_path / "c" / "main.c").write_text("mine")
    code, out, err = command(*USUAL, "--out", "c")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert [path.name for path in (tmp_path / "c").iterdir()] == ["main.c"]
    assert (tmp_path / "c" / "main.c").read_text() == "mine"
    (tmp_path / "c" / "main.c").unlink()
    assert command(*USUAL, "--out", "c")[0] == 0
    assert command(*USUAL, "--float", "--out", "c")[0] == 0
