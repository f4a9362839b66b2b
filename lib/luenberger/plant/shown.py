"""A plant as a terminal and a notebook show it."""

from __future__ import annotations

from typing import TYPE_CHECKING

import numpy as np

from ..show.blocks import clock, counted, html, listed, matrices, text
from ..show.tables import Table

if TYPE_CHECKING:
    from .plant import Plant


def as_text(plant: Plant) -> str:
    """Sizes, names with their units, and what is known of the noise."""
    return text(*_said(plant))


def as_html(plant: Plant) -> str:
    """The same, with the matrices under the names of what they multiply."""
    return html(*_said(plant), None if plant.steps is not None else _table(plant))


def _said(plant: Plant) -> tuple[str, dict[str, str]]:
    name = f" {plant.name!r}" if plant.name else ""
    sizes = (plant.n, "state"), (plant.m, "input"), (plant.p, "output")
    about = ", ".join(counted(*size) for size in sizes)
    over = f", over {counted(plant.steps, 'instant')}" if plant.steps else ""
    known = [key for key in "QRSU" if getattr(plant, key) is not None]
    known += ["P0"] * (plant.P0 is not None)
    known += ["multiplicative noise"] * bool(plant.multiplicative)
    lines = dict(
        states=listed(plant.state_names),
        inputs=listed(plant.input_names),
        outputs=listed(plant.output_names),
        given=", ".join(known) or "no noise",
    )
    return f"Plant{name}: {about}, {clock(plant.dt)}{over}", lines


def _table(plant: Plant) -> Table | None:
    """[A B; C E], and the standard deviation of each row's noise."""
    ahead = "+" if plant.dt else "'"
    rows = [*(f"{x}{ahead}" for x in plant.state_names), *plant.output_names]
    X = np.block([[plant.A, plant.B], [plant.C, plant.E]])
    columns = [*plant.state_names, *plant.input_names]
    if plant.dt and plant.Q is not None and plant.R is not None:
        variances = np.concatenate([plant.Q.diagonal(), plant.R.diagonal()])
        X = np.column_stack([X, np.sqrt(np.maximum(variances, 0))])
        columns.append("one sigma of noise")
    return matrices(rows, columns, X)
