"""Which characteristic polynomials an observer of k x may have, order by order.

An observer of order r with V = 0 and characteristic polynomial beta exists exactly
when k beta(A) is a combination of the rows of C, CA, .., CA^(r-1), that is, when

    sum_j beta_j k A^j N = 0,    N a basis of what these rows do not see.

With one output that is Moore's (13): the numbers kappa_i = k A^i g, which are k in his
coordinates, obey the recurrence with coefficients beta.
"""

from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from ...arguments import expect
from ...certificate import require_real
from ...errors import DesignError
from ...numeric import Matrix
from ...numeric.validation import as_array, exact, matrix, vector
from ...plant import Plant
from .admissible import Recurrence, polynomials

EXACT_ORDER = 20  # beyond, fractions of thousands of digits take minutes


def recurrences(
    plant: Plant, k: ArrayLike, *, orders: Iterable[int] | None = None
) -> tuple[Recurrence, ...]:
    """For each order, which observers of k x without feedthrough there are.

    Parameters
    ----------
    plant : Plant
        Constant and real.
    k : (n,) array_like
        The functional.
    orders : sequence of int, optional
        Default 1 .. n.

    Returns
    -------
    tuple of Recurrence
        One for each order.

    Examples
    --------
    >>> import luenberger as lb
    >>> from luenberger.papers.moore.recurrences import recurrences
    >>> plant = lb.Plant([[0, 1, 0], [0, 0, 1], [0, 0, 0]], None, [[1, 0, 0]])
    >>> for r in recurrences(plant, [2, 3, -1]):
    ...     print(r.order, r.dimension, r.stable, r.decided)
    1 None False exact
    2 1 True exact
    3 3 True exact
    """
    rows = functionals(plant, k)
    if len(rows) != 1:
        raise ValueError(f"recurrences are of one functional, got {len(rows)}")
    admissible = polynomials(plant, rows[0])
    orders = range(1, plant.n + 1) if orders is None else orders
    return tuple(admissible.answer(r)[0] for r in orders)


def functionals(plant: Plant, k: ArrayLike) -> Matrix:
    """k as a matrix of rows: Fractions when plant and k are exact, else floats."""
    expect(plant=plant)
    if plant.steps is not None:
        raise DesignError(
            "Moore's observers are for a constant plant, and this one varies over "
            f"{plant.steps} steps. Give one A, B, C and E."
        )
    require_real("an observer of a functional", plant)
    k = as_array(k)
    if k.ndim not in (1, 2):
        raise ValueError(
            f"k must be a vector of {plant.n} numbers, or a matrix with such rows"
        )
    floats = vector("k", k, plant.n) if k.ndim == 1 else matrix("k", k, cols=plant.n)
    if len(floats) == 0:
        raise ValueError("k has no rows; give at least one functional")
    rational = None if plant.exact is None or plant.n > EXACT_ORDER else exact(k)
    return np.atleast_2d(floats if rational is None else rational)
