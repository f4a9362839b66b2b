"""Figures of designs side by side: error against work or order, and poles."""

from __future__ import annotations

from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.ticker import LogFormatter
from matplotlib.transforms import ScaledTranslation

from ..comparison import Comparison, Design, why_not
from ..observer import Observer
from ..plant import Plant
from ..show import number
from .style import COLOURS, MARKERS, Look, text

FAR = 100  # times the least error: no longer of interest beside the others
ALONG = {
    "work": "multiply-adds per step",
    "order": "order (observer states)",
    "settling": "settling time (s), to 1 % of a wrong start",
}


def pareto(table: Comparison, ax: Axes | None = None, *, by: str | None = None) -> Axes:
    """Error against work per step for every design of a comparison.

    The error is that of the worst state, its standard deviation over the Kalman
    filter's, or with `compare(scale=...)` the error in that scale.  Where no error is
    known it is the noise gain against the settling time.

    A marker for each method, a line through the front, whose designs show how many
    states they have, and a star beside the recommended design.  A design is on the
    front when none of the same or less work is more accurate.  Errors more than 100
    times the least are left out; the title counts them.  Under a budget designs that
    are beyond it are pale, and a line shows its limit where that is along the axis.

    Parameters
    ----------
    table : Comparison
    by : "work", "order" or "settling", optional
        Multiply-adds per step, observer states, or seconds until a wrong start has
        decayed to 1 %.  Default work, or settling where no error is known.
    """
    ax, front = ax or plt.gca(), table.pareto(by)
    by, what = table.along(by), table.judged_by
    if not front:
        reasons = " ".join(why_not(table))
        raise ValueError(f"no error is known, so nothing can be weighed. {reasons}")
    least = getattr(front[-1], what)
    highest = FAR * least if least > 0 else np.inf
    chosen = table.chosen
    if chosen is not None:  # under a small budget it may be far
        highest = max(highest, chosen.error)
    near = [one for one in table.judged if getattr(one, what) <= highest]
    line = [one for one in front if one in near]
    ax.step(*_points(line, by, what), where="post", color="0.6", lw=1, label="front")
    _markers(table, near, ax, by)
    _limit(table, ax, by)
    if chosen is not None:
        star = _points([one for one in near if one is chosen], by, what)
        beside = ScaledTranslation(-10 / 72, 0, ax.figure.dpi_scale_trans)
        look: Look = dict(label="recommended", clip_on=False)
        ax.plot(*star, "k*", ms=9, transform=ax.transData + beside, **look)
    _name(ax, line, by, what)
    said = [] if not table.budget.limits else [f"paler: beyond {table.budget}"]
    if beyond := len(table.judged) - len(near):
        said.append(f"not shown: {beyond} above {number(float(f'{highest:.1e}'))}")
    if said:
        ax.set_title("; ".join(said), fontsize="small")
    _label(table, ax, [getattr(one, what) for one in near], by)
    return ax


def _markers(table: Comparison, near: list[Design], ax: Axes, by: str) -> None:
    """A marker for each method, and pale ones beyond the budget."""
    what, budget = table.judged_by, table.budget
    for k, method in enumerate(dict.fromkeys(one.method for one in table)):
        look: Look = {"color": COLOURS[k % 6], "mfc": "none", "ls": ""}
        mine = [one for one in near if one.method == method]
        over = [one for one in mine if budget.over(one)]
        fit, label = [one for one in mine if one not in over], text(method)
        for designs, alpha in (fit, 1.0), (over, 0.35):
            if designs:
                points = _points(designs, by, what)
                ax.plot(*points, MARKERS[k % 6], alpha=alpha, label=label, **look)
                label = ""


def _limit(table: Comparison, ax: Axes, by: str) -> None:
    """The budget's limit, where it is one along the axis."""
    limit = table.budget.along(by)
    if limit is not None:
        ax.axvline(limit, label="budget", color="0.3", lw=1, ls="--")


def _name(ax: Axes, front: list[Design], by: str, what: str) -> None:
    """How many states the designs on the front have, beside their points.

    The last is written inwards, a line above that of the point before it.
    """
    look: Look = dict(textcoords="offset points", fontsize="x-small")
    for k, one in enumerate(front):
        at, last = (getattr(one, by), getattr(one, what)), len(front) - 1 == k > 0
        side: Look = dict(xytext=(-6, 16), ha="right") if last else {"xytext": (6, 5)}
        states = f"{one.order} state{'' if one.order == 1 else 's'}"
        ax.annotate(states, at, **look, **side)


def _label(table: Comparison, ax: Axes, errors: list[float], by: str) -> None:
    """Scales, labels and legend of the picture of `pareto`."""
    if max(errors) > 5 * min(errors) > 0:
        ax.set_yscale("log")
        ax.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(2, 0.5)))
        ax.yaxis.set_major_formatter(LogFormatter())
    if by != "settling":
        ax.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    ax.set(xlabel=ALONG[by], ylabel=table.judged_as)
    ax.legend(fontsize="small")


def _points(
    designs: list[Design], by: str, what: str
) -> tuple[list[float], list[float]]:
    return [getattr(one, by) for one in designs], [
        getattr(one, what) for one in designs
    ]


def poles(shown: Any, dt: float | None = None, ax: Axes | None = None) -> Axes:
    """Poles in the complex plane with the stability boundary.

    `shown` is a dict of poles, observers or plants by label, or one of them; of a
    Comparison the plant, the most accurate design and the recommended one, or all
    designs where none is recommended.  `dt` is needed where only numbers are given.
    """
    ax, groups = ax or plt.gca(), _groups(shown)
    for one in groups.values():
        dt = one.dt if dt is None and isinstance(one, Observer | Plant) else dt
    if dt is None:
        raise ValueError("give dt, 0 in continuous time: it says what is stable")
    if dt > 0:
        angle = np.linspace(0, 2 * np.pi, 200)
        ax.plot(np.cos(angle), np.sin(angle), color="0.6", lw=0.8)
    else:
        ax.axvline(0, color="0.6", lw=0.8)
    for k, (label, one) in enumerate(groups.items()):
        values = one.poles if isinstance(one, Observer) else one
        values = np.linalg.eigvals(one.A) if isinstance(one, Plant) else values
        values = np.ravel(np.asarray(values, complex))
        look: Look = dict(color=COLOURS[k % 6], mfc="none", ls="", ms=6 + 2 * (k % 3))
        ax.plot(values.real, values.imag, MARKERS[k % 6], label=text(label), **look)
    ax.set(xlabel="real part", ylabel="imaginary part")
    ax.set_aspect("equal" if dt > 0 else "auto")
    ax.legend(fontsize="small", loc="lower left" if dt > 0 else "best")
    return ax


def _groups(shown: Any) -> dict[str, Any]:
    if isinstance(shown, Comparison):
        best, chosen = shown.yardstick, shown.chosen
        if chosen is None:
            every = {one.title: one.observer for one in shown.designs}
            return {"plant": shown.plant} | every
        more = {} if best in (None, chosen) else {best.method: best.observer}
        return {"plant": shown.plant, "recommended": chosen.observer} | more
    if isinstance(shown, Observer | Plant):
        return {type(shown).__name__.lower(): shown}
    return shown
