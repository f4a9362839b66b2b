"""The library beside exact arithmetic, problem by problem, and one table of it.

What is judged of a problem: filter, smoother and likelihood of a record that fits the
model exactly; some with readings that come late, or with an unknown start; and all of
it again with one reading damaged, which is refused if and only if that contradicts.

A number is judged beside what it was made of: estimates and predictions of the whole
record in its own state (TOL), and of its own row (ROW).  To that comes what the exact
numbers move where every instant gets noise of SHAKE of the deviations there: rounding
moves them too, in any filter that rounds.  A likelihood may move by that, and by what
rounding of what an innovation was made of is, beside its deviation.
"""

import time
from collections import defaultdict
from contextlib import nullcontext
from dataclasses import replace
from multiprocessing import get_context
from typing import NamedTuple

import numpy as np
from exact_filter import rational

from . import adapter, oracle, problems

TOL = 1e-9
ROW = 1e-3
SHAKE = 1e-10
FELT = 1e-4  # an estimate may move by this part of the deviations by which P moves
TOLD = 1e-5  # a contradiction by less, beside what is met, need not be told
SHOWN, WIDTH = 40, 200  # lines on what is bad, and their length
EPS = 1e-14  # rounding of what an innovation is made of
PATHS = "filter", "smoother", "likelihood", "late readings", "start unknown"
COLUMNS = (
    "calls", "wrong", "falsely refused", "contradictions", "missed", "misnamed",
    "lost digits",
)  # fmt: skip


BAD = "wrong", "missed", "falsely refused", "misnamed"  # the worst first


class Made(NamedTuple):
    """What numbers of each row are made of: deviations and magnitudes (N, n)."""

    std: np.ndarray
    mean: np.ndarray


class Verdict(NamedTuple):
    path: str
    columns: tuple  # those of COLUMNS in which it counts
    error: float = 0.0  # in units in which TOL is allowed
    words: str = ""


def made(p, x, P):
    """What filtered x and P were made of: themselves, and one prediction."""
    N = len(x)
    std = np.sqrt(np.maximum(np.einsum("kii->ki", P), 0))
    start = np.sqrt((p.start**2).sum(axis=1).astype(float))
    last_x, last_std = np.abs(p.x0.astype(float)), start
    both = []
    for k in range(N):
        W = np.sqrt((p.W[k] ** 2).sum(axis=1).astype(float))
        A, B, u = (np.abs(X.astype(float)) for X in (p.A[k], p.B[k], p.u[k]))
        moved = k or not p.prior
        ahead = A @ last_std + W if moved else start
        mean = A @ last_x + B @ u if moved else last_x
        ahead = np.maximum(ahead, std[k])
        both.append((ahead, np.maximum(mean, np.abs(x[k])) + ahead))
        last_x, last_std = np.abs(x[k]), std[k]
    std, mean = np.array(both).swapaxes(0, 1)
    unit = p.unit.astype(float)
    return Made(np.where(std > 0, std, 0), np.where(mean > 0, mean, unit))


def off(p, found, wanted, of):
    """How far (x, P) are off: beside the record's numbers, and beside the row's."""
    x, P = (np.abs(a - b) for a, b in zip(found, wanted))
    result = []
    for std, mean in (of.std.max(axis=0)[None], of.mean.max(axis=0)[None]), of:
        std = np.where(std > 0, std, p.unit.astype(float))
        of_P = std[:, :, None] * std[:, None]
        result.append((np.max(x / mean, initial=0), np.max(P / of_P, initial=0)))
    return np.array(result)


