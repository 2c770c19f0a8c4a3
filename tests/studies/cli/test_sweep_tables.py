"""The tables of a sweep: which rows and columns there are, and that they fit a terminal."""

import pytest
import xarray as xr

from hillobs.studies.cli.reports.sweep import tables
from hillobs.studies.sweep.run import sweep
from short_sweeps import SHORT, printed


def test_who_is_not_changed_is_said_to_be_so(line: xr.Dataset) -> None:
    optima, spreads = tables(line)
    assert all(text.startswith("HGO") for text in printed(optima)[2:] if text)
    rows = [text for text in printed(spreads) if text.startswith("SMO")]
    assert rows
    assert all(row.endswith("none") for row in rows)


@pytest.mark.parametrize("path", ["high_gain.eps_h", "sliding_mode.delta_s", "adaptive_sliding_mode.delta_a"])
def test_a_table_of_one_parameter_fits_a_terminal(path: str) -> None:
    swept = sweep("paper-noisy", {path: [1e-4, 0.1]}, changes=SHORT)
    for table in tables(swept):
        assert max(map(len, printed(table))) <= 80


def test_the_table_has_the_quantities_asked_for(line: xr.Dataset) -> None:
    table, spreads = tables(line.sel(quantity=["x1", "a2"]))
    headings = [str(column.header).replace("\n", " ") for column in table.columns]
    assert headings == ["", "quantity", "high_gain. eps_h", "median RMSE", "scenario's own", ""]
    for each in (table, spreads):
        assert list(each.columns[1].cells) == ["x1", "a2"]


ALONE = {"plant.m": [1.1]}
PAIR = {**ALONE, "high_gain.eps_h": [0.1]}


@pytest.mark.parametrize(("over", "kind"), [({}, "grid"), (ALONE, "grid"), (PAIR, "grid"), (PAIR, "zip")])
def test_axes_of_one_value_each_have_a_table_of_medians(over: dict[str, list[float]], kind: str) -> None:
    swept = sweep("paper-noisy", over, 2, ["high_gain"], SHORT, kind=kind)
    (table,) = tables(swept)
    assert [str(column.header) for column in table.columns] == ["", "quantity", "median RMSE"]
    assert len(printed(table)) > 1
