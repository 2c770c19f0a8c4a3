"""What a figure shows, read back from it."""

from hillobs.model.symbols import SIGNALS
from hillobs.studies.figures.run import figures


def panels(figure, quantity):
    """The axes of a quantity, from left to right."""
    label = SIGNALS[quantity].symbol
    first = next(axes for axes in figure.axes if axes.get_ylabel() == label)
    row = first.get_subplotspec().rowspan.start
    return [axes for axes in figure.axes if axes.get_subplotspec().rowspan.start == row]


def line(axes, label):
    (found,) = [line for line in axes.lines if line.get_label() == label]
    return found


def shaded(axes):
    """The spans that are shaded, in time."""
    boxes = [patch.get_window_extent().transformed(axes.transData.inverted()) for patch in axes.patches]
    return sorted((box.x0, box.x1) for box in boxes)


def draw(dataset):
    """All figures, drawn to the last tick but not written; warnings are errors here."""
    drawn = figures(dataset)
    for figure in drawn.values():
        figure.draw_without_rendering()
    return drawn


def legend(figure):
    (only,) = figure.legends
    return [text.get_text() for text in only.get_texts()]
