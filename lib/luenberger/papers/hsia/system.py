"""Everything between two samples, as one linear system that runs by itself."""

from math import comb

import numpy as np
import scipy.linalg
from numpy.typing import ArrayLike

from ...errors import DesignError
from ...numeric import Matrix, Vector
from ...numeric.validation import vector
from ...plant import Plant

PIECES = 10_000_000  # more than these is a plant far too fast for the duration
DEGREE = 19  # of the Taylor series on a piece with |M h| <= 1: 1 / 20! is 4e-19
MEANS = 1 / np.arange(1, DEGREE + 2)  # of t^k over 0 <= t <= 1
BERNSTEIN = np.array(  # from the coefficients of t^k to Bernstein's
    [
        [comb(j, k) / comb(DEGREE, k) for k in range(DEGREE + 1)]
        for j in range(DEGREE + 1)
    ]
)


class Loop:
    """s = [x; x*; reference; u] with s' = M s between samples, balanced."""

    def __init__(self, plant: Plant, reference: Plant, duration: float) -> None:
        require_plant(plant)
        require_reference(reference)
        A, B, C, n = plant.A, plant.B, plant.C, plant.n
        Ar, Cr, q = reference.A, reference.C, reference.n
        zero = np.zeros
        M = np.block(
            [
                [A, zero((n, n + q)), B],
                [zero((n, n)), A - B @ C, B @ Cr, zero((n, 1))],
                [zero((q, 2 * n)), Ar, zero((q, 1))],
                [zero((1, 2 * n + q + 1))],
            ]
        )
        self.M, (scale, _) = scipy.linalg.matrix_balance(M, permute=False, separate=1)
        r = np.concatenate([zero(2 * n), Cr[0], [0]]) * scale
        y = np.concatenate([C[0], zero(n + q + 1)]) * scale
        y_star = np.concatenate([zero(n), C[0], zero(q + 1)]) * scale
        self.outputs, self.error, self.missed = (r, y, y_star), r - y, y_star - y
        self.plant, self.reference, self.scale = plant, reference, scale
        self.speed = np.linalg.norm(self.M, 1)
        self._known: dict[float, tuple[Matrix, Matrix]] = {}
        if self.speed * duration > PIECES:
            raise DesignError(
                f"the plant or the reference moves at rates up to {self.speed:.2g} per "
                f"second, so {duration:g} s of it cannot be followed. Leave out modes "
                "that are faster than any sample."
            )

    def start(self, x0: ArrayLike | None) -> Vector:
        x0 = self.plant.x0 if x0 is None else vector("x0", x0, self.plant.n)
        return np.concatenate([x0, x0, self.reference.x0, [0]]) / self.scale

    def hold(self, s: Vector, u: float) -> Vector:
        """The state with a new input."""
        return np.append(s[:-1], u / self.scale[-1])

    def run(self, s: Vector, T: float) -> tuple[Vector, float]:
        """The state T seconds on, and the integral of |y* - y| over them."""
        pieces = max(1, int(np.ceil(self.speed * T)))
        flow, series = self._piece(T / pieces)
        missed = 0.0
        with np.errstate(over="ignore", invalid="ignore"):  # refused by the caller
            for _ in range(pieces):
                missed += absolute_integral(series @ s)
                s = flow @ s
        return s, missed * T / pieces

    def ahead(self, s: Matrix, T: Vector) -> Matrix:
        """The states T seconds after those in the rows of s, T an array."""
        pieces = max(1, int(np.ceil(self.speed * T.max(initial=0.0))))
        for _ in range(pieces):
            term = s
            for j in range(1, DEGREE + 1):
                term = term @ self.M.T * (T / (pieces * j))[:, None]
                s = s + term
        return s

    def _piece(self, h: float) -> tuple[Matrix, Matrix]:
        """e^(M h), and the rows c (M h)^j / j! of the series of c e^(M t) s.

        One Taylor series gives both; with |M h| <= 1 it loses nothing.
        """
        if h not in self._known:
            powers = [np.eye(len(self.M))]
            for j in range(1, DEGREE + 1):
                powers.append(powers[-1] @ self.M * (h / j))
            powers = np.array(powers)
            # one period is usually like the last, or like none
            self._known = {h: (powers[::-1].sum(axis=0), self.missed @ powers)}
        return self._known[h]


def absolute_integral(coefficients: Vector) -> float:
    """Integral over 0 <= t <= 1 of the magnitude of a polynomial, constant first.

    The interval is split at the real part of every root: those of complex roots
    split it where nothing changes sign, which does no harm, so no root has to be
    called real.  Most often Bernstein's coefficients have one sign, and so has the
    polynomial.
    """
    if not np.isfinite(coefficients).all():
        return np.nan
    bernstein = BERNSTEIN @ coefficients
    if bernstein.min() >= 0 or bernstein.max() <= 0:
        return float(abs(coefficients @ MEANS))
    p = np.polynomial.Polynomial(coefficients / np.abs(coefficients).max())
    ends = np.clip(p.trim(1e-18).roots().real, 0, 1)
    parts = np.diff(p.integ()(np.sort([0, *ends, 1])))
    return float(np.abs(coefficients).max() * np.abs(parts).sum())


def require_plant(plant: Plant) -> None:
    if plant.dt != 0:
        raise DesignError(
            f"the plant has dt = {plant.dt:g}: it is sampled already, and what happens "
            "between its samples is lost. Give the continuous plant."
        )
    if plant.steps is not None or plant.is_complex:
        raise DesignError(
            "the sampled loop needs constant, real matrices. Give one A, B and C."
        )
    if (plant.m, plant.p) != (1, 1):
        raise DesignError(
            f"the sampled loop is for one input and one output, the plant has "
            f"{plant.m} and {plant.p}. Close the other loops first."
        )
    if plant.E.any():
        raise DesignError(
            f"the plant has feedthrough E = {plant.E[0, 0]:g}: its output jumps with "
            "the held input, so a sample has no single value. Model what is between "
            "input and output as a fast state."
        )


def require_reference(reference: object) -> None:
    if not isinstance(reference, Plant):
        raise ValueError(
            "reference must be `sampling.step(size)`, `ramp`, `sine` or a Plant "
            f"without inputs, got {reference!r}"
        )
    shape = (reference.m, reference.p, reference.dt, reference.steps)
    if shape != (0, 1, 0.0, None) or reference.is_complex:
        raise ValueError(
            "the reference must be a continuous plant with constant, real matrices, no "
            "inputs and one output"
        )
