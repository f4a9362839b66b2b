"""A figure of designs on the plants that there may be."""

from __future__ import annotations

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ..compare import Robustness, Spread
from .style import COLOURS, MARKERS, Look, style, text


def robustness(found: Robustness, ax: Axes | None = None) -> Axes:
    """The error of each design on each plant that there may be.

    Where one parameter is varied, a curve for each design against its value.
    Otherwise a row for each design: a line from the least error to the largest, a bar
    between the quartiles, a tick at the median.  A marker shows the worst case, a
    filled one that of the recommended design.  Where an error grows without bound
    there is no point, and the name of the design says so.

    Parameters
    ----------
    found : Robustness
    """
    ax = ax or plt.gca()
    names = list(found.plants[-1].values)
    known = [one for one in found if one.known and np.isfinite(one.errors).any()]
    if not known:
        raise ValueError("no design has a known, finite error on any plant")
    if len(names) == 1:
        _against(found, known, names[0], ax)
    else:
        _rows(found, known, ax)
    return ax


def _label(found: Robustness) -> str:
    if found.scale is not None:
        return "error in the given scale"
    what = "worst state" if found.whole else "k x"
    return f"error of {what} / own Kalman filter's"


def _named(one: Spread) -> str:
    grows = len(one.growing)
    plural = "" if grows == 1 else "s"
    return text(one.name) + (f" (grows on {grows} plant{plural})" if grows else "")


def _against(found: Robustness, known: list[Spread], name: str, ax: Axes) -> None:
    """A curve for each design over the one parameter that is varied."""
    for k, one in enumerate(known):
        points = [(case.values[name], case.error) for case in one.cases if case.values]
        values, errors = np.array(sorted(points)).T
        ax.plot(values, np.where(np.isfinite(errors), errors, np.nan), **style(k))
        worst = max((p for p in points if np.isfinite(p[1])), key=lambda p: p[1])
        filled = COLOURS[k % 6] if one is found.chosen else "none"
        look: Look = dict(color=COLOURS[k % 6], mfc=filled, ls=style(k)["linestyle"])
        ax.plot(*worst, MARKERS[k % 6], label=_named(one), **look)
    ax.set(xlabel=text(name), ylabel=_label(found))
    ax.legend(fontsize="small")


def _rows(found: Robustness, known: list[Spread], ax: Axes) -> None:
    """A row for each design: its least, quartiles, median and largest error."""
    for k, one in enumerate(known):
        finite = np.isfinite(one.quartiles)
        low, first, middle, third, _ = np.where(finite, one.quartiles, np.nan)
        colour, high = COLOURS[k % 6], _highest(one)
        said = ("all plants", "quartiles", "median", "worst") if k == 0 else 4 * ("",)
        all_of, between, half, worst = said
        ax.plot([low, high], [k, k], color=colour, lw=1, label=all_of)
        ax.plot([first, third], [k, k], color=colour, lw=5, alpha=0.5, label=between)
        ax.plot(middle, k, "|", color=colour, ms=10, label=half)
        filled = colour if one is found.chosen else "none"
        ax.plot(high, k, MARKERS[k % 6], color=colour, mfc=filled, label=worst)
    ax.set_yticks(range(len(known)), [_named(one) for one in known], fontsize="small")
    ax.invert_yaxis()
    if max(map(_highest, known)) > 5 * min(one.errors.min() for one in known) > 0:
        ax.set_xscale("log")
    ax.set(xlabel=_label(found))
    ax.legend(fontsize="small")


def _highest(one: Spread) -> float:
    """The largest finite error."""
    return one.errors[np.isfinite(one.errors)].max()
