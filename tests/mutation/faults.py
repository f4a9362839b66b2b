"""Single faults of Python source, each a small slip that a test ought to notice.

Signs, comparisons and constants are changed, a `.T` or a term is dropped, arguments are
swapped, a statement is deleted.  Text that is printed as code (`" - "` in a generator)
is damaged in the same way.  Docstrings, annotations and the words of an error are not.
"""

import ast
import re
from contextlib import contextmanager
from dataclasses import dataclass

SWAPS = {
    ast.Add: ast.Sub,
    ast.Sub: ast.Add,
    ast.Mult: ast.Div,
    ast.Div: ast.Mult,
    ast.Pow: ast.Mult,
    ast.FloorDiv: ast.Mult,
    ast.Mod: ast.FloorDiv,
    ast.Lt: ast.LtE,
    ast.LtE: ast.Lt,
    ast.Gt: ast.GtE,
    ast.GtE: ast.Gt,
    ast.Eq: ast.NotEq,
    ast.NotEq: ast.Eq,
    ast.In: ast.NotIn,
    ast.NotIn: ast.In,
    ast.Is: ast.IsNot,
    ast.IsNot: ast.Is,
    ast.And: ast.Or,
    ast.Or: ast.And,
}
PRINTED = {" + ": " - ", " - ": " + ", " * ": " + ", "-=": "+=", "*=": "+=", "+ 1": ""}
PRINTED |= {" < ": " <= ", " > ": " >= ", " / ": " * ", "+=": "-="}
SENTENCE = re.compile(r"[A-Za-z]{2,} [a-z]{2,} [a-z]")
COMMUTE = {"maximum", "minimum", "max", "min", "logical_and", "logical_or"}
SILENT = {"errstate"}  # what it is told changes warnings, not results
LETTERS = 3  # of an attribute that is a matrix: Qs, V2s
DECADES = 1e3  # by which a number that is not whole is moved


@dataclass(frozen=True, order=True)
class Fault:
    """Bytes `start` to `end` of a file replaced by `text`."""

    path: str
    line: int
    start: int
    end: int
    text: str
    where: str = ""  # the function that it is in
    name: str = ""  # what the statement outside functions defines

    def damaged(self, source):
        return source[: self.start] + self.text.encode() + source[self.end :]

    def shown(self, source):
        """The lines that change, before and after, each without its indentation."""
        first = source.rfind(b"\n", 0, self.start) + 1
        new, pieces = self.damaged(source), []
        for whole, end in ((source, self.end), (new, self.start + len(self.text))):
            last = whole.find(b"\n", end)
            piece = whole[first : last if last >= 0 else None].decode()
            pieces.append(" ".join(piece.split()))
        return tuple(pieces)


def faults(path, source):
    """All faults of one file, in a list for each place that can be damaged."""
    found = _Finder(path, source)
    found.statements(ast.parse(source).body, "", "")
    return list(found.places.values())


