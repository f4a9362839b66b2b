"""Figures over time: errors, estimates, and the response of a sampled loop."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from numpy.typing import ArrayLike

from ..arguments import expect
from ..comparison import Comparison
from ..comparison.transients import from_start, transients
from ..observer import Observer
from ..plant import Plant
from .style import COLOURS, Look, squared, style, text, unit

FALL = 20  # times a transient falls at least, where its scale is logarithmic
DENSE = 200  # samples; points of more are drawn smaller


def error_variance(
    shown: Comparison | Mapping[str, Any],
    plant: Plant | None = None,
    state: str | int = 0,
    ax: Axes | None = None,
    *,
    start: int = 0,
    steps: int | None = None,
    names: Sequence[str] | None = None,
) -> Axes:
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
    names : sequence of str, optional
        What is estimated, where it is not the states; a comparison knows it.
    """
    ax = ax or plt.gca()
    if isinstance(shown, Comparison):
        names = shown.estimates
        plant, shown = shown.plant, transients(shown, steps)[0]
        if not shown:
            raise ValueError("the plant gives no P0 or no noise: there are no curves")
    expect(shown=shown, plant=plant)
    assert plant is not None  # which `expect` refuses
    curves: Mapping[str, Any] = shown
    if any(isinstance(one, Observer) for one in curves.values()):
        curves = from_start(curves, plant, steps)
    names = names or plant.state_names
    k = names.index(state) if isinstance(state, str) else state
    for i, (label, covariance) in enumerate(curves.items()):
        t = plant.dt * (start + np.arange(len(covariance)))
        variance = np.asarray(covariance)[:, k, k]
        ax.plot(t, variance, label=text(label), **style(i))
    name = names[k]
    _scale(ax, [np.asarray(X)[:, k, k] for X in curves.values()])
    ax.set(xlabel="time (s)", ylabel="error variance" + squared(name), title=text(name))
    return ax


def _scale(ax: Axes, variances: Sequence[np.ndarray]) -> None:
    """A logarithmic scale for transients that fall far, with the least steady level."""
    least = min(X.min() for X in variances)
    last = [X[-1] for X in variances if len(X) > 1 and X[-1] > 0.99 * X[-2]]
    if 0 < least < max(X.max() for X in variances) / FALL:
        ax.set_yscale("log")
        if last:
            ax.axhline(min(last), color="0.6", lw=0.8, zorder=0, label="steady level")
    else:
        ax.set_ylim(0, 1.05 * ax.dataLim.y1 or 1)  # a level curve off the frame


def sampled_response(
    run: Any, ax: Axes | None = None, *, output: str = "output"
) -> Axes:
    """Output of a sampled loop with its samples, and of the continuous loop.

    Parameters
    ----------
    run : sampling.Response
    output : str, default "output"
        What the output is called, with its unit: "angle (rad)".
    """
    ax = ax or plt.gca()
    t = np.union1d(np.linspace(0, run.duration, 400), run.t)
    _, y, y_star = run.at(t)
    ax.plot(t, y_star, label="continuous loop, y*", **style(1))
    ax.plot(t, y, label=f"sampled loop, {run.samples} samples", **style(0))
    ax.plot(run.t, run.y, "o", ms=4, color=COLOURS[0], label="at the samples")
    ax.set(xlabel="time (s)", ylabel=text(output))
    ax.legend(fontsize="small")
    return ax


def estimates(
    plant: Plant,
    time: ArrayLike,
    x: ArrayLike,
    std: ArrayLike | None,
    state: str | int = 0,
    ax: Axes | None = None,
    *,
    y: ArrayLike | None = None,
    label: str = "estimate",
    names: Sequence[str] | None = None,
) -> Axes:
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
    names : sequence of str, optional
        What is estimated, where it is not the states.
    """
    expect(plant=plant)
    ax = ax or plt.gca()
    names = names or plant.state_names
    k = names.index(state) if isinstance(state, str) else state
    middle = np.asarray(x)[:, k]
    if y is not None:  # below the band, and smaller the more there are
        size = 4.0 if len(middle) <= DENSE else 3.0
        ax.plot(time, y, ".", color="0.65", ms=size, mew=0, zorder=1, label="measured")
    ax.plot(time, middle, label=label, zorder=3, **style(0))
    if std is not None:
        band = np.asarray(std)[:, k]
        look: Look = dict(color=COLOURS[0], lw=0.6, zorder=2, label="one sigma")
        ax.fill_between(time, middle - band, middle + band, alpha=0.35, **look)
    name = names[k]
    ax.set(xlabel="time (s)", ylabel=text(unit(name)), title=text(name))
    return ax
