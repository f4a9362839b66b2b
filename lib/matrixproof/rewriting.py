"""Rewriting of words by rules, with a record of why each rule holds.

Inside the engine a letter is a small integer and a word a tuple of them.  A rule
replaces its lead, a word, by its tail, a polynomial {word: coefficient}.  Each rule is
a node: the sum of terms `(c, u, ref, v)` for earlier nodes, where `ref` is a node k or,
transposed, ~k.  So what follows from the relations is known by construction, and is
multiplied out only when a proof is found.
"""

from fractions import Fraction
from heapq import heapify, heappop, heappush

LONGEST = 100  # letters of a word; one that is longer has been growing


class Endless(Exception):
    """Rewriting took more steps than allowed."""


class Contradiction(ValueError):
    """The relations say that an identity matrix is zero: no matrices satisfy them."""


class Rewriter:
    """A set of rules.

    Parameters
    ----------
    generators : list of (terms, unit)
        What is given: polynomials that are zero.
    flip : sequence of int
        The transpose of each letter.
    weight : sequence of int
        What each letter counts in the degree of a word.
    solid : callable
        Whether a coefficient is certainly not zero, so that one may divide by it.
    """

    def __init__(self, generators, flip, weight=None, solid=lambda c: True):
        self.flip, self.solid = flip, solid
        self.weight = weight or [1] * len(flip)
        self.nodes = [None] * len(generators)
        self.generators = generators
        self.rules = {}  # lead: (tail, node)
        self.lengths = {}  # first letter: lengths of the leads that begin with it
        self.steps = 0  # rewritings so far, a measure of work

    # -- words and polynomials ----------------------------------------------------

    def degree(self, word):
        return sum(self.weight[x] for x in word)

    def key(self, word):
        """What words are compared by: the degree, then letter by letter."""
        return self.degree(word), len(word), word

    def turned(self, word):
        """The transpose of a word."""
        return tuple(self.flip[x] for x in reversed(word))

    def transposed(self, terms):
        return {self.turned(w): c for w, c in terms.items()}

    # -- rewriting ----------------------------------------------------------------

    def match(self, word):
        """(place, lead) of the first rule that applies, or None."""
        for i, x in enumerate(word):
            for k in self.lengths.get(x, ()):
                lead = word[i : i + k]
                if lead in self.rules:
                    return i, lead
        return None

    def reduce(self, terms, most=None):
        """(normal form, terms (c, u, ref, v)): what was subtracted to get there."""
        todo, done, used = dict(terms), {}, []
        queue = [self._upside_down(w) for w in todo]
        heapify(queue)
        start = self.steps
        while queue:
            word = heappop(queue)[-1]
            c = todo.pop(word, 0)
            if not c:
                continue
            found = self.match(word)
            if found is None:
                done[word] = c
                continue
            self.steps += 1
            if most is not None and (self.steps - start > most or len(word) > LONGEST):
                raise Endless
            i, lead = found
            tail, node = self.rules[lead]
            u, v = word[:i], word[i + len(lead) :]
            used.append((c, u, node, v))
            for w, d in tail.items():
                whole = u + w + v
                if whole in done:
                    add(done, whole, c * d)
                elif whole in todo:
                    todo[whole] += c * d
                else:
                    todo[whole] = c * d
                    heappush(queue, self._upside_down(whole))
        return done, used

    def _upside_down(self, word):
        """Sorts the greatest word first."""
        return -self.degree(word), -len(word), tuple(-x for x in word), word

    # -- rules --------------------------------------------------------------------

    def install(self, lead, tail, node):
        self.rules[lead] = tail, node
        lengths = self.lengths.setdefault(lead[0], [])
        if len(lead) not in lengths:
            lengths.append(len(lead))
            lengths.sort()

    def remove(self, lead):
        del self.rules[lead]

    def derive(self, terms, why):
        """Make the polynomial a rule, `why` it is zero; its lead, or None if it is not.

        Raises
        ------
        Contradiction
            The polynomial is a multiple of the identity.
        """
        lead = max(terms, key=self.key)
        top = terms[lead]
        if not self.solid(top):
            return None
        if not lead:
            raise Contradiction(
                "the relations say that an identity matrix is zero: "
                "no matrices satisfy them"
            )
        tail = {w: quotient(-c, top) for w, c in terms.items() if w != lead}
        self.nodes.append([(quotient(c, top), u, ref, v) for c, u, ref, v in why])
        self.install(lead, tail, len(self.nodes) - 1)
        return lead

    # -- proofs -------------------------------------------------------------------

    def flatten(self, why):
        """{(u, ref, v): c} over the generators alone."""
        waiting, done = {}, {}
        for c, u, ref, v in why:
            add(waiting.setdefault(max(ref, ~ref), {}), (u, ref, v), c)
        while waiting:
            node = max(waiting)
            terms, because = waiting.pop(node), self.nodes[node]
            if because is None:
                done |= terms
                continue
            for (u, ref, v), c in terms.items():
                for d, a, inner, b in because:
                    if ref < 0:
                        a, inner, b = self.turned(b), ~inner, self.turned(a)
                    place = waiting.setdefault(max(inner, ~inner), {})
                    add(place, (u + a, inner, b + v), c * d)
        return {key: c for key, c in done.items() if c}


def inside(word, other):
    """Whether a word occurs in another."""
    k = len(word)
    return any(other[i : i + k] == word for i in range(len(other) - k + 1))


def add(terms, key, c):
    """Add c to an entry, which disappears when it becomes zero."""
    total = terms.get(key, 0) + c
    if total:
        terms[key] = total
    else:
        terms.pop(key, None)


def quotient(a, b):
    """a / b, exact; whole numbers stay whole."""
    if b == 1:
        return a
    if b == -1:
        return -a
    if isinstance(a, (int, Fraction)) and isinstance(b, (int, Fraction)):
        found = Fraction(a) / b
        return found.numerator if found.denominator == 1 else found
    return a / b
