"""Designs beside each other, on one plant or many: what each gains and what it costs.

`designs` has what is tried, `judge` measures it, `choice` takes one, `words` say why,
`table` shows it, and `plants` are those that there may be.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import replace
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.known_input import known_input
from ..arguments import expect
from ..errors import DesignError
from ..numeric.combinations import combinations
from ..observer import Observer
from ..plant import Plant
from ..plant.estimates import Combinations, by_name
from .choice import TOLERANCE as TOLERANCE
from .choice import Budget as Budget
from .choice import more_orders
from .designs import KALMAN as KALMAN
from .designs import METHODS as METHODS
from .designs import NO_ORDER_ABOVE, Candidate, Question, fixed_order, left_out, own
from .designs import candidates as candidates
from .designs import noisy as noisy
from .judge import NOMINAL as NOMINAL
from .judge import Case as Case
from .judge import Design as Design
from .judge import made, on_plant, sizes
from .plants import judged_on
from .plants import vary as vary
from .table import Comparison as Comparison
from .words import percent as percent
from .words import why_not as why_not


def compare(
    plant: Plant,
    designs: Any = None,
    *,
    plants: Mapping[str, Plant] | None = None,
    L: Combinations | None = None,
    scale: ArrayLike | None = None,
    budget: Mapping[str, Any] | Budget | None = None,
) -> Comparison:
    """Compare designs for a plant: what each loses, what it costs, which one to take.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...                  Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]])
    >>> table = lb.compare(plant)
    >>> [(one.order, round(one.error, 3), one.work) for one in table.pareto()]
    [(1, 1.257, 3), (1, 1.011, 4), (2, 1.0, 10)]
    >>> table.recommended().name
    'Leondes-Novak filter, y1 taken as accurate, best constant gain'
    >>> small = lb.compare(plant, budget=dict(multiply_adds=3))
    >>> small.recommended().work, small.next_beyond().work
    (3, 4)
    >>> mine = {"Kalman": lb.kalman_filter, "raw": lb.deadbeat_observer}
    >>> unsure = lb.vary(plant, {"A[1,1]": (0.9, 1.0)}, samples=9)
    >>> lb.compare(plant, mine, plants=unsure).find("Kalman").worst_on
    'A[1,1] = 0.9'

    Parameters
    ----------
    plant : Plant
        Constant.  Without noise covariances, or in continuous time, nothing is
        recommended: designs are judged by noise gain and settling.  Of a design that
        its known input disturbs no error is known unless `with_input` says what that
        is like.
    designs : dict or list, optional
        Observers, or functions of the plant that return one, by name.  Default
        `candidates(plant)`, every method; and then fixed orders above the first few
        where they could win, by bisection up to the rule or the budget.
    plants : dict of str to Plant, optional
        Plants that there may be, as `vary` makes them.  Each design is judged on all
        of them and on `plant`, and its error is that on the worst of them.
    L : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        Estimate L x and nothing else; default `plant.estimates`, else the state.
    scale : (q,) array_like or float, optional
        Typical sizes of what is estimated.  Designs are then made for, and ranked by,
        the root mean square of standard deviations in these units.  By default each
        standard deviation is compared with the one that the plant's own Kalman filter
        leaves, and the worst counts, so that no units are added.
    budget : dict, optional
        The most that a design may cost, by one or more of ``multiply_adds`` of a step,
        ``states`` and ``bytes``; the most accurate within it is recommended.  And
        ``dtype="float"`` for a device that computes in it.

    Returns
    -------
    Comparison
        A design that was refused is listed with its reason.

    Raises
    ------
    DesignError
        If the library's methods are all refused, or the plants are not comparable.
    """
    expect(plant=plant)
    _require_comparable(plant)
    limits = Budget.read(budget)
    tried = [*candidates(plant).values()] if designs is None else own(designs)
    asked = _question(plant, designs, L, scale)
    every = judged_on(plant, plants)
    given = [made(one, asked, limits.dtype) for one in _with_bar(tried)]
    rows = np.eye(plant.n) if asked.rows is None else asked.rows
    judged = _judged(given, asked, rows, every)
    if all(one.refusal and one.method in METHODS for one in judged):
        raise DesignError(f"no design exists: {judged[0].refusal}")
    table = Comparison(
        plant, tuple(judged), every, asked.rows, _names(asked, given, len(rows)),
        asked.scale, limits,
    )  # fmt: skip
    return table if designs is not None else _with_more(table, asked, rows)


def _question(
    plant: Plant,
    designs: Any,
    L: Combinations | None,
    scale: ArrayLike | None,
) -> Question:
    """What is wanted: L, else the plant's estimates, else those of an observer."""
    if L is None and not plant.estimates and designs is not None:
        values = designs.values() if isinstance(designs, Mapping) else designs
        for one in values:
            if isinstance(one, Observer) and one.L.shape[1] == plant.n:
                L = one.L if one.estimates is None else dict(zip(one.estimates, one.L))
                break
    given, called = by_name(plant.estimates or None if L is None else L, plant)
    rows = None if given is None else combinations("L", given, plant.n)
    if rows is not None and np.array_equal(rows, np.eye(plant.n)) and called is None:
        rows = None
    count = plant.n if rows is None else len(rows)
    if plant.U is not None:
        known_input(plant)  # or its error, once
    return Question(plant, rows, called, sizes(scale, count))


