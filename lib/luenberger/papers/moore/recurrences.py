"""Which characteristic polynomials an observer of k x may have, order by order.

An observer of order r with V = 0 and characteristic polynomial beta exists exactly
when k beta(A) is a combination of the rows of C, CA, .., CA^(r-1), that is, when

    sum_j beta_j k A^j N = 0,    N a basis of what these rows do not see.

With one output that is Moore's (13): the numbers kappa_i = k A^i g, which are k in his
coordinates, obey the recurrence with coefficients beta.
"""

from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np

from ...arguments import expect
from ...certificate import require_real
from ...errors import DesignError
from ...numeric import rationals
from ...numeric.independent_rows import default_tol, levels, scaled
from ...numeric.linalg import RANK_TOL, eigenvalues
from ...numeric.stable_polynomials import decide
from ...numeric.validation import as_array, matrix, vector
from ...numeric.validation import exact as exact_k

EXACT_ORDER = 20  # beyond, fractions of thousands of digits take minutes
SET_TOL = 1e-12  # k A^j at length one on N: below it a combination of them is zero
FAR = 1e-11  # a leading coefficient this small beside the others is zero
SLOW = 1e-6  # an eigenvalue this small beside the largest is zero, for the time scale


@dataclass(frozen=True)
class Recurrence:
    """What `recurrences` says of one order.

    Attributes
    ----------
    order : int
        Number r of observer states.
    dimension : int or None
        Of the set of admissible characteristic polynomials: 0 for a single one, r
        for all of them; None when there is none.
    stable : bool
        Whether a stable polynomial was found among them.
    decided : str
        "exact": by solving equations of which every solution is known.  "sign
        condition": no admissible polynomial has all coefficients positive (in
        discrete time, in the variable of the half plane); a proof that there is no
        stable one.  "search": by descent from many starts; finding none proves
        nothing.
    poles : (r,) complex ndarray or None
        Of the stable polynomial of largest margin, or of the only admissible one.
    margin : float or None
        The least -Re s in rad/s, or 1 - |z|, of these poles.
    """

    order: int
    dimension: int | None
    stable: bool
    decided: str
    poles: np.ndarray | None = None
    margin: float | None = None

    @property
    def reason(self):
        """In words, why there is no stable observer of this order; or how many."""
        if self.dimension is None:
            return "no polynomial is admissible"
        if self.stable and self.dimension == 0:
            return "a single polynomial is admissible"
        if self.stable:
            numbers = "number" if self.dimension == 1 else "numbers"
            return f"the admissible polynomials have {self.dimension} free {numbers}"
        if self.dimension == 0:
            return "the only admissible polynomial is not stable"
        if self.decided == "search":
            return "a search found no stable polynomial, which is not a proof"
        return "no admissible polynomial is stable, by the signs of its coefficients"


