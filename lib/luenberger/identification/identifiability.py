"""Which combinations of unknown noise covariances a record can determine."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import kernels
from ..arguments import expect
from ..errors import DesignError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.covariance_maps import packing
from ..numeric.independent_rows import climb, default_tol, in_even_units, outside
from ..numeric.linalg import RANK_TOL
from ..plant import Plant
from ..run.filter import Filter
from .derivation import change_step, silent_change
from .forms import form_of

SMALL = 1e-7  # a share of a direction below this is rounding
TOGETHER = 64  # instants that are asked at first, and whose rows are reduced at once
CLEAR = 1e-4  # least singular value of what determines every change


@dataclass(frozen=True, eq=False)
class Identifiability:
    """What a record, however long, can tell of unknown entries of Q, R and S.

    Attributes
    ----------
    unknown : tuple of str
        Names of the unknowns, such as "Q[0,1]"; indices count from 0.
    directions : tuple of dict
        Changes {"Q": (n, n), "R": (p, p), "S": (n, p)} that leave no trace in a
        record, in the units of the plant; all other changes are linear combinations
        of them and of what is determined.
    sentences : tuple of str
        Each direction in words.
    """

    unknown: tuple[str, ...]
    directions: tuple[Matrices, ...]
    sentences: tuple[str, ...]

    @property
    def determined(self) -> int:
        """How many combinations of the unknowns a record determines."""
        return len(self.unknown) - len(self.directions)

    def require(self) -> None:
        """Raise DesignError, naming what cannot be told apart, unless all can."""
        if self.sentences:
            raise DesignError(
                "no record of this plant determines "
                f"{'; nor '.join(s.removesuffix('.') for s in self.sentences)}. Give "
                "what you know (Q=None or R=None keeps the plant's), or a form with "
                "fewer unknowns, such as Q='diagonal' or a matrix G"
            )


def identifiability(
    plant: Plant, *, Q: Any = "full", R: Any = "full", S: Any = 0, start: Any = None,
    seen: Matrix | None = None,
) -> Identifiability:  # fmt: skip
    """Say which combinations of the unknown Q, R and S a record can determine.

    A state that is forgotten at once: both noises only add up in the output.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0]], None, [[1]], dt=1.0)
    >>> identifiability(plant).sentences
    ('Q[0,0] and R[0,0] apart, but only the sum Q[0,0] + R[0,0].',)

    Let the rows of T be what the outputs show of the state, now or later: T A = A_T T
    and C = C_T T with an observable pair A_T, C_T; of an observable plant T is I.  A
    change (dQ, dR, dS) leaves no trace in the autocovariances of the innovations, of
    any gain under which the error of T x dies out, exactly if there is a symmetric X
    with

        T dQ T' = X - A_T X A_T',   T dS = -A_T X C_T',   dR = -C_T X C_T'.

    So what a state adds that no output shows, its rows of Q and S, is not determined.

    Parameters
    ----------
    plant : Plant
        Its A and C; they may be unstable, or vary over time.
    Q, R : "full", "diagonal", "scaled", (., k) array_like, callable or None
        What is unknown: every entry, the default; the diagonal; the plant's own times
        a number; q in G diag(q) G'; the numbers of a function (linearised at
        ``start["Q"]``); or None, if it is known.
    S : 0, None or "full", default 0
        Zero and None are known.
    start : dict, optional
        Where functions are linearised, as in `fit_noise`.
    seen : (N, p) array_like of bool, optional
        Which outputs a record has, where some are missing; default all of them.

    Returns
    -------
    Identifiability

    Raises
    ------
    ValueError
        If Q, R or S is none of these.

    Notes
    -----
    Judged in units in which the plant's numbers are of like size: a direction counts
    as silent if what it shows is below 1e-10 of the terms that it is computed from.

    References
    ----------
    Mehra (1970); Odelson, Rajamani and Rawlings (2006);
    identification/derivation/identifiability.py.
    """
    expect(plant=plant)
    n, p, begin, one = plant.n, plant.p, start or {}, plant.at(0)
    Q_form = form_of("Q", Q, n, one.Q, begin.get("Q"), np.ones(n))
    R_form = form_of("R", R, p, one.R, begin.get("R"), np.ones(p))
    wide = n * p if isinstance(S, str) and S == "full" else 0
    if not (wide or S is None or (np.isscalar(S) and S == 0)) and np.shape(S) != (n, p):
        raise ValueError(f"S must be 0, None, 'full' or {n} x {p} and known, got {S!r}")
    parts = [one.directions(one.at(np.eye(k), np.ones(k)))
             for one, k in ((Q_form, n), (R_form, p))]  # fmt: skip
    parts.append(np.eye(n * p)[:wide].reshape(-1, n, p))
    labels = [*Q_form.labels, *R_form.labels]
    labels += [f"S[{i},{j}]" for i in range(n) for j in range(p)][:wide]
    edges, changes = np.cumsum([0, *map(len, parts)]), {}
    for name, part, a, b in zip("QRS", parts, edges, edges[1:]):
        changes[name] = np.zeros((len(labels), *part.shape[1:]))
        changes[name][a:b] = part
    units, silent = _silent(plant, changes, seen)
    found = _sparse(silent)
    user = [row / units for row in found]
    user = [row / row[np.flatnonzero(row)[0]] for row in user]
    return Identifiability(
        tuple(labels),
        tuple({k: np.tensordot(row, X, 1) for k, X in changes.items()} for row in user),
        tuple(_sentence(labels, row, at) for row, at in zip(user, found)),
    )


def _silent(
    plant: Plant, changes: Matrices, seen: Matrix | None
) -> tuple[Vector, Matrix]:
    """Sizes of the unknowns in even units, and rows: silent combinations of these."""
    one, tol = plant.at(0), default_tol(plant.n)
    pair, _ = in_even_units(one.A, one.C, 1.0, tol)
    x, y = pair.states, pair.outputs
    unit = {"Q": (x, x), "R": (y, y), "S": (x, y)}
    even = {k: X / unit[k][0][:, None] / unit[k][1] for k, X in changes.items()}
    sizes = np.sqrt(sum((X**2).sum(axis=(1, 2)) for X in even.values()))
    sizes = np.where(sizes > 0, sizes, 1.0)
    even = {name: X / sizes[:, None, None] for name, X in even.items()}
    A, C = plant.A / x[:, None] * x, plant.C / y[:, None] * x
    if seen is not None:
        C = np.where(np.any(seen, axis=0)[:, None], C, 0.0)
    # Rows whose product with the state is all that an output shows, now or later.  At
    # least one of zeros: it stands for a state that is zero.
    rows = np.vstack(climb(A, C, tol)[0] or [np.zeros((1, plant.n))])
    A, C = rows @ A @ rows.T, C @ rows.T
    even |= {"Q": rows @ even["Q"] @ rows.T, "S": rows @ even["S"]}
    if plant.steps is not None or (seen is not None and not np.all(seen)):
        if seen is None:
            assert plant.steps is not None
            seen = np.ones((plant.steps - 1, plant.p), dtype=bool)
        shown = over_time(A, C, even, np.asarray(seen, dtype=bool))
    else:
        shown = _of_lags(A, C, even)
    _, values, right = np.linalg.svd(shown)
    values = np.pad(values, (0, len(right) - len(values)))
    return sizes, right[values <= RANK_TOL]


def _of_lags(A: Matrix, C: Matrix, changes: Matrices) -> Matrix:
    """Rows that vanish exactly for the combinations that some X makes.

    The changes less their component in the space of those that are made of an X; all
    of the observable part of a plant.
    """
    n, p = len(A), len(C)
    pack, unpack = packing(n)
    pack_y, _ = packing(p)
    X = unpack(np.eye(n * (n + 1) // 2))
    made = kernels.compiled(silent_change, stacks=True)(A=A, C=C, X=X, X_next=X)

    def stacked(dQ: Matrix, dR: Matrix, dS: Matrix) -> Matrix:
        flat = dS.reshape(len(dS), n * p) * np.sqrt(2)
        return np.hstack([pack(dQ), pack_y(dR), flat]).T

    basis = stacked(made["dQ"], made["dR"], made["dS"])
    given = stacked(changes["Q"], changes["R"], changes["S"])
    return outside(given.T, np.linalg.qr(basis)[0].T).T


def _sparse(rows: Matrix) -> Matrix:
    """The same row space by Gauss and Jordan: each row has few unknowns."""
    rows, done = rows.copy(), 0
    for _ in range(len(rows)):
        i, j = np.unravel_index(np.abs(rows[done:]).argmax(), rows[done:].shape)
        rows[[done, done + i]] = rows[[done + i, done]]
        rows[done] /= rows[done, j]
        others = np.arange(len(rows)) != done
        rows[others] -= np.outer(rows[others, j], rows[done])
        done += 1
    largest = np.abs(rows).max(axis=1, keepdims=True, initial=0)
    return np.where(np.abs(rows) > SMALL * largest, rows, 0.0)


def _sentence(labels: Sequence[str], row: Vector, share: Vector) -> str:
    """A silent direction in words; `share` says which unknowns take part."""
    part = [int(k) for k in np.flatnonzero(share)]
    names = [labels[k] for k in part]
    if len(names) == 1:
        return f"{names[0]}, which leaves no trace in the outputs."
    if len(names) == 2:
        (a, b), ratio = names, -row[part[0]] / row[part[1]]
        word = {1.0: "the sum ", -1.0: "the difference "}.get(round(ratio, 9), "")
        size = "" if word else f"{abs(ratio):.4g} "
        sign = "+" if ratio > 0 else "-"
        return f"{a} and {b} apart, but only {word}{a} {sign} {size}{b}."
    ratios = " : ".join(f"{row[k]:.4g}" for k in part)
    listed = f"{', '.join(names[:-1])} and {names[-1]}"
    return f"{listed} apart, which may change together as {ratios}."


# -- instant by instant ----------------------------------------------------------------
# For plants that vary over time and records with gaps there is no constant gain.  The
# gains are those of a Kalman filter for noises of size one, under which errors die out.
# An instant shows a change of what the next error has in common with its innovation
# only as far as later outputs show that error.


def over_time(A: Matrix, C: Matrix, changes: Matrices, seen: Matrix) -> Matrix:
    """A square root (r, k) of what a record shows of stacks of changes, for any start.

    It is measured by what the record would show of them if the start were known.  The
    plant, or its stacks, and the changes are in even units.  What a part of a record
    shows, the record shows: later instants are left out where those before determine
    every change clearly.
    """
    n, rows = A.shape[-1], TOGETHER
    one = Plant(A, None, C, Q=np.eye(n), R=np.eye(C.shape[-2]), P0=np.eye(n), dt=1.0)
    while True:
        shown = _of_rows(one, changes, seen[:rows])
        values = np.linalg.svd(shown, compute_uv=False)
        if rows >= len(seen) or values.min(initial=1.0) > CLEAR:
            return shown
        rows *= 2


def _of_rows(plant: Plant, changes: Matrices, seen: Matrix) -> Matrix:
    n, count = plant.n, len(changes["Q"])
    first = packing(n)[1](np.eye(n * (n + 1) // 2))
    wide = {k: np.concatenate([np.zeros((len(first), *X.shape[1:])), X])
            for k, X in changes.items()}  # fmt: skip
    X = np.concatenate([first, np.zeros((count, n, n))])
    gains, at = Filter(plant).run(np.where(seen, 0.0, np.nan)).K, list[Any]()
    for k, here in enumerate(seen):
        now, L = plant.at(k + 1), plant.at(k + 1).A @ gains[k][:, here]
        at.append((now.A - L @ now.C[here], now.C[here], L))
    later = [np.zeros((0, n))]  # roots of what the rows after each show of its error
    for A_L, C, _ in at[:0:-1]:
        later.append(_triangle(np.vstack([C, later[-1] @ A_L])))
    step, rows = kernels.compiled(change_step, stacks=True), list[Matrix]()
    root = np.zeros((0, len(X)))
    for here, after, (A_L, C, L) in zip(seen, later[::-1], at):
        dR, dS = wide["R"][:, here][:, :, here], wide["S"][:, :, here]
        found = step(A_L=A_L, C=C, L=L, dQ=wide["Q"], dR=dR, dS=dS, X=X)
        for one in (found["dLambda_0"], after @ found["dN_1"]):
            rows.append(one.reshape(len(X), one[0].size).T)
        X = found["X_next"]
        if len(rows) >= 2 * TOGETHER:
            root, rows = _triangle(np.vstack([root, *rows])), list[Matrix]()
    root = _triangle(np.vstack([root, *rows]))
    # The start's covariance explains what it can; a record need not show all of it.
    given = root[:, len(first) :]
    largest = max(np.linalg.norm(given, 2), 1e-300)
    of_start, size, _ = np.linalg.svd(root[:, : len(first)], full_matrices=False)
    of_start = of_start[:, size > RANK_TOL * max(size.max(initial=0.0), largest)]
    left = outside(given.T, of_start.T).T / largest
    return np.pad(left, ((0, max(0, count - len(left))), (0, 0)))


def _triangle(X: Matrix) -> Matrix:
    """R of X = Q R."""
    found: Any = np.linalg.qr(X, mode="r")
    return np.asarray(found)
