"""The figures of observability can be read: nothing written lies on what is drawn."""

import numpy as np

from hillobs.studies.figures.observability import explanation
from hillobs.studies.observability.point import start_point
from hillobs.studies.observability.question import pose
from hillobs.studies.scenarios.prepare import prepare


def test_no_words_lie_on_a_curve():
    prepared = prepare("paper-clean", None, {})
    figure = explanation(pose(prepared, unknown="u", order=2), start_point(prepared))
    figure.draw_without_rendering()
    for axes in figure.axes:
        words = [text.get_window_extent() for text in axes.texts]
        if axes.get_legend() is not None:
            words += [text.get_window_extent() for text in axes.get_legend().get_texts()]
        assert words
        for curve in (line for line in axes.lines if len(line.get_xdata()) > 2):
            x, y = np.asarray(curve.get_xydata(), dtype=float).T
            # the curve between its points too
            fine = np.linspace(0, len(x) - 1, 20 * len(x))
            points = np.column_stack([np.interp(fine, np.arange(len(x)), values) for values in (x, y)])
            drawn = axes.transData.transform(points)
            assert not any(box.contains(*point) for box in words for point in drawn[:: len(drawn) // 2000 + 1])
