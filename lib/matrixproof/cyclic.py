"""Traces: words up to cyclic shift and transposition, rewritten across the seam too.

Two rules may overlap at both ends, around the circle.  The two ways of rewriting such a
circle give linear relations between traces; they decide with the rules themselves.
"""

from .rewriting import LONGEST, Endless, add, inside, quotient
from .words import rotations


class Circle:
    """Traces modulo the rules of a rewriter and given linear relations of traces.

    Parameters
    ----------
    rewriter : Rewriter
    rows : callable
        The size of a letter's rows, as a coefficient: the trace of the identity.
    given : list of (terms, node)
        Linear combinations of traces that are zero.
    turn : bool
        Whether a trace is also known by its transpose.
    down : bool
        Rewrite to lesser circles only, which must end.
    """

    def __init__(self, rewriter, rows, given=(), turn=True, down=True):
        self.rewriter, self.rows, self.turn = rewriter, rows, turn
        self.given, self.down = given, down
        self.known = {}  # word: (the same circle in its standard form)

    def standard(self, word):
        """The least of the words that have the same trace for every matrix."""
        if word not in self.known:
            turned = rotations(word)
            if self.turn:
                turned = turned + rotations(self.rewriter.turned(word))
            self.known[word] = min(turned)
        return self.known[word]

    def moves(self, word):
        """Each way of rewriting a circle: (what it becomes, u, node, v, factor).

        The circle times the factor is what it becomes; the factor is not 1 where the
        circle itself comes back, as where A' = -A turns tr(P A) into its negative.
        """
        turned = rotations(word)
        if self.turn:
            turned = turned + rotations(self.rewriter.turned(word))
        for w in turned:
            found = self.rewriter.match(w)
            if found is None:
                continue
            i, lead = found
            u, v = w[:i], w[i + len(lead) :]
            tail, node = self.rewriter.rules[lead]
            terms = {}
            for x, d in tail.items():
                whole, size = self.closed(u, x, v, lead)
                add(terms, whole, d * size)
            factor = 1 - terms.pop(word, 0)
            if factor and self.rewriter.solid(factor):
                yield terms, u, node, v, factor

    def step(self, word):
        """The first move to lesser circles; to any, where rules need not go down."""
        key = self.rewriter.key
        for move in self.moves(word):
            if not self.down or all(key(w) < key(word) for w in move[0]):
                return move
        return None

    def closed(self, u, w, v, lead):
        """(word, factor) of tr(u w v); the empty word stands for 1."""
        whole = u + w + v
        return (self.standard(whole), 1) if whole else ((), self.rows(lead[0]))

    def reduce(self, terms, most=None):
        """(normal form, terms (c, u, ref, v)) of a combination of traces."""
        todo, done, used = {}, {}, []
        for w, c in terms.items():
            add(todo, self.standard(w) if w else w, c)
        while todo:
            word = max(todo, key=self.rewriter.key)
            c = todo.pop(word)
            move = self.step(word) if word else None
            if move is None:
                add(done, word, c)
                continue
            self.rewriter.steps += 1
            if most is not None and (len(used) > most or len(word) > LONGEST):
                raise Endless
            becomes, u, node, v, factor = move
            c = quotient(c, factor)
            used.append((c, u, node, v))
            for w, d in becomes.items():
                add(todo, w, c * d)
        return done, used

    def overlaps(self, degree):
        """The circles that can be rewritten in two ways which rules do not settle.

        Two leads overlap at both ends; or one overlaps the transpose of another.
        """
        found, leads = set(), list(self.rewriter.rules)
        for first in leads:
            for second in leads:
                found |= {first + s for s in both_ends(first, second)}
                if self.turn:
                    turned = self.rewriter.turned(second)
                    found |= {first + s for s in both_ends(first, turned, 0)}
                    found |= {first} if inside(turned, first) else set()
        short = {self.standard(w) for w in found if self.rewriter.degree(w) <= degree}
        return sorted(short, key=self.rewriter.key)

    def sideways(self, words):
        """Every move from each circle as a relation: (terms, why)."""
        for word in words:
            for terms, u, node, v, factor in self.moves(word):
                yield (
                    {**{w: -d for w, d in terms.items()}, word: factor},
                    [(1, u, node, v)],
                )

    def solve(self, terms, degree):
        """The same as `reduce`, modulo the linear relations between traces as well."""
        rest, used = self.reduce(terms)
        pivots = {}
        relations = [(dict(t), [(1, (), k, ())]) for t, k in self.given]
        words = {w for row, _ in [(rest, ()), *relations] for w in self.reduce(row)[0]}
        circles = sorted(words - {()}, key=self.rewriter.key) + self.overlaps(degree)
        for row, why in [*relations, *self.sideways(circles)]:
            row, extra = self.reduce(row)
            why = why + [(-c, u, ref, v) for c, u, ref, v in extra]
            row, why = self.eliminate(row, why, pivots)
            lead = max(row, key=self.rewriter.key, default=None)
            if lead is None or not self.rewriter.solid(row[lead]):
                continue
            top = row[lead]
            pivots[lead] = (
                {w: quotient(c, top) for w, c in row.items()},
                [(quotient(c, top), u, ref, v) for c, u, ref, v in why],
            )
        rest, gone = self.eliminate(rest, [], pivots)
        return rest, used + [(-c, u, ref, v) for c, u, ref, v in gone]

    def eliminate(self, row, why, pivots):
        """Subtract pivots until no word of the row is one; `why` likewise."""
        row, why = dict(row), list(why)
        for word in sorted(row, key=self.rewriter.key, reverse=True):
            self._subtract(row, why, word, pivots)
        while any(w in pivots for w in row):
            word = max((w for w in row if w in pivots), key=self.rewriter.key)
            self._subtract(row, why, word, pivots)
        return row, why

    @staticmethod
    def _subtract(row, why, word, pivots):
        if word in pivots and word in row:
            c, (terms, because) = row[word], pivots[word]
            for w, d in terms.items():
                add(row, w, -c * d)
            why += [(-c * d, u, ref, v) for d, u, ref, v in because]


def both_ends(first, second, least=1):
    """Each s: first = p q r, second = r s p; p and r have `least` letters or more."""
    for a in range(least, len(first)):
        for b in range(least, len(first) - a + 1):
            p, r = first[:a], first[len(first) - b :]
            fits = a + b and len(second) >= a + b and second[:b] == r
            if fits and second[len(second) - a :] == p:
                yield second[b : len(second) - a]
