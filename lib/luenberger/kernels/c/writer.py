"""C99 lines: statements, numbers, functions."""

from __future__ import annotations

import re

import numpy as np
from numpy.typing import ArrayLike

# a number with a point or an exponent, which C takes for a double
LITERAL = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)(?![\w.])")
FUNCTION = re.compile(r"\b(sqrt|fabs)\(")  # of doubles; those of floats end in f


class C:
    """Lines of the body of a function; `real` is "double" or "float"."""

    def __init__(self, real: str, depth: int = 1) -> None:
        self.real, self.depth = real, depth
        self.lines: list[str] = []

    def line(self, text: str) -> None:
        self.lines.append("    " * self.depth + typed(text, self.real))

    def set(self, target: str, text: str, sign: str = "=") -> None:
        self.line(f"{target} {sign} {text};")

    def let(self, name: str, text: str) -> None:
        """A scalar that changes."""
        self.line(f"{self.real} {name} = {text};")

    def constant(self, name: str, text: str) -> None:
        self.line(f"const {self.real} {name} = {text};")

    def table(self, name: str, values: ArrayLike) -> None:
        """Numbers that never change."""
        size = np.size(values)
        self.line(f"static const {self.real} {name}[{size}] = {listed(values)};")

    def array(self, name: str, length: int | str, start: str = "") -> None:
        """Room for numbers."""
        self.line(f"{self.real} {name}[{length or 1}]{start};")

    def loop(self, index: str, start: int | str, stop: int | str) -> None:
        self.line(f"for (int {index} = {start}; {index} < {stop}; {index}++) {{")
        self.depth += 1

    def check(self, condition: str) -> None:
        """What follows, up to `end`, only where a condition holds."""
        self.line(f"if ({condition}) {{")
        self.depth += 1

    def end(self) -> None:
        """End of a loop or a condition."""
        self.depth -= 1
        self.line("}")

    def need(self, text: str) -> None:
        """Give up unless the condition holds."""
        self.when(f"!({text})", "return 1;")

    def each(self, array: str, length: int, test: str) -> None:
        """Give up unless a condition, of an entry {}, holds for every entry."""
        self.loop("i", 0, length)
        self.need(test.format(f"{array}[i]"))
        self.end()

    def when(self, condition: str, text: str) -> None:
        """One statement under a condition."""
        self.check(condition)
        self.line(text)
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
