"""Certificates: from what the engine recorded to terms that anybody can multiply out.

The engine takes a symmetric letter and its transpose for one letter, and a trace for a
circle.  Here these steps are made explicit, so that the terms add up in the free
algebra, where nothing at all is taken for granted.
"""

from .statements import flip, product
from .words import rotations


def spelled_out(problem, claim, why):
    """The certificate of a claim: a tuple of `(c, u, fact, v)`.

    `why` is {(u, ref, v): c} over the generators, as `Rewriter.flatten` gives it.
    """
    writer = Writer(problem, claim)
    for (u, ref, v), c in why.items():
        kind, name = problem.facts[max(ref, ~ref)]
        writer.cite(
            problem.coefficient(c),
            problem.spelled(u),
            (kind, name, ref < 0),
            problem.spelled(v),
        )
    writer.settle()
    return tuple(writer.terms)


class Writer:
    """Writes terms and keeps what is left of the claim."""

    def __init__(self, problem, claim):
        self.problem, self.statement = problem, problem.statement
        (self.shape, left), (_, right) = self.statement.sides(claim)
        self.rest, self.terms = {}, []
        self._subtract(-1, left)
        self._subtract(1, right)
        self.depth = depths(self.statement)

    def _subtract(self, c, terms, u=(), v=(), size=1):
        for word, d in terms.items():
            whole = u + word + v
            factor = size if self.shape is None and not whole else 1
            total = self.problem.number(c) * self.problem.number(d)
            total = self.rest.get(whole, 0) - total * self.problem.number(factor)
            if total:
                self.rest[whole] = total
            else:
                self.rest.pop(whole, None)

    def cite(self, c, u, fact, v):
        """Write one term and take it off what is left."""
        shape, left, right = self._sides(fact)
        size = 1 if shape is None else shape[0]
        self._subtract(c, left, u, v, size)
        self._subtract(-c, right, u, v, size)
        self.terms.append((c, u, fact, v))

    def _sides(self, fact):
        kind, name, transposed = fact
        if kind == "given":
            (shape, left), (_, right) = self.statement.given[name]
        elif kind == "exchanged":
            p, q, c = self.statement.lemmas[name]
            shape, left, right = p[0], product(q[1], p[1]), {(): c}
        elif kind == "number":
            (a, b), shape = name, (1, 1)
            left, right = ({a + b: 1}, {b + a: 1}) if b else ({a: 1}, {flip(a): 1})
        else:
            shape, base = self.statement.inverses[name]
            y, right = ((name, False),), {(): 1}
            first = kind == "right inverse"
            left = {w + y if first else y + w: c for w, c in base.items()}
        if transposed:
            shape = None if shape is None else shape[::-1]
            left, right = ({flip(w): c for w, c in s.items()} for s in (left, right))
        return shape, left, right

    def settle(self):
        """Write the symmetries, and in a trace the turns, that are still to be used."""
        if self.shape is None:
            for word in list(self.rest):
                self._turn(word)
        self._symmetries()
        if self.shape is None:
            for word in list(self.rest):
                self._rotate(word)

    def _symmetries(self):
        """Each transposed symmetric letter, the simplest first."""
        symmetric = self.problem.symmetric
        while True:
            places = [
                (self.depth[name], word, i)
                for word in self.rest
                for i, (name, transposed) in enumerate(word)
                if transposed and name in symmetric
            ]
            if not places:
                return
            _, word, i = min(places)
            self._straighten(word, i)

    def _straighten(self, word, i):
        name = word[i][0]
        c = self.problem.coefficient(self.rest[word])
        u, v = word[:i], word[i + 1 :]
        if name in self.statement.symmetric:
            self.terms.append((c, u, ("symmetric", name, False), v))
            self._subtract(c, {((name, True),): 1, ((name, False),): -1}, u, v)
            return
        # Y' - Y = (Y'P' - I) Y - Y'(P Y - I) + Y'(P - P') Y, where P Y = I
        self.cite(c, u, ("right inverse", name, True), ((name, False), *v))
        self.cite(-c, (*u, (name, True)), ("right inverse", name, False), v)

    def _standard(self, word):
        """The rotation or transpose of a word that the engine knows it by."""
        index = self.problem.word
        turned = rotations(word)
        if self.problem.turns:
            turned = turned + rotations(flip(word))
        return min(turned, key=index)

    def _turn(self, word):
        """Transpose a circle that is better known by its transpose."""
        if word and word in self.rest and self._standard(word) not in rotations(word):
            c = self.problem.coefficient(self.rest[word])
            self.terms.append((c, word, ("turned", "", False), ()))
            self._subtract(c, {word: 1})
            self._subtract(-c, {flip(word): 1})

    def _rotate(self, word):
        if not word or word not in self.rest:
            return
        target = min(rotations(word), key=self.problem.word)
        if target != word:
            k = next(k for k in range(len(word)) if word[k:] + word[:k] == target)
            c = self.problem.coefficient(self.rest[word])
            self.terms.append((c, word[:k], ("cyclic", "", False), word[k:]))
            self._subtract(c, {word: 1})
            self._subtract(-c, {target: 1})


def depths(statement):
    """How deeply the inverses in a letter are nested: 0 for a symbol."""
    found = {}

    def depth(name):
        if name not in found:
            inner = statement.inverses.get(name, (None, {}))[1]
            below = [depth(x) for word in inner for x, _ in word]
            found[name] = 1 + max(below, default=0) if name in statement.inverses else 0
        return found[name]

    for name in statement.sizes:
        depth(name)
    return found
