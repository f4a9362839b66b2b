"""Which modes the outputs do not see, in whatever units states and outputs are.

A mode is unseen if [A - mode I; C] has dependent columns (Popov, Belevitch, Hautus).
Whether they are dependent to rounding hangs on the units, so the pencil is scaled
first, and in one way for all units.  A state is measured by how strongly it is seen:
through C, or through a state i that is seen, as a_ij / (|mode| + |a_ii|); the
strongest way counts.  Then no entry exceeds 1 and every column has an entry that is 1
along its way.  States without a way to an output are unseen for themselves.
"""

import numpy as np

from ..errors import DesignError
from . import Matrix, Vector
from .factors import EPS
from .linalg import RANK_TOL, UNIT_TOL, modes

SUSPECT = 1e-3  # a singular value below this: eigenvalues are searched for nearby
CLOSE = 1e-3  # relative distance that rounding may move a repeated eigenvalue
REFINEMENTS = 8
SQUARES = 10  # powers up to 512
SWEEPS = 3  # of scaling outputs by states and states by outputs


def require_detectable(A: Matrix, C: Matrix) -> None:
    """Raise DesignError naming the modes that are not stable and not seen by C."""
    hidden = hidden_modes(A, C, 1 - UNIT_TOL)
    if hidden:
        raise DesignError(
            f"not detectable: the plant mode at {modes(hidden)} does not decay and "
            "does not reach the outputs, so its error grows without bound or never "
            "dies out. Add a sensor that sees it, or a model in which it decays."
        )


def hidden_modes(A: Matrix, C: Matrix, least: float = 0.0) -> list[complex]:
    """Eigenvalues of A, of at least this size, that C does not see, each once.

    Of two conjugate ones that with positive imaginary part.
    """
    way = _has_way(A, C)
    values = np.linalg.eigvals(A[np.ix_(~way, ~way)])
    found = [mode for mode in values if abs(mode) >= least]
    A, C = A[np.ix_(way, way)], C[:, way]
    for mode in np.linalg.eigvals(A):
        if mode.imag >= 0 and abs(mode) >= least * (1 - CLOSE):
            mode, gap = _nearest(A, C, mode)
            known = any(abs(mode - one) <= UNIT_TOL * abs(mode) for one in found)
            if gap <= RANK_TOL and abs(mode) >= least and not known:
                found.append(mode)
    return found


def dies_out(A: Matrix) -> bool:
    """Whether a power of A is small, so that all modes decay; False may be wrong.

    Powers are quicker than eigenvalues where there are many states.
    """
    off = 0.0  # how far rounding has moved the power, at most
    with np.errstate(over="ignore", invalid="ignore"):
        for _ in range(SQUARES):
            size = np.abs(A).sum(axis=1).max(initial=0.0)
            if size + off < 0.9:
                return True
            off = off * (2 * size + off) + len(A) * EPS * size * size
            A = A @ A
    return False


def _has_way(A: Matrix, C: Matrix) -> Vector:
    """The states from which entries that are not zero lead to an output."""
    way, reached = np.zeros(len(A), dtype=bool), (C != 0).any(axis=0)
    while (reached & ~way).any():
        way |= reached
        reached = (A[way] != 0).any(axis=0)
    return way


def _nearest(A: Matrix, C: Matrix, mode: complex) -> tuple[complex, float]:
    """The nearest value at which the pencil loses rank most, and by how much it fails.

    Rounding moves an eigenvalue that is repeated by more than rounding; a step of
    Newton's method on the smallest singular value takes it back.
    """
    pencil, slope = _pencil(A, C, mode)
    n, start, best = len(A), mode, (np.inf, mode)
    for _ in range(REFINEMENTS):
        moved = pencil.astype(complex)
        moved[np.arange(n), np.arange(n)] -= slope * (mode - start)
        left, values, right = np.linalg.svd(moved, full_matrices=False)
        if values[-1] >= best[0]:
            break
        best = values[-1], mode
        turn = left[:n, -1].conj() @ (slope * right[-1].conj())
        if not RANK_TOL < values[-1] < SUSPECT or turn == 0:
            break
        mode = mode + values[-1] / turn
        if abs(mode - start) > CLOSE * max(abs(start), 1.0):
            break
    gap, mode = best
    return mode, gap


def _pencil(A: Matrix, C: Matrix, mode: complex) -> tuple[Matrix, Vector]:
    """[A - mode I; C] in the units of `_sight`, and the slope of its diagonal."""
    size = np.abs(A.diagonal()) + abs(mode)
    size = np.where(size > 0, size, 1.0)
    coupling = A - np.diag(A.diagonal())
    sight, outputs = _sight(_log(coupling) - np.log(size)[:, None], _log(C))
    rows = np.sign(coupling) * np.exp(
        _log(coupling) - np.log(size)[:, None] + sight[:, None] - sight
    )
    rows = rows + np.diag((A.diagonal() - mode) / size)
    shown = np.sign(C) * np.exp(_log(C) - outputs[:, None] - sight)
    return np.vstack([rows, shown]), 1 / size


def _log(X: Matrix) -> Matrix:
    with np.errstate(divide="ignore"):
        return np.log(np.abs(X))


def _sight(gain: Matrix, shown: Matrix) -> tuple[Vector, Vector]:
    """Logarithms of how strongly each state is seen, and of each output's unit.

    `gain` and `shown` are the logarithms of what passes from state to state, and from
    state to output.
    """
    outputs = shown.max(axis=1, initial=-np.inf)
    for _ in range(SWEEPS):
        outputs = np.where(np.isfinite(outputs), outputs, 0.0)
        sight = (shown - outputs[:, None]).max(axis=0)
        for _ in range(len(gain)):
            further = np.maximum(sight, (sight[:, None] + gain).max(axis=0))
            if (further == sight).all():
                break
            sight = further
        outputs = (shown - sight).max(axis=1)
    return sight, np.where(np.isfinite(outputs), outputs, 0.0)
