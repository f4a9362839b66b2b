"""Figures of what a filter leaves of a record."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes

from ..identification.fit import NoiseFit
from ..identification.whiteness import Whiteness, whiteness
from ..plant import Plant
from ..run.filter import Filter
from ..run.record import Record
from .style import style, text


def innovations(
    shown: NoiseFit | Whiteness | Plant,
    y: Any = None,
    u: Any = None,
    ax: Axes | None = None,
    names: Sequence[str] | None = None,
) -> Axes:
    """Autocorrelations of normalised innovations, and the band of white ones.

    Each output has a curve of its own over the lags; of white innovations 95 % of the
    points lie in the band, two standard errors to each side of zero.

    Parameters
    ----------
    shown : NoiseFit, Whiteness or Plant
        What `fit_noise` or `whiteness` found; or a plant with Q and R, whose
        innovations on the record y, u are computed.
    y, u : array_like, optional
        The record, with a plant.
    names : sequence of str, optional
        Of the outputs, for a Whiteness; default y1, y2, ...
    """
    ax = ax or plt.gca()
    if isinstance(shown, Plant):
        if y is None:
            raise ValueError("give the record y of the plant as well")
        left = Filter(shown).innovations(Record(y, u))
        names, shown = shown.output_names, whiteness(left)
    elif isinstance(shown, NoiseFit):
        names, shown = shown.plant.output_names, shown.whiteness
    elif not isinstance(shown, Whiteness):
        raise ValueError(
            "plot.innovations shows a NoiseFit, a Whiteness, or a Plant and a record; "
            f"got {type(shown).__name__}"
        )
    names = names or [f"y{j + 1}" for j in range(shown.autocorrelation.shape[1])]
    lags = np.arange(1, len(shown.autocorrelation) + 1)
    ax.axhspan(-shown.bound, shown.bound, color="0.9", label="white, 95 %")
    ax.axhline(0, color="0.3", lw=0.8)
    for j in range(shown.autocorrelation.shape[1]):
        own = shown.autocorrelation[:, j, j]
        ax.plot(lags, own, label=text(names[j]), **style(j))
    ax.set(xlabel="lag (samples)", ylabel="autocorrelation of innovations")
    ax.legend(fontsize="small")
    return ax
