"""Check a certificate by multiplying it out.  Shares no code with the prover.

A certificate is a sum of terms `(c, u, fact, v)`; each stands for c u (l - r) v, where
l = r is a given relation, a defining equation of an inverse, a symmetry, or one of
these transposed.  In a claim about traces a term stands for the trace of that, and two
more kinds say that the trace is cyclic and that it does not change by transposition.
The claim is proved when its left side less its right side, less all terms, has no word
left.  Words are tuples of letters (name, transposed).
"""

import sympy as sp

NUMBER = (int, sp.Rational)


def complaints(statement, claim, certificate):
    """What is wrong with a certificate of a claim; [] when it proves the claim."""
    (shape, left), (other, right) = statement.claims[claim]
    parts = [(shape, 1, (), left, (), shape), (other, -1, (), right, (), shape)]
    try:
        for c, u, name, v in certificate:
            inner, terms = fact(statement, name, u, v)
            outside = ((), ()) if name[0] in ("cyclic", "turned") else (u, v)
            parts.append((inner, -c, outside[0], terms, outside[1], shape))
        rest = {}
        for inner, c, u, terms, v, whole in parts:
            for word, d in terms.items():
                word, factor = fitted(statement, u, word, v, inner, whole)
                rest[word] = rest.get(word, 0) + c * d * factor
    except (KeyError, ValueError) as problem:
        return [f"{type(problem).__name__}: {problem}"]
    return [f"left over: {c} {w}" for w, c in rest.items() if not vanishes(c)]


def vanishes(c):
    """Whether a number, or an expression in scalars, is zero."""
    return c == 0 if isinstance(c, NUMBER) else sp.simplify(c) == 0


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
        if sp.expand(a[1] - b[0]) != 0:
            raise ValueError(f"shapes {a} and {b} do not fit")


def difference(left, right):
    return {w: left.get(w, 0) - right.get(w, 0) for w in {**left, **right}}


def flip(word):
    return tuple((name, not transposed) for name, transposed in reversed(word))
