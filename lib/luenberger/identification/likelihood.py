"""The likelihood of a record, and its gradient in all that the plant says."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from concurrent.futures import Executor
from typing import Any, Literal, overload

import numpy as np

from .. import kernels
from ..arguments import expect
from ..errors import DesignError
from ..formats import dataframes
from ..numeric import Given, Matrices
from ..plant import Plant
from ..recursion.settings import accurate_outputs, require_noise
from ..run import chunks
from ..run.executor import in_order
from . import score
from .likelihood_parts import Part, Record, parts
from .records import named, several, split

Outputs = int | Sequence[int | str]  # how many, or which


@overload
def log_likelihood(
    plant: Plant, y: Any, u: Any = ..., *, m1: Outputs = ..., u0: Given = ...,
    gradient: Literal[False] = ..., each: Literal[False] = ..., backend: str = ...,
    executor: Executor | None = ...,
) -> float: ...  # fmt: skip
@overload
def log_likelihood(
    plant: Plant, y: Any, u: Any = ..., *, m1: Outputs = ..., u0: Given = ...,
    gradient: Literal[False] = ..., each: Literal[True], backend: str = ...,
    executor: Executor | None = ...,
) -> np.ndarray: ...  # fmt: skip
@overload
def log_likelihood(
    plant: Plant, y: Any, u: Any = ..., *, m1: Outputs = ..., u0: Given = ...,
    gradient: Literal[True], each: Literal[False] = ..., backend: str = ...,
    executor: Executor | None = ...,
) -> tuple[float, Matrices]: ...  # fmt: skip
@overload
def log_likelihood(
    plant: Plant, y: Any, u: Any = ..., *, m1: Outputs = ..., u0: Given = ...,
    gradient: Literal[True], each: Literal[True], backend: str = ...,
    executor: Executor | None = ...,
) -> tuple[np.ndarray, Matrices]: ...  # fmt: skip
def log_likelihood(
    plant: Plant,
    y: Any,
    u: Any = None,
    *,
    m1: Outputs = 0,
    u0: Given = None,
    gradient: bool = False,
    each: bool = False,
    backend: str = "auto",
    executor: Executor | None = None,
) -> Any:
    """The logarithm of the likelihood of a record under a plant.

    It is the density of y, given u, of a plant with Gaussian noises and a Gaussian
    start, as the product of the densities of the innovations of its Kalman filter:
    with nu the innovations and M their covariances,
    ``-1/2 sum (count log(2 pi) + log det M + nu' M^-1 nu)``.

    Outputs without noise may make M singular.  An entry of y that the entries before
    it determine, in the order of instants and then of outputs, has no density of its
    own; the likelihood is the density of the others, in the units of y.  That is the
    density of y on its support, with those others for coordinates there.

    Without P0 nothing is known of the state x[1] at the first row, whatever `at_first`
    and x0 say.  The density is then integrated over x[1]: it is the limit of
    ``log density + 1/2 log det(2 pi P0)`` as P0 grows.  That is exact, and no P0 is
    grown: the first rows, as few as determine the state, are solved for it.  It is the
    density of what the record shows beside its start (its contrasts), up to a factor
    that depends on A and C alone.  Durbin and Koopman, and statsmodels, count n more
    factors (2 pi)^(-1/2): their value is smaller by n/2 log(2 pi).

    Parameters
    ----------
    plant : Plant
        Discrete, with Q and R.
    y : (N, p) array_like or pandas.DataFrame, (M, N, p) array, or a list of records
        As in `filter_data`: row k is instant k + 1, and NaN was not measured.  Of many
        records, all of this plant and each with a start of its own, the likelihoods
        multiply, so that the sum of their logarithms is returned; see `each`.
    u : (N, m) array_like or DataFrame, or as many of them, optional
        Known inputs, as in `filter_data`; (N, m) for all records of an array.
    m1 : int or sequence, default 0
        Accurate outputs, as in `filter_data`.  A likelihood does not depend on the
        filter, so they must be outputs without noise, and nothing changes.
    u0 : (m,) array_like, or a list of them for a list of records, optional
        Input from instant 0 to 1, default zero.
    gradient : bool, default False
        Return the gradient as well, from one pass back over the record; it takes at
        most three times as long as the filter.
    each : bool, default False
        Return the value of each record, (M,), and gradients with the record first,
        instead of their sums.
    backend : "auto", "numpy" or "numba"
        As in `filter_data`.
    executor : concurrent.futures.Executor, optional
        Where many records are filtered, as in `filter_data`; it changes no bit.

    Returns
    -------
    float, (M,) ndarray with `each`, or (that, dict of str to ndarray)
        A record without a measurement has the likelihood 1, of which this is 0.  With
        ``gradient=True`` also the gradient in "A", "B", "C", "E", "Q", "R", "S", "x0"
        and "P0", as far as the plant has them, in their shapes.  Each is the matrix G
        with ``d log_likelihood = sum(G * dX)``.  In Q, R and P0 it is symmetric, for
        symmetric changes: the derivative along an entry above the diagonal, which
        moves its mirror image, is twice the entry of G.  Where entries of y have no
        density, it is the gradient of the density of the others.

    Raises
    ------
    ValueError
        If sizes disagree or a value is infinite.
    ImportError
        If numba is asked for and not installed.
    DesignError
        If the plant lacks Q or R, an accurate output has noise, or noise-free outputs
        contradict each other or a state known exactly: then the record is impossible;
        the message names outputs and instant.  If the plant lacks P0 and the record
        does not determine the state, being too short or not showing all of it.  If
        states grow so far in a gap that digits are gone, as in `filter_data`; rows
        before and behind it can be two records.

    See Also
    --------
    filter_data

    References
    ----------
    Schweppe, "Evaluation of likelihood functions for Gaussian signals", IEEE Trans.
    Inf. Theory 11 (1965) 61-70; Koopman and Shephard, "Exact score for time series
    models in state space form", Biometrika 79 (1992) 823-826; de Jong, "The diffuse
    Kalman filter", Ann. Statist. 19 (1991) 1073-1083;
    identification/derivation/likelihood.py; identification/derivation/score.py;
    identification/derivation/score_by_blocks.py;
    identification/derivation/unknown_start.py.

    Examples
    --------
    Two measurements of a number of variance 3, with noise of variance 1: they have
    the covariance [[4, 3], [3, 4]], whose determinant is 7.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[1]], P0=[[3]])
    >>> round(lb.log_likelihood(plant, [[0], [0]]), 4)
    -2.8108
    >>> many = [[[0], [0]], [[1], [1]]]  # two records; their sum without each=True
    >>> lb.log_likelihood(plant, many, each=True).round(4)
    array([-2.8108, -2.9537])
    >>> _, slope = lb.log_likelihood(plant, [[0], [0]], gradient=True)
    >>> slope["R"].round(4)
    array([[-0.5714]])
    """
    expect(plant=plant)
    require_noise(plant)
    require_noise_free(plant, m1)
    y, u = dataframes.taken(y=y, u=u)
    if executor is not None and not several(y, plant.p):
        raise ValueError("executor is for many records, (M, N, p), and y is one")
    records = [*_records(plant, y, u, u0)]
    fast = kernels.runs_compiled(backend, sum(len(one.y) for one in records))
    wanted = score.names(plant) if gradient else ()
    jobs = parts(plant, records, fast, wanted, each)
    every = [one for part in in_order(Part.found, jobs, executor) for one in part]
    gather = np.array if each else sum
    values = gather([value for value, _ in every])
    names = wanted if each or records else ()
    slopes = {name: gather([slope[name] for _, slope in every]) for name in names}
    return (values, slopes) if gradient else values


def require_noise_free(plant: Plant, m1: Outputs) -> None:
    """DesignError unless the outputs that are taken as accurate have no noise."""
    assert plant.R is not None
    for k in accurate_outputs(plant, m1):
        if np.any(plant.R[..., k, k]):
            raise DesignError(
                f"the output {plant.output_names[k]!r} is noisy, so a filter that "
                "treats it as exact leaves innovations that are not white, and their "
                "densities do not multiply to a likelihood. Use m1=0, or give the "
                "output no noise in R."
            )


def _records(plant: Plant, y: Any, u: Any, u0: Any) -> Iterator[Record]:
    """One record, or each of several."""
    pairs = split(y, u, plant.p)
    begin = [u0] * len(pairs)
    if isinstance(y, list | tuple) and several(y, plant.p) and u0 is not None:
        if not isinstance(u0, list | tuple) or len(u0) != len(pairs):
            raise ValueError(
                f"y is a list of {len(pairs)} records, so u0 must be a list as long"
            )
        begin = list(u0)
    for k, ((y, u), first) in enumerate(zip(pairs, begin)):
        with named(k, len(pairs)):
            yield _record(plant, y, u, first)


def _record(plant: Plant, y: Any, u: Any, u0: Any) -> Record:
    """The record as arrays that were checked."""
    outputs, inputs = (plant.p, plant.output_names), (plant.m, plant.input_names)
    y, u = chunks.arrays(y, u, outputs, inputs, missing=True)
    if plant.steps is not None and len(y) >= plant.steps:
        raise ValueError(
            f"the plant has rows for instants 0 .. {plant.steps - 1}, the data "
            f"reach instant {len(y)}"
        )
    u0 = dataframes.entries("u0", u0, plant.input_names)
    u0 = np.zeros(plant.m) if u0 is None else chunks.single("u0", u0, plant.m)
    return Record(y, u, u0)
