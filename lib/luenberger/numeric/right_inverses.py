"""Right inverses of least weight, of many matrices at once.

They are those of `linalg.complete`, found for all in the same few operations: one
solution, less what the weight sees of it along the null space.
"""

import numpy as np

from . import Matrix, Vector

CLEARLY = 1e-6  # of what chosen columns leave: dependent rows are refused far below


def right_inverses(C: Matrix, weight: Matrix | None = None) -> tuple[Matrix, Vector]:
    """The right inverse of least trace of each of a stack, and whether there is one.

    Parameters
    ----------
    C : (N, m1, n) ndarray
        Each with fewer rows than columns, or as many.
    weight : (n, n) or (N, n, n) ndarray, optional
        Positive definite.  Default the identity.

    Returns
    -------
    inverses : (N, n, m1) ndarray
        ``W^-1 C' (C W^-1 C')^-1`` for each weight W.
    clear : (N,) ndarray of bool
        Whether the rows are independent beyond doubt.  Where they are not, the inverse
        is zero.
    """
    count, m1, n = C.shape
    found = np.zeros((count, n, m1))
    size = np.abs(C).max(axis=2, keepdims=True, initial=0)
    C = C / np.where(size > 0, size, 1)
    order, clear = _columns(C)
    if not clear.all():  # perhaps in better units
        units = np.abs(C[~clear]).max(axis=1, keepdims=True, initial=0)
        order[~clear], clear[~clear] = _columns(
            C[~clear] / np.where(units > 0, units, 1)
        )
    C, order = C[clear], order[clear]
    W = np.eye(n) if weight is None else weight
    W = np.broadcast_to(W, (count, n, n))[clear]
    if not len(C):
        return found, clear
    here = np.arange(len(C))[:, None]
    turned = np.take_along_axis(C, order[:, None], axis=2)
    W = W[here[:, :, None], order[:, :, None], order[:, None]]
    one, free = _solutions(turned[:, :, :m1], turned[:, :, m1:])
    one = _least(one, free, W)
    inverses = np.empty_like(one)
    inverses[here, order] = one
    found[clear] = inverses / size[clear].mT
    return found, clear


def _columns(C: Matrix) -> tuple[Matrix, Vector]:
    """All columns, first those that span most; whether they span all clearly."""
    count, m1, n = C.shape
    if m1 > n:
        return np.zeros((count, n), dtype=int), np.zeros(count, dtype=bool)
    lengths = np.linalg.norm(C, axis=2, keepdims=True)
    left = C / np.where(lengths > 0, lengths, 1)
    chosen, sizes = np.zeros((count, n), dtype=bool), np.zeros((count, m1))
    each = np.arange(count)
    for k in range(m1):
        size = np.where(chosen, -1.0, np.linalg.norm(left, axis=1))
        best = size.argmax(axis=1)
        sizes[:, k] = size[each, best]
        along = left[each, :, best] / np.where(sizes[:, k] > 0, sizes[:, k], 1)[:, None]
        left = left - along[:, :, None] * (along[:, None] @ left)
        chosen[each, best] = True
    clear = sizes[:, -1] > CLEARLY * sizes[:, 0] if m1 else np.ones(count, dtype=bool)
    return np.argsort(~chosen, axis=1, kind="stable"), np.asarray(clear)


def _solutions(bound: Matrix, free: Matrix) -> tuple[Matrix, Matrix]:
    """A right inverse of [bound free], and columns that span its null space."""
    count, m1, r = free.shape
    both = np.linalg.solve(
        bound, np.concatenate([np.broadcast_to(np.eye(m1), (count, m1, m1)), free], 2)
    )
    zeros, ones = np.zeros((count, r, m1)), np.broadcast_to(np.eye(r), (count, r, r))
    return (
        np.concatenate([both[:, :, :m1], zeros], 1),
        np.concatenate([-both[:, :, m1:], ones], 1),
    )


def _least(one: Matrix, free: Matrix, W: Matrix) -> Matrix:
    """A right inverse less what the weight sees of it along the null space."""
    seen = free.mT @ W
    square = seen @ free
    scale = 1 / np.sqrt(np.diagonal(square, axis1=1, axis2=2))[:, :, None]
    part = np.linalg.solve(square * scale * scale.mT, scale * (seen @ one))
    return one - free @ (scale * part)
