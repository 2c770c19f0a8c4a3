"""The figure of errors over the delay: a line and a bound for each, over all lags from none on."""

import numpy as np

from hillobs.studies.figures.lag import lag_figure

LAGS = np.array([0, 0.005, 0.05])


def test_each_line_ends_at_or_above_its_bound() -> None:
    panels = {"of a": {"u": ([3.0, 2.0, 1.5], 1.0), "a": ([2.0, 1.0, 0.6], 0.5)}, "of v": {"u": ([9.0, 7, 6], 5.0)}}
    left, right = lag_figure(LAGS, panels).axes
    assert [axes.get_ylabel() for axes in (left, right)] == list(panels)
    lines = {line.get_label(): line for line in left.lines if not str(line.get_label()).startswith("_")}
    bounds = [line for line in left.lines if line.get_linestyle() == ":"]
    assert list(lines) == ["u", "a"]
    for line, bound in zip(lines.values(), bounds, strict=True):
        np.testing.assert_allclose(line.get_xdata(), [0, 5, 50])  # ms
        assert line.get_color() == bound.get_color()
        assert min(line.get_ydata()) > bound.get_ydata()[0]
    assert left.get_xlim()[0] < 0 < 50 < left.get_xlim()[1]
