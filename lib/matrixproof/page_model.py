"""One model of everything that a page, a line or a claim rests on.

Each line can have a model of what it cites, while the page has none: A Y = I in one
chain and A Y = 2 I in another.  Then the page proves anything.  So one model is sought
in which all of it holds at once, the moments of random columns included.

Random columns have a joint second moment: the blocks E[w v'], and E[w] beside a 1.  A
matrix is one exactly if it is symmetric and not negative.  What the columns are made
of makes linear equations of its blocks: of e = A x + w, say, E[e w'] is A E[x w'] with
E[w w'] added.

Source: our own.
"""

from collections import deque
from collections.abc import Iterable
from functools import lru_cache, reduce
from operator import add
from typing import Any

import sympy as sp

from .algebra import Algebra, Blocks, Polynomial
from .dependence import letters, sides
from .models import Model, Setting, models
from .relations import Moment, Relation
from .symbols import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix
from .typeset import text
from .words import Formula, Symbols, Values, plain

ONE = None  # stands among the columns for the number 1


class NotLinear(ValueError):
    """A relation is not linear in columns that may be random."""


class Joint:
    """Relations with and without random columns, and what is known of their moments.

    `relations` are those in which nothing is random, and the equations of the moments;
    `blocks` is {(column, column): its joint second moment}, where that is not zero;
    `columns` are those of which all others are made; `symmetric` are second moments
    that nothing states.  Where `free` is true, what nothing states is free, or it is 0.

    >>> from matrixproof import letters
    >>> A, P, Q, e, w = letters("A:n*n P:n*n Q:n*n e:n w:n")
    >>> given = Moment("", w * w.T, Q), Relation("", e, A * w), Moment("", e * e.T, P)
    >>> [(str(r.left), str(r.right)) for r in Joint(given).relations]
    [('A*Q*A.T', 'P'), ('Q', 'Q.T')]
    """

    def __init__(self, relations: Iterable[Relation], free: bool = False):
        relations = list(relations)
        moments = [r for r in relations if isinstance(r, Moment)]
        others = [r for r in relations if not isinstance(r, Moment)]
        self.free, self.listed = free, set().union(*(sides(m)[0] for m in moments))
        constant = set().union(*(sides(m)[1] for m in moments))
        constant |= {x for r in others if not is_column(plain(r.left)) for x in of(r)}
        self._let_vary(others, constant)
        self.made: dict[Any, Any] = {}
        self.blocks: dict[Any, Any] = {}
        self.kept: list[Any] = []
        self.columns: list[Any] = []
        self.relations: list[Any] = []
        self.symmetric: list[Any] = []
        for relation in others:
            if of(relation) & self.vary:
                self._make(relation)
            else:
                self.relations.append(relation)
        self._read(moments)

    def _let_vary(self, relations, constant):
        """Which columns may be random: those beside one that is, in a relation."""
        self.vary, before = set(self.listed), 0
        while before != len(self.vary):
            before = len(self.vary)
            for relation in relations:
                inside = of(relation)
                if inside & self.vary:
                    columns = {x for x in inside - constant if is_column(x)}
                    self.vary |= columns

    # -- what columns are made of ---------------------------------------------------

    def _make(self, relation):
        """Solve a relation for a column, which then is made of others."""
        total = self._difference(relation)
        bare = [x for x, c in total.items() if x is not ONE and sign_of(c)]
        if not bare:
            self.kept.append((relation, total))
            return
        left = plain(relation.left)
        x = min(bare, key=lambda x: (x in self.listed, x != left, str(x)))
        c = sign_of(total.pop(x))
        new = {y: -c * d for y, d in total.items()}
        self.made[x] = new
        for y, parts in self.made.items():
            if x in parts:
                self.made[y] = combined(replaced(parts, x, new))
        self.kept = [(r, combined(replaced(t, x, new))) for r, t in self.kept]

    def _difference(self, relation):
        """Left less right as {column: coefficient}, of columns nothing is known of."""
        pairs = []
        for side, sign in ((relation.left, 1), (relation.right, -1)):
            for x, c in self._columns_of(Algebra().normal(plain(side)), relation):
                known = self.made.get(x, {x: None})
                pairs += [(y, sign * applied(c, d)) for y, d in known.items()]
        return combined(pairs)

    def _columns_of(self, value, relation):
        """(Column, coefficient) pairs of a normal form; a rest has the column ONE."""
        if isinstance(value, Blocks):
            if len(value.cols) > 1:
                raise NotLinear(relation.name)
            for i, (entry,) in enumerate(value.entries):
                for x, c in self._columns_of(entry, relation):
                    rows = [[ZeroMatrix(r, c.shape[1])] for r in value.rows]
                    rows[i] = [c]
                    yield x, BlockMatrix(rows)
            return
        if not isinstance(value, Polynomial) or value.shape[1] != 1:
            raise NotLinear(relation.name)
        for word, c in value.terms.items():
            at = [k for k, x in enumerate(word) if x.atom in self.vary]
            term = Polynomial(value.algebra, [(word, c)], value.shape)
            if not at:
                yield ONE, term.as_expr()
            elif at == [len(word) - 1] and not word[-1].transposed:
                x = word[-1].atom
                shape = value.shape[0], x.shape[0]
                yield x, Polynomial(value.algebra, [(word[:-1], c)], shape).as_expr()
            else:
                raise NotLinear(relation.name)

    # -- moments ----------------------------------------------------------------------

    def _read(self, moments):
        self.columns = sorted(self.vary - set(self.made), key=str)
        later = []
        for moment in moments:
            pair = self._pair(moment)
            if all(x in (ONE, *self.columns) for x in pair):
                self._state(moment, *pair)
            else:
                later.append((moment, pair))
        for moment, pair in later:
            self._equate(self._moment(*pair), moment.right, moment.name)
        for relation, total in self.kept:
            for z in (ONE, *self.columns):
                found = [applied(c, self._block(x, z)) for x, c in total.items()]
                if found := [t for t in found if not t.is_ZeroMatrix]:
                    right = ZeroMatrix(*found[0].shape)
                    self._equate(reduce(add, found), right, relation.name)
        self.free = False  # what is in no equation is zero
        for (x, y), block in list(self.blocks.items()):
            if x == y:
                self._equate(block, block.T, f"{x} {x}'")
        for x in dict.fromkeys(x for pair in list(self.blocks) for x in pair):
            if x is not ONE and (x, x) not in self.blocks:
                self.blocks[x, x] = MatrixSymbol(f"E[{x} {x}']", *x.shape[:1] * 2)
                self.symmetric.append(self.blocks[x, x])

    def _pair(self, moment):
        """The two columns of a moment; ONE for the second where there is one only."""
        ((word, c),) = Algebra().normal(plain(moment.left)).terms.items()
        turned = [x.transposed for x in word]
        columns = all(is_column(x.atom) for x in word)
        if c != 1 or not columns or turned not in ([False], [False, True]):
            raise NotLinear(moment.name)
        return word[0].atom, word[1].atom if len(word) == 2 else ONE

    def _state(self, moment, x, y):
        if (x, y) not in self.blocks and (y, x) not in self.blocks:
            self.blocks[x, y] = plain(moment.right)
        else:
            self._equate(self._block(x, y), plain(moment.right), moment.name)

    def _equate(self, left, right, name):
        self.relations.append(Relation(name, left, right))

    def _block(self, x, y):
        """E[x y'] of columns of which others are made."""
        shape = (1 if x is ONE else x.shape[0]), (1 if y is ONE else y.shape[0])
        if x is ONE and y is ONE:
            return Identity(1)
        if (x, y) in self.blocks:
            return self.blocks[x, y]
        if (y, x) in self.blocks:
            return self.blocks[y, x].T
        if not self.free:
            return ZeroMatrix(*shape)
        self.blocks[x, y] = MatrixSymbol(f"E[{x or 1} {y or 1}']", *shape)
        return self.blocks[x, y]

    def _moment(self, x, y):
        """E[x y'] of any columns."""
        one = {ONE: Identity(1)}
        first = one if x is ONE else self.made.get(x, {x: None})
        second = one if y is ONE else self.made.get(y, {y: None})
        terms = [
            applied(applied(c, self._block(a, b)), None if d is None else d.T)
            for a, c in first.items()
            for b, d in second.items()
        ]
        terms = [t for t in terms if not t.is_ZeroMatrix]
        shape = x.shape[0], (1 if y is ONE else y.shape[0])
        return reduce(add, terms) if terms else ZeroMatrix(*shape)

    def possible(self, world: Any) -> bool:
        """Whether the joint second moment is not negative in a world of numbers."""
        used = {x for pair in self.blocks for x in pair if x is not ONE}
        names = [ONE, *(x for x in self.columns if x in used)]
        rows: list[Any] = []
        for x in names:
            blocks = [world.value(self._block(x, y)) for y in names]
            rows += [sum(parts, []) for parts in zip(*blocks)]
        numbers = [[sp.Rational(p.get((), 0)) for p in row] for row in rows]
        return sp.Matrix(numbers).is_positive_semidefinite


