"""The observer that forgets its start: exact after the fewest samples.

In staircase coordinates every row block of T A - F T = D C is solved from the one
above it, with zero diagonal blocks in F: Van Dooren's recursion with all poles zero,
one stair at a time, so that F^(p_M - 1) = 0 and not only F^(n - p) = 0.
"""

from __future__ import annotations

import warnings
from collections.abc import Callable, Sequence
from typing import NoReturn

import numpy as np
import scipy.linalg

from ... import kernels
from ...arguments import expect
from ...certificate import residuals
from ...errors import DesignError
from ...numeric import Matrix, Vector, rationals
from ...numeric.combinations import combinations
from ...numeric.even_pair import Pair
from ...numeric.independent_rows import default_tol, in_even_units, split_hidden
from ...numeric.linalg import modes
from ...observer import Observer
from ...plant import Plant
from ...plant.estimates import Combinations, by_name
from ..certified import (
    CONDITION_WARNING,
    LOST_TOL,
    certified,
    of_what_is_needed,
    state_observer,
)
from .derivation import measured_gain, next_entries
from .form import find_form, require_discrete, solve_left

Built = tuple[Matrix, ...]  # F, D, T, P, V
NOT_ZERO = 1e-6  # a hidden mode this large is named, whatever rounding does to it
EXACT_ORDER = 20  # beyond, fractions of thousands of digits take minutes


def deadbeat_observer(
    plant: Plant, *, L: Combinations | None = None, method: str = "staircase"
) -> Observer:
    r"""Deadbeat observer: F is nilpotent, the error is zero after p_M samples.

    Double integrator, T = 0.2 s (Ogata, Discrete-Time Control Systems, chapter 6):
    x2^ = 5 y[k] - 5 y[k-1] + 0.1 u[k-1].

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 0.2], [0, 1]], [[0.02], [0.2]], [[1, 0]], dt=0.2)
    >>> observer = lb.deadbeat_observer(plant)
    >>> (observer.P @ observer.D).round(9)[1], observer.V.round(9)[1]
    (array([-5.]), array([5.]))

    The state that `reconstruct_state` computes from p_M samples, kept up to date
    recursively with n - rank C numbers.

    Parameters
    ----------
    plant : Plant
        Discrete and constant.  Singular A, feedthrough and redundant outputs are
        allowed, and modes that no output sees if they die out in finite time.
    L : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        Estimate L x; default x.  Rows may have names, and names of states and of
        `plant.estimates` stand for rows.
    method : "staircase" or "canonical"
        The coordinates it is computed in: orthogonal ones, or Kawazoe's of an
        observable plant, where one of ints and Fractions is treated exactly.

    Returns
    -------
    Observer
        Of order n - rank C, with T and F strictly triangular by blocks, so
        all poles are exactly zero.  Whatever its start, the estimate is exact from
        the p_M-th sample on: row p_M - 1 of `estimate` (with hidden nilpotent modes,
        row max(p_M - 1, nu), nu the index of their block).

    Raises
    ------
    DesignError
        Continuous or time-varying plant; modes that no output sees and that are not
        zero, by name; a plant so ill-conditioned that no digit would be right.
    CertificateError
        If rounding spoils the design.

    See Also
    --------
    reduced_order_observer : any other poles; with several outputs its F has poles
        zero but need not be zero after p_M - 1 steps.

    References
    ----------
    Kawazoe (1978); Van Dooren (1984), equations (13)-(20) with f_ii = 0;
    papers/kawazoe/derivation/deadbeat.py.
    """
    expect(plant=plant)
    require_discrete(plant)
    if method not in ("staircase", "canonical"):
        raise ValueError(f"method must be 'staircase' or 'canonical', got {method!r}")
    even, found = in_even_units(plant.A, plant.C, plant.dt, default_tol(plant.n))
    L, called = by_name(L, plant)
    if L is not None:
        L = combinations("L", L, plant.n, field=complex)
    with of_what_is_needed(plant, L, NOT_ZERO):
        built = _staircase(even, found) if method == "staircase" else _canonical(plant)
    F, D, T, P, V = built
    observer = state_observer(plant, F + 0.0, D, T, P, V)  # no -0
    _judge(observer, plant, method, even.natural)
    return certified(observer, plant, L=L, called=called)


