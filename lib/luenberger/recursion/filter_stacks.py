"""A plant's settings as stacks of matrices, and the compiled filter that reads them.

Every row of a record has an index into stacks of A, Q, C, ..., so a constant plant,
a plant that changes and outputs that did not arrive are one case.  Matrices of
outputs that did not arrive are padded (papers/leondes_novak/derivation/places.py) so
that every row has all p outputs.
"""

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np

from .. import kernels
from ..errors import DesignError
from ..kernels.program import Factor
from ..numeric import Matrices, Matrix, Vector
from ..numeric.factors import SAFE
from ..numeric.linalg import nonsingular
from ..papers.leondes_novak.derivation import filter_step, padded
from .alike import alike, arrived, every, patterns
from .pushes import change, pushes
from .root_step import Spread
from .settings import PATTERNS, Setting, Settings
from .state import History, State, flat

BEFORE = {"A": "A", "As": "As", "Q": "Qs", "B": "B", "J": "J"}
NOW = {"C": "C", "R": "R", "E": "E", "Gamma": "Gamma"}
FIELDS = BEFORE | NOW
FILTER = kernels.Recursion(
    filter_step,
    carried=(("Sigma_next", "Sigma"), ("x_next", "x"), ("rho_next", "rho")),
    rows=(("y", "y", 0), ("u", "u", 0), ("u_next", "u", 1)),
    written=(
        ("xs", "x_next", "vector"),
        ("variances", "Sigma_next", "diagonal"),
        ("covariances", "Sigma_next", "matrix"),
        ("gains", "K", "matrix"),
    ),
    before=tuple(BEFORE),
    symmetric=("Q", "R", "Sigma"),
    definite=(Factor("Sigma_next", SAFE, "Omega", known=True),),
    same=(("As", "A", "J"),),
)


# the index of each row, that of the row before, whether R is definite, the stacks
Indexed = tuple[Vector, Vector, Vector, Matrices]


