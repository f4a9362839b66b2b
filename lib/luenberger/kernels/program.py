"""A lowered stage list: what every printer reads.  No SymPy, no NumPy."""

from dataclasses import dataclass, replace
from fractions import Fraction

IDENTITY = "I"


@dataclass(frozen=True)
class Operand:
    """A matrix by name, or its transpose."""

    name: str
    turned: bool = False

    @property
    def T(self):
        return replace(self, turned=not self.turned)


@dataclass(frozen=True)
class Term:
    """scale times one matrix or the product of two."""

    scale: Fraction
    factors: tuple


@dataclass(frozen=True)
class Assign:
    """target = sum of terms; of a symmetric target one triangle is computed."""

    target: str
    terms: tuple
    symmetric: bool = False
    equation: str = ""


@dataclass(frozen=True)
class Factor:
    """matrix = L d L', each pivot above tol times its diagonal entry, or give up.

    With `beside`, tol times the sum of that entry and the one of the matrix `beside`.
    """

    matrix: str
    tol: float
    beside: str = ""


@dataclass(frozen=True)
class Substitute:
    """target M = right, through the factor of M."""

    target: str
    right: Operand
    matrix: str
    equation: str = ""


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

    given: tuple
    shapes: dict
    steps: tuple
    results: dict
    symmetric: frozenset
    definite: tuple = ()

    def shape(self, name, sizes):
        """The shape of a matrix as numbers."""
        rows, cols = self.shapes[name]
        return sizes.get(rows, rows), sizes.get(cols, cols)

    def work(self, sizes):
        """Multiplications of its products at `sizes`, no zeros left out."""
        total = 0
        for step in self.steps:
            if isinstance(step, Factor):
                total += self.shape(step.matrix, sizes)[0] ** 3 // 6
                continue
            rows, cols = self.shape(step.target, sizes)
            if isinstance(step, Substitute):
                total += rows * cols * cols
                continue
            for term in step.terms:
                left = (
                    self.shape(term.factors[0].name, sizes) if term.factors[1:] else ()
                )
                inner = left and left[not term.factors[0].turned]
                total += rows * cols * (inner or 0) // (1 + step.symmetric)
        return total


def reads(step):
    """Names of the matrices that a step reads."""
    if isinstance(step, Factor):
        return {step.matrix}
    if isinstance(step, Substitute):
        return {step.right.name, step.matrix}
    return {op.name for term in step.terms for op in term.factors} - {IDENTITY}
