"""A plant's settings as stacks of matrices, and the compiled filter that reads them.

Every row of a record has an index into stacks of A, Q, C, ..., so a constant plant,
a plant that changes and outputs that did not arrive are one case.  Matrices of
outputs that did not arrive are padded (papers/leondes_novak/derivation/one_pass.py) so
that every row has all p outputs.
"""

import numpy as np

from .. import kernels
from ..errors import DesignError
from ..numeric.linalg import nonsingular
from .settings import PATTERNS

BEFORE = {"A": "A", "As": "As", "Q": "Qs", "B": "B", "J": "J"}
NOW = {"C": "C", "R": "R", "E": "E", "Gamma": "Gamma"}
FIELDS = BEFORE | NOW


class Compiled:
    """What can be decided before the run: whether, and from which matrices."""

    def __init__(self, settings):
        self.settings, self.plant = settings, settings.plant
        plant = self.plant
        self.varying = plant.steps is not None
        self.cross = plant.S is not None and bool(plant.S.any())
        self.accurate = len(settings.accurate) > 0
        self.table, self.padded = {}, []
        try:
            self.full = settings.at(1)  # what it was at instant 0 is not used
        except DesignError:  # perhaps the outputs never arrive together
            self.full = None
        has_all = plant.p > 0 and self.full is not None
        self.applies = has_all and (self.varying or not self.full.blind.size)

    def rows(self, run, y, u):
        """The rows of a chunk, ready to be run; `run` is the pass before them."""
        seen = np.isnan(y)
        np.logical_not(seen, out=seen)  # the first touch of new memory costs most
        # with S, what carries over from the row before hangs on what it had
        complete = seen.all() and (not self.cross or run.seen.all())
        if self.varying:
            now, before, good, stacks = self.instants(run, seen)
        elif complete:
            now = before = np.zeros(1, dtype=np.int64)  # which nothing reads
            good, stacks = np.ones(1, dtype=bool), self.constant()
        else:
            now, before, good, stacks = self.patterns(run, seen)
        changing = self.changing(complete)
        known = tuple((name, self.known(name, name in changing)) for name in FIELDS)
        plant = self.plant
        kernel = kernels.over_record(
            "filter_recursion",
            (("m", plant.m), ("n", plant.n), ("p", plant.p)),
            known,
            changing,
        )
        u = np.concatenate([run.u[None], u]) if plant.m else np.empty((len(y) + 1, 0))
        return Rows(kernel, now, before, good, stacks, y, seen, u)

    def changing(self, complete):
        """Names of the matrices that have an index."""
        if self.varying:
            return frozenset(FIELDS)
        if complete:
            return frozenset()
        return frozenset(NOW) | frozenset(("A", "As", "Q", "J") if self.cross else ())

    def known(self, name, changing):
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

    def constant(self):
        return {name: getattr(self.full, f)[None] for name, f in FIELDS.items()}

    def patterns(self, run, seen):
        """A constant plant with outputs missing: an index for each pattern."""
        if len(self.padded) >= PATTERNS:
            self.table, self.padded = {}, []
        bits = np.packbits(seen, axis=1)
        bits = bits.view(f"S{bits.shape[1]}")[:, 0]
        _, first, now = np.unique(bits, return_index=True, return_inverse=True)
        index = np.array([self.pattern(seen[k]) for k in first], dtype=np.int64)
        now = index[now]
        before = np.concatenate([[self.pattern(run.seen)], now[:-1]])
        stacks = self.constant()
        for name in self.changing(False):
            stacks[name] = np.stack([one[name] for one in self.padded])
        good = np.array([one["good"] for one in self.padded])[now]
        return now, before, good, stacks

    def pattern(self, seen):
        key = seen.tobytes()
        if key not in self.table:
            self.table[key] = len(self.padded)
            setting = self.settings.at(0, None if seen.all() else seen)
            self.padded.append(self.pad(setting, seen))
        return self.table[key]

    def pad(self, setting, seen):
        """The matrices of one setting at full size."""
        out = {name: getattr(setting, field) for name, field in FIELDS.items()}
        if not seen.all():
            seen_only = {f"{name}_seen": out[name] for name in "C E R Gamma J".split()}
            out |= kernels.padded()(Pick=np.eye(self.plant.p)[seen], **seen_only)
        return out | {"good": not setting.blind.size}

    def instants(self, run, seen):
        """A plant that changes: index k + 1 for row k, and 0 for the row before."""
        N, plant = len(seen), self.plant
        stacks = {}
        here = slice(run.i + 1, run.i + 1 + N)
        easy = not self.cross and (not self.accurate or plant.C.ndim == 2)
        for name in FIELDS:
            whole = getattr(plant, {"As": "A"}.get(name, name), None)
            shape = self.constant()[name].shape[1:]
            stacks[name] = np.zeros((N + 1, *shape))
            if easy and whole is not None:
                stacks[name][1:] = whole[here] if whole.ndim == 3 else whole
        good = np.ones(N, dtype=bool)
        if easy:
            stacks["Gamma"][1:] = self.full.Gamma
            good[:] = nonsingular(stacks["R"][1:])
        for k in range(N) if not easy else np.flatnonzero(~seen.all(axis=1)):
            setting = self.settings.at(run.i + 1 + k, seen[k])
            one = self.pad(setting, seen[k])
            good[k] = one.pop("good")
            for name, value in one.items():
                stacks[name][k + 1] = value
        if run.before is not None:
            one = self.pad(run.before[0], run.seen)
            for name in FIELDS:
                stacks[name][0] = one[name]
        now = np.arange(1, N + 1)
        return now, now - 1, good, stacks


class Rows:
    """A chunk of a record on its way through the compiled filter."""

    def __init__(self, kernel, now, before, good, stacks, y, seen, u):
        self.kernel, self.seen = kernel, seen
        given = {k: _flat(np.array(X, order="C")) for k, X in stacks.items()}
        if not seen.all():
            y = np.where(seen, y, 0.0)
        y = kernels.plain_array(y)
        self.given = given | dict(now=now, before=before, good=good, y=y, u=u)

    def run(self, run, k, x, variances, P, K):
        """Rows k on, into the arrays; the first row that was not done."""
        rho = np.zeros(self.seen.shape[1])
        rho[run.seen] = run.before[1][:, 0]
        state = dict(Sigma=run.Sigma.flatten(), x=run.x.flatten(), rho=rho)
        done = self.kernel(
            **self.given,
            **state,
            start=k,
            stop=len(self.seen),
            keep=len(P) > 0,
            xs=x,
            variances=variances,
            covariances=_flat(P),
            gains=_flat(K),
        )
        if done > k:
            seen = self.seen[done - 1]
            run.resume(done - k, state, self.given["u"][done], seen)
        return done


def _flat(stack):
    """(N, rows, cols) as (N, rows * cols), the same memory."""
    return stack.reshape(len(stack), stack.shape[1] * stack.shape[2])
