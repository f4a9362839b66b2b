"""Which rows C_i A^k are independent: decided level by level, in scaled units.

A row is judged by its distance from the rows before it.  What is multiplied by A to
reach the next level is not the row but its part orthogonal to the lower levels: the
spans are the same, and high powers, whose rows all turn toward one direction, never
enter a decision.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np
import scipy.linalg

from ..errors import DesignError
from . import Matrix, Vector, rationals
from .linalg import modes

SMALL_STAIR = 1e-4  # relative size of a stair that asks for better units
SWEEPS = 6  # alternations of row and column scaling; more change nothing much

Pair = tuple[Matrix, Matrix]  # A, C
Scaled = tuple[Vector, Vector, Matrix, Matrix]
Alive = dict[int, tuple[Vector, float]]  # unit rows that may go on, their true sizes


@dataclass(frozen=True)
class Choice:
    indices: tuple[int, ...]
    tol: float = 0.0
    margin: float = 0.0


def default_tol(n: int) -> float:
    return 50 * n * float(np.finfo(float).eps)


def choose(
    A: Matrix, C: Matrix, selection: str, tol: float | None, exact: Pair | None
) -> Choice:
    """Subindices of (6), one per output; DesignError if they do not add up to n.

    `exact` is A and C in Fractions, where a decision is to be exact.
    """
    tol = default_tol(len(A)) if tol is None else float(tol)
    _, _, A, C = scaled(A, C, tol)
    if exact is None:
        chosen = _largest_or_first(A, C, tol, selection)
    else:
        chosen = Choice(_exact(*exact))
        if selection == "largest":
            found = _largest_or_first(A, C, tol, selection).indices
            chosen = Choice(found) if _spans(*exact, found) else chosen
    if sum(chosen.indices) < len(A):
        _refuse(A, C, sum(chosen.indices), tol)
    return chosen


def _refuse(A: Matrix, C: Matrix, seen: int, tol: float) -> NoReturn:
    _, zero, values = split_hidden(levels(A, C, tol), A, tol)
    values = np.concatenate([np.zeros(zero), values])
    which = f"the plant modes {modes(values)}" if len(values) else "some modes"
    advice = (
        "Add a sensor that sees them, or leave them out of the model."
        if values.any()
        else "They die out in finite time, so deadbeat_observer accepts this plant."
    )
    raise DesignError(
        f"not observable: only {seen} of the {len(A)} states can be told from the "
        f"outputs; {which} do not reach them. {advice}"
    )


def scaled(A: Matrix, C: Matrix, tol: float | None = None) -> Scaled:
    """Scales d of x and s of y, diag(1/d) A diag(d), and diag(1/s) C diag(d).

    Units of states and outputs must not decide anything.  The d balance A, as for an
    eigenvalue problem; where that leaves a very small stair, as in a chain of states
    with unlike units, they balance the columns of the observability matrix instead.
    """
    tol = default_tol(len(A)) if tol is None else tol
    best = _in_units(A, C, _balanced(A))
    rank, margin = _stairs(*best[2:], tol)
    if rank < len(A) or margin < SMALL_STAIR:
        other = _in_units(A, C, _seen(A, C))
        if _stairs(*other[2:], tol) > (rank, margin / SMALL_STAIR):
            return other
    return best


def _stairs(A: Matrix, C: Matrix, tol: float) -> tuple[int, float]:
    """Rank, and the smallest stair that was kept."""
    found, margin = climb(A, C, tol)
    return sum(map(len, found)), margin


def _in_units(A: Matrix, C: Matrix, d: Vector) -> Scaled:
    C = C * d
    s = np.linalg.norm(C, axis=1)
    s = np.where(s > 0, s, 1)
    return d, s, A / d[:, None] * d, C / s[:, None]


def _balanced(A: Matrix) -> Vector:
    (gebal,) = scipy.linalg.get_lapack_funcs(("gebal",), (A,))
    d = gebal(A, scale=True, permute=False)[3]
    return np.where(np.isfinite(d) & (d > 0), d, 1.0)


def _seen(A: Matrix, C: Matrix) -> Vector:
    """Scales that give the columns of the observability matrix comparable sizes."""
    size = float(np.abs(np.linalg.eigvals(np.abs(A))).max())
    size = size if size > 0 else 1.0  # Perron's root: the same in all units
    rows, power = [], C
    for _ in range(len(A)):
        rows.append(np.abs(power))
        power = power @ A / size
    rows = np.array(rows)
    outputs, d = np.ones(len(C)), np.ones(len(A))
    for _ in range(SWEEPS):
        d = _reciprocal((rows * outputs[:, None]).max(axis=(0, 1), initial=0))
        outputs = _reciprocal((rows * d).max(axis=(0, 2)))
    return d


def scaling(M: Matrix) -> tuple[Vector, Vector]:
    """Powers of two that bring the rows and columns of M to comparable size."""
    row, column = np.ones(len(M)), np.ones(M.shape[1])
    for _ in range(SWEEPS):
        row = _reciprocal((np.abs(M) * column).max(axis=1))
        column = _reciprocal((np.abs(M) * row[:, None]).max(axis=0))
    return row, column


def _reciprocal(size: Vector) -> Vector:
    size = np.where((size > 0) & np.isfinite(size), size, 1.0)
    return np.exp2(-np.round(np.log2(size)))  # powers of two: scaling is exact


def outside(rows: Matrix, basis: Matrix) -> Matrix:
    """The part of `rows` orthogonal to orthonormal `basis`; twice is enough."""
    for _ in range(2):
        rows = rows - (rows @ basis.conj().T) @ basis
    return rows


def _largest_or_first(A: Matrix, C: Matrix, tol: float, selection: str) -> Choice:
    n, p = A.shape[0], len(C)
    indices, margin, scale = [0] * p, np.inf, 1.0
    basis = np.zeros((0, n), C.dtype)
    alive = {i: (C[i], 1.0) for i in range(p) if C[i].any()}
    while alive and len(basis) < n:
        parts = {i: outside(row, basis) for i, (row, _) in alive.items()}
        left, kept, level = list(alive), [], np.zeros((0, n), basis.dtype)
        while left:
            rest = {i: float(np.linalg.norm(outside(parts[i], level))) for i in left}
            i = left[0]
            if selection == "largest":
                i = max(left, key=lambda i: rest[i] * alive[i][1])
            left.remove(i)
            if rest[i] > tol * scale and len(basis) + len(level) < n:
                unit = outside(parts[i], level)[None] / rest[i]
                level = np.vstack([level, unit])
                margin = min(margin, rest[i] / scale)
                kept.append(i)
        basis = np.vstack([basis, level])
        for i in kept:
            indices[i] += 1
        scale, alive = _next_level(A, kept, parts, alive)
    return Choice(tuple(indices), tol, float(margin))


def _next_level(
    A: Matrix, kept: list[int], parts: dict[int, Vector], alive: Alive
) -> tuple[float, Alive]:
    """The kept rows times A, relative to the largest that such a row can be."""
    following, scale = {}, 0.0
    for i in kept:
        norm = float(np.linalg.norm(parts[i]))
        unit = parts[i] / norm
        scale = max(scale, float(np.linalg.norm(np.abs(unit) @ np.abs(A))))
        following[i] = (unit @ A, alive[i][1] * norm)
    return scale, following


def _exact(A: Matrix, C: Matrix) -> tuple[int, ...]:
    indices, span = [0] * len(C), rationals.Span()
    alive = list(enumerate(C))
    while alive:
        alive = [(i, row @ A) for i, row in alive if span.accept(row)]
        for i, _ in alive:
            indices[i] += 1
    return tuple(indices)


def levels(A: Matrix, C: Matrix, tol: float) -> list[Matrix]:
    """Orthonormal rows, level by level: C, then what each power of A adds to it.

    Stacked, they span what the outputs can see; in these coordinates A and C have
    Van Dooren's staircase form (7), the last level on top.
    """
    return climb(A, C, tol)[0]


def climb(A: Matrix, C: Matrix, tol: float) -> tuple[list[Matrix], float]:
    """`levels`, and the smallest singular value, relative, that was not called 0."""
    n = len(A)
    found, basis, scale, margin = [], np.zeros((0, n), A.dtype), 1.0, np.inf
    rows = C
    while len(basis) < n and len(rows):
        rows = outside(rows, basis)
        _, size, new = np.linalg.svd(rows, full_matrices=False)
        new = outside(new[size > tol * scale], basis)
        if not len(new):
            break
        margin = min(margin, size[len(new) - 1] / scale)
        new = np.linalg.qr(new.conj().T)[0].conj().T
        found.append(new)
        basis = np.vstack([basis, new])
        scale = max(scale * (len(found) > 1), _row_size(new, A))
        rows = new @ A
    return found, margin


def _row_size(rows: Matrix, A: Matrix) -> float:
    return np.linalg.norm(np.abs(rows) @ np.abs(A), axis=1).max()


def split_hidden(
    found: list[Matrix], A: Matrix, tol: float
) -> tuple[Matrix, int, Vector]:
    """What no output sees: its coordinates, how many are nilpotent, other modes.

    Returns orthonormal rows in whose coordinates the leading block of A is strictly
    upper triangular, the size of that block, and the eigenvalues of the rest.  The
    null space comes first, then that of what is left, and so on: eigenvalues that
    are zero and defective are too sensitive to be computed and compared.
    """
    hidden = _complement(found, A)
    scale = _row_size(hidden, A) if len(hidden) else 0.0
    done = 0
    while done < len(hidden):
        rest = hidden[done:]
        _, size, right = np.linalg.svd(rest @ A @ rest.conj().T)
        null = int((size <= tol * scale).sum())
        if not null:
            return hidden, done, np.linalg.eigvals(rest @ A @ rest.conj().T)
        hidden[done:] = right[::-1] @ rest
        done += null
    return hidden, done, np.zeros(0)


def _complement(found: list[Matrix], A: Matrix) -> Matrix:
    n = len(A)
    if not found:
        return np.eye(n, dtype=A.dtype)
    seen = np.vstack(found)
    full = np.linalg.qr(seen.conj().T, mode="complete")[0]
    return full[:, len(seen) :].conj().T.copy()


def _spans(A: Matrix, C: Matrix, indices: Iterable[int]) -> bool:
    """Whether the rows with these subindices are independent, exactly."""
    span = rationals.Span()
    for row, size in zip(C, indices):
        for _ in range(size):
            if not span.accept(row):
                return False
            row = row @ A
    return sum(indices) == len(A)
