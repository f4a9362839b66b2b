"""A statement in the terms of the engine: letters as integers, exact coefficients."""

from fractions import Fraction

import sympy as sp

from .certificates import flip
from .finite import one_by_one
from .words import same_size


class Problem:
    """The letters of a statement in some order, and its polynomials over them.

    Parameters
    ----------
    statement : Statement
    order : str
        One of `ORDERS`: which letters are great, so that rules get rid of them.
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
            for plain, c in side.items():
                word = self.word(plain)
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


# -- orders of letters ----------------------------------------------------------------


def appearance(statement):
    """The names in the order in which they appear."""
    seen = {name: 0 for word in statement.words for name, _ in word}
    return [*seen, *(name for name in statement.sizes if name not in seen)]


def inverses_last(statement):
    """Inverses are greatest, so that rules drive them to the right."""
    names = appearance(statement)
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