class Case:
    """A problem, and its exact answers as far as they are asked for."""

    def __init__(self, p):
        self.p, self.answer = p, oracle.answer(p)
        self.filtered, self.first = self.answer[:2], self.answer.first
        if p.accurate:
            *self.filtered, self.first = oracle.accurate(p)
        self.made = made(p, *self.filtered)

    def shaken(self):
        """The same problem with a little noise at every instant."""
        p, std = self.p, np.where(self.made.std > 0, self.made.std, self.made.mean)
        return p.shaken(SHAKE * np.vstack([std[:1], std]))

    def smooth(self, found=None):
        """Exact smoothed x, P, with accurate outputs met."""
        p, found = self.p, self.answer if found is None else found
        x, P = found.smooth_x.copy(), found.smooth_P.copy()
        for k, row in enumerate(p.y):
            seen = [j for j in p.accurate if row[j] is not None]
            if not seen:
                continue
            C, H = p.C[k + 1][seen].astype(float), p.H[k + 1][seen].astype(float)
            known = (row[seen] - p.E[k + 1][seen] @ p.u[k + 1]).astype(float)
            Gamma = np.linalg.pinv(C)
            x[k] += Gamma @ (known - C @ x[k])
            P[k] += Gamma @ (H @ H.T - C @ P[k] @ C.T) @ Gamma.T
        return x, P

    def moments(self, path, found):
        """The verdict on estimates and covariances."""
        p = self.p
        smooth = path == "smoother"
        wanted = self.smooth() if smooth else self.filtered
        by = off(p, found, wanted, self.made)
        allowed = np.array([[TOL, TOL], [ROW, ROW]])
        if not (by < allowed).all():
            shaken = self.shaken()
            if p.accurate and not smooth:
                moved = oracle.accurate(shaken)[:2]
            else:
                moved = oracle.answer(shaken, self.answer.determined)
                moved = self.smooth(moved) if smooth else moved[:2]
            slack = off(p, moved, wanted, self.made)[:, 1]
            allowed[:, 1] += slack
            allowed[:, 0] += slack + FELT * slack**0.5
        std = np.where(self.made.std > 0, self.made.std, p.unit.astype(float))
        least = np.linalg.eigvalsh(found[1] / (std[:, :, None] * std[:, None])).min()
        error = max(TOL * (by / allowed).max(), -1e3 * least if least < 0 else 0)
        return self.verdict(path, error, f"off by {by.round(14).tolist()}")

    def density(self, path, value):
        """The verdict on a likelihood."""
        p, found = self.p, self.answer
        if path == "start unknown":
            found = oracle.answer(unknown(p), start=True)
            wanted = oracle.integrated(found)
            if wanted is None:
                return Verdict(path, ("calls", "wrong"), 1.0, "is not determined")
        else:
            wanted = oracle.likelihood(found)
        shaken = self.shaken()
        shaken = unknown(shaken) if path == "start unknown" else shaken
        shaken = oracle.answer(shaken, found.determined, path == "start unknown")
        moved = {(k, j): s for k, j, s, _ in shaken.terms}
        slack = 0.0
        for k, j, s, nu in found.terms:
            sigma, more = float(s) ** 0.5, max(float(moved[k, j] / s - 1), 0)
            C = np.abs(p.C[k + 1][j].astype(float))
            met = abs(float(p.y[k, j])) + C @ self.made.mean[k]
            mean = EPS * met / sigma + FELT * more**0.5
            std = EPS * (C @ self.made.std[k] / sigma) ** 2 + more
            z = abs(float(nu)) / sigma
            slack += mean * (2 * z + mean) + std * (1 + z * z)
        size = TOL * (1 + wanted[1])
        error = TOL * abs(value - wanted[0]) / (size + slack)
        return self.verdict(path, error, f"{value!r} in place of {wanted[0]!r}")

    def verdict(self, path, error, words):
        wrong = not error <= TOL
        columns = ("calls", "wrong") if wrong else ("calls",)
        return Verdict(path, columns, float(error), words * wrong)

    def refused(self, path, error):
        """The verdict on a refusal."""
        why, words = adapter.reason(error), str(error)
        if why == "undetermined" and path == "start unknown":
            found = oracle.answer(unknown(self.p), start=True)
            if oracle.integrated(found) is None:
                return Verdict(path, ("calls",))
        if why == "digits" and "long gap" in self.p.kinds:
            return Verdict(path, ("calls", "lost digits"))
        if why != "contradiction" or self.first is None:
            return Verdict(path, ("calls", "falsely refused"), 0.0, words)
        instant, names = adapter.where(error)
        columns = ("calls", "contradictions")
        right = instant == self.first[0] + 1 and names
        if right and not self.p.accurate:
            y = self.p.y[:instant].copy()
            y[-1] = [v if j in names else None for j, v in enumerate(y[-1])]
            right = oracle.answer(replace(self.p, y=y)).first is not None
        return Verdict(path, columns + ("misnamed",) * (not right), 0.0, words)

    def tells(self):
        """Whether a contradiction is large enough to be told."""
        k, j, gap = self.first
        p = self.p
        C = np.abs(p.C[k + 1][j].astype(float))
        met = abs(float(p.y[k, j])) + C @ self.made.mean[k]
        if gap < TOLD * met:
            return False
        moved = oracle.answer(self.shaken(), self.answer.determined)
        slack = off(p, moved[:2], self.answer[:2], self.made)[:, 1].max()
        return gap > 10 * (slack + FELT * slack**0.5) * met


