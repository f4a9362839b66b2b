"""A program as loops over panels of rows: what exported C is where it is not scalars.

A product is a few rows of its target at a time.  A matrix is factored, and what is
solved with it eliminated, a few rows at a time as well: the rows above are taken off
as a product, and the rest is done on the panel alone.
"""

from __future__ import annotations

from collections.abc import Callable, Collection, Sequence

from ..loops import Places
from ..passes import Results
from ..program import (
    GUARDS,
    Assign,
    Cost,
    Factor,
    Operand,
    Program,
    Sizes,
    Substitute,
    Term,
    reads,
)
from . import guards
from .elimination import Elimination
from .panels import Panels, pointer, runs
from .store import Store
from .writer import C

HEIGHT = 10  # rows of a product that are added up at once, at most
HALF = 10  # the same of a symmetric one, of which half is computed


def fits(program: Program, sizes: Sizes) -> bool:
    """Whether there is a matrix to compute, and every size is known and not zero."""
    whole, large = True, False
    for name in program.shapes:
        rows, cols = program.shape(name, sizes)
        whole &= isinstance(rows, int) and isinstance(cols, int) and rows * cols > 0
        large |= name not in program.given and 1 not in (rows, cols)
    return whole and large


def write(
    program: Program,
    sizes: Sizes,
    to: C,
    panels: Panels,
    constants: Collection[str],
    places: Places,
    results: Results,
) -> Cost:
    """Write one pass, see `passes.write_pass`; `constants` are given as tables."""
    store = Store(program, sizes, to, panels, constants, places)
    work, solves = _Rows(store), Elimination(store)
    for k, step in enumerate(program.steps):
        if equation := getattr(step, "equation", ""):
            to.line(f"{to.comment} {equation}")
        if isinstance(step, Assign):
            work.assign(step, _is_read(program, step.target, k))
        elif isinstance(step, Factor):
            solves.factor(step)
        elif isinstance(step, GUARDS):
            guards.write(step, store)
        else:
            solves.substitute(step)
    for one in program.definite:
        solves.factor(one)
    for name, (place, length) in results.items():
        store.result(program.results[name], place, int(length))
    return store.cost


def _is_read(program: Program, name: str, k: int) -> bool:
    """Whether more than a triangle of a matrix is read after step k."""
    later = [one for one in program.steps[k + 1 :] if not isinstance(one, Factor)]
    read = {name for one in later if isinstance(one, Assign) for name in reads(one)}
    read |= {one.right.name for one in later if isinstance(one, Substitute)}
    read |= {op.name for op in program.results.values() if op is not None}
    return name in read


