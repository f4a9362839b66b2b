"""A constant observer in whole numbers, as C99.

No shift of a negative number, no sum that overflows: what is written behaves the same
under every compiler.
"""

from __future__ import annotations

from collections.abc import Sequence

from ...kernels.c.file import File, function
from ...kernels.c.writer import C
from ...observer import Observer
from . import counts, source_and_header
from .formats import SUM, Formats, Row
from .observer import EQUATIONS
from .rounding_bound import RoundingBound
from .source_and_header import Signals

UNROLLED = 24  # products that are written one by one; more are loops over tables
UNIT = "Every number is a whole one: counts, of which one unit has as many as below."
CODES = (
    "0: done; 1: done, and what was beyond its range was cut to it;\n"
    "   2: refused, as a count is the least one, which stands for no number, and\n"
    "   state and what are as they were."
)


def texts(
    observer: Observer, name: str, signals: Signals, made: Formats, bound: RoundingBound
) -> dict[str, str]:
    """The two files of an observer in whole numbers, by name."""
    module = File(name, f"int{made.bits}_t")
    written = _Fixed(module, made, observer.G.shape[1])
    body = source_and_header.source(module, written.functions())
    body += "\n" + counts.selftest(module, made, written.m)
    head = source_and_header.header(
        module,
        f"An observer of order {observer.order} in whole numbers of {made.bits} bits.",
        EQUATIONS,
        observer.dt,
        signals,
        [("z", observer.order, "z of the next sample; it follows T x")],
        [*NOTES, *written.cost(), *_rounded(bound)],
        counts.declared(module),
        ["", "#include <stdint.h>", *counts.units(name, made, signals)],
        UNIT,
        CODES,
    )
    return source_and_header.stamped(name, head, body)


NOTES = [
    "No state, no estimate and no sum can leave its whole number, whatever is read.",
]


def _rounded(bound: RoundingBound) -> list[str]:
    return [*bound.notes(), "Weights and readings are rounded in this bound, too."]


