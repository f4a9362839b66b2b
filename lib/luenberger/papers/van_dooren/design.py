"""Van Dooren's reduced order observer with prescribed poles.

Source: Van Dooren (1984); papers/van_dooren/derivation/rows.py.
"""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np
from numpy.typing import ArrayLike
from scipy.linalg.lapack import get_lapack_funcs

from ...arguments import expect
from ...errors import DesignError
from ...numeric import Matrix
from ...numeric.combinations import combinations
from ...numeric.even_pair import Pair, as_given
from ...numeric.staircase_form import Staircase, find_in_even_units, staircase
from ...observer import Observer
from ...plant import Plant
from ...plant.estimates import Combinations, by_name
from ..certified import certified, of_what_is_needed, state_observer
from ..poles import arranged, numbers
from . import rows_of_T
from .best_conditioned import best_conditioned
from .rows_of_T import Order, Rows, solve_rows

METHODS = {
    "best-conditioned": rows_of_T.minimum_norm,  # of which a search begins
    "minimum-norm": rows_of_T.minimum_norm,
    "back-substitution": rows_of_T.back_substitution,
}
SENSITIVE = 1e6  # condition of [T; C] that is worth a word
ADVICE = (
    "Add sensors, ask for poles closer to the eigenvalues of A, or give them in "
    "another order."
)


def reduced_order_observer(
    plant: Plant,
    poles: ArrayLike,
    *,
    L: Combinations | None = None,
    method: str = "best-conditioned",
    units: str = "even",
) -> Observer:
    r"""Observer of order n - rank C whose error decays with the poles asked for.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0, 1, 0], [0, 0, 1], [0, -24, -10]], [[0], [10], [-80]],
    ...                  [[1, 0, 0]])
    >>> observer = lb.reduced_order_observer(plant, [-10, -10])
    >>> observer.F.diagonal()
    array([-10., -10.])
    >>> lb.certify(observer, plant).worst < 1e-14
    True

    With several outputs the poles do not determine the observer; the one that is
    returned is well conditioned, which also means little noise in the estimate.  Of all
    poles, those of `reduced_order_filter` let in the least.

    Parameters
    ----------
    plant : Plant
        Constant and observable, real or complex, continuous or discrete, with or
        without feedthrough and redundant outputs.
    poles : (n - rank C,) array_like
        In rad/s (dt == 0) or in the z-plane.  For a real plant complex poles come
        in conjugate pairs; the second of a pair is moved up beside the first.
    L : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        Estimate L x; default x.  Rows may have names, and names of states and of
        `plant.estimates` stand for rows.
    method : "best-conditioned", "minimum-norm" or "back-substitution"
        Each row by least norm, (21), or by the cheapest solution, remark 2(b).  By
        default by least norm, and by a search where that is ill conditioned.
    units : "even" or "given"
        The units in which that is done: those that make the plant's numbers of like
        size, or the user's, as printed.

    Returns
    -------
    Observer
        Certified.  F has the poles on its diagonal, exactly; a conjugate pair of a real
        plant has a 2 x 2 block with diagonal a, a and determinant a^2 + b^2.

    Raises
    ------
    DesignError
        If the plant is not observable (the modes are named) or so close to that that no
        digit would be correct, varies in time, or the poles do not fit.
    CertificateError
        If a pole asked for is not stable.

    Warns
    -----
    RuntimeWarning
        When cond([T; C]) exceeds 1e6, states in even units and rows at unit length.

    References
    ----------
    Van Dooren (1984), (13)-(34); papers/van_dooren/derivation/rows.py, choices.py.
    """
    expect(plant=plant)
    poles = numbers(poles)
    L, called = by_name(L, plant)
    if L is not None:
        L = combinations("L", L, plant.n, field=complex)
    with of_what_is_needed(plant, L):
        pair, form = _stairs(plant, method, units, np.abs(poles).max(initial=0))
    form = rows_of_T.firm(form) if method == "back-substitution" else form
    poles, pairs = arranged(poles, plant.n - form.rank, plant)
    order = Order(poles / pair.rate, pairs)
    with np.errstate(all="ignore"):  # what overflows is refused below
        rows = solve_rows(form, order, METHODS[method])
        if method == "best-conditioned":
            natural = pair.natural / pair.states
            form, rows = best_conditioned(form, order, natural, rows)
        built = _in_users_coordinates(pair, form, rows)
        observer = state_observer(plant, built, pair.natural, ADVICE, SENSITIVE)
    return certified(observer, plant, L=L, called=called)


def _stairs(
    plant: Plant, method: str, units: str, fastest: float
) -> tuple[Pair, Staircase]:
    if method not in METHODS:
        raise ValueError(f"method must be one of {sorted(METHODS)}, got {method!r}")
    if units not in ("even", "given"):
        raise ValueError(f"units must be 'even' or 'given', got {units!r}")
    if plant.steps is not None:
        raise DesignError(
            "prescribed poles are for a constant plant, and this one varies over "
            f"{plant.steps} steps. Give one A and one C."
        )
    if units == "given":
        return as_given(plant.A, plant.C), staircase(plant.A, plant.C)
    return find_in_even_units(plant.A, plant.C, plant.dt, fastest)


def _in_users_coordinates(pair: Pair, form: Staircase, rows: Rows) -> Iterator[Matrix]:
    """F, D, T, P, V: (5), (12), (24), with the outputs compressed by Y."""
    r, U = form.rank, form.U
    S = np.vstack([rows.T, form.C[:r]])  # upper triangular, (13) and (8)
    (trtrs,) = get_lapack_funcs(("trtrs",), (S,))
    back = trtrs(S, U.T, trans=1)[0].T  # back S = U, n^3 / 2 of (25)
    outputs, x = form.Y[:, :r].conj().T / pair.outputs, pair.states
    yield rows.F * pair.rate
    yield rows.D @ outputs * pair.rate
    yield rows.T @ U.conj().T / x
    yield back[:, : rows.size] * x[:, None]
    yield back[:, rows.size :] @ outputs * x[:, None]
