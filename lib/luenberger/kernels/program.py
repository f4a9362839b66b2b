"""A lowered stage list: what every printer reads.  No SymPy, no NumPy."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from fractions import Fraction
from typing import Any

IDENTITY = "I"

Size = Any  # a number, or the text of one that is not known yet
Shape = tuple[Size, Size]
Sizes = Mapping[str, Size]
Known = Mapping[str, Sequence[Sequence[float | None]]]  # entries of given matrices


@dataclass(frozen=True)
class Operand:
    """A matrix by name, or its transpose."""

    name: str
    turned: bool = False

    @property
    def T(self) -> Operand:
        return Operand(self.name, not self.turned)


@dataclass(frozen=True)
class Term:
    """scale times one matrix or the product of two."""

    scale: Fraction
    factors: tuple[Operand, ...]

    @property
    def is_identity(self) -> bool:
        """Whether it is a multiple of the identity."""
        return [factor.name for factor in self.factors] == [IDENTITY]


@dataclass(frozen=True)
class Assign:
    """target = sum of terms; of a symmetric target one triangle is computed."""

    target: str
    terms: tuple[Term, ...]
    symmetric: bool = False
    equation: str = ""


@dataclass(frozen=True)
class Factor:
    """matrix = L d L', each pivot above tol times its diagonal entry, or give up.

    With `beside`, tol times the sum of that entry and `part` of the one of the matrix
    `beside`, or of that vector.
    With `known`, a row of zeros is passed over where that sum is zero too: what it
    belongs to is known exactly.
    """

    matrix: str
    tol: float
    beside: str = ""
    known: bool = False
    part: float = 1.0

    def unit(self, entry: str, beside: str) -> str:
        """What a pivot is judged by, from its diagonal entry and what is beside it."""
        if not beside:
            return entry
        part = "" if self.part == 1 else f"{self.part!r} * "
        return f"({entry} + {part}{beside})"


@dataclass(frozen=True)
class Substitute:
    """target M = right, through the factor of M."""

    target: str
    right: Operand
    matrix: str
    equation: str = ""


@dataclass(frozen=True)
class Roots:
    """target = roots of the variances of a matrix times `part`, or give up.

    It gives up where an entry is larger than the product of its two roots.
    """

    target: str
    matrix: str
    part: float

    def root(self, variance: str) -> str:
        return f"{self.part!r} * sqrt({variance})"

    def condition(self, entry: str, one: str, other: str) -> str:
        return f"fabs({entry}) <= {one} * {other}"


@dataclass(frozen=True)
class Magnitudes:
    """target = entries of a matrix without their signs."""

    target: str
    matrix: str

    def of(self, entry: str) -> str:
        return f"fabs({entry})"


@dataclass(frozen=True)
class Squares:
    """target = squares of the entries of a matrix."""

    target: str
    matrix: str

    def of(self, entry: str) -> str:
        return f"{entry} * {entry}"


@dataclass(frozen=True)
class Variances:
    """target = the diagonal of a matrix, as a vector."""

    target: str
    matrix: str


@dataclass(frozen=True)
class Within:
    """Variances of a matrix that are `least`, and `part` of squared sizes, or give up.

    Where the size in `by` is zero nothing is asked.
    """

    matrix: str
    by: str
    part: float
    least: float

    def condition(self, variance: str, size: str) -> str:
        squares = f"{self.part!r} * {size} * {size}"
        enough = f"({variance} >= {self.least!r}) && ({squares} <= {variance})"
        return f"({size} == 0.0) || ({enough})"


Guard = Roots | Magnitudes | Squares | Variances | Within
GUARDS = (Roots, Magnitudes, Squares, Variances, Within)
Step = Assign | Factor | Substitute | Guard


@dataclass(frozen=True)
class Cost:
    """What one pass takes.

    Attributes
    ----------
    operations : int
        Additions, multiplications, divisions and comparisons.
    constants : int
        Numbers that are kept for good, in tables or in the code.
    stack : int
        Numbers that are kept for the time of the pass.
    terms : int
        Products and names that sums add up: multiply-adds, where nothing is divided.
    """

    operations: int = 0
    constants: int = 0
    stack: int = 0
    terms: int = 0

    def __add__(self, other: Cost) -> Cost:
        return Cost(
            self.operations + other.operations,
            self.constants + other.constants,
            self.stack + other.stack,
            self.terms + other.terms,
        )


@dataclass(frozen=True)
class Program:
    """What printers print.

    Attributes
    ----------
    given : tuple of str
        Matrices that the steps read, in the derivation's order.
    shapes : dict of str to (rows, cols)
        Of every matrix; a size is a name or a number.
    steps : tuple of Assign, Factor or Substitute
    results : dict of str to Operand or None
        Where each output is found; None if it is zero.
    symmetric : frozenset of str
        Matrices of which one triangle says all.
    definite : tuple of Factor
        Of results that must be positive definite, or the step gives up.
    """

    given: tuple[str, ...]
    shapes: dict[str, Shape]
    steps: tuple[Step, ...]
    results: dict[str, Operand | None]
    symmetric: frozenset[str]
    definite: tuple[Factor, ...] = ()

    def shape(self, name: str, sizes: Mapping[str, Any]) -> tuple[Any, Any]:
        """The shape of a matrix as numbers."""
        rows, cols = self.shapes[name]
        return sizes.get(rows, rows), sizes.get(cols, cols)

    def parted(self) -> tuple[Program, Program]:
        """The steps that results need, and those that only tests of them read."""
        beside = {one.beside for one in self.definite}
        wanted = {op.name for k, op in self.results.items() if op and k not in beside}
        some: list[Step] = []
        for step in reversed(self.steps):
            if isinstance(step, Factor | Variances) or made(step) in wanted:
                some.append(step)
                wanted |= reads(step)
        rest = tuple(step for step in self.steps if step not in some)
        return replace(self, steps=tuple(some[::-1])), replace(self, steps=rest)

    def cost(self, sizes: Sizes, known: Known | None = None) -> Cost:
        """The `Cost` of one pass on a device, as scalars or as loops.

        Parameters
        ----------
        sizes : dict of str to int
        known : dict of str to nested sequence, optional
            Given matrices that never change: zeros and ones in them cost nothing
            where the pass is short enough to be written as scalars.
        """
        from . import cost

        straight = cost.straight(self, sizes, known)
        return cost.loops(self, sizes, known) if straight is None else straight.cost


def times(rows: Size, cols: Size) -> Size:
    """How many entries a matrix has; sizes are numbers, or the text of some."""
    if isinstance(rows, int) and isinstance(cols, int):
        return rows * cols
    return " * ".join(str(size) for size in (rows, cols) if size != 1)


def made(step: Step) -> str | None:
    """The name of the matrix that a step computes, if it does."""
    return None if isinstance(step, Factor | Within) else step.target


def reads(step: Step) -> set[str]:
    """Names of the matrices that a step reads."""
    if isinstance(step, Within):
        return {step.matrix, step.by}
    if isinstance(step, Factor):
        return {step.matrix, step.beside} - {""}
    if isinstance(step, Roots | Magnitudes | Squares | Variances):
        return {step.matrix}
    if isinstance(step, Substitute):
        return {step.right.name, step.matrix}
    return {op.name for term in step.terms for op in term.factors} - {IDENTITY}
