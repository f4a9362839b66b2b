"""The loops of `filtering.passes` as C, at sizes that are known.

A text there is Python of loops over arrays, and C says the same, operation by
operation: compiled without fused products it finds Python's bits.  What touches an
array without entries is left out: it is never reached.
"""

from __future__ import annotations

import ast
import inspect
import textwrap
from collections.abc import Collection, Mapping
from typing import Any

import numpy as np

from ...filtering import passes
from ...kernels.c.writer import C
from .source_and_header import wrapped

ORDER = "clear over part whiten absorb gram rows_ahead predict read spread push".split()
# rows and columns of arguments that are arrays; ! marks those that a text changes
ARRAYS = {
    "whiten": "R:pp! C:pN! y:p! r:p!",
    "absorb": "V:NN! D:N! c:N x:N! K:N! f:N!",
    "gram": "W:nw! w:w made:n V:NN! D:N! T:0n! h:w!",
    "rows_ahead": "B:nN G:ng V:NN D:N W:nw! made:n!",
    "predict": "M:nN B:nN G:ng X:no d:e drive:n z:N! V:NN! D:N! E:tN e:t W:nw! w:w! "
    "made:n! met:N! T:0n! h:w!",
    "read": "V:NN! D:N! c:N z:N! met:N! K:N! f:N!",
    "spread": "V:NN D:N variances:n!",
    "push": "O:no z:N E:tN e:t x:n! variances:n!",
}
SIGNS = dict(Add="+", Sub="-", Mult="*", Div="/", Lt="<", Gt=">", Eq="==", USub="-")
INDICES = ("i", "j", "k", "m", "top", "start")


class Printed:
    """C functions PREFIX_text for the `wanted` texts, with all that they call.

    `sizes` are those of the letters of `ARRAYS`, and `tiny` is `passes.TINY`.
    """

    def __init__(
        self,
        prefix: str,
        real: str,
        sizes: Mapping[str, int],
        tiny: float,
        wanted: Collection[str],
    ) -> None:
        self.prefix, self.real, self.tiny = prefix, real, tiny
        self.sizes = {**sizes, "0": 0}
        self.given: dict[str, list[str]] = {}  # of a text the arguments that there are
        self.texts = [_Text(self, name).function() for name in ORDER if name in wanted]

    def call(self, name: str, **given: str) -> str:
        """A call of a text, with what there is of `given`."""
        inside = [given[k] for k in (*self.given[name], "found") if k in given]
        return f"{self.prefix}_{name}({', '.join(inside)})"


