"""Haddad and Bernstein's filter: of all estimators of a given order the best."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import replace
from numbers import Integral
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...analysis.known_input import known_input
from ...analysis.optimality import optimality
from ...arguments import expect
from ...errors import CertificateError, DesignError
from ...numeric import Matrix
from ...numeric.combinations import combinations
from ...numeric.linalg import decaying, modes
from ...observer import Observer
from ...plant import Plant
from ...plant.estimates import Combinations, by_name
from ...recursion.settings import require_noise
from ...recursion.weight import positive_weight
from .assembly import observer_of, projected, signs
from .driven import driven_search
from .search import Minimum, Search, directions, minima
from .target import prediction, target


def fixed_order_filter(
    plant: Plant,
    order: int,
    *,
    L: Combinations | None = None,
    weight: ArrayLike | None = None,
    feedthrough: bool = True,
    starts: int = 24,
    seed: int = 0,
) -> Observer:
    r"""The estimator of a given order with the least steady error.

    The best one-state estimate of x1 of a plant with two states; the Kalman filter
    has 0.485934.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.9, 0.1], [0.2, 0.7]], None, [[0, 1]], dt=1.0,
    ...                  Q=[[0.1, 0], [0, 0]], R=[[1]])
    >>> observer = lb.fixed_order_filter(plant, 1, L=[[1, 0]])
    >>> observer.F.round(6), observer.V.round(6)
    (array([[0.83029]]), array([[0.198368]]))
    >>> round(lb.optimality(observer, plant).cost, 6)
    0.485938

    Of all stable systems of that order it has the least mean square error, a minimum
    that a search over many starts has found.

    Parameters
    ----------
    plant : Plant
        Discrete, constant and stable (mean-square stable with multiplicative noise),
        with Q and R.  With U the filter is the best for such an input.
    order : int
        1 to n.  At n it is the Kalman filter, multiplicative noise included.
    L : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        Estimate L x; default x.  Rows may have names, and names of states and of
        `plant.estimates` stand for rows.
    weight : (q, q) array_like, optional
        Positive definite; default the identity, the error trace of L x.
    feedthrough : bool, default True
        Whether w^ at i may use y at i; else V = 0, a prediction.
    starts, seed : int
        Number of starts of the search, and the seed of the random half of them.  The
        result is the same whenever these are.

    Returns
    -------
    Observer
        Every residual of `optimality` is below 1e-8.  Without U the estimate is best
        for u = 0: unless T is exact (`certify`), what is left of x beside z moves with
        u.  With it G and W are as free as D and V.

    Raises
    ------
    DesignError
        A plant that is not (mean-square) stable; an order out of range, or so high
        that states would be superfluous; outputs that add nothing; no Q or R.
    CertificateError
        If no start leads to a minimum that meets its conditions: take a lower order.

    References
    ----------
    Haddad and Bernstein (1987), equations (3.10)-(3.27);
    papers/haddad_bernstein/derivation/stationarity.py, equations.py.
    """
    expect(plant=plant)
    L, called = by_name(L, plant)
    options: Any = dict(L=L, weight=weight, feedthrough=feedthrough)
    found = fixed_order_search(plant, order, **options, starts=starts, seed=seed)
    found.best.optimality.require()
    return replace(found.best.observer, estimates=called)


def fixed_order_search(
    plant: Plant,
    order: int,
    *,
    L: Combinations | None = None,
    weight: ArrayLike | None = None,
    feedthrough: bool = True,
    starts: int = 24,
    seed: int = 0,
) -> Search:
    """The local minima that `fixed_order_filter` chooses from.

    Two modes and one filter state, which can follow either of them.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.9, 0], [0, -0.8]], None, [[1, 1]], dt=1.0,
    ...                  Q=[[1, 0], [0, 1]], R=[[1]])
    >>> found = fixed_order_search(plant, 1, L=[[1, 1]])
    >>> [(round(one.excess, 4), one.observer.F.round(4)) for one in found.minima]
    [(0.049, array([[0.7214]])), (0.0909, array([[-0.8536]]))]

    Parameters
    ----------
    plant, order, L, weight, feedthrough, starts, seed
        As of `fixed_order_filter`.

    Returns
    -------
    Search

    Raises
    ------
    DesignError, CertificateError
        As `fixed_order_filter`; residuals of the minima are reported, not judged.

    References
    ----------
    Haddad and Bernstein (1987), Theorem 3.1;
    papers/haddad_bernstein/derivation/sensitivity.py.
    """
    expect(plant=plant)
    _require(plant, order, feedthrough, starts, seed)
    L = np.eye(plant.n) if L is None else by_name(L, plant)[0]
    L = combinations("L", L, plant.n)
    weight = positive_weight(np.eye(len(L)) if weight is None else weight, len(L))

    def search(plant: Plant, L: Matrix) -> Search:
        return _found(plant, order, L, weight, feedthrough, starts, seed)

    alone = replace(plant, U=None)
    if plant.U is None or not plant.m:
        return search(alone, L)
    given = known_input(plant)  # whatever it is, order n needs no more than (3.19)
    if order == plant.n:
        return search(alone, L)
    return driven_search(search, alone, L, given)


def _found(
    plant: Plant,
    order: int,
    L: Matrix,
    weight: Matrix,
    feedthrough: bool,
    starts: int,
    seed: int,
) -> Search:
    """The search itself, of a plant whose input is zero."""
    whole = prediction(plant, L, weight, feedthrough)

    def judged(observer: Observer, excess: float, names: Iterable[str]) -> Minimum:
        residuals = optimality(observer, plant, weight=weight, feedthrough=feedthrough)
        return Minimum(observer, whole.cost + excess, excess, residuals, tuple(names))

    def in_full(G: Matrix, Gam: Matrix) -> Search:
        full = judged(projected(plant, whole, G, Gam), 0.0, ["the Kalman filter"])
        return Search((full,), (), whole.cost, order)

    if order == plant.n:
        return in_full(np.diag(1 / whole.states), np.diag(whole.states))
    sought = target(whole)
    every = directions(sought)
    enough = len(every.strength)
    if order > enough:
        raise _superfluous(order, enough, plant.n)
    if order == enough:
        sign = signs(every.read / whole.states)
        return in_full(sign * every.lift.T, sign * every.read)
    known, failed = minima(sought, every, order, starts, seed)
    if not known:
        raise CertificateError(_nowhere(order, failed))
    found = tuple(
        judged(observer_of(plant, whole, sought, frame), frame.point.cost, names)
        for frame, names in known
    )
    return Search(found, tuple(failed), whole.cost, enough)


def _require(
    plant: Plant, order: int, feedthrough: bool, starts: int, seed: int
) -> None:
    """Refuse what the paper's problem does not cover."""
    if plant.steps is not None:
        raise DesignError("the fixed-order filter is for a constant plant")
    require_noise(replace(plant, multiplicative=()))
    for name, value, least, most in (
        ("order", order, 1, plant.n),
        ("starts", starts, 1, np.inf),
        ("seed", seed, 0, np.inf),
    ):
        whole = isinstance(value, Integral) and not isinstance(value, bool)
        if not whole or not least <= value <= most:
            limit = f"to n = {most}" if name == "order" else "up"
            raise DesignError(
                f"{name} must be a whole number from {least} {limit}, got {value!r}"
            )
    if not isinstance(feedthrough, bool | np.bool_):
        raise ValueError(f"feedthrough must be True or False, got {feedthrough!r}")
    poles = np.linalg.eigvals(plant.A)
    lasting = ~decaying(poles, True)
    if lasting.any():
        raise DesignError(
            "the fixed-order filter is for stable plants, and A has the mode "
            f"{modes(poles[lasting])} on or outside the unit circle. What "
            "the filter does not track would grow without bound. Use kalman_filter or "
            "reduced_order_filter, which need no stability, or split the unstable part "
            "off and filter it in full."
        )


def _superfluous(order: int, enough: int, n: int) -> DesignError:
    if enough == 0:
        return DesignError(
            "no filter state is of use: the static estimate V y is as good as the "
            f"Kalman filter's. Use order n = {n}, or V alone."
        )
    return DesignError(
        f"order {order} is more than it takes: L x^ of the Kalman filter needs only "
        f"{enough} states, and more would be driven by nothing or used for nothing. "
        f"Order {enough} loses nothing (one or two less will do if rounding spoils "
        f"its conditions); order n = {n} gives the whole Kalman filter."
    )


def _nowhere(order: int, failed: list[tuple[str, str]]) -> str:
    reasons = sorted({reason for _, reason in failed})
    return (
        f"no start led to a filter of order {order}: {'; '.join(reasons)}. Try a lower "
        "order, more starts or another seed, or scale states and outputs to similar "
        "sizes."
    )
