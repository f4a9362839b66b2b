"""A pass written out as scalars: its statements, and what its entries are called."""

from dataclasses import dataclass
from typing import Any

from .fused import Sums
from .program import Cost

Entry = Any  # a number that is known, or a name
Entries = dict[str, list[list[Entry]]]


@dataclass(frozen=True)
class Let:
    """name = text, which reads the names in `reads`.

    Of a sum, `terms` and `number` are what it adds up.
    """

    name: str
    text: str
    reads: frozenset[str]
    cost: Cost
    terms: Sums = ()
    number: float = 0.0


@dataclass(frozen=True)
class Need:
    """Give up unless the condition holds; it does not where a NaN is involved.

    With `unless`, do not give up either where all that these name is zero.
    """

    text: str
    reads: frozenset[str]
    cost: Cost
    unless: tuple[str, ...] = ()

    def but(self, either: str) -> str:
        """That something is not zero, for the end of a condition."""
        if not self.unless:
            return ""
        return f" and ({either.join(f'{name} != 0.0' for name in self.unless)})"


@dataclass(frozen=True)
class Inverse(Let):
    """name = 1 / pivot, or 0 where the pivot is zero."""

    pivot: str = ""


@dataclass(frozen=True)
class Straight:
    """Statements in order, and what each entry of each matrix is called.

    Attributes
    ----------
    statements : list of Let or Need
    entries : dict of str to list of lists
        Of each matrix; an entry is a float or a name.
    given : dict of str to list of (i, j, name)
        The entries of given matrices that are not known.
    used : set of str
        The names that the statements or the results read.
    """

    statements: list[Let | Need]
    entries: Entries
    given: dict[str, list[tuple[int, int, str]]]
    used: set[Entry]

    @property
    def cost(self) -> Cost:
        """The `Cost` of the statements; entries that they read stand on the stack."""
        read = sum(e in self.used for one in self.given.values() for *_, e in one)
        return sum((one.cost for one in self.statements), Cost(stack=read))
