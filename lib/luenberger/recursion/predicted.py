"""Rows in compiled code from prediction to prediction.

A filter's covariance is singular after an exact reading, and that of a prediction is
not, where noise drives the state.  Nor does the noise have to be split into parts where
it is correlated.  NumPy does the rows in which the covariance of a prediction, or of an
innovation, is close to singular.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import kernels
from ..kernels.program import Factor, Squares, Variances
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import EPS, SAFE, safe
from ..papers.leondes_novak.derivation import estimate_step, filtered_row
from ..plant import Plant
from .alike import arrived, every, patterns
from .root_step import Move, Spread, ahead
from .settings import Settings
from .state import Ahead, History, State, flat, leading_on, step

FIRM = 1e-7  # a pivot of an innovation's covariance, beside its variance
CLEARLY = 1e-6  # of singular values: dependent rows are refused far below
PLACED = frozenset(("C", "C_s", "E", "R", "S"))  # with places for what is missing
PREDICTED = kernels.Recursion(
    filtered_row,
    carried=(("Omega_next", "Omega"), ("x_minus_next", "x_minus")),
    rows=(("y", "y", 0), ("u", "u", 0)),
    written=(
        ("xs", "x", "vector"),
        ("variances", "Sigma", "diagonal"),
        ("covariances", "Sigma", "matrix"),
        ("gains", "K", "matrix"),
    ),
    symmetric=("Q", "R", "Omega"),
    definite=(
        Factor("Omega_next", SAFE, "X_s"),
        Factor("M", FIRM, "c_s", part=SAFE / FIRM),
    ),
    sizes=(Squares("K_s", "Kmv"), Variances("v_s", "Omega"), Variances("q_s", "Q")),
    each=True,
)


def by_predictions(settings: Settings) -> bool:
    """Whether compiled code is to go from prediction to prediction.

    So it does where outputs have no noise, and where correlated noises change.
    Accurate outputs must have no noise then: the gain is the Kalman filter's.
    """
    plant, some = settings.plant, settings.accurate
    S = plant.S
    crossed = plant.steps is not None and S is not None and bool(S.any())
    noisy = bool(settings.R[..., some, some].any())
    return plant.p > 0 and not noisy and (settings.noise_free or crossed)


def _kernel(plant: Plant, whole: bool) -> Callable[..., Any]:
    """The compiled loop of a plant; `whole` says that no entry is missing."""
    stacks = _matrices(plant)
    stacks |= _squares(stacks)
    changing = {name for name, X in stacks.items() if len(X) > 1}
    changing |= frozenset() if whole else PLACED
    known = tuple((k, _known(k, X, k in changing)) for k, X in stacks.items())
    sizes = tuple((name, getattr(plant, name)) for name in "mnp")
    return kernels.over_record(PREDICTED, sizes, known, frozenset(changing))


def predicted(settings: Settings, state: State) -> Ahead | None:
    """The next prediction; None where its covariance is close to singular."""
    move, A, B, J = leading_on(settings.plant, state.setting)
    H_minus, rounding = ahead(move, *state.spread.factored())
    Omega = H_minus @ H_minus.T
    with np.errstate(over="ignore"):  # infinite is not safe
        made_of = np.maximum(rounding.diagonal(), 0) / EPS**2
    if not safe(Omega, made_of):
        return None
    found = kernels.compiled(estimate_step, "x_minus")(
        A=A, B=B, J=J, x=state.x, rho=state.rho, u=state.u[:, None]
    )
    return Ahead(Omega.flatten(), found["x_minus"].flatten())


def begins(settings: Settings, instant: int, now: Ahead, seen: Vector | None) -> State:
    """The state from which the row after an instant begins with this prediction.

    `seen` (p,) bool tells which outputs arrive there; None is all.
    """
    n, m, p = settings.plant.n, settings.plant.m, settings.plant.p
    still = Move(np.eye(n), np.zeros((n, n)), np.zeros((n, 0)), np.eye(n))
    setting = settings.at(instant + 1, seen)._replace(
        A=np.eye(n), B=np.zeros((n, m)), J=np.zeros((n, 0)), move=still
    )
    return State(
        instant, now.x[:, None], Spread(now.Omega.reshape(n, n)), None, np.zeros(m),
        seen=np.zeros(p, dtype=bool), rho=np.zeros((0, 1)), setting=setting,
    )  # fmt: skip


@dataclass(frozen=True, eq=False)
class Predicted:
    """Rows of a record that compiled code can run, from prediction to prediction.

    Attributes
    ----------
    settings : Settings
    kernel : callable
        The loop over rows; see `kernels.over_record`.
    given : dict of str to ndarray
        Stacks of matrices, the index of each row, y and u.
    seen : (N, p) ndarray of bool
        Which outputs arrived.
    y : (N, p) ndarray
        As measured.
    """

    settings: Settings
    kernel: Callable[..., int]
    given: Matrices
    seen: np.ndarray
    y: np.ndarray

    @classmethod
    def of(cls, settings: Settings, state: State, y: Matrix, u: Matrix) -> Predicted:
        """The next rows of a record, which begin at `state`."""
        seen = arrived(y)
        whole = every(seen)
        stacks, index = _stacks(settings, seen, whole, state.instant + 1)
        kernel = _kernel(settings.plant, whole)
        given = {name: flat(kernels.plain_array(X)) for name, X in stacks.items()}
        given |= dict(now=index, before=index, good=np.ones(len(index), dtype=bool))
        read = y if whole else np.where(seen, y, 0.0)
        given |= dict(y=kernels.plain_array(read), u=kernels.plain_array(u))
        return cls(settings, kernel, given, seen, y)

    def ready(self, state: State) -> bool:
        """Whether it is the turn of compiled code."""
        return state.instant >= state.turn.instant

    def run(self, state: State, k: int, out: History, stop: int) -> tuple[State, int]:
        """From `state` before row k on: the state reached, and the first row not done.

        That is `stop`, unless compiled code gives up before.

        Rows that were done are written to `out`.  The factor of the last covariance is
        found in NumPy, from the last prediction.
        """
        first, now = state.instant - k, state.ahead or predicted(self.settings, state)
        if now is None:
            return state, k
        now, done = self.rows(now, k, out, stop - 1)
        after = now
        if done == stop - 1:
            after, done = self.rows(now, done, out, stop)
        if done == k:
            return state, k
        row = min(done, stop - 1)
        seen = None if self.seen[row].all() else self.seen[row]
        last = begins(self.settings, first + row, now, seen)
        if done < stop:
            return last, done
        found = step(self.settings, last, self.y[row], self.given["u"][row])
        return found.state._replace(ahead=after), stop

    def rows(self, now: Ahead, k: int, out: History, stop: int) -> tuple[Ahead, int]:
        """From the prediction of row k: the one reached, and the first row not done."""
        Omega, x = now.Omega.copy(), now.x.copy()
        done = self.kernel(
            **self.given, Omega=Omega, x_minus=x, start=k, stop=stop, keep=True,
            **out.arrays,
        )  # fmt: skip
        return Ahead(Omega, x), done


def _matrices(plant: Plant) -> Matrices:
    """The plant's matrices, as stacks."""
    S = np.zeros((plant.n, plant.p)) if plant.S is None else plant.S
    whole = {name: getattr(plant, name) for name in "ABCEQR"} | {"S": S}
    return {name: X if X.ndim == 3 else X[None] for name, X in whole.items()}


