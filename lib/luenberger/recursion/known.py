"""Rows of a state that is known exactly, in compiled code.

Some exact readings tell the whole state, and tell it again in each row, as with one
process noise and two outputs without noise.  Its covariance is zero against rounding
then, of predictions too, so that no factor of a covariance says more.  One gain does
for all rows; what was known before it is read has to agree in each of them.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..kernels.program import Squares
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import CLEAR, lengths
from ..papers.leondes_novak.derivation import known_row
from .agreement import CONFLICT_TOL, followed, rounding_of
from .alike import arrived, every
from .root_step import Spread, root_step
from .settings import Setting, Settings
from .state import History, State, sizes

SLACK = 1e-9  # a mode may be rounded by this, beside the unit circle
KNOWN = kernels.Recursion(
    known_row,
    carried=(("x_next", "x"),),
    rows=(("y", "y", 0), ("u", "u", 0), ("u_next", "u", 1)),
    written=(("xs", "x_next", "vector"),),
    bounds=(("left", "size", "square", CONFLICT_TOL**2),),
    sizes=(
        Squares("x_s", "x"),
        Squares("u_s", "u"),
        Squares("v_s", "u_next"),
        Squares("y_s", "y"),
    ),
)


class Fixed(NamedTuple):
    """A row that leaves a state known: its matrices, the spread behind it, and U."""

    new: Matrices
    spread: Spread
    U: np.ndarray

    @classmethod
    def of(cls, now: Setting, spread: Spread) -> Fixed | None:
        """From the spread before it; None where more than rounding is left."""
        new, after, U = root_step(now, now.move, spread)
        return cls(new, after, U) if nothing(after) else None


def nothing(spread: Spread) -> bool:
    """Whether a spread is rounding."""
    if spread.half is None or spread.rounding is None:
        return False
    most = CLEAR * np.sqrt(np.maximum(spread.rounding.diagonal(), 0))
    return bool((lengths(spread.half) <= most).all())


class Known:
    """Whether a plant has such rows, and what they are."""

    def __init__(self, settings: Settings) -> None:
        self.settings = settings

    @cached_property
    def fixed(self) -> Fixed | None:
        """The row behind a state that is known, where it is known again."""
        settings, n = self.settings, self.settings.plant.n
        if settings.steps is not None or not settings.noise_free:
            return None
        now = settings.at(0)
        if now.J.any():
            return None
        found = Fixed.of(now, Spread(np.zeros((n, n)), *np.zeros((2, n, n))))
        if found is None:
            return None
        modes = np.linalg.eigvals(found.new["Y"] @ now.As)
        return found if np.abs(modes).max(initial=0) <= 1 + SLACK else None

    def begins(self, state: State) -> bool:
        """Whether a state is such, and the next row decides as all behind it."""
        if not nothing(state.spread) or self.fixed is None:
            return False
        found = Fixed.of(self.settings.at(0), state.spread)
        return found is not None and found.U.shape == self.fixed.U.shape

    @cached_property
    def matrices(self) -> Matrices:
        """What a row reads of the plant, and squares of its entries."""
        assert self.fixed is not None
        now, U = self.settings.at(0), self.fixed.U
        U = U if U.size else np.zeros((len(U), 1))
        found = dict(A=now.A, B=now.B, C=now.C, E=now.E, K=self.fixed.new["K"], U=U)
        squares = {f"{name}_s": X**2 for name, X in found.items() if name != "K"}
        return {name: kernels.plain_array(X) for name, X in (found | squares).items()}

    @cached_property
    def row(self) -> Callable[..., int]:
        """The loop over rows; see `kernels.over_record`."""
        known = tuple(
            (name, kernels.entries_known(X == 0, X == 1))
            for name, X in self.matrices.items()
        )
        plant, k = self.settings.plant, self.matrices["U"].shape[1]
        of = ("k", k), ("m", plant.m), ("n", plant.n), ("p", plant.p)
        return kernels.over_record(KNOWN, of, known, frozenset())

    def block(self, state: State, y: Matrix, u: Matrix) -> KnownRows:
        """The next rows of a record, which begin at `state`."""
        return KnownRows(self, y, np.concatenate([state.u[None], u]))


@dataclass(frozen=True, eq=False)
class KnownRows:
    """Rows of a record, y (N, p), and u (N + 1, m) from the row before on."""

    known: Known
    y: Matrix
    u: Matrix

    @cached_property
    def ends(self) -> Vector:
        """For each row the first one from it on in which an output is missing."""
        N, seen = len(self.y), arrived(self.y)
        if every(seen):
            return np.broadcast_to(N, N)
        after = np.where(seen.all(axis=1), N, np.arange(N))
        return np.minimum.accumulate(after[::-1])[::-1]

    def run(self, state: State, k: int, out: History, stop: int) -> tuple[State, int]:
        """From `state` before row k on: the state reached, and the first row not done.

        Compiled code stops before a row that may contradict what is known.
        """
        end = min(int(self.ends[k]), stop)
        if end == k or state.setting is None or not self.known.begins(state):
            return state, k
        fixed, x = self.known.fixed, state.x.flatten()
        assert fixed is not None
        nowhere, given = np.zeros(1, dtype=np.int64), self.known.matrices
        done = self.known.row(
            **{name: X.reshape(1, -1) for name, X in given.items()}, now=nowhere,
            before=nowhere, good=np.ones(1, dtype=bool), y=kernels.plain_array(self.y),
            u=self.u, x=x, xs=out.x, start=k, stop=end, keep=False,
        )  # fmt: skip
        if done == k:
            return state, k
        rows = slice(k, done)
        out.repeat(rows, fixed.spread.Sigma, fixed.new["K"])
        return self.after(state, rows, out.x), done

    def after(self, state: State, rows: slice, x: Matrix) -> State:
        """The state behind some rows, whose estimates are those of x."""
        now, fixed, last = self.known.settings.at(0), self.known.fixed, rows.stop - 1
        assert fixed is not None
        y, u = self.y[last], self.u[last + 1]
        before = np.maximum(sizes(x[rows]), np.abs(state.x[:, 0]))
        made_of = now.move.size @ before
        made_of += np.abs(now.B) @ sizes(self.u[rows])
        inputs = sizes(self.u[rows.start + 1 : rows.stop + 1])
        read = sizes(self.y[rows]) + np.abs(now.E) @ inputs
        begin = rounding_of(state.x) if state.rounding is None else state.rounding
        added, _ = followed(0 * begin, now.As, now.C, fixed.new, made_of, read)
        ahead = fixed.new["Y"] @ now.As
        rounding = repeated(ahead, added, begin, rows.stop - rows.start)
        rho = y - now.E @ u - now.C @ x[last]
        return State(
            state.instant + rows.stop - rows.start, x[last][:, None], fixed.spread,
            rounding, u, seen=np.ones(len(y), dtype=bool), rho=rho[:, None],
            setting=now, turn=state.turn,
        )  # fmt: skip


def repeated(A: Matrix, Q: Matrix, X: Matrix, rows: int) -> Matrix:
    """X after so many steps of X = A X A' + Q: two steps are one with others."""
    while rows:
        if rows % 2:
            X = A @ X @ A.T + Q
        A, Q, rows = A @ A, A @ Q @ A.T + Q, rows // 2
    return X
