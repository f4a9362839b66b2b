"""From SymPy to plain data: what is to be proved, and from what.

Everything is multiplied out as written; nothing cancels and nothing is reordered.
A side is `(shape, terms)`: `terms` is {word: coefficient}, a word is a tuple of
letters, a letter is `(name, transposed)`.  A scalar has no shape; its words stand for
traces and the empty word for 1.

A `Problem` is a statement in the terms of the engine: its letters are integers.
"""

from dataclasses import dataclass, field
from fractions import Fraction

import sympy as sp
from sympy import Pow

from .algebra import Algebra, Blocks, Polynomial, Traces, same
from .contents import is_partial, parts
from .families import degree, left_open, scopes, settled, shown, sums
from .relations import named, refuse_means
from .symbols import Identity, Own
from .words import Letter, ShapeError, exact, plain, same_shape, same_size


@dataclass(frozen=True)
class Statement:
    """A claim and what it rests on, in plain data that needs no SymPy matrices.

    Attributes
    ----------
    claims, given : dict of str to (left, right)
        The claim, block by block where it is partitioned, and the relations likewise.
    inverses : dict of str to side
        What each inverse letter is the inverse of.
    symmetric : frozenset of str
    sizes : dict of str to (rows, columns)
    lemmas : dict of str to (p, q, c)
        Square sides with p q = c I, proved on the way; then q p = c I.
    sums : dict of number to frozenset of str
        The signs of sums over an index, and the letters that depend on it.
    """

    claims: dict
    given: dict = field(default_factory=dict)
    inverses: dict = field(default_factory=dict)
    symmetric: frozenset = frozenset()
    sizes: dict = field(default_factory=dict)
    lemmas: dict = field(default_factory=dict)
    sums: dict = field(default_factory=dict)

    @property
    def every_side(self):
        """The sides of the claims, of the relations, and what is inverted."""
        pairs = (*self.claims.values(), *self.given.values())
        return [*(side for pair in pairs for side in pair), *self.inverses.values()]

    @property
    def words(self):
        """Every word of them, as often as it occurs."""
        return [word for _, terms in self.every_side for word in terms]

    def sides(self, claim):
        """Left and right of a claim or a lemma."""
        if claim not in self.lemmas:
            return self.claims[claim]
        p, q, c = self.lemmas[claim]
        return (p[0], product(p[1], q[1])), (p[0], {(): c})


