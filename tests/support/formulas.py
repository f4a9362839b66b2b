"""Formulas as they are printed, read back: two that say the same are equal here.

What `text` sets in Unicode is read into a polynomial in letters that do not commute.
Sizes are not known and not needed: I is 1.
"""

import re
from fractions import Fraction
from functools import cache
from itertools import product as choices

HIGH = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻"
DIGITS = str.maketrans(HIGH, "0123456789-")
SIGNS = ("=", "≥", "≤", ">", "<", "≠", "→", "⇔", "⇒")
TOKEN = re.compile(
    rf"(?P<call>(?:tr|det|rank|E)(?=[(\[]))|(?P<number>\d+(?:/\d+)?)"
    rf"|(?P<letter>(?![{HIGH}])[^\W\d_](?:(?![{HIGH}])[\w\u0300-\u036f₊₋]|,(?=\w))*"
    rf"[*⊥⁺]?)"
    rf"|(?P<power>[{HIGH}]+|\^\([^()]*\)|\^\w+)|(?P<gap>\s+)|(?P<sign>\.\.\.|\S)"
)


class Unread(ValueError):
    """A formula that is no formula here."""


def one(c=1):
    return {(): Fraction(c)} if c else {}


def letter(name, turned=False, inverse=False):
    return {((name, turned, inverse),): Fraction(1)}


def plus(a, b, c=1):
    found = dict(a)
    for word, value in b.items():
        found[word] = found.get(word, 0) + c * value
    return {word: value for word, value in found.items() if value}


def times(a, b):
    found = {}
    for (u, x), (v, y) in choices(a.items(), b.items()):
        found = plus(found, {joined(u, v): x * y})
    return found


def joined(u, v):
    """A product of words; a letter and its inverse cancel."""
    while u and v and u[-1][:2] == v[0][:2] and u[-1][2] != v[0][2]:
        u, v = u[:-1], v[1:]
    return u + v


def turned(a, symmetric=()):
    """The transpose."""
    same = {n for word in a for n, _, _ in word if scalar(n)} | set(symmetric)
    return {
        tuple((n, not t and n not in same, i) for n, t, i in word[::-1]): c
        for word, c in a.items()
    }


def scalar(name):
    return isinstance(name, tuple) and name[0] in ("tr", "det", "rank")


def frozen(a):
    return tuple(sorted(a.items(), key=repr))


def inverse(a):
    if len(a) == 1:
        ((word, c),) = a.items()
        return {tuple((n, t, not i) for n, t, i in word[::-1]): 1 / c}
    return letter(frozen(a), inverse=True)


def power(a, exponent):
    if exponent == "-1":
        return inverse(a)
    if exponent.isdigit() and int(exponent) < 9:
        found = one()
        for _ in range(int(exponent)):
            found = times(found, a)
        return found
    return letter((frozen(a), "^", exponent))