def unknown(p):
    """The problem whose start has variance 1 and an unknown mean, at the first row."""
    start = rational(np.eye(len(p.x0)))
    return replace(p, start=start, x0=0 * p.x0, prior=True)


def judged(p, seed):
    """All verdicts on a problem."""
    if p.arrival is not None:
        late, p = p, replace(p, arrival=None)
        yield from paths(Case(late), ["late readings"])
    more = ["start unknown"] if p.unknown else []
    yield from paths(Case(p), ["filter", "smoother", "likelihood", *more])
    damaged = Case(p.damaged(np.random.default_rng([33, seed])))
    if damaged.first is None:
        yield from paths(damaged, ["filter"])
    elif damaged.tells():
        yield from paths(damaged, ["filter", "smoother", "likelihood"][:
                         1 if p.accurate else None])  # fmt: skip


def paths(case, names):
    """The verdict on each call that is named."""
    p = case.p
    matrices, given = p.matrices()
    plant = adapter.plant(*matrices, **given)
    data = p.record, p.u[1:].astype(float), p.u[0].astype(float)
    for path in names:
        try:
            if path == "smoother":
                found = adapter.smoothed(plant, *data, m1=p.accurate)
            elif path == "likelihood":
                found = adapter.log_likelihood(plant, *data)
            elif path == "start unknown":
                given = {k: given[k] for k in "QRS"}
                found = adapter.log_likelihood(adapter.plant(*matrices, **given), *data)
            else:
                found = adapter.filtered(plant, *data, p.accurate, p.arrival)
        except adapter.Refused as error:
            yield case.refused(path, error)
            continue
        if case.first is not None:
            yield Verdict(path, ("calls", "contradictions", "missed"), 0.0, "missed")
        elif path in ("likelihood", "start unknown"):
            yield case.density(path, found)
        else:
            yield case.moments(path, found)


def one(seed):
    """Seed, kinds, verdicts; a call that ends in any other way is wrong."""
    p = problems.problem(seed)
    try:
        with np.errstate(all="ignore"):
            return seed, p.kinds, list(judged(p, seed))
    except Exception as error:
        words = f"{type(error).__name__}: {error}"
        return seed, p.kinds, [Verdict("filter", ("calls", "wrong"), 1.0, words)]


def table(results):
    """Lines: kinds and paths beside what was counted; then what is to be looked at."""
    counts, worst, bad = defaultdict(lambda: defaultdict(int)), defaultdict(float), []
    for seed, kinds, verdicts in results:
        for row in ("all", *kinds):
            counts[row]["problems"] += 1
        for one in verdicts:
            for row in ("all", one.path, *kinds):
                for column in one.columns:
                    counts[row][column] += 1
                worst[row] = max(worst[row], one.error)
            if one.columns[-1] in BAD:
                words = f"--seed {seed}  {one.columns[-1]}: {one.path}: {one.words}"
                bad.append((BAD.index(one.columns[-1]), seed, words[:WIDTH]))
    rows = sorted(set(counts) - {"all", *PATHS})
    head = ("problems", *COLUMNS)
    lines = [f"{'':24}" + "".join(f"{c:>16}" for c in (*head, "worst error"))]
    for row in (*rows, *PATHS, "all"):
        cells = "".join(f"{counts[row][c] or '':>16}" for c in head)
        lines.append(f"{row:24}{cells}{worst[row]:>16.1e}")
    return lines, [words for *_, words in sorted(bad)]


def main(count, first=0, jobs=2, minutes=None):
    """Print the table of `count` problems from the seed `first`; 1 if any is bad.

    After so many minutes it is the table of those that are done.
    """
    start, seeds = time.monotonic(), range(first, first + count)
    results = []
    with get_context("spawn").Pool(jobs) if jobs > 1 else nullcontext() as pool:
        done = pool.imap_unordered(one, seeds, 20) if pool else map(one, seeds)
        for result in done:
            results.append(result)
            if minutes and time.monotonic() - start > 60 * minutes:
                break
    lines, bad = table(sorted(results, key=lambda r: r[0]))
    print(*lines, *bad[:SHOWN], sep="\n")
    more = len(bad) - SHOWN
    print(f"{len(results)} of {count} problems", f"; {more} lines more" * (more > 0))
    return int(bool(bad))
