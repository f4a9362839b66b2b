"""Sums of products and solves, written as calls of `products`: matrices by rows.

The right factor of a product is read along its rows.  Where it is a transpose, that
is copied first.  A matrix is factored a few rows at a time: the rows above are taken
off as a product, and then each of the few by itself.
"""

from collections.abc import Iterator, Sequence
from fractions import Fraction

from .products import HEIGHT, WIDTHS
from .program import (
    IDENTITY,
    Assign,
    Factor,
    Operand,
    Program,
    Size,
    Sizes,
    Substitute,
    Term,
)
from .writer import Writer, bounds, entry

BLOCK = 4  # rows that are eliminated together
ALONE = 8  # rows up to which each is eliminated alone

Index = int | str  # of a row or column: a number, or what loops call it
Terms = Sequence[tuple[int, Term]]  # with their numbers in the sum
Place = tuple[str, str, int]  # an array, where a matrix begins, and from row to row


def runs(rows: int, most: int) -> list[tuple[int, int, int]]:
    """(first row, row after the last, height) of runs of panels of one height."""
    height, taller = divmod(rows, -(-rows // most))
    middle = taller * (height + 1)
    found = [(0, middle, height + 1), (middle, rows, height)]
    return [run for run in found if run[0] < run[1]]


def blocks(size: int) -> list[tuple[int, int, int]]:
    """(first row, how many, height) of blocks of rows; the last may be lower."""
    if size <= ALONE:
        return [(0, 1, size)]
    whole = size // BLOCK
    found = [(0, whole, BLOCK), (whole * BLOCK, 1, size - whole * BLOCK)]
    return [one for one in found if one[1] and one[2]]


class Tiles:
    """Writes sums and solves as calls; the rest of the writing is `loops`."""

    program: Program
    sizes: Sizes
    to: Writer
    turned: set[str]

    def at(self, name: str, i: Index, j: Index) -> str:
        """The entry (i, j) of a matrix."""
        raise NotImplementedError

    def sum(self, terms: Sequence[Term], i: Index = "i") -> str:
        """The entry (i, j) of a sum of matrices."""
        raise NotImplementedError

    def turn(self, name: str) -> None:
        """Write the transpose of a matrix into an array, once."""
        raise NotImplementedError

    def size(self, name: str) -> tuple[int, int]:
        rows, cols = self.program.shape(name, self.sizes)
        return int(rows), int(cols)

    # sums of products

    def in_tiles(self, step: Assign, products: Terms) -> bool:
        """Whether a sum is written so, with these of its products."""
        if not (self.to.tiles and products):
            return False
        rows, cols = self.size(step.target)
        even = all(t.factors[0].name in self.program.symmetric for _, t in products)
        return rows > 1 and (cols > 1 or even)

    def tile_arrays(self, step: Assign) -> dict[str, int]:
        """Lengths of the arrays that such a sum takes beside its target."""
        rows, cols = self.size(step.target)
        products = [k for k, t in enumerate(step.terms) if len(t.factors) == 2]
        names = [f"{step.target}_b{k}" for k in products[:-1]]
        if self.alone(self.singles(step)) is None and self.singles(step):
            names.append(f"{step.target}_b")
        return dict.fromkeys(names, rows * cols)

    def singles(self, step: Assign) -> list[Term]:
        """The terms that are no products."""
        return [t for t in step.terms if len(t.factors) == 1 and not t.is_identity]

    def alone(self, singles: Sequence[Term]) -> str | None:
        """The one matrix that products are added to, where it is there by rows."""
        if len(singles) != 1 or singles[0].scale != 1 or singles[0].factors[0].turned:
            return None
        return singles[0].factors[0].name

    def add_in_tiles(self, step: Assign, products: Terms) -> None:
        """The sum, product by product; of a symmetric one at least the right half."""
        singles = self.singles(step)
        start = self.alone(singles)
        if singles and start is None:
            start = f"{step.target}_b"
            rows, cols = self.size(step.target)
            self.to.loop("i", 0, rows)
            self.to.loop("j", 0, cols)
            self.to.set(entry(start, ("i", cols), ("j", 1)), self.sum(singles))
            self.to.end()
            self.to.end()
        for k, term in products:
            last = k == products[-1][0]
            target = step.target if last else f"{step.target}_b{k}"
            self.add_product_in_tiles(step, target, start, term)
            start = target

    def add_product_in_tiles(
        self, step: Assign, target: str, start: str | None, term: Term
    ) -> None:
        """target = start + a product, a run of panels a call."""
        rows, cols = self.size(step.target)
        left, right = term.factors
        if cols == 1:  # of a symmetric matrix: as a row
            left, right, rows, cols = right.T, Operand(left.name), 1, rows
        inner, stride = self.size(left.name)
        down, along = (1, stride) if left.turned else (stride, 1)
        inner = inner if left.turned else stride
        for first, last, height in runs(rows, HEIGHT):
            most = max(cols - WIDTHS[0], 0) if step.symmetric else 0
            skip = min(first, most)
            at = str(first * cols + skip)
            self.call(
                height, (target, at, cols), (start, at, cols) if start else None,
                (left.name, str(first * down), down, along),
                (self.by_rows(right), str(skip), cols),
                counts=((last - first) // height, cols - skip, inner, most - skip),
                scale=term.scale,
            )  # fmt: skip

    def by_rows(self, operand: Operand) -> str:
        """The array of an operand's rows; a vector is the same either way."""
        if operand.turned and 1 not in self.size(operand.name):
            return f"{operand.name}_T"
        return operand.name

    def call(
        self,
        height: int,
        D: Place,
        C: Place | None,
        A: tuple[str, str, int, int],
        B: Place,
        counts: tuple[Index, Index, Index, Index],
        scale: Fraction | int = -1,
    ) -> None:
        """A call of `product`; counts are panels, columns, inner and most."""
        start = int(C is not None)
        given = [height, start, *counts, float(scale), *D, *(C or D), *A, *B]
        self.to.line(f"product({', '.join(map(str, given))})")

    # solves

    def arrays_in_tiles(self, step: Factor | Substitute) -> dict[str, Size]:
        """Lengths of the arrays that a factor or a substitution takes."""
        if isinstance(step, Factor):
            size, _ = self.size(step.matrix)
            M, whole = step.matrix, size * size
            return {f"{M}_u": whole, f"{M}_s": whole, f"{M}_v": size} | {
                f"{M}_x": BLOCK * size
            }
        cols, size = self.size(step.target)
        found = {f"{step.target}_{what}": cols * size for what in "usT"}
        if step.right.name == IDENTITY:
            found[f"{step.target}_r"] = cols * size
        else:
            found[self.by_rows(step.right.T)] = cols * size
        return found | {f"{step.target}_x": BLOCK * cols}

    def factor_in_tiles(self, step: Factor) -> None:
        """M = L d L': rows of u = d L' and of s = L', and v = 1 / d."""
        to, M = self.to, step.matrix
        size, _ = self.size(M)
        u, s, x = (f"{M}_{what}" for what in "usx")
        bounds(to, step, size, self.at, f"{M}_v")
        for height in self.down(size):
            if height:
                self.call(
                    height, (x, "i", size), (M, f"i * {size + 1}", size),
                    (s, "i", 1, size), (u, "i", size),
                    counts=(1, f"{size} - i", "i", 0),
                )  # fmt: skip
            rows = (x, f"(r - i) * {size} + i") if height else (M, f"r * {size} + i")
            to.loop("r", "i", f"i + {height or size}")
            self.call(
                1, (u, f"r * {size} + i", size), (*rows, size),
                (s, f"i * {size} + r", 1, size), (u, f"i * {size + 1}", size),
                counts=(1, f"{size} - i", "r - i", 0),
            )  # fmt: skip
            pivot = f"{u}[r * {size + 1}]"
            to.need(f"{pivot} > {M}_v[r]")
            inverse = to.inverse(pivot) if step.known else f"1.0 / {pivot}"
            to.set(f"{M}_v[r]", inverse)
            to.loop("j", "r", size)
            to.set(f"{s}[r * {size} + j]", f"{u}[r * {size} + j] * {M}_v[r]")
            to.end()
            to.end()
            to.end()

    def down(self, size: int) -> Iterator[int]:
        """Open loops over blocks from above; the height of one, or 0 if it is all."""
        for first, count, height in blocks(size):
            self.to.loop("b", 0, count)
            self.to.index("i", f"{first} + b * {height}")
            yield height if height < size else 0

    def substitute_in_tiles(self, step: Substitute) -> None:
        """The transpose of the target by rows, L d L' target' = right'; then itself."""
        to, target = self.to, step.target
        cols, size = self.size(target)
        self.forward(step, self.right_in_tiles(step))
        self.backward(step)
        self.turned.add(target)
        to.loop("i", 0, cols)
        to.loop("j", 0, size)
        turned = entry(self.by_rows(Operand(target, True)), ("j", cols), ("i", 1))
        to.set(self.at(target, "i", "j"), turned)
        to.end()
        to.end()

    def right_in_tiles(self, step: Substitute) -> str:
        """The array of the rows of the transposed right side."""
        if step.right.name != IDENTITY:
            right = self.by_rows(step.right.T)
            if right != step.right.name:
                self.turn(step.right.name)
            return right
        cols, size = self.size(step.target)
        name = f"{step.target}_r"
        self.to.fill(f"{name}[i]", "0.0", cols * size)
        self.to.fill(f"{name}[i * {cols + 1}]", "1.0", size)
        return name

    def forward(self, step: Substitute, right: str) -> None:
        """u = L^-1 right', and s = u / d."""
        to, M = self.to, step.matrix
        cols, size = self.size(step.target)
        u, s, x = (f"{step.target}_{what}" for what in "usx")
        for height in self.down(size):
            if height:
                self.call(
                    height, (x, "0", cols), (right, f"i * {cols}", cols),
                    (f"{M}_s", "i", 1, size), (u, "0", cols), counts=(1, cols, "i", 0),
                )  # fmt: skip
            rows = (x, f"(r - i) * {cols}") if height else (right, f"r * {cols}")
            to.loop("r", "i", f"i + {height or size}")
            self.call(
                1, (u, f"r * {cols}", cols), (*rows, cols),
                (f"{M}_s", f"i * {size} + r", 1, size), (u, f"i * {cols}", cols),
                counts=(1, cols, "r - i", 0),
            )  # fmt: skip
            to.loop("j", 0, cols)
            to.set(f"{s}[r * {cols} + j]", f"{u}[r * {cols} + j] * {M}_v[r]")
            to.end()
            to.end()
            to.end()

    def backward(self, step: Substitute) -> None:
        """L' target' = s, from below."""
        to, M, s, x = self.to, step.matrix, f"{step.target}_s", f"{step.target}_x"
        cols, size = self.size(step.target)
        found = self.by_rows(Operand(step.target, True))
        for first, count, height in reversed(blocks(size)):
            to.loop("b", 0, count)
            to.index("i", f"{first + (count - 1) * height} - b * {height}")
            to.index("e", f"i + {height}")
            if height < size:
                self.call(
                    height, (x, "0", cols), (s, f"i * {cols}", cols),
                    (f"{M}_s", f"i * {size} + e", size, 1),
                    (found, f"e * {cols}", cols), counts=(1, cols, f"{size} - e", 0),
                )  # fmt: skip
            to.loop("back", 1, height + 1)
            to.index("r", "e - back")
            rows = (x, f"(r - i) * {cols}") if height < size else (s, f"r * {cols}")
            self.call(
                1, (found, f"r * {cols}", cols), (*rows, cols),
                (f"{M}_s", f"r * {size + 1} + 1", size, 1),
                (found, f"(r + 1) * {cols}", cols), counts=(1, cols, "back - 1", 0),
            )  # fmt: skip
            to.end()
            to.end()
