"""Rows of several records to lanes and back, in compiled code: eight by eight.

Eight rows of eight floats are eight vectors; what is wanted are their columns.  LLVM
does not see that in a loop, so it is written as shuffles of vectors.  Nothing is
computed, so no bit hangs on it.
"""

from typing import Any

SIDE = 8  # rows, and floats of each

# to_lanes(X, rows, l, column, lanes, at, step): lanes[at + i * step + k] is
#     X[rows[l + k], column + i], for i and k in 0 ... 7
# to_rows(X, rows, l, column, lanes, at, step): the other way round


def to_lanes_in_python(
    X: Any, rows: Any, l: int, column: int, lanes: Any, at: int, step: int
) -> None:
    """Eight floats of eight rows of X, to `lanes`."""
    for i in range(SIDE):
        place = at + i * step
        lanes[place : place + SIDE] = X[rows[l : l + SIDE], column + i]


def to_rows_in_python(
    X: Any, rows: Any, l: int, column: int, lanes: Any, at: int, step: int
) -> None:
    """Eight floats to eight rows of X, from `lanes`."""
    for i in range(SIDE):
        place = at + i * step
        X[rows[l : l + SIDE], column + i] = lanes[place : place + SIDE]


def to_lanes() -> Any:
    """`to_lanes_in_python`, defined for numba."""
    return _turning(True)


def to_rows() -> Any:
    """`to_rows_in_python`, defined for numba."""
    return _turning(False)


def _turning(reads: bool) -> Any:
    from numba.core import types
    from numba.np.arrayobj import make_array

    def turn(
        context: Any, X: Any, rows: Any, l: Any, column: Any, lanes: Any, at: Any,
        step: Any,
    ) -> Any:  # fmt: skip
        i = types.intp

        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            arrays = [
                make_array(kind)(context, builder, value).data
                for kind, value in zip(signature.args, arguments)
                if isinstance(kind, types.Array)
            ]
            X = make_array(signature.args[0])(context, builder, arguments[0])
            wide = builder.extract_value(X.strides, 0)
            _, _, l, column, _, at, step = arguments
            data, rows, lanes = arrays
            to = _Turn(builder)
            outside = [to.row(data, rows, wide, l, column, k) for k in range(SIDE)]
            inside = [to.line(lanes, at, step, k) for k in range(SIDE)]
            here, there = (outside, inside) if reads else (inside, outside)
            for place, vector in zip(there, to.turned([to.load(p) for p in here])):
                builder.store(vector, place, align=8)
            return context.get_dummy_value()

        return types.void(X, rows, i, i, lanes, i, i), code

    return turn


class _Turn:
    """Instructions that read, turn and write vectors of eight."""

    def __init__(self, builder: Any) -> None:
        from llvmlite import ir

        self.ir, self.to = ir, builder
        self.whole, self.kind = ir.IntType(64), ir.VectorType(ir.DoubleType(), SIDE)

    def row(self, X: Any, rows: Any, wide: Any, l: Any, column: Any, k: int) -> Any:
        """Where row ``rows[l + k]`` of X has its floats from `column` on."""
        to = self.to
        here = to.load(to.gep(rows, [to.add(l, self.whole(k))]))
        row = to.gep(
            to.bitcast(X, self.ir.IntType(8).as_pointer()), [to.mul(here, wide)]
        )
        first = to.gep(to.bitcast(row, X.type), [column])
        return to.bitcast(first, self.kind.as_pointer())

    def line(self, lanes: Any, at: Any, step: Any, k: int) -> Any:
        to = self.to
        place = to.gep(lanes, [to.add(at, to.mul(step, self.whole(k)))])
        return to.bitcast(place, self.kind.as_pointer())

    def load(self, place: Any) -> Any:
        return self.to.load(place, align=8)

    def turned(self, rows: list[Any]) -> list[Any]:
        """The columns of eight vectors: fours change places, then twos, then ones."""
        for half in (4, 2, 1):
            for k in range(SIDE):
                if not k & half:
                    upper, lower = rows[k], rows[k + half]
                    rows[k] = self.joined(upper, lower, half, 0)
                    rows[k + half] = self.joined(upper, lower, half, half)
        return rows

    def joined(self, upper: Any, lower: Any, half: int, side: int) -> Any:
        """Of two rows the blocks on one side: those of the lower row follow."""
        taken = [(j & ~half) + side + (SIDE if j & half else 0) for j in range(SIDE)]
        kind = self.ir.VectorType(self.ir.IntType(32), SIDE)
        return self.to.shuffle_vector(upper, lower, self.ir.Constant(kind, taken))
