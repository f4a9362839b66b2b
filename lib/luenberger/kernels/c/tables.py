"""Tables of constants in padded rows, and how long a padded row is.

How many numbers a vector register holds is known when the C is compiled, so the length
of a row is an expression in `NAME_LANES`; without vectors nothing is padded.
"""

from dataclasses import dataclass, field

import numpy as np

from ...numeric import Matrix
from ..writer import entry
from .numbers import BYTES
from .writer import C, listed

# bytes in a vector, by macro
VECTORS = {"__AVX512F__": 64, "__AVX__": 32, "__SSE2__": 16, "__ARM_NEON": 16}


@dataclass
class PaddedRows:
    """What one file has of them; a table is there once it was asked for."""

    name: str
    real: str
    given: dict[str, Matrix] = field(default_factory=dict)
    tables: dict[str, Matrix] = field(default_factory=dict)
    lengths: dict[int, str] = field(default_factory=dict)

    @property
    def lanes(self) -> str:
        """The macro that says how many numbers are in a vector."""
        return f"{self.name}_LANES"

    @property
    def start(self) -> str:
        """The macro before a row; where no row is padded it is empty (MISRA C, 9.3)."""
        return f"{self.name}_AT"

    def row(self, length: int) -> str:
        """How many numbers a row of so many takes."""
        return self.lengths.setdefault(length, f"{self.name}_row{length}")

    def table(self, matrix: str, turned: bool) -> str:
        """The table of a given matrix or of its transpose; equal ones share one."""
        X = self.given[matrix]
        X = X.T if turned and 1 not in X.shape else X
        for name, other in self.tables.items():
            if other.shape == X.shape and np.array_equal(other, X):
                return name
        name = f"{self.name}_{matrix}" + "_T" * turned
        self.tables[name] = X
        return name

    def constants(self) -> int:
        """How many numbers are in the tables, without the padding."""
        return sum(X.size for X in self.tables.values())

    def lines(self) -> list[str]:
        """The lengths and the tables as C declarations."""
        padded, plain = C(self.real, 0), C(self.real, 0)
        entries = [self.entries(name, X) for name, X in self.tables.items()]
        for length, row in sorted(self.lengths.items()):
            whole = f"({length} + {self.lanes} - 1) / {self.lanes} * {self.lanes}"
            padded.line(f"enum {{ {row} = {whole} }};")
            plain.line(f"enum {{ {row} = {length} }};")
        head: list[str] = []
        if self.lengths:
            head = [*self.macro(), f"#if {self.lanes} > 1", *padded.lines]
            head += [f"#define {self.start}(k) [k] =", "#else", *plain.lines]
            head += [f"#define {self.start}(k)", "#endif"]
        return [*head, *(text for one in entries for text in one)]

    def macro(self) -> list[str]:
        """How many numbers are in a vector, unless the compiler is told."""
        lines = [
            "/* Numbers in a vector: a row of a matrix is padded to a multiple. */",
            f"#ifndef {self.lanes}",
        ]
        longest = max(self.lengths)
        for k, (macro, size) in enumerate(VECTORS.items()):
            lanes = size // BYTES[self.real]
            while lanes >= 2 * longest:
                lanes //= 2
            lines.append(f"#{'elif' if k else 'if'} defined({macro})")
            lines.append(f"#define {self.lanes} {lanes}")
        return [*lines, "#else", f"#define {self.lanes} 1", "#endif", "#endif", ""]

    def entries(self, name: str, X: Matrix) -> list[str]:
        """The declaration of one table; the padding of a row is zero."""
        to = C(self.real, 0)
        if 1 in X.shape:
            to.table(name, X)
            return to.lines
        rows, cols = X.shape
        row = self.row(cols)
        to.line(f"static const {self.real} {name}[{rows} * {row}] = {{")
        for i, numbers in enumerate(X):
            at = entry("", (i, row))[1:-1]
            to.line(f"    {self.start}({at}) {listed(numbers)[1:-1].strip()},")
        to.line("};")
        return to.lines