class Stacks:
    """From which matrices compiled code runs, for any record of a plant.

    `full` is the setting with every output.
    """

    def __init__(self, settings: Settings, full: Setting) -> None:
        self.settings, self.plant, self.full = settings, settings.plant, full
        plant = self.plant
        self.varying = plant.steps is not None
        self.cross = plant.S is not None and bool(plant.S.any())
        self.accurate = len(settings.accurate) > 0
        self.table: dict[bytes, int] = {}
        self.padded: list[dict[str, Any]] = []
        self.tables: dict[frozenset[str], tuple[tuple[str, tuple], ...]] = {}

    def block(self, state: State, y: Matrix, u: Matrix) -> "Block":
        """The next rows of a record, which begin at `state`, ready to be run."""
        given, seen, changing = self.given(state, y, u)
        known = self.entries(changing)
        recursion = FILTER.strict(self.settings.noise_free)
        kernel = kernels.over_record(recursion, self.sizes, known, changing)
        return Block(self.settings, kernel, given, seen)

    @property
    def sizes(self) -> tuple[tuple[str, int], ...]:
        return tuple((k, getattr(self.plant, k)) for k in ("m", "n", "p"))

    def entries(self, changing: frozenset[str]) -> tuple[tuple[str, tuple], ...]:
        """What is known of the entries of each matrix; see `known`."""
        if changing not in self.tables:
            known = ((name, self.known(name, name in changing)) for name in FIELDS)
            self.tables[changing] = tuple(known)
        return self.tables[changing]

    def given(
        self, state: State, y: Matrix, u: Matrix
    ) -> tuple[Matrices, Matrix, frozenset[str]]:
        """What compiled code reads of the next rows, which begin at `state`.

        Beside it, which outputs arrived, and the matrices that change.
        """
        seen = arrived(y)
        complete = self.complete(state, seen)
        if self.varying:
            now, before, good, stacks = self.instants(state, seen)
        elif complete:
            now = before = np.zeros(1, dtype=np.int64)  # which nothing reads
            good, stacks = np.ones(1, dtype=bool), self.constant()
        else:
            now, before, good, stacks = self.patterns(state, seen)
        given = {k: flat(kernels.plain_array(X)) for k, X in stacks.items()}
        if not complete:
            y = np.where(seen, y, 0.0)
        y, empty = kernels.plain_array(y), np.empty((len(y) + 1, 0))
        u = np.concatenate([state.u[None], u]) if self.plant.m else empty
        given |= dict(now=now, before=before, good=good, y=y, u=u)
        return given, seen, self.changing(complete)

    def complete(self, state: State, seen: Matrix) -> bool:
        """Whether every output arrived, as far as rows from `state` on hang on it.

        With S, what carries over from the row before hangs on what it had.
        """
        return every(seen) and (not self.cross or bool(state.seen.all()))

    def changing(self, complete: bool) -> frozenset[str]:
        """Names of the matrices that have an index."""
        if self.varying:
            return frozenset(FIELDS)
        if complete:
            return frozenset()
        return frozenset(NOW) | frozenset(("A", "As", "Q", "J") if self.cross else ())

    def known(self, name: str, changing: bool) -> tuple:
        """Entries that are 0, or 1, in every row of every record."""
        full = getattr(self.full, FIELDS[name])
        if not changing:
            return kernels.entries_known(full == 0, full == 1)
        if name == "Gamma":
            zero = np.full(full.shape, not self.accurate)
        elif name == "J" or self.cross and name in ("A", "As", "Q"):
            zero = np.full(full.shape, not self.cross)
        else:
            whole = getattr(self.plant, "A" if name == "As" else name)
            zero = ~(whole.any(axis=0) if whole.ndim == 3 else whole != 0)
        return kernels.entries_known(zero, np.zeros(full.shape, dtype=bool))

    def constant(self) -> Matrices:
        """A constant plant with every output: stacks of one."""
        return {name: getattr(self.full, f)[None] for name, f in FIELDS.items()}

    def patterns(self, state: State, seen: Matrix) -> Indexed:
        """A constant plant with outputs missing: an index for each pattern."""
        if len(self.padded) >= PATTERNS:
            self.table, self.padded = {}, []
        first, now = patterns(seen)
        index = np.array([self.pattern(seen[k]) for k in first], dtype=np.int64)
        now = index[now]
        before = np.concatenate([[self.pattern(state.seen)], now[:-1]])
        stacks = self.constant()
        for name in self.changing(False):
            stacks[name] = np.stack([one[name] for one in self.padded])
        good = np.array([one["good"] for one in self.padded])[now]
        return now, before, good, stacks

    def pattern(self, seen: Vector) -> int:
        """The index of the outputs `seen`, whose matrices are kept from now on."""
        key = seen.tobytes()
        if key not in self.table:
            self.table[key] = len(self.padded)
            setting = self.settings.at(0, None if seen.all() else seen)
            self.padded.append(self.pad(setting, seen))
        return self.table[key]

    def pad(self, setting: Setting, seen: Vector) -> dict[str, Any]:
        """The matrices of one setting at full size."""
        out = {name: getattr(setting, field) for name, field in FIELDS.items()}
        if not seen.all():
            seen_only = {f"{name}_seen": out[name] for name in "C E R Gamma J".split()}
            seen_only["Pick"] = np.eye(self.plant.p)[seen]
            out |= kernels.run(padded, seen_only)
        return out | {"good": not setting.blind.size}

    def instants(self, state: State, seen: Matrix) -> Indexed:
        """A plant that changes: index k + 1 for row k, and 0 for the row before."""
        N, first = len(seen), state.instant + 1
        stacks = {
            name: np.zeros((N + 1, *X.shape[1:])) for name, X in self.constant().items()
        }
        good = np.ones(N, dtype=bool)
        if not self.cross:
            self.fill(stacks, slice(first - self.settings.origin, None))
            good[:] = nonsingular(stacks["R"][1:])
            for rows in alike(seen):
                some = seen[rows[0]]
                if not some.all():
                    good[rows] = self.fill_missing(stacks, first, rows, some)
                elif change(self.settings):
                    C = stacks["C"][rows + 1]
                    pushed = pushes(self.settings, C, some, first + rows)
                    stacks["Gamma"][rows + 1] = pushed
        else:
            for k in range(N):
                setting = self.settings.at(first + k, seen[k])
                good[k] = self.place(stacks, k + 1, setting, seen[k])
        if state.setting is not None:
            self.place(stacks, 0, state.setting, state.seen)
        now = np.arange(1, N + 1)
        return now, now - 1, good, stacks

    def place(
        self, stacks: Matrices, index: int, setting: Setting, seen: Vector
    ) -> bool:
        """Put a setting at an index of all stacks; whether its R is definite."""
        one = self.pad(setting, seen)
        for name, stack in stacks.items():
            stack[index] = one[name]
        return one["good"]

    def fill(self, stacks: Matrices, here: slice) -> None:
        """Rows 1 and on from the plant's own matrices of the instants `here`."""
        for name, stack in stacks.items():
            whole = getattr(self.plant, {"As": "A"}.get(name, name), None)
            if whole is not None:
                stack[1:] = whole[here][: len(stack) - 1] if whole.ndim == 3 else whole
        stacks["Gamma"][1:] = self.full.Gamma

    def fill_missing(
        self, stacks: Matrices, first: int, rows: Vector, seen: Vector
    ) -> Vector:
        """The same of rows whose outputs `seen` arrived; whether their R is definite.

        Which outputs arrived decides all but C, E and R, and pushes where C changes.
        """
        one, here = self.settings.at(first + int(rows[0]), seen), rows + 1
        have = dict(Pick=np.eye(self.plant.p)[seen], Gamma_seen=one.Gamma, J_seen=one.J)
        have |= {f"{name}_seen": stacks[name][here][:, seen] for name in "CER"}
        have["R_seen"] = have["R_seen"][:, :, seen]
        if change(self.settings):
            C = have["C_seen"]
            have["Gamma_seen"] = pushes(self.settings, C, seen, first + rows)
        for name, X in kernels.run(padded, have, stacks=True).items():
            if name in stacks:
                stacks[name][here] = X
        return np.asarray(nonsingular(have["R_seen"]))


