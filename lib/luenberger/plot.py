"""Figures.  Every function takes an optional Axes, draws on it and returns it.

Curves differ in line style and marker as well as in colour, so they can be told
apart in grey, and the colours are those of Okabe and Ito, told apart by most eyes.
"""

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.ticker import LogFormatter

from .arguments import expect
from .compare import METHODS, Comparison, from_start, transients
from .observer import Observer
from .plant import Plant
from .show import number

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", "--", ":", "-.", (0, (5, 1)), (0, (3, 1, 1, 1, 1, 1)))
MARKERS = ("o", "s", "^", "D", "v", "P")
FAR = 100  # times the least error: no longer of interest beside the others


def text(name):
    """A name of the user's as it is: no mathematics between dollar signs."""
    return name.replace("$", r"\$")


def style(k):
    """Colour and dashes of the k-th curve of a figure."""
    return {"color": COLOURS[k % 6], "linestyle": DASHES[k % 6]}


def error_variance(shown, plant=None, state=0, ax=None, *, start=0, steps=None):
    """Error variance of one state against time, a curve for each design.

    Parameters
    ----------
    shown : dict or Comparison
        By label, error covariances over time of shape (N, n, n), as
        `error_covariance` gives them with `steps`, or observers.  Or a `Comparison`:
        its most accurate and its recommended design, from the start on.
    plant : Plant
        May be left out with a `Comparison`.
    state : int or str, default 0
        Which state, by index or by name.
    start : int, default 0
        The instant that row 0 of a covariance belongs to.  Observers and a comparison
        start from P0 at instant 0.
    steps : int, optional
        Of observers and of a comparison; default until their errors have settled.
    """
    ax = ax or plt.gca()
    if isinstance(shown, Comparison):
        plant = shown.plant
        shown = transients(shown, steps)[0]
        if not shown:
            raise ValueError("the plant gives no P0 or no noise: there are no curves")
    expect(shown=shown, plant=plant)
    curves = shown
    if any(isinstance(one, Observer) for one in shown.values()):
        curves = from_start(shown, plant, steps)
    k = plant.state_names.index(state) if isinstance(state, str) else state
    for i, (label, covariance) in enumerate(curves.items()):
        t = plant.dt * (start + np.arange(len(covariance)))
        variance = np.asarray(covariance)[:, k, k]
        ax.plot(t, variance, label=text(label), **style(i))
    ax.set_ylim(0, 1.05 * ax.dataLim.y1 or 1)  # a level curve off the frame
    ax.set(xlabel="time (s)", ylabel="error variance", title=text(plant.state_names[k]))
    return ax


def sampled_response(run, ax=None):
    """Output of a sampled loop with its samples, and of the continuous loop.

    Parameters
    ----------
    run : sampling.Response
    """
    ax = ax or plt.gca()
    t = np.union1d(np.linspace(0, run.duration, 400), run.t)
    _, y, y_star = run.at(t)
    ax.plot(t, y_star, label="continuous loop, y*", **style(1))
    ax.plot(t, y, label=f"sampled loop, {run.samples} samples", **style(0))
    ax.plot(run.t, run.y, "o", ms=4, color=COLOURS[0])
    ax.set(xlabel="time (s)", ylabel="output")
    ax.legend(fontsize="small")
    return ax


def pareto(table, ax=None, *, by="work"):
    """Error against work per step for every design of a comparison.

    A marker for each method, a line through the front, and a star on the recommended
    design.  A design is on the front when none of the same or less work is more
    accurate.  Errors more than 100 times the least are left out; the title counts them.

    Parameters
    ----------
    table : Comparison
    by : "work" or "order"
        Multiply-adds per step, or observer states.
    """
    ax, front = ax or plt.gca(), table.pareto(by)
    if not front:
        raise ValueError("no error is known, so there is nothing to weigh work against")
    highest = FAR * front[-1].error if front[-1].error > 0 else np.inf
    near = [one for one in table.ranked if one.error <= highest]
    line = [one for one in front if one.error <= highest]
    ax.step(*_points(line, by), where="post", color="0.6", lw=1, label="front")
    for k, method in enumerate(METHODS):
        points = _points([one for one in near if one.method == method], by)
        look = {"color": COLOURS[k % 6], "mfc": "none", "ls": ""}
        if points[0]:
            ax.plot(*points, MARKERS[k % 6], label=method, **look)
    chosen = [one for one in [table.recommended()] if one in near]
    ax.plot(*_points(chosen, by), "k*", ms=13, mfc="none", label="recommended")
    errors = [one.error for one in near]
    if max(errors) > 5 * min(errors) > 0:
        ax.set_yscale("log")
        ax.yaxis.set_minor_formatter(LogFormatter(minor_thresholds=(2, 0.5)))
        ax.yaxis.set_major_formatter(LogFormatter())
    beyond = len(table.ranked) - len(near)
    if beyond:
        limit = number(float(f"{highest:.1e}"))
        ax.set_title(f"not shown: {beyond} above {limit}", fontsize="small")
    ax.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    along = {"work": "multiply-adds per step", "order": "order (observer states)"}
    error = "error trace" if table.k is None else "error variance of k x"
    ax.set(xlabel=along[by], ylabel=error)
    ax.legend(fontsize="small")
    return ax


def _points(designs, by):
    return [getattr(one, by) for one in designs], [one.error for one in designs]


