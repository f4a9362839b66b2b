"""Instructions of LLVM for arrays: room for them, their entries, and what is called."""

import ast
from collections.abc import Sequence
from typing import Any

from .expressions import Array, Expressions, Number, Unknown

ALIGNED = 64  # bytes: memory from the heap begins at a multiple
ON_STACK = 256  # whole numbers at most; more go to the heap


class Arrays(Expressions):
    """Writes expressions in which arrays are read, made, or given to a function."""

    # entries

    def of_Subscript(self, node: ast.Subscript) -> Any:
        if isinstance(node.value, ast.Attribute):
            return self.length(node.value, node.slice)
        found = self.part(node)
        return found if found.shape else self.load(found)

    def length(self, node: ast.Attribute, at: ast.expr) -> Number:
        """``X.shape[0]``"""
        array = self.any(node.value)
        if not isinstance(array, Array) or node.attr != "shape":
            raise Unknown(node)
        if not isinstance(at, ast.Constant) or not isinstance(at.value, int):
            raise Unknown(at)
        return self.index(array.shape[at.value], True)

    def load(self, entry: Array) -> Number:
        found = self.to.load(entry.data)
        if entry.kind == "b":
            found = self.to.icmp_unsigned("!=", found, self.byte(0))
        return Number(entry.kind, found)

    def store(self, node: ast.Subscript, value: Any) -> None:
        """An entry = value."""
        self.keep(self.part(node), value, node)

    def keep(self, entry: Array, value: Any, node: ast.expr) -> None:
        if entry.shape or not isinstance(value, Number):
            raise Unknown(node)
        found = self.float(value) if entry.kind == "f" else value.value
        if entry.kind != "f" and entry.kind != value.kind:
            raise Unknown(node)
        if entry.kind == "b":
            found = self.to.zext(found, self.byte)
        self.to.store(found, entry.data)

    def part(self, node: ast.Subscript) -> Array:
        """An entry of an array, which has no shape, or a part of a row, or a row."""
        array, to = self.any(node.value), self.to
        if not isinstance(array, Array):
            raise Unknown(node)
        at = node.slice.elts if isinstance(node.slice, ast.Tuple) else [node.slice]
        if len(at) > len(array.shape):
            raise Unknown(node)
        shape, places = list(array.shape), []
        for k, one in enumerate(at):
            if isinstance(one, ast.Slice):
                if k + 1 < len(array.shape):
                    raise Unknown(node)
                first, last = self.span(one, shape[k], node)
                places.append(first)
                shape[k] = to.sub(last, first, flags=("nsw",))
            else:
                places.append(self.within(one, shape[k]))
                shape[k] = None
        data = to.gep(array.data, [self.offset(places, array.shape)])
        return Array(array.kind, data, tuple(one for one in shape if one is not None))

    def offset(self, places: Sequence[Any], shape: Sequence[Any]) -> Any:
        """The number of the entry that a part begins with."""
        to, quick, found = self.to, ("nsw",), places[0]
        for k, wide in enumerate(shape[1:], 1):
            found = to.mul(found, wide, flags=quick)
            if k < len(places):
                found = to.add(found, places[k], flags=quick)
        return found

    def within(self, node: ast.expr, long: Any) -> Any:
        """An index; one below zero counts from the end, as in Python."""
        found, to = self.number(node), self.to
        if found.kind != "i":
            raise Unknown(node)
        if found.natural:
            return found.value
        low = to.icmp_signed("<", found.value, self.whole(0))
        return to.select(low, to.add(found.value, long), found.value)

    def span(self, node: ast.Slice, long: Any, whole: ast.expr) -> tuple[Any, Any]:
        """Where a part of a row begins and ends; both lie in the row."""
        if node.lower is None or node.upper is None or node.step is not None:
            raise Unknown(whole)
        return self.within(node.lower, long), self.within(node.upper, long)

    # room

    def room(self, node: ast.Call) -> Array:
        """``array(9)``, ``np.empty(9)``, ``np.zeros(9)``, ``np.empty(9, np.int64)``."""
        how, (first, *more) = ast.unparse(node.func), node.args
        kind = {"": "f", "np.int64": "i"}.get(", ".join(map(ast.unparse, more)))
        sides = first.elts if isinstance(first, ast.Tuple) else [first]
        sizes = [self.number(one) for one in sides]
        if kind is None or node.keywords or any(one.kind != "i" for one in sizes):
            raise Unknown(node)
        shape = tuple(one.value for one in sizes)
        small = kind == "i" and len(sizes) == 1 and (sizes[0].literal or ON_STACK + 1)
        if how == "array" or (how == "np.empty" and small and small <= ON_STACK):
            if sizes[0].literal is None:
                raise Unknown(node)
            whole = self.ir.ArrayType(self.inner[kind], sizes[0].literal)
            place = self.tools.alloca_once(self.to, whole)
            data = self.to.bitcast(place, self.inner[kind].as_pointer())
            return Array(kind, data, shape)
        return Array(kind, self.from_heap(kind, shape, how == "np.zeros", node), shape)

    def from_heap(self, kind: str, shape: Sequence[Any], zero: bool, node: Any) -> Any:
        """Memory that `give_back` gives back; a MemoryError where there is none."""
        if self.open > 1:  # in a loop or under a condition
            raise Unknown(node)
        to, many = self.to, self.whole(8)
        for one in shape:
            many = to.mul(many, one)
        room = to.add(many, self.whole(ALIGNED))
        found = self.context.nrt.allocate(to, room)
        with self.tools.if_unlikely(to, self.tools.is_null(to, found)):
            for one in self.heap:
                self.context.nrt.free(to, one)
            said = ("no memory for an array of a kernel",)
            self.context.call_conv.return_user_exc(to, MemoryError, said)
        self.heap.append(found)
        first = to.add(to.ptrtoint(found, self.whole), self.whole(ALIGNED - 1))
        first = to.and_(first, self.whole(-ALIGNED))
        data = to.inttoptr(first, self.inner[kind].as_pointer())
        if zero:
            self.tools.memset(to, data, many, 0)
        return data

    def give_back(self) -> None:
        for one in self.heap:
            self.context.nrt.free(self.to, one)

    # calls

    def of_Call(self, node: ast.Call) -> Any:
        name = ast.unparse(node.func)
        if name in ("array", "np.empty", "np.zeros"):
            return self.room(node)
        if name in ("min", "max"):
            return self.extreme(node, "<" if name == "min" else ">")
        if name == "abs":
            return self.size(node)
        found = self.call(node)
        if not isinstance(found, Number):
            raise Unknown(node)
        return found

    def extreme(self, node: ast.Call, sign: str) -> Number:
        """The less or the greater of two; the first, where one is a NaN, as Python."""
        if len(node.args) != 2:
            raise Unknown(node)
        left, right = map(self.number, node.args)
        one, other = self.alike(left, right, node)
        whole = one.kind == "i"
        write = self.to.icmp_signed if whole else self.to.fcmp_ordered
        wanted = write(sign, other.value, one.value)
        found = self.to.select(wanted, other.value, one.value)
        return Number(one.kind, found, one.natural and other.natural)

    def size(self, node: ast.Call) -> Number:
        """The size of a float."""
        one = self.number(node.args[0])
        if one.kind != "f":
            raise Unknown(node)
        kind = self.ir.FunctionType(self.real, [self.real])
        fabs = self.to.module.declare_intrinsic("llvm.fabs", [self.real], kind)
        return Number("f", self.to.call(fabs, [one.value]))

    def call(self, node: ast.expr) -> Any:
        """A call of one of our functions; what it returns."""
        if not isinstance(node, ast.Call) or ast.unparse(node.func) not in self.known:
            raise Unknown(node)
        given = [self.any(one) for one in node.args]
        kinds = [self.kind(one) for one in given]
        signature, code = self.known[ast.unparse(node.func)](None, *kinds)
        values = []
        for one, kind in zip(given, signature.args):
            if isinstance(one, Array):
                values.append(self.given_on(one))
            else:
                values.append(self.float(one) if kind == self.kinds["f"] else one.value)
        found = code(self.context, self.to, signature, values)
        return Number("f", found) if signature.return_type == self.kinds["f"] else None

    def kind(self, one: Any) -> Any:
        """numba's type of what is given to a function."""
        if isinstance(one, Array):
            return self.types.Array(self.kinds[one.kind], len(one.shape), "C")
        if one.kind == "i" and one.literal is not None:
            return self.types.literal(one.literal)
        return self.kinds[one.kind]

    def given_on(self, one: Array) -> Any:
        """An array as numba has it."""
        from numba.np.arrayobj import make_array, populate_array

        made = make_array(self.kind(one))(self.context, self.to)
        strides = [self.whole(8)]
        for wide in reversed(one.shape[1:]):
            strides.insert(0, self.to.mul(strides[0], wide))
        size = self.whole(8)
        populate_array(made, one.data, list(one.shape), strides, size, None)
        return made._getvalue()
