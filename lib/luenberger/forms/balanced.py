"""Balanced coordinates: inputs reach each state as far as the estimate shows it."""

import numpy as np
import scipy.linalg

from .. import kernels
from ..errors import DesignError
from ..numeric import Matrix
from ..numeric.linalg import decaying, eigenvalues, lyapunov, modes, symmetrise
from .derivation import balancing
from .system import Change, System

LEAST = 1e-6  # of the largest singular value: a state below it has none to speak of


def balanced_form(system: System, dt: float) -> Change:
    """Balanced coordinates of a stable system, by square roots of its Gramians."""
    F, N, P, _ = system
    _require_stable(F, dt)
    roots = dict(R=_root(gramian(F, N, dt)), M=_root(gramian(F.T, P.T, dt)).T)
    left, values, right = scipy.linalg.svd(roots["M"] @ roots["R"])
    _require_minimal(roots["R"], roots["M"], values)
    k = np.diag(values**-0.5)
    found = kernels.compiled(balancing)(**roots, Q_1=left, Q_2=right.T, k=k)
    S, U = found["S"], found["U"]
    moved = S @ N
    largest = moved[np.arange(len(S)), np.abs(moved).argmax(axis=1)]
    sign = np.where(largest < 0, -1.0, 1.0)  # a vector's sign is left open
    return Change(S * sign[:, None], U * sign)


def gramian(F: Matrix, N: Matrix, dt: float) -> Matrix:
    """X = F X F' + N N', or in continuous time F X + X F' + N N' = 0."""
    if dt:
        return lyapunov(F, N @ N.T)
    return symmetrise(scipy.linalg.solve_continuous_lyapunov(F, -N @ N.T))


def _root(X: Matrix) -> Matrix:
    values, vectors = np.linalg.eigh(X)
    return vectors * np.sqrt(np.maximum(values, 0.0))


def _require_stable(F: Matrix, dt: float) -> None:
    poles = eigenvalues(F)
    lasting = poles[~decaying(poles, dt > 0)]
    if len(lasting):
        raise DesignError(
            f"a balanced form is of a stable observer, and the poles {modes(lasting)} "
            "do not decay. Use modal() or companion()."
        )


def _require_minimal(R: Matrix, M: Matrix, values: Matrix) -> None:
    """Raise where some state is not reached, or not shown; say how many and which."""
    lacking = int((values <= LEAST * values.max()).sum())
    if not lacking:
        return
    reached, shown = (int(np.linalg.matrix_rank(X, rtol=LEAST)) for X in (R, M))
    r = len(values)
    causes = [
        f"y and u reach only {reached} of {r} states" * (reached < r),
        f"the estimate shows only {shown} of {r} states" * (shown < r),
    ]
    cause = " and ".join(filter(None, causes)) or (
        f"y and u reach {lacking} of {r} states that the estimate hardly shows"
    )
    raise DesignError(
        f"there is no balanced form: {cause}. Use modal(), which takes them apart, or "
        "design an observer of lower order."
    )
