"""C99 lines: statements, numbers, functions."""

from __future__ import annotations

import re
from collections.abc import Iterable

import numpy as np
from numpy.typing import ArrayLike

from ..program import Size
from ..writer import Writer

# a number with a point or an exponent, which C takes for a double
LITERAL = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?![\w.])")
FUNCTION = re.compile(r"\b(sqrt|fabs)\(")  # of doubles; those of floats end in f
WIDTH = 84  # of a line with a call in it


class C(Writer):
    """The body of a function; `real` is "double" or "float"."""

    comment, stop = "//", ";"

    def __init__(self, real: str, depth: int = 1) -> None:
        super().__init__(depth)
        self.real = real

    def line(self, text: str) -> None:
        super().line(typed(text, self.real))

    def let(self, name: str, text: str) -> None:
        self.line(f"{self.real} {name} = {text};")

    def constant(self, name: str, text: str) -> None:
        self.line(f"const {self.real} {name} = {text};")

    def table(self, name: str, values: ArrayLike) -> None:
        """Numbers that never change."""
        size = np.size(values)
        self.line(f"static const {self.real} {name}[{size}] = {listed(values)};")

    def index(self, name: str, text: str) -> None:
        self.line(f"const int {name} = {text};")

    def array(self, name: str, length: int | str, start: str = "") -> None:
        self.line(f"{self.real} {name}[{length or 1}]{start};")

    def loop(self, index: str, start: Size, stop: Size, step: int = 1) -> None:
        on = f"{index}++" if step == 1 else f"{index} += {step}"
        self.line(f"for (int {index} = {start}; {index} < {stop}; {on}) {{")
        self.depth += 1

    def end(self) -> None:
        self.depth -= 1
        self.line("}")

    def panels(self, index: str, first: int, last: int, height: int) -> None:
        """A loop over panels; one alone is a block."""
        if last - first > height:
            self.loop(index, first, last, height)
        else:
            self.line("{")
            self.depth += 1
            self.index(index, str(first))

    def at_least_once(self, index: str) -> None:
        """A loop from 0 that runs once or more; `again` ends it."""
        self.line(f"int {index} = 0;")
        self.line("do {")
        self.depth += 1

    def again(self, index: str, stop: Size) -> None:
        self.line(f"{index}++;")
        self.depth -= 1
        self.line(f"}} while ({index} < {stop});")

    def check(self, condition: str) -> None:
        self.line(f"if ({condition}) {{")
        self.depth += 1

    def inverse(self, pivot: str) -> str:
        return f"({pivot} > 0.0) ? 1.0 / {pivot} : 0.0"

    def need(self, text: str) -> None:
        self.line(f"if (!({text})) {{")
        self.line("    return 1;")
        self.line("}")

    def when(self, condition: str, text: str) -> None:
        """One statement under a condition."""
        self.line(f"if ({condition}) {{")
        self.line(f"    {text}")
        self.line("}")

    def call(self, what: str, given: Iterable[str], before: str = "") -> None:
        """A call, in lines that are not too long."""
        lines, indent = [f"{before}{what}("], 4 * self.depth
        for argument in given:
            start = "" if lines[-1].endswith("(") else ", "
            if indent + len(lines[-1] + start + argument) > WIDTH:
                lines[-1] += start.rstrip()
                lines.append(f"    {argument}")
            else:
                lines[-1] += start + argument
        for text in lines[:-1]:
            self.line(text)
        self.line(lines[-1] + (") != 0) {" if before else ");"))

    def need_call(self, what: str, given: Iterable[str]) -> None:
        """Give up where a function says so."""
        self.call(what, given, before="if (")
        self.depth += 1
        self.line("return 1;")
        self.end()


def typed(text: str, real: str) -> str:
    """Text whose numbers are of the type `real`."""
    if real != "float":
        return text
    return FUNCTION.sub(r"\1f(", LITERAL.sub(r"\1f", text))


def listed(values: ArrayLike, per_line: int = 4) -> str:
    """Numbers between braces; NaN is C99's NAN."""
    numbers = [repr(float(v)) if v == v else "NAN" for v in np.ravel(values)] or ["0.0"]
    rows = [
        ", ".join(numbers[k : k + per_line]) for k in range(0, len(numbers), per_line)
    ]
    if len(rows) == 1:
        return f"{{{rows[0]}}}"
    return "{\n        " + ",\n        ".join(rows) + "\n    }"
