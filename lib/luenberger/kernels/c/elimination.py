"""Factors L d L' and what is solved with them, a panel of rows at a time.

The rows above a panel are taken off it as a product; the rest is done on the panel
alone.  The first panel has no rows above it, and the last none below.
"""

from __future__ import annotations

from fractions import Fraction

from ..program import IDENTITY, Factor, Operand, Substitute
from ..writer import bounds
from .panels import entry, pointer, runs
from .store import Store

BLOCK = 4  # rows that are eliminated at once, at most
ONE = Fraction(1)


def parts(size: int, backwards: bool = False) -> list[tuple[int, int, int]]:
    """Runs of panels that are eliminated; the first of all, or the last, is alone."""
    found = runs(size, BLOCK)
    first, last, height = found.pop(-1 if backwards else 0)
    if backwards:
        alone, others = (last - height, last, height), (first, last - height, height)
        found = [alone, others, *reversed(found)]
    else:
        found = [(first, height, height), (height, last, height), *found]
    return [run for run in found if run[0] < run[1]]


class Elimination:
    """Writes factors and substitutions; the arrays of a factor are named after it."""

    def __init__(self, store: Store) -> None:
        self.store, self.program, self.to = store, store.program, store.to
        self.panels, self.layouts = store.panels, store.layouts

    def factor(self, step: Factor) -> None:
        """M = L d L': u = d L' and s = L' by rows; l and v = 1 / d by panels."""
        M, to, store = step.matrix, self.to, self.store
        size, _ = self.program.shape(M, store.sizes)
        m, row = store.strides(Operand(M))[0], store.line(size)
        for what in ("u", "s"):
            store.block(f"{M}_{what}", size, size)
        for what in ("l", "v", "least")[size == 1 :]:
            store.vector(f"{M}_{what}", size * (BLOCK if what == "l" else 1))
        bounds(to, step, size, lambda X, i, j: store.at(Operand(X), i, j), f"{M}_least")
        self.store.count(size * (bool(step.tol) + bool(step.tol and step.beside)))
        for first, last, height in parts(size):
            to.panels("i", first, last, height)
            j, width = "0", row  # where a row begins, and what is left of it
            if size > 1:
                j, width = "j", f"{row} - j"
                to.index(j, f"i - i % {self.panels.rows.lanes}")
            x = pointer(m, ("i", row))
            at = ("i", row), (j, "1")
            if first:
                x = store.block("panel", height, size)
                less = self.less(height, ("1", row), row, row, row)
                self.call(less, width, "i", f"{M}_s + i", f"{M}_u + j",
                          pointer(m, *at), f"{x} + j")  # fmt: skip
            pivots = self.panels.pivots(height, row, step.known)
            given = f"{x} + i", f"{M}_least + i", *self.rim(M, height)
            to.need_call(pivots, given)
            forward = self.panels.forward(height, row, row)
            ahead = pointer(x, (j, "1")), *self.rim(M, height)
            made = pointer(f"{M}_u", *at), pointer(f"{M}_s", *at)
            self.call(forward, width, *ahead, *made)
            to.end()
            for i in range(first, last, height):
                self.count_panel(height, size - i, i)
                inside = sum(2 * r * (height - r) for r in range(height))
                self.store.count(inside + 2 * height + height * (height - 1) // 2)

    def call(self, what: str, *given: str) -> None:
        self.to.call(what, given)

    def rim(self, M: str, height: int) -> list[str]:
        """What a panel needs of its own block: L below the diagonal, and 1 / d."""
        return [f"{M}_l + i * {BLOCK}"] * (height > 1) + [f"{M}_v + i"]

    def less(self, height: int, a: tuple[str, str], b: str, c: str, d: str) -> str:
        return self.panels.product(height, -ONE, a, b, c, d)

    def count_panel(self, height: int, columns: int, above: int) -> None:
        """What the rows above take, and the panel by itself."""
        self.store.count(columns * height * (2 * above + height))

    def substitute(self, step: Substitute) -> None:
        """The transpose of the target by rows: L d L' target' = right'."""
        M, store = step.matrix, self.store
        size, _ = self.program.shape(M, store.sizes)
        target = Operand(step.target, True)
        _, cols = self.layouts.shape(target)
        x, x_row = self.right(step, size, cols)
        names = (f"{step.target}_{what}" for what in ("down", "scaled"))
        u, s = (store.block(name, size, cols) for name in names)
        d = store.declare(target)
        for run in parts(size):
            self.forward(M, run, cols, (x, x_row), u, s)
        for run in parts(size, backwards=True):
            self.backward(M, size, run, cols, s, d)

    def forward(
        self,
        M: str,
        run: tuple[int, int, int],
        cols: int,
        right: tuple[str, str],
        u: str,
        s: str,
    ) -> None:
        """u = L^-1 right and s = u / d in a run of panels, from above."""
        to, (first, last, height), (x, x_row) = self.to, run, right
        m_row, row = self.store.line(self.size(M)), self.store.line(cols)
        width = self.store.width(self.size(M), cols)
        right_at = pointer(x, ("i", x_row))
        to.panels("i", first, last, height)
        if first:
            x, x_row = self.store.block("panel", height, cols), row
            less = self.less(height, ("1", m_row), row, right[1], row)
            self.call(less, width, "i", f"{M}_s + i", u, right_at, x)
        forward = self.panels.forward(height, x_row, row)
        given = x if first else right_at
        made = pointer(u, ("i", row)), pointer(s, ("i", row))
        self.call(forward, width, given, *self.rim(M, height), *made)
        to.end()
        for i in range(first, last, height):
            self.count_panel(height, cols, i)

    def backward(
        self, M: str, size: int, run: tuple[int, int, int], cols: int, s: str, d: str
    ) -> None:
        """d = L'^-1 s in a run of panels, from below."""
        to, (first, last, height) = self.to, run
        m_row, row = self.store.line(size), self.store.line(cols)
        width = self.store.width(size, cols)
        to.panels("above", first, last, height)
        low = last - height + first
        to.index("i", f"{low} - above" if low else "above")  # 0: one panel
        x = right = pointer(s, ("i", row))
        if last < size:
            x = self.store.block("panel", height, cols)
            to.index("k", f"i + {height}")
            less = self.less(height, (m_row, "1"), row, row, row)
            self.call(less, width, f"{size} - k", f"{M}_s + i * {m_row} + k",
                      pointer(d, ("k", row)), right, x)  # fmt: skip
        backward = self.panels.backward(height, row, row)
        self.call(backward, width, x, *self.rim(M, height)[:-1], pointer(d, ("i", row)))
        to.end()
        for i in range(first, last, height):
            rest = size - i - height
            self.store.count(cols * height * (2 * rest + height - 1))

    def size(self, M: str) -> int:
        return self.program.shape(M, self.store.sizes)[0]

    def right(self, step: Substitute, size: int, cols: int) -> tuple[str, str]:
        """The right side's transpose, by rows."""
        if step.right.name != IDENTITY:
            return self.store.in_rows(step.right.T)
        row = self.store.line(cols)
        name = self.store.block(f"{step.target}_x", size, cols)
        self.to.loop("i", 0, size)
        self.to.loop("j", 0, row)
        self.to.set(entry(name, ("i", row), ("j", "1")), "i == j ? 1.0 : 0.0")
        self.to.end()
        self.to.end()
        return name, row