class Free(Algebra):
    """The free algebra: nothing is known of the symbols, so that nothing cancels.

    The inverse of a composite is a letter of its own.
    """

    def __init__(self):
        super().__init__()
        self.composites = {}  # symbol: (the expression it stands for, its value)
        self.partitioned = {}  # expression: the blocks of its inverse, its value
        self.names, self.inverses = {}, {}
        self.indices = {}  # of the blocks of an inverse
        self.made = set()  # the names of our own symbols

    def reduced(self, pairs):
        return settled(pairs)

    reduced_cyclically = reduced

    def depends(self, atom):
        """The indices on which a letter depends; an inverse, on those of its base."""
        if atom in self.composites:
            return left_open(self.composites[atom][1])
        return self.indices.get(atom) or super().depends(atom)

    def spelled(self, expr):
        """An expression with its composites written out."""
        return expr.xreplace({s: base for s, (base, _) in self.composites.items()})

    def _inverted(self, base):
        value = self.normal(base)
        if not same_size(*value.shape):
            raise ShapeError(f"{base} of shape {value.shape} has no inverse")
        if isinstance(value, Blocks):
            return self._inverted_blocks(base, value)
        if len(value.terms) == 1:
            ((word, c),) = value.terms.items()
            again = word and word[0].inverted and word[0].atom in self.composites
            if len(word) == 1 and again and c == 1:  # the inverse of an inverse
                known = self.composites[word[0].atom][1]
                return known.T if word[0].transposed else known
            if len(word) < 2 and c.is_zero is False:
                turned = tuple(x._replace(inverted=not x.inverted) for x in word)
                return value.like([(turned, 1 / c)])
        return self._inverted_composite(base, value)

    def _inverted_composite(self, base, value):
        for symbol, (_, known) in self.composites.items():
            for turned in (False, True):
                if same_shape(known.shape, value.shape) and (
                    (known.T if turned else known).terms == value.terms
                ):
                    return value.like([((self.letter(symbol, turned, True),), 1)])
        symbol = self._own(f"({base})", value.shape)
        self.composites[symbol] = (base, value)
        return value.like([((self.letter(symbol, False, True),), 1)])

    def _inverted_blocks(self, base, value):
        if not same(value.rows, value.cols):
            raise ShapeError(f"no inverse of blocks {value.rows} x {value.cols}")
        if base not in self.partitioned:
            block = lambda i, j: self._own(  # noqa: E731
                f"({base})^-1[{i + 1},{j + 1}]", (value.rows[i], value.cols[j])
            )
            k = range(len(value.rows))
            symbols = [[block(i, j) for j in k] for i in k]
            inside = left_open(value)
            self.indices |= {s: inside for row in symbols for s in row}
            grid = [[self.normal(s) for s in row] for row in symbols]
            self.partitioned[base] = (Blocks(self, grid), value)
        return self.partitioned[base][0]

    def _own(self, text, shape):
        """A new symbol.  What differs may look alike: two scalars called t."""
        name = unused(text, self.made)
        self.made.add(name)
        return Own(name, *shape)

    # -- plain data ---------------------------------------------------------------

    def name(self, letter):
        """The name of a letter; no two symbols share one, whatever they are called."""
        key = (letter.atom, letter.inverted)
        if key not in self.names:
            name = letter.atom.name + ("^-1" if letter.inverted else "")
            taken = set(self.names.values())
            if name in taken:
                name = unused(name + " ({} x {})".format(*letter.atom.shape), taken)
            self.names[key] = name
            if letter.inverted:
                base = Polynomial(self, [((Letter(letter.atom),), 1)], key[0].shape)
                self.inverses[name] = self.composites.get(key[0], (None, base))[1]
        return self.names[key]

    def side(self, value):
        """(shape, {word: coefficient}) of a normal form."""
        shape = None if isinstance(value, Traces) else value.shape
        for s in (s for c in value.terms.values() for s in sums(c)):
            if any(degree(c, s) > 1 for c in value.terms.values()):
                raise ValueError(
                    f"there is a sum over {shown(s.index)} within another, or it is "
                    "divided by: use another index"
                )
        plain = {
            tuple((self.name(x), x.transposed) for x in word): c
            for word, c in value.terms.items()
        }
        return shape, plain

    def equations(self, name, left, right):
        """{name: (side, side)}, an entry for each block of a partitioned equation."""
        left = self.normal(left)
        if isinstance(right, int) and right == 0:
            right = 0 * left
        right = self.normal(right)
        if not isinstance(left, Blocks) and not isinstance(right, Blocks):
            if isinstance(left, Traces) != isinstance(right, Traces):
                raise ShapeError(f"{name}: a scalar and a matrix are never equal")
            if isinstance(left, Polynomial) and not same_shape(left.shape, right.shape):
                raise ShapeError(
                    f"{name}: shapes {left.shape} and {right.shape} are not the same"
                )
            return {name: (self.side(left), self.side(right))}
        whole = left if isinstance(left, Blocks) else right
        left, right = (Blocks.spread(x, whole.rows, whole.cols) for x in (left, right))
        if not (same(left.rows, right.rows) and same(left.cols, right.cols)):
            raise ShapeError(f"{name}: the two sides are partitioned differently")
        return {
            f"{name} [{i + 1},{j + 1}]": (self.side(left[i, j]), self.side(right[i, j]))
            for i in range(len(left.rows))
            for j in range(len(left.cols))
        }


def read(left, right, given=(), symmetric=()):
    """The `Statement` of a claim, and the free algebra in which it was read."""
    given = named(given)
    refuse_means(given)
    sound(left, right, *(side for relation in given for side in relation))
    free = Free()
    for side in (left, right, *(side for relation in given for side in relation)):
        free.made |= {s.name for s in plain(side).atoms(Own)}
    claims = free.equations("claim", left, right)
    known = {}
    for relation in given:
        for name, sides in free.equations(relation.name, *relation).items():
            known[unused(name, known)] = sides
    for base, (inverse, value) in free.partitioned.items():
        whole = Identity(value.shape[0])
        for name, both in (("M M^-1", value @ inverse), ("M^-1 M", inverse @ value)):
            block = free.equations(f"{name} = I, M = {base}", both, whole)
            known |= {unused(name, known): sides for name, sides in block.items()}
    inverses = {}
    while len(inverses) < len(free.inverses):  # a base may bring in further inverses
        inverses |= {k: free.side(v) for k, v in list(free.inverses.items())}
    for s in symmetric:
        if not same_size(*s.shape):
            raise ShapeError(f"{s} of shape {s.shape} is not symmetric")
    told = frozenset(free.name(Letter(s)) for s in symmetric)
    sizes = {name: tuple(atom.shape) for (atom, _), name in free.names.items()}
    every = (left, right, *(side for relation in given for side in relation))
    families = scopes(free, *every)
    return Statement(claims, known, inverses, told, sizes, sums=families), free