def _judge(observer: Observer, plant: Plant, method: str, d: Vector) -> None:
    """Refuse what has no digits left, warn of what has few.

    A residual can be small beside T and P and not beside x: both that of
    P T + V C = I and, through P, that of T A - F T = D C are measured in even units
    `d` of the states, as the error they put into the estimate.
    """
    o = observer
    dynamics, _, output, _ = residuals(
        plant.A, plant.B, plant.C, plant.E, o.L, o.F, o.G, o.D, o.P, o.V, o.W, o.T, o.T
    )
    lost = [np.linalg.norm(X / d[:, None] * d) for X in (output, o.P @ dynamics)]
    cond = _condition(np.vstack([o.T, plant.C]) * d)
    if not max(lost) <= LOST_TOL:
        advice = (
            "Add sensors, or take an observer with poles closer to those of the plant."
            if method == "staircase"
            else "Use method='staircase', whose coordinates lose less."
        )
        raise DesignError(
            f"cond([T; C]) = {cond:.1e}: the plant is so close to one that cannot be "
            "told from p_M samples that the estimate would have no correct digit. "
            f"{advice}"
        )
    if cond > CONDITION_WARNING:
        warnings.warn(
            f"cond([T; C]) = {cond:.1e}, states in even units and rows at unit length: "
            f"the deadbeat estimate loses up to {min(np.log10(cond), 16):.0f} digits, "
            "and amplifies noise as much.",
            RuntimeWarning,
            stacklevel=3,
        )


def _condition(M: Matrix) -> float:
    size = np.linalg.norm(M, axis=1, keepdims=True)
    if not np.isfinite(size).all():
        return np.inf
    M = (M / np.where(size > 0, size, 1))[size[:, 0] > 0]  # no sensor: no row
    return float(np.linalg.cond(M)) if M.size else 1.0


def rows_of_T(
    A: Matrix,
    sizes: Sequence[int],
    inverses: list[Matrix],
    one: Callable[[int], Matrix],
    first: Matrix | None = None,
) -> tuple[Matrix, Matrix, Matrix]:
    """T of (13), F, and D in the coordinates of the last block, from the stairs of A.

    Row block i of T A - F T = [0 .. 0 D] is solved column by column: columns up to
    i - 1 give F, which is the subdiagonal of A; column c < last gives T[i, c + 1]
    through a left inverse of A[c + 1, c]; the last column gives D.  `first` is the
    diagonal block of coordinates that no output sees; F keeps it.
    """
    entries, gain = kernels.compiled(next_entries), kernels.compiled(measured_gain)
    at = np.cumsum([0, *sizes])
    block = [slice(*pair) for pair in zip(at, at[1:])]
    order, last = at[-2], len(sizes) - 1
    T, F, D = A[:order] * 0, A[:order, :order] * 0, A[:order, order:] * 0
    T[:, :order] = one(order)
    for i, me in enumerate(block[:last]):
        above = block[max(i - 1, 0)]  # F has this block only
        if i:
            F[me, above] = A[me, above]
        elif first is not None:
            F[me, above] = first
        stair, known = F[me, above], slice(at[i], None)
        for c in range(i, last):
            upto = slice(at[i], at[c + 1])
            so_far = dict(T_c=T[me, upto], A_c=A[upto, block[c]], J_c=inverses[c])
            found = entries(A_i=stair, T_h_c=T[above, block[c]], **so_far)
            T[me, block[c + 1]] = found["T_n"]
        row = dict(T_i=T[me, known], A_m=A[known, order:])
        D[me] = gain(A_i=stair, T_h_m=T[above, order:], **row)["D_i"]
    return T, F, D


