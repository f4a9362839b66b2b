"""What the search for a fixed-order filter needs to know of a plant.

The error of any linear estimator is that of the Kalman filter plus, uncorrelated with
it, the distance to the Kalman filter's own estimate.  So the search approximates the
Kalman filter: the plant whose state is the prediction x^ and whose noise is the
innovation.  Nothing cancels then, however close the two filters come.  Multiplicative
noise has become additive before (`mean_square.equivalent_noise`).
"""

from dataclasses import replace
from typing import NamedTuple

import numpy as np

from .. import kernels
from ..errors import DesignError
from ..kernels import run
from ..linalg import lyapunov, null_directions
from ..mean_square import equivalent_noise
from .setting import Settings
from .steady import steady_gain
from .stein import Schur


class Prediction(NamedTuple):
    """The Kalman predictor of the plant with equivalent additive noise."""

    A: np.ndarray
    C: np.ndarray
    L: np.ndarray
    R: np.ndarray  # the weight
    De: np.ndarray  # its best feedthrough; zero when there is to be none
    Q: np.ndarray  # its error covariance
    Qs: np.ndarray
    V2s: np.ndarray
    feedthrough: bool

    @property
    def cost(self):
        """What the best estimator of any order costs: (3.18)."""
        return float(np.trace(run(kernels.projection_trace("J"), self._asdict())["J"]))


class Target(NamedTuple):
    """The innovations plant: states of unit variance, unit innovations, weight I.

    An estimator (Ae, Be, Ce, De) here is the estimator Ae, Be `outputs`,
    `unweighted` Ce, `unweighted` De `outputs` + De of the prediction there.
    """

    matrices: dict  # A, C, L, R and the moments Q1, Qxy, Qxy_next, Qyy
    Kq: np.ndarray  # gain on the innovation
    dynamics: Schur
    feedthrough: bool
    scale: float  # mean square of the weighted estimate that is sought
    power: float  # the same of the weighted L x itself, were its states independent
    states: np.ndarray  # (n,) what the states were divided by
    outputs: np.ndarray
    unweighted: np.ndarray


def prediction(plant, L, weight, feedthrough):
    """The Kalman predictor, with equivalent noise when some is multiplicative."""
    noise = equivalent_noise(plant)
    additive = replace(plant, multiplicative=(), Q=noise.Q, R=noise.R, S=noise.S)
    now = Settings(additive, 0).at(0)
    K, eye = np.zeros(now.C.T.shape), np.eye(plant.n)
    if noise.Q.any():  # without process noise the state is known to be zero
        K = steady_gain(now, ())
    compute = kernels.observer_matrices
    D = compute("D")(As=now.As, J=now.J, K=K, T_next=eye)["D"]
    F = now.As @ compute("T")(That=eye, K=K, C=now.C)["T"]
    drive = kernels.error_recursion("X_next")(
        F=F, D=D, T_next=eye, Q=noise.Q, R=noise.R, S=noise.S, X=np.zeros_like(F)
    )
    have = dict(A=plant.A, C=plant.C, L=L, R=weight, V12=noise.S, V2=noise.R)
    have["Q"] = lyapunov(F, drive["X_next"])
    have |= run(kernels.projection_innovation(), have)
    have["De"] = np.zeros((len(L), plant.p))
    if feedthrough:
        have |= run(kernels.feedthrough_gain(), have)
    return Prediction(
        *(have[name] for name in Prediction._fields[:-1]), feedthrough=feedthrough
    )


def target(found):
    """The problem of approximating the filter `found`, a Prediction."""
    _require_innovation(found.V2s)
    have = found._asdict()
    have |= run(kernels.innovations_plant(), have)
    unit = np.linalg.inv(np.linalg.cholesky(found.V2s))
    half = np.linalg.cholesky(found.R).T
    Q1 = lyapunov(found.A, have["V1i"])
    size = np.sqrt((found.Q + Q1).diagonal())
    size = np.where(size > 0, size, 1.0)
    A, L, whole = found.A * size / size[:, None], have["Lq"] * size, found.L * size
    matrices = dict(A=A, C=unit @ found.C * size, L=half @ L, R=np.eye(len(half)))
    matrices["Q1"] = Q1 = Q1 / size / size[:, None]
    noise = dict(V12=found.Qs @ unit.T / size[:, None], V2=np.eye(len(unit)))
    matrices |= run(kernels.output_moments(), matrices | noise)
    return Target(
        matrices,
        Kq=noise["V12"],
        dynamics=Schur(A),
        feedthrough=found.feedthrough,
        scale=float(np.trace(half @ L @ Q1 @ L.T @ half.T)),
        power=float(np.sum((half @ whole) ** 2)),
        states=size,
        outputs=unit,
        unweighted=np.linalg.inv(half),
    )


def _require_innovation(V2s):
    """Refuse when a combination of outputs is known before it is measured."""
    blind = null_directions(V2s)
    if blind.size:
        which = np.flatnonzero(np.abs(blind).max(axis=1) > 1e-6 * np.abs(blind).max())
        raise DesignError(
            "the innovation covariance V2s of (3.10) is singular: a combination of "
            f"the outputs {which.tolist()} (counted from 0) follows from earlier "
            "outputs and carries nothing new. Leave one of them out, or give them "
            "noise in R."
        )
