"""Sums of products, some rows at a time, as loops that numba makes vector code of.

Of each entry of a right factor that is read, a product is added to every row of a
band.  So there are several additions for a number that is loaded, and they need not
wait for each other.  The loop over the inner product has few turns, and their number
is written out: LLVM unrolls it before it turns the loop along the row into vectors.
"""

from collections.abc import Sequence

from .program import Assign, Operand, Program, Size, Sizes, Term
from .writer import Writer

HIGH = 4  # rows of a band
SHORT_SUM = 16  # factors of an inner product that LLVM unrolls

Index = int | str  # of a row or column: a number, or what loops call it
Terms = Sequence[tuple[int, Term]]  # with their numbers in the sum


class Bands:
    """Writes a sum in bands; the rest of the writing is `loops`."""

    program: Program
    sizes: Sizes
    to: Writer

    def at(self, name: str, i: Index, j: Index) -> str:
        """The entry (i, j) of a matrix."""
        raise NotImplementedError

    def of(self, operand: Operand, i: Index, j: Index) -> str:
        """The same of an operand."""
        raise NotImplementedError

    def right(self, step: Assign, term: Term, k: Index) -> str:
        """The entry (k, j) of the right factor of a product."""
        raise NotImplementedError

    def sum(self, terms: Sequence[Term], i: Index = "i") -> str:
        """The entry (i, j) of a sum of matrices."""
        raise NotImplementedError

    def add(self, target: str, term: Term, product: str) -> None:
        """Add a product to a scalar, with the factor of its term."""
        raise NotImplementedError

    def width(self, term: Term) -> Size:
        """How many factors an inner product has."""
        raise NotImplementedError

    def in_bands(self, step: Assign, small: Terms) -> bool:
        """Whether a sum is written in bands, with these of its products."""
        rows, cols = self.program.shape(step.target, self.sizes)
        widths = [self.width(term) for _, term in small]
        known = all(isinstance(size, int) for size in (rows, cols, *widths))
        if not (self.to.bands and small and known) or rows == 1 or cols == 1:
            return False
        return max(widths) <= SHORT_SUM

    def add_in_bands(self, step: Assign, small: Terms) -> None:
        """The sum, band by band; of a symmetric one at least what is on the right."""
        rows, _ = self.program.shape(step.target, self.sizes)
        whole = rows // HIGH
        if whole:
            self.to.loop("b", 0, whole)
            self.to.index("i", f"b * {HIGH}")
            self.band(step, small, HIGH)
            self.to.end()
        if rows > whole * HIGH:
            self.to.index("i", f"{whole * HIGH}")
            self.band(step, small, rows - whole * HIGH)

    def band(self, step: Assign, small: Terms, high: int) -> None:
        """The rows from i on, so many."""
        to = self.to
        _, cols = self.program.shape(step.target, self.sizes)
        single = [t for t in step.terms if len(t.factors) == 1 and not t.is_identity]
        rows = [f"(i + {r})" if r else "i" for r in range(high)]
        to.loop("j", "i" if step.symmetric and cols > SHORT_SUM else 0, cols)
        for r, i in enumerate(rows):
            to.let(f"s{r}", self.sum(single, i))
        for _, term in small:
            to.loop("k", 0, self.width(term))
            to.let("q", self.right(step, term, "k"))
            for r, i in enumerate(rows):
                self.add(f"s{r}", term, f"{self.of(term.factors[0], i, 'k')} * q")
            to.end()
        for r, i in enumerate(rows):
            to.set(self.at(step.target, i, "j"), f"s{r}")
        to.end()
