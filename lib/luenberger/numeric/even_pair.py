"""A pair (A, C) in units in which its numbers are of like size and its stairs high.

Units of states, outputs and time must decide nothing.  What the outputs see, and the
observer that comes of it, are those of the pair in these units.
"""

from collections.abc import Callable
from typing import NamedTuple, TypeVar

import numpy as np

from . import Matrix, Vector
from .balance import balanced, even_rate, power_of_two, sizes

SMALL_STAIR = 1e-4  # relative size of a stair that asks for other units
SWEEPS = 6  # alternations of row and column scaling; more change nothing much
Form = TypeVar("Form")


class Pair(NamedTuple):
    """A is diag(1/states) A diag(states) / rate, C is diag(1/outputs) C diag(states).

    All are powers of two.  `natural` are the units that balance A, for judging errors.
    """

    A: Matrix
    C: Matrix
    states: Vector
    outputs: Vector
    natural: Vector
    rate: float


def as_given(A: Matrix, C: Matrix) -> Pair:
    """The pair in the user's units."""
    one = np.ones(len(A))
    return Pair(A, C, one, np.ones(len(C)), one, 1.0)


def even_pair(A: Matrix, C: Matrix, dt: float = 0.0, fastest: float = 0.0) -> Pair:
    """The pair in units that balance it; see `balanced` and `time_unit`.

    In continuous time that of time is the plant's own, or of the `fastest` rate that
    it has to meet; in discrete time it is the sample.
    """
    rate = even_rate(A, C, dt, fastest)
    states, _ = balanced(A / rate, C, 0, 0)
    pair = _moved(as_given(A / rate, C)._replace(rate=rate), states)
    return pair._replace(natural=pair.states)


def highest(
    pair: Pair, climb: Callable[[Matrix, Matrix], tuple[Form, int, float]]
) -> tuple[Pair, Form]:
    """`pair`, perhaps in units that make its stairs higher, and the form it has there.

    Where balance leaves a very small stair, as in a loop that one of its links nearly
    opens, states are measured by how strongly the outputs see them instead.

    Parameters
    ----------
    pair : Pair
    climb : callable
        What A and C give: a form, how many states are in it, and its smallest stair,
        relative.
    """
    form, rank, margin = climb(pair.A, pair.C)
    if rank == len(pair.A) and margin >= SMALL_STAIR:
        return pair, form
    other = _moved(pair, _seen(pair.A, pair.C))
    found = climb(other.A, other.C)
    return (
        (other, found[0]) if found[1:] > (rank, margin / SMALL_STAIR) else (pair, form)
    )


def _moved(pair: Pair, d: Vector) -> Pair:
    """The pair with states in units `d`, outputs in those of what they show."""
    C = pair.C * d
    y = sizes(np.abs(C), 0, 1)
    return pair._replace(
        A=pair.A / d[:, None] * d, C=C / y[:, None],
        states=pair.states * d, outputs=pair.outputs * y,
    )  # fmt: skip


def _seen(A: Matrix, C: Matrix) -> Vector:
    """Scales that give the columns of the observability matrix comparable sizes."""
    size = float(np.abs(np.linalg.eigvals(np.abs(A))).max())
    size = size if size > 0 else 1.0  # Perron's root: the same in all units
    rows, power = [], C
    for _ in range(len(A)):
        rows.append(np.abs(power))
        power = power @ A / size
    rows = np.array(rows)
    outputs, d = np.ones(len(C)), np.ones(len(A))
    for _ in range(SWEEPS):
        d = _reciprocal((rows * outputs[:, None]).max(axis=(0, 1), initial=0))
        outputs = _reciprocal((rows * d).max(axis=(0, 2)))
    return d


def _reciprocal(size: Vector) -> Vector:
    return 1 / power_of_two(np.where((size > 0) & np.isfinite(size), size, 1.0))
