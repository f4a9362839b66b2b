"""Which names of a function need no place in memory."""

import ast
from collections.abc import Sequence

Block = tuple[int, ...]  # a block of lines by numbers, those around it first


class _Found:
    """Where each name is bound and read, in the order of the lines."""

    def __init__(self) -> None:
        self.bound: dict[str, list[tuple[int, Block]]] = {}
        self.readings: list[tuple[str, int, Block]] = []
        self.number = 0

    def read(self, node: ast.AST, at: Block) -> None:
        for one in ast.walk(node):
            if isinstance(one, ast.Name) and isinstance(one.ctx, ast.Load):
                self.readings.append((one.id, self.number, at))

    def bind(self, node: ast.expr, at: Block) -> None:
        if isinstance(node, ast.Name):
            self.number += 1
            self.bound.setdefault(node.id, []).append((self.number, at))
        else:
            self.read(node, at)

    def lines(self, lines: Sequence[ast.stmt], at: Block) -> None:
        for line in lines:
            self.number += 1
            inner = (*at, self.number)
            if isinstance(line, ast.For):
                self.read(line.iter, at)
                self.bind(line.target, inner)
                self.lines(line.body, inner)
            elif isinstance(line, ast.If):
                self.read(line.test, at)
                self.lines(line.body, inner)
                self.lines(line.orelse, (*at, -self.number))
            elif isinstance(line, ast.Assign):
                self.read(line.value, at)
                self.bind(line.targets[0], at)
            elif isinstance(line, ast.AugAssign):
                self.read(line.value, at)
                if isinstance(line.target, ast.Name):
                    self.readings.append((line.target.id, self.number, at))
                self.bind(line.target, at)
            else:
                self.read(line, at)

    def surely(self, name: str, number: int, at: Block) -> bool:
        """Whether what a name means where it is read is what was last bound above.

        That is so if its line is run whenever the reading is, and no line further
        down can come before the reading in another turn of a loop.
        """
        bound = self.bound[name]
        *_, block = next(
            (one for one in reversed(bound) if one[0] <= number), (0, (0,))
        )
        later = [other for first, other in bound if first > number]
        return at[: len(block)] == block and not any(
            len(block) < len(at) and at[: len(block) + 1] == other[: len(block) + 1]
            for other in later
        )


def plain_names(function: ast.FunctionDef) -> frozenset[str]:
    """The names that mean, wherever they are read, what was last bound above."""
    found = _Found()
    for one in function.args.args:
        found.bind(ast.Name(one.arg, ast.Store()), ())
    found.lines(function.body, ())
    plain = set(found.bound)
    for name, number, at in found.readings:
        if name in plain and not found.surely(name, number, at):
            plain.remove(name)
    return frozenset(plain)
