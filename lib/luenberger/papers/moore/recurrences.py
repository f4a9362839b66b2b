"""Which characteristic polynomials an observer of k x may have, order by order.

An observer of order r with V = 0 and characteristic polynomial beta exists exactly
when k beta(A) is a combination of the rows of C, CA, .., CA^(r-1), that is, when

    sum_j beta_j k A^j N = 0,    N a basis of what these rows do not see.

With one output that is Moore's (13): the numbers kappa_i = k A^i g, which are k in his
coordinates, obey the recurrence with coefficients beta.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from fractions import Fraction
from functools import cached_property

import numpy as np
from numpy.typing import ArrayLike

from ...arguments import expect
from ...certificate import require_real
from ...errors import DesignError
from ...numeric import Matrix, Vector, rationals
from ...numeric.balance import power_of_two
from ...numeric.even_pair import even_pair
from ...numeric.independent_rows import default_tol, levels
from ...numeric.linalg import RANK_TOL, eigenvalues
from ...numeric.validation import as_array, exact, matrix, vector
from ...plant import Plant
from .companion_chain import Factors, factors_of
from .stable_polynomials import Answer, decide

EXACT_ORDER = 20  # beyond, fractions of thousands of digits take minutes
SET_TOL = 1e-12  # k A^j at length one on N: below it a combination of them is zero
FAR = 1e-11  # a leading coefficient this small beside the others is zero
SLOW = 1e-6  # an eigenvalue this small beside the largest is zero, for the time scale


@dataclass(frozen=True)
class Recurrence:
    """What is known of one order.

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
    def reason(self) -> str:
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


class Admissible:
    """The admissible polynomials of one functional on one plant, in any arithmetic.

    Time is scaled by `sigma`, a power of two, so polynomials are in s / sigma; a
    discrete plant has sigma = 1.  A, C and k are in the units of the arithmetic.
    """

    A: Matrix
    C: Matrix
    k: Vector
    exactly: bool

    def __init__(self, plant: Plant, k: Vector) -> None:
        self.plant, self.discrete = plant, plant.dt > 0
        rows = np.vstack([plant.C, k.astype(float)])
        pair = even_pair(plant.A, rows, plant.dt)
        self.d, self.outputs = pair.states, pair.outputs[:-1]
        self.even = pair.A * pair.rate
        self.sigma = 1.0 if self.discrete else time_scale(self.even)

    @cached_property
    def powers(self) -> Matrix:
        """k (A / sigma)^j for j = 0 .. n; rows."""
        rows, scale = [self.k], type(self.A[0, 0])(self.sigma)
        for _ in range(len(self.A)):
            rows.append(rows[-1] @ self.A / scale)
        return np.array(rows)

    def basis(self, r: int) -> Matrix | None:
        """A basis of the admissible polynomials of order r, or None: see `decide`."""
        raise NotImplementedError

    @property
    def kappa(self) -> Vector | None:
        """kappa_i = k A^i g sigma^-i, i = 0 .. n - 1, or None.

        Up to one factor, for an observable plant with one output: C A^j g = 0 for
        j < n - 1, so g is what the first n - 1 levels do not see.
        """
        raise NotImplementedError

    def answer(self, r: int) -> tuple[Recurrence, Answer | None]:
        """What is known of order r, with the polynomial that was found."""
        basis = self.basis(r)
        if basis is None:
            return Recurrence(r, None, False, "exact"), None
        found = decide(basis, self.discrete)
        poles = margin = None
        if found.roots is not None:
            poles = np.sort_complex(found.roots * self.sigma)
            margin = float((1 - abs(poles) if self.discrete else -poles.real).min())
        free = basis.shape[1] - 1
        said = Recurrence(r, free, found.stable, found.decided, poles, margin)
        return said, found

    def kappa_has_one_sign(self) -> bool:
        """Moore's remark: then, in continuous time, no order below n is possible."""
        kappa = self.kappa
        if kappa is None or self.discrete:
            return False
        least = 0 if self.exactly else 1e-11 * np.abs(kappa).max()
        return bool((kappa >= -least).all() or (kappa <= least).all())


