"""What the search for a fixed-order filter needs to know of a plant.

The error of any linear estimator is that of the Kalman filter plus, uncorrelated with
it, the distance to the Kalman filter's own estimate.  So the search approximates the
Kalman filter: the plant whose state is the prediction x^ and whose noise is the
innovation.  Nothing cancels then, however close the two filters come.  Multiplicative
noise has become additive before (`mean_square.equivalent_noise`).
"""

from dataclasses import replace
from typing import Any, NamedTuple

import numpy as np

from ...analysis.error_system import settled
from ...analysis.mean_square import equivalent_noise
from ...errors import DesignError
from ...kernels import run
from ...numeric import Matrix
from ...numeric.linalg import left_over, lyapunov, null_directions
from ...plant import Plant
from ...recursion.settings import setting
from ...recursion.steady_gain import steady_gain
from . import derivation as stages
from .stein import Schur


class Prediction(NamedTuple):
    """The Kalman predictor, for states of unit variance and additive noise."""

    A: np.ndarray
    C: np.ndarray
    L: np.ndarray
    R: np.ndarray  # the weight
    De: np.ndarray  # its best feedthrough; zero when there is to be none
    Q: np.ndarray  # its error covariance
    Qs: np.ndarray
    V2s: np.ndarray
    states: np.ndarray  # (n,) what the plant's states were divided by
    feedthrough: bool
    output_names: tuple

    @property
    def cost(self) -> float:
        """What the best estimator of any order costs, by (3.18)."""
        return float(np.trace(run(stages.projection_trace, self._asdict(), "J")["J"]))


class Target(NamedTuple):
    """The innovations plant, with innovations of unit covariance and weight I.

    An estimator (Ae, Be, Ce, De) here is the estimator Ae, Be `outputs`,
    `unweighted` Ce, `unweighted` De `outputs` + De of the prediction there.
    """

    matrices: dict  # A, C, L, R and the moments Q1, Qxy, Qxy_next, Qyy
    Kq: np.ndarray  # gain on the innovation
    dynamics: Schur
    feedthrough: bool
    scale: float  # mean square of the weighted estimate that is sought
    power: float  # the same of the weighted L x itself, were its states independent
    outputs: np.ndarray
    unweighted: np.ndarray


def prediction(
    plant: Plant, L: Matrix, weight: Matrix, feedthrough: bool
) -> Prediction:
    """The Kalman predictor, with equivalent noise when some is multiplicative."""
    noise = equivalent_noise(plant)
    size = np.sqrt(noise.X.diagonal())
    size = np.where(size > 0, size, 1.0)
    A, C, L = plant.A * size / size[:, None], plant.C * size, L * size
    Q, S = noise.Q / size / size[:, None], noise.S / size[:, None]
    K = _predictor_gain(
        replace(plant, multiplicative=(), A=A, C=C, Q=Q, R=noise.R, S=S)
    )
    have: dict[str, Any] = dict(
        A=A, C=C, L=L, R=weight, V1=Q, V12=S, V2=noise.R, states=size
    )
    error = dict(F=A - K @ C, D=K, T_next=np.eye(plant.n))
    have["Q"] = settled(**error, Q=Q, R=noise.R, S=S)
    have |= run(stages.projection_innovation, have)
    have["De"] = np.zeros((len(L), plant.p))
    if feedthrough:
        have |= run(stages.feedthrough_gain, have)
    have |= dict(feedthrough=feedthrough, output_names=plant.output_names)
    return Prediction(*(have[name] for name in Prediction._fields))


def _predictor_gain(plant: Plant) -> Matrix:
    """K of x^+ = A x^ + K (y - C x^); zero where nothing ever disturbs the state."""
    if not plant.Q.any():
        return np.zeros(plant.C.T.shape)
    now = setting(plant)
    return now.predictor(steady_gain(now, ()))


def target(found: Prediction) -> Target:
    """The problem of approximating the filter `found`, a Prediction."""
    _require_innovation(found.V2s, found.output_names)
    have = found._asdict()
    have |= run(stages.innovations_plant, have)
    unit = np.linalg.inv(np.linalg.cholesky(found.V2s))
    half = np.linalg.cholesky(found.R).T
    Lq = left_over(found.L, found.De, found.C, np.ones(len(found.A)))
    Q1, L = lyapunov(found.A, have["V1i"]), half @ Lq
    matrices = dict(A=found.A, C=unit @ found.C, L=L, R=np.eye(len(half)), Q1=Q1)
    noise = dict(V12=found.Qs @ unit.T, V2=np.eye(len(unit)))
    matrices |= run(stages.output_moments, matrices | noise)
    return Target(
        matrices,
        Kq=noise["V12"],
        dynamics=Schur(found.A),
        feedthrough=found.feedthrough,
        scale=float(np.trace(L @ Q1 @ L.T)),
        power=float(np.sum((half @ found.L) ** 2)),
        outputs=unit,
        unweighted=np.linalg.inv(half),
    )


def _require_innovation(V2s: Matrix, names: tuple[str, ...]) -> None:
    """Refuse when a combination of outputs is known before it is measured."""
    blind = null_directions(V2s)
    if blind.size:
        which = np.flatnonzero(np.abs(blind).max(axis=1) > 1e-6 * np.abs(blind).max())
        raise DesignError(
            "the innovation covariance V2s of (3.10) is singular: a combination of "
            f"the outputs {', '.join(names[k] for k in which)} follows from earlier "
            "outputs and carries nothing new. Leave one of them out, or give them "
            "noise in R."
        )
