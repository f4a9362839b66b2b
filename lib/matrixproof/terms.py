"""What an operation makes of a line: normal forms written in the order of the work.

A `Polynomial` sorts nothing, so its terms stand as they arose; here they become
expressions again, are put into brackets, and are found again where a relation has
them.
"""

import sympy as sp

from .algebra import Blocks, Polynomial, Traces, same
from .symbols import (
    BlockMatrix,
    Identity,
    MatrixProduct,
    MatrixSum,
    ZeroMatrix,
    plus,
)
from .words import gather, rotations

OFTEN = 50  # rewritings of one line, after which a relation does not come to an end


def term(word, c, rows):
    """A word with its coefficient as an expression; `rows` is the size of its I."""
    one = () if word else (Identity(rows),)
    return MatrixProduct(c, *(x.as_expr() for x in word), *one)


def summed(terms, rows, columns):
    """A sum of (word, coefficient) pairs in that order, but no minus in front."""
    found = [(c, term(word, c, rows)) for word, c in terms]
    first = next((k for k, (c, _) in enumerate(found) if not negative(c)), 0)
    found = [
        x for _, x in (*found[first : first + 1], *found[:first], *found[first + 1 :])
    ]
    return MatrixSum(*found) if found else ZeroMatrix(rows, columns)


def negative(number):
    """Whether a coefficient is written with a minus."""
    return number.could_extract_minus_sign()


def written(value):
    """A normal form as an expression, its terms in the order in which they arose."""
    if isinstance(value, Blocks):
        return BlockMatrix([[written(x) for x in row] for row in value.entries])
    if isinstance(value, Polynomial):
        return summed(value.terms.items(), *value.shape)
    return scalar(value.terms)


def whole(value):
    """The same, but blocks that make an identity or a zero matrix are that."""
    if isinstance(value, Blocks):
        if value.is_zero:
            return ZeroMatrix(*value.shape)
        if same(value.rows, value.cols) and (value - Identity(value.shape[0])).is_zero:
            return Identity(value.shape[0])
    return written(value)


def as_before(value, expr):
    """A normal form written; a trace that stood in the expression stands as it did."""
    if not isinstance(value, Traces):
        return written(value)
    stood = {}
    for word in opened(expr, value.algebra):
        for key in Traces(value.algebra, [(word, 1)]).terms:
            stood.setdefault(key, word)
    return scalar({stood.get(w, w): c for w, c in value.terms.items()})


def put_in(expr, meant):
    """An expression with something replaced; the terms of a sum keep their order."""
    if isinstance(expr, sp.Add) and not isinstance(expr, sp.MatAdd):
        return plus(*(term.xreplace(meant) for term in expr.args))
    return sp.sympify(expr).xreplace(meant)


def scalar(terms):
    """{word: coefficient} as a sum of traces; the empty word stands for 1."""
    return plus(*(c * sp.Trace(term(w, 1, 0)) if w else c for w, c in terms.items()))


def opened(expr, algebra):
    """A sum of traces multiplied out, {word: coefficient}; no trace is rotated."""
    return gather(_opened(sp.sympify(expr), algebra))


def _opened(expr, algebra):
    inside = [f for f in sp.Mul.make_args(expr) if f.has(sp.Trace)]
    if isinstance(expr, sp.Add):
        for term in expr.args:
            yield from _opened(term, algebra)
    elif isinstance(expr, sp.Trace):
        value = algebra.normal(expr.arg)
        whole = not isinstance(value, Blocks)
        for x in [value] if whole else [value[i, i] for i in range(len(value.rows))]:
            yield from ((w, c if w else c * x.shape[0]) for w, c in x.terms.items())
    elif inside:
        number = sp.Mul(*(f for f in sp.Mul.make_args(expr) if f not in inside))
        yield from ((w, number * c) for w, c in _opened(sp.Mul(*inside), algebra))
    else:
        yield (), expr


def joined(terms, algebra, first=None):
    """{word: coefficient} of traces, of which those that are equal are one.

    Each stands as it first did, or begins with a factor where it has that.
    """
    kept, total = {}, []
    for word, c in terms.items():
        for key, share in Traces(algebra, [(word, c)]).terms.items():
            turned = rotations(word) + rotations(algebra.flipped(word))
            front = [w for w in turned if w and w[0].as_expr() == first]
            same = len(key) == len(word)  # nothing in it has cancelled
            stands = (front or [word])[0] if same else key
            total.append((kept.setdefault(key, stands), share))
    return gather(total)


# -- brackets -------------------------------------------------------------------------


def common(words):
    """How many letters all words begin with."""
    k = 0
    while all(len(w) > k for w in words) and len({w[k] for w in words}) == 1:
        k += 1
    return k


