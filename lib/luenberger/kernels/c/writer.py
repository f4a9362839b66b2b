"""C99 lines: statements, numbers, functions."""

import re

import numpy as np

from ..writer import Writer

# a number with a point or an exponent, which C takes for a double
LITERAL = re.compile(r"(?<![\w.])(\d+\.\d*(?:e[+-]?\d+)?|\d+e[+-]?\d+)")


class C(Writer):
    """The body of a function; `real` is "double" or "float"."""

    comment, stop = "//", ";"

    def __init__(self, real, depth=1):
        super().__init__(depth)
        self.real = real

    def line(self, text):
        super().line(typed(text, self.real))

    def let(self, name, text):
        self.line(f"{self.real} {name} = {text};")

    def constant(self, name, text):
        self.line(f"const {self.real} {name} = {text};")

    def table(self, name, values):
        """Numbers that never change."""
        size = np.size(values)
        self.line(f"static const {self.real} {name}[{size}] = {listed(values)};")

    def index(self, name, text):
        self.line(f"const int {name} = {text};")

    def array(self, name, length, start=""):
        self.line(f"{self.real} {name}[{length or 1}]{start};")

    def loop(self, index, start, stop):
        self.line(f"for (int {index} = {start}; {index} < {stop}; {index}++) {{")
        self.depth += 1

    def end(self):
        self.depth -= 1
        self.line("}")

    def need(self, text):
        self.line(f"if (!({text})) return 1;")


def typed(text, real):
    """Text whose numbers are of the type `real`."""
    return LITERAL.sub(r"\1f", text) if real == "float" else text


def listed(values, per_line=4):
    """Numbers between braces; NaN is C99's NAN."""
    numbers = [repr(float(v)) if v == v else "NAN" for v in np.ravel(values)] or ["0.0"]
    rows = [
        ", ".join(numbers[k : k + per_line]) for k in range(0, len(numbers), per_line)
    ]
    if len(rows) == 1:
        return f"{{{rows[0]}}}"
    return "{\n        " + ",\n        ".join(rows) + "\n    }"


def function(head, lines, arguments=()):
    """A function of these lines; of its `arguments` those that they never read."""
    body = "\n".join(lines)
    unused = [k for k in arguments if not re.search(rf"\b{k}\b", body)]
    return "\n".join([head, "{", *(f"    (void){k};" for k in unused), body, "}", ""])