def cost_against_order(costs, ax=None, *, least=None):
    """Error cost against the number of filter states, a curve for each kind of filter.

    Parameters
    ----------
    costs : dict of str to dict of int to float
        A label, and for each order the cost of its filter.
    least : float, optional
        A cost that no order goes below, that of the Kalman filter; a level line.
    """
    ax = ax or plt.gca()
    for k, (label, found) in enumerate(costs.items()):
        orders = sorted(found)
        curve = style(k) | {"marker": MARKERS[k % 6], "mfc": "none"}
        ax.plot(orders, [found[order] for order in orders], label=text(label), **curve)
    if least is not None:
        ax.axhline(least, color="0.6", lw=0.8, label="least of any order")
    ax.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    ax.set(xlabel="order (observer states)", ylabel="error cost")
    ax.legend(fontsize="small")
    return ax


def estimates(plant, time, x, std, state=0, ax=None, *, y=None, label="estimate"):
    """One estimated state against time with its one-sigma band.

    Parameters
    ----------
    plant : Plant
    time : (N,) array_like
        Seconds.
    x, std : (N, n) array_like
        Estimates and their standard deviations; std may be None.
    state : int or str, default 0
    y : (N,) array_like, optional
        A measurement of this very state, drawn as points.
    """
    expect(plant=plant)
    ax = ax or plt.gca()
    k = plant.state_names.index(state) if isinstance(state, str) else state
    middle = np.asarray(x)[:, k]
    if y is not None:
        ax.plot(time, y, ".", color="0.5", ms=4, label="measured")
    ax.plot(time, middle, label=label, **style(0))
    if std is not None:
        band = np.asarray(std)[:, k]
        look = {"color": COLOURS[0], "alpha": 0.25, "lw": 0, "label": "one sigma"}
        ax.fill_between(time, middle - band, middle + band, **look)
    ax.set(xlabel="time (s)", title=text(plant.state_names[k]))
    return ax


def gains(shown, plant=None, ax=None, *, start=1):
    """Every gain against time, or as bars where it is constant.

    `shown` is K of shape (N, n, p) or (n, p); of an observer its V, how strongly each
    output moves each estimate when it is measured; of a Comparison, which knows its
    plant, the V of the recommended design.  Row 0 belongs to instant `start`.
    """
    ax = ax or plt.gca()
    if isinstance(shown, Comparison):
        plant, shown = shown.plant, shown.recommended().observer
    expect(shown=shown, plant=plant)
    K, rows = np.asarray(shown.V if isinstance(shown, Observer) else shown), None
    if isinstance(shown, Observer) and not np.array_equal(shown.L, np.eye(plant.n)):
        rows = [f"row {k + 1} of k x" for k in range(len(shown.L))]
    rows = rows or plant.state_names
    if K.ndim == 2:
        return _gain_bars(K, rows, plant.output_names, ax)
    t = plant.dt * (start + np.arange(len(K)))
    for j, output in enumerate(plant.output_names):
        for i, row in enumerate(rows):
            curve = style(i) | {"marker": MARKERS[j % 6], "markevery": 0.2}
            ax.plot(t, K[:, i, j], label=text(f"{row} from {output}"), **curve)
    ax.set(xlabel="time (s)", ylabel="gain")
    ax.legend(fontsize="small")
    return ax


def _gain_bars(K, rows, outputs, ax):
    n, p = K.shape
    wide = 0.8 / max(p, 1)
    hatches = ("", "//", "..", "xx", "\\\\", "--")
    for j, output in enumerate(outputs):
        where = np.arange(n) + wide * (j - (p - 1) / 2)
        ax.bar(
            where,
            K[:, j],
            wide,
            color=COLOURS[j % 6],
            hatch=hatches[j % 6],
            edgecolor="white",
            label=text(f"from {output}"),
        )
    ax.axhline(0, color="0.3", lw=0.8)
    turned = sum(map(len, rows)) > 20
    ax.set_xticks(range(n), [text(name) for name in rows])
    if turned:
        ax.tick_params(axis="x", rotation=30)
        plt.setp(ax.get_xticklabels(), ha="right")
    ax.set(ylabel="gain")
    if p:
        ax.legend(fontsize="small")
    return ax


def poles(shown, dt=None, ax=None):
    """Poles in the complex plane with the stability boundary.

    `shown` is a dict of poles, observers or plants by label, or one of them; of a
    Comparison the plant, the most accurate design and the recommended one.  `dt` is
    needed where only numbers are given.
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
        look = {"color": COLOURS[k % 6], "mfc": "none", "ls": "", "ms": 6 + 2 * (k % 3)}
        ax.plot(values.real, values.imag, MARKERS[k % 6], label=text(label), **look)
    ax.set(xlabel="real part", ylabel="imaginary part")
    ax.set_aspect("equal" if dt > 0 else "auto")
    ax.legend(fontsize="small", loc="lower left" if dt > 0 else "best")
    return ax


def _groups(shown):
    if isinstance(shown, Comparison):
        best, chosen = shown.yardstick, shown.recommended()
        more = {} if best in (None, chosen) else {best.method: best.observer}
        return {"plant": shown.plant, "recommended": chosen.observer} | more
    if isinstance(shown, Observer | Plant):
        return {type(shown).__name__.lower(): shown}
    return shown


def panels(count, *, columns=3, height=2.0, width=8.0):
    """A figure of `count` small panels; returns the panels, none for count = 0."""
    if count == 0:
        return []
    columns = min(columns, count)
    rows = -(-count // columns)
    _, axes = plt.subplots(
        rows,
        columns,
        figsize=(width, height * rows + 0.4),
        squeeze=False,
        layout="constrained",
    )
    for ax in axes.flat[count:]:
        ax.remove()
    return list(axes.flat[:count])