def factored(value):
    """A polynomial with what is common to its terms before and behind a bracket.

    Where all have no factor in common, those that begin and end alike are joined, or
    begin, or end alike; a number in common stands before them all.
    """
    if isinstance(value, Blocks):
        return BlockMatrix([[factored(x) for x in row] for row in value.entries])
    terms = list(value.terms.items())
    number = sp.gcd_list([c for c in value.terms.values()]) if terms else 1
    words = [w for w, _ in terms]
    if number != 1 and not (common(words) or common([w[::-1] for w in words])):
        inside = value.like((w, sp.cancel(c / number)) for w, c in terms)
        return MatrixProduct(number, factored(inside))
    if whole := bracket(terms, value):
        return whole
    for key in (lambda w: (w[0], w[-1])), (lambda w: w[0]), (lambda w: w[-1]):
        groups = {}
        for w, c in terms:
            groups.setdefault(key(w) if w else (), []).append((w, c))
        if len(groups) < len(terms):
            parts = [
                bracket(g, value) or summed(g, *value.shape) for g in groups.values()
            ]
            return MatrixSum(*parts)
    return written(value)


def together(value):
    """What is common to all terms, before and behind a bracket."""
    terms = [*value.terms.items()]
    matrix = isinstance(value, Polynomial)
    return (matrix and bracket(terms, value)) or written(value)


def bracket(terms, value):
    """number * prefix * (sum) * suffix of at least two terms, or None."""
    if len(terms) < 2:
        return None
    words, number = [w for w, _ in terms], sp.gcd_list([c for _, c in terms])
    a = common(words)
    b = common([w[a:][::-1] for w in words])
    if not (a or b) and number == 1:
        return None
    before, behind = words[0][:a], words[0][len(words[0]) - b :] if b else ()
    rows = columns_of(before, value.shape[0])
    inside = [(w[a : len(w) - b], sp.cancel(c / number)) for w, c in terms]
    inner = summed(inside, rows, rows)
    outer = [[x.as_expr() for x in word] for word in (before, behind)]
    return MatrixProduct(number, *outer[0], inner, *outer[1])


def columns_of(word, rows):
    """The columns of a word; of the empty one, that has these rows, as many."""
    return word[-1].atom.shape[0 if word[-1].transposed else 1] if word else rows


# -- terms that are found again -------------------------------------------------------


class Pattern:
    """A sum of words that stands in a line, and what takes its place."""

    def __init__(self, old, new):
        self.old, self.new = list(old.terms.items()), list(new.terms.items())
        self.algebra, self.shape = old.algebra, old.shape
        nothing = (), 0
        self.lead, self.number = max(
            self.old, key=lambda term: len(term[0]), default=nothing
        )

    def solved(self, k):
        """The same for the k-th longest word alone, by taking the others across."""
        longest = sorted(self.old, key=lambda term: -len(term[0]))
        lead, number = longest[k]
        others = [(w, -c) for w, c in self.old if w != lead]
        parts = [(w, c / number) for w, c in (*self.new, *others)]
        make = [[(lead, 1)], parts]
        return Pattern(*(Polynomial(self.algebra, x, self.shape) for x in make))

    def replaced(self, value):
        """A normal form in which it is replaced wherever it stands; None if nowhere."""
        if not self.lead:
            return None
        if isinstance(value, Blocks):
            found = [[self.replaced(x) for x in row] for row in value.entries]
            if all(x is None for row in found for x in row):
                return None
            rows = zip(found, value.entries)
            return Blocks(
                value.algebra,
                [[y if x is None else x for x, y in zip(*row)] for row in rows],
            )
        found = None
        for _ in range(OFTEN):
            step = self._once(value)
            if step is None:
                return found
            value = found = step
        raise ValueError("what is rewritten comes again and again: put it in once")

    def _once(self, value):
        for word, c in value.terms.items():
            for make in self._contexts(word, isinstance(value, Traces)):
                share = c / self.number
                old = value.like(make(w, share * d) for w, d in self.old)
                if all(
                    sp.expand(value.terms.get(w, 0) - d) == 0
                    for w, d in old.terms.items()
                ):
                    return self._exchanged(value, word, old, make, share)
        return None

    def _contexts(self, word, cyclic):
        """For each place of the lead in a word, what a word becomes that stands there.

        In a trace every rotation of the word is looked at; a pattern that is transposed
        stands for words that are.
        """
        k, size = len(self.lead), self.shape[0]
        if cyclic:
            for w in rotations(word) if word else ():
                if w[:k] == self.lead:
                    yield lambda x, c, rest=w[k:]: (
                        x + rest,
                        c if x + rest else c * size,
                    )
            return
        for i in range(len(word) - k + 1):
            if word[i : i + k] == self.lead:
                u, v = word[:i], word[i + k :]
                yield lambda x, c, u=u, v=v: (u + x + v, c)

    def _exchanged(self, value, word, old, make, share):
        """The line with the new terms where the first of the old ones was."""
        pairs = []
        for w, c in value.terms.items():
            if w == word:
                pairs += [make(x, share * d) for x, d in self.new]
            if w not in old.terms:
                pairs.append((w, c))
        return value.like(pairs)