class OverFloats(Admissible):
    """In units x / d and y / outputs, in which what is small may be called zero."""

    exactly = False

    def __init__(self, plant: Plant, k: Vector) -> None:
        super().__init__(plant, k)
        self.A, self.k = self.even, k * self.d
        self.C = plant.C / self.outputs[:, None] * self.d

    @cached_property
    def found(self) -> list[Matrix]:
        """Orthonormal rows, level by level, and what no output sees last."""
        return levels(self.A, self.C, default_tol(len(self.A)))

    @cached_property
    def _complete(self) -> Matrix:
        """An orthonormal basis that begins with what the outputs see, by levels."""
        seen = np.vstack([np.zeros((0, len(self.A))), *self.found])
        return np.linalg.qr(seen.T, mode="complete")[0]

    def unseen(self, r: int) -> Matrix:
        """Orthonormal columns N that C, CA, .., CA^(r-1) do not see."""
        return self._complete[:, sum(map(len, self.found[:r])) :]

    def basis(self, r: int) -> Matrix | None:
        size = np.linalg.norm(self.powers[: r + 1], axis=1)
        size = np.where(size > 0, size, 1.0)
        rows = (self.powers[: r + 1] / size[:, None]) @ self.unseen(r)
        left, values, _ = np.linalg.svd(rows)
        rank = int((values > SET_TOL).sum())
        basis = left[:, rank:]
        leads = np.linalg.norm(basis[-1:]) > FAR
        return basis / size[:, None] if leads else None

    @cached_property
    def kappa(self) -> Vector | None:
        n = len(self.A)
        if len(self.C) > 1 or len(self.found) < n:
            return None
        return self.powers[:n] @ self.unseen(n - 1)[:, 0]

    def admits(self, poles: Vector) -> bool:
        """Whether an observer can have these poles."""
        beta = np.poly(poles / self.sigma)[::-1]
        rows = beta.real[:, None] * self.powers[: len(poles) + 1]
        left = np.linalg.norm(rows.sum(axis=0) @ self.unseen(len(poles)))
        return bool(left <= RANK_TOL * np.linalg.norm(rows, axis=1).sum())

    def factors(self, answer: Answer, free: bool) -> Factors:
        """The polynomial of an answer, in s: a factor for each pole or pair."""
        return factors_of(answer.roots * self.sigma)


class OverRationals(Admissible):
    """In the user's units, in Fractions, where zero is zero."""

    exactly = True

    def __init__(self, plant: Plant, k: Vector) -> None:
        super().__init__(plant, k)
        self.A, self.C, self.k = plant.exact["A"], plant.exact["C"], k

    @cached_property
    def rounded(self) -> OverFloats:
        """The same functional over the floats."""
        return OverFloats(self.plant, self.k.astype(float))

    def _seen(self, r: int) -> Matrix:
        """C, CA, .., CA^(r-1), one below the other."""
        rows, seen = self.C, [self.C[:0]]
        for _ in range(r):
            seen.append(rows)
            rows = rows @ self.A
        return np.vstack(seen)

    def basis(self, r: int) -> Matrix | None:
        seen = self._seen(r)
        echelon, pivots = rationals.reduced(np.vstack([seen, self.powers[: r + 1]]).T)
        left = [i for i, pivot in enumerate(pivots) if pivot >= len(seen)]
        if not left:
            return rationals.eye(r + 1)
        basis = rationals.null_space(echelon[left, len(seen) :])
        return basis if basis.shape[1] and basis[-1].any() else None

    @cached_property
    def kappa(self) -> Vector | None:
        n = len(self.A)
        if len(self.C) > 1:
            return None
        seen, unit = self._seen(n), rationals.eye(n)[:, -1:]
        try:
            return self.powers[:n] @ rationals.solve(seen, unit)[:, 0]
        except ZeroDivisionError:  # not observable
            return None

    def admits(self, poles: Vector) -> bool:
        """Whether an observer can have these poles, which are Fractions."""
        basis = self.basis(len(poles))
        if basis is None:
            return False
        beta = np.array([Fraction(1)])  # descending
        for pole in poles / Fraction(self.sigma):
            beta = np.append(beta, 0) - pole * np.append([0], beta)
        both = np.column_stack([basis, beta[::-1]])
        return len(rationals.reduced(both)[1]) == basis.shape[1]

    def factors(self, answer: Answer, free: bool) -> Factors:
        """The polynomial of an answer, in s.

        Poles that are free were chosen rational, and each has a factor; others need
        not be, and the polynomial is one factor.
        """
        sigma, r = Fraction(self.sigma), len(answer.roots)
        if free:
            return [[-Fraction(root) * sigma] for root in answer.roots]
        return [[b * sigma ** (r - j) for j, b in enumerate(answer.beta[:-1])]]


Polynomials = OverFloats | OverRationals


def polynomials(plant: Plant, k: Vector) -> Polynomials:
    """The admissible polynomials of k x: over the rationals where k is rational."""
    return (OverRationals if k.dtype == object else OverFloats)(plant, k)


def time_scale(A: Matrix) -> float:
    """A power of two near the geometric mean of the rates |lambda(A)| in 1/s.

    Rates that are zero do not count; 1 when all are.
    """
    rates = np.abs(eigenvalues(A))
    floor = 1e-7 * np.linalg.norm(A)  # of a defective zero, rounding leaves this much
    rates = rates[rates > max(SLOW * rates.max(initial=0), floor)]
    if not len(rates):
        return 1.0
    return power_of_two(float(np.exp2(np.log2(rates).mean())))
