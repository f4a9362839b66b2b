"""What one constant observer costs on a device, counted from the step that it runs."""

import dataclasses
from typing import Any, NamedTuple

import numpy as np

from ..arguments import expect
from ..kernels.c.numbers import BYTES, representable, require_c_type
from ..numeric import Matrix, Vector
from ..observer import Observer

MATRICES = "FGDPVW"
# the sums of the functions of a device, as `observer_step` has them
SUMS = {"estimate": ("PVW", "zyu"), "advance": ("FGD", "zuy")}
SHORT, LONG = 400, 3000  # operations: scalars up to SHORT; up to LONG if mostly zeros
SPARSE = 3  # that is, where loops would do this many times the work


class StepCost(NamedTuple):
    """What one observer costs on a device.

    Attributes
    ----------
    multiply_adds : int
        Products and names that the sums of a step add up.  A known zero is none, and a
        known one is a name; a result that is a bare copy adds nothing up.
    operations : int
        Additions, multiplications and comparisons of an estimate and an advance, with
        those that test whether what they read and write is finite.
    bytes : int
        Of the state, and of the constants in the code and its tables.
    """

    multiply_adds: int
    operations: int
    bytes: int


class Counts(NamedTuple):
    """What a function is made of in C.

    Attributes
    ----------
    scalars : bool
        Whether it is written as scalars, else as loops.
    terms : int
        Products and names that its sums add up.
    operations : int
        Additions, multiplications and comparisons.
    constants : int
        Numbers that are kept for good, in tables or in the code.
    stack : int
        Numbers that are kept for the time of a step.
    """

    scalars: bool
    terms: int
    operations: int
    constants: int
    stack: int


def step_cost(observer: Observer, dtype: str = "double") -> StepCost:
    """Count the C that `export.to_c` writes for a constant, real observer as it is.

    Short observers are written as scalars, where zeros and copies cost nothing and
    equal expressions are computed once; long and dense ones as loops, which multiply
    by zeros too.

    Parameters
    ----------
    observer : Observer
    dtype : "double" or "float"
        What the device computes in.  An entry may be a zero or a one in float only.

    Raises
    ------
    ValueError
        If an entry is beyond the range of float.

    Examples
    --------
    >>> import luenberger as lb
    >>> observer = lb.Observer([[0.5]], [[1]], [[2]], [[0], [1]], [[1], [2]],
    ...                        T=[[-2, 1]], L=[[1, 0], [0, 1]])
    >>> step_cost(observer)
    StepCost(multiply_adds=5, operations=12, bytes=32)
    >>> step_cost(observer, "float").bytes
    16
    """
    require_c_type(dtype)
    found = counts(narrowed(observer, dtype)).values()
    constants = sum(one.constants for one in found)
    return StepCost(
        sum(one.terms for one in found),
        sum(one.operations for one in found),
        BYTES[dtype] * (observer.order + constants),
    )


def multiply_adds(observer: Observer, *, dtype: str = "double") -> int:
    """Multiply-adds of one step of a constant observer in the C of `export.to_c`.

    >>> import luenberger as lb
    >>> multiply_adds(lb.Observer([[0.5]], [[1]], [[2]], [[0], [1]], [[1], [2]],
    ...                         T=[[-2, 1]], L=[[1, 0], [0, 1]]))
    5

    They are the products and names that the sums of a step add up: a zero costs
    nothing, a one no multiplication but an addition, which is counted, and an estimate
    that is a bare copy of a signal nothing.  The observer is counted exactly as it is,
    so that an entry of 1e-17 is work.  `compare` shows this figure, and the header of
    the exported source does.  Of a complex observer, which is not exported, it is the
    number of complex entries that are not zero.

    Parameters
    ----------
    observer : Observer
    dtype : "double" or "float"
        What the device computes in.

    Returns
    -------
    int

    Raises
    ------
    ValueError
        If the observer has gains for every step, or numbers that float has not.
    """
    expect(observer=observer)
    if observer.steps is not None:
        raise ValueError("the count is of a constant observer; take one row's worth")
    if observer.is_complex:
        return sum(int((getattr(observer, k) != 0).sum()) for k in MATRICES)
    return step_cost(observer, dtype).multiply_adds


def narrowed(observer: Observer, dtype: str) -> Observer:
    """The observer in the numbers that a device has which computes in `dtype`."""
    if dtype == "double":
        return observer
    exact: Any = {
        k: representable(k, getattr(observer, k), dtype) for k in (*MATRICES, "z0")
    }
    return dataclasses.replace(observer, **exact)


def counts(observer: Observer) -> dict[str, Counts]:
    """Count the functions of an observer, each in the form that is better for a device.

    Scalars do no work on zeros and ones, loops do; but scalars are as many lines as
    they are sums.
    """
    found = {}
    for name, (matrices, signals) in SUMS.items():
        parts = [getattr(observer, k) for k in matrices]
        loops, scalars = _in_loops(parts), _in_scalars(parts, signals)
        short = LONG if SPARSE * scalars.operations < loops.operations else SHORT
        one = scalars if scalars.operations <= short else loops
        results = len(parts[0])  # in an array of their own
        read = sum(X.shape[1] for X in parts[1:] if X.any())
        found[name] = one._replace(
            operations=one.operations + read + results,  # whether they are finite
            stack=one.stack + results,
        )
    return found


def _in_loops(parts: list[Matrix]) -> Counts:
    """Every entry of a matrix that is not zero altogether is a product and a sum."""
    entries = sum(X.size for X in parts if X.any())
    return Counts(False, entries, 2 * entries, entries, 0)


def _in_scalars(parts: list[Matrix], signals: str) -> Counts:
    """A sum for each row, if it is no copy of a signal and no sum that was there."""
    names = [(s, k) for s, X in zip(signals, parts) for k in range(X.shape[1])]
    seen, read = dict[Any, Vector](), set[tuple[str, int]]()
    for row in np.hstack(parts):
        (at,) = row.nonzero()
        read.update(names[k] for k in at)
        if len(at) > 1 or (row[at] != 1).any():
            at = sorted(at, key=lambda k: row[k] < 0)  # stable
            seen[tuple((names[k], row[k]) for k in at)] = row[at]
    factors = sum(int((np.abs(values) != 1).sum()) for values in seen.values())
    terms = sum(map(len, seen.values()))
    operations = terms - len(seen) + factors
    return Counts(True, terms, operations, factors, len(seen) + len(read))