def of(relation):
    """The letters of both sides."""
    left, right = sides(relation)
    return left | right


def is_column(x):
    return getattr(x, "shape", (0, 0))[1] == 1


def sign_of(c):
    """1 or -1 where a coefficient is plus or minus the identity, otherwise 0."""
    if c is None:
        return 1
    if c.has(sp.BlockMatrix):
        return 0
    terms = Algebra().normal(c).terms
    return int(terms[()]) if set(terms) == {()} and abs(terms[()]) == 1 else 0


def applied(c, d):
    """A product in which None stands for the identity."""
    if d is None:
        return c
    if c is None:
        return d
    if getattr(c, "is_ZeroMatrix", False) or getattr(d, "is_ZeroMatrix", False):
        return ZeroMatrix(c.shape[0], d.shape[1])
    return c * d


def replaced(total, x, made):
    """(Column, coefficient) pairs with what a column is made of in its place."""
    for y, c in total.items():
        if y == x:
            yield from ((z, applied(c, d)) for z, d in made.items())
        else:
            yield y, c


def combined(pairs):
    """{column: coefficient}, without those that are zero."""
    found = {}
    for x, c in pairs:
        found[x] = found[x] + c if x in found else c
    parted = [x for x, c in found.items() if c.has(sp.BlockMatrix)]
    return {
        x: c for x, c in found.items() if x in parted or not Algebra().normal(c).is_zero
    }


