"""What was added to errors in the last steps, and how the steps have moved it since.

A difference of covariances is the sum of what each step added, moved from both sides.
An error of the estimate is moved from one side.  What is older than the window counts
as added by the last step, and so does what rounding does to the moves here.
"""

from __future__ import annotations

import numpy as np

from ...numeric import Matrices, Matrix
from ...numeric.factors import EPS
from ...numeric.power_sums import SLACK
from ...numeric.rounded import Rounded

NAMES = ("squares", "spreads", "errors", "through", "reached", "inputs")


class Window:
    """Moves of the last steps, newest first, and what each step added.

    Attributes
    ----------
    moves : (N, n, n) ndarray
    squares : (N, k, n, n) ndarray
        Sizes that are moved from both sides, of k kinds.
    spreads : (N, k, n, n) ndarray
        Sizes that are moved from both sides, by As first.
    errors : (N, n, c) ndarray
        Sizes that are moved from one side.
    through : (N, n, c) ndarray
        Sizes that are moved by As first.
    reached : (N, n, c) ndarray
        Sizes that the exact prediction has besides `inputs`.
    inputs : (N, n, c) ndarray
        What readings do to the exact prediction, with its sign.
    """

    def __init__(self, As: Matrix, kinds: int, columns: int, length: int) -> None:
        n = len(As)
        self.As, self.length = As, length
        self.moves = np.zeros((0, n, n))
        self.squares = self.spreads = np.zeros((0, kinds, n, n))
        self.errors, self.through, self.reached, self.inputs = (
            np.zeros((0, n, columns)) for _ in range(4)
        )

    def add(self, **new: Matrix) -> None:
        """What the last step added, by name."""
        self.moves = np.concatenate([np.eye(len(self.As))[None], self.moves])
        for name in NAMES:
            there = getattr(self, name)
            one = new.get(name, np.zeros(there.shape[1:]))
            setattr(self, name, np.concatenate([one[None], there]))

    def move(self, F: Rounded) -> Matrices:
        """Move everything by F.

        Returns what has to be added to squares, errors and what is reached.
        """
        ahead = F.value @ self.moves
        lost = F.off + (len(self.As) + 2) * EPS * np.abs(F.value)
        lost = lost @ np.abs(self.moves)
        size, As = np.abs(ahead), np.abs(self.As)
        squares = self.squares + As @ self.spreads @ As.T
        errors = self.errors + As @ self.through
        reached = self.reached + np.abs(self.inputs)
        mixed = _twice(lost, squares, 2 * size + lost)
        mixed = (mixed + mixed.swapaxes(-1, -2)) / 2
        more = dict(errors=(lost @ errors).sum(axis=0))
        more["reached"] = (lost @ reached).sum(axis=0)
        if len(ahead) >= self.length:
            mixed = mixed + _twice(size[-1:], squares[-1:], size[-1:])
            more["errors"] += size[-1] @ errors[-1]
            more["reached"] += size[-1] @ reached[-1]
            ahead = ahead[:-1]
            for name in NAMES:
                setattr(self, name, getattr(self, name)[:-1])
        self.moves = ahead
        more["squares"] = mixed
        return {name: X * (1 + SLACK) for name, X in more.items()}

    def seen(self, left: Rounded, right: Matrix | None = None) -> Matrix:
        """Sizes of ``left moves right``, of each move."""
        made = left.value @ self.moves
        part = left.off + 2 * (len(self.As) + 2) * EPS * np.abs(left.value)
        off = part @ np.abs(self.moves)
        if right is not None:
            made, off = made @ right, off @ np.abs(right)
        return np.asarray(np.abs(made) + 2 * off)

    def square(self, left: Rounded, right: Rounded) -> Matrix:
        """Sizes of ``left Xi right'`` at most, of each kind of difference Xi."""
        direct = _twice(self.seen(left), self.squares, self.seen(right))
        moved = self.seen(left, self.As), self.spreads, self.seen(right, self.As)
        return (direct + _twice(*moved)) * (1 + SLACK)

    def error(self, left: Rounded) -> Matrix:
        """Sizes of ``left e`` at most, e being the error of the prediction."""
        direct = (self.seen(left) @ self.errors).sum(axis=0)
        through = (self.seen(left, self.As) @ self.through).sum(axis=0)
        return np.asarray((direct + through) * (1 + SLACK))

    def reach(self, left: Rounded) -> Matrix:
        """Sizes of ``left x`` at most, x being the exact prediction."""
        made = self.seen(left, self.inputs) + self.seen(left) @ self.reached
        return np.asarray(made.sum(axis=0) * (1 + SLACK))


def _twice(left: Matrix, X: Matrix, right: Matrix) -> Matrix:
    """The sum of ``left X right'`` over all moves."""
    return np.asarray((left[:, None] @ X @ right[:, None].swapaxes(-1, -2)).sum(axis=0))
