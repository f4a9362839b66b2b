"""Factors L d L' and substitution through them, as loops or, when small, as scalars."""

from .program import Factor, Operand, Size, Substitute, times
from .tiles import Index, Tiles
from .writer import bounds

SHORT_SOLVE = 6  # a factor this small is written as scalars
TILED_SOLVE = 6  # the same where sums are written in tiles


class Solves(Tiles):
    """Writes `Factor` and `Substitute`; the rest of the writing is `loops`."""

    def of(self, operand: Operand, i: Index, j: Index) -> str:
        """The same of an operand."""
        raise NotImplementedError

    def factor_short(self, step: Factor) -> None:
        """The factor of a small M as scalars: L, and 1 / d as {M}_i0, {M}_i1, ..."""
        to, M = self.to, step.matrix
        for i in range(self.program.shape(M, self.sizes)[0]):
            for j in range(i):  # L d, and L
                rest = "".join(f" - {M}_a{i}_{k} * {M}_l{j}_{k}" for k in range(j))
                to.let(f"{M}_a{i}_{j}", self.at(M, i, j) + rest)
                to.let(f"{M}_l{i}_{j}", f"{M}_a{i}_{j} * {M}_i{j}")
            rest = "".join(f" - {M}_a{i}_{k} * {M}_l{i}_{k}" for k in range(i))
            to.let(f"{M}_d{i}", self.at(M, i, i) + rest)
            beside = self.at(step.beside, i, i) if step.beside else ""
            to.need(f"{M}_d{i} > {step.tol!r} * {step.unit(self.at(M, i, i), beside)}")
            to.let(f"{M}_i{i}", f"1.0 / {M}_d{i}")

    def substitute_short(self, step: Substitute) -> None:
        """target L d L' = right, row by row, a row as scalars."""
        to, M, target = self.to, step.matrix, step.target
        rows, size = self.program.shape(target, self.sizes)
        to.loop("i", 0, rows)
        for j in range(size):
            rest = "".join(f" - {M}_l{j}_{k} * f{k}" for k in range(j))
            to.let(f"f{j}", self.of(step.right, "i", j) + rest)
        for j in reversed(range(size)):
            rest = (f" - {M}_l{k}_{j} * g{k}" for k in range(j + 1, size))
            to.let(f"g{j}", f"f{j} * {M}_i{j}" + "".join(rest))
            to.set(self.at(target, "i", j), f"g{j}")
        to.end()

    def is_short(self, M: str) -> bool:
        size, _ = self.program.shape(M, self.sizes)
        most = TILED_SOLVE if self.to.tiles else SHORT_SOLVE
        return isinstance(size, int) and size <= most

    def solve_arrays(self, step: Factor | Substitute) -> dict[str, Size]:
        """Lengths of the arrays that a factor or a substitution takes."""
        if self.to.tiles:
            return self.arrays_in_tiles(step)
        if isinstance(step, Substitute):
            return {}
        rows, cols = self.program.shape(step.matrix, self.sizes)
        return {f"{step.matrix}_l": times(rows, cols), f"{step.matrix}_least": rows}

    def factor_of(self, step: Factor) -> None:
        """A factor that is solved with, in the form that suits its size."""
        (self.factor_short if self.is_short(step.matrix) else self.test_of)(step)

    def substitution(self, step: Substitute) -> None:
        """What is solved with it, in the same form."""
        if self.is_short(step.matrix):
            self.substitute_short(step)
        elif self.to.tiles:
            self.substitute_in_tiles(step)
        else:
            self.substitute(step)

    def test_of(self, step: Factor) -> None:
        """A factor in arrays."""
        (self.factor_in_tiles if self.to.tiles else self.factor)(step)

    def factor(self, step: Factor) -> None:
        """Factor matrix = L d L' row by row, into one array.

        When row i is done, the array holds L(i, j) left of the diagonal and 1 / d(i)
        on it.  On the way there, row i holds L(i, j) d(j): it is filled from left to
        right, each entry from the rows above it.  Then each is divided by d(j), and
        its share is taken off the pivot d(i), which must stay above its bound.
        """
        to, M, name = self.to, step.matrix, f"{step.matrix}_l"
        size, _ = self.program.shape(M, self.sizes)

        def L(i: Index, j: Index) -> str:
            return f"{name}[{i} * {size} + {j}]"

        bounds(to, step, size, self.at, f"{M}_least")
        to.loop("i", 0, size)
        to.loop("j", 0, "i")  # L d in row i, column by column
        to.let("s", self.at(M, "i", "j"))
        to.loop("k", 0, "j")
        to.set("s", f"{L('i', 'k')} * {L('j', 'k')}", "-=")
        to.end()
        to.set(L("i", "j"), "s")
        to.end()
        to.let("s", self.at(M, "i", "i"))
        to.loop("k", 0, "i")  # divide by d, and take the row off the pivot
        to.let("q", f"{L('i', 'k')} * {L('k', 'k')}")
        to.set("s", f"{L('i', 'k')} * q", "-=")
        to.set(L("i", "k"), "q")
        to.end()
        to.need(f"s > {M}_least[i]")
        to.set(L("i", "i"), to.inverse("s") if step.known else "1.0 / s")
        to.end()

    def substitute(self, step: Substitute) -> None:
        """target L d L' = right, row by row."""
        to, name, target = self.to, f"{step.matrix}_l", step.target
        rows, size = self.program.shape(target, self.sizes)

        def L(i: Index, j: Index) -> str:
            return f"{name}[{i} * {size} + {j}]"

        to.loop("i", 0, rows)
        to.loop("j", 0, size)
        to.let("s", self.of(step.right, "i", "j"))
        to.loop("k", 0, "j")
        to.set("s", f"{L('j', 'k')} * {self.at(target, 'i', 'k')}", "-=")
        to.end()
        to.set(self.at(target, "i", "j"), "s")
        to.end()
        to.loop("j", 0, size)
        to.set(self.at(target, "i", "j"), L("j", "j"), "*=")
        to.end()
        to.loop("back", 1, size)
        last = size - 1 if isinstance(size, int) else f"{size} - 1"
        to.index("j", f"{last} - back")
        to.let("s", self.at(target, "i", "j"))
        to.loop("k", "j + 1", size)
        to.set("s", f"{L('k', 'j')} * {self.at(target, 'i', 'k')}", "-=")
        to.end()
        to.set(self.at(target, "i", "j"), "s")
        to.end()
        to.end()
