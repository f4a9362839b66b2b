"""The observer that forgets its start: exact after the fewest samples.

In staircase coordinates every row block of T A - F T = D C is solved from the one
above it, with zero diagonal blocks in F: Van Dooren's recursion with all poles zero,
one stair at a time, so that F^(p_M - 1) = 0 and not only F^(n - p) = 0.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import NoReturn

import numpy as np
import scipy.linalg

from ... import kernels
from ...arguments import expect
from ...errors import DesignError
from ...numeric import Matrix, Vector, rationals
from ...numeric.combinations import combinations
from ...numeric.even_pair import Pair
from ...numeric.independent_rows import default_tol, in_even_units, split_hidden
from ...numeric.linalg import modes
from ...observer import Observer
from ...plant import Plant
from ...plant.estimates import Combinations, by_name
from ..certified import certified, of_what_is_needed, state_observer
from .derivation import measured_gain, next_entries
from .form import find_form, require_discrete, solve_left

NOT_ZERO = 1e-6  # a hidden mode this large is named, whatever rounding does to it
ADVICE = {
    "staircase": "Add sensors, or ask for poles closer to those of the plant.",
    "canonical": "Use method='staircase', whose coordinates lose less.",
}
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
    if method not in ADVICE:
        raise ValueError(f"method must be 'staircase' or 'canonical', got {method!r}")
    even, found = in_even_units(plant.A, plant.C, plant.dt, default_tol(plant.n))
    L, called = by_name(L, plant)
    if L is not None:
        L = combinations("L", L, plant.n, field=complex)
    with of_what_is_needed(plant, L, NOT_ZERO):
        built = _staircase(even, found) if method == "staircase" else _canonical(plant)
    observer = state_observer(plant, built, even.natural, ADVICE[method])
    return certified(observer, plant, L=L, called=called)


def rows_of_T(
    A: Matrix,
    sizes: Sequence[int],
    inverses: list[Matrix],
    one: Callable[[int], Matrix],
    first: Matrix | None = None,
) -> tuple[Matrix, Matrix, Matrix]:
    """F, D, T of (13) in the coordinates of the last block, from the stairs of A.

    Row block i of T A - F T = [0 .. 0 D] is solved column by column: columns up to
    i - 1 give F, which is the subdiagonal of A; column c < last gives T[i, c + 1]
    through a left inverse of A[c + 1, c], `inverses[c]`; the last column gives D.
    `first` is the diagonal block of coordinates that no output sees; F keeps it.
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
    return F, D, T


def _staircase(even: Pair, found: list[Matrix]) -> Iterable[Matrix]:
    """F, D, T, P, V by orthogonal coordinates: hidden ones, then the levels, C last."""
    A, C, d, size, *_ = even
    n = len(A)
    hidden, zero, values = split_hidden(found, A, default_tol(n))
    if zero < len(hidden):
        _refuse(values)
    blocks = [block for block in (hidden, *found[::-1]) if len(block)]
    if not found:
        blocks.append(hidden[:0])  # no output sees anything
    sizes, U = [len(block) for block in blocks], np.vstack(blocks)
    A, at = U @ A @ U.conj().T, np.cumsum(sizes)
    for end, below in zip(at, at[1:]):
        A[below:, :end] = 0  # below the stairs
    A[zero:, :zero] = 0  # no output sees it
    stairs = zip([0, *at], at, at[1:])
    inverses = [np.linalg.pinv(A[b:c, a:b]) for a, b, c in stairs]
    first = np.triu(A[:zero, :zero], 1) if zero else None
    F, D, T = rows_of_T(A, sizes, inverses, np.eye, first)
    to_y = np.linalg.pinv(C @ blocks[-1].conj().T) / size
    to_y[:, ~C.any(axis=1)] = 0  # an output that shows nothing has no part in it
    full, one = np.vstack([T, np.eye(n)[len(T) :]]), np.eye(n)
    # solved from the left: the certificate is about P T + V C, not [T; C] [P V]
    X = scipy.linalg.solve_triangular(full, one, trans=1, unit_diagonal=True).T
    X = d[:, None] * (U.conj().T @ X)
    return F, D @ to_y, T @ U / d, X[:, : len(T)], X[:, len(T) :] @ to_y


def _refuse(values: Vector) -> NoReturn:
    decays = np.abs(values).max() < 1
    advice = (
        "An observer with other poles, such as kalman_filter, can estimate what decays "
        "by itself asymptotically."
        if decays
        else "Add a sensor that sees them."
    )
    raise DesignError(
        f"no deadbeat observer: the plant mode(s) {modes(values)} do not reach the "
        "outputs and are not zero, so no observer can forget a wrong start of them in "
        f"finite time. {advice}"
    )


def _canonical(plant: Plant) -> Iterable[Matrix]:
    """The same by Kawazoe's coordinates, sorted by level: stairs of units."""
    exactly = plant.exact is not None and plant.n <= EXACT_ORDER
    form, outputs = find_form(plant, "interleaved", None, exactly)
    one, _ = rationals.makers(form.exact)
    start = np.cumsum([0, *form.indices[:-1]])
    levels = [
        [first + k for first, size in zip(start, form.indices) if size > k]
        for k in reversed(range(form.samples))
    ]
    order = sum(levels, [])
    M, stairs = form.P[order], form.Phi[np.ix_(order, order)]
    n, sizes = plant.n, [len(own) for own in levels]
    picks = [  # of a stair the ones, which take each row to the next
        one(n)[np.ix_([k - 1 for k in above], own)]
        for above, own in zip(levels, levels[1:])
    ]
    F, D, T = rows_of_T(stairs, sizes, picks, one)
    r = len(T)
    T = T @ M
    X = solve_left(one(n), np.vstack([T, M[r:]]))
    F, D, T, X = (Y.astype(float) if form.exact else Y for Y in (F, D, T, X))
    to_y = np.eye(plant.p)[outputs]  # zeros for outputs that add nothing
    return F, D @ to_y, T, X[:, :r], X[:, r:] @ to_y
