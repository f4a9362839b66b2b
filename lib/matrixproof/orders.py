"""One matrix is at least another: as a hypothesis, and as what follows.

P >= Q says that P - Q = L L' for some L; that is how it is used.  What is to be at
least something else is so if the difference is a sum of squares X X'.  A word of even
length is a product of two halves in one way only, so the difference is U G U' with a
row U of different halves and one matrix G of numbers, and it is a sum of squares if G
is not negative (Helton, 2002).  Then the machine has the roots, and the equation that
they make is proved like any other.
"""

from dataclasses import dataclass, replace
from itertools import chain
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .algebra import Algebra, Traces
from .dependence import declared, letters
from .exact import as_matrix
from .lines import squared
from .models import QUICK, Setting, models
from .proofs import Proof, Unproved, prove
from .relations import Given, Relation, named
from .symbols import BlockMatrix, MatrixProduct, Own, ZeroMatrix
from .terms import summed
from .typeset import Show, text
from .words import Formula, Letter, Symbols, plain, rotations


@dataclass(frozen=True, repr=False)
class Bound(Relation):
    """`left >= least`, as the equation `left = least + L L'` with a root L.

    Attributes
    ----------
    least : MatrixExpr
    root : MatrixSymbol
    """

    least: Formula = None
    root: Formula = None

    def show(self, show: Show) -> str:
        sign = "≥" if show is text else r"\ge"
        return f"{show(self.left)} {sign} {show(self.least)}"

    @property
    def expressions(self) -> tuple[Formula, Formula]:
        return self.left, self.least

    def mapped(self, put: Any) -> Any:
        found = replace(self, least=put(self.least), root=put(self.root))
        return super(Bound, found).mapped(put)


def at_least(left: Formula, right: Formula = 0, number: str = "") -> Bound:
    """That a matrix is at least another one: their difference is not negative.

    Parameters
    ----------
    left, right : MatrixExpr
        Symmetric; a right side of 0 says that `left` is not negative.
    number : str
        As for a `Relation`.

    Examples
    --------
    >>> from matrixproof import letters, prove
    >>> P, Q, T = letters("P:n*n= Q:n*n= T:m*n")
    >>> above = at_least(P, Q)
    >>> above
    Suppose P ≥ Q
    >>> prove_at_least(T * P * T.T, T * Q * T.T, [above]).cited
    ('P ≥ Q',)
    """
    least = ZeroMatrix(*left.shape) if right == 0 else right
    inside = sorted(letters(plain(left)), key=str)
    inside += sorted(letters(plain(least)) - {*inside}, key=str)
    root = Own("_".join(["L", *(x.name for x in inside)]), *left.shape)
    found = Bound("", left, least + root * root.T, least, root)
    says = found.show(text)
    return replace(found, name=f"({number}) {says}" if number else says)


def prove_at_least(
    left: Formula, right: Formula, given: Given = (), symmetric: Symbols = ()
) -> Proof:
    """Prove `left >= right` for all matrices that satisfy what is given.

    Parameters
    ----------
    left, right : MatrixExpr or scalar expression in traces
    given : iterable of Relation or (left, right)
        With what `at_least` says among them.
    symmetric : iterable of MatrixSymbol

    Returns
    -------
    Proof
        Of `left = right + X X'`; the machine finds X.

    Raises
    ------
    Unproved
        The difference was not found to be a sum of squares; with a counterexample, in
        which everything given holds, if one was found.

    Examples
    --------
    >>> from matrixproof import letters
    >>> P, Q = letters("P:n*n= Q:n*n=")
    >>> given = at_least(P, Q), at_least(Q)
    >>> prove_at_least(Q.I, P.I, given).check()
    True
    >>> prove_at_least(P * P, Q * Q, given)  # doctest: +ELLIPSIS
    Traceback (most recent call last):
        ...
    matrixproof.proofs.Unproved: not proved: it is false; see the counterexample; ...
    """
    given = named(given)
    symmetric = declared(symmetric, (left, right, *given))
    root, difference = root_of(left, right, given, symmetric)
    if root is None:
        found = denied(left, right, given, symmetric)
        why = "the difference is no sum of squares that was found"
        why = "it is false; see the counterexample" if found else why
        message = f"not proved: {why}; the difference: {difference}"
        raise Unproved(message, difference, False, found)
    square = squared(root)
    if not isinstance(plain(left), MatrixExpr):
        square = sp.Trace(square)
    return prove(left, right + square, given, symmetric)


def root_of(left, right, given, symmetric):
    """X with left = right + X X' where this is found, or None; and the difference."""
    orders = [r for r in given if isinstance(r, Bound)]
    algebra = Algebra((*symmetric, *(x for r in orders for x in sides(r))))
    difference = algebra.normal(left) - algebra.normal(right)
    value = difference
    for r in orders:
        value = unturned(value, r)
    for r in [*given] * max(len(given), 1):
        value = lowered(value, r)
    known = {r.left: r.root for r in orders if r.least.is_ZeroMatrix}
    find = of_traces if isinstance(value, Traces) else of_polynomial
    roots = find(value, known) if hasattr(value, "terms") else None
    if roots is None:
        return None, difference
    if not roots:
        return ZeroMatrix(*value.shape), difference
    return (roots[0] if len(roots) == 1 else BlockMatrix([roots])), difference


def sides(relation):
    """The letters among the two sides of what is ordered."""
    return [x for x in relation.expressions if isinstance(x, sp.MatrixSymbol)]


