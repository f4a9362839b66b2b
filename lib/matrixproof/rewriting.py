"""Rewriting of words by rules, with a record of why each rule holds; their completion.

Inside the engine a letter is a small integer and a word a tuple of them.  A rule
replaces its lead, a word, by its tail, a polynomial {word: coefficient}.  Each rule is
a node: the sum of terms `(c, u, ref, v)` for earlier nodes, where `ref` is a node k or,
transposed, ~k.  So what follows from the relations is known by construction, and is
multiplied out only when a proof is found.

Where the leads of two rules overlap in a word, the word can be rewritten in two ways;
their difference is a consequence of the relations, and becomes a rule.  When no overlap
is left (the rules are then a non-commutative Groebner basis) every consequence rewrites
to zero.  That need not happen after finitely many steps, so there is a limit.

Source: Knuth and Bendix (1970); Bergman (1978), "The diamond lemma for ring theory";
Mora (1994).
"""

from dataclasses import dataclass
from fractions import Fraction
from heapq import heapify, heappop, heappush
from itertools import count

LONGEST = 100  # letters of a word; one that is longer has been growing


class Endless(Exception):
    """Rewriting took more steps than allowed."""


class Contradiction(ValueError):
    """The relations say that an identity matrix is zero: no matrices satisfy them."""


class Rewriter:
    """A set of rules.

    `generators` are polynomials that are zero, `flip` the transpose of each letter,
    `weight` what each letter counts in the degree of a word; `solid` says whether a
    coefficient is certainly not zero, so that one may divide by it.
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


@dataclass(frozen=True)
class Limit:
    """How far a completion goes: a measure of work that is the same on each machine.

    Attributes
    ----------
    degree : int
        Longest overlap that is resolved, in letters.
    rules, steps : int
        Most rules ever made, and most rewritings.
    """

    degree: int = 12
    rules: int = 400
    steps: int = 40_000


class Completion(Rewriter):
    """Rules that are completed a batch at a time.

    `goal` is called with each new lead, and with None where a polynomial is set aside;
    when it returns True the search is over.
    """

    def __init__(self, generators, flip, weight=None, solid=lambda c: True, turn=True):
        super().__init__(generators, flip, weight, solid)
        self.turn = turn  # whether transposes of the relations matter
        self.queue, self.order = [], count()
        self.skipped = set()  # degrees of overlaps beyond the limit
        self.beyond = lambda lead, tail, node: ()  # what follows otherwise
        self.set_aside = []  # polynomials whose leading coefficient might vanish
        for k in range(len(generators)):
            self.consider(generators[k], [(1, (), k, ())])
            if turn:
                terms = self.transposed(generators[k])
                self.consider(terms, [(1, (), ~k, ())])

    def consider(self, terms, why):
        """Queue a polynomial that is zero."""
        if terms:
            degree = max(map(self.degree, terms))
            heappush(self.queue, (degree, 0, next(self.order), (terms, why)))

    def run(self, goal, limit):
        """Resolve overlaps, shortest first: "proved", "complete" or "limit"."""
        start, made = self.steps, len(self.nodes)
        while self.queue:
            if self.steps - start > limit.steps or len(self.nodes) - made > limit.rules:
                return "limit"
            degree, _, _, item = heappop(self.queue)
            if degree > limit.degree:
                self.skipped.add(degree)
                continue
            terms, why = item if isinstance(item[0], dict) else self.difference(*item)
            if terms and self.absorb(terms, why, goal):
                return "proved"
        return "limit" if self.skipped or self.set_aside else "complete"

    @property
    def reached(self):
        """The degree below which every overlap has been resolved."""
        return self.queue[0][0] if self.queue else min(self.skipped, default=None)

    def difference(self, first, second, shared):
        """The two ways of rewriting an overlap, one less the other, and why it is 0."""
        if first not in self.rules or second not in self.rules:
            return None, None  # one of them has been simplified since
        (tail, node), (other, second_node) = self.rules[first], self.rules[second]
        before, behind = first[: len(first) - shared], second[shared:]
        terms = {w + behind: c for w, c in tail.items()}
        for w, c in other.items():
            terms[before + w] = terms.get(before + w, 0) - c
        why = [(1, before, second_node, ()), (-1, (), node, behind)]
        return terms, why

    def absorb(self, terms, why, goal):
        """Make what is left of a polynomial a rule; True when the goal is reached."""
        rest, used = self.reduce(terms)
        if not rest:
            return False
        why = why + [(-c, u, ref, v) for c, u, ref, v in used]
        lead = self.derive(rest, why)
        if lead is None:
            self.nodes.append(why)
            self.set_aside.append((rest, len(self.nodes) - 1))
            return goal(lead)
        tail, node = self.rules[lead]
        self.simplify(lead)
        if self.turn:
            turned = self.transposed({lead: 1} | {w: -c for w, c in tail.items()})
            self.consider(turned, [(1, (), ~node, ())])
        self.overlap(lead)
        for terms, because in self.beyond(lead, tail, node):
            self.consider(terms, because)
        return goal(lead)

    def simplify(self, lead):
        """Take out the rules whose leads contain the new one, to be reduced again."""
        for old in list(self.rules):
            if old != lead and inside(lead, old):
                tail, node = self.rules.pop(old)
                whole = {old: 1} | {w: -c for w, c in tail.items()}
                self.consider(whole, [(1, (), node, ())])

    def overlap(self, lead):
        """Queue the overlaps of a lead with every lead, itself included."""
        for other in self.rules:
            pairs = [(lead, other)] if other == lead else [(lead, other), (other, lead)]
            for a, b in pairs:
                for shared in range(1, min(len(a), len(b))):
                    if a[-shared:] == b[:shared]:
                        word = a + b[shared:]
                        item = (self.degree(word), 1, next(self.order), (a, b, shared))
                        heappush(self.queue, item)
