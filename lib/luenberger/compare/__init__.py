"""One plant under every method: what each design gains, and what it costs.

What weighs designs against each other enters here.  It uses all papers, `analysis`,
`run`, `identification` and `export`, whose C it counts.
"""

from __future__ import annotations

from collections.abc import Collection, Iterable, Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.known_input import known_input
from ..arguments import expect
from ..errors import DesignError
from ..kernels.c.numbers import require_c_type
from ..numeric.combinations import combinations
from ..papers.poles import numbers
from ..plant import Plant
from ..plant.estimates import Combinations, by_name
from .attempts import Attempt as Attempt
from .attempts import noisy as noisy
from .budget import Budget as Budget
from .cases import Case as Case
from .cases import Spread as Spread
from .judge import judged, sizes
from .measure import attempt
from .methods import METHODS as METHODS
from .methods import Plan
from .question import Question
from .reasons import percent as percent
from .reasons import sigma as sigma
from .robust_table import Robustness as Robustness
from .table import TOLERANCE as TOLERANCE
from .table import Comparison as Comparison
from .transients import from_start as from_start
from .transients import transients as transients
from .unweighed import why_not as why_not


def compare(
    plant: Plant,
    *,
    k: Combinations | None = None,
    orders: Iterable[int] | None = None,
    poles: ArrayLike | None = None,
    methods: Iterable[str] | None = None,
    scale: ArrayLike | None = None,
    budget: Mapping[str, float] | Budget | None = None,
    dtype: str = "double",
) -> Comparison:
    """Try every method on one plant, and compare what comes of it.

    Tried are

    - the Kalman filter;
    - the Leondes-Novak filter for every set of outputs taken as accurate (with more
      than 4 outputs for the first 1, 2, ..., p; with more than 50 states for the first
      1, 2, 4, ..., p), with the paper's gain in its steady state and with the best
      constant gain; all outputs accurate is the minimal order;
    - the fixed-order filter of every order below n, with feedthrough, and for up to 5
      states without it; for more than 9 states orders 1 to 3 and for more than 100
      none, unless `orders` asks for others;
    - the reduced-order observer with `poles`;
    - the deadbeat observer;
    - the functional observer of k x of least order.

    Each is returned without states that its estimate never shows, and in the
    coordinates in which it is the least work: as designed, modal or companion, where
    the certificate is as good there and digits are kept.  They are where rounding moves
    no estimate more than ten times as far as in the design, or by less than 1e-9 of its
    size, in the numbers of `dtype` on a simulated record.

    What is left out is listed as not tried; with 200 states and 4 outputs the rest is
    a matter of seconds.

    Parameters
    ----------
    plant : Plant
        Without noise covariances, or in continuous time, only the last three apply,
        and nothing is recommended: designs are judged by noise gain and settling.
        Multiplicative noise is known to the fixed-order filter; other filters are
        designed for the additive noise that has the same covariance in steady state,
        and all are measured on the plant as it is.
    k : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        Default `plant.estimates`, if there are any, else the state.
        The comparison is then about k x: every design estimates it and nothing else,
        so that work, bytes and noise gain are counted alike; designs are ranked by the
        error of its rows, and functional observers join in.
    orders : iterable of int, optional
        Only designs of these orders.  States that the estimate never shows are left
        out afterwards.
    poles : (n - rank C,) array_like, optional
        Of the reduced-order observer.  Default those of the minimal-order
        Leondes-Novak filter with the best constant gain; where there is none, on a
        circle (Butterworth) three times as far out as the geometric mean of the
        rates of the plant's modes, in discrete time exp(s dt) of these; without
        noise covariances, or in continuous time, once, three and ten times.
    methods : iterable of str, optional
        Only these methods, by their names in the table.

    scale : (n,) array_like or float, optional
        Typical sizes of the states, or of the rows of k x: errors of equal importance.
        Designs are then ranked by the root mean square of their standard deviations
        in these units, and Leondes-Novak and fixed-order filters make that least (of
        k x, Leondes-Novak filters with the best constant gain do).  By default each
        standard deviation is compared with the one that the Kalman filter leaves of
        the same state, and the worst state counts, so that no units are added.
    budget : dict, optional
        The most that a design may cost, by one or more of ``multiply_adds`` (of a
        step), ``states`` and ``bytes`` (of state and constants).  The most accurate
        design within it is then recommended.  `Comparison.within` gives the same
        table under another budget.
    dtype : "double" or "float"
        What the device computes in.  Multiply-adds, operations and bytes are those of
        ``export.to_c(..., dtype=dtype)``.  Errors are those of exact arithmetic:
        `export.rounding_error` measures what float adds.

    Returns
    -------
    Comparison
        A design that was refused is listed with its reason.

    Raises
    ------
    DesignError
        If every design is refused.
    ValueError
        An unknown method, k that does not fit the plant, or no budget.

    See Also
    --------
    sweep : designs of your choice on many plants.
    plot.pareto : the picture.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]])
    >>> table = lb.compare(plant)
    >>> [(one.order, round(one.trace, 4), one.work) for one in table.pareto()]
    [(1, 0.28, 3), (1, 0.1813, 4), (2, 0.1806, 10)]
    >>> table.recommended().name
    'Leondes-Novak filter, y1 taken as accurate, best constant gain'
    >>> small = lb.compare(plant, budget=dict(multiply_adds=3))
    >>> small.recommended().work, small.next_beyond().work
    (3, 4)
    """
    expect(plant=plant)
    require_c_type(dtype)
    limits = None if budget is None else Budget.read(budget)
    k, called = by_name(plant.estimates or None if k is None else k, plant)
    rows = None if k is None else combinations("k", k, plant.n)
    asked = Question(
        plant,
        rows,
        None if poles is None else tuple(numbers(np.ravel(poles))),
        None if orders is None else _orders(orders, plant.n),
        sizes(scale, plant.n if rows is None else len(rows)),
        called,
    )
    _require_comparable(plant)
    if plant.U is not None:
        known_input(plant)  # or its error, once
    attempts = tuple(
        one
        for method in _chosen(methods)
        for plan in METHODS[method](asked)
        if _wanted(plan, asked.orders)
        for one in [attempt(plan, plant, asked.k, dtype, asked.orders)]
        if one is not None
    )
    if all(one.refusal for one in attempts):
        reason = attempts[0].refusal if attempts else f"none has {asked.orders} states"
        every = orders is None and methods is None
        what = (
            "no exact filter of any order" if every else "no design that is asked for"
        )
        raise DesignError(f"{what} exists: {reason}")
    found = judged(asked, attempts, asked.scale)
    return Comparison(plant, found, asked.k, limits, dtype, called)


