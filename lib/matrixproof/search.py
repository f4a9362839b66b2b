"""The search for a proof: rewriting first, then completion in several orders."""

from .completion import Completion, Limit
from .cyclic import Circle
from .finite import exchangeable, product
from .problems import Problem
from .rewriting import Endless, Rewriter, add, inside, quotient

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
