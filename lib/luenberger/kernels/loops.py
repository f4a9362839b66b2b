"""Write a lowered program out as loops over arrays at frozen sizes.

Arrays are flat, row by row, so an index is written out with the size in it, and a
transpose is an index turned round.  What the loops are is the same for Python and C;
a `Writer` knows the language.
"""

import math
from collections.abc import Callable, Collection, Iterable, Mapping, Sequence
from fractions import Fraction
from itertools import pairwise
from typing import Any

from . import guards
from .program import (
    GUARDS,
    IDENTITY,
    Assign,
    Factor,
    Operand,
    Program,
    Size,
    Sizes,
    Step,
    Substitute,
    Term,
    Within,
    times,
)
from .solves import Solves
from .tiles import Index
from .writer import Writer, entry

Places = Mapping[str, str]
Terms = list[tuple[int, Term]]  # with their numbers in the sum
SHORT = 12  # factors of an inner product that are written in one line
WIDE = 16  # entries of a row from which it is added up along itself


def write(
    program: Program,
    sizes: Sizes,
    writer: Writer,
    turned: Iterable[str] = (),
    places: Places | None = None,
    after: Callable[[Fraction], None] | None = None,
) -> None:
    """Write every step of `program` at `sizes`; arrays are there, of their size.

    Of the matrices `turned` a transpose has been written before.  `places` says what
    given matrices are called, where not by their own name.  `after` is called behind
    each step, with the part of the steps that is written.
    """
    work = _Loops(program, sizes, writer, places)
    work.turned.update(turned)
    for number, step in enumerate(program.steps, 1):
        if step_tag := getattr(step, "equation", ""):
            writer.line(f"{writer.comment} {step_tag}")
        if isinstance(step, Assign):
            work.assign(step)
        elif isinstance(step, Factor):
            work.factor_of(step)
        elif isinstance(step, GUARDS):
            guards.write(step, *program.shape(step.matrix, sizes), writer)
        else:
            work.substitution(step)
        if after:
            after(Fraction(number, len(program.steps)))


def write_definite(
    program: Program, sizes: Sizes, writer: Writer, places: Places | None = None
) -> None:
    """Write the tests that results are positive definite."""
    for factor in program.definite:
        _Loops(program, sizes, writer, places).test_of(factor)


def write_turned(
    program: Program, sizes: Sizes, writer: Writer, names: Collection[str]
) -> set[str]:
    """Write the transposes that the steps need of `names`, and say which they are."""
    work = _Loops(program, sizes, writer)
    for step in program.steps:
        if not isinstance(step, Assign):
            continue
        for term in step.terms:
            if work.wants_turned(step, term) and term.factors[1].name in names:
                work.turn(term.factors[1].name)
    return work.turned


def arrays(program: Program, sizes: Sizes, writer: Writer) -> dict[str, Size]:
    """Lengths of the arrays that the steps write, factors included, by name."""
    lengths: dict[str, Size] = {}
    work = _Loops(program, sizes, writer)
    steps: tuple[Step, ...] = (*program.steps, *program.definite)
    for step in steps:
        if isinstance(step, Factor):
            rows, cols = program.shape(step.matrix, sizes)
            if step in program.definite or not work.is_short(step.matrix):
                lengths |= work.solve_arrays(step)
            continue
        if isinstance(step, Within):
            continue
        rows, cols = program.shape(step.target, sizes)
        lengths[step.target] = times(rows, cols)
        if isinstance(step, GUARDS):
            continue
        if isinstance(step, Substitute):
            if not work.is_short(step.matrix):
                lengths |= work.solve_arrays(step)
            continue
        products = [(k, t) for k, t in enumerate(step.terms) if len(t.factors) == 2]
        if work.in_tiles(step, products):
            lengths |= work.tile_arrays(step)
        for _, term in products:
            if work.wants_turned(step, term):
                name = term.factors[1].name
                lengths[f"{name}_T"] = math.prod(program.shape(name, sizes))
    return lengths


def inner_width(program: Program, sizes: Sizes, term: Term) -> Size:
    rows, cols = program.shape(term.factors[0].name, sizes)
    return rows if term.factors[0].turned else cols


