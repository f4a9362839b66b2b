"""What one constant observer costs on a device, counted from the step that it runs."""

import dataclasses
from typing import Any, NamedTuple

from ..arguments import expect
from ..kernels import lowered
from ..kernels.c.numbers import BYTES, representable, require_c_type
from ..kernels.program import Program
from ..observer import Observer
from ..papers.leondes_novak.derivation import observer_step

MATRICES = "FGDPVW"


class StepCost(NamedTuple):
    """What one observer costs on a device.

    Attributes
    ----------
    multiply_adds : int
        Products and names that the sums of a step add up.  A known zero is none, and a
        known one is a name; a result that is a bare copy adds nothing up.
    operations : int
        Additions, multiplications and comparisons of a step, with those that test
        whether each input, measurement, estimate and state is finite.
    bytes : int
        Of the state, and of the constants in the code and its tables.
    """

    multiply_adds: int
    operations: int
    bytes: int


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
    StepCost(multiply_adds=5, operations=11, bytes=32)
    >>> step_cost(observer, "float").bytes
    16
    """
    require_c_type(dtype)
    observer = narrowed(observer, dtype)
    known = {k: getattr(observer, k).tolist() for k in MATRICES}
    sizes = step_sizes(observer)
    cost = step_program(observer).cost(sizes, known)
    size = BYTES[dtype] * (observer.order + cost.constants)
    return StepCost(cost.terms, cost.operations + sum(sizes.values()), size)


def multiply_adds(observer: Observer, *, dtype: str = "double") -> int:
    """Multiply-adds of one step of a constant observer in the C of `export.to_c`.

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

    Examples
    --------
    >>> import luenberger as lb
    >>> lb.multiply_adds(lb.Observer([[0.5]], [[1]], [[2]], [[0], [1]], [[1], [2]],
    ...                              T=[[-2, 1]], L=[[1, 0], [0, 1]]))
    5
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


def step_program(observer: Observer) -> Program:
    """The step from z, y and u to w_hat and z_next, without matrices that vanish."""
    zero = [k for k in MATRICES if not getattr(observer, k).any()]
    return lowered(observer_step, ["w_hat", "z_next"], zero=zero)


def step_sizes(observer: Observer) -> dict[str, int]:
    """The sizes of `step_program` by name."""
    q, r = observer.P.shape
    return dict(q=q, r=r, p=observer.D.shape[1], m=observer.G.shape[1])
