"""What a filter that waits for readings carries from row to row, and its prediction.

A reading that was taken and has not arrived stands beside the state as one more
unknown, from the instant at which it was taken until it arrives.  The formulas are
those of late_outputs.py and late_arrivals.py in papers/leondes_novak/derivation.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np

from .. import kernels
from ..numeric import Matrix, Vector
from ..papers.leondes_novak.derivation import late_ahead, late_fresh
from .growth import Gap
from .root_step import Move, Spread
from .settings import Setting, Settings, require_start
from .state import leading_on

Label = Any  # of a row or an arrival: a number that grows from row to row


class Row(NamedTuple):
    """A row of a record, and when its readings arrive.

    Attributes
    ----------
    y, u : (p,), (m,) ndarray
        NaN in y was not measured, or never arrives.
    due : (p,) ndarray
        Labels of the rows at which they arrive.
    label : number
        That of this row.
    """

    y: np.ndarray
    u: np.ndarray
    due: np.ndarray
    label: Label


class Held(NamedTuple):
    """A reading that was taken and is not known yet.

    ``value`` is the reading, NaN if it never arrives; ``size`` is the magnitude that
    the reading less what the input does to it is a sum of.
    """

    instant: int
    output: int
    due: Label
    value: float
    size: float

    def arrived(self, label: Label) -> bool:
        """Whether it is known at the row of that label."""
        return self.value == self.value and bool(self.due <= label)


class LateState(NamedTuple):
    """A filter between two rows: all that the rows to come depend on.

    Attributes
    ----------
    instant : int
        That of the last row; 0 before the first.
    xi : (n + q, 1) ndarray
        The estimate of the state, and what is expected of the readings held.
    spread : Spread
        Covariance of its error.
    rounding : (n + q, n + q) ndarray or None
        Covariance of the rounding in xi; None where noise covers it.
    u : (m,) ndarray
        The input.
    y_hat : (p, 1) ndarray
        Readings of the instant, where they arrived.
    held : tuple of Held
        In the order of xi.
    setting : Setting or None
        The plant there, with every output; None at instant 0, which has none.
    label : number or None
        Of the last row.
    gap : Gap or None
        The stretch of rows without all their readings that the last row is in.
    """

    instant: int
    xi: np.ndarray
    spread: Spread
    rounding: np.ndarray | None
    u: np.ndarray
    y_hat: np.ndarray
    held: tuple[Held, ...]
    setting: Setting | None
    label: Label = None
    gap: Gap | None = None


def start(settings: Settings, x: Vector, u: Vector) -> LateState:
    """The state at instant 0: the mean x (n,) with covariance P0, and the input u."""
    spread = Spread.of(require_start(settings.plant))
    return LateState(0, x[:, None], spread, None, u, np.zeros((0, 1)), (), None)


class Ahead(NamedTuple):
    """The next row before any of its readings is used.

    Attributes
    ----------
    instant : int
    now : Setting
        The plant there, with every output.
    move : Move
        What leads there.
    J : (n, f) ndarray
        What readings of the last instant that are held tell of the process noise.
    last, kept : list of int
        Which of those held are these, and which are held on.
    new : list of int
        The outputs of which readings are new.
    held : tuple of Held
        What is held on, and then what is new.
    xi : (n + q, 1) ndarray
        What is expected of the state and of them.
    made_of : (n,) ndarray
        The magnitudes that the state's part of it is a sum of.
    """

    instant: int
    now: Setting
    move: Move
    J: np.ndarray
    last: list[int]
    kept: list[int]
    new: list[int]
    held: tuple[Held, ...]
    xi: np.ndarray
    made_of: np.ndarray

    def of_all(self, of_held: Vector) -> Vector:
        """The same for state and readings: False for each state."""
        return np.concatenate([np.zeros(len(self.now.A), dtype=bool), of_held])


def predicted(settings: Settings, state: LateState, row: Row) -> Ahead:
    """What is expected of the next row, and which readings it is about."""
    n, i = settings.plant.n, state.instant + 1
    now = settings.at(i)
    move, A, B, J = leading_on(settings.plant, state.setting)
    C, E = np.zeros((0, n)), np.zeros((0, len(state.u)))
    if state.setting is not None:
        C, E = state.setting.C, state.setting.E
    last = [k for k, one in enumerate(state.held) if one.instant == state.instant]
    last = last if J.any() else []
    of = [state.held[k].output for k in last]
    x, u, y_hat = state.xi[:n], state.u[:, None], state.y_hat.copy()
    y_hat[of] = state.xi[n:][last]
    found = kernels.compiled(late_ahead, "rho", "x_minus")(
        A=A, B=B, C=C, E=E, J=J, x=x, u=u, y_hat=y_hat
    )
    made_of = _magnitude((move.size, x), (B, u), (J, found["rho"]))
    kept = [k for k, one in enumerate(state.held) if one.value == one.value]
    new, fresh = _new(now, i, row)
    y_minus = kernels.compiled(late_fresh, "y_minus")(
        C=now.C[new], E=now.E[new], x_minus=found["x_minus"], u_next=row.u[:, None]
    )["y_minus"]
    xi = [found["x_minus"], state.xi[n:][kept], y_minus]
    return Ahead(
        i, now, move, J[:, of], last, kept, new,
        (*(state.held[k] for k in kept), *fresh), np.concatenate(xi), made_of[:, 0],
    )  # fmt: skip


def _magnitude(*products: tuple[Matrix, Matrix]) -> Matrix:
    """The largest numbers that a sum of these products may pass through."""
    return np.add.reduce([np.abs(X) @ np.abs(v) for X, v in products])


def _new(now: Setting, instant: int, row: Row) -> tuple[list[int], list[Held]]:
    """The outputs that are taken at a row; with S, those that never arrive as well."""
    size = np.abs(row.y) + np.abs(now.E) @ np.abs(row.u)
    taken = ~np.isnan(row.y) | now.J.any()
    new = np.flatnonzero(taken).tolist()
    return new, [Held(instant, j, row.due[j], row.y[j], size[j]) for j in new]
