"""A figure of designs on the plants that there may be."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ..comparison import NOMINAL, Comparison, Design
from .style import COLOURS, MARKERS, Look, style, text

QUARTILES = (0.0, 0.25, 0.5, 0.75, 1.0)


def robustness(found: Comparison, ax: Axes | None = None) -> Axes:
    """The error of each design on each plant that there may be.

    Where one parameter is varied, as the names of `vary` say, a curve for each design
    against its value.  Otherwise a row for each design: a line from the least error to
    the largest, a bar between the quartiles, a tick at the median.  A marker shows the
    worst case, a filled one that of the recommended design.  Where an error grows
    without bound there is no point, and the name of the design says so.

    Parameters
    ----------
    found : Comparison
    """
    ax = ax or plt.gca()
    known = [one for one in found.ranked if np.isfinite(_errors(one)).any()]
    if not known:
        raise ValueError("no design has a known, finite error on any plant")
    names, values = _varied(found)
    if len(names) == 1:
        _against(found, known, names.pop(), values, ax)
    else:
        _rows(found, known, ax)
    return ax


def _errors(one: Design) -> np.ndarray:
    return np.array(list(one.errors.values()), dtype=float)


def _varied(found: Comparison) -> tuple[set[str], dict[str, float]]:
    """The names of what is varied, and of each plant the value of the first of them."""
    names: set[str] = set()
    values: dict[str, float] = {}
    for plant in found.plants:
        if plant == NOMINAL:
            continue
        pairs = [part.rpartition(" = ") for part in plant.split(", ")]
        names |= {name or plant for name, _, _ in pairs}
        try:
            values[plant] = float(pairs[0][2])
        except ValueError:
            return set(), {}
    return names, values


def _label(found: Comparison) -> str:
    if found.scale is not None:
        return "error in the given scale"
    what = "worst state" if found.rows is None else "L x"
    return f"error of {what} / own Kalman filter's"


def _named(one: Design) -> str:
    grows = len(one.growing)
    plural = "" if grows == 1 else "s"
    return text(one.name) + (f" (grows on {grows} plant{plural})" if grows else "")


def _against(
    found: Comparison,
    known: list[Design],
    name: str,
    values: dict[str, float],
    ax: Axes,
) -> None:
    """A curve for each design over the one parameter that is varied."""
    for k, one in enumerate(known):
        points = sorted((value, one.errors[plant]) for plant, value in values.items())
        x, errors = np.array(points, dtype=float).T
        ax.plot(x, np.where(np.isfinite(errors), errors, np.nan), **style(k))
        worst = max((p for p in points if np.isfinite(p[1])), key=lambda p: p[1])
        filled = COLOURS[k % 6] if one is found.chosen else "none"
        look: Look = dict(color=COLOURS[k % 6], mfc=filled, ls=style(k)["linestyle"])
        ax.plot(*worst, MARKERS[k % 6], label=_named(one), **look)
    ax.set(xlabel=text(name), ylabel=_label(found))
    ax.legend(fontsize="small")


def _rows(found: Comparison, known: list[Design], ax: Axes) -> None:
    """A row for each design: its least, quartiles, median and largest error."""
    highest = []
    for k, one in enumerate(known):
        errors = _errors(one)
        parts = np.quantile(errors, QUARTILES, method="inverted_cdf")
        low, first, middle, third, _ = np.where(np.isfinite(parts), parts, np.nan)
        colour, high = COLOURS[k % 6], errors[np.isfinite(errors)].max()
        highest.append(high)
        said = ("all plants", "quartiles", "median", "worst") if k == 0 else 4 * ("",)
        all_of, between, half, worst = said
        ax.plot([low, high], [k, k], color=colour, lw=1, label=all_of)
        ax.plot([first, third], [k, k], color=colour, lw=5, alpha=0.5, label=between)
        ax.plot(middle, k, "|", color=colour, ms=10, label=half)
        filled = colour if one is found.chosen else "none"
        ax.plot(high, k, MARKERS[k % 6], color=colour, mfc=filled, label=worst)
    ax.set_yticks(range(len(known)), [_named(one) for one in known], fontsize="small")
    ax.invert_yaxis()
    if max(highest) > 5 * min(_errors(one).min() for one in known) > 0:
        ax.set_xscale("log")
    ax.set(xlabel=_label(found))
    ax.legend(fontsize="small")
