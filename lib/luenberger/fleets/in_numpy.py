"""Records with gaps of their own in NumPy: each row of many at once.

Covariances are found once for records with the same gaps, and then all estimates.
"""

from collections.abc import Iterator

import numpy as np

from .. import kernels
from ..numeric import Matrix, Vector
from ..numeric.columns import Columns, firm
from ..papers.leondes_novak.derivation import complete_sample, sample_with_gain
from .block import Block
from .records import Records
from .whole import Whole

MOST = 512  # records at once: what is computed stays near the processor


def many(out: Block, records: Records, which: Vector, whole: Whole) -> Vector:
    """Filter some records; return those that lose digits, which are not done."""
    if whole.stacks.cross or whole.stacks.accurate:
        return which
    left = [which[:0]]
    with np.errstate(all="ignore"):  # what has failed goes on with numbers of no use
        for groups in _parts(list(records.alike(which))):
            failed = _Rows(out, records, groups, whole).run()
            left += [groups[g] for g in np.flatnonzero(failed)]
    return np.sort(np.concatenate(left))


def _parts(groups: list[Vector]) -> Iterator[list[Vector]]:
    """Some groups of about `MOST` records at a time."""
    some, count = [], 0
    for members in groups:
        some.append(members)
        count += len(members)
        if count >= MOST:
            yield some
            some, count = [], 0
    if some:
        yield some


class _Rows:
    """The rows of some groups of records, one after the other."""

    def __init__(
        self, out: Block, records: Records, groups: list[Vector], whole: Whole
    ) -> None:
        self.out, self.records, self.whole = out, records, whole
        self.plant = records.settings.plant
        self.first = np.array([members[0] for members in groups])
        self.members = np.concatenate(groups)
        self.group = np.repeat(np.arange(len(groups)), [len(k) for k in groups])
        y = records.y[self.members]
        self.y, self.u = np.where(np.isnan(y), 0.0, y), records.u[self.members]
        self.seen = ~np.isnan(records.y[self.first])
        self.none = Columns.one(np.zeros((self.plant.n, self.plant.p)))
        self.gain = kernels.side_by_side(complete_sample, "K", "Sigma", "Omega_next")
        self.step = kernels.side_by_side(sample_with_gain, "x", "x_minus_next")

    def run(self) -> Vector:
        """Filter them; which groups have failed."""
        (G, N, _), n, begin = self.seen.shape, self.plant.n, self.whole.first
        Omega = Columns.one(begin["Omega"].reshape(n, n))
        x = Columns.one(begin["x_minus"])
        failed, variances = np.zeros(G, dtype=bool), np.empty((G, N, n))
        for k in range(N):
            found = self.spread(k, Omega)
            failed |= ~firm(found["Sigma"], Omega.diagonal)[:G]
            variances[:, k] = found["Sigma"].diagonal[:, :G].T
            self.keep(k, found)
            Omega, x = found["Omega_next"], self.estimate(k, found["K"], x)
        self.finish(variances, np.flatnonzero(~failed))
        return failed

    def matrix(self, name: str, k: int) -> Columns:
        """A matrix of the plant at row k."""
        whole, shape = self.whole.matrices[name], getattr(self.plant, name).shape[-2:]
        return Columns.one(whole[k if len(whole) > 1 else 0].reshape(shape))

    def spread(self, k: int, Omega: Columns) -> dict[str, Columns]:
        """Gains and covariances of a row, for each group."""
        seen = Columns.many(self.seen[:, k].astype(float)).X
        A, C, Q, R = (self.matrix(name, k) for name in "ACQR")
        unit = np.eye(self.plant.p)[:, :, None]
        R = Columns(np.where(seen * seen.swapaxes(0, 1) > 0, R.X, unit))
        C = Columns(C.X * seen)
        return self.gain(As=A, C=C, Q=Q, R=R, Gamma=self.none, Omega=Omega)

    def estimate(self, k: int, K: Columns, x_minus: Columns) -> Columns:
        """Write the estimates of a row; what is predicted for the next one."""
        given = {name: self.matrix(name, k) for name in "ABCE"}
        given |= dict(J=self.none, K=K.of(self.group), x_minus=x_minus)
        y, u = Columns.many(self.y[:, k]), Columns.many(self.u[:, k])
        found = self.step(**given, y=y, u=u)
        self.out.x[self.members, k] = found["x"].X[:, 0, : len(self.members)].T
        return found["x_minus_next"]

    def keep(self, k: int, found: dict[str, Columns]) -> None:
        """Write what is kept of a row for each record."""
        if self.out.K is not None:
            self.out.P[self.members, k] = self.each(found["Sigma"])
            self.out.K[self.members, k] = self.each(found["K"])
        elif k == self.seen.shape[1] - 1:
            self.out.P[self.members] = self.each(found["Sigma"])

    def each(self, X: Columns) -> Matrix:
        """What groups have, for each record (M, rows, cols)."""
        return X.of(self.group).X[:, :, : len(self.members)].transpose(2, 0, 1)

    def finish(self, variances: Matrix, good: Vector) -> None:
        """Write variances, and refuse records whose states have grown too far."""
        self.out.variances[self.first] = variances
        self.out.back[self.members] = self.members - self.first[self.group]
        least, most = variances.min(axis=1), variances.max(axis=1)
        self.records.grown(self.first[good], variances, good, least, most)
