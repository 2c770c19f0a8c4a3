"""`hillobs estimate`: activations and more from a recording."""

from __future__ import annotations

import contextlib
import itertools
import json
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import click
import xarray as xr

from ..estimate.files import SHEET, STEM, estimate_paths, refuse_replacing, report_path, save_again, save_estimates
from ..estimate.run import KALMAN, compile_observers
from ..estimate.run import estimate as estimated
from ..estimate.scores import scores
from ..files.pictures import figure_paths
from ..files.quote import escaped
from ..files.writing import writable_folder, write_whole
from ..kalman.run import AUTO, FORMS
from ..laboratory.mapping import read_mapping
from ..laboratory.recording import read_recording
from ..scenarios.layers import Value
from ..scenarios.observers import observers_named
from ..verdict.run import judged
from .reports.estimates.estimate import failures, notes, score_table, timing
from .reports.estimates.estimate_page import estimate_page
from .reports.estimates.verdict import answer, sentences
from .reports.written import written
from .shell.options import (
    corrected_option,
    doubt_option,
    mapping_option,
    observer_option,
    seconds_option,
    set_option,
    whole_option,
)
from .shell.own_observers import loaded
from .shell.progress import bar
from .shell.stopping import Stopped
from .shell.subjects import subject_asked_for, subject_options
from .shell.tables import print_table
from .shell.terminal import NUMERICAL, complain, say

_KALMAN_TOO = "--observer kalman also says what noise leaves open, smooths, and judges recording and muscles"


@click.command()
@click.argument("recording", metavar="RECORDING")
@subject_options()
@observer_option()
@corrected_option(default=True)
@mapping_option()
@set_option("A gain by hand: high_gain.eps_h=0.05.")
@doubt_option()
@click.option("--no-doubt", is_flag=True, help="Numbers are right, but for those of --doubt.")
@click.option("--smooth", is_flag=True, help="Estimates know all samples, later ones too: the Kalman filter alone can.")
@seconds_option("--lag", "Its estimates may be so late, to know the samples until then: 20ms.")
@click.option(
    "--form",
    type=click.Choice(FORMS),
    default=AUTO,
    show_default=True,
    help="What its unknowns are: inputs u or activations a.",
)
@click.option("--no-verdict", is_flag=True, help="Do not ask whether recording and muscles can be believed.")
@click.option(
    "--json", "as_json", is_flag=True, help="Verdict, scores and files as JSON; words go to the error stream."
)
@whole_option("--every", 1, "Keep the estimates of every Nth sample.", default=1)
@click.option("--out", default="estimates", show_default=True, metavar="DIR", help="Where estimates are written.")
@click.option("--no-figures", is_flag=True, help="Write no figures.")
@click.option("--report", is_flag=True, help="Write a page for a browser too: figure, scores, settings, in one file.")
def estimate(
    recording: str,
    muscles: str | None,
    mechanism: str | None,
    observers: tuple[str, ...],
    corrected: bool,
    maps: tuple[str, ...],
    changes: dict[str, Value],
    doubt: dict[str, float | str],
    no_doubt: bool,
    smooth: bool,
    lag: float,
    form: str,
    no_verdict: bool,
    as_json: bool,
    every: int,
    out: str,
    no_figures: bool,
    report: bool,
) -> None:
    """Estimate velocity, lengths, activations and disturbance from RECORDING: CSV, .sto or .mot, also gzipped.

    It needs time, positions and tendon forces. If it has the truth too, the estimates are scored.
    """
    folder = writable_folder(Path(out))
    chosen, subject, mapping = loaded(observers), subject_asked_for(muscles, mechanism), read_mapping(maps)
    times = [time.monotonic()]
    with bar("reading") as progress:
        read = read_recording(recording, mapping, progress, subject.columns)
    times.append(time.monotonic())
    sheet = [] if no_figures else [SHEET]
    paths = estimate_paths(folder, tuple(observers_named(chosen)), bool(read.true))
    refuse_replacing(folder, [*paths, *figure_paths(folder, STEM, sheet), *[report_path(folder)] * report])
    with bar("following") as progress:
        compile_observers(subject, chosen, corrected)
        # following ends with its last progress: making a Dataset imports half of dask, which no observer costs
        times += [time.monotonic()] * 2

        def advance(done: float) -> None:
            times[-1] = time.monotonic()
            progress(done)

        dataset = estimated(
            read,
            subject,
            chosen,
            None,
            corrected,
            changes,
            every,
            advance,
            form,
            smooth,
            lag,
            doubt,
            not no_doubt,
        )
    reading, building, following = (after - before for before, after in itertools.pairwise(times))
    known, found = scores(dataset), None
    with bar("writing") as progress:
        # first of all: what is said of estimates may take longer than they did
        paths = save_estimates(dataset, known, folder, progress)
        picture, files = _drawn(dataset, folder, not no_figures, report)
        paths += files
    say(*notes(dataset), timing(dataset, reading, building, following), err=as_json)
    if chosen is None:
        say(_KALMAN_TOO, err=as_json)
    if KALMAN in dataset.observer and not no_verdict:
        with _noting_what_is_kept(folder), bar("weighing") as progress:
            found = judged(read, subject, dataset, progress)
        dataset.attrs |= {"quality": found.quality, "verdict": json.dumps(found.as_dict())}
        with bar("writing"):
            save_again(dataset, folder)
        say("", *sentences(found), err=as_json)
    if report:
        lines = list(sentences(found)) if found else []
        write_whole(report_path(folder), estimate_page(dataset, known, lines, picture))
        paths.append(report_path(folder))
    if as_json:
        say(*answer(found, known, paths).split("\n"))
    elif known:
        say("")
        print_table(score_table(known))
    say(written(paths), err=as_json)
    ended = list(failures(dataset))
    for sentence in ended:
        complain(sentence)
    if ended:
        sys.exit(NUMERICAL)


def _drawn(dataset: xr.Dataset, folder: Path, figures: bool, report: bool) -> tuple[bytes, list[Path]]:
    """The sheet as a PNG for the report, and the files that it was written to, each if it is wanted."""
    if not figures and not report:
        return b"", []
    from ..figures.estimate import estimate_sheet  # here, since matplotlib takes as long to come as a run
    from ..figures.page import content, write_figures

    sheet = estimate_sheet(dataset)
    paths = write_figures({SHEET: sheet}, folder, STEM) if figures else []
    return content(sheet, "png") if report else b"", paths


@contextlib.contextmanager
def _noting_what_is_kept(folder: Path) -> Iterator[None]:
    """A signal that comes while estimates are judged is noted where they are."""
    try:
        yield
    except Stopped as stopped:
        stopped.add_note(escaped(f"the estimates are in {folder}, without a verdict"))
        raise
