"""The search for a proof: rewriting first, then completion in several orders.

Traces are words up to cyclic shift and transposition, rewritten across the seam too.
Two rules may overlap at both ends, around the circle.  The two ways of rewriting such a
circle give linear relations between traces; they decide with the rules themselves.
"""

from .rewriting import (
    LONGEST,
    Completion,
    Endless,
    Limit,
    Rewriter,
    add,
    inside,
    quotient,
)
from .statements import Problem, product
from .words import rotations


class Circle:
    """Traces modulo the rules of a rewriter and given linear relations of traces.

    `rows` is the size of a letter's rows, the trace of the identity; `given` are linear
    combinations of traces that are zero, with their nodes.  Where `turn` is true, a
    trace is known by its transpose as well; where `down` is, a circle is rewritten to
    lesser ones only, which must end.
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


def exchangeable(lead, tail, square, solid):
    """(p, q, c) for each way of reading the rule lead = tail as p q = c I.

    Either the lead is cut in two, or it has two letters and the rule says
    (x - a)(y - b) = c I.
    """
    if set(tail) == {()} and solid(tail[()]):
        for k in range(1, len(lead)):
            if square(lead[:k]):
                yield {lead[:k]: 1}, {lead[k:]: 1}, tail[()]
    elif len(lead) == 2 and lead[0] != lead[1] and square(lead[:1]):
        x, y = lead[:1], lead[1:]
        if square(y) and set(tail) <= {x, y, ()}:
            b, a = tail.get(x, 0), tail.get(y, 0)
            c = tail.get((), 0) + a * b
            if c and solid(c):
                yield shifted(x, a), shifted(y, b), c


def shifted(letter, a):
    """letter - a I."""
    return {letter: 1, (): -a} if a else {letter: 1}


MOST = 5_000  # rewritings of a claim by the relations as they are written
LIMITS = (
    ("inverses", Limit(degree=10, rules=60, steps=4_000)),
    ("definitions", Limit(degree=16, rules=120, steps=10_000)),
    ("reversed", Limit(degree=10, rules=120, steps=10_000)),
    ("inverses", Limit(degree=14, rules=500, steps=60_000)),
)
EVERY = 25  # new rules after which relations between traces are looked for


class Search:
    """Targets that are to become zero, and an engine that has the rules.

    `targets` is {claim: (what is left, why the rest is zero)}.
    """

    def __init__(self, problem, engine, down):
        self.problem, self.engine = problem, engine
        traces = problem.rows, problem.scalars, problem.turns
        self.circle = Circle(engine, *traces, down)
        self.scalar, self.lemmas = set(), {}  # lemmas: {name: (p, q, c, node)}
        self.targets = {}
        for claim, ((shape, left), (_, right)) in problem.statement.claims.items():
            if shape is None:
                self.scalar.add(claim)
            self.targets[claim] = problem.terms(left, right), []

    def reduce(self, most=None):
        """Rewrite every target; True when nothing is left of any."""
        for claim, (rest, why) in self.targets.items():
            reduce = self.circle.reduce if claim in self.scalar else self.engine.reduce
            rest, used = reduce(rest, most)
            self.targets[claim] = rest, why + used
        return self.done

    @property
    def done(self):
        return not any(rest for rest, _ in self.targets.values())


class Rewriting(Search):
    """The relations applied from left to right, as they are written."""

    reached = ""

    def __init__(self, statement):
        problem = Problem(statement)
        engine = Rewriter(problem.generators, problem.flip, None, problem.solid)
        super().__init__(problem, engine, down=False)
        for k, (kind, name) in problem.facts.items():
            self._orient(k, self._lead(kind, name))

    def _lead(self, kind, name):
        """The left side of a given relation, if it is one word."""
        if kind != "given":
            return None
        (_, left), _ = self.problem.statement.given[name]
        words = list(left)
        return self.problem.word(words[0]) if len(words) == 1 and words[0] else None

    def _orient(self, k, lead):
        terms = self.engine.generators[k]
        if not terms:
            return
        lead = lead if lead in terms else max(terms, key=self.engine.key)
        if not lead or not self.problem.solid(terms[lead]):
            return
        tail = {w: quotient(-c, terms[lead]) for w, c in terms.items() if w != lead}
        if any(inside(lead, w) for w in tail):
            return  # X = A X A' + Q would never end
        mirrored = self.engine.turned(lead), self.engine.transposed(tail)
        both = not any(inside(lead, w) for w in mirrored[1])  # not so with A' = -A
        for ref, (word, rest) in ((k, (lead, tail)), (~k, mirrored)):
            if (ref == k or both) and word not in self.engine.rules:
                self.engine.nodes.append([(quotient(1, terms[lead]), (), ref, ())])
                self.engine.install(word, rest, len(self.engine.nodes) - 1)

    def run(self):
        try:
            return "proved" if self.reduce(MOST) else "limit"
        except Endless:
            return "limit"


class Completing(Search):
    """The relations completed until the targets vanish, or up to a limit."""

    def __init__(self, statement, order, limit):
        problem = Problem(statement, order)
        engine = Completion(
            problem.generators,
            problem.flip,
            problem.weight,
            problem.solid,
            problem.turns,
        )
        super().__init__(problem, engine, down=True)
        self.limit, self.made = limit, 0
        engine.beyond = self._exchanged

    @property
    def reached(self):
        at = self.engine.reached
        said = f" at degree {at}" if at else ""
        if self.engine.set_aside:
            said += "; a relation was set aside whose leading coefficient may vanish"
        return said

    def run(self):
        if self.reduce():
            return "proved"
        outcome = self.engine.run(self._goal, self.limit)
        if outcome != "proved" and self._solve():
            outcome = "proved"
        return outcome

    def _goal(self, lead):
        self.made += 1
        if self.reduce() or self._multiples():
            return True
        return bool(self.scalar) and self.made % EVERY == 0 and self._solve()

    def _multiples(self):
        """Targets that are a number times what was set aside; True when all are done.

        So (a - b) x = 0 is used where it is wanted, though nothing is known of x.
        """
        for terms, node in self.engine.set_aside:
            word, c = next(iter(terms.items()))
            for claim, (rest, why) in self.targets.items():
                factor = self.problem.multiple(rest.get(word, 0), c)
                if claim in self.scalar or not factor:
                    continue
                left = dict(rest)
                for w, d in terms.items():
                    add(left, w, -factor * d)
                if not left:
                    self.targets[claim] = left, [*why, (factor, (), node, ())]
        return self.done

    def _exchanged(self, lead, tail, node):
        """q p = c I wherever a rule says p q = c I of square matrices."""
        problem, engine = self.problem, self.engine
        for p, q, c in exchangeable(lead, tail, problem.square, problem.solid):
            terms = product(q, p)
            add(terms, (), -c)
            if engine.reduce(terms)[0]:
                name = f"lemma {len(self.lemmas) + 1}"
                self.lemmas[name] = p, q, c, node
                problem.facts[len(engine.nodes)] = "exchanged", name
                engine.nodes.append(None)
                yield terms, [(1, (), len(engine.nodes) - 1, ())]

    def _solve(self):
        """Relations between traces, found around the circle."""
        for claim in self.scalar:
            rest, why = self.targets[claim]
            if rest:
                rest, used = self.circle.solve(rest, self.limit.degree)
                self.targets[claim] = rest, why + used
        return self.done


def searches(statement, limits=LIMITS):
    """One search after the other: the cheap ones first."""
    yield Rewriting(statement)
    for order, limit in limits:
        yield Completing(statement, order, limit)
