"""Records of one plant: each as it is by itself, and which have the same gaps."""

from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from itertools import pairwise

import numpy as np

from .. import kernels
from ..errors import DesignError
from ..numeric import Matrices, Matrix, Vector
from ..numeric.linalg import finite
from ..recursion.growth import far, passed, require_digits
from ..recursion.progress import Progress
from ..recursion.settings import Settings
from ..recursion.settled_pass import SettledPass
from ..recursion.state import History
from .fleet import Fleet


@dataclass(frozen=True, eq=False)
class Records:
    """Records y (M, N, p) with inputs u (M, N, m), NaN where not measured.

    They are some of a fleet; `first` is the number of the first one.  If `whole` is
    true, nothing is missing; else something may be.
    """

    fleet: Fleet
    y: np.ndarray
    u: np.ndarray
    first: int = 0
    whole: bool = False

    @property
    def settings(self) -> Settings:
        """Those of the filter."""
        return self.fleet.settings

    @cached_property
    def run(self) -> SettledPass:
        """The way of a filter over a record with gaps, which threads do not share."""
        return SettledPass(self.settings, None)

    @cached_property
    def complete(self) -> bool:
        """Whether nothing is missing, as a quick look tells."""
        return self.whole or finite(self.y)

    @cached_property
    def read(self) -> Matrices:
        """Measurements and inputs, a row for each record, and which row is whose."""
        y, u = self.y, self.u
        M, N, p = y.shape
        every = np.arange(M)
        same = M > 0 and u.strides[0] == 0  # one input for all
        u = u[:1] if same else u
        return dict(
            y=kernels.plain_array(y.reshape(M, N * p)), which_y=every,
            u=kernels.plain_array(u.reshape(len(u), N * u.shape[2])),
            which_u=np.zeros_like(every) if same else every,
        )  # fmt: skip

    def told(self, s: int) -> Matrix:
        """J in every row of record s, zero for what did not arrive; or (1, ...)."""
        whole, stacks = self.fleet.whole, self.run.run.stacks
        assert whole is not None and stacks is not None
        if not stacks.cross:
            return whole.matrices["J"][:1]
        given, *_ = stacks.given(self.fleet.begin, self.y[s], self.u[s])
        J, now = given["J"], given["now"]
        return J if len(J) == 1 else np.ascontiguousarray(J[now])

    def one(
        self, s: int, history: bool, way: SettledPass | None = None
    ) -> tuple[Progress, History]:
        """Record s by itself."""
        begin, compile = Progress(self.fleet.begin), self.fleet.compile
        try:
            return (way or self.run).over(begin, self.y[s], self.u[s], compile, history)
        except DesignError as error:
            raise DesignError(f"record {self.first + s}: {error}") from error

    def require_digits(self, s: int, variances: Matrix) -> None:
        """DesignError if the states of record s have grown beyond their digits."""
        y, u = self.y[s], self.u[s]
        begin, compile = self.fleet.begin, self.fleet.compile
        rows = passed(self.run.run, begin, y, u, variances, compile)
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
        if self.complete:
            return np.zeros((M, 1), dtype=np.uint8)
        return np.packbits(np.isnan(self.y).reshape(M, N * p), axis=1)

    def alike(self, which: Vector) -> Iterator[Vector]:
        """Those with the same gaps, in the order of the first of them."""
        if self.complete or not len(which):
            yield from (which,) if len(which) else ()
            return
        group = self.groups(which)
        order, ends = np.argsort(group, kind="stable"), np.cumsum(np.bincount(group))
        for a, b in pairwise([0, *ends.tolist()]):
            yield which[order[a:b]]

    def groups(self, which: Vector) -> Vector:
        """A number for each of them, the same for those with the same gaps."""
        some = self.gaps[which]
        if not some.any():  # none has any
            return np.zeros(len(which), dtype=int)
        texts = some.view(f"V{some.shape[1]}")[:, 0].tolist()
        number = {text: k for k, text in enumerate(dict.fromkeys(texts))}
        return np.fromiter(map(number.__getitem__, texts), int, len(texts))
