"""How curves, text and panels look: each told apart in grey and by most eyes."""

from typing import Any

import matplotlib.pyplot as plt
from matplotlib.axes import Axes

from ..show import unit as unit

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", "--", ":", "-.", (0, (5, 1)), (0, (3, 1, 1, 1, 1, 1)))
MARKERS = ("o", "s", "^", "D", "v", "P")
Look = dict[str, Any]  # of a curve: what matplotlib takes by keyword


def text(name: str) -> str:
    """A name of the user's as it is: no mathematics between dollar signs."""
    return name.replace("$", r"\$")


def squared(name: str) -> str:
    """The unit of a variance, as it is written behind a word.

    >>> squared("position (m)"), squared("velocity (m/s)"), squared("x1")
    (' (m²)', ' ((m/s)²)', '')
    """
    one = text(unit(name))
    if not one:
        return ""
    return f" ({one}²)" if one.isalpha() else f" (({one})²)"


def style(k: int) -> Look:
    """Colour and dashes of the k-th curve of a figure."""
    return {"color": COLOURS[k % 6], "linestyle": DASHES[k % 6]}


def panels(
    count: int, *, columns: int = 3, height: float = 2.0, width: float = 8.0
) -> list[Axes]:
    """A figure of `count` small panels; returns the panels, none for count = 0."""
    if count == 0:
        return []
    columns = min(columns, count)
    rows = -(-count // columns)
    size = (width, height * rows + 0.4)
    _, axes = plt.subplots(
        rows, columns, figsize=size, squeeze=False, layout="constrained"
    )
    for ax in axes.flat[count:]:
        ax.remove()
    return list(axes.flat[:count])
