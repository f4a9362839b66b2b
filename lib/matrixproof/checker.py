"""Check a certificate by multiplying it out.  Shares no code with the prover.

A certificate is a sum of terms `(c, u, fact, v)`; each stands for c u (l - r) v, where
l = r is a given relation, a defining equation of an inverse, a symmetry, or one of
these transposed; or p q = c I the other way round, a lemma about square p and q; or it
says that a 1 x 1 matrix is a number.  A coefficient may have signs of sums over an
index; what is summed once is not summed again, and what a sum is multiplied by does not
depend on its index.  In a claim about traces a term stands for the
trace of that, and two more kinds say that the trace is cyclic and does not change by
transposition.  The claim is proved when its left side less its right side, less all
terms, has no word left.  Words are tuples of letters (name, transposed).
"""

import sympy as sp

NUMBER = (int, sp.Rational)


def complaints(statement, claim, certificate):
    """What is wrong with a certificate of a claim; [] when it proves the claim."""
    try:
        (shape, left), (other, right) = equation(statement, claim, certificate)
        parts = [(shape, 1, (), left, (), shape), (other, -1, (), right, (), shape)]
        scoped(statement, 1, (), left), scoped(statement, 1, (), right)
        for c, u, name, v in certificate:
            inner, terms = fact(statement, name, u, v)
            outside = ((), ()) if name[0] in ("cyclic", "turned") else (u, v)
            scoped(statement, c, outside[0] + outside[1], terms)
            parts.append((inner, -c, outside[0], terms, outside[1], shape))
        rest = {}
        for inner, c, u, terms, v, whole in parts:
            for word, d in terms.items():
                word, factor = fitted(statement, u, word, v, inner, whole)
                rest[word] = rest.get(word, 0) + c * d * factor
    except (KeyError, TypeError, ValueError) as problem:
        return [f"{type(problem).__name__}: {problem}"]
    return [f"left over: {c} {w}" for w, c in rest.items() if not vanishes(c)]


def equation(statement, claim, certificate):
    """The two sides of a claim, or of a lemma, which cites earlier lemmas only."""
    if claim not in statement.lemmas:
        return statement.claims[claim]
    names = list(statement.lemmas)
    later = names[names.index(claim) :]
    if any(
        kind == "exchanged" and key in later for _, _, (kind, key, _), _ in certificate
    ):
        raise ValueError("a lemma rests on itself")
    p, q, c = statement.lemmas[claim]
    return times(p, q), (p[0], {(): c})


def scoped(statement, c, outside, terms):
    """Refuse what no sum over an index says, of c times terms within two words.

    Read for one member, a term without the sign of the sum is what it is for that
    member, and a term with it is the sum of what it is for each.
    """
    for sign, names in statement.sums.items():
        inside = max((degree(d, sign) for d in terms.values()), default=0)
        if inside + degree(c, sign) > 1:
            raise ValueError(f"{sign} within {sign}, or divided by")
        if inside and any(name in names for name, _ in outside):
            raise ValueError(f"{sign} does not reach all that depends on its index")


def degrees(statement, c):
    """Whether a coefficient has a sign of a sum."""
    return any(degree(c, sign) for sign in statement.sums)


def degree(c, sign):
    """In which power a sign is in a coefficient; 2 if in none that is whole."""
    c = sp.sympify(c)
    if not c.has(sign):
        return 0
    c = sp.cancel(c)
    return sp.degree(c, sign) if c.is_polynomial(sign) else 2


def vanishes(c):
    """Whether a number, or an expression in scalars, is zero."""
    if isinstance(c, NUMBER):
        return c == 0
    c = sp.sympify(c)
    if c.is_rational_function():  # zero if its numerator is, multiplied out
        return sp.expand(sp.fraction(sp.together(c))[0]) == 0
    return sp.simplify(c) == 0


def fact(statement, name, u, v):
    """(shape, terms) of the l - r that a term names as (kind, name, transposed)."""
    kind, key, transposed = name
    if kind == "turned" and v:
        raise ValueError("a trace is transposed as a whole")
    if kind == "cyclic":  # tr(u v) - tr(v u)
        return None, difference({u + v: 1}, {v + u: 1})
    if kind == "turned":  # tr(u) - tr(u')
        return None, difference({u: 1}, {flip(u): 1})
    if kind == "given":
        (shape, left), (_, right) = statement.given[key]
    elif kind == "symmetric" and key in statement.symmetric:
        shape, left, right = (
            statement.sizes[key],
            {((key, True),): 1},
            {((key, False),): 1},
        )
    elif kind == "exchanged":  # square p, q with p q = c I have q p = c I
        p, q, c = statement.lemmas[key]
        joined([p[0], p[0], q[0], q[0]])
        if sp.sympify(c).is_zero is not False:
            raise ValueError(f"{c} may be zero")
        signs = [d for d in (*p[1].values(), *q[1].values()) if degrees(statement, d)]
        if signs:
            raise ValueError(f"{signs[0]} in a lemma")
        (shape, left), right = times(q, p), {(): c}
    elif kind == "number":  # 1 x 1: a = a', a b = b a
        (a, b), shape = key, (1, 1)
        left, right = ({a + b: 1}, {b + a: 1}) if b else ({a: 1}, {flip(a): 1})
    else:
        shape, base = statement.inverses[key]
        y, left = ((key, False),), {}
        for word, c in base.items():
            left[{"right inverse": word + y, "left inverse": y + word}[kind]] = c
        right = {(): 1}
    terms = difference(left, right)
    if transposed:
        shape, terms = shape[::-1], {flip(word): c for word, c in terms.items()}
    return shape, terms


def fitted(statement, u, word, v, inner, whole):
    """The word u word v, after its shapes; in a trace the empty word is its size."""
    path = [*[size(statement, x) for x in u]]
    if inner is not None:
        path += [inner, *[size(statement, x) for x in v]]
        within = [inner[:1] * 2, *[size(statement, x) for x in word], inner[1:] * 2]
        joined(path), joined(within)
        if whole is not None:
            joined([whole[:1] * 2, *path, whole[1:] * 2])
    elif u or v or whole is not None:
        raise ValueError("a scalar stands alone, in a claim about scalars")
    elif word:
        path = [size(statement, x) for x in word]
        joined(path)
    full = u + word + v
    if whole is None and path:
        joined([path[-1], path[0]])
        return full, 1 if full else path[0][0]
    return full, 1


def size(statement, letter):
    name, transposed = letter
    return tuple(statement.sizes[name][:: -1 if transposed else 1])


def joined(shapes):
    """Each factor must have as many rows as the one before it has columns."""
    for a, b in zip(shapes, shapes[1:]):
        if a[1] != b[0] and sp.expand(a[1] - b[0]) != 0:
            raise ValueError(f"shapes {a} and {b} do not fit")


def times(p, q):
    (one, left), (two, right) = p, q
    found = {}
    for u, c in left.items():
        for v, d in right.items():
            found[u + v] = found.get(u + v, 0) + c * d
    return (one[0], two[1]), found


def difference(left, right):
    return {w: left.get(w, 0) - right.get(w, 0) for w in {**left, **right}}


def flip(word):
    return tuple((name, not transposed) for name, transposed in reversed(word))