def spans(width: Size, cols: Size) -> list[Any]:
    """The inner indices in the parts in which a row of products is added up.

    A part is written in one line, so that the loop along a row has one store for
    many products.  None is a loop of its own, for rows that are short.
    """
    known = isinstance(width, int) and isinstance(cols, int)
    if not known or width > SHORT and cols < WIDE or not SHORT:
        return [None]
    count = max(1, -(-width // SHORT))
    ends = [width * part // count for part in range(count + 1)]
    return [range(*two) for two in pairwise(ends)]


class _Loops(Solves):
    def __init__(
        self,
        program: Program,
        sizes: Sizes,
        writer: Writer,
        places: Places | None = None,
    ) -> None:
        self.program, self.sizes, self.to = program, sizes, writer
        self.places = places or {}
        self.turned: set[str] = set()

    def at(self, name: str, i: Index, j: Index) -> str:
        _, cols = self.program.shape(name, self.sizes)
        name = self.places.get(name, name)
        if cols == 1:
            return f"{name}[{i}]"
        return entry(name, (i, cols), (j, 1))

    def of(self, operand: Operand, i: Index, j: Index) -> str:
        if operand.name == IDENTITY:  # the right side of a solve
            return f"1.0 * ({i} == {j})"
        i, j = (j, i) if operand.turned else (i, j)
        return self.at(operand.name, i, j)

    def assign(self, step: Assign) -> None:
        products = [(k, t) for k, t in enumerate(step.terms) if len(t.factors) == 2]
        for _, term in products:
            if self.wants_turned(step, term):
                self.turn(term.factors[1].name)
        if self.in_tiles(step, products):
            self.add_in_tiles(step, products)
        else:
            self.add_up(step, products)
        self.mirror(step)

    def add_up(self, step: Assign, products: Terms) -> None:
        """The sum of the terms, row by row; of a symmetric one what is on the right."""
        to = self.to
        rows, cols = self.program.shape(step.target, self.sizes)
        single = [t for t in step.terms if len(t.factors) == 1 and not t.is_identity]
        parts = {
            k: spans(inner_width(self.program, self.sizes, t), cols)
            for k, t in products
        }
        to.loop("i", 0, rows)
        for turn in range(max(map(len, parts.values()), default=1)):
            now = [(k, t, parts[k][turn]) for k, t in products if turn < len(parts[k])]
            for k, term, span in now:
                self.load_row(k, term, span)
            to.loop("j", "i" if step.symmetric else 0, cols)
            so_far = self.at(step.target, "i", "j")
            to.let("s", so_far if turn else self.sum(single))
            for k, term, span in now:
                self.add_product(step, k, term, span)
            to.set(so_far, "s")
            to.end()
        to.end()

    def mirror(self, step: Assign) -> None:
        """The other triangle of a symmetric target, and multiples of the identity."""
        to = self.to
        rows, _ = self.program.shape(step.target, self.sizes)
        if step.symmetric:
            to.loop("i", 1, rows)
            to.loop("j", 0, "i")
            to.set(self.at(step.target, "i", "j"), self.at(step.target, "j", "i"))
            to.end()
            to.end()
        for term in step.terms:
            if term.is_identity:
                to.loop("i", 0, rows)
                to.set(self.at(step.target, "i", "i"), *_signed(term.scale, "1.0"))
                to.end()

    def wants_turned(self, step: Assign, term: Term) -> bool:
        """Whether the right factor's columns are better copied into rows first."""
        if not self.to.turns or len(term.factors) == 1:
            return False
        names = step.target, term.factors[1].name
        shapes = (self.program.shape(name, self.sizes) for name in names)
        return term.factors[1].turned and all(1 not in shape for shape in shapes)

    def turn(self, name: str) -> None:
        """Write the transpose of a matrix into an array, once."""
        if name not in self.turned:
            self.turned.add(name)
            to, (rows, cols) = self.to, self.program.shape(name, self.sizes)
            to.loop("i", 0, rows)
            to.loop("j", 0, cols)
            to.set(entry(f"{name}_T", ("j", rows), ("i", 1)), self.at(name, "i", "j"))
            to.end()
            to.end()

    def load_row(self, k: int, term: Term, span: range | None) -> None:
        """A part of row i of a left factor, into scalars."""
        for m in span or ():
            self.to.let(f"a{k}_{m}", self.of(term.factors[0], "i", m))

    def add_product(self, step: Assign, k: int, term: Term, span: range | None) -> None:
        """Add a part of the entry (i, j) of a product to s."""
        to, left = self.to, term.factors[0]
        if span is None:
            to.loop("k", 0, self.width(term))
            self.add(
                "s", term, f"{self.of(left, 'i', 'k')} * {self.right(step, term, 'k')}"
            )
            to.end()
        elif span:
            parts = (f"a{k}_{m} * {self.right(step, term, m)}" for m in span)
            to.set("s", *_signed(term.scale, " + ".join(parts), len(span) > 1))

    def add(self, target: str, term: Term, product: str) -> None:
        self.to.set(target, *_signed(term.scale, product))

    def right(self, step: Assign, term: Term, k: Index) -> str:
        right = term.factors[1]
        if not self.wants_turned(step, term):
            return self.of(right, k, "j")
        rows, _ = self.program.shape(right.name, self.sizes)
        return entry(f"{right.name}_T", (k, rows), ("j", 1))

    def width(self, term: Term) -> Size:
        return inner_width(self.program, self.sizes, term)

    def sum(self, terms: Sequence[Term], i: Index = "i") -> str:
        text = ""
        for term in sorted(terms, key=lambda term: term.scale < 0):
            value, sign = _signed(term.scale, self.of(term.factors[0], i, "j"))
            text += f" {sign[0]} {value}" if text else f"{sign[0]}{value}".lstrip("+")
        return text or "0.0"


def _signed(scale: Fraction, text: str, is_sum: bool = False) -> tuple[str, str]:
    """The text times |scale|, and the operator that adds it with its sign."""
    size = abs(scale)
    text = f"({text})" if is_sum and size != 1 else text
    text = text if size == 1 else f"{float(size)!r} * {text}"
    return text, "-=" if scale < 0 else "+="