class Admissible:
    """The admissible polynomials of one functional on one plant.

    Time is scaled by `sigma`, a power of two, so polynomials are in s / sigma; a
    discrete plant has sigma = 1.  When k is of Fractions so is everything; else A, C
    and k are in scaled units, x / d and y / outputs.
    """

    def __init__(self, plant, k):
        self.plant, self.exactly = plant, k.dtype == object
        self.discrete = plant.dt > 0
        self.sigma = 1.0 if self.discrete else time_scale(plant.A)
        if self.exactly:
            self.A, self.C, self.k = plant.exact["A"], plant.exact["C"], k
        else:
            self.d, self.outputs, self.A, self.C = scaled(plant.A, plant.C)
            self.k = k * self.d

    @cached_property
    def powers(self):
        """k (A / sigma)^j for j = 0 .. n; rows."""
        rows, scale = [self.k], type(self.A[0, 0])(self.sigma)
        for _ in range(len(self.A)):
            rows.append(rows[-1] @ self.A / scale)
        return np.array(rows)

    @cached_property
    def found(self):
        """Orthonormal rows, level by level, and what no output sees last."""
        return levels(self.A, self.C, default_tol(len(self.A)))

    @cached_property
    def _complete(self):
        """An orthonormal basis that begins with what the outputs see, by levels."""
        seen = np.vstack([np.zeros((0, len(self.A))), *self.found])
        return np.linalg.qr(seen.T, mode="complete")[0]

    def unseen(self, r):
        """Orthonormal columns N that C, CA, .., CA^(r-1) do not see; floats only."""
        return self._complete[:, sum(map(len, self.found[:r])) :]

    @cached_property
    def hidden(self):
        """Eigenvalues of the part that no output sees."""
        if self.exactly:
            return Admissible(self.plant, self.k.astype(float)).hidden
        N = self.unseen(len(self.A))
        return eigenvalues(N.T @ self.A @ N)

    def basis(self, r):
        """A basis of the admissible polynomials of order r, or None: see `decide`."""
        basis = (self._exact_basis if self.exactly else self._float_basis)(r)
        return basis if basis.shape[1] and basis[-1].any() else None

    def _exact_basis(self, r):
        rows, seen = self.C, []
        for _ in range(r):
            seen.append(rows)
            rows = rows @ self.A
        both = np.vstack([*seen, self.powers[: r + 1]])
        echelon, pivots = rationals.reduced(both.T)
        first = len(both) - (r + 1)
        left = [i for i, pivot in enumerate(pivots) if pivot >= first]
        return (
            rationals.null_space(echelon[left, first:])
            if left
            else rationals.eye(r + 1)
        )

    def _float_basis(self, r):
        size = np.linalg.norm(self.powers[: r + 1], axis=1)
        size = np.where(size > 0, size, 1.0)
        rows = (self.powers[: r + 1] / size[:, None]) @ self.unseen(r)
        left, values, _ = np.linalg.svd(rows)
        rank = int((values > SET_TOL).sum())
        basis = left[:, rank:]
        if not np.linalg.norm(basis[-1:]) > FAR:
            return np.zeros((r + 1, 0))
        return basis / size[:, None]

    def admits(self, poles):
        """Whether an observer can have these poles."""
        r = len(poles)
        if self.exactly:
            beta = np.array([Fraction(1)])  # descending
            for pole in poles / Fraction(self.sigma):
                beta = np.append(beta, 0) - pole * np.append([0], beta)
            basis = self.basis(r)
            if basis is None:
                return False
            both = np.column_stack([basis, beta[::-1]])
            return len(rationals.reduced(both)[1]) == basis.shape[1]
        beta = np.poly(poles / self.sigma)[::-1]
        rows = beta.real[:, None] * self.powers[: r + 1]
        left = np.linalg.norm(rows.sum(axis=0) @ self.unseen(r))
        return left <= RANK_TOL * np.linalg.norm(rows, axis=1).sum()

    def answer(self, r):
        """(Recurrence, Answer) of order r."""
        basis = self.basis(r)
        if basis is None:
            return Recurrence(r, None, False, "exact"), None
        found = decide(basis, self.discrete)
        poles = margin = None
        if found.roots is not None:
            poles = np.sort_complex(found.roots * self.sigma)
            margin = float((1 - abs(poles) if self.discrete else -poles.real).min())
        dimension = basis.shape[1] - 1
        return Recurrence(
            r, dimension, found.stable, found.decided, poles, margin
        ), found

    @cached_property
    def kappa(self):
        """kappa_i = k A^i g sigma^-i, i = 0 .. n - 1, or None.

        Up to one factor, for an observable plant with one output: C A^j g = 0 for
        j < n - 1, so g is what the first n - 1 levels do not see.
        """
        n = len(self.A)
        if len(self.C) > 1:
            return None
        if self.exactly:
            rows = [self.C[0]]
            for _ in range(n - 1):
                rows.append(rows[-1] @ self.A)
            if len(rationals.reduced(np.array(rows))[1]) < n:
                return None
            unit = rationals.zeros(n, 1)
            unit[-1, 0] += 1
            return self.powers[:n] @ rationals.solve(np.array(rows), unit)[:, 0]
        if len(self.found) < n:
            return None
        return self.powers[:n] @ self.unseen(n - 1)[:, 0]

    def kappa_has_one_sign(self):
        """Moore's remark: then, in continuous time, no order below n is possible."""
        kappa = self.kappa
        if kappa is None or self.discrete:
            return False
        least = 0 if self.exactly else 1e-11 * np.abs(kappa).max()
        return bool((kappa >= -least).all() or (kappa <= least).all())


def time_scale(A):
    """A power of two near the geometric mean of the rates |lambda(A)| in 1/s.

    Rates that are zero do not count; 1 when all are.
    """
    rates = np.abs(eigenvalues(A))
    floor = 1e-7 * np.linalg.norm(A)  # of a defective zero, rounding leaves this much
    rates = rates[rates > max(SLOW * rates.max(initial=0), floor)]
    return float(2.0 ** np.round(np.log2(rates).mean())) if len(rates) else 1.0


def recurrences(plant, k, *, orders=None):
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
    admissible = Admissible(plant, rows[0])
    orders = range(1, plant.n + 1) if orders is None else orders
    return tuple(admissible.answer(r)[0] for r in orders)


def functionals(plant, k):
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
    rational = None if plant.exact is None or plant.n > EXACT_ORDER else exact_k(k)
    return np.atleast_2d(floats if rational is None else rational)
