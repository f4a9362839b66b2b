"""Where the matrices of a pass are in C: arrays, tables, and their strides.

A matrix is kept in rows of `NAME_rowN` numbers: N of them, and zeros up to whole
vectors.  A vector is kept as it is.  Of a constant there is a table, of its transpose
another where it is asked for.
"""

from __future__ import annotations

from collections.abc import Collection

from ..loops import Places
from ..program import Cost, Operand, Program, Sizes
from .layouts import chosen
from .panels import Panels, entry
from .writer import C

PADDED = 8  # numbers to a multiple of which a row is padded, as the stack is counted


class Store:
    """Declares, finds and copies; `cost` grows with what is on the stack."""

    def __init__(
        self,
        program: Program,
        sizes: Sizes,
        to: C,
        panels: Panels,
        constants: Collection[str],
        places: Places,
    ) -> None:
        self.program, self.sizes, self.to, self.panels = program, sizes, to, panels
        self.constants, self.places = constants, dict(places)
        self.layouts = chosen(program, sizes, constants)
        self.arrays: dict[tuple[str, bool], str] = {}
        self.cost = Cost()
        for name in program.given:
            self.read(name)

    def count(self, operations: int) -> None:
        self.cost += Cost(operations)

    def row(self, length: int) -> str:
        """From one row of so many numbers to the next."""
        return self.panels.rows.row(length)

    def line(self, length: int) -> str:
        """The same; one number is not padded."""
        return self.row(length) if length > 1 else "1"

    def width(self, rows: int, cols: int) -> str:
        """The columns to compute: the padding with them, which vectors do not have."""
        return self.row(cols) if rows > 1 and cols > 1 else str(cols)

    def block(self, name: str, rows: int, cols: int) -> str:
        """Declare an array of rows, or of one number each."""
        if cols == 1:
            return self.vector(name, rows)
        return self.array(name, rows, cols)

    def array(self, name: str, rows: int, cols: int) -> str:
        """Declare an array of padded rows."""
        self.cost += Cost(stack=rows * -(-cols // PADDED) * PADDED)
        self.to.array(name, f"{rows} * {self.row(cols)}".removeprefix("1 * "))
        return name

    def vector(self, name: str, length: int) -> str:
        self.cost += Cost(stack=length)
        self.to.array(name, length)
        return name

    def declare(self, operand: Operand) -> str:
        """An array for the rows of an operand that is about to be computed."""
        name, (rows, cols) = operand.name, self.layouts.shape(operand)
        if 1 in (rows, cols):
            return self.vector(name, rows * cols)
        found = self.array(name + "_T" * operand.turned, rows, cols)
        self.arrays[name, operand.turned] = found
        return found

    def strides(self, operand: Operand) -> tuple[str, str, str]:
        """The array of an operand, and its strides down a column and along a row."""
        name, (rows, cols) = operand.name, self.layouts.shape(operand)
        if 1 in (rows, cols):
            place = self.tabled(name, False) or self.places.get(name, name)
            return (place, "1", "1")
        if name in self.program.symmetric:
            operand = Operand(name)
        if name in self.constants or (name, operand.turned) in self.arrays:
            return self.found(operand), self.row(cols), "1"
        return self.found(operand.T), "1", self.row(rows)

    def found(self, kept: Operand) -> str:
        return self.tabled(*self.key(kept)) or self.arrays[self.key(kept)]

    def key(self, operand: Operand) -> tuple[str, bool]:
        return operand.name, operand.turned

    def tabled(self, name: str, turned: bool) -> str | None:
        """The table of a constant, or of its transpose."""
        if name not in self.constants:
            return None
        return self.panels.rows.table(name, turned)

    def at(self, operand: Operand, i: str, j: str) -> str:
        """The entry (i, j) of an operand."""
        rows, cols = self.layouts.shape(operand)
        name, down, along = self.strides(operand)
        parts = [(i, down)] * (rows > 1) + [(j, along)] * (cols > 1)
        return entry(name, *parts)

    def in_rows(self, operand: Operand) -> tuple[str, str]:
        """The array of an operand's rows and their stride; copied if there is none."""
        rows, cols = self.layouts.shape(operand)
        if rows > 1 and cols > 1 and self.strides(operand)[2] != "1":
            there = self.strides(operand)
            name = self.declare(operand)
            self.to.loop("i", 0, rows)
            self.to.loop("j", 0, cols)
            other = entry(there[0], ("i", there[1]), ("j", there[2]))
            self.to.set(entry(name, ("i", self.row(cols)), ("j", "1")), other)
            self.to.end()
            self.pad(name, cols)
            self.to.end()
        name, down, _ = self.strides(operand)
        return name, down if cols > 1 else "1"

    def pad(self, name: str, cols: int) -> None:
        """Zeros behind the entries of row i."""
        self.to.loop("j", cols, self.row(cols))
        self.to.set(entry(name, ("i", self.row(cols)), ("j", "1")), "0.0")
        self.to.end()

    def pad_all(self, name: str, rows: int, cols: int) -> None:
        """Zeros behind the entries of every row."""
        self.to.loop("i", 0, rows)
        self.pad(name, cols)
        self.to.end()

    def read(self, name: str) -> None:
        """A given matrix, into padded rows; constants and vectors stay in place."""
        rows, cols = self.program.shape(name, self.sizes)
        if name in self.constants or 1 in (rows, cols):
            return
        place = self.places.get(name, name)
        local = self.array(name + "_in" * (place == name), rows, cols)
        self.arrays[name, False] = local
        self.to.loop("i", 0, rows)
        self.to.loop("j", 0, cols)
        target = entry(local, ("i", self.row(cols)), ("j", "1"))
        self.to.set(target, entry(place, ("i", str(cols)), ("j", "1")))
        self.to.end()
        self.pad(local, cols)
        self.to.end()

    def result(self, operand: Operand | None, place: str, length: int) -> None:
        """Copy a result to where it is wanted, without the padding."""
        shape = (1, length) if operand is None else self.layouts.shape(operand)
        if operand is None or 1 in shape:
            value = (
                "0.0"
                if operand is None
                else entry(self.strides(operand)[0], ("i", "1"))
            )
            self.to.fill(f"{place}[i]", value, length)
            return
        rows, cols = shape
        self.to.loop("i", 0, rows)
        self.to.loop("j", 0, cols)
        value = self.at(operand, "i", "j")
        self.to.set(entry(place, ("i", str(cols)), ("j", "1")), value)
        self.to.end()
        self.to.end()