class _Rows:
    def __init__(self, store: Store) -> None:
        self.store, self.program, self.to = store, store.program, store.to
        self.panels, self.layouts = store.panels, store.layouts

    # sums of products

    def assign(self, step: Assign, read: bool) -> None:
        """target, or its transpose, as its terms say."""
        terms = self.layouts.terms(step)
        products = [term for term in terms if len(term.factors) == 2]
        singles = [
            term for term in terms if len(term.factors) == 1 and not term.is_identity
        ]
        lefts = [(term, *self.store.in_rows(term.factors[1])) for term in products]
        start = self.start(singles) if products else None
        target = Operand(step.target, step.target in self.layouts.turned)
        rows, cols = self.layouts.shape(target)
        if step.symmetric and rows > 1:
            target = Operand(step.target)
        self.store.declare(target)
        if not products or (singles and start is None):
            self.sum(step, target, singles)
        for k, (term, array, stride) in enumerate(lefts):
            in_place = k > 0 or bool(singles and start is None)
            self.product(step, target, term, (array, stride), start if not k else None,
                         in_place)  # fmt: skip
        if step.symmetric and rows > 1 and read:
            self.mirror(target, rows)
        for term in terms:
            if term.is_identity:
                self.identity(target, term, rows)

    def start(self, singles: Sequence[Term]) -> Operand | None:
        """The one matrix that products are added to, if it can be read by rows."""
        if len(singles) != 1 or singles[0].scale != 1:
            return None
        (operand,) = singles[0].factors
        by_rows = 1 in self.layouts.shape(operand)
        return operand if by_rows or self.store.strides(operand)[2] == "1" else None

    def sum(self, step: Assign, target: Operand, singles: Sequence[Term]) -> None:
        """The terms that are no products, entry by entry."""
        rows, cols = self.layouts.shape(target)
        text = ""
        for term in sorted(singles, key=lambda term: term.scale < 0):
            value, size = self.store.at(term.factors[0], "i", "j"), abs(term.scale)
            value = value if size == 1 else f"{float(size)!r} * {value}"
            self.store.count(rows * cols * ((size != 1) + bool(text)))
            sign = "-" if term.scale < 0 else "+" if text else ""
            text += f" {sign} {value}" if text else f"{sign}{value}"
        self.to.loop("i", 0, rows)
        self.to.loop("j", 0, cols)
        self.to.set(self.store.at(target, "i", "j"), text or "0.0")
        self.to.end()
        if rows > 1 and cols > 1:
            self.store.pad(self.store.strides(target)[0], cols)
        self.to.end()

    def product(
        self,
        step: Assign,
        target: Operand,
        term: Term,
        right: tuple[str, str],
        start: Operand | None,
        in_place: bool,
    ) -> None:
        """Add a product to the target, panel by panel."""
        rows, cols = self.layouts.shape(target)
        array, stride = right
        a, down, along = self.store.strides(term.factors[0])
        d, d_row, _ = self.store.strides(target)
        c, c_row, _ = self.store.strides(start) if start else ("", "", "")
        inner = self.layouts.shape(term.factors[0])[1]
        half = step.symmetric and rows > 1
        width = self.store.width(min(rows, inner), cols)
        if inner == 1 < rows and cols > 1 and not in_place:
            self.store.pad_all(d, rows, cols)
        for first, last, height in runs(rows, HALF if half else HEIGHT):
            what = self.panels.product(
                height, term.scale, (down, along), stride,
                c_row if start else None, d_row, in_place,
            )  # fmt: skip

            def call(i: str, j: str, columns: str) -> None:
                given = [columns, str(inner), pointer(a, (i, down))]  # noqa: B023
                given.append(pointer(array, (j, "1")))  # noqa: B023
                if start:
                    given.append(pointer(c, (i, c_row), (j, "1")))
                given.append(pointer(d, (i, d_row), (j, "1")))
                self.to.call(what, given)  # noqa: B023

            self.each(first, last, height, width, half, call)
            for i in range(first, last, height):
                scaled = abs(term.scale) != 1
                entries = cols - i if half else cols
                self.store.count(entries * inner * (2 * height + scaled))

    def each(
        self,
        first: int,
        last: int,
        height: int,
        width: str,
        half: bool,
        call: Callable[[str, str, str], None],
    ) -> None:
        """A call for each panel: its first row, its first column and its width."""
        to = self.to
        if last - first == height and not (half and first):
            call(str(first), "0", width)
            return
        to.panels("i", first, last, height)
        if half:
            to.index("j", f"i - i % {self.panels.rows.lanes}")
        call("i", "j" if half else "0", f"{width} - j" if half else width)
        to.end()

    def mirror(self, target: Operand, rows: int) -> None:
        """The left triangle of a symmetric matrix is the right one."""
        self.to.loop("i", 1, rows)
        self.to.loop("j", 0, "i")
        at = self.store.at
        # the triangle was written by a function, through a pointer into the array
        self.to.line("/* cppcheck-suppress uninitvar */")
        self.to.set(at(target, "i", "j"), at(target, "j", "i"))
        self.to.end()
        self.to.end()

    def identity(self, target: Operand, term: Term, rows: int) -> None:
        sign = "-=" if term.scale < 0 else "+="
        self.to.loop("i", 0, rows)
        number = repr(float(abs(term.scale)))
        self.to.set(self.store.at(target, "i", "i"), number, sign)
        self.to.end()
        self.store.count(rows)
