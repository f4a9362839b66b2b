"""What a fit found: the plant, how sure it is, and what it leaves of the record."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from ..errors import CertificateError, DesignError
from ..filtering.likelihood import normalised
from ..numeric import Matrix, Vector
from ..plant import Plant
from ..run.filter import Filter
from .boundary import Face, face, inside, unsure
from .forms import Full
from .search import Likelihood
from .standard_errors import errors, of_logarithms, spread_of
from .unknowns import Unknowns
from .whiteness import Whiteness, whiteness

Likely = Callable[[Matrix, Matrix], bool]  # whether the record is, under a Q and an R

MANY = 1e6  # times a variance that autocovariances put at zero, but for rounding
LOSS = 1e-3  # in the logarithm of the likelihood, that a variance of zero may cost


@dataclass(frozen=True, eq=False, repr=False)
class NoiseFit:
    """The most likely noise of a plant, as `fit_noise` returns it.

    Attributes
    ----------
    plant : Plant
        The plant with the Q, R and S that were found, and the parameters.
    log_likelihood : float
        Of all records together.
    parameters : dict of str to float
        {name: value} of the unknown parameters, and of the numbers q of a form.
    standard_errors : dict
        {"Q": (n, n), "R": (p, p), and each name in `parameters`: float}: one standard
        error each, from the curvature of the likelihood.  Zero for what was known;
        infinite for what this record does not determine; NaN for a variance at its
        bound, zero, where the error is not normal and has none.  The errors beside
        such a variance are those that hold without the bound: at a bound estimates
        vary less, so that two errors hold the truth more often than 95 times in a
        hundred.
    unidentifiable : list of str
        What the record left open, in words.
    innovations : (N, p) ndarray, or a list of them
        Normalised: of variance one and uncorrelated, if the model is right.  NaN
        where nothing was measured, or not yet enough to predict it.
    whiteness : Whiteness
        The test of that.

    Printed, it is every number with its standard error, and what the tests say.
    """

    plant: Plant
    log_likelihood: float
    parameters: dict[str, float]
    standard_errors: dict[str, Any]
    unidentifiable: list[str]
    innovations: Any
    whiteness: Whiteness

    @property
    def lines(self) -> list[str]:
        """Every number that was found with its standard error, a line each."""
        out = []
        for letter in "QR":
            X, error = getattr(self.plant, letter), self.standard_errors[letter]
            for i, j in zip(*np.triu_indices(len(X)), strict=True):
                out.append(_line(f"{letter}[{i},{j}]", X[i, j], error[i, j]))
        for name, value in self.parameters.items():
            out.append(_line(name, value, self.standard_errors[name]))
        return [*out, f"log-likelihood {self.log_likelihood:.2f}"]

    def __repr__(self) -> str:
        about = [*self.lines, *self.unidentifiable, *self.whiteness.sentences]
        return "\n".join(about)


def _line(name: str, value: float, error: float) -> str:
    if error == 0:
        return f"{name:<10} {value:.5g}, known"
    if error == math.inf:
        return f"{name:<10} {value:.5g}, not determined by this record"
    sure = "at its bound" if math.isnan(error) else f"standard error {error:.2g}"
    return f"{name:<10} {value:.5g}, {sure}"


def found(
    unknowns: Unknowns, theta: Vector, likelihood: Likelihood,
    spread: Matrix | None = None,
) -> NoiseFit:  # fmt: skip
    """The `NoiseFit` at a vector.

    Parameters
    ----------
    unknowns : Unknowns
    theta : (k,) ndarray
    likelihood : Likelihood
        Of the records.
    spread : (k, k) ndarray, optional
        Covariance of the vector; default by the curvature of the likelihood.
    """
    _, _, values = unknowns.split(theta)
    plant, alone = unknowns.plant(theta), spread is not None
    best = likelihood.of(plant)

    def likely(Q: Matrix, R: Matrix) -> bool:
        try:
            return likelihood.of(unknowns.with_noise(Q, R, values)) >= best - LOSS
        except (CertificateError, DesignError, np.linalg.LinAlgError):
            return False

    if spread is None:
        noises = plant.at(0).covariances()[:2]
        spread = spread_of(unknowns, theta, likelihood, *noises)
        vague = unsure(spread, theta)
    else:
        spread = of_logarithms(unknowns, theta, spread)
        vague = _tiny(unknowns, theta, likely)
    Q, R = _faces(unknowns, theta, likely, vague, whole=not alone)
    if Q.sentences or R.sentences:
        plant = unknowns.with_noise(Q.X, R.X, values)
        best = likelihood.of(plant)
        if not alone:
            spread = spread_of(unknowns, theta, likelihood, Q.X, R.X)
    run = Filter(plant)
    left = [normalised(run.passed(rows, "values")) for rows in likelihood.rows]
    beyond = max(unknowns.count - plant.p * (plant.p + 1) // 2, 0)
    named = dict(zip(unknowns.parameters.names, values.tolist()))
    return NoiseFit(
        plant, best, Q.values | R.values | named,
        errors(unknowns, theta, spread, Q, R), [*Q.sentences, *R.sentences],
        left[0] if len(left) == 1 else left, whiteness(joined(left), beyond),
    )  # fmt: skip


def _faces(
    unknowns: Unknowns, theta: Vector, likely: Likely, vague: Vector, whole: bool
) -> tuple[Face, Face]:
    """What of Q and R is at its bound; of a whole matrix, if that is asked for."""
    q, r, _ = unknowns.split(theta)
    Q, R = inside(unknowns.Q, q), inside(unknowns.R, r)
    if whole or not isinstance(unknowns.Q, Full):
        Q = face(unknowns.Q, q, lambda X: likely(X, R.X), vague[: len(q)])
    if whole or not isinstance(unknowns.R, Full):
        R = face(unknowns.R, r, lambda X: likely(Q.X, X), vague[len(q) :])
    return Q, R


def _tiny(unknowns: Unknowns, theta: Vector, likely: Likely) -> Vector:
    """Which numbers of Q and R could be a million times larger without a trace."""
    steps = 0.5 * np.log(MANY) * np.eye(len(theta))
    plants = (unknowns.split(theta + step) for step in steps)
    found = [likely(unknowns.Q.matrix(q), unknowns.R.matrix(r)) for q, r, _ in plants]
    return np.array(found, dtype=bool)


def joined(left: list[Matrix]) -> Matrix:
    """Innovations of several records, one below the other, with a gap between."""
    gap = np.full((1, left[0].shape[1]), np.nan)
    return np.concatenate([part for one in left for part in (one, gap)][:-1])