def _staircase(even: Pair, found: list[Matrix]) -> Built:
    """Orthogonal coordinates: hidden part on top, then the levels, C last."""
    A, C, d, size, *_ = even
    n = len(A)
    hidden, zero, values = split_hidden(found, A, default_tol(n))
    if zero < len(hidden):
        _refuse(values)
    first = np.triu(hidden @ A @ hidden.conj().T, 1) if zero else None
    blocks = [block for block in (hidden, *found[::-1]) if len(block)]
    if not found:
        blocks.append(hidden[:0])  # no output sees anything
    sizes = [len(block) for block in blocks]
    U = np.vstack(blocks)
    stairs, inverses = _stairs(U @ A @ U.conj().T, sizes, len(hidden))
    T, F, D = rows_of_T(stairs, sizes, inverses, np.eye, first)
    to_y = np.linalg.pinv(C @ blocks[-1].conj().T) / size
    to_y[:, ~C.any(axis=1)] = 0  # an output that shows nothing has no part in it
    X = _complete(T, np.eye(n)[len(T) :])
    X = d[:, None] * (U.conj().T @ X)
    return F, D @ to_y, T @ U / d, X[:, : len(T)], X[:, len(T) :] @ to_y


def _stairs(
    A: Matrix, sizes: Sequence[int], hidden: int
) -> tuple[Matrix, list[Matrix]]:
    """Set what is below the stairs to zero, and invert the subdiagonal blocks."""
    at = np.cumsum([0, *sizes])
    inverses = []
    for c in range(len(sizes) - 1):
        me = slice(at[c], at[c + 1])
        A[at[c + 2] :, me] = 0
        if c == 0 and hidden:
            A[at[1] :, me] = 0  # no output sees it
        inverses.append(np.linalg.pinv(A[at[c + 1] : at[c + 2], me]))
    return A, inverses


def _complete(T: Matrix, last: Matrix) -> Matrix:
    """X with X [T; last] = I, for T with unit upper triangular left part."""
    full = np.vstack([T, last])
    one = np.eye(len(full))
    # solved from the left: the certificate is about P T + V C, not [T; C] [P V]
    return scipy.linalg.solve_triangular(full, one, trans=1, unit_diagonal=True).T


def _refuse(values: Vector) -> NoReturn:
    which, decaying = modes(values), np.abs(values).max() < 1
    mode, do, are, it, decays = "mode", "does", "is", "it", "It decays by itself"
    if "," in which:
        mode, do, are, it, decays = "modes", "do", "are", "them", "They decay"
    advice = (
        f"{decays}: an observer with other poles, such as kalman_filter, can estimate "
        f"{it} asymptotically."
        if decaying
        else f"Add a sensor that sees {it}."
    )
    raise DesignError(
        f"no deadbeat observer: the plant {mode} {which} {do} not reach the outputs "
        f"and {are} not zero, so no observer can forget a wrong start of {it} in "
        f"finite time. {advice}"
    )


def _canonical(plant: Plant) -> Built:
    """Kawazoe's coordinates sorted by level: a staircase whose stairs hold units."""
    exactly = plant.exact is not None and plant.n <= EXACT_ORDER
    form, outputs = find_form(plant, "interleaved", None, exactly)
    one, zero = rationals.makers(form.exact)
    start = np.cumsum([0, *form.indices[:-1]])
    has = [
        [i for i, size in enumerate(form.indices) if size > k]
        for k in reversed(range(form.samples))
    ]
    order = [start[i] + form.samples - 1 - k for k, own in enumerate(has) for i in own]
    inverses = []
    for above, below in zip(has, has[1:]):  # row i of the stair is output i's unit
        inverse = zero(len(above), len(below))
        for k, i in enumerate(above):
            inverse[k, below.index(i)] += 1
        inverses.append(inverse)
    M = form.P[order]
    stairs = form.Phi[np.ix_(order, order)]
    T, F, D = rows_of_T(stairs, [len(own) for own in has], inverses, one)
    n, r = plant.n, len(T)
    T = T @ M
    X = solve_left(one(n), np.vstack([T, M[r:]]))
    F, D, T, X = (_rounded(Y) for Y in (F, D, T, X))
    to_y = np.eye(plant.p)[outputs]  # zeros for outputs that add nothing
    return F, D @ to_y, T, X[:, :r], X[:, r:] @ to_y


def _rounded(X: Matrix) -> Matrix:
    return X.astype(float) if X.dtype == object else X
