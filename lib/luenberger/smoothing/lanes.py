"""Records that are smoothed in lanes of compiled code, forward and back.

What the way back needs of the filter's pass stays in lanes.  A record with gaps of its
own has its covariances.  Records with the same gaps have those of the first of them,
and their estimates go forward and back with its gains.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from .. import kernels
from ..fleets.fleet import Fleet
from ..fleets.given_gain import GIVEN
from ..fleets.own_gain import MANY, NAMES, OWN, does
from ..fleets.records import Records
from ..fleets.whole import Whole
from ..kernels.panel_copies import LANES
from ..kernels.panels import Panels, fits, in_panels
from ..numeric import Matrices, Matrix, Vector
from ..papers.leondes_novak.derivation import marked_and_kept
from ..plant import Plant
from ..recursion.growth import far
from .compiled import BACKWARD, entries, leading, stacks
from .finish import ways

NEAR = 1 << 16  # numbers that are kept near a processor: half a megabyte
ROOM = 1 << 23  # numbers of one panel at most
ESTIMATES = (("kept_x", "x", "vector"), ("kept_innovation", "innovation", "vector"))
SPREADS = (("kept_Sigma", "Sigma", "matrix"), ("kept_K", "K", "matrix"))
SPREADS += (("kept_W", "Said", "matrix"),)
STAYS = tuple(name for name, *_ in ESTIMATES + SPREADS)
READ = (("x", "kept_x", 0), ("innovation", "kept_innovation", 0))
SMOOTHED = ("xs", "x_s", "vector")
FORWARD = replace(
    OWN,
    recursion=replace(
        OWN.recursion, stages=marked_and_kept, written=ESTIMATES + SPREADS
    ),
    stays=STAYS,
)
BACK = Panels(
    replace(
        BACKWARD,
        rows=(
            *READ, ("Sigma", "kept_Sigma", 0), ("K", "kept_K", 0), ("W", "kept_W", 0),
            ("K_next", "kept_K", 1), ("W_next", "kept_W", 1),
        ),
        written=(
            SMOOTHED, ("variances", "Sigma_s", "diagonal"),
            ("covariances", "Sigma_s", "matrix"),
        ),
        replaces=(),
    ),
    stays=STAYS,
)  # fmt: skip
GIVEN_FORWARD = replace(
    GIVEN, recursion=replace(GIVEN.recursion, written=ESTIMATES), stays=STAYS
)
GIVEN_BACK = Panels(
    replace(
        BACKWARD, carried=BACKWARD.carried[:1], rows=READ, written=(SMOOTHED,),
        symmetric=("Sigma", "W"), definite=(), bounds=(), replaces=(),
    ),
    stays=STAYS,
)  # fmt: skip


def lengths(n: int, p: int) -> dict[str, int]:
    """Entries of a row of each array that stays in lanes."""
    halves = (k * (k + 1) // 2 for k in (n, p))
    return dict(zip(STAYS, (n, p, next(halves), n * p, next(halves))))


def numbers(plant: Plant, rows: int) -> int:
    """How many numbers a panel keeps from the way forward."""
    return (rows + 1) * sum(lengths(plant.n, plant.p).values()) * LANES


def takes(fleet: Fleet) -> bool:
    """Whether lanes are for records of a fleet, and not each is for itself."""
    whole, plant, rows = fleet.whole, fleet.settings.plant, fleet.rows
    if whole is None or fleet.settings.noise_free or not rows or not plant.n:
        return False
    fit = does(whole) and all(fits(k, whole.stacks.sizes) for k in (FORWARD, BACK))
    return fit and numbers(plant, rows) <= ROOM


@dataclass(frozen=True, eq=False)
class Lanes:
    """Records of a plant that panels can smooth; see `of`."""

    records: Records
    whole: Whole

    @classmethod
    def of(cls, records: Records) -> Lanes | None:
        """The same, or None where each is smoothed by itself."""
        whole = records.fleet.whole
        return cls(records, whole) if whole and takes(records.fleet) else None

    def smooth(self, x: Matrix, std: Matrix, P: Matrix) -> Vector:
        """Smooth the records; return those in which digits are lost, not done.

        If all of them share the memory of std and P, nothing is missing in any.
        """
        group = self.records.groups(np.arange(len(x)))
        few = np.bincount(group, minlength=1)[group] < MANY
        few &= P.strides[0] > 0
        which, left = np.flatnonzero(few), []
        if len(which):
            M = len(x)
            found = x.reshape(M, -1), std.reshape(M, -1), P.reshape(M, -1)
            failed, _ = self.own(which, *found)
            std[which] = np.sqrt(np.maximum(std[which], 0))
            left.append(which[failed[which]])
        many = list(self.records.alike(np.flatnonzero(~few)))
        for k in range(0, len(many), LANES):
            left += self.together(many[k : k + LANES], x, std, P)
        return np.sort(np.concatenate([which[:0], *left]))

    def together(
        self, groups: list[Vector], x: Matrix, std: Matrix, P: Matrix
    ) -> list[Vector]:
        """Groups with the same gaps, as many as there are lanes; the same return.

        As the arithmetic is that of records by themselves, so are the bits.
        """
        first = np.array([members[0] for members in groups])
        G, (_, N, n), left = len(groups), x.shape, []
        xs, variances, covariances = (np.empty((G, N * k)) for k in (n, n, n * n))
        who = np.arange(G)
        failed, kept = self.own(who, xs, variances, covariances, first)
        for g, members in enumerate(groups):
            if failed[g]:
                left.append(members)
                continue
            places = members if P.strides[0] else members[:1]
            P[places] = covariances[g].reshape(N, n, n)
            std[places] = np.sqrt(np.maximum(variances[g], 0)).reshape(N, n)
            if len(members) == 1:
                x[members] = xs[g].reshape(N, n)
            else:
                self.given(members, self.lane(kept, g), x)
        return left

    def own(
        self, who: Vector, xs: Matrix, variances: Matrix, covariances: Matrix,
        records: Vector | None = None,
    ) -> tuple[Vector, Matrices]:  # fmt: skip
        """Rows `who` of what is found: which failed, and what the last ones kept.

        Row k is of the record k, or of ``records[k]``.
        """
        rows, M, (n, p) = self.records.y.shape[1], len(xs), self.sizes
        off, read = ~np.eye(p, dtype=bool), dict(self.records.read)
        if records is not None:
            read |= {k: read[k][records] for k in ("which_y", "which_u")}
        marks = ("Seen", kernels.entries_known(off, np.zeros_like(off)))
        changing = frozenset(NAMES) if self.whole.varying else frozenset()
        known = (*self.whole.known(**NAMES), marks)
        ahead = in_panels(FORWARD, self.whole.stacks.sizes, known, changing)
        moves = self.moves
        back = in_panels(BACK, self.whole.stacks.sizes, entries(moves), self.changing)
        failed, lost = np.zeros((2, M), dtype=bool)
        least, most, last = (np.zeros((M, k)) for k in (n, n, n * n))
        given = read | {to: self.whole.matrices[k] for to, k in NAMES.items()}
        given |= self.whole.first | dict(least=least, most=most, last=last)
        found = dict(xs=xs, variances=variances, covariances=covariances)
        found |= stacks(moves) | dict(
            lamda_next=np.zeros(n), Theta_next=np.zeros(n * n)
        )
        kept, size = self.kept(STAYS, len(who))
        for k in range(0, len(who), size):
            some = dict(who=who[k : k + size], rows=rows, **kept)
            ahead(**some, **given, failed=failed)
            back(**some, **found, failed=lost)
        failed |= lost
        for k in who[far(least[who], most[who]) & ~failed[who]].tolist():
            s = k if records is None else int(records[k])
            self.records.one(s, False)  # refused there if digits are lost
        return failed, kept

    def kept(self, names: tuple[str, ...], records: int) -> tuple[Matrices, int]:
        """Room for what stays in lanes, and for how many records."""
        long, rows = lengths(*self.sizes), self.whole.rows
        near = NEAR // numbers(self.whole.stacks.plant, rows)
        panels = max(min(near, -(-records // LANES)), 1)
        room = {k: np.zeros((panels * (rows + 1), long[k] * LANES)) for k in names}
        return room, panels * LANES

    def given(self, members: Vector, rows: Matrices, x: Matrix) -> None:
        """Write the estimates of records with these gains and covariances."""
        whole, (M, N, n) = self.whole, x.shape
        J, changing = self.records.told(int(members[0])), {"K"}
        if whole.varying:
            changing |= set("ABCE")
        sizes = whole.stacks.sizes
        known = whole.known(A="A", B="B", C="C", E="E", J="J")
        ahead = in_panels(GIVEN_FORWARD, sizes, known, frozenset(changing))
        spread = {"K", "W", "Sigma"}
        back = in_panels(GIVEN_BACK, sizes, entries(self.moves), self.changing | spread)
        given = self.records.read | {name: whole.matrices[name] for name in "ABCE"}
        given |= dict(J=J, K=rows["K"], x_minus=whole.first["x_minus"])
        found = stacks(self.moves) | {name: rows[name] for name in spread}
        found |= dict(xs=x.reshape(M, N * n), lamda_next=np.zeros(n))
        kept, size = self.kept(STAYS[:2], len(members))
        for k in range(0, len(members), size):
            some = dict(who=members[k : k + size], rows=N, **kept)
            ahead(**some, **given)
            back(**some, **found)

    def lane(self, kept: Matrices, g: int) -> Matrices:
        """Sigma, K and W of every row of one record, from what it kept."""
        rows, n, p = len(kept["kept_x"]), *self.sizes
        found = {k: X.reshape(rows, -1, LANES)[..., g] for k, X in kept.items()}
        whole = {"K": np.ascontiguousarray(found["kept_K"])}
        for name, size in (("Sigma", n), ("W", p)):
            at = np.zeros((size, size), dtype=int)
            i, j = np.triu_indices(size)
            at[i, j] = at[j, i] = np.arange(len(i))
            whole[name] = np.ascontiguousarray(found[f"kept_{name}"][:, at.ravel()])
        return whole

    @cached_property
    def moves(self) -> Matrices:
        """The matrices As, C and Seen, which lead a row on."""
        seen = np.ones(self.records.y.shape[1:], dtype=bool)
        return leading(ways(self.records.settings, 1, seen))

    @property
    def changing(self) -> frozenset[str]:
        """Which of them have one for each row."""
        return frozenset(name for name, X in self.moves.items() if X.ndim == 3)

    @property
    def sizes(self) -> tuple[int, int]:
        return self.whole.stacks.plant.n, self.whole.stacks.plant.p
