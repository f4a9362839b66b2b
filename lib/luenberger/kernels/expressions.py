"""Instructions of LLVM for expressions: numbers, flat arrays, and what is called."""

import ast
import math
from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

COMPARED = {
    "Eq": "==", "NotEq": "!=", "Lt": "<", "LtE": "<=", "Gt": ">", "GtE": ">=",
}  # fmt: skip
IN_FLOATS = {"Add": "fadd", "Sub": "fsub", "Mult": "fmul", "Div": "fdiv"}
IN_WHOLE = {"Add": "add", "Sub": "sub", "Mult": "mul"}


class Unknown(TypeError):
    """A text has something that is not written so."""

    def __init__(self, node: ast.AST) -> None:
        super().__init__(f"not known: {ast.unparse(node)}")


@dataclass(frozen=True)
class Number:
    """A float ("f"), whole number ("i") or truth ("b").

    It is `natural` if it cannot be below zero; its `literal` is known from the text.
    """

    kind: str
    value: Any
    natural: bool = False
    literal: Any = None


@dataclass(frozen=True)
class Array:
    """Numbers of a kind by rows: where they begin, and how many there are each way."""

    kind: str
    data: Any
    shape: tuple[Any, ...]


class Expressions:
    """Writes expressions with a builder of LLVM; `plain` names have no memory."""

    def __init__(
        self, context: Any, builder: Any, plain: frozenset[str], known: dict[str, Any]
    ) -> None:
        from llvmlite import ir
        from numba.core import cgutils, types

        self.context, self.to, self.plain, self.known = context, builder, plain, known
        self.tools, self.types, self.ir = cgutils, types, ir
        self.whole, self.byte, self.truth = (ir.IntType(k) for k in (64, 8, 1))
        self.real = ir.DoubleType()
        self.held: dict[str, Any] = {}  # by name: a value, or memory
        self.heap: list[Any] = []  # memory to give back
        self.open = 0  # loops and conditions that the lines stand in
        self.inner = {"f": self.real, "i": self.whole, "b": self.byte}
        self.kinds = {"f": types.float64, "i": types.int64, "b": types.boolean}
        self.numbers = {"f": self.real, "i": self.whole, "b": self.truth}

    # names

    def take(self, name: str, kind: Any, value: Any) -> None:
        """An argument of the function, of one of numba's types."""
        from numba.np.arrayobj import make_array

        letters = {one: letter for letter, one in self.kinds.items()}
        if isinstance(kind, self.types.Array):
            found = make_array(kind)(self.context, self.to, value)
            shape = tuple(self.tools.unpack_tuple(self.to, found.shape))
            self.bind(name, Array(letters[kind.dtype], found.data, shape))
        else:
            self.bind(name, Number(letters[kind], value))

    def bind(self, name: str, value: Any) -> None:
        """name = value."""
        if name in self.plain:
            self.held[name] = value
            return
        kind, place = self.held.get(name, ("", None))
        if not isinstance(value, Number):
            raise Unknown(ast.Name(name))
        if place is None:
            kind = value.kind
            place = self.tools.alloca_once(self.to, self.numbers[kind], name=name)
            self.held[name] = kind, place
        if kind != value.kind:
            raise Unknown(ast.Name(name))
        self.to.store(value.value, place)

    def name(self, node: ast.expr) -> Any:
        if not isinstance(node, ast.Name) or node.id not in self.held:
            raise Unknown(node)
        found = self.held[node.id]
        if isinstance(found, tuple):
            return Number(found[0], self.to.load(found[1]))
        return found

    # numbers

    def any(self, node: ast.expr) -> Any:
        """A number or an array."""
        write: Callable[[Any], Any] | None
        write = getattr(self, f"of_{type(node).__name__}", None)
        if write is None:
            raise Unknown(node)
        return write(node)

    def number(self, node: ast.expr) -> Number:
        found = self.any(node)
        if not isinstance(found, Number):
            raise Unknown(node)
        return found

    def flag(self, node: ast.expr) -> Any:
        """A truth, as a value."""
        found = self.number(node)
        if found.kind != "b":
            raise Unknown(node)
        return found.value

    def index(self, value: Any, natural: bool) -> Number:
        return Number("i", value, natural)

    def of_Name(self, node: ast.Name) -> Any:
        return self.name(node)

    def of_Constant(self, node: ast.Constant) -> Number:
        return self.constant(node.value, node)

    def constant(self, value: Any, node: ast.expr) -> Number:
        kind = {bool: "b", int: "i", float: "f"}.get(type(value))
        if kind is None:
            raise Unknown(node)
        natural = kind == "i" and value >= 0
        return Number(kind, self.numbers[kind](value), natural, literal=value)

    def of_Attribute(self, node: ast.Attribute) -> Number:
        if ast.unparse(node) != "np.inf":
            raise Unknown(node)
        return self.constant(math.inf, node)

    def range(self, node: ast.expr) -> tuple[Number, Number, Number]:
        """Start, stop and step of a range; the step is a number above zero."""
        if not isinstance(node, ast.Call) or ast.unparse(node.func) != "range":
            raise Unknown(node)
        given = [self.number(one) for one in node.args]
        start, stop, step = {
            1: [self.constant(0, node), *given, self.constant(1, node)],
            2: [*given, self.constant(1, node)],
        }.get(len(given), given)
        if any(one.kind != "i" for one in given) or not (step.literal or 0) > 0:
            raise Unknown(node)
        return start, stop, step

    def float(self, one: Number) -> Any:
        if one.kind == "f":
            return one.value
        if one.literal is not None:
            return self.real(float(one.literal))
        turn = self.to.sitofp if one.kind == "i" else self.to.uitofp
        return turn(one.value, self.real)

    def of_BinOp(self, node: ast.BinOp) -> Number:
        return self.operation(node.op, self.number(node.left), self.number(node.right))

    def operation(self, op: ast.operator, one: Number, other: Number) -> Number:
        name = type(op).__name__
        if "f" in (one.kind, other.kind) and name in IN_FLOATS:
            write = getattr(self.to, IN_FLOATS[name])
            return Number("f", write(self.float(one), self.float(other)))
        if one.kind != "i" or other.kind != "i":
            raise Unknown(op)
        natural = one.natural and other.natural
        if name in ("FloorDiv", "Mod") and (other.literal or 0) > 0:
            return self.divided(name == "Mod", one, other)
        if name not in IN_WHOLE:
            raise Unknown(op)
        if (name, one.literal) in (("Add", 0), ("Mult", 1)):
            return other
        if (name, other.literal) in (("Add", 0), ("Mult", 1)):
            return one
        found = getattr(self.to, IN_WHOLE[name])(one.value, other.value, flags=("nsw",))
        return self.index(found, natural and name != "Sub")

    def divided(self, rest: bool, one: Number, other: Number) -> Number:
        """The whole quotient by a number above zero, or its rest, which is natural."""
        to, quick = self.to, ("nsw",)
        left = to.srem(one.value, other.value)
        if not one.natural:
            low = to.icmp_signed("<", left, self.whole(0))
            left = to.select(low, to.add(left, other.value, flags=quick), left)
        if rest:
            return self.index(left, True)
        even = to.sub(one.value, left, flags=quick)
        return self.index(to.sdiv(even, other.value), one.natural)

    def of_UnaryOp(self, node: ast.UnaryOp) -> Number:
        one = self.number(node.operand)
        if isinstance(node.op, ast.Not) and one.kind == "b":
            return Number("b", self.to.not_(one.value))
        if not isinstance(node.op, ast.USub) or one.kind == "b":
            raise Unknown(node)
        if one.literal is not None:
            return self.constant(-one.literal, node)
        if one.kind == "i":
            return self.index(self.to.neg(one.value), False)
        return Number("f", self.to.fsub(self.real(-0.0), one.value))

    def of_Compare(self, node: ast.Compare) -> Number:
        found, left = None, self.number(node.left)
        for op, right in zip(node.ops, map(self.number, node.comparators)):
            sign = COMPARED.get(type(op).__name__)
            if sign is None or "b" in (left.kind, right.kind):
                raise Unknown(node)
            if left.kind == right.kind == "i":
                one = self.to.icmp_signed(sign, left.value, right.value)
            else:
                write = self.to.fcmp_unordered if sign == "!=" else self.to.fcmp_ordered
                one = write(sign, self.float(left), self.float(right))
            found, left = one if found is None else self.to.and_(found, one), right
        return Number("b", found)

    def of_BoolOp(self, node: ast.BoolOp) -> Number:
        """What stands behind is not read where what stands before decides."""
        found = Number("b", self.flag(node.values[0]))
        for one in node.values[1:]:
            ends = isinstance(node.op, ast.Or)
            two: list[Any] = [ast.Constant(ends), one]
            found = self.either(found.value, *(two if ends else reversed(two)))
        return found

    def of_IfExp(self, node: ast.IfExp) -> Number:
        return self.either(self.flag(node.test), node.body, node.orelse)

    def either(self, condition: Any, yes: ast.expr, no: ast.expr) -> Number:
        """One of two; where one reads an array or calls, only that which is wanted."""
        to, reads = self.to, (ast.Subscript, ast.Call)
        if not any(isinstance(k, reads) for one in (yes, no) for k in ast.walk(one)):
            a, b = self.alike(self.number(yes), self.number(no), no)
            natural = a.natural and b.natural
            return Number(a.kind, to.select(condition, a.value, b.value), natural)
        blocks = [to.append_basic_block(name) for name in ("yes", "no", "end")]
        to.cbranch(condition, *blocks[:2])
        found = []
        for node, block in zip((yes, no), blocks):
            to.position_at_end(block)
            one = self.number(node)
            found.append((one, to.block))
            to.branch(blocks[2])
        to.position_at_end(blocks[2])
        kinds = {one.kind for one, _ in found}
        if len(kinds) > 1:
            raise Unknown(no)
        (kind,) = kinds
        phi = to.phi(self.numbers[kind])
        for one, block in found:
            phi.add_incoming(one.value, block)
        return Number(kind, phi, all(one.natural for one, _ in found))

    def alike(self, a: Number, b: Number, node: ast.expr) -> tuple[Number, Number]:
        """Two numbers as numbers of one kind."""
        if a.kind == b.kind:
            return a, b
        if "b" in (a.kind, b.kind):
            raise Unknown(node)
        return Number("f", self.float(a)), Number("f", self.float(b))