class Reader:
    """Reads one side of an equation."""

    def __init__(self, string, symmetric=()):
        self.symmetric = symmetric
        self.tokens = [(m.lastgroup, m.group()) for m in TOKEN.finditer(string.strip())]
        self.names = set()
        self.string = string

    def read(self):
        found = self.sum()
        if self.tokens:
            raise Unread(f"{self.string!r} should end before {self.tokens[0][1]!r}")
        return found

    def next(self):
        return self.tokens[0] if self.tokens else ("", "")

    def gap(self):
        width = 0
        while self.next()[0] == "gap":
            width = len(self.tokens.pop(0)[1])
        return width

    def take(self, wanted):
        self.gap()
        if self.next()[1] != wanted:
            raise Unread(f"{self.string!r}: no {wanted!r} before {self.next()[1]!r}")
        self.tokens.pop(0)

    def sum(self, entry=False):
        """Terms; of a matrix, one `entry`, which ends at a wider gap."""
        self.gap()
        sign = -1 if self.next()[1] == "-" else 1
        if self.next()[1] in "+-" and self.tokens:
            self.tokens.pop(0)
        found = plus({}, self.product(entry), sign)
        while self.after_gap(entry)[1] in ("+", "-"):
            self.gap()
            sign = -1 if self.tokens.pop(0)[1] == "-" else 1
            found = plus(found, self.product(entry), sign)
        return found

    def after_gap(self, entry):
        """The next token, or nothing where an entry ends."""
        if self.next()[0] != "gap":
            return self.next()
        if entry and len(self.next()[1]) >= entry:
            return ("", "")
        return self.tokens[1] if len(self.tokens) > 1 else ("", "")

    def product(self, entry=False):
        found = self.factor()
        while self.starts(self.after_gap(entry)):
            found = times(found, self.factor())
        return found

    def starts(self, token):
        return token[0] in ("letter", "number", "call") or token[1] in ("(", "[", "∂")

    def factor(self):
        found = self.atom()
        while True:
            kind, string = self.next()
            if string == "'":
                found = turned(found, self.symmetric)
            elif kind == "power":
                found = power(found, string.translate(DIGITS).strip("^()"))
            else:
                return found
            self.tokens.pop(0)

    def atom(self):
        self.gap()
        if not self.tokens:
            raise Unread(f"{self.string!r} ends too early")
        kind, string = self.tokens.pop(0)
        if kind == "number":
            return one(Fraction(string))
        if kind == "letter":
            if string == "I":
                return one()
            self.names.add(string)
            return letter(string)
        if kind == "call":
            return self.call(string)
        if string == "(":
            found = self.sum()
            self.take(")")
            return found
        if string == "[":
            return self.block()
        raise Unread(f"{self.string!r}: no formula begins with {string!r}")

    def call(self, name):
        """A function that is linear, but for the determinant and the rank."""
        closing = {"(": ")", "[": "]"}[self.next()[1]]
        self.tokens.pop(0)
        inner = self.sum()
        self.take(closing)
        if name in ("det", "rank"):
            return letter((name, frozen(inner)))
        found = {}
        for word, c in inner.items():
            of = cyclic(word, self.symmetric) if name == "tr" else word
            found = plus(found, letter((name, of)), c)
        return found

    def block(self):
        """A matrix: rows end at semicolons, entries at gaps, wide ones if any is."""
        entry = self.widest()
        rows = [[]]
        while True:
            self.gap()
            if self.next()[1] == "]":
                self.tokens.pop(0)
                break
            if self.next()[1] == ";":
                self.tokens.pop(0)
                rows.append([])
                continue
            rows[-1].append(frozen(self.sum(entry)))
        if rows == [rows[0]] and len(rows[0]) == 1:
            return dict(rows[0][0])
        return letter(("block", tuple(map(tuple, rows))))

    def widest(self):
        """How wide a gap ends an entry of the matrix that begins here."""
        depth, wide = 0, 1
        for kind, string in self.tokens:
            depth += (string in "([") - (string in ")]")
            if depth < 0:
                break
            if kind == "gap" and len(string) > 1 and depth == 0:
                wide = 2
        return wide


def cyclic(word, symmetric):
    """The first of the rotations of a word and of its transpose."""
    ((back, _),) = turned({word: 1}, symmetric).items()
    turns = [w[k:] + w[:k] for w in (word, back) for k in range(max(len(w), 1))]
    return min(turns, key=repr)


def side(string, symmetric=()):
    """What an expression is; one that cannot be read is a word."""
    return _side(string, tuple(symmetric))


@cache
def _side(string, symmetric):
    try:
        return frozen(Reader(string, symmetric).read())
    except Unread:
        return "".join(string.split())


def equation(left, sign, right, symmetric=()):
    """What an equation says, and its letters; a side that cannot be read is a word.

    The sides may change places, both signs be turned, and both be transposed.
    """
    return _equation(left, sign, right, tuple(symmetric))


@cache
def _equation(left, sign, right, symmetric):
    try:
        readers = Reader(left, symmetric), Reader(right, symmetric)
        a, b = (reader.read() for reader in readers)
    except Unread:
        words = (sign, *("".join(x.split()) for x in (left, right)))
        return words, frozenset(letters(left) | letters(right))
    if sign in ("≤", "<"):
        sign, a, b = {"≤": "≥", "<": ">"}[sign], b, a
    pairs = [(a, b), (turned(a, symmetric), turned(b, symmetric))]
    if sign in ("=", "≠"):
        pairs += [(plus({}, x, -1), plus({}, y, -1)) for x, y in pairs]
        pairs += [(y, x) for x, y in pairs]
    written = [tuple(map(frozen, pair)) for pair in pairs]
    names = frozenset(readers[0].names | readers[1].names)
    return (sign, min(written, key=repr)), names


def letters(string):
    """The letters of a formula, whether it can be read or not."""
    found = {m.group() for m in TOKEN.finditer(string) if m.lastgroup == "letter"}
    return found - {"I", "and", "or", "for"}


def parts(string):
    """(left, sign, right) of each equation in a formula: a = b = c has two."""
    depth, found, start = 0, [], 0
    for k, c in enumerate(string):
        depth += (c in "([") - (c in ")]")
        if depth == 0 and c in SIGNS:
            found.append((string[start:k].strip(), c))
            start = k + 1
    sides = [left for left, _ in found] + [string[start:].strip()]
    return [(a, sign, b) for a, (_, sign), b in zip(sides, found, sides[1:])]
