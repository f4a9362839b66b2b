"""An observer's pass over the rows of a record, in NumPy or compiled."""

from __future__ import annotations

from collections.abc import Callable
from functools import partial

import numpy as np

from .. import kernels
from ..kernels import Recursion, at_hand, entries_known, may_be_at_hand, plain_array
from ..numeric import Matrices, Matrix, Vector
from ..observer import Observer
from ..papers.leondes_novak.derivation import observer_step

ESTIMATED = 1_000_000  # rows that NumPy estimates in the time that compiling takes
OBSERVER = Recursion(
    observer_step,
    carried=(("z_next", "z"),),
    rows=(("y", "y", 0), ("u", "u", 0)),
    written=(("w_hats", "w_hat", "vector"),),
)


def plain(
    observer: Observer,
    y: Matrix,
    u: Matrix,
    kept: Callable[[Vector], Vector] = np.positive,
) -> Matrix:
    """Estimates of a constant observer from z0 on; of each state it keeps kept(z)."""
    return over_rows(observer, kept(observer.z0), y, u, slice(0, len(y)), kept)[1]


def over_rows(
    observer: Observer,
    z: Vector,
    y: Matrix,
    u: Matrix,
    here: slice,
    kept: Callable[[Vector], Vector] = np.positive,
) -> tuple[Vector, Matrix]:
    """The state after the rows `here`, and their estimates, in NumPy."""
    matrices = (getattr(observer, name) for name in "FGDPVW")
    F, G, D, P, V, W = (X if X.ndim == 2 else X[here] for X in matrices)
    drive = _apply(G, u) + _apply(D, y)
    states = np.empty((len(y), observer.order))
    for k in range(len(y)):
        states[k] = z
        z = kept((F if F.ndim == 2 else F[k]) @ z + drive[k])
    return z, _apply(P, states) + _apply(V, y) + _apply(W, u)


def over_rows_compiled(
    observer: Observer, z: Vector, y: Matrix, u: Matrix, here: slice
) -> tuple[Vector, Matrix]:
    """The same in compiled code."""
    step = over_stacks(OBSERVER, *stacks_of(observer), here)
    z, w_hats = np.array(z, dtype=float), np.empty((len(y), len(observer.L)))
    step(stop=len(y), z=z, y=plain_array(y), u=plain_array(u), w_hats=w_hats)
    return z, w_hats


def stacks_of(o: Observer) -> tuple[dict[str, int], Matrices]:
    """The sizes of an observer, and stacks of its matrices."""
    given = {name: getattr(o, name) for name in "FGDPVW"}
    sizes = dict(m=o.G.shape[-1], p=o.D.shape[-1], q=len(o.L), r=o.order)
    return sizes, {k: X if o.steps is not None else X[None] for k, X in given.items()}


def is_at_hand(observer: Observer, rows: int) -> bool:
    """Whether the code for this observer has been compiled before."""
    if not may_be_at_hand(rows):
        return False
    return at_hand(rows, *_question(OBSERVER, *stacks_of(observer)))


def _question(
    recursion: Recursion, sizes: dict[str, int], stacks: Matrices
) -> tuple[Recursion, tuple, tuple, frozenset[str]]:
    """What `kernels.over_record` is asked for."""
    changing = frozenset(name for name, X in stacks.items() if len(X) > 1)
    known = tuple(
        (name, entries_known((X == 0).all(axis=0), (X == 1).all(axis=0)))
        for name, X in stacks.items()
    )
    return recursion, tuple(sizes.items()), known, changing


def over_stacks(
    recursion: Recursion,
    sizes: dict[str, int],
    stacks: Matrices,
    here: slice = slice(None),
) -> partial:
    """A compiled loop over a record, which has the matrices of the rows `here`.

    It still asks for ``stop``, the number of rows, and for what is not a matrix.  A
    stack (S, rows, cols) of one matrix is the same in every row.  Entries that are 0,
    or 1, in all of a stack are known to the compiler; see `kernels.over_record`.
    """
    asked = _question(recursion, sizes, stacks)
    step, changing, given = kernels.over_record(*asked), asked[-1], {}
    for name, X in stacks.items():
        part = X[here] if name in changing else X
        flat = part.reshape(len(part), X.shape[1] * X.shape[2])
        given[name] = np.array(flat, order="C")
    index = np.arange(max(map(len, given.values())))
    given |= dict(now=index, before=index, good=np.ones(len(index), dtype=bool))
    return partial(step, **given, start=0, keep=False)


def _apply(matrix: Matrix, signal: Matrix) -> Matrix:
    """matrix @ signal row by row; the matrix may change from row to row."""
    if matrix.ndim == 2:
        return signal @ matrix.T
    return (matrix @ signal[..., None])[..., 0]