class _Text:
    """One text: what its names stand for, and its lines."""

    def __init__(self, to: Printed, name: str) -> None:
        source = textwrap.dedent(inspect.getsource(getattr(passes, name).plain))
        head = ast.parse(source).body[0]
        assert isinstance(head, ast.FunctionDef)
        self.all, self.name, self.head, self.to = to, name, head, C(to.real)
        given = dict(one.split(":") for one in ARRAYS.get(name, "").split())
        self.kept = {k for k, of in given.items() if not of.endswith("!")}
        self.arrays = {
            k: np.empty([to.sizes[c] for c in of.rstrip("!")])
            for k, of in given.items()
        }
        self.empty = {k for k, X in self.arrays.items() if not X.size}
        self.sizes: dict[str, Any] = {}  # those that the text gives names to
        arguments = [one.arg for one in head.args.args]
        to.given[name] = [k for k in arguments if k not in self.empty]
        self.scopes = [set(arguments)]

    def function(self) -> str:
        said = ast.get_docstring(self.head) or ""
        self.block(self.head.body)
        lines, real, kinds = "\n".join(self.to.lines), self.all.real, []
        for k in self.all.given[self.name]:
            kept = k in self.kept or k not in self.arrays
            kind = "int" if k in INDICES else real
            kinds.append(f"{'const ' * kept}{kind} {k}{'[]' * (k in self.arrays)}")
        kinds += [f"{real} found[]"] if "found[0]" in lines else []
        result = real if "    return " in lines else "void"
        head = f"static {result} {self.all.prefix}_{self.name}({', '.join(kinds)})"
        return "\n".join(
            [f"/* {said.splitlines()[0]} */", wrapped(head), "{", lines, "}", ""]
        )

    def row(self, x: ast.AST) -> str | None:
        """The matrix of which this is a row, or the end of one."""
        if not isinstance(x, ast.Subscript):
            return None
        of = x.slice
        if isinstance(of, ast.Tuple) and not isinstance(of.elts[1], ast.Slice):
            return None
        name = ast.unparse(x.value)
        return name if name in self.arrays and self.arrays[name].ndim == 2 else None

    def never(self, x: ast.AST) -> bool:
        """Whether this touches an array without entries."""
        return any(isinstance(n, ast.Name) and n.id in self.empty for n in ast.walk(x))

    # statements

    def block(self, body: list[ast.stmt]) -> None:
        for one in body:
            getattr(self, type(one).__name__)(one)

    def inside(self, head: str, body: list[ast.stmt], *names: str) -> bool:
        """A block under a head; nothing where there would be nothing in it."""
        self.to.line(head)
        before = len(self.to.lines)
        self.to.depth += 1
        self.scopes.append(set(names))
        self.block(body)
        self.scopes.pop()
        if len(self.to.lines) > before:
            self.to.end()
            return True
        self.to.depth -= 1
        del self.to.lines[-1]
        return False

    def Expr(self, x: ast.Expr) -> None:
        if isinstance(x.value, ast.Call):
            self.to.line(f"{self.number(x.value)};")

    def Assign(self, x: ast.Assign) -> None:
        target, value = x.targets[0], x.value
        text = ast.unparse(value)
        if "len(" in text or "shape" in text:  # sizes, which Python can tell
            self.sizes |= self.arrays
            exec(ast.unparse(x), {}, self.sizes)
            return
        both = isinstance(target, ast.Tuple) and isinstance(value, ast.Tuple)
        pairs = zip(target.elts, value.elts) if both else [(target, value)]  # type: ignore
        for one, of in pairs:
            if not (self.never(one) or self.never(of)):
                self.let(one, of)

    def let(self, target: ast.expr, value: ast.expr) -> None:
        if ast.unparse(target) in INDICES:
            self.to.line(f"int {ast.unparse(target)} = {self.index(value)};")
            return
        text, matrix = self.number(value), self.row(value)
        if isinstance(target, ast.Name):
            new = not any(target.id in scope for scope in self.scopes)
            self.scopes[-1].add(target.id)
            kind = f"{self.all.real} " * new
            if matrix:
                self.arrays[target.id] = self.arrays[matrix][0]
                kind = f"{'const ' * (matrix in self.kept)}{kind}*"
            self.to.line(f"{kind}{target.id} = {text};")
        elif matrix := self.row(target):  # all of a row is this number
            wide = self.arrays[matrix].shape[1]
            start = self.index(target.slice)  # type: ignore[attr-defined]
            self.to.loop("q", 0, wide)
            self.to.line(f"{matrix}[({start} * {wide}) + q] = {text};")
            self.to.end()
        else:
            self.to.line(f"{self.number(target)} = {text};")

    def AugAssign(self, x: ast.AugAssign) -> None:
        if not self.never(x):
            sign, of = SIGNS[type(x.op).__name__], ast.unparse(x.target)
            number = self.index if of in INDICES else self.number
            self.to.line(f"{number(x.target)} {sign}= {number(x.value)};")

    def For(self, x: ast.For) -> None:
        given = [self.index(one) for one in x.iter.args]  # type: ignore[attr-defined]
        i = ast.unparse(x.target)
        if len(given) == 3:
            head = f"for (int {i} = {given[0]}; {i} > {given[1]}; {i}--) {{"
        else:
            first, last = given if len(given) > 1 else ("0", given[0])
            head = f"for (int {i} = {first}; {i} < {last}; {i}++) {{"
            if first == last:
                return
        self.inside(head, x.body, i)

    def If(self, x: ast.If) -> None:
        if not self.inside(f"if ({self.number(x.test)}) {{", x.body):
            self.block(x.orelse)
        elif x.orelse:
            raise NotImplementedError(ast.unparse(x))

    def While(self, x: ast.While) -> None:
        self.inside(f"while ({self.number(x.test)}) {{", x.body)

    def Continue(self, x: ast.Continue) -> None:
        self.to.line("continue;")

    def Return(self, x: ast.Return) -> None:
        if isinstance(x.value, ast.Tuple):
            for k, value in enumerate(x.value.elts):
                self.to.line(f"found[{k}] = {self.number(value)};")
        else:
            self.to.line(f"return {self.number(x.value)};")

    # expressions

    def index(self, x: ast.expr, inner: bool = True) -> str:
        """A whole number."""
        try:
            return str(eval(ast.unparse(x), {}, {**self.sizes, **self.arrays}))
        except NameError:
            pass
        if isinstance(x, ast.BinOp):
            a, b = self.index(x.left), self.index(x.right)
            if "0" in (a, b):  # it is added, or taken away
                return b if a == "0" else a
            text = f"{a} {SIGNS[type(x.op).__name__]} {b}"
            return f"({text})" if inner else text
        if isinstance(x, ast.Call):  # of min
            a, b = map(self.index, x.args)
            return f"(({a} < {b}) ? {a} : {b})"
        return ast.unparse(x)

    def number(self, x: Any, inner: bool = False) -> str:
        """A number, a row or a condition."""
        sign = SIGNS.get(type(getattr(x, "op", None)).__name__)
        if isinstance(x, ast.Constant):
            return repr(float(str(x.value)))
        if isinstance(x, ast.Name):
            return repr(self.all.tiny) if x.id == "TINY" else x.id
        if isinstance(x, ast.Subscript):
            return self.entry(x)
        if isinstance(x, ast.Call):
            return self.called(x)
        if isinstance(x, ast.UnaryOp):
            return f"{sign}{self.number(x.operand, True)}"
        if isinstance(x, ast.IfExp):
            test, a, b = map(self.number, (x.test, x.body, x.orelse))
            return f"({test}) ? {a} : {b}"
        if isinstance(x, ast.BoolOp):
            return " && ".join(f"({self.number(one)})" for one in x.values)
        if isinstance(x, ast.Compare):
            of = self.index if ast.unparse(x.left) in INDICES else self.number
            a, b = of(x.left), of(x.comparators[0])
            sign = SIGNS[type(x.ops[0]).__name__]
            return f"isnan({a}) == 0" if a == b else f"{a} {sign} {b}"
        text = f"{self.number(x.left, True)} {sign} {self.number(x.right, True)}"
        return f"({text})" if inner else text

    def entry(self, x: ast.Subscript) -> str:
        array, at = ast.unparse(x.value), x.slice
        if not (isinstance(at, ast.Tuple) or self.row(x)):
            return f"{array}[{self.index(at, inner=False)}]"
        i, end = at.elts if isinstance(at, ast.Tuple) else (at, None)
        first = end.lower if isinstance(end, ast.Slice) else end
        wide, j = self.arrays[array].shape[1], self.index(first) if first else "0"
        begin = self.index(i) if wide == 1 else f"{self.index(i)} * {wide}"
        entry = f"{array}[{begin}]" if j == "0" else f"{array}[({begin}) + {j}]"
        return f"&{entry}" if self.row(x) else entry

    def called(self, x: ast.Call) -> str:
        name = ast.unparse(x.func)
        if name == "abs":
            return f"fabs({self.number(x.args[0])})"
        names = inspect.signature(getattr(passes, name).plain).parameters
        given = dict(zip(names, x.args, strict=True))
        return self.all.call(name, **{
            k: self.index(given[k]) if k in INDICES else self.number(given[k])
            for k in self.all.given[name]
        })  # fmt: skip