def _require_comparable(plant: Plant) -> None:
    if plant.steps is not None:
        raise DesignError(
            "only a constant plant is compared, and this one varies over time. Design "
            "a filter over its steps: kalman_filter or reduced_order_filter with steps="
        )
    if plant.is_complex and noisy(plant):
        raise DesignError(
            "a complex plant is compared without noise: leave Q and R out, or separate "
            "real and imaginary parts into a real plant of twice the size"
        )


def _chosen(methods: Iterable[str] | None) -> list[str]:
    """The methods in the order of the table."""
    if methods is None:
        return list(METHODS)
    wanted = _listed(methods)
    if not wanted:
        raise ValueError(
            f"methods is empty; leave it out, or name some of {[*METHODS]}"
        )
    unknown = [name for name in wanted if name not in METHODS]
    if unknown:
        raise ValueError(f"there is no method {unknown[0]!r}; there are {[*METHODS]}")
    return [name for name in METHODS if name in wanted]


def _listed(given: Any) -> list[Any]:
    """One, or several, as a list."""
    several = np.iterable(given) and not isinstance(given, str)
    return list(given) if several else [given]


def _orders(orders: Iterable[int], n: int) -> tuple[int, ...]:
    found = tuple(_listed(orders))
    if not found:
        raise ValueError(f"orders is empty; leave it out, or give some of 0 to {n}")
    for order in found:
        whole = isinstance(order, (int, np.integer)) and not isinstance(order, bool)
        if not whole or not 0 <= order <= n:
            raise ValueError(
                f"orders must be whole numbers from 0 to {n}, got {order!r}"
            )
    return found


def _wanted(plan: Plan, orders: Collection[int] | None) -> bool:
    """Whether a plan has an order that was asked for, or none yet."""
    return orders is None or plan.order is None or plan.order in orders