def sound(*sides):
    """Refuse numbers that are not exact, and quotients by what may be zero for sizes.

    A size is not a letter that one may choose: what is said is said for all of them.
    """
    sides = [exact(plain(side)) for side in sides]
    sizes = {
        s for side in sides for d in parts(side).dimensions for s in d.free_symbols
    }
    for side in sides:
        for power in side.atoms(Pow) if sizes else ():
            if not (is_partial(power) and power.base.free_symbols & sizes):
                continue
            if power.exp.is_negative and power.base.is_zero is not False:
                raise ValueError(f"{power.base} may be zero, and is divided by")
            if not power.exp.is_Integer and power.base.is_nonnegative is not True:
                raise ValueError(f"{power.base} may be negative, and has a root")


def unused(name, taken):
    """The name, with a number behind it if it is taken."""
    k, found = 1, name
    while found in taken:
        k += 1
        found = f"{name} ({k})"
    return found


def product(p, q):
    """The product of two polynomials {word: coefficient}."""
    found = {}
    for u, c in p.items():
        for v, d in q.items():
            found[u + v] = found.get(u + v, 0) + c * d
    return found


def flip(word):
    return tuple((name, not transposed) for name, transposed in reversed(word))


class Problem:
    """The letters of a statement in some order, and its polynomials over them.

    `order` is one of `ORDERS`: which letters are great, so that rules get rid of them.
    """

    def __init__(self, statement, order="inverses"):
        self.statement = statement
        self.field, self.zero = field_of(statement)
        self.symmetric = self._all_symmetric()
        names = ORDERS[order](statement)
        self.letters, self.index = [], {}
        for name in names:
            for transposed in (False, True):
                if transposed and name in self.symmetric:
                    self.index[name, True] = self.index[name, False]
                    continue
                self.index[name, transposed] = len(self.letters)
                self.letters.append((name, transposed))
        self.sizes = {
            symbol
            for size in statement.sizes.values()
            for d in size
            for symbol in sp.sympify(d).free_symbols
        }
        self.flip = [self.index[name, not t] for name, t in self.letters]
        heavy = heavy_names(statement) if order == "definitions" else {}
        self.weight = [heavy.get(name, 1) for name, _ in self.letters]
        self.facts, self.generators, self.scalars = {}, [], []
        self.numbers = list(one_by_one(statement))
        self._collect()

    def _all_symmetric(self):
        """The symmetric letters, among them the inverses of what is symmetric."""
        known = set(self.statement.symmetric)
        found = True
        while found:
            found = {
                name
                for name, (_, terms) in self.statement.inverses.items()
                if name not in known and is_symmetric(terms, known)
            }
            known |= found
        return known

    def _collect(self):
        for name, ((shape, left), (_, right)) in self.statement.given.items():
            terms = self.terms(left, right)
            if shape is not None:
                self._add(("given", name), terms)
            elif terms:
                self.scalars.append((terms, len(self.generators)))
                self._add(("given", name), {})
        for name, (_, base) in self.statement.inverses.items():
            y = ((name, False),)
            for kind in ("right inverse", "left inverse"):
                side = {w + y if kind[0] == "r" else y + w: c for w, c in base.items()}
                self._add((kind, name), self.terms(side, {(): 1}))
        for a, b in self.numbers:
            left, right = (a + b, b + a) if b else (a, flip(a))
            self._add(("number", (a, b)), self.terms({left: 1}, {right: 1}))

    def _add(self, fact, terms):
        self.facts[len(self.generators)] = fact
        self.generators.append(terms)

    @property
    def turns(self):
        """Whether the transposes of relations can matter."""
        known = bool(self.symmetric or self.numbers)
        return known or any(t for w in self.statement.words for _, t in w)

    def word(self, plain):
        return tuple(self.index[x] for x in plain)

    def spelled(self, word):
        """The plain word of an engine's word."""
        return tuple(self.letters[x] for x in word)

    def terms(self, left, right):
        """The difference of two plain sides."""
        found = {}
        for side, sign in ((left, 1), (right, -1)):
            for spelled, c in side.items():
                word = self.word(spelled)
                found[word] = found.get(word, 0) + sign * self.number(c)
        return {w: c for w, c in found.items() if c}

    def rows(self, letter):
        """The number of rows of a letter, as a coefficient."""
        name, transposed = self.letters[letter]
        return self.number(self.statement.sizes[name][1 if transposed else 0])

    def square(self, word):
        """Whether a word is provably square."""
        (name, t), (last, u) = self.spelled((word[0], word[-1]))
        sizes = self.statement.sizes
        return same_size(sizes[name][1 if t else 0], sizes[last][0 if u else 1])

    def side(self, terms, letter):
        """The plain side of a square polynomial, as large as a letter's rows."""
        name, t = self.letters[letter]
        size = self.statement.sizes[name][1 if t else 0]
        plain = {self.spelled(w): self.coefficient(c) for w, c in terms.items()}
        return (size, size), plain

    def number(self, c):
        """A coefficient for the engine."""
        if self.field is None and isinstance(c, (int, Fraction)):
            return c
        c = sp.sympify(c)
        if self.field is not None:
            return self.field.from_sympy(c)
        return int(c) if c.is_Integer else Fraction(int(c.p), int(c.q))

    def coefficient(self, c):
        """Back from the engine: a whole number, a Fraction or a SymPy expression."""
        if isinstance(c, (int, Fraction)) or self.field is None:
            return c
        return self.field.to_sympy(c)

    def solid(self, c):
        """Whether one may divide by a coefficient: it is certainly not zero.

        Where no relations are given, both sides are rational functions of free entries.
        They are then equal wherever they are defined if they are equal where some
        polynomial in the scalars is not zero, and one may divide by that.
        """
        if isinstance(c, (int, Fraction)):
            return bool(c)
        c = sp.factor(self.coefficient(c))
        if c.free_symbols & set(self.statement.sums):
            return True  # for now: no certificate with it below is taken
        free = not self.statement.given and not c.free_symbols & self.sizes
        return c != 0 if free else c.is_zero is False

    def multiple(self, a, c):
        """What c is multiplied by to be a, where nothing is divided by; else 0."""
        if self.field is None or not a:
            return 0
        _, below = sp.fraction(sp.cancel(self.coefficient(a / c)))
        return a / c if below.is_number else 0


