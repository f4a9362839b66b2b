"""Instructions of LLVM for the text of a kernel, without numba's front end.

numba infers the type of every name in a text and lowers each operation by looking for
one of many that fit.  That takes most of the time of compiling.  The texts of this
library need little of it: numbers, flat arrays, loops over ranges and conditions.  So
their instructions are written at once.  numba still makes the function that Python
calls, optimises, and keeps what it made.

A text with anything else raises `Unknown`, and numba compiles it as a whole.
"""

import ast
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import Any

from .arrays import Arrays
from .expressions import Unknown
from .scopes import plain_names


@dataclass(frozen=True)
class Text:
    """The function `run` of a module: what it is given, its body and its result."""

    names: tuple[str, ...]
    body: list[ast.stmt]
    plain: frozenset[str]
    result: str  # the kind of number that it returns

    def __hash__(self) -> int:
        return id(self)


def read(text: str) -> Text:
    """The function of a text that can be written so; else `Unknown` is raised."""
    function = ast.parse(text).body[-1]
    if not isinstance(function, ast.FunctionDef):
        raise Unknown(function)
    *_, last = function.body
    if not isinstance(last, ast.Return):
        raise Unknown(last)
    names = tuple(one.arg for one in function.args.args)
    flags = {
        one.targets[0].id
        for one in ast.walk(function)
        if isinstance(one, ast.Assign)
        and isinstance(one.targets[0], ast.Name)
        and isinstance(one.value, ast.Constant)
        and isinstance(one.value.value, bool)
    }
    value = last.value
    flag = isinstance(value, ast.Name) and value.id in flags
    return Text(names, function.body, plain_names(function), "b" if flag else "i")


def body(text: Text) -> Any:
    """A function for numba that does what the text says; it is given its arguments."""
    from numba.core import types
    from numba.extending import intrinsic

    from . import stack

    result = {"b": types.boolean, "i": types.int64}[text.result]

    def define(context: Any, *given: Any) -> Any:
        def code(context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
            work = Statements(context, builder, text.plain, stack.definitions())
            for name, kind, value in zip(text.names, signature.args, arguments):
                work.take(name, kind, value)
            return work.function(text.body, text.result)

        return result(*given), code

    names = ", ".join(text.names)
    made: dict[str, Any] = dict(define=define)
    exec(f"def body(context, {names}): return define(context, {names})", made)
    return intrinsic(made["body"])


class Statements(Arrays):
    """Writes statements, one after another."""

    def function(self, lines: Sequence[ast.stmt], kind: str) -> Any:
        """All lines; what is returned."""
        self.ends: list[Any] = []  # where `break` goes, of loops that are open
        self.block(lines[:-1])
        last = lines[-1]
        assert isinstance(last, ast.Return) and last.value
        found = self.number(last.value)
        if found.kind != kind:
            raise Unknown(last)
        self.give_back()
        return found.value

    def block(self, lines: Sequence[ast.stmt]) -> None:
        self.open += 1
        for line in lines:
            write: Callable[[Any], None] | None
            write = getattr(self, f"do_{type(line).__name__}", None)
            if write is None:
                raise Unknown(line)
            write(line)
        self.open -= 1

    def do_Pass(self, line: ast.Pass) -> None:
        pass

    def do_Expr(self, line: ast.Expr) -> None:
        if not isinstance(line.value, ast.Constant):  # else words
            self.call(line.value)

    def do_Assign(self, line: ast.Assign) -> None:
        (target,) = line.targets
        self.put(target, self.any(line.value))

    def do_AugAssign(self, line: ast.AugAssign) -> None:
        more = self.number(line.value)
        if isinstance(line.target, ast.Subscript):
            entry = self.part(line.target)
            found = self.operation(line.op, self.load(entry), more)
            self.keep(entry, found, line.target)
        else:
            before = self.name(line.target)
            self.put(line.target, self.operation(line.op, before, more))

    def put(self, target: ast.expr, value: Any) -> None:
        """target = value."""
        if isinstance(target, ast.Subscript):
            self.store(target, value)
        elif isinstance(target, ast.Name):
            self.bind(target.id, value)
        else:
            raise Unknown(target)

    def do_If(self, line: ast.If) -> None:
        to, condition = self.to, self.flag(line.test)
        yes, end = (to.append_basic_block(name) for name in ("yes", "end"))
        no = to.append_basic_block("no") if line.orelse else end
        to.cbranch(condition, yes, no)
        for lines, begin in ((line.body, yes), (line.orelse, no)):
            if lines:
                to.position_at_end(begin)
                self.block(lines)
                if not to.block.is_terminated:
                    to.branch(end)
        to.position_at_end(end)

    def do_Break(self, line: ast.Break) -> None:
        self.to.branch(self.ends[-1])

    def do_For(self, line: ast.For) -> None:
        """A loop over a range whose step is above zero."""
        start, stop, step = self.range(line.iter)
        to, before = self.to, self.to.block
        names = ("head", "turn", "next", "end")
        head, turn, following, end = (to.append_basic_block(name) for name in names)
        to.branch(head)
        to.position_at_end(head)
        index = to.phi(self.whole)
        index.add_incoming(start.value, before)
        to.cbranch(to.icmp_signed("<", index, stop.value), turn, end)
        to.position_at_end(turn)
        assert isinstance(line.target, ast.Name)
        self.bind(line.target.id, self.index(index, start.natural))
        self.ends.append(end)
        self.block(line.body)
        self.ends.pop()
        if not to.block.is_terminated:
            to.branch(following)
        to.position_at_end(following)
        index.add_incoming(to.add(index, step.value, flags=("nsw",)), following)
        to.branch(head)
        to.position_at_end(end)
