"""Designs on plants that differ from the one they were made for."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ..analysis.known_input import known_input
from ..analysis.step_cost import multiply_adds
from ..arguments import expect_as
from ..certificate import require_match
from ..errors import FIT, SAMPLE, DesignError, short
from ..numeric import Matrix
from ..numeric.combinations import combinations
from ..observer import Observer
from ..plant.estimates import Combinations, by_name
from .attempts import noisy
from .cases import Spread, cases
from .judge import sizes
from .perturbed import Made, Perturbed, Range, perturbed
from .robust_table import Robustness
from .table import Comparison, row_names


def robustness(
    observers: Any,
    plants: Any,
    *,
    ranges: Mapping[str, Range] | Made | None = None,
    samples: int = 100,
    seed: int = 0,
    k: Combinations | None = None,
    scale: ArrayLike | None = None,
) -> Robustness:
    r"""Judge designs on every plant that there may be: worst case, spread and choice.

    On each plant the error of a design, in the steady state, is measured beside that
    of the Kalman filter that knows this plant, as in `compare`: the largest ratio over
    the states,

    .. math:: \max_j \sqrt{\Sigma_{jj} / \Sigma^{Kalman}_{jj}} \ge 1 .

    The recommended design is the minimax choice, the one whose largest error over all
    plants is least.

    Parameters
    ----------
    observers : dict of str to Observer, list of Observer, or Comparison
        Constant designs.  Of a comparison, all its designs, with its `k` and `scale`.
    plants : dict of str to Plant, list of Plant, or Plant
        With Q and R; of the same numbers of states, inputs and outputs.  With `ranges`
        the nominal plant.  A continuous plant is sampled at the period of the designs,
        after its entries have been varied.  Where the known input disturbs an
        estimate, as it does on a plant of other dynamics, no error is known without U.
    ranges : dict or (callable, dict), optional
        Entries of the nominal plant, counted from 0, with their bounds:
        ``{"A[1,1]": (-0.65, -0.35)}``, or ``{"A[1,1]": "30 %"}`` of the nominal entry
        to either side; or a function of a vector of parameters that returns the plant,
        with their names and bounds: ``(made, {"damping": (0.35, 0.65)})``.  Judged
        are the nominal plant, with up to 4 parameters every corner of the ranges, and
        `samples` plants drawn evenly from within.
    samples, seed : int, default 100 and 0
        How many plants are drawn, and from which random stream.
    k : (n,) or (q, n) array_like, dict of str to (n,) array_like, or str, optional
        The error is then that of k x, of observers of x or of k x.  Rows may have
        names, and names of states and of `plant.estimates` stand for rows, those of
        the nominal or the first plant.
    scale : (n,) array_like or float, optional
        Typical sizes of the states, or of the rows of k x.  The error is then the root
        mean square of standard deviations in these units, and not a ratio.

    Returns
    -------
    Robustness
        A design whose error grows on a plant has an infinite error there.

    Raises
    ------
    DesignError
        If a plant has no noise covariances, or U does not fit.
    ValueError
        If sizes, names, `ranges` or anything else is not what it should be.

    See Also
    --------
    compare : designs for one plant.
    error_covariance : one design on one plant.
    plot.robustness : the picture.

    Examples
    --------
    Two filters of x+ = a x + w, y = x + v, where a lies between 0.5 and 0.9:

    >>> import luenberger as lb
    >>> def made(a):
    ...     return lb.Plant([[a]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]])
    >>> filters = {f"a = {a}": lb.kalman_filter(made(a)) for a in (0.5, 0.9)}
    >>> found = lb.robustness(filters, made(0.7), ranges={"A[0,0]": (0.5, 0.9)})
    >>> found.worst["a = 0.5"].plant, found.worst["a = 0.9"].plant
    ('A[0,0] = 0.9', 'A[0,0] = 0.5')
    >>> found.recommended().name
    'a = 0.9'
    """
    if isinstance(observers, Comparison):
        k = observers.asked if k is None else k
        scale = observers.scale if scale is None else scale
    designs = _designs(observers)
    every = perturbed(plants, ranges, samples, seed, next(iter(designs.values())).dt)
    given, called = by_name(k, every[0].plant)
    rows = _rows(designs, given)
    units = sizes(scale, len(rows))
    for one in every:
        _require(designs, one)
    found = [cases(designs, one, rows, units) for one in every]
    spreads = tuple(
        Spread(name, designs[name], multiply_adds(designs[name]), tuple(of_one))
        for name, of_one in zip(designs, zip(*found))
    )
    known = (called, _called(designs, rows), every[0].plant.state_names)
    called = next(filter(None, known))
    seed_of = None if ranges is None else seed
    return Robustness(spreads, every, units, seed_of, called, _is_state(rows))


def _designs(given: Any) -> dict[str, Observer]:
    """The designs by name."""
    if isinstance(given, Comparison):
        found = {one.title: one.observer for one in given.designs}
    elif isinstance(given, Mapping):
        found = {str(name): one for name, one in given.items()}
    elif np.iterable(given) and not isinstance(given, str):
        found = {f"design {k + 1}": one for k, one in enumerate(given)}
    elif isinstance(given, Observer):
        raise ValueError(
            "observers is one observer alone; give a list, [observer], or a dict by "
            "name"
        )
    else:
        raise ValueError(
            "observers must be a dict or a list of observers, or a comparison, got "
            f"{short(given)}"
        )
    if not found:
        raise ValueError("observers is empty; give at least one")
    for name, one in found.items():
        expect_as(f"observers[{name!r}]", "observer", one)
        if one.steps is not None:
            raise DesignError(
                f"design {name!r} varies over time, and steady errors are of constant "
                "designs; design without steps="
            )
    return found


def _is_state(rows: Matrix) -> bool:
    return np.array_equal(rows, np.eye(rows.shape[1]))


def _called(designs: Mapping[str, Observer], rows: Matrix) -> tuple[str, ...] | None:
    """What rows of k x are called: as the first design that names them does."""
    for one in designs.values():
        if one.estimates is not None and np.array_equal(one.L, rows):
            return one.estimates
    return None if _is_state(rows) else row_names(len(rows))


def _rows(designs: Mapping[str, Observer], k: Any) -> Matrix:
    """The rows of the state whose error is judged: k, or what all designs estimate."""
    first, o = next(iter(designs.items()))
    n = o.L.shape[1]
    if k is None:
        wanted, allowed = f"all must estimate the same, as {first!r}", [o.L]
    else:
        rows = combinations("k", k, n)
        wanted, allowed = "all must estimate x or k x", [rows, np.eye(n)]
    for name, one in designs.items():
        if not any(np.array_equal(one.L, L) for L in allowed):
            raise ValueError(
                f"design {name!r} has another L: {wanted}"
                + ("; k=... compares designs of x and of k x" if k is None else "")
            )
    return allowed[0]


def _require(designs: Mapping[str, Observer], one: Perturbed) -> None:
    """Refuse plants that no error is of."""
    plant = one.plant
    try:
        if plant.steps is not None or plant.is_complex:
            raise DesignError("plants must be constant and real")
        if not noisy(plant):
            advice = FIT if plant.dt > 0 else SAMPLE
            raise DesignError(f"it needs both noise covariances Q and R; {advice}")
        for observer in designs.values():
            require_match(observer, plant)
        if plant.U is not None:
            known_input(plant)
    except ValueError as error:
        raise type(error)(f"plant {one.name!r}: {error}") from None
