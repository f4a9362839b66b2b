"""Completion: relations are made to decide, by resolving what overlaps.

Where the leads of two rules overlap in a word, the word can be rewritten in two ways;
their difference is a consequence of the relations, and becomes a rule.  When no overlap
is left (the rules are then a non-commutative Groebner basis) every consequence rewrites
to zero.  That need not happen after finitely many steps, so there is a limit.

Source: Knuth and Bendix (1970); Bergman (1978), "The diamond lemma for ring theory";
Mora (1994).
"""

from dataclasses import dataclass
from heapq import heappop, heappush
from itertools import count

from .rewriting import Rewriter, inside


@dataclass(frozen=True)
class Limit:
    """How far a completion goes: a measure of work that is the same on each machine.

    Attributes
    ----------
    degree : int
        Longest overlap that is resolved, in letters.
    rules : int
        Most rules ever made.
    steps : int
        Most rewritings.
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
