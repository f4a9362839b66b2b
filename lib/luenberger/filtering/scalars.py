"""The texts of `passes` for few states: a statement an entry, known zeros left out.

`predict`, `read` and `spread` run on names instead of numbers, and what they do is
written down.  The operations are those of the loops, in their order, so they find the
same bits; rows around them are compiled for one pattern of zeros and ones.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Sequence
from functools import cache, partial
from inspect import getsource
from typing import Any, NamedTuple

import numpy as np

from ..kernels.jit import jitted
from . import passes
from .compiling import installed
from .passes import CLASH, LOST, TINY, Maps

Entry = Any  # a Name, or a number that is known


class Name:
    """A number that is not known yet; what is done with it is written down."""

    def __init__(self, to: Statements, op: str, of: tuple[Entry, ...]) -> None:
        self.to, self.op, self.of = to, op, of

    def __add__(self, other: Entry) -> Entry:
        return self if _is(other, 0) else self.to.let("+", self, other)

    def __radd__(self, other: Entry) -> Entry:
        return self if _is(other, 0) else self.to.let("+", other, self)

    def __sub__(self, other: Entry) -> Entry:
        return self if _is(other, 0) else self.to.let("-", self, other)

    def __rsub__(self, other: Entry) -> Entry:
        return -self if _is(other, 0) else self.to.let("-", other, self)

    def __mul__(self, other: Entry) -> Entry:
        if _is(other, 0):
            return 0.0
        return self if _is(other, 1) else self.to.let("*", self, other)

    __rmul__ = __mul__

    def __neg__(self) -> Entry:
        return self.to.let("neg", self)

    def __abs__(self) -> Entry:
        return self.to.let("abs", self)


def _is(value: Entry, number: int) -> bool:
    return not isinstance(value, Name) and bool(value == number)


class Statements:
    """What was done with names, equal things once."""

    def __init__(self, tiny: float = TINY) -> None:
        self.known: dict[Any, Name] = {}
        self.tiny, self.positive = tiny, False

    def let(self, op: str, *of: Entry) -> Name:
        """The name of what an operation makes of others."""
        key = op, *(id(x) if isinstance(x, Name) else repr(x) for x in of)
        if key not in self.known:
            self.known[key] = Name(self, op, of)
        return self.known[key]

    def given(self, text: str) -> Name:
        """The name of what is there before."""
        return self.let("given", text)

    def clear(self, value: Entry, made: Entry) -> Entry:
        alone = isinstance(made, Name) and made.op == "abs" and made.of[0] is value
        if alone or not isinstance(value, Name):
            return value  # a single product is no rounding
        return self.let("clear", value, made, self.tiny)

    def over(self, a: Entry, b: Entry) -> Entry:
        return 0.0 if _is(a, 0) or _is(b, 0) else self._quotient("over", a, b)

    def part(self, a: Entry, b: Entry) -> Entry:
        return 1.0 if _is(b, 0) else self._quotient("part", a, b)

    def _quotient(self, op: str, a: Entry, b: Entry) -> Entry:
        if not isinstance(b, Name):
            return self.let("/", a, b) if isinstance(a, Name) else a / b
        return self.let("/" if self.positive else op, a, b)

    def does(self, text: passes.Text, *given: Any, **more: Any) -> Any:
        """What a text of `passes` does, with `more` names for other things."""
        names: dict[str, Any] = dict(clear=self.clear, over=self.over, part=self.part)
        return text.on(**names, TINY=self.tiny, **more)(*given)


class Language(NamedTuple):
    """How a choice and a size are written, and whether choices are calls."""

    choice: str
    size: str
    calls: bool = False


PYTHON = Language("{a} if {b} > {c} else {d}", "abs({})")
CALLS = PYTHON._replace(calls=True)  # a choice in the text itself takes long to compile
C99 = Language("{b} > {c} ? {a} : {d}", "fabs({})")
RANK = {"+": 1, "-": 1, "*": 2, "/": 2}
INLINE = (*RANK, "abs", "neg")  # where it is used once


def written(
    results: Iterable[Entry], language: Language = PYTHON, prefix: str = "t"
) -> tuple[list[tuple[str, str]], Callable[..., str]]:
    """Statements (name, text) that lead to results, and what names an entry in them."""
    order: list[Name] = []
    uses: Counter[int] = Counter()
    seen: set[int] = set()

    def visit(x: Entry) -> None:
        stack = [(x, False)]
        while stack:
            one, done = stack.pop()
            if not isinstance(one, Name):
                continue
            if done:
                order.append(one)
            elif id(one) not in seen:
                seen.add(id(one))
                stack.append((one, True))
                parts = one.of if one.op != "given" else ()
                for part in reversed(parts):
                    if isinstance(part, Name):
                        twice = one.op == "clear" and part is one.of[0]
                        twice |= one.op in ("over", "part") and part is one.of[1]
                        uses[id(part)] += 1 + twice
                        stack.append((part, False))

    for result in results:
        visit(result)
        if isinstance(result, Name):
            uses[id(result)] += 2  # it needs a name
    texts: dict[int, tuple[str, int]] = {}

    def shown(x: Entry, rank: int = 3) -> str:
        if not isinstance(x, Name):
            return repr(float(x))
        text, mine = texts[id(x)]
        return text if mine >= rank else f"({text})"

    lines: list[tuple[str, str]] = []
    for one in order:
        text, rank = _said(one, language, shown)
        inline = one.op == "given" or (uses[id(one)] < 2 and one.op in INLINE)
        if not inline:
            lines.append((f"{prefix}{len(lines)}", text))
            text, rank = lines[-1][0], 3
        texts[id(one)] = text, rank
    return lines, shown


def _said(one: Name, language: Language, shown: Callable[..., str]) -> tuple[str, int]:
    """An operation as text, and how tightly it binds."""
    of = one.of
    if one.op == "given":
        return of[0], 3
    if one.op in RANK:
        rank = RANK[one.op]  # a sum goes on from the left, in its order
        return f"{shown(of[0], rank)} {one.op} {shown(of[1], rank + 1)}", rank
    if one.op == "neg":
        return f"-{shown(of[0])}", 2
    if one.op == "abs":
        return language.size.format(shown(of[0], 0)), 3
    if language.calls:
        return f"{one.op}({', '.join(shown(x, 0) for x in of[:2])})", 3
    a, b = (shown(x) for x in of[:2])
    if one.op == "clear":
        size = language.size.format(a)
        return language.choice.format(a=a, b=size, c=f"{of[2]!r} * {b}", d="0.0"), 0
    other = "0.0" if one.op == "over" else "1.0"
    return language.choice.format(a=f"{a} / {b}", b=b, c="0.0", d=other), 0


class Sizes(NamedTuple):
    """What the statements of a row hang on.

    Attributes
    ----------
    n, p, g : int
        States, outputs, columns of G.
    known : tuple of (str, tuple)
        For M, G and C the entries that are 0 or 1 in every row, None elsewhere; M is B.
    noisy : bool
        Whether every reading has noise: pivots are positive, and nothing contradicts.
    """

    n: int
    p: int
    g: int
    known: tuple[tuple[str, tuple[float | None, ...]], ...]
    noisy: bool


def sizes(maps: Maps) -> Sizes:
    """Those of maps without shared noises."""
    known = []
    for name in ("B", "G", "C"):
        X = getattr(maps, name)
        same = (X == X[0]).all(axis=0) & ((X[0] == 0) | (X[0] == 1))
        flat = zip(X[0].ravel().tolist(), same.ravel().tolist())
        known.append((name, tuple(v if s else None for v, s in flat)))
    n, p, g = maps.B.shape[1], maps.C.shape[1], maps.G.shape[2]
    return Sizes(n, p, g, tuple(known), bool((maps.r > 0).all()))


def known(name: str, maps: Maps) -> bool:
    """Whether the text for these maps was compiled in this process."""
    return bool(_compiled) and (name, sizes(maps)) in _compiled


def function(name: str, maps: Maps) -> Callable:
    """`forward`, `replay` or `backward` of `passes` for these maps, in scalars."""
    key = name, sizes(maps)
    if key not in _compiled:
        written = dict(forward=record, replay=replayed, backward=way_back)[name]
        alone = getattr(passes, name).exact
        _compiled[key] = jitted(written(key[1])) if installed() else alone
    return _compiled[key]


_compiled: dict[tuple[str, Sizes], Callable] = {}


def python(maps: Maps) -> Callable:
    """`forward` of `passes` for these maps, in scalars, not compiled."""
    run = _python(sizes(maps))

    def over(*given: Any) -> Any:  # entries of memoryviews are numbers of Python
        return run(*(
            type(X)(*(memoryview(one) for one in X))
            if isinstance(X, tuple) else memoryview(X)
            for X in given
        ))  # fmt: skip

    return over


@cache
def _python(size: Sizes) -> Callable:
    space: dict[str, Any] = dict(TINY=TINY)
    exec("\n\n".join([*CHOICES, statements(size)]), space)  # made by us
    found: Callable = space["run"]
    return found


BESIDE = """from numba import njit
import numpy as np