def stacks_of(settings: Settings) -> Stacks | None:
    """The stacks of a plant; None where compiled code can do no row of any record."""
    try:
        full = settings.at(settings.origin + 1)  # that of instant 0 is not used
    except DesignError:  # perhaps the outputs never arrive together
        return None
    if settings.plant.p == 0 or (settings.steps is None and full.blind.size):
        return None
    return Stacks(settings, full)


@dataclass(frozen=True, eq=False)
class Block:
    """Rows of a record that compiled code can run, with all it needs to know of them.

    Attributes
    ----------
    settings : Settings
    kernel : callable
        The loop over rows; see `kernels.over_record`.
    given : dict of str to ndarray
        Stacks of matrices, the index of each row, y, and u from the row before on.
    seen : (N, p) ndarray of bool
        Which outputs arrived.
    """

    settings: Settings
    kernel: Callable
    given: Matrices
    seen: np.ndarray

    def ready(self, state: State) -> bool:
        """Whether compiled code can go on from a state, and it is its turn."""
        return state.ready

    def run(self, state: State, k: int, out: History, stop: int) -> tuple[State, int]:
        """From `state` before row k on: the state reached, and the first row not done.

        That is `stop`, unless compiled code gives up before.

        Rows that were done are written to `out`.
        """
        rho = np.zeros(self.seen.shape[1])
        rho[state.seen] = state.rho[:, 0]
        x, Sigma = state.x.flatten(), state.Sigma.flatten()
        done = self.kernel(
            **self.given, Sigma=Sigma, x=x, rho=rho, start=k, stop=stop,
            keep=True, **out.arrays,
        )  # fmt: skip
        if done == k:
            return state, k
        i, seen = state.instant + done - k, self.seen[done - 1]
        now = self.settings.at(i, None if seen.all() else seen)
        spread = Spread(Sigma.reshape(state.Sigma.shape))
        u, rho = self.given["u"][done], rho[seen][:, None]
        return State(i, x[:, None], spread, None, u, seen, rho, now), done