def _names(asked: Question, designs: Sequence[Design], count: int) -> tuple[str, ...]:
    """What is estimated, by name: as asked, or as the first design that names it."""
    if asked.rows is None:
        return asked.plant.state_names
    own = [o.estimates for one in designs if (o := one.observer) and o.estimates]
    return asked.called or next(
        iter(own), tuple(f"row {k + 1} of L x" for k in range(count))
    )


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


def _judged(
    designs: Sequence[Design],
    asked: Question,
    rows: Any,
    plants: Mapping[str, Plant],
) -> list[Design]:
    """The designs with what they are worth on each plant; refused without an error."""
    for one in designs:
        if one.observer is not None:
            _require_rows(one, rows)
    if not noisy(asked.plant):
        return [*designs]
    able = [one for one in designs if not one.refusal]
    known = next((one for one in able if one.method == KALMAN), None)
    cases: list[dict[str, Case]] = [{} for _ in able]
    for name, plant in plants.items():
        own = known if name == NOMINAL else None
        for of_one, case in zip(cases, on_plant(able, asked, rows, plant, own)):
            of_one[name] = case
    found = iter(
        replace(one, cases=of_one, refusal=_grows(of_one))
        for one, of_one in zip(able, cases)
    )
    return [one if one.refusal else next(found) for one in designs]


def _grows(cases: Mapping[str, Case]) -> str:
    """Why a design has no error on the plant that it is for."""
    own = cases[NOMINAL]
    return own.refusal if own.error == np.inf and own.covariance is None else ""


def _require_rows(one: Design, rows: Any) -> None:
    assert one.observer is not None
    L = one.observer.L
    if not (np.array_equal(L, rows) or np.array_equal(L, np.eye(L.shape[1]))):
        raise ValueError(
            f"design {one.name!r} estimates other combinations of the states than the "
            "rest: all must estimate x or L x. Give compare its L=, or leave it out"
        )


def _with_more(table: Comparison, asked: Question, rows: Any) -> Comparison:
    """The table with fixed orders that could win, and what was left out."""
    untried = [*left_out(table.plant)]

    def tried(order: int) -> Design:
        one = made(fixed_order(order), asked, table.budget.dtype)
        return _judged([one], asked, rows, table.plants)[0] if not one.refusal else one

    found = [*more_orders(table, tried)]
    missed = [one for one in found if one.error is None]
    if table.plant.n > NO_ORDER_ABOVE or missed:
        untried.append("fixed-order filters of other orders")
    if not found and not untried:
        return table
    at = max(k for k, one in enumerate(table.every) if one.method in METHODS[:3]) + 1
    every = [*table.every[:at], *sorted(found, key=_order), *table.every[at:]]
    searched = tuple(one.order for one in found if one.order is not None)
    return replace(table, every=tuple(every), untried=tuple(untried), searched=searched)


def _order(one: Design) -> int:
    return one.order or 0


def _with_bar(tried: Sequence[Candidate]) -> Iterator[Candidate]:
    """The candidates, and on a terminal a line that says which one is being made."""
    shown = sys.stderr.isatty()
    began = time.monotonic()
    for k, one in enumerate(tried):
        if shown and time.monotonic() - began > 1:
            name = f"{one.method}, {one.label}"[:50]
            done = "#" * (20 * k // len(tried))
            print(f"\r[{done:20}] {name:50}", end="", file=sys.stderr, flush=True)
        yield one
    if shown:
        print("\r" + 74 * " " + "\r", end="", file=sys.stderr, flush=True)
