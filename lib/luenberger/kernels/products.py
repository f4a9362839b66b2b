"""The product of two matrices in compiled code: a few rows and columns at a time.

The sums of a tile, some rows by some columns, stay in registers: each number that is
read of the right factor serves all rows, each of the left all columns.  It is written
for LLVM as vectors, so nothing hangs on whether a loop becomes vector code, and once
for each height, at any sizes, so there is little to compile.
"""

from typing import Any

import numpy as np

HEIGHT = 6  # rows of a tile at most
WIDTHS = (8, 4, 1)  # its columns, the first that fits; the last tile overlaps another
ORDER = "panels columns inner most scale d d_row c c_row a a_row a_col b b_row".split()
POINTERS = frozenset("dcab")

# product(height, start, panels, columns, inner, most, scale, D, d, d_row, C, c, c_row,
#         A, a, a_row, a_col, B, b, b_row)


def in_python(
    height: int, start: int, panels: int, columns: int, inner: int, most: int,
    scale: float, D: Any, d: int, d_row: int, C: Any, c: int, c_row: int,
    A: Any, a: int, a_row: int, a_col: int, B: Any, b: int, b_row: int,
) -> None:  # fmt: skip
    """D = C + scale A B, or without C if not `start`, of arrays that are flat.

    An array comes with the index of its first entry and the steps to the next row
    (and, of A, to the next column).  There are panels * height rows.  Of a panel that
    begins with row i the columns from min(i, most) on are computed.  D must not
    overlap what is read.
    """
    i, j, k = (np.arange(m) for m in (panels * height, columns, inner))
    i, down = i[:, None], k[:, None]
    found = scale * (A[a + i * a_row + k * a_col] @ B[b + down * b_row + j])
    if start:
        found += C[c + i * c_row + j]
    wanted = j >= np.minimum(i // height * height, most)
    D[(d + i * d_row + j)[wanted]] = found[wanted]


def in_vectors() -> Any:
    """`in_python`, defined for numba; `height` and `start` are numbers in the call."""
    from numba.core import types
    from numba.core.typing import signature
    from numba.np.arrayobj import make_array

    def product(
        context: Any, height: Any, start: Any, panels: Any, columns: Any, inner: Any,
        most: Any, scale: Any, D: Any, d: Any, d_row: Any, C: Any, c: Any, c_row: Any,
        A: Any, a: Any, a_row: Any, a_col: Any, B: Any, b: Any, b_row: Any,
    ) -> Any:  # fmt: skip
        if not all(isinstance(one, types.IntegerLiteral) for one in (height, start)):
            return None
        i, real = types.intp, types.float64
        kinds = i, i, i, i, real, D, i, i, C, i, i, A, i, i, i, B, i, i

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            given: list[Any] = []
            wanted = list(zip(signature.args, arguments))[2:]
            while wanted:
                kind, value = wanted.pop(0)
                if isinstance(kind, types.Array):
                    data = make_array(kind)(context, builder, value).data
                    value = builder.gep(data, [wanted.pop(0)[1]])
                given.append(value)
            made = _function(builder.module, height.literal_value, start.literal_value)
            builder.call(made, given)
            return context.get_dummy_value()

        return signature(types.none, height, start, *kinds), code

    return product


def _function(module: Any, height: int, start: int) -> Any:
    """The function of one height in a module of LLVM, written if it is not there."""
    from llvmlite import ir

    name = f"product_{'plus' if start else 'alone'}_{height}"
    if name in module.globals:
        return module.globals[name]
    real, whole = ir.DoubleType(), ir.IntType(64)
    kinds = {"scale": real} | {name: real.as_pointer() for name in POINTERS}
    kind = ir.FunctionType(ir.VoidType(), [kinds.get(one, whole) for one in ORDER])
    made = ir.Function(module, kind, name)
    made.linkage = "internal"
    made.attributes.add("noinline")
    _Body(ir.IRBuilder(made.append_basic_block()), height, start, made.args).write()
    return made


class _Body:
    """The instructions of one function; what it was given has the names in `ORDER`."""

    def __init__(self, builder: Any, height: int, start: int, given: Any) -> None:
        from llvmlite import ir
        from numba.core import cgutils

        self.ir, self.tools, self.to = ir, cgutils, builder
        self.height, self.start = height, start
        self.given = dict(zip(ORDER, given))
        self.whole, self.real = ir.IntType(64), ir.DoubleType()

    def number(self, value: int) -> Any:
        return self.whole(value)

    def least(self, one: Any, other: Any) -> Any:
        return self.to.select(self.to.icmp_signed("<", one, other), one, other)

    def write(self) -> None:
        to, columns = self.to, self.given["columns"]
        with self.tools.for_range(to, self.given["panels"]) as panel:
            self.row = to.mul(panel.index, self.number(self.height))
            first = self.least(self.row, self.given["most"])
            self.begin()
            self.columns(first, columns)
        to.ret_void()

    def begin(self) -> None:
        """Where the rows of this panel begin, in each matrix."""
        self.rows = {
            name: [self.at(name, self.row, r) for r in range(self.height)]
            for name in ("d", "c", "a")
        }

    def at(self, name: str, row: Any, more: int) -> Any:
        to = self.to
        here = to.mul(to.add(row, self.number(more)), self.given[f"{name}_row"])
        return to.gep(self.given[name], [here])

    def columns(self, first: Any, last: Any) -> None:
        """Tiles from column `first` on: the widest, then one that ends with the row."""
        to, (wide, narrow, one) = self.to, WIDTHS
        there = to.sub(last, first)
        fits = {w: to.icmp_signed(">=", there, self.number(w)) for w in WIDTHS[:2]}
        with to.if_else(fits[wide]) as (yes, no):
            with yes:
                self.across(first, last, wide)
            with no:
                with to.if_else(fits[narrow]) as (some, few):
                    with some:
                        self.tile(first, narrow)
                        more = to.icmp_signed(">", there, self.number(narrow))
                        with to.if_then(more):
                            self.tile(to.sub(last, self.number(narrow)), narrow)
                    with few:
                        self.loop(first, last, one)

    def across(self, first: Any, last: Any, width: int) -> None:
        """Tiles of a width, and one more that ends with the row."""
        to, narrow = self.to, WIDTHS[1]
        there = to.sub(last, first)
        rest = to.srem(there, self.number(width))
        self.loop(first, to.sub(last, rest), width)
        left = to.icmp_signed(">", rest, self.number(0))
        with to.if_then(left):
            much = to.icmp_signed(">", rest, self.number(narrow))
            with to.if_else(much) as (yes, no):
                with yes:
                    self.tile(to.sub(last, self.number(width)), width)
                with no:
                    self.tile(to.sub(last, self.number(narrow)), narrow)

    def loop(self, first: Any, last: Any, width: int) -> None:
        step = self.number(width)
        with self.tools.for_range_slice(self.to, first, last, step) as (j, _):
            self.tile(j, width)

    def tile(self, j: Any, width: int) -> None:
        """The entries of all rows in the columns from j on."""
        to, ir = self.to, self.ir
        kind = ir.VectorType(self.real, width) if width > 1 else self.real
        zero = ir.Constant(kind, [0.0] * width if width > 1 else 0.0)
        sums = [self.tools.alloca_once(to, kind) for _ in range(self.height)]
        for one in sums:
            to.store(zero, one)
        given, quick = self.given, ("contract",)
        with self.tools.for_range(to, given["inner"]) as inner:
            b = to.add(to.mul(inner.index, given["b_row"]), j)
            right = self.load(to.gep(given["b"], [b]), kind)
            along = to.mul(inner.index, given["a_col"])
            for r, one in enumerate(sums):
                left = to.load(to.gep(self.rows["a"][r], [along]))
                term = to.fmul(self.spread(left, width), right, flags=quick)
                to.store(to.fadd(to.load(one), term, flags=quick), one)
        scale = self.spread(given["scale"], width)
        for r, one in enumerate(sums):
            found = to.fmul(scale, to.load(one), flags=quick)
            if self.start:
                first = self.load(to.gep(self.rows["c"][r], [j]), kind)
                found = to.fadd(first, found, flags=quick)
            place = to.gep(self.rows["d"][r], [j])
            to.store(found, to.bitcast(place, kind.as_pointer()), align=8)

    def load(self, place: Any, kind: Any) -> Any:
        return self.to.load(self.to.bitcast(place, kind.as_pointer()), align=8)

    def spread(self, number: Any, width: int) -> Any:
        """A number in every place of a vector."""
        if width == 1:
            return number
        to, ir = self.to, self.ir
        kind = ir.VectorType(self.real, width)
        empty = ir.Constant(kind, ir.Undefined)
        first = to.insert_element(empty, number, ir.IntType(32)(0))
        places = ir.Constant(ir.VectorType(ir.IntType(32), width), [0] * width)
        return to.shuffle_vector(first, empty, places)