class _Finder:
    def __init__(self, path, source):
        self.path, self.source, self.places = path, source, {}
        ends = [0]
        for line in source.splitlines(keepends=True):
            ends.append(ends[-1] + len(line))
        self.begins = ends
        self.siblings = _siblings(ast.parse(source))

    def span(self, node):
        return (
            self.begins[node.lineno - 1] + node.col_offset,
            self.begins[node.end_lineno - 1] + node.end_col_offset,
        )

    def note(self, anchor, key, text, where, name):
        start, end = self.span(anchor)
        if text.encode() != self.source[start:end]:
            fault = Fault(self.path, anchor.lineno, start, end, text, where, name)
            self.places.setdefault((start, key), []).append(fault)

    def statements(self, body, where, name):
        for one in body:
            if isinstance(one, ast.FunctionDef | ast.ClassDef):
                inner = f"{where}.{one.name}".strip(".")
                if isinstance(one, ast.FunctionDef):
                    self.expressions(one.args, where, name or one.name)
                    self.statements(one.body, inner, "")
                else:
                    self.statements(one.body, inner, name or one.name)
            else:
                self.statement(one, where, name or _defines(one))

    def statement(self, one, where, name):
        here = where, name
        if _is_text(one) or isinstance(one, ast.Import | ast.ImportFrom | ast.Assert):
            return
        if isinstance(one, ast.Raise | ast.Break | ast.Continue | ast.AugAssign) or (
            isinstance(one, ast.Expr) and isinstance(one.value, ast.Call)
        ):
            self.note(one, "delete", "pass", *here)
        if isinstance(one, ast.Raise):
            return
        if isinstance(one, ast.AugAssign) and type(one.op) in SWAPS:
            with _changed(one, "op", SWAPS[type(one.op)]()):
                self.note(one, "delete", ast.unparse(one), *here)
        if isinstance(one, ast.If | ast.While):
            self.note(one.test, "negate", f"not ({ast.unparse(one.test)})", *here)
        for field, value in ast.iter_fields(one):
            if field in ("body", "orelse", "finalbody"):
                self.statements(value, *here)
            elif field == "handlers":
                for handler in value:
                    self.statements(handler.body, *here)
            elif field not in ("annotation", "targets", "target"):
                self.field(one, field, value, None, *here)

    def expressions(self, node, where, name, anchor=None):
        """Faults of what is below a node; inside a text only the whole is replaced."""
        for field, value in ast.iter_fields(node):
            if field not in ("annotation", "returns"):
                self.field(node, field, value, anchor, where, name)

    def field(self, parent, field, value, anchor, where, name):
        if isinstance(value, list):
            for k, child in enumerate(value):
                self.field(value, k, child, anchor, where, name)
        elif isinstance(value, ast.expr):
            outer = anchor or value
            for new in self.changes(value):
                with _changed(parent, field, ast.copy_location(new, value)):
                    text = _printed(new if outer is value else outer, value)
                if text is not None:
                    self.note(outer, id(value), text, where, name)
            inside = isinstance(value, ast.JoinedStr)
            self.expressions(value, where, name, outer if anchor or inside else None)
        elif isinstance(value, ast.AST):
            self.expressions(value, where, name, anchor)

    def changes(self, node):
        """What may stand in the place of an expression by mistake."""
        match node:
            case ast.BinOp(left, op, right):
                yield from _of_sum(left, op, right)
            case ast.UnaryOp(ast.USub() | ast.Not(), operand):
                yield operand
            case ast.Compare(left, ops, others):
                for k, op in enumerate(ops):
                    other = [*ops[:k], SWAPS[type(op)](), *ops[k + 1 :]]
                    yield ast.Compare(left, other, others)
            case ast.BoolOp(op, values):
                yield ast.BoolOp(SWAPS[type(op)](), values)
                for k in range(len(values)):
                    rest = [*values[:k], *values[k + 1 :]]
                    yield ast.BoolOp(op, rest) if len(rest) > 1 else rest[0]
            case ast.IfExp(_, body, orelse):
                yield from (body, orelse)
            case ast.Constant(value):
                yield from (ast.Constant(other) for other in _values(value))
            case ast.Attribute(value, attr):
                if attr in ("T", "mT"):
                    yield value
                for other in self.siblings.get((ast.unparse(value), attr), ()):
                    yield ast.Attribute(value, other, ast.Load())
            case ast.Slice(lower, upper, step):
                one = ast.Constant(1)
                if lower is not None:
                    yield ast.Slice(ast.BinOp(lower, ast.Add(), one), upper, step)
                if upper is not None:
                    yield ast.Slice(lower, ast.BinOp(upper, ast.Sub(), one), step)
            case ast.Call(func, args, keywords) if _called(func) not in SILENT:
                swap = len(args) > 1 and _called(func) not in COMMUTE
                swap = swap and ast.dump(args[0]) != ast.dump(args[1])
                if swap and not any(isinstance(one, ast.Starred) for one in args):
                    yield ast.Call(func, [args[1], args[0], *args[2:]], keywords)
                for k in range(len(keywords)):
                    yield ast.Call(func, args, [*keywords[:k], *keywords[k + 1 :]])


def _called(func):
    return getattr(func, "attr", None) or getattr(func, "id", None)


def _of_sum(left, op, right):
    if isinstance(op, ast.MatMult):
        yield ast.BinOp(right, op, left)
    elif type(op) in SWAPS:
        yield ast.BinOp(left, SWAPS[type(op)](), right)
    if isinstance(op, ast.Add | ast.Sub):
        yield left
        yield right if isinstance(op, ast.Add) else ast.UnaryOp(ast.USub(), right)


def _values(value):
    """Constants beside a constant."""
    if isinstance(value, bool):
        yield not value
    elif isinstance(value, int):
        yield value + 1
        if value:
            yield value - 1
    elif isinstance(value, float) and value:
        yield float(f"{value * DECADES:.12g}")
        yield float(f"{value / DECADES:.12g}")
    elif isinstance(value, str) and not SENTENCE.search(value):
        for old, new in PRINTED.items():
            if old in value:
                yield value.replace(old, new, 1)


def _siblings(tree):
    """Letters that the file takes of one name, by their first: Q and Qs of `now`.

    A dictionary (name, attribute) -> other attributes.
    """
    taken = {}
    for node in ast.walk(tree):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            taken.setdefault(node.value.id, set()).add(node.attr)
    return {
        (name, one): sorted(b for b in have if b != one and b[0] == one[0])
        for name, attributes in taken.items()
        for have in [[one for one in attributes if len(one) <= LETTERS]]
        for one in have
    }


def _defines(statement):
    """The name that an assignment is to, or nothing."""
    targets = getattr(statement, "targets", None) or [getattr(statement, "target", 0)]
    return targets[0].id if isinstance(targets[0], ast.Name) else ""


def _is_text(statement):
    return isinstance(statement, ast.Expr) and isinstance(statement.value, ast.Constant)


def _printed(node, place):
    """Source of a node that fits any place; None where Python cannot print it."""
    try:
        text = ast.unparse(node)
    except ValueError:  # a backslash in the braces of a text
        return None
    plain = isinstance(place, ast.Slice | ast.JoinedStr | ast.Constant)
    return text if plain else f"({text})"


@contextmanager
def _changed(parent, field, new):
    """Put `new` into a field, or into a list, and the old one back."""
    if isinstance(parent, list):
        old, parent[field] = parent[field], new
    else:
        old = getattr(parent, field)
        setattr(parent, field, new)
    try:
        yield
    finally:
        if isinstance(parent, list):
            parent[field] = old
        else:
            setattr(parent, field, old)
