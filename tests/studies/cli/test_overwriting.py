"""No command writes over what it reads, over a user's file, or over a product of its own that a user has changed."""

import hashlib
import os
from collections.abc import Callable
from pathlib import Path

import pytest

from hillobs.studies.files.written import list_name, remember
from places import DATA, contents
from written_files import WRITERS, inputs

Command = Callable[..., tuple[int, str, str]]


@pytest.mark.parametrize("writer", WRITERS)
def test_a_command_writes_over_its_own_files_and_over_no_other(writer: str, command: Command, tmp_path: Path) -> None:
    """Twice the same is the same; then a file is a link, then each was changed, then each is a user's."""
    read = inputs(tmp_path)
    assert command(*WRITERS[writer])[0] == 0
    first = contents(tmp_path)
    assert command(*WRITERS[writer])[0] == 0
    assert contents(tmp_path) == first
    # the result of a sweep is read, never written again: a file under its name is that, or damaged
    written = sorted(first.keys() - read - {"x.nc"})
    link = tmp_path / written[0]
    link.rename(tmp_path / "victim")
    link.symlink_to("victim")
    assert_refused(command(*WRITERS[writer]), link.name)
    assert (link.is_symlink(), (tmp_path / "victim").read_bytes()) == (True, first[link.name])
    (tmp_path / "victim").replace(link)
    for name in written:
        (tmp_path / name).write_bytes(first[name] + b"\n")
        before = contents(tmp_path)
        assert_refused(command(*WRITERS[writer]), name)
        assert contents(tmp_path) == before
        (tmp_path / name).write_bytes(first[name])
    for left in [*(first.keys() - read), list_name()]:
        (tmp_path / left).unlink()
    for name in written:
        (tmp_path / name).write_text("mine")
        assert_refused(command(*WRITERS[writer]), name)
        assert contents(tmp_path).keys() == {*read, name}
        assert (tmp_path / name).read_text() == "mine"
        (tmp_path / name).unlink()


def test_a_sweep_takes_no_other_file_for_its_result(command: Command, tmp_path: Path) -> None:
    read = inputs(tmp_path)
    for name in ("run.toml", "x.nc"):
        (tmp_path / "x.nc").write_text("mine")
        before = contents(tmp_path)
        done = command(*WRITERS["sweep over one"][:-1], name)
        assert done == (2, "", f"hillobs: {name} cannot be read: it is no result of hillobs, or it is damaged\n")
        assert contents(tmp_path) == before
    assert before.keys() == {*read, "x.nc"}


def assert_refused(done: tuple[int, str, str], name: str) -> None:
    code, _, err = done
    assert (code, err) == (
        2,
        f"hillobs: {name} is there already, and not as hillobs wrote it; "
        "move it away, or name another folder with --out\n",
    )


def test_figures_write_over_no_other_file(command: Command, tmp_path: Path) -> None:
    inputs(tmp_path)
    command(*WRITERS["sweep over one"], "--no-figures")
    (tmp_path / "x-curves.pdf").write_text("mine")
    before = contents(tmp_path)
    assert_refused(command("figures", "x.nc", "--pdf"), "x-curves.pdf")
    assert contents(tmp_path) == before


def test_two_results_of_one_name_are_refused(command: Command, tmp_path: Path) -> None:
    """The measures of `x` are called as the time series of `x-measures`."""
    for name in ("x", "x-measures"):
        (tmp_path / f"{name}.toml").write_text('base = "paper-clean"\n')
    code, out, err = command("simulate", "x.toml", "x-measures.toml", "--out", "o")
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err.startswith("hillobs: two results would be called o/x-measures.csv")


# other names of a file
LEADS: dict[str, Callable[[Path, Path], None]] = {
    "a link": lambda given, product: given.symlink_to(product.name),
    "a link beyond a link": lambda given, product: (
        given.symlink_to("between"),
        given.with_name("between").symlink_to(product.absolute()),
    ),
    "a hard link": lambda given, product: os.link(product, given),
}


@pytest.mark.parametrize("how", LEADS)
@pytest.mark.parametrize("role", ["recording", "muscles", "mapping", "curves", "earlier estimates", "earlier scores"])
def test_what_an_estimate_reads_is_not_written_over(role: str, how: str, command: Command, tmp_path: Path) -> None:
    """Even where the file is what hillobs has written there: what is read is not lost."""
    inputs(tmp_path)
    words = list(WRITERS["estimate"])
    given = tmp_path / f"given{'.toml' if role in ('muscles', 'mapping') else '.csv'}"
    product = tmp_path / ("estimates-sliding_mode.sto" if role == "earlier estimates" else "estimates.csv")
    if role == "earlier scores":
        product = tmp_path / "scores.csv"
    if role == "muscles":
        product.write_bytes((tmp_path / "pair.toml").read_bytes())
        words[3] = given.name
    elif role == "mapping":
        product.write_text('position = "position_measured"\n')
        words += ["--map", given.name]
    elif role == "curves":
        product.write_bytes((DATA / "curves_millard_tables.csv").read_bytes())
        text = (tmp_path / "pair.toml").read_text().replace('"degroote_fregly2016"', '"given.csv"')
        # the numbers after v_max are those of the curves that are replaced
        (tmp_path / "pair.toml").write_text(text.partition("tendon_strain")[0])
    else:
        product.write_bytes((tmp_path / "short.csv").read_bytes())
        words[1] = given.name
    LEADS[how](given, product)
    enter(product)
    before = contents(tmp_path)
    code, out, err = command(*words)
    assert (code, out, err.count("\n")) == (2, "", 1)
    assert err == f"hillobs: {product.name} is read by this command and would be lost; name another folder with --out\n"
    assert contents(tmp_path) == before


def test_a_recording_of_our_own_is_not_written_over(command: Command, tmp_path: Path) -> None:
    """Estimates of estimates, in their folder."""
    inputs(tmp_path)
    assert command(*WRITERS["estimate"])[0] == 0
    before = contents(tmp_path)
    words = list(WRITERS["estimate"])
    for words[1] in ("estimates.sto", f"../{tmp_path.name}/estimates.sto"):
        code, _, err = command(*words)
        assert (code, err.partition(" and ")[0]) == (2, "hillobs: estimates.sto is read by this command")
        assert contents(tmp_path) == before


def enter(path: Path) -> None:
    """Enter a file into the list of what hillobs has written."""
    handle = os.open(path.parent, os.O_RDONLY)
    remember(handle, path.name, hashlib.sha256(path.read_bytes()).hexdigest())
    os.close(handle)
