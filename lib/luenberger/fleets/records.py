"""Records of one plant: each as it is by itself, and which have the same gaps."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from ..errors import DesignError
from ..numeric import Matrix, Vector
from ..recursion.growth import far, passed, require_digits
from ..recursion.settings import Settings
from ..recursion.settled_pass import Progress, SettledPass
from ..recursion.state import History, State, start


@dataclass(frozen=True, eq=False)
class Records:
    """Records y (M, N, p) with inputs u (M, N, m), NaN where not measured.

    `first` is the number of the first one.
    """

    settings: Settings
    y: np.ndarray
    u: np.ndarray
    u0: np.ndarray
    compile: bool
    first: int

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

    def require_digits(self, s: int, std: Matrix) -> None:
        """DesignError if the states of record s have grown beyond their digits."""
        y, u = self.y[s], self.u[s]
        rows = passed(self.run.run, self.begin, y, u, std * std, self.compile)
        try:
            require_digits(None, rows)
        except DesignError as error:
            raise DesignError(f"record {self.first + s}: {error}") from error

    def grown(
        self, which: Vector, std: Matrix, at: Vector, least: Matrix, most: Matrix
    ) -> None:
        """The same of all records `which` where variances are far apart.

        They are in the rows `at` of std, `least` and `most`.
        """
        for k in np.flatnonzero(far(least[at], most[at])).tolist():
            self.require_digits(int(which[k]), std[at[k]])

    @cached_property
    def gaps(self) -> Matrix:
        """Which entries are missing, in bits, a row for each record."""
        M, N, p = self.y.shape
        return np.packbits(np.isnan(self.y).reshape(M, N * p), axis=1)

    def alike(self, which: Vector) -> Iterator[Vector]:
        """Those with the same gaps, in the order of the first of them."""
        found: dict[bytes, list[int]] = {}
        some = self.gaps[which]
        if not some.any():  # none has any
            return iter([which] if len(which) else [])
        for s, gaps in zip(which.tolist(), some):
            found.setdefault(gaps.tobytes(), []).append(s)
        return map(np.array, found.values())