KNOWN: deque[tuple[frozenset, ...]] = deque(maxlen=200)  # what has a model
LIMIT = 160  # attempts to find a model, at generic sizes and at small ones
STRETCH = 40  # attempts until the other sizes are tried
SAID = "no model was found, within the limit of the search, in which {} at once"
MEND = (
    "change one of them, or, if all can hold, give a witness: exact values of letters "
    "from which the search finds the others, Derivation(..., witness={letter: value})"
)


@lru_cache(1000)
def one_model(
    relations: tuple[Relation, ...],
    symmetric: frozenset = frozenset(),
    also: tuple[Formula, ...] = (),
    witness: tuple[tuple[Any, Any], ...] = (),
) -> Model | None:
    """A `Model` of relations and moments, or None if none was found.

    Letters of the witness, of (letter, value) pairs, have those values.

    >>> from matrixproof import Identity, letters
    >>> (w,) = letters("w:n")
    >>> one = Identity(w.rows)
    >>> [one_model((Moment("", w * w.T, x),)) is None for x in (one, -one)]
    [False, True]
    """
    moments = any(isinstance(r, Moment) for r in relations)
    ways = [Joint(relations, free) for free in (False, True)[: 1 + moments]]
    settings = [
        Setting(
            way.relations,
            symmetric.union(way.symmetric),
            (*also, *way.blocks.values()),
            dict(witness),
        )
        for way in ways
    ]
    turns = list(zip(ways, settings)) * 2
    for k in range(0, LIMIT, STRETCH):
        for turn, (way, setting) in enumerate(turns):
            small = turn >= len(ways)
            sizes = setting.small_sizes() if small else setting.generic_sizes()
            for found in models(setting, sizes, range(k, k + STRETCH)):
                if way.possible(found.world):
                    return found
    return None


def values_of(witness, symmetric):
    """{letter: its value}; a number stands for a matrix of one entry."""
    found = {}
    for letter, value in witness.items():
        if isinstance(letter, sp.MatrixSymbol):
            value = sp.ImmutableMatrix(value if hasattr(value, "__len__") else [value])
            if letter in symmetric and value != value.T:
                raise ValueError(f"{text(letter)} of the witness is not symmetric")
        found[letter] = value
    return found


def clashing(relations, symmetric=frozenset(), also=()):
    """Of relations without a model, some of which each is needed to have none."""
    needed = list(relations)
    for relation in relations:
        others = tuple(r for r in needed if r is not relation)
        if one_model(others, symmetric, also) is None:
            needed.remove(relation)
    return needed


def impossible(
    relations: Iterable[Relation],
    symmetric: Symbols = (),
    also: Iterable[Formula] = (),
    witness: Values | None = None,
) -> list[str]:
    """A complaint if no model was found, which names the relations that clash.

    A model of a page is one of its chains, too, and is not sought again.
    """
    relations, also = tuple(relations), tuple(also)
    known = frozenset(symmetric)
    sides = [plain(e) for e in (*(e for r in relations for e in r), *also)]
    occur = set().union(*map(letters, sides))  # before the end of a scope, not all
    values = values_of(witness or {}, known)
    given = tuple((x, value) for x, value in values.items() if x in occur)
    asked = frozenset(relations), known, frozenset(also)
    if not given and any(all(map(frozenset.issubset, asked, had)) for had in KNOWN):
        return []
    try:
        if one_model(relations, known, also, given) is not None:
            KNOWN.append(asked)
            return []
    except NotLinear as e:
        return [f"{e} is not linear in what may be random: {MEND}"]
    if given:
        return [SAID.format("all that the page says holds") + ", with this witness"]
    said = " and ".join(r.show(text) for r in clashing(relations, known, also))
    what = f"{said} hold" if said else "all that is inverted has an inverse"
    return [f"{SAID.format(what)}: {MEND}"]
