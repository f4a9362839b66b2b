"""The best constant gain: stationary in the gain itself, not at each step.

The step-wise gain is least at each step for the weight; the constant gain of least
steady trace is the step-wise one for another weight, which the search finds.
"""

from collections.abc import Iterator, Sequence

import numpy as np

from .. import kernels
from ..errors import CertificateError
from ..numeric import Matrix, Vector
from ..numeric.balance import power_of_two
from ..numeric.linalg import ROUNDING, UNIT_TOL, complete, lyapunov, radius
from ..papers.leondes_novak.derivation import steady_gradient
from .excitation import require_excited
from .settings import Setting
from .steady_gain import reduced_dynamics, steady_cost, steady_gain, step_from
from .units import in_units, natural

STATIONARITY_TOL = 1e-9  # of the best constant gain, relative
REFINED = 1e-12  # where no more is to be gained
PATIENCE = 20  # moves without a smaller residual before the search ends
POLISHING = 3  # moves that do not halve it, once it certifies
MOVES = 2000  # at most
WEIGHED = ", or weight=numpy.eye(n): no gain may be best where states do not count."
UNFELT = 1e-24  # of the largest cost
MEMORY = 8  # moves that Anderson mixing looks back on


def best_constant_gain(
    now: Setting, accurate: Sequence[int], weight: Matrix | None = None
) -> Matrix:
    """Constant gain of the same structure with the least steady weighted trace.

    `weight` may be singular; default that of the setting.  The search starts from the
    step-wise gain, in units in which each state and each output matters as much as the
    others: so the user's units play no part.
    """
    x, y = natural(now)
    now = in_units(now, x, y)  # where no square overflows
    K = steady_gain(now, accurate)
    if weight is not None:
        now = now._replace(weight=weight * x[:, None] * x)
    states, outputs = _units(now, K)
    K = _descended(in_units(now, states, outputs), K / states[:, None] * outputs)
    return K * (x * states)[:, None] / (y * outputs)


def _units(now: Setting, K: Matrix) -> tuple[Vector, Vector]:
    """Units of states and outputs in which all of them matter to the cost.

    That of an output is its innovation's deviation; that of a state the deviation
    that would cost as much as the filter does, at its weight Lambda in the long run.
    """
    weight = now.whole_weight
    cost, (Sigma, Phi) = steady_cost(now, K, weight)
    counts = _in_the_end(Phi, weight).diagonal()  # 0 where nothing weighed is reached
    states = np.sqrt((cost if cost > 0 else 1.0) / np.where(counts > 0, counts, 1.0))
    innovation = step_from(now, Sigma)["M"].diagonal()
    known = (now.C * now.C) @ (states * states)  # what an exact output may be off by
    outputs = np.where(innovation > ROUNDING * known, innovation, known)
    outputs = np.sqrt(np.where(outputs > 0, outputs, 1.0))
    return power_of_two(states), power_of_two(outputs)


def _in_the_end(Phi: Matrix, weight: Matrix) -> Matrix:
    """Lambda = Phi' Lambda Phi + weight, without what reaches the weight by rounding.

    That is a state that is not weighed itself, and whose errors cost less than 1e-24 of
    what others cost, in units in which the plant's numbers are of like size.
    """
    Lambda = lyapunov(Phi.T, weight)
    cost = Lambda.diagonal()
    counts = (weight.diagonal() > 0) | (cost > UNFELT * cost.max(initial=0.0))
    return Lambda * np.outer(counts, counts)


def _descended(now: Setting, K: Matrix) -> Matrix:
    """From K to the gain of least cost.

    With Lambda = Phi' Lambda Phi + weight, the stationary gain is the step-wise gain
    for the weight Lambda.  Moving toward that gain is a direction of descent; it is
    extrapolated from the last moves (Anderson mixing) where that lowers the trace,
    and shortened where it does not.  The gradient that certifies is the derived one.
    """
    columns = np.any(now.Gamma, axis=0)
    cost, state = steady_cost(now, K, now.whole_weight)
    best, idle = (np.inf, K), 0
    memory: list[tuple[Matrix, Matrix]] = []
    for _ in range(MOVES):
        residual, toward = _descent(now, K, state, columns)
        good = best[0] <= STATIONARITY_TOL
        progress = residual < (best[0] / 2 if good else best[0])  # NaN is none
        idle = 0 if progress else idle + 1
        best = min(best, (residual, K), key=lambda pair: pair[0])
        if best[0] <= REFINED or idle >= (POLISHING if good else PATIENCE):
            break
        memory = [*memory[-MEMORY:], (K, toward - K)]
        for trial in _trials(memory):
            lower, reached = steady_cost(now, trial, now.whole_weight)
            if lower <= cost * (1 + 1e-13):  # equal: at the bottom costs only round
                break
        else:
            break
        K, cost, state = trial, lower, reached
    _require_reached(now, *best)
    return best[1]


def _require_reached(now: Setting, residual: float, K: Matrix) -> None:
    """Raise unless K is stationary, and stable by more than rounding."""
    if radius(reduced_dynamics(now, K)) >= 1 - UNIT_TOL:
        require_excited(now, K)
        raise CertificateError(
            "the best constant gain leaves a pole on the unit circle, to rounding, so "
            "its start would never be forgotten. Use horizon='step', or other accurate "
            "outputs."
        )
    if residual > STATIONARITY_TOL:
        raise CertificateError(
            "the best constant gain was not reached: the stationarity residual stays "
            f"at {residual:.1e}. Use horizon='step', or other accurate outputs"
            + ("." if now.whole_weight.diagonal().all() else WEIGHED)
        )


def _trials(memory: Sequence[tuple[Matrix, Matrix]]) -> Iterator[Matrix]:
    """Gains to try in turn: extrapolated, then along the descent ever more shortly."""
    K, move = memory[-1]
    if len(memory) > 1:
        moves = np.stack([(move - m).ravel() for _, m in memory[:-1]], axis=1)
        steps = np.stack([(K + move - k - m).ravel() for k, m in memory[:-1]], axis=1)
        mix = np.linalg.lstsq(moves, move.ravel(), rcond=1e-12)[0]
        yield K + move - (steps @ mix).reshape(K.shape)
    for halvings in range(30):
        yield K + move / 2**halvings


def _descent(
    now: Setting, K: Matrix, state: tuple[Matrix, Matrix], columns: np.ndarray
) -> tuple[float, Matrix]:
    """Relative stationarity residual at K, and the step-wise gain to move toward."""
    Sigma, Phi = state
    Lambda = _in_the_end(Phi, now.whole_weight)
    new = step_from(now._replace(Gamma=_regamma(now, Lambda, columns)), Sigma)
    gradient = kernels.compiled(steady_gradient)(
        K=K, M=new["M"], Omega=new["Omega"], C=now.C, Lambda=Lambda
    )["Gradient"]
    along = now.Phat.T
    size = 2 * np.linalg.norm(along @ Lambda) * np.linalg.norm(new["Omega"] @ now.C.T)
    residual = float(np.linalg.norm(along @ gradient) / size) if size > 0 else 0.0
    return residual, new["K"]


def _regamma(now: Setting, weight: Matrix, columns: np.ndarray) -> Matrix:
    Gamma = np.zeros_like(now.Gamma)
    Gamma[:, columns] = complete(now.C[columns], weight)[1]
    return Gamma
