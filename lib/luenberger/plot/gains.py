"""Gains of an observer or a filter: a panel for each unit, curves or bars."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.gridspec import GridSpecFromSubplotSpec
from numpy.typing import ArrayLike

from ..arguments import expect
from ..comparison import Comparison
from ..observer import Observer
from ..plant import Plant
from .style import COLOURS, MARKERS, Look, style, text, unit

HATCHES = ("", "//", "..", "xx", "\\\\", "--")
ACROSS = 3  # panels beside one another
Place = tuple[int, int]  # row and column of a gain


def gains(
    shown: ArrayLike | Observer | Comparison,
    plant: Plant | None = None,
    ax: Axes | None = None,
    *,
    start: int = 1,
) -> Axes:
    """Every gain against time, or as bars where it is constant; a panel for each unit.

    Units of which all gains are zero have no panel.

    Parameters
    ----------
    shown : array_like, Observer or Comparison
        K of shape (N, n, p) or (n, p); of an observer its V, how strongly each output
        moves each estimate when it is measured; of a Comparison, which knows its
        plant, the V of the recommended design.
    plant : Plant
        May be left out with a `Comparison`.
    ax : Axes, optional
        Where the gains have several units, its place in the figure is divided among
        the panels; outside a grid of subplots it holds all gains.
    start : int, default 1
        The instant that row 0 of gains over time belongs to.

    Returns
    -------
    Axes
        That given, as the first panel; ``ax.figure.axes`` has all of them.
    """
    if isinstance(shown, Comparison):
        plant, shown = shown.plant, shown.recommended().observer
    expect(shown=shown, plant=plant)
    assert plant is not None  # which `expect` refuses
    K, rows = np.asarray(shown.V if isinstance(shown, Observer) else shown), None
    if isinstance(shown, Observer) and not np.array_equal(shown.L, np.eye(plant.n)):
        rows = shown.estimates or [f"row {k + 1} of k x" for k in range(len(shown.L))]
    names = list(rows or plant.state_names), list(plant.output_names)
    groups = by_unit(*names)
    some = {k: of for k, of in groups.items() if any(K[..., i, j].any() for i, j in of)}
    groups = some or dict([*groups.items()][:1])
    panels = _divided(ax or plt.gca(), len(groups))
    if len(panels) < len(groups):  # an Axes that is in no grid
        every = [one for places in groups.values() for one in places]
        groups = {"gain (units of state per output)": sorted(every)}
    t = plant.dt * (start + np.arange(len(K)))
    for one, (label, places) in zip(panels, groups.items()):
        if K.ndim == 2:
            _bars(one, K, places, *names)
        else:
            _curves(one, t, K, places, *names)
        one.set_ylabel(text(label))
        _entitle(one)
    return panels[0]


def _entitle(ax: Axes) -> None:
    """What the curves or bars are: a title where there is one kind, else a legend."""
    labels = ax.get_legend_handles_labels()[1]
    if len(labels) == 1:
        ax.set_title(labels[0], fontsize="small")
    elif labels:
        ax.margins(y=0.1 + 0.12 * len(labels))
        ax.legend(fontsize="x-small")


def _plain(name: str) -> str:
    """A name without its unit, which the axis gives."""
    found = unit(name)
    return text(name.rstrip().removesuffix(f"({found})").rstrip() if found else name)


def by_unit(rows: Sequence[str], outputs: Sequence[str]) -> dict[str, list[Place]]:
    """Which gains have which unit, by what their axis says.

    >>> by_unit(["position (m)", "speed (m/s)"], ["distance (m)", "wheel (m/s)"])
    ... # doctest: +NORMALIZE_WHITESPACE
    {'gain': [(0, 0), (1, 1)], 'gain (m per m/s)': [(0, 1)],
     'gain (m/s per m)': [(1, 0)]}
    """
    groups: dict[str, list[Place]] = {}
    for i, row in enumerate(rows):
        for j, output in enumerate(outputs):
            above, below = unit(row), unit(output)
            same = above == below
            label = "gain" if same else f"gain ({above or '1'} per {below or '1'})"
            groups.setdefault(label, []).append((i, j))
    return groups or {"gain": []}


def _divided(ax: Axes, count: int) -> list[Axes]:
    """Panels in the place of the Axes, which becomes the first of them."""
    place = ax.get_subplotspec()
    if count == 1 or place is None:
        return [ax]
    columns = min(ACROSS, count)
    grid = GridSpecFromSubplotSpec(-(-count // columns), columns, place)
    ax.set_subplotspec(grid[0])
    figure: Any = ax.figure
    return [ax, *(figure.add_subplot(grid[k]) for k in range(1, count))]


def _curves(
    ax: Axes,
    t: np.ndarray,
    K: np.ndarray,
    places: Sequence[Place],
    rows: Sequence[str],
    outputs: Sequence[str],
) -> None:
    for i, j in places:
        curve = style(i) | {"marker": MARKERS[j % 6], "markevery": 0.2}
        label = f"{_plain(rows[i])} from {_plain(outputs[j])}"
        ax.plot(t, K[:, i, j], label=label, **curve)
    ax.set(xlabel="time (s)")


def _bars(
    ax: Axes,
    K: np.ndarray,
    places: Sequence[Place],
    rows: Sequence[str],
    outputs: Sequence[str],
) -> None:
    """A group of bars for each row that has one of these gains, a bar an output."""
    shown = sorted({i for i, _ in places}) if places else list(range(len(rows)))
    used = sorted({j for _, j in places})
    wide = 0.8 / max(len(used), 1)
    for k, j in enumerate(used):
        those = [i for i, other in places if other == j]
        where = np.array([shown.index(i) for i in those])
        look: Look = dict(
            color=COLOURS[j % 6], hatch=HATCHES[j % 6], edgecolor="white",
            label=f"from {_plain(outputs[j])}",
        )  # fmt: skip
        ax.bar(where + wide * (k - (len(used) - 1) / 2), K[those, j], wide, **look)
    ax.axhline(0, color="0.3", lw=0.8)
    names = [_plain(rows[i]) for i in shown]
    ax.set_xticks(range(len(names)), names)
    ax.set_xlim(-0.6, max(len(names), 1) - 0.4)
    if sum(map(len, names)) > 20:
        ax.tick_params(axis="x", rotation=30)
        plt.setp(ax.get_xticklabels(), ha="right")
