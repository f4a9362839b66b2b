"""The expected information of a record in directions in which a plant may move."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from .. import kernels
from ..arguments import expect
from ..numeric import Given, Matrix, Vector
from ..plant import Plant
from ..recursion.settings import Settings
from ..recursion.state import start
from ..recursion.units import natural
from . import diffuse
from .few_rows import rows_of
from .first_rows import first_stretch
from .likelihood import _records
from .likelihood_parts import Record
from .stretch import Carried, Stretch
from .ways import Ways, ways_of


def information(
    plant: Plant,
    y: Any,
    u: Any = None,
    *,
    along: Sequence[Mapping[str, Any]],
    u0: Given = None,
    backend: str = "auto",
) -> Matrix:
    r"""The expected (Fisher) information of a record in what a plant says.

    Move the plant in a direction i, and the record's likelihood L has a slope.
    Over all records of this plant, with gaps where y has them, the slopes have the
    mean zero and the covariance

    .. math:: I_{ij} = \sum_k \tfrac12 \operatorname{tr}
              (M^{-1} \dot M_i M^{-1} \dot M_j)
              + \operatorname{E}[\dot\nu_i' M^{-1} \dot\nu_j] ,

    with the innovations nu of the Kalman filter, their covariances M, and the
    derivatives of both in the directions i and j.  The inverse of I bounds the
    covariance of every unbiased estimate from below (Cramer and Rao), and that of the
    most likely one comes near it in long records.

    Parameters
    ----------
    plant : Plant
        Discrete, with Q and R: where the information is asked for.
    y, u, u0
        As in `log_likelihood`, and of a list of records the information adds up.
        Only where y has gaps matters; but see Notes for a plant without P0.
    along : list of dict
        Directions, such as ``[{"Q": [[1.0]]}, {"R": [[1.0]]}]``: changes of "A", "B",
        "C", "E", "Q", "R", "S", "x0" and "P0" together, in their shapes.  What is not
        named stays.
    backend : "auto", "numpy" or "numba"
        As in `log_likelihood`.

    Returns
    -------
    (k, k) ndarray
        In units of the likelihood's logarithm: the information of the number t in
        plant + t * direction, for the k directions.

    Raises
    ------
    ValueError
        If sizes disagree, or a change of a covariance is not symmetric.
    DesignError
        As in `log_likelihood`.

    See Also
    --------
    log_likelihood, fit_noise, identifiability

    Notes
    -----
    Where entries of y have no density, because those before determine them, it is the
    information of the others.

    Without P0 it is the information of the record given the readings, as many as there
    are states, that determine the state first: these say nothing of the noises by
    themselves, and their values matter only where A, B, C or E moves.

    A constant plant's record without gaps costs a fixed number of rows: when a row
    moves the covariance of the prediction by less than 1e-12 of its variances, as many
    rows more are taken as a settled filter needs to forget all but 1e-8 of any
    change.  What is left of the changes of a covariance is the square of that.  All
    rows between those and equally many at the end give the same information, to 1e-10
    of it.

    References
    ----------
    Schweppe, "Evaluation of likelihood functions for Gaussian signals", IEEE Trans.
    Inf. Theory 11 (1965) 61-70; Porat and Friedlander, "Computation of the exact
    information matrix of Gaussian time series with stationary random components",
    IEEE Trans. Acoust., Speech, Signal Process. 34 (1986) 118-130;
    identification/derivation/sensitivity.py; identification/derivation/information.py;
    identification/derivation/first_rows.py.

    Examples
    --------
    N readings of a number that is known, with noise of variance R, hold N / (2 R^2)
    on that variance.

    >>> import numpy as np, luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[2]], P0=[[0]])
    >>> lb.information(plant, np.zeros((1000, 1)), along=[{"R": [[1]]}])
    array([[125.]])
    """
    expect(plant=plant)
    unknown = plant.P0 is None
    settings = Settings(plant, 0)
    ways = ways_of(plant, along)
    records = [*_records(plant, y, u, u0)]
    fast = kernels.runs_compiled(backend, sum(len(one.y) for one in records))
    total = np.zeros((ways.count, ways.count))
    for one in records if ways.count else []:
        total += _of_record(settings, unknown, ways, one, fast)
    return total


def _of_record(
    settings: Settings, unknown: bool, ways: Ways, record: Record, fast: bool
) -> Matrix:
    """The information of one record."""
    plant, (y, u, u0) = settings.plant, record
    stretches, first = list[Stretch](), 0
    now = Carried.start(plant.x0[:, None], ways.dx0, ways.dP0)
    if unknown:
        head = diffuse.head(settings, y, u)
        state, first, free = head.state, len(head.trail.free), head.trail.free
        _, unit = natural(settings.at(1))
        stretches = [first_stretch(plant, ways, free, y[:first], u[:first], unit)]
        now = Carried(*(np.zeros_like(X) for X in now))
    else:
        state = start(settings, plant.x0, u0)
        stretches = [_from_start(plant, ways, u0)] * (not plant.at_first)
    stretches.append(rows_of(settings, ways, state, y[first:], u[first:], fast))
    Pi, told = np.zeros((plant.n, plant.n)), list[Matrix]()
    for one in reversed(stretches):
        rows, Pi = one.back(Pi, fast)
        told.insert(0, rows)
    total = np.zeros((ways.count, ways.count))
    for one, rows in zip(stretches, told):
        found, now = one.forward(rows, now, ways, fast)
        total += found
    return total


def _from_start(plant: Plant, ways: Ways, u0: Vector) -> Stretch:
    """The row at instant 0, which has no measurement."""
    n, m, at = plant.n, plant.m, plant.at(0)
    assert plant.P0 is not None
    none = np.zeros((n, 0))
    given = dict(A=at.A, B=at.B, C=none.T, E=np.zeros((0, m)), S=none)
    given |= dict(Omega=plant.P0, G=none, W=np.zeros((0, 0)))
    changes = ways.rows(0, 1)
    for name, rows, columns in (("C", 0, n), ("E", 0, m), ("S", n, 0), ("R", 0, 0)):
        changes[f"d{name}"] = np.zeros((1, ways.count, rows, columns))
    given = {name: X[None, None] for name, X in given.items()}
    return Stretch(given, changes, 1, u0[None, None, :, None], np.zeros(1, dtype=int))