def _squares(stacks: Matrices) -> Matrices:
    """Squares of the entries of A and C, by which rounding is judged."""
    return {f"{name}_s": stacks[name] ** 2 for name in "AC"}


def _stacks(
    settings: Settings, seen: Matrix, whole: bool, first: int
) -> tuple[Matrices, Vector]:
    """The plant's matrices, and which of them a row has where there are several.

    `whole` says that no output is missing, and `first` is the instant of the first
    row.  One index says that all rows have the first of each.  Outputs that did not
    arrive keep their places; see derivation/predictions.py.
    """
    plant = settings.plant
    one = whole and plant.steps is None
    kinds = index = np.arange(1 if one else len(seen))
    at = index + first - settings.origin
    stacks = {
        k: X if len(X) == 1 else X[np.minimum(at, len(X) - 1)]
        for k, X in _matrices(plant).items()
    }
    if not whole and plant.steps is None:
        kinds, index = patterns(seen)
    for k in _doubtful(settings, seen, stacks["C"]):  # what is refused
        settings.at(first + k, None if seen[k].all() else seen[k])
    if not whole:
        some = seen[kinds]
        both = some[:, :, None] & some[:, None, :]
        for name in "CE":
            stacks[name] = stacks[name] * some[:, :, None]
        stacks["S"] = stacks["S"] * some[:, None, :]
        stacks["R"] = np.where(both, stacks["R"], np.eye(plant.p))
    stacks |= _squares(stacks)
    return stacks, np.ascontiguousarray(index, dtype=np.int64)


def _doubtful(settings: Settings, seen: Matrix, C: Matrix) -> list[int]:
    """Rows whose accurate outputs, or those of a weight, may depend on each other.

    One row of each kind where C (., p, n) does not change.
    """
    weighed = isinstance(settings.weight, str)
    if not (settings.accurate or weighed):
        return []
    if len(C) == 1:
        return [0] if every(seen) else [int(k) for k in patterns(seen)[0]]
    C1 = C[:, list(settings.accurate)]  # what arrived of them depends no more
    lengths = np.linalg.norm(C1, axis=2, keepdims=True)
    clear = _independent(C1 / np.where(lengths > 0, lengths, 1))
    if weighed:
        clear &= _independent(C)
    return [int(k) for k in np.flatnonzero(~clear)]


def _independent(C: Matrix) -> Matrix:
    """Whether the rows of each of a stack are independent beyond doubt."""
    count, n = C.shape[1:]
    if not 0 < count <= n:
        return np.full(len(C), count == 0)
    values = np.linalg.svd(C, compute_uv=False)
    return np.asarray(values[:, -1] > CLEARLY * values[:, 0])


def _known(name: str, X: Matrix, changing: bool) -> tuple:
    """Entries that are 0, or 1; of covariances only those off the diagonal.

    A search may move a variance to zero, and back.
    """
    zero, one = np.asarray((X == 0).all(axis=0)), np.asarray((X == 1).all(axis=0))
    if name in "QR":
        np.fill_diagonal(zero, False)
    if name in "QR" or changing:
        one[:] = False
    return kernels.entries_known(zero, one)
