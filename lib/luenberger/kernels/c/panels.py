"""The functions that the loops of exported C share: a few rows of a matrix at once.

Each number that is read of a right factor serves all rows of a panel, and the loop
along the row becomes vector code.  Arguments are `restrict`, by a macro, and trip
counts are not known when they are compiled: otherwise gcc writes a function out and
does not vectorise it.  No function reads and writes the same array.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from fractions import Fraction

from ..program import Roots
from ..tiles import runs as runs
from ..writer import entry as entry
from ..writer import pointer as pointer
from .tables import PaddedRows
from .writer import C

Stride = str  # from one entry to the next, as C has it: "1" or the name of a row


@dataclass
class Panels:
    """The functions of one file, each written when it is first asked for."""

    rows: PaddedRows
    texts: dict[tuple[object, ...], tuple[str, str]] = field(default_factory=dict)

    @property
    def name(self) -> str:
        return self.rows.name

    @property
    def real(self) -> str:
        return self.rows.real

    @property
    def restrict(self) -> str:
        """The macro for `restrict`, which rule 8.14 of MISRA forbids."""
        return f"{self.name}_RESTRICT"

    def lines(self) -> list[str]:
        """The functions, and what they call `restrict`."""
        if not self.texts:
            return []
        macro = [
            "/* No two arguments overlap.  Define it empty for MISRA C:2012, 8.14. */",
            f"#ifndef {self.restrict}",
            f"#define {self.restrict} restrict",
            "#endif",
            "",
        ]
        return [*macro, *(text for _, text in self.texts.values())]

    def ask(
        self, what: str, key: tuple[object, ...], write: Callable[[str], str]
    ) -> str:
        """The name of a function; `write` makes its text if it is new."""
        whole = (what, *key)
        if whole not in self.texts:
            same = sum(other[0] == what for other in self.texts)
            name = f"{self.name}_{what}" + (f"_{same + 1}" if same else "")
            self.texts[whole] = name, write(name)
        return self.texts[whole][0]

    def function(
        self, name: str, says: str, inputs: str, outputs: str, to: C, kind: str = "void"
    ) -> str:
        """The text of a static function of pointers."""
        pointers = [f"const {self.real} *{self.restrict} {k}" for k in inputs.split()]
        pointers += [f"{self.real} *{self.restrict} {k}" for k in outputs.split()]
        counts = "int columns, " if kind == "void" else ""
        if "b" in inputs.split():
            counts += "int inner, "
        head = f"static inline {kind} {name}({counts}"
        given = ",\n    ".join(pointers)
        body = "\n".join(to.lines)
        return f"/* {says} */\n{head}\n    {given})\n{{\n{body}\n}}\n".replace(
            " \n", "\n"
        )

    def product(
        self,
        height: int,
        scale: Fraction,
        a: tuple[Stride, Stride],
        b: Stride,
        c: Stride | None,
        d: Stride,
        in_place: bool = False,
    ) -> str:
        """d = c + scale a b, or without c; `in_place` adds to d and takes no c.

        Strides are from row to row; of `a` from row to row and along a row.
        """
        sign = "-=" if scale < 0 else "+="

        def write(name: str) -> str:
            to = C(self.real)
            to.loop("j", 0, "columns")
            for r in range(height):
                start = "0.0" if c is None else entry("c", (r, c), (1, "j"))
                start = entry("d", (r, d), (1, "j")) if in_place else start
                to.let(f"s{r}", start)
            to.at_least_once("k")
            number = entry("b", ("k", b), (1, "j"))
            scaled = "" if abs(scale) == 1 else f"{float(abs(scale))!r} * "
            to.constant("q", scaled + number)
            for r in range(height):
                to.set(f"s{r}", f"{entry('a', (r, a[0]), ('k', a[1]))} * q", sign)
            to.again("k", "inner")
            for r in range(height):
                to.set(entry("d", (r, d), (1, "j")), f"s{r}")
            to.end()
            given = "a b" if c is None or in_place else "a b c"
            rows = f"{height} rows" if height > 1 else "a row"
            factor = "" if abs(scale) == 1 else f"{float(abs(scale)):.3g} "
            start = "d " if in_place else "c " if c else ""
            whole = f"{start}{sign[0] if start else ''} {factor}a b".strip()
            says = f"d = {whole}, {rows}; `inner` is not 0"
            return self.function(name, says, given, "d", to)

        what = "less" if scale < 0 else "plus" if c or in_place else "times"
        key = (height, scale, a, b, c, d, in_place)
        return self.ask(f"{what}{height}", key, write)

    def pivots(self, height: int, m: Stride, known: bool = False) -> str:
        """The factor L d L' of a block on the diagonal: 0, or 1 if it must give up.

        With `known` a pivot may be zero, and so is its v then.
        """

        def write(name: str) -> str:
            to = C(self.real)
            for r in range(height):
                for c in range(r, height):
                    rest = "".join(f" - l{r}{k} * u{k}{c}" for k in range(r))
                    to.constant(f"u{r}{c}", entry("m", (r, m), (c, "1")) + rest)
                pivot = f"u{r}{r}"
                to.constant(f"v{r}", to.inverse(pivot) if known else f"1.0 / {pivot}")
                for c in range(r + 1, height):
                    to.constant(f"l{c}{r}", f"u{r}{c} * v{r}")
            for r in range(height):
                to.set(f"v[{r}]", f"v{r}")
                for c in range(r):
                    to.set(f"l[{r * (r - 1) // 2 + c}]", f"l{r}{c}")
            tests = " && ".join(f"u{r}{r} > least[{r}]" for r in range(height))
            to.line(f"return ({tests}) ? 0 : 1;")
            made = "l v" if height > 1 else "v"
            says = "m = L d L' with v = 1 / d; 1 if one of d is not above its least"
            return self.function(name, says, "m least", made, to, "int")

        return self.ask(f"pivots{height}", (height, m, known), write)

    def larger(self, step: Roots, b: Stride) -> str:
        """d = how many entries of each column of b are larger than a a'."""

        def write(name: str) -> str:
            to = C(self.real)
            to.loop("j", 0, "columns")
            to.let("s", "0.0")
            to.at_least_once("k")
            fits = step.condition(entry("b", ("k", b), (1, "j")), "a[k]", "a[j]")
            to.set("s", f"({fits}) ? 0.0 : 1.0", "+=")
            to.again("k", "inner")
            to.set("d[j]", "s")
            to.end()
            says = "entries of each column of b that are larger than those of a a'"
            return self.function(name, says, "a b", "d", to)

        return self.ask("larger", (step, b), write)

    def forward(self, height: int, x: Stride, u: Stride) -> str:
        """L u = x in a panel, and s = u / d."""

        def write(name: str) -> str:
            to = C(self.real)
            self.load(to, height)
            to.loop("j", 0, "columns")
            for r in range(height):
                rest = "".join(f" - l{r}{k} * u{k}" for k in range(r))
                to.constant(f"u{r}", entry("x", (r, x), (1, "j")) + rest)
            for r in range(height):
                to.set(entry("u", (r, u), (1, "j")), f"u{r}")
                to.set(entry("s", (r, u), (1, "j")), f"u{r} * v{r}")
            to.end()
            given = "x l v" if height > 1 else "x v"
            says = "u with L u = x, and s = u / d"
            return self.function(name, says, given, "u s", to)

        return self.ask(f"forward{height}", (height, x, u), write)

    def backward(self, height: int, x: Stride, d: Stride) -> str:
        """L' d = x in a panel."""

        def write(name: str) -> str:
            to = C(self.real)
            self.load(to, height, diagonal=False)
            to.loop("j", 0, "columns")
            for r in reversed(range(height)):
                rest = "".join(f" - l{k}{r} * d{k}" for k in range(r + 1, height))
                to.constant(f"d{r}", entry("x", (r, x), (1, "j")) + rest)
            for r in range(height):
                to.set(entry("d", (r, d), (1, "j")), f"d{r}")
            to.end()
            given = "x l" if height > 1 else "x"
            return self.function(name, "d with L' d = x", given, "d", to)

        return self.ask(f"backward{height}", (height, x, d), write)

    def load(self, to: C, height: int, diagonal: bool = True) -> None:
        """The factor of a block into scalars."""
        for r in range(height):
            for c in range(r):
                to.constant(f"l{r}{c}", f"l[{r * (r - 1) // 2 + c}]")
            if diagonal:
                to.constant(f"v{r}", f"v[{r}]")
