"""What depends on what: by definitions, and by equations that tie letters.

A line that differentiates or averages takes every letter for constant but its own.
That is wrong of a letter which a definition makes depend on one that moves, however
long the way, and it may be wrong of a letter which an equation ties to one.
"""

from collections.abc import Iterable, Iterator
from functools import lru_cache
from typing import Any

import sympy as sp

from .contents import KEPT
from .relations import Moment, Relation, Result
from .symbols import Over, Symmetric
from .words import Formula, is_letter, plain

Tied = dict[Any, Relation]  # by which relation each letter moves


@lru_cache(KEPT)
def letters(expr: Formula) -> frozenset[Any]:
    """The letters of an expression, for matrices and for numbers; no sizes.

    >>> import matrixproof
    >>> A, t = matrixproof.letters("A:n*n t")
    >>> sorted(map(str, letters(t * A)))
    ['A', 't']
    """
    matrices = expr.atoms(sp.MatrixSymbol)
    sizes = {s for m in expr.atoms(sp.MatrixExpr) for d in m.shape for s in symbols(d)}
    return frozenset(matrices | (expr.atoms(sp.Symbol) - sizes - expr.atoms(Over)))


def declared(symmetric: Iterable[Any], items: Iterable[Any]) -> tuple[Any, ...]:
    """Symmetric letters, and those in expressions and relations that are so by kind."""
    sides = [e for x in items for e in (x if isinstance(x, Relation) else (x,))]
    found = {x for e in sides for x in letters(plain(e)) if isinstance(x, Symmetric)}
    return tuple(dict.fromkeys([*symmetric, *sorted(found, key=str)]))


def symbols(size):
    return sp.sympify(size).free_symbols


def sides(relation):
    """The letters of the left and of the right side."""
    return letters(plain(relation.left)), letters(plain(relation.right))


def behind(relations: Iterable[Relation]) -> Iterator[Relation]:
    """Relations, and those on which the results among them rest."""
    waiting, seen = list(relations), set()
    while waiting:
        relation = waiting.pop(0)
        if relation in seen:
            continue
        seen.add(relation)
        if isinstance(relation, Result):
            chain = getattr(relation, "chain", None)
            waiting += chain.relations if chain is not None else ()
        else:
            yield relation


class Scope:
    """The relations of a page, or those that a chain cites, as ties between letters.

    `definitions` has the first relation with a letter alone on its left; in all other
    `equations` each letter may depend on each other.  `random` has the letters whose
    moments are known.  `held` are constant beside these: what the moments are, what
    lines which average take for constant, and what is defined by such letters.

    >>> from matrixproof import Relation, letters
    >>> A, B, C, S, X = letters("A:n*n B:n*n C:n*n S:n*n X:n*n")
    >>> scope = Scope([Relation("S = X' A", S, X.T * A), Relation("C = S", C, S)])
    >>> {str(x): r.name for x, r in scope.tied([X]).items()}
    {'S': "S = X' A", 'C': 'C = S'}
    """

    def __init__(self, relations: Iterable[Relation], averaged: Iterable[Any] = ()):
        self.definitions: dict[Any, Any] = {}
        self.random: dict[Any, Any] = {}
        self.equations: list[Any] = []
        moments = []
        for relation in dict.fromkeys(behind(relations)):
            left, (_, right) = plain(relation.left), sides(relation)
            single = is_letter(left)
            if isinstance(relation, Moment):
                moments.append(relation)
            elif single and left not in right and left not in self.definitions:
                self.definitions[left] = relation
            else:
                self.equations.append(relation)
        for moment in moments:
            self.random |= dict.fromkeys(sides(moment)[0], moment)
        self.held = set(averaged).union(*(sides(m)[1] for m in moments))
        self.held -= set(self.random)
        for letter, relation in self._in_turn():
            if sides(relation)[1] <= self.held and letter not in self.random:
                self.held.add(letter)

    def _in_turn(self):
        """Every definition, again and again, so that the last is known to the first."""
        return [*self.definitions.items()] * max(len(self.definitions), 1)

    def tied(self, moving: Iterable[Any]) -> Tied:
        """What cannot be held while letters move: {letter: what ties it to them}."""
        moving = set(moving)
        found = self._carried(moving, {})
        for letter in sorted(moving & set(self.definitions), key=str):
            relation = self.definitions[letter]
            inside = sides(relation)[1]
            if not inside & (moving | set(found)):  # one of these moves, and which?
                found = self._carried(moving, found | dict.fromkeys(inside, relation))
        return found

    def _carried(self, moving, found):
        """What moves with letters, and with what is known to move with them."""
        while True:
            before, known = len(found), moving | set(found)
            for letter, relation in self.definitions.items():
                if letter not in known and sides(relation)[1] & known:
                    found[letter] = relation
                    known.add(letter)
            for relation in self.equations:
                inside = frozenset().union(*sides(relation))
                if inside & known:
                    found |= dict.fromkeys(inside - known, relation)
                    known |= inside
            if len(found) == before:
                return found

    @property
    def not_constant(self) -> Tied:
        """What is held, and depends on random letters or must, for these to move."""
        known, found = set(self.random), {}
        changed = True
        while changed:
            changed = False
            for letter, relation in self.definitions.items():
                if letter not in known and sides(relation)[1] & known:
                    known.add(letter)
                    if letter in self.held:
                        found[letter] = relation
                    changed = True
            for relation in (*self.definitions.values(), *self.equations):
                inside = frozenset().union(*sides(relation))
                rest = inside - known
                if len(inside & known) == 1 and rest and rest - self.held == set():
                    found |= {x: relation for x in rest if x not in found}
                elif len(inside & known) == 1 and len(rest - self.held) == 1:
                    known |= rest - self.held
                    changed = True
        return found


def hidden(chains, relations=()):
    """{chain: {number of a line: what it takes for constant without right}}.

    `relations` is what the page says beside what the chains cite.
    """
    chains = list(chains)
    everything = [*relations, *(r for chain in chains for r in chain.relations)]
    operations = [step for chain in chains for step in _operations(chain)]
    averaged = (line.constants(left) for _, left, line in operations)
    scope = Scope(everything, frozenset().union(*averaged))
    return {
        chain: {k: line.hidden(left, scope) for k, left, line in _operations(chain)}
        for chain in chains
    }


def _operations(chain):
    """(Its number, what stands before, the line) of lines that do something to it."""
    before = (chain.left, *(line.right for line in chain.lines))
    for k, (left, line) in enumerate(zip(before, chain.lines), 1):
        if hasattr(line, "hidden"):
            yield k, left, line