from luenberger.filtering.passes import ROOM, TINY, State, Tape

own = njit(error_model="numpy")
"""


def replayed(size: Sizes) -> str:
    """The text of `passes.replay` for these sizes, over that of `forward`."""
    forward = statements(size).replace("def run(", "def forward(", 1)
    replay = _source(passes.replay).replace("def replay(", "def run(", 1)
    return _module([*CHOICES, forward, _source(passes.taken)], replay)


def record(size: Sizes) -> str:
    """The text of `passes.forward` for these sizes."""
    return _module(CHOICES, statements(size))


def _source(text: passes.Text) -> str:
    return getsource(text.plain).removeprefix("@Text\n")


def _module(called: Sequence[str], run: str) -> str:
    return "\n\n@own\n".join([BESIDE, *called]) + f"\n\n{run}"


CHOICES = [_source(one) for one in (passes.clear, passes.over, passes.part)]


class Row:
    """The statements of one row: of the prediction, of each reading, of variances.

    `r` are the variances of readings where they are known for good.
    """

    def __init__(
        self,
        size: Sizes,
        r: Sequence[float] | None = None,
        tiny: float = TINY,
    ) -> None:
        n, p, g = size.n, size.p, size.g
        self.size, self.to = size, Statements(tiny)
        known = {name: iter(values) for name, values in size.known}
        self.tables = {
            name: self._table(name, shape, known[name])
            for name, shape in (("B", (n, n)), ("G", (n, g)), ("C", (p, n)))
        }
        self.r: Any = r or [self.to.given(f"r_{j}") for j in range(p)]
        self.state = {
            "z": _array([self.to.given(f"z_{i}") for i in range(n)]),
            "V": self._triangle(),
            "D": _array([self.to.given(f"D_{i}") for i in range(n)]),
        }

    def _table(self, name: str, shape: tuple[int, int], known: Any) -> np.ndarray:
        X = np.empty(shape, dtype=object)
        for at in np.ndindex(*shape):
            value = next(known)
            given = f"{name}_{at[0]}_{at[1]}"
            X[at] = self.to.given(given) if value is None else value
        return X

    def _triangle(self) -> np.ndarray:
        n = self.size.n
        V = np.zeros((n, n), dtype=object)
        for j in range(n):
            V[j, j] = 1.0
            for i in range(j):
                V[j, i] = self.to.given(f"V_{j}_{i}")
        return V

    def fresh(self) -> tuple[np.ndarray, ...]:
        """z, V and D as they are named before the next statements."""
        return tuple(X.copy() for X in self.state.values())

    def predict(self) -> tuple[np.ndarray, ...]:
        """z, V, D and what z is made of, ahead of the next row."""
        n, g = self.size.n, self.size.g
        z, V, D = self.fresh()
        room = lambda *shape: np.zeros(shape, dtype=object)  # noqa: E731
        drive = _array([self.to.given(f"drive_{i}") for i in range(n)])
        B, G = self.tables["B"], self.tables["G"]
        met = _array([self.to.given(f"met_{i}") for i in range(n)])
        self.to.does(
            passes.predict, B, B, G, room(n, 0), room(0), drive, z, V, D, room(0, n),
            room(0), room(n, n + g), room(n + g), room(n), met, room(0, n),
            room(n + g),
        )  # fmt: skip
        return z, V, D, met

    def own(self) -> list[str]:
        """The names of a state."""
        return [name for name, _ in names(*self.fresh())]

    def read(self, j: int, given: bool = False) -> tuple[Any, ...]:
        """z, V, D, met, K, pivot, innovation, its size, after the reading of output j.

        K and the pivot may be `given`; then V and D are left as they are.
        """
        n = self.size.n
        z, V, D = self.fresh()
        K, f = np.zeros(n, dtype=object), np.zeros(n, dtype=object)
        met = _array([self.to.given(f"met_{i}") for i in range(n)])
        y = self.to.given(f"y_{j}")
        c, r = self.tables["C"][j], self.r[j]
        more = {"absorb": partial(self._moved, j)} if given else {}
        self.to.positive = self.size.noisy or (not isinstance(r, Name) and r > 0)
        pivot, nu, made = self.to.does(passes.read, y, V, D, c, r, z, met, K, f, **more)
        self.to.positive = False
        return z, V, D, met, K, pivot, nu, made

    def reads(self, which: str) -> dict[str, str]:
        """What is read of the maps `which`, by name; the place of the row is open."""
        found = {
            f"{X}_{i}_{j}": f"{X}[{{}}, {i}, {j}]" for X, T in self.tables.items()
            for (i, j), v in np.ndenumerate(T) if isinstance(v, Name) and X in which
        }  # fmt: skip
        if "r" in which:
            found |= {f"r_{j}": f"R[{{}}, {j}]" for j in range(self.size.p)}
        return found

    def _moved(self, j: int, *state: Any) -> Entry:
        """What `passes.absorb` does to the estimate x, with a gain that is given."""
        _, _, _, _, nu, x, K, _ = state
        pivot = self.to.given(f"pivot_{j}")
        move = self.to.over(nu, pivot)
        for i in range(len(x)):
            K[i] = self.to.given(f"K_{j}_{i}")
            x[i] += K[i] * move
        return pivot

    def spread(self) -> np.ndarray:
        """The variances."""
        variances = np.zeros(self.size.n, dtype=object)
        self.to.does(passes.spread, *self.fresh()[1:], variances)
        return variances


def _array(entries: list[Entry]) -> np.ndarray:
    X = np.empty(len(entries), dtype=object)
    X[:] = entries
    return X


def names(
    z: np.ndarray, V: np.ndarray, D: np.ndarray, met: Iterable[Entry] = ()
) -> list[tuple[str, Entry]]:
    """The parts of a state that change, and what it is made of, by name."""
    n = len(z)
    found = [(f"z_{i}", z[i]) for i in range(n)] + [(f"D_{i}", D[i]) for i in range(n)]
    found += [(f"V_{j}_{i}", V[j, i]) for j in range(n) for i in range(j)]
    return found + [(f"met_{i}", X) for i, X in enumerate(met)]


def statements(size: Sizes) -> str:
    """The function `run` that does what `passes.forward` does."""
    row, n, p, sure = Row(size), size.n, size.p, size.noisy
    out = [
        "def run(y, drive, at, maps, state, xs, variances, tape):",
        "    B, G, C, R = maps.B, maps.G, maps.C, maps.r",
        "    z, V, D = state.z, state.V, state.D",
        "    clash, s, k = -1, -1, -1",
    ]
    fixed = [f"{X}_{i}_{j}" for X, T in row.tables.items() for (i, j), v in
             np.ndenumerate(T) if isinstance(v, Name)]  # fmt: skip
    load = {one: "{}[{}, {}, {}]".format(*_apart(one)) for one in fixed}
    load |= {f"r_{j}": f"R[at_, {j}]" for j in range(p)}
    ahead = [one for one in load if one[0] in "BG"]
    behind = [one for one in load if one[0] in "Cr"]
    own = [name for name, _ in names(*row.fresh())]
    read_back = {"z": "z[{0}]", "D": "D[{0}]", "V": "V[{0}, {1}]"}
    out += [f"    {one} = {load[one].replace('at_', '0')}" for one in load]
    for one in own:
        out.append(f"    {one} = {read_back[one[0]].format(*one.split('_')[1:])}")
    out += [f"    met_{i} = abs(z_{i})" for i in range(0 if sure else n)]
    out += ["    for t in range(y.shape[0]):", "        if at[t] >= 0:"]
    if ahead:
        out += ["            if at[t] != s:", "                s = at[t]"]
        out += [
            f"                {one} = {load[one].replace('at_', 's')}" for one in ahead
        ]
    out += [f"            drive_{i} = drive[t, {i}]" for i in range(n)]
    z, V, D, met = row.predict()
    out += _block(names(z, V, D, () if sure else met), 12, "p")
    keep = lambda what, lines: [f"        if len(tape.{what}):"] + [  # noqa: E731
        f"            {line}" for line in lines]  # fmt: skip
    out += keep("ahead", [f"tape.ahead[t, {i}] = z_{i}" for i in range(n)])
    out += ["        if at[t + 1] != k:", "            k = at[t + 1]"]
    out += [f"            {one} = {load[one].replace('at_', 'k')}" for one in behind]
    for j in range(p):
        z, V, D, met, K, pivot, nu, made = row.read(j)
        found = names(z, V, D, () if sure else met) + [("pivot", pivot), ("nu", nu)]
        found += [*((f"K_{i}", K[i]) for i in range(n))]
        if not sure:
            found.append(("size", made))
        out += [
            f"        y_{j} = y[t, {j}]",
            "        pivot, nu = -1.0, 0.0",
            *(f"        K_{i} = 0.0" for i in range(n)),
            f"        if y_{j} == y_{j}:",
            *_block(found, 12, f"r{j}_"),
        ]
        contradicts = f"pivot == 0.0 and abs(nu) > {CLASH!r} * size"
        if not sure:
            out += [
                f"            if clash < 0 and {contradicts}:",
                f"                clash = t * {p} + {j}",
            ]
        out += keep("pivot", [f"tape.pivot[t, {j}] = pivot", f"tape.nu[t, {j}] = nu"])
        out += keep("K", [f"tape.K[t, {j}, {i}] = K_{i}" for i in range(n)])
    rest = [f"tape.z[t, {i}] = z_{i}" for i in range(n)]
    rest += [f"tape.D[t, {i}] = D_{i}" for i in range(n)]
    rest += [f"tape.V[t, {j}, {i}] = V_{j}_{i}" for j in range(n) for i in range(j)]
    ones = np.eye(n).tolist()
    for j in range(n):
        rest += [f"tape.V[t, {j}, {i}] = {ones[j][i]}" for i in range(j, n)]
    out += keep("z", rest)
    out += _block([(f"v_{i}", v) for i, v in enumerate(row.spread())], 8, "v")
    out += [f"        xs[t, {i}] = z_{i}" for i in range(n)]
    out += [f"        variances[t, {i}] = v_{i}" for i in range(n)]
    for one in own:
        out.append(f"    {read_back[one[0]].format(*one.split('_')[1:])} = {one}")
    return "\n".join([*out, "    return clash", ""])


def one_gain(n: int, p: int, m: int) -> str:
    """The text of `passes.one_gain` for n states, p outputs and m columns of J."""
    to, x = Statements(), np.zeros(n, dtype=object)
    given = lambda X, k: _array([to.given(f"{X}_{i}") for i in range(k)])  # noqa: E731
    wide = dict(A=n, J=m, K=p)
    tables = {X: given(X, n * k).reshape(n, k) for X, k in wide.items()}
    z, y, drive = given("z", n), given("y", p), given("drive", m)
    to.does(passes.gained, *tables.values(), z, y, drive, x)
    lines, shown = written(x)
    of = lambda text, count: [text.format(k) for k in range(count)]  # noqa: E731
    out = ["def run(y, drive, A, J, K, z, sizes, xs, variances):"]
    for X, entries in tables.items():
        for (i, k), one in np.ndenumerate(entries):
            out.append(f"    {one.of[0]} = {X}[{i}, {k}]")
    out += [
        *of("    z_{0}, v_{0} = z[{0}], sizes[{0}]", n),
        "    for t in range(len(y)):",
        *of("        y_{0} = y[t, {0}]", p),
        *of("        drive_{0} = drive[t, {0}]", m),
        *(f"        {one} = {said}" for one, said in lines),
        *(f"        z_{i} = {shown(one)}" for i, one in enumerate(x)),
        *of("        xs[t, {0}], variances[t, {0}] = z_{0}, v_{0}", n),
        *of("    z[{0}] = z_{0}", n),
    ]
    return "\n".join([*out, ""])


def way_back(size: Sizes) -> str:
    """The text of `passes.backward` for these sizes, where no P is wanted."""
    row, n, p = Row(size), size.n, size.p
    does, pairs = row.to.does, [(i, j) for i in range(n) for j in range(i + 1)]
    room = lambda *shape: np.zeros(shape, dtype=object)  # noqa: E731
    given = lambda name: _array([row.to.given(f"{name}_{i}") for i in range(n)])  # noqa: E731
    square, own = room(n, n), [f"l_{i}" for i in range(n)]
    for i, j in pairs:
        square[i, j] = square[j, i] = row.to.given(f"A_{i}_{j}")
        own.append(f"A_{i}_{j}")
    load = row.reads("BGC")
    out = [
        "def run(at, maps, tape, z, variances, P, w, before):",
        "    B, G, C = maps.B, maps.G, maps.C",
        "    worst, k = 0.0, -1",
        *(f"    {one} = 0.0" for one in own),
        *(f"    {one} = {text.format(0)}" for one, text in load.items()),
        "    for t in range(tape.z.shape[0] - 1, -1, -1):",
        "        if at[t + 1] != k:",
        "            k = at[t + 1]",
        *(f"            {one} = {text.format('k')}" for one, text in load.items()),
    ]
    z, V, D = row.fresh()
    out += [f"        z_{i} = tape.z[t, {i}]" for i in range(n)]
    out += [f"        D_{i} = tape.D[t, {i}]" for i in range(n)]
    out += [
        f"        V_{j}_{i} = tape.V[t, {j}, {i}]" for j in range(n) for i in range(j)
    ]
    a, A, S, H = room(n), room(n, n), room(n, n), room(n, n)
    v, noise, T = room(n), room(n), D[:, None] * V
    does(passes.moved_back, row.tables["B"], given("l"), square, a, A, room(n, n))
    does(passes.times, V.T, T, S)
    made = does(passes.corrected, S, a, A, z, H, v)
    does(passes.driven_by, row.tables["G"], given("l"), room(size.g), noise)
    vectors = dict(x=z, v=v, w=noise, l=a, m=S.diagonal())
    found = [(f"{one}_{i}", X[i]) for one, X in vectors.items() for i in range(n)]
    found += [
        (f"{k}_{i}_{j}", X[i, j]) for k, X in (("A", A), ("S", S)) for i, j in pairs
    ]
    out += _block([*found, ("size", made)], 8, "b")
    out += [f"        variances[t, {i}] = v_{i}" for i in range(n)]
    for k, X in enumerate("AS"):
        out += [f"        before[t % 2, {k}, {i}, {j}] = {X}_{max(i, j)}_{min(i, j)}"
                for i in range(n) for j in range(n)]  # fmt: skip
    out += [f"        o_{i} = A_{i}_{i}" for i in range(n)]
    for j in range(p - 1, -1, -1):
        share, nu, K = row.to.given("share"), row.to.given("nu"), given("K")
        a, A, m = given("l"), square.copy(), given("m")
        does(passes.unread, K, row.tables["C"][j], share, nu, a, A, room(n))
        m += K * K * share
        found = [(f"l_{i}", a[i]) for i in range(n)] + [
            (f"m_{i}", m[i]) for i in range(n)
        ]
        found += [(f"A_{i}_{j}", A[i, j]) for i, j in pairs]
        out += [
            f"        if tape.pivot[t, {j}] > 0.0:",
            f"            share, nu = 1.0 / tape.pivot[t, {j}], tape.nu[t, {j}]",
            *(f"            K_{i} = tape.K[t, {j}, {i}]" for i in range(n)),
            *_block(found, 12, f"u{j}_"),
        ]
    out += [f"        size += m_{i} * (o_{i} + A_{i}_{i})" for i in range(n)]
    out += ["        worst = max(worst, size)"]
    for i in range(n):
        out += [
            f"        if not {LOST!r} * worst * S_{i}_{i} <= v_{i}:",
            "            return t",
        ]
    for one, name in dict(z="x", w="w").items():
        out += [f"        {one}[t, {i}] = {name}_{i}" for i in range(n)]
    return "\n".join([*out, "    return -1", ""])


def _apart(one: str) -> tuple[str, ...]:
    X, i, j = one.split("_")
    return X, "at_", i, j


def _block(found: list[tuple[str, Entry]], indent: int, prefix: str) -> list[str]:
    """Statements, and then all names at once."""
    found = [(name, x) for name, x in found if renamed(name, x)]
    lines, shown = written([x for _, x in found], CALLS, prefix)
    out = [f"{name} = {text}" for name, text in lines]
    if found:
        left = ", ".join(name for name, _ in found)
        out.append(f"{left} = {', '.join(shown(x, 1) for _, x in found)}")
    return [" " * indent + line for line in out]


def renamed(name: str, x: Entry) -> bool:
    return not (isinstance(x, Name) and x.op == "given" and x.of[0] == name)