def lowered(value, relation):
    """A normal form with what a letter is in its place, a root included."""
    P, whole = relation.left, relation.right
    stays = not isinstance(P, sp.MatrixSymbol) or P in plain(whole).atoms(
        sp.MatrixSymbol
    )
    if stays or getattr(relation, "least", whole).is_ZeroMatrix:
        return value
    try:
        whole = value.algebra.normal(whole)
    except TypeError:  # what is inverted in it has no letter
        return value
    return put_in(value, Letter(P), whole)


def unturned(value, relation):
    """A normal form in which the inverse of the less is that of the more, and squares.

    With P >= Q and D = P - Q it is P^-1 + P^-1 D P^-1 + P^-1 D Q^-1 D P^-1.
    """
    P, Q = sides(relation)[:1], sides(relation)[1:]
    if not (P and Q) or not any(Letter(P[0], inverted=True) in w for w in value.terms):
        return value
    algebra = value.algebra
    D, one = algebra.normal(relation.root * relation.root.T), algebra.normal(P[0].I)
    rest = one @ D @ algebra.normal(Q[0].I) @ D @ one
    return put_in(value, Letter(Q[0], inverted=True), one + one @ D @ one + rest)


def put_in(value, letter, new):
    """A normal form with a polynomial in place of a symmetric letter."""
    pairs = []
    for word, c in value.terms.items():
        parts = [((), c)]
        for x in word:
            options = new.terms.items() if x == letter else [((x,), 1)]
            parts = [(w + u, d * e) for w, d in parts for u, e in options]
        pairs += parts
    return value.like(pairs)


def of_polynomial(value, known):
    """The roots of a polynomial that is a sum of squares, or None."""
    halves = {}  # {number in front: {(half, half): coefficient}}
    for word, c in value.terms.items():
        word = doubled(word, known, value.algebra)
        half, odd = divmod(len(word), 2)
        if odd:
            return None
        factor, share = apart(c)
        pair = word[:half], value.algebra.flipped(word[half:])
        entries = halves.setdefault(factor, {})
        entries[pair] = entries.get(pair, 0) + share
    roots = []
    for factor, entries in halves.items():
        found = gram(entries)
        if found is None or factor.is_nonnegative is not True:
            return None
        for number, terms in found:
            columns = size_behind(terms[0][0], value.shape[0])
            inside = summed(terms, value.shape[0], columns)
            roots.append(MatrixProduct(sp.sqrt(number * factor), inside))
    return roots


def doubled(word, known, algebra):
    """A word with the root of its middle letter, where it has one and that is known."""
    half, odd = divmod(len(word), 2)
    if not odd or word[half].atom not in known:
        return word
    M, L = word[half], Letter(known[word[half].atom])
    turned = algebra.flipped((L,))
    middle = (M, L, *turned, M) if M.inverted else (L, *turned)
    return word[:half] + middle + word[half + 1 :]


def apart(c):
    """A coefficient as what is no rational number in it, and the number."""
    number, rest = sp.sympify(c).as_coeff_Mul()
    return (rest, number) if number.is_Rational else (sp.sympify(c), sp.S.One)


def gram(entries):
    """[(number, terms)] of squares that add up to a form in words, or None."""
    words = list(dict.fromkeys(w for pair in entries for w in pair))
    G = sp.Matrix(
        len(words), len(words), lambda i, j: entries.get((words[i], words[j]), 0)
    )
    if G != G.T:
        return None
    found = []
    for k in range(len(words)):
        pivot = G[k, k]
        if pivot < 0 or (pivot == 0 and any(G[k, :])):
            return None
        if pivot > 0:
            column = G[:, k] / pivot
            found.append((pivot, [(w, c) for w, c in zip(words, column) if c]))
            G = G - pivot * column * column.T
    return found


def size_behind(word, rows):
    """The columns of a word, or the rows where it is empty."""
    if not word:
        return rows
    return word[-1].atom.shape[0 if word[-1].transposed else 1]


def of_traces(value, known):
    """The root of a sum of traces of squares, or None."""
    roots = []
    for word, c in value.terms.items():
        opened = []
        for x in word:
            root = Letter(known[x.atom]) if x.atom in known and not x.inverted else None
            opened += [root, *value.algebra.flipped((root,))] if root else [x]
        half, odd = divmod(len(opened), 2)
        turned = [tuple(w) for w in rotations(tuple(opened))]
        fits = [w for w in turned if w[:half] == value.algebra.flipped(w[half:])]
        if odd or not opened or not fits or c.is_nonnegative is not True:
            return None
        factors = [x.as_expr() for x in fits[0][:half]]
        roots.append(MatrixProduct(sp.sqrt(c), *factors))
    alike = all(x.shape[0] == roots[0].shape[0] for x in roots)
    return roots if alike else None


def denied(left, right, given, symmetric):
    """Matrices that satisfy what is given, where the difference is negative."""
    both = [Setting(given, symmetric, (left, right), definite=x) for x in (True, False)]
    tried = (models(setting, setting.small_sizes(), QUICK) for setting in both)
    for found in chain(*tried):
        values = [found.world.value(side) for side in (left, right)]
        if isinstance(values[0], dict):
            a, b = (sp.Rational(x.get((), 0)) for x in values)
            negative = a < b
        else:
            a, b = (as_matrix(x, found.world.shape(left)) for x in values)
            negative = not (a - b).is_positive_semidefinite
        if negative:
            return found.matrices()
    return None