def is_symmetric(terms, known):
    """Whether a plain polynomial is its own transpose, given the symmetric letters."""

    def settled(word):
        return tuple((name, t and name not in known) for name, t in word)

    def turned(word):
        return settled((name, not t) for name, t in reversed(word))

    settled_terms = {settled(w): c for w, c in terms.items()}
    return settled_terms == {turned(w): c for w, c in terms.items()}


def field_of(statement):
    """The SymPy field of the coefficients, None for the rationals; and its zero."""
    sides = statement.every_side
    numbers = {sp.sympify(c) for _, terms in sides for c in terms.values()}
    if any(shape is None for shape, _ in sides):  # the trace of an identity is a size
        numbers |= {sp.sympify(d) for size in statement.sizes.values() for d in size}
    if all(c.is_Rational for c in numbers):
        return None, 0
    field, _ = sp.construct_domain(sorted(numbers, key=str), field=True)
    return field, field.zero


def one_by_one(statement):
    """Pairs of plain words that say what a 1 x 1 matrix does.

    (a, ()) stands for a = a', and (a, b) for a b = b a.
    """
    loops = sorted({x for w in statement.words for x in scalars(statement, w)})
    yield from ((a, ()) for a in loops)
    yield from ((a, b) for i, a in enumerate(loops) for b in loops[:i])


def scalars(statement, word):
    """The shortest pieces of a word that are 1 x 1."""
    sizes = [statement.sizes[name][1 if t else 0] for name, t in word]
    sizes += [statement.sizes[name][0 if t else 1] for name, t in word[-1:]]
    cuts = [i for i, size in enumerate(sizes) if same_size(size, 1)]
    return [word[i:j] for i, j in zip(cuts, cuts[1:])]


# -- orders of letters ----------------------------------------------------------------


def inverses_last(statement):
    """Inverses are greatest, so that rules drive them to the right."""
    names = dict.fromkeys(name for word in statement.words for name, _ in word)
    names |= dict.fromkeys(statement.sizes)
    return sorted(names, key=lambda name: name in statement.inverses)


def inverses_first(statement):
    return inverses_last(statement)[::-1]


def heavy_names(statement):
    """Weights that make a letter greater than the words that define it."""
    heavy = {}
    for (_, left), (_, right) in statement.given.values():
        for side, other in ((left, right), (right, left)):
            words = list(side)
            if len(words) == 1 and len(words[0]) == 1 and other:
                ((name, _),) = words[0]
                if not any(name == x for word in other for x, _ in word):
                    longest = max(sum(heavy.get(x, 1) for x, _ in w) for w in other)
                    heavy[name] = longest + 1
                    break
    return heavy


ORDERS = {
    "inverses": inverses_last,
    "reversed": inverses_first,
    "definitions": inverses_last,
}