class _Fixed:
    """The functions of one observer; `wide` is the type of sums."""

    def __init__(self, module: File, made: Formats, inputs: int) -> None:
        self.module, self.made, self.m = module, made, inputs
        self.name, self.real = module.name, module.real
        self.wide, self.bits = f"int{SUM[made.bits]}_t", made.bits
        self.r, self.k, self.q = len(made.state), len(made.read), len(made.shown)
        self.products = sum(
            w != 0 for row in (*made.moves, *made.shows) for w in row.weights
        )

    def functions(self) -> list[str]:
        rows = self.unrolled if self.products <= UNROLLED else self.loops
        tables, step = rows()
        own = [self.nearest(), *tables, self.init(), step]
        return own + counts.conversions(self.module, self.bits)

    def nearest(self) -> str:
        """A sum over 2^(less + 1), to nearest, halves away from zero."""
        size = f"u{self.wide}"
        lines = [
            f"    const {size} size = (sum < 0) ? (0U - ({size})sum) : ({size})sum;",
            f"    const {size} twice = size >> less;",
            f"    const {size} whole = (twice + 1U) / 2U;",
            f"    const {self.wide} near = ({self.wide})whole;",
            f"    return ({self.real})((sum < 0) ? -near : near);",
        ]
        head = f"static {self.real} {self.name}_nearest({self.wide} sum, uint8_t less)"
        return function(head, lines)

    def init(self) -> str:
        to = C(self.real)
        for i, value in enumerate(self.made.start or (0,)):
            to.set(f"state->z[{i}]", str(value))
        return function(f"void {self.name}_init({self.name}_state *state)", to.lines)

    def reading(self, to: C) -> None:
        """Refuse what is no number, and cut to its range what is beyond."""
        to.line("int cut = 0;")
        if self.k:
            to.line(f"{self.real} s[{self.k}];")
        for array, first, last in (("u", 0, self.m), ("y", self.m, self.k)):
            if first == last:
                to.line(f"(void){array};")
                continue
            to.loop("i", 0, last - first)
            to.set(f"s[{_at(first)}]", f"{array}[i]")
            to.end()
        if not self.k:
            return
        to.loop("i", 0, self.k)
        to.when(f"s[i] < -INT{self.bits}_MAX", "return 2;")
        to.end()
        most = f"{self.name}_most[i]"
        cut = (f"s[i] > {most}", most), (f"s[i] < -{most}", f"({self.real})(-{most})")
        to.loop("i", 0, self.k)
        for test, value in cut:
            to.line(f"if ({test}) {{")
            to.line(f"    s[i] = {value};")
            to.line("    cut = 1;")
            to.line("}")
        to.end()

    def step(self, lines: Sequence[str]) -> str:
        to = C(self.real)
        if not self.r:
            to.line("(void)state;")
        self.reading(to)
        for line in lines:
            to.line(line)
        to.line("return cut;")
        return function(source_and_header.prototype(self.module), to.lines)

    def tables(self) -> list[str]:
        return (
            [counts.table(self.name, "most", self.real, self.made.most)]
            if self.k
            else []
        )

    def unrolled(self) -> tuple[list[str], str]:
        """Every product in a line of its own."""
        made, lines = self.made, []
        used = [
            any(row.weights[j] for row in (*made.moves, *made.shows))
            for j in range(self.r + self.k)
        ]
        names = [f"z{i}" for i in range(self.r)] + [f"s{i}" for i in range(self.k)]
        places = [f"state->z[{i}]" for i in range(self.r)]
        places += [f"s[{i}]" for i in range(self.k)]
        for name, place, one in zip(names, places, used, strict=True):
            if one:
                lines.append(f"const {self.wide} {name} = {place};")
        ahead = []
        for i, row in enumerate(made.moves):
            lines += self.sum(f"next{i}", row, names)
            ahead.append(f"state->z[{i}] = {self.rounded(f'next{i}', row)};")
        for i, row in enumerate(made.shows):
            lines += self.sum(f"now{i}", row, names)
            lines.append(f"what[{i}] = {self.rounded(f'now{i}', row)};")
        return self.tables(), self.step([*lines, *ahead])

    def sum(self, name: str, row: Row, names: Sequence[str]) -> list[str]:
        terms = [
            f"({w} * {one})" for w, one in zip(row.weights, names, strict=True) if w
        ]
        lines = [f"const {self.wide} {name} = {(terms or ['0'])[0]}"]
        lines += [f"    + {term}" for term in terms[1:]]
        return [*lines[:-1], f"{lines[-1]};"]

    def rounded(self, name: str, row: Row) -> str:
        return f"{self.name}_nearest({name}, {row.shift - 1}U)"

    def loops(self) -> tuple[list[str], str]:
        """Weights and shifts in tables, and one function for a row."""
        rows, width = [*self.made.moves, *self.made.shows], self.r + self.k
        weights = [w for row in rows for w in row.weights]
        tables = [
            *self.tables(),
            counts.table(self.name, "weights", self.real, weights),
            counts.table(
                self.name, "shifts", "uint8_t", [row.shift - 1 for row in rows]
            ),
            self.row(width),
        ]
        to = C(self.real, 0)
        to.line(f"{self.real} v[{width}];")
        for place, first, length in (("state->z", 0, self.r), ("s", self.r, self.k)):
            if length:
                to.loop("i", 0, length)
                to.set(f"v[{_at(first)}]", f"{place}[i]")
                to.end()
        for place, first, length in (("what", self.r, self.q), ("state->z", 0, self.r)):
            if length:
                to.loop("i", 0, length)
                to.set(f"{place}[i]", f"{self.name}_row({_at(first)}, v)")
                to.end()
        return tables, self.step(to.lines)

    def row(self, width: int) -> str:
        name, to = self.name, C(self.real)
        to.line(f"const {self.real} *weights = &{name}_weights[i * {width}];")
        to.line(f"{self.wide} sum = 0;")
        to.loop("j", 0, width)
        to.line(f"sum += ({self.wide})weights[j] * ({self.wide})v[j];")
        to.end()
        to.line(f"return {name}_nearest(sum, {name}_shifts[i]);")
        head = f"static {self.real} {name}_row(int i, const {self.real} v[])"
        return function(head, to.lines)

    def cost(self) -> list[str]:
        rows = [*self.made.moves, *self.made.shows]
        loops = self.products > UNROLLED
        count = len(rows) * (self.r + self.k) if loops else self.products
        size = self.bits // 8
        return [
            "",
            f"Cost of a step: {count} products of {self.bits} bits, summed in "
            f"{SUM[self.bits]} bits; {len(rows)} shifts.",
            f"    {size * self.r} bytes of state",
        ]


def _at(first: int) -> str:
    return f"i + {first}" if first else "i"
