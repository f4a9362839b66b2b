"""Which rows C_i A^k are independent: decided level by level, in even units.

A row is judged by its distance from the rows before it.  What is multiplied by A to
reach the next level is not the row but its part orthogonal to the lower levels: the
spans are the same, and high powers, whose rows all turn toward one direction, never
enter a decision.
"""

from collections.abc import Iterable
from dataclasses import dataclass
from typing import NoReturn

import numpy as np

from ..errors import DesignError
from . import Matrix, Vector, rationals
from .even_pair import Pair, even_pair, highest
from .linalg import modes

ROUNDING = 4 * float(np.finfo(float).eps)  # of an entry of a unit row, for each state
Alive = dict[int, tuple[Vector, float]]  # unit rows that may go on, their true sizes


@dataclass(frozen=True)
class Choice:
    indices: tuple[int, ...]
    tol: float = 0.0
    margin: float = 0.0


def default_tol(n: int) -> float:
    return 50 * n * float(np.finfo(float).eps)


def choose(
    A: Matrix,
    C: Matrix,
    dt: float,
    selection: str,
    tol: float | None,
    exact: tuple[Matrix, Matrix] | None,
) -> Choice:
    """Subindices of (6), one per output; DesignError if they do not add up to n.

    `exact` is A and C in Fractions, where a decision is to be exact.
    """
    tol = default_tol(len(A)) if tol is None else float(tol)
    even, found = in_even_units(A, C, dt, tol)
    if exact is None:
        chosen = _largest_or_first(even, tol, selection)
    else:
        chosen = Choice(_exact(*exact))
        if selection == "largest":
            largest = _largest_or_first(even, tol, selection).indices
            chosen = Choice(largest) if _spans(*exact, largest) else chosen
    if sum(chosen.indices) < len(A):
        _refuse(even, found, sum(chosen.indices), tol)
    return chosen


def in_even_units(
    A: Matrix, C: Matrix, dt: float, tol: float
) -> tuple[Pair, list[Matrix]]:
    """The pair in the units in which it is judged, and its levels there."""
    return highest(even_pair(A, C, dt), lambda A, C: climb(A, C, tol))


def _refuse(even: Pair, found: list[Matrix], seen: int, tol: float) -> NoReturn:
    A = even.A
    _, zero, values = split_hidden(found, A, tol)
    values = np.concatenate([np.zeros(zero), values * even.rate])
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


def outside(rows: Matrix, basis: Matrix) -> Matrix:
    """The part of `rows` orthogonal to orthonormal `basis`; twice is enough."""
    for _ in range(2):
        rows = rows - (rows @ basis.conj().T) @ basis
    return rows


def _largest_or_first(even: Pair, tol: float, selection: str) -> Choice:
    A, C = even.A, even.C
    n, p = A.shape[0], len(C)
    lengths = np.linalg.norm(C, axis=1, keepdims=True)
    C = C / np.where(lengths > 0, lengths, 1)
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


def climb(A: Matrix, C: Matrix, tol: float) -> tuple[list[Matrix], int, float]:
    """`levels`, their rank, and the smallest singular value that was not called 0.

    Of stacks (N, n, n) and (N, p, n) they span all that any of these A and C shows.
    """
    n = A.shape[-1]
    found, basis, scale, margin = [], np.zeros((0, n), A.dtype), 1.0, np.inf
    rows = C.reshape(-1, n)
    while len(basis) < n and len(rows):
        rows = outside(rows, basis)
        _, size, new = np.linalg.svd(rows, full_matrices=False)
        new = outside(new[size > tol * scale], basis)
        if not len(new):
            break
        margin = min(margin, size[len(new) - 1] / scale)
        new = np.linalg.qr(new.conj().T)[0].conj().T
        # What rounding left would be all that A moves, where it moves nothing else.
        new = np.where(np.abs(new) > ROUNDING * n, new, 0.0)
        found.append(new)
        basis = np.vstack([basis, new])
        scale = max(scale * (len(found) > 1), _row_size(new, A))
        rows = (new @ A).reshape(-1, n)
    return found, len(basis), float(margin)


def _row_size(rows: Matrix, A: Matrix) -> float:
    return np.linalg.norm(np.abs(rows) @ np.abs(A), axis=-1).max()


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
