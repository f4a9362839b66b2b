"""The recursion in scalars over many records: lanes of one loop, which become vectors.

A lane does what its record by itself does, operation by operation.  So it finds the
same bits, whatever is in the lanes beside it.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import cache
from itertools import chain

from ..kernels.jit import jitted
from .passes import CLASH
from .scalars import Entry, Language, Row, Sizes, names, written

WIDE = 16  # records side by side
# a choice as a call: numba needs a third of the time where there are no branches
PICK = Language("pick({b} > {c}, {a}, {d})", "abs({})")
HEAD = """\
import numpy as np
from numba.extending import register_jitable


@register_jitable
def pick(first, a, b):
    return a if first else b


def run(y, drive, at, maps, told, state, xs, variances, K, pivot, clash):
    B, G, C, R = maps.B, maps.G, maps.C, maps.r
    Cs, Rs, mix = told
    z, V, D = state.z, state.V, state.D
    own = 1 if len(drive) > 1 else 0
"""


@cache
def over(size: Sizes, *ways: bool) -> Callable:
    """The function of `text`, compiled."""
    return jitted(text(size, *ways))


class Lanes:
    """The text, line by line, and the places of names in its lanes."""

    def __init__(self, *groups: list[str]) -> None:
        self.room = {one: k for k, one in enumerate(chain(*groups))}
        self.lines: list[str] = []

    def put(self, depth: int, *lines: str) -> None:
        self.lines += ["    " * depth + line for line in lines]

    def place(self, name: str) -> str:
        return f"c[{self.room[name] * WIDE} + l]"

    def each(self, depth: int, lines: list[str], some: bool = False) -> None:
        """A loop over all lanes, or over `some` that have records."""
        if lines:
            self.put(depth, f"for l in range({'wide' if some else WIDE}):")
            self.put(depth + 1, *lines)

    def get(self, *groups: list[str]) -> list[str]:
        return [f"{one} = {self.place(one)}" for one in chain(*groups)]

    def keep(self, found: list[tuple[str, str]]) -> list[str]:
        return [f"{self.place(one)} = {said}" for one, said in found]


class Told:
    """What a reading is combined with: statements that load it, and that pick it.

    The row of output j hangs on which of those before it arrived, of which there are
    2^j sets; a set is a number with a bit for each output, the first one highest.
    """

    def __init__(self, row: Row) -> None:
        p = row.size.p
        self.loads: list[str] = []
        self.picks: list[str] = []
        for j in reversed(range(p)):  # readings are combined as they came
            find = {one: "Cs" + X[1:] for one, X in row.reads("C").items()}
            find = {one: X for one, X in find.items() if one.startswith(f"C_{j}_")}
            find[f"r_{j}"] = f"Rs[{{}}, {j}]"
            find |= {f"L_{i}": f"mix[{{}}, {j}, {i}]" for i in range(j)}
            for one, X in find.items():
                self._pick(one, X, j, p)
            if j:
                some = (f"pick(y_{i} == y_{i}, y_{i}, 0.0) * L_{i}" for i in range(j))
                self.picks.append(f"y_{j} = {' + '.join(some)} + y_{j}")

    def _pick(self, one: str, X: str, j: int, p: int) -> None:
        """The entry `one` of output j, by what arrived of the outputs before."""
        found = []
        for v in range(1 << j):
            found.append(f"{one}_{j}_{v}")
            code = (2 * v + 1) << (p - 1 - j)
            self.loads.append(f"{found[-1]} = {X.format(f'k, {code}')}")
        for i in reversed(range(j)):  # the last bit is of the output just before
            pairs = zip(found[1::2], found[::2])
            found = [f"pick(y_{i} == y_{i}, {a}, {b})" for a, b in pairs]
        self.picks.append(f"{one} = {found[0]}")


def text(size: Sizes, alike: bool, mixed: bool = False) -> str:
    """`passes.forward` over lanes, without a tape.

    Each has gaps of its own; or they are `alike`: nothing is missing, and all have the
    gains K and pivots of one of them, none of which is 0, so that nothing contradicts.
    Where all readings are `noisy` nothing contradicts either, and `clash` is left.
    Where readings are `mixed`, a reading is combined with those before it that arrived:
    `told` has C, r and what combines them for each set of outputs.
    """
    row, n, p = Row(size), size.n, size.p
    sure = alike or size.noisy
    own = [f"z_{i}" for i in range(n)] if alike else row.own()
    met = [f"met_{i}" for i in range(0 if sure else n)]
    spread = [f"v_{i}" for i in range(0 if alike else n)]
    drive, read = [f"drive_{i}" for i in range(n)], [f"y_{j}" for j in range(p)]
    bad = [] if sure else ["bad"]
    to = Lanes(own, met, drive, read, spread, bad)
    state = {"z": "z[b + l, {}]", "D": "D[b + l, {}]", "V": "V[b + l, {}, {}]"}
    state = {one: state[one[0]].format(*one.split("_")[1:]) for one in own}
    ahead, behind = row.reads("B" if alike else "BG"), row.reads("C" if alike else "Cr")
    to.put(1, f"c = np.zeros({len(to.room) * WIDE})")
    to.put(1, *(f"{one} = {X.format(0)}" for one, X in (ahead | behind).items()))
    to.put(1, f"for b in range(0, len(y), {WIDE}):")
    to.put(2, f"wide = min({WIDE}, len(y) - b)", "s, k = -1, -1")
    to.each(2, to.keep([*state.items()]), some=True)
    sizes = [(one, f"abs({to.place(f'z_{i}')})") for i, one in enumerate(met)]
    to.each(2, to.keep([*sizes, *((one, "-1.0") for one in bad)]))
    to.put(2, "for t in range(y.shape[1]):")
    to.put(3, "if at[t] >= 0:")
    to.put(4, "if at[t] != s:")
    to.put(5, "s = at[t]", *(f"{one} = {X.format('s')}" for one, X in ahead.items()))
    acts = [f"drive[(b + l) * own, t, {i}]" for i in range(n)]
    to.each(4, to.keep([*zip(drive, acts)]), some=True)
    z, V, D, sizes_ = row.predict()
    found = [*names(z, V, D)[: len(own)], *zip(met, sizes_)]
    lines, said = _said(found, "p")
    to.each(4, to.get(own, met, drive) + lines + to.keep(said))
    told = Told(row) if mixed else None
    to.put(3, "if at[t + 1] != k:")
    to.put(4, "k = at[t + 1]")
    if told is None:
        to.put(4, *(f"{one} = {X.format('k')}" for one, X in behind.items()))
    else:
        to.put(4, *told.loads)
    for j in range(p if alike else 0):
        to.put(3, f"pivot_{j} = pivot[t, {j}]")
        to.put(3, *(f"K_{j}_{i} = K[t, {j}, {i}]" for i in range(n)))
    came = [(f"y_{j}", f"y[b + l, t, {j}]") for j in range(p)]
    to.each(3, to.keep(came), some=True)
    body = to.get(own, met, read, bad)
    body += [] if told is None else told.picks
    for j in range(p):
        body += _reading(row, j, len(own), alike, sure)
    lines, said = ([], []) if alike else _said([*zip(spread, row.spread())], "v")
    to.each(
        3, body + lines + to.keep([*said, *((one, one) for one in [*own, *met, *bad])])
    )
    results = [f"xs[b + l, t, {i}] = {to.place(f'z_{i}')}" for i in range(n)]
    results += [
        f"variances[b + l, t, {i}] = {to.place(v)}" for i, v in enumerate(spread)
    ]
    to.each(3, results, some=True)
    last = [f"{X} = {to.place(one)}" for one, X in state.items()]
    last += [f"clash[b + l] = int({to.place(one)})" for one in bad]
    to.each(2, last, some=True)
    return "\n".join([HEAD + to.lines[0], *to.lines[1:], ""])


def _said(
    found: list[tuple[str, Entry]], prefix: str
) -> tuple[list[str], list[tuple[str, str]]]:
    """Statements, and how each name is written behind them."""
    lines, shown = written([x for _, x in found], PICK, prefix)
    return [f"{one} = {said}" for one, said in lines], [
        (one, shown(x)) for one, x in found
    ]


def _reading(row: Row, j: int, kept: int, alike: bool, sure: bool) -> list[str]:
    """Take in the reading of output j, where it arrived."""
    z, V, D, met, _, pivot, nu, size = row.read(j, given=alike)
    found = names(z, V, D)[:kept]
    if not sure:
        found = names(z, V, D, met)
        kept = len(found)
        found += [("", pivot), ("", nu), ("", size)]
    lines, said = _said(found, f"r{j}_")
    if not sure:
        (_, pivot), (_, nu), (_, size) = said[kept:]
        clash = f"(bad < 0.0) & ({pivot} == 0.0) & (abs({nu}) > {CLASH!r} * {size})"
        lines.append(f"bad = pick({clash}, t * {row.size.p} + {j} + 0.0, bad)")
    arrived = "{1}" if alike else f"pick(y_{j} == y_{j}, {{1}}, {{0}})"
    moved = [(one, arrived.format(one, x)) for one, x in said[:kept] if x != one]
    if moved:
        left, right = (", ".join(side) for side in zip(*moved))
        lines.append(f"{left} = {right}")
    return lines
