"""Records of one plant: each as it is by itself, and which have the same gaps."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..numeric.linalg import finite
from ..recursion.growth import far, passed, require_digits
from ..recursion.progress import Progress
from ..recursion.settings import Settings
from ..recursion.settled_pass import SettledPass
from ..recursion.state import History, State, start


@dataclass(frozen=True, eq=False)
class Records:
    """Records y (M, N, p) with inputs u (M, N, m), NaN where not measured.

    `first` is the number of the first one.  If they are `complete`, nothing is missing;
    else something may be.
    """

    settings: Settings
    y: np.ndarray
    u: np.ndarray
    u0: np.ndarray
    compile: bool
    first: int
    complete: bool = False

    @cached_property
    def run(self) -> SettledPass:
        """The way of a filter over one record, in full."""
        return SettledPass(self.settings, None)

    @cached_property
    def begin(self) -> State:
        """The state at instant 0, of every record."""
        return start(self.run, self.settings.plant.x0, self.u0)

    def one(self, s: int, history: bool) -> tuple[Progress, History]:
        """Record s by itself."""
        begin = Progress(self.begin)
        try:
            return self.run.over(begin, self.y[s], self.u[s], self.compile, history)
        except DesignError as error:
            raise DesignError(f"record {self.first + s}: {error}") from error

    def require_digits(self, s: int, variances: Matrix) -> None:
        """DesignError if the states of record s have grown beyond their digits."""
        y, u = self.y[s], self.u[s]
        rows = passed(self.run.run, self.begin, y, u, variances, self.compile)
        try:
            require_digits(None, rows)
        except DesignError as error:
            raise DesignError(f"record {self.first + s}: {error}") from error

    def grown(
        self, which: Vector, variances: Matrix, at: Vector, least: Matrix, most: Matrix
    ) -> None:
        """The same of all records `which` where variances are far apart.

        They are in the rows `at` of variances, `least` and `most`.
        """
        for k in np.flatnonzero(far(least[at], most[at])).tolist():
            self.require_digits(int(which[k]), np.maximum(variances[at[k]], 0))

    @cached_property
    def gaps(self) -> Matrix:
        """Which entries are missing, in bits, a row for each record."""
        M, N, p = self.y.shape
        if self.complete or finite(self.y):
            return np.zeros((M, 1), dtype=np.uint8)
        return np.packbits(np.isnan(self.y).reshape(M, N * p), axis=1)

    def alike(self, which: Vector) -> Iterator[Vector]:
        """Those with the same gaps, in the order of the first of them."""
        group = self.groups(which)
        order, ends = np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))
        return (which[order[a:b]] for a, b in pairwise([0, *ends.tolist()]))

    def groups(self, which: Vector) -> Vector:
        """A number for each of them, the same for those with the same gaps."""
        some = self.gaps[which]
        if not some.any():  # none has any
            return np.zeros(len(which), dtype=int)
        texts = some.view(f"V{some.shape[1]}")[:, 0].tolist()
        number = {text: k for k, text in enumerate(dict.fromkeys(texts))}
        return np.fromiter(map(number.__getitem__, texts), int, len(texts))
