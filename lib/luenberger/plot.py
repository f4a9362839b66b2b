"""Figures.  Every function takes an optional Axes, draws on it and returns it.

Curves differ in line style and marker as well as in colour, so they can be told
apart in grey, and the colours are those of Okabe and Ito, told apart by most eyes.
"""

import matplotlib.pyplot as plt
import numpy as np

COLOURS = ("#0072B2", "#D55E00", "#009E73", "#CC79A7", "#E69F00", "#56B4E9")
DASHES = ("-", "--", ":", "-.", (0, (5, 1)), (0, (3, 1, 1, 1, 1, 1)))
MARKERS = ("o", "s", "^", "D", "v", "P")


def text(name):
    """A name of the user's as it is: no mathematics between dollar signs."""
    return name.replace("$", r"\$")


def style(k):
    """Colour and dashes of the k-th curve of a figure."""
    return {"color": COLOURS[k % 6], "linestyle": DASHES[k % 6]}


def error_variance(covariances, plant, state=0, ax=None, *, start=0):
    """Error variance of one state against time, a curve for each design.

    Parameters
    ----------
    covariances : dict of str to (N, n, n) ndarray
        A label and the error covariances over time, as `error_covariance` gives
        them with `steps`.
    plant : Plant
    state : int or str, default 0
        Which state, by index or by name.
    ax : Axes, optional
    start : int, default 0
        The instant that row 0 belongs to.
    """
    ax = ax or plt.gca()
    k = plant.state_names.index(state) if isinstance(state, str) else state
    for i, (label, covariance) in enumerate(covariances.items()):
        t = plant.dt * (start + np.arange(len(covariance)))
        ax.plot(t, np.asarray(covariance)[:, k, k], label=label, **style(i))
    ax.set_ylim(bottom=0)
    ax.set(xlabel="time (s)", ylabel="error variance", title=text(plant.state_names[k]))
    return ax


def sampled_response(run, ax=None):
    """Output of a sampled loop with its samples, and of the continuous loop.

    Parameters
    ----------
    run : sampling.Response
    ax : Axes, optional
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


def pareto(survey, ax=None):
    """Error trace against order for every design of a survey, the front marked.

    A design is on the front when none of lower order has a smaller trace.
    """
    ax = ax or plt.gca()
    designs, front = survey.designs, survey.pareto()
    ax.plot(
        *_order_and_trace(designs), "o", color="0.55", mfc="none", label="all designs"
    )
    ax.plot(*_order_and_trace(front), "s-", color=COLOURS[0], label="Pareto front")
    chosen = survey.recommended()
    ax.plot(
        *_order_and_trace([chosen]), "*", ms=15, color=COLOURS[1], label="recommended"
    )
    traces = [design.trace for design in designs]
    if max(traces) > 20 * min(traces) > 0:
        ax.set_yscale("log")
    ax.xaxis.set_major_locator(plt.MaxNLocator(integer=True))
    ax.set(xlabel="order (observer states)", ylabel="error trace")
    ax.legend()
    return ax


def cost_against_order(costs, ax=None, *, least=None):
    """Error cost against the number of filter states, a curve for each kind of filter.

    Parameters
    ----------
    costs : dict of str to dict of int to float
        A label, and for each order the cost of its filter.
    ax : Axes, optional
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


def _order_and_trace(designs):
    return [d.order for d in designs], [d.trace for d in designs]


def estimates(plant, time, x, std, state=0, ax=None, *, y=None, label="estimate"):
    """One estimated state against time with its one-sigma band.

    Parameters
    ----------
    plant : Plant
    time : (N,) array_like
        Seconds.
    x, std : (N, n) array_like
        Estimates and their standard deviations.
    state : int or str, default 0
    ax : Axes, optional
    y : (N,) array_like, optional
        A measurement of this very state, drawn as points.
    """
    ax = ax or plt.gca()
    k = plant.state_names.index(state) if isinstance(state, str) else state
    middle, band = np.asarray(x)[:, k], np.asarray(std)[:, k]
    if y is not None:
        ax.plot(time, y, ".", color="0.5", ms=4, label="measured")
    ax.plot(time, middle, label=label, **style(0))
    ax.fill_between(
        time,
        middle - band,
        middle + band,
        color=COLOURS[0],
        alpha=0.25,
        lw=0,
        label="one sigma",
    )
    ax.set(xlabel="time (s)", title=text(plant.state_names[k]))
    return ax


def gains(K, plant, ax=None, *, start=1):
    """Every gain against time, K of shape (N, n, p), or as bars when K is (n, p)."""
    ax = ax or plt.gca()
    K = np.asarray(K)
    if K.ndim == 2:
        return _gain_bars(K, plant, ax)
    t = plant.dt * (start + np.arange(len(K)))
    for j, output in enumerate(plant.output_names):
        for i, state in enumerate(plant.state_names):
            curve = style(i) | {"marker": MARKERS[j % 6], "markevery": 0.2}
            ax.plot(t, K[:, i, j], label=text(f"{state} from {output}"), **curve)
    ax.set(xlabel="time (s)", ylabel="gain")
    ax.legend(fontsize="small")
    return ax


def _gain_bars(K, plant, ax):
    n, p = K.shape
    wide = 0.8 / max(p, 1)
    hatches = ("", "//", "..", "xx", "\\\\", "--")
    for j, output in enumerate(plant.output_names):
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
    turned = sum(map(len, plant.state_names)) > 20
    ax.set_xticks(range(n), [text(name) for name in plant.state_names])
    if turned:
        ax.tick_params(axis="x", rotation=30)
        plt.setp(ax.get_xticklabels(), ha="right")
    ax.set(ylabel="gain")
    if p:
        ax.legend(fontsize="small")
    return ax


def poles(groups, dt, ax=None):
    """Poles in the complex plane with the stability boundary, `groups` by label."""
    ax = ax or plt.gca()
    if dt > 0:
        angle = np.linspace(0, 2 * np.pi, 200)
        ax.plot(np.cos(angle), np.sin(angle), color="0.6", lw=0.8)
    else:
        ax.axvline(0, color="0.6", lw=0.8)
    for k, (label, values) in enumerate(groups.items()):
        values = np.asarray(values, complex)
        ax.plot(
            values.real,
            values.imag,
            MARKERS[k % 6],
            color=COLOURS[k % 6],
            mfc="none",
            label=label,
        )
    ax.set(xlabel="real part", ylabel="imaginary part")
    ax.set_aspect("equal" if dt > 0 else "auto")
    ax.legend(fontsize="small")
    return ax


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
