"""Free entries of the rows, and an order of the poles, for the best condition.

With r > 1 outputs a row has r - 1 free entries.  Searches over them, from rows of pairs
and from their mirror images, and over orders of the poles, go through the observers
with these poles.  What is made least is

    J = sum over rows k of [T; C] of |row k|^2 |column k of its inverse|^2,

the sum of 1 / sin^2 of the angles between each row and the span of the others.  The
lengths of rows do not matter.  With rows of unit length sqrt(n J) is the condition in
the Frobenius norm.

Source: papers/van_dooren/derivation/choices.py; the search is our own.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
import scipy  # its parts load when first used

from ...errors import DesignError
from ...numeric import Matrix, Vector
from ...numeric.staircase_form import Staircase
from .rows_of_T import Order, Rows, firm, minimum_norm, slopes, solve_rows, with_entries

WELL = 1e3  # condition up to which the rows of least norm are kept
MUCH = 4.0  # times less J must be for another order, or for other rows
SEARCH_UP_TO = 100  # states
FEW_PAIRS = 4  # whose mirror images are tried one by one too
EVALUATIONS, FEWEST, MOST = 2000, 20, 60  # of J: the first over n, within the others
FLAT = 1e-4  # relative decrease of log J in an iteration that ends the search
FAR = 1e3  # in place of log J where there is none


def best_conditioned(
    form: Staircase, order: Order, weights: Vector, found: Rows
) -> tuple[Staircase, Rows]:
    """Rows with the same poles and a better conditioned [T; C], if there are.

    Parameters
    ----------
    form : Staircase
    order : Order
        As asked for.
    weights : (n,) ndarray
        Natural units of the states, in those of the form.
    found : Rows
        The rows of least norm in that order: kept where they are well conditioned, and
        where nothing is much better.

    Returns
    -------
    form : Staircase
        The same, or turned so that its stairs are safe to divide by.
    rows : Rows
    """
    n, r = len(form.A), form.rank
    before, _ = slant(found, weights)
    if r in (1, n) or n > SEARCH_UP_TO or n * before < WELL**2:
        return form, found
    turned = firm(form)
    plain = [_least_norm(turned, one, weights) for one in _orders(order)]
    J, chosen, rows = min(plain, key=lambda one: one[0])
    if not MUCH * J < plain[0][0]:
        J, chosen, rows = plain[0]
    if rows is None:
        return form, found
    starts = [rows, *_mirrored(chosen, rows)]
    ends = [_searched(chosen, weights, one) for one in starts]
    rows = min(ends, key=lambda one: slant(one, weights)[0])
    after, _ = slant(rows, weights)
    return (turned, rows) if MUCH * after < before else (form, found)


def _orders(order: Order) -> list[Order]:
    """The order given, its reverse, and with conjugate pairs first or last."""
    first = np.flatnonzero(~np.concatenate([[False], order.pairs[:-1]]))
    pairs, single = (first[order.pairs[first] == kind] for kind in (True, False))
    tried = [first, first[::-1]]
    if len(pairs) and len(single):
        tried += [np.concatenate([pairs, single]), np.concatenate([single, pairs])]
    rows = [[k + j for k in one for j in range(1 + order.pairs[k])] for one in tried]
    return [Order(order.poles[one], order.pairs[one]) for one in rows]


def _least_norm(
    form: Staircase, order: Order, weights: Vector
) -> tuple[float, Order, Rows | None]:
    """J of the rows of least norm in this order; infinite where it cannot be told."""
    try:
        rows = solve_rows(form, order, minimum_norm)
    except DesignError:
        return np.inf, order, None
    J, _ = slant(rows, weights)
    return (J, order, rows) if np.isfinite(J) else (np.inf, order, None)


def _mirrored(order: Order, rows: Rows) -> Iterator[Rows]:
    """The rows with free entries of conjugate pairs conjugated: all, and one by one.

    A pair's second row is where its entries are imaginary.  Its sign is open, and
    between a row and its mirror image the rows of a pair become dependent, which no
    descent crosses.
    """
    pairs = [k for k, step in enumerate(rows.steps) if step.size is not None]
    alone = [[k] for k in pairs] if 1 < len(pairs) <= FEW_PAIRS else []
    begin = [rows.free(step) for step in rows.steps]
    for turned in [pairs, *alone] if pairs else []:
        free = [x.conj() if k in turned else x for k, x in enumerate(begin)]
        try:
            yield solve_rows(rows.form, order, with_entries(free))
        except DesignError:
            continue


def slant(rows: Rows, weights: Vector) -> tuple[float, Matrix]:
    """J, and its gradient in T_U: it changes by Re sum conj(gradient) dT_U."""
    K = rows.form.U.conj().T * weights
    both = np.concatenate([rows.T, rows.form.C[: rows.r]]) @ K
    try:
        back = np.linalg.inv(both)
    except np.linalg.LinAlgError:
        return np.inf, np.zeros_like(rows.T)
    lengths, shares = (np.abs(both) ** 2).sum(axis=1), (np.abs(back) ** 2).sum(axis=0)
    turn = back.conj().T
    slope = shares[:, None] * both - turn @ (back * lengths) @ turn
    J = float(lengths @ shares)
    return J if np.isfinite(J) else np.inf, (2 * slope @ K.conj().T)[: rows.size]


def _searched(order: Order, weights: Vector, start: Rows) -> Rows:
    """Rows in this order whose J is small: L-BFGS from the free entries of `start`.

    The entries of a row are measured by the largest of it.
    """
    begin = [start.free(step) for step in start.steps]
    real = [free.view(float) for free in begin]
    centre, cuts = np.concatenate(real), np.cumsum([part.size for part in real])[:-1]
    tops = [np.abs(step.x).max() for step in start.steps]
    scale = np.repeat(tops, [part.size for part in real])

    def with_free(v: Vector) -> Rows:
        parts = zip(np.split(centre + scale * v, cuts), begin)
        free = [part.view(like.dtype) for part, like in parts]
        return solve_rows(start.form, order, with_entries(free))

    def cost(v: Vector) -> tuple[float, Vector]:
        try:
            rows = with_free(v)
        except DesignError:
            return FAR, np.zeros_like(v)
        J, slope = slant(rows, weights)
        if not np.isfinite(J):
            return FAR, np.zeros_like(v)
        parts = [part.view(float) for part in slopes(rows, slope)]
        return np.log(J), np.concatenate(parts) * scale / J

    most = int(np.clip(EVALUATIONS / start.n, FEWEST, MOST))
    limits = dict(maxfun=most, maxcor=20, ftol=FLAT, gtol=0)
    found = scipy.optimize.minimize(
        cost, np.zeros_like(centre), jac=True, method="L-BFGS-B", options=limits
    )
    return with_free(found.x)
