"""What is true of matrices and does not follow from equations between words alone.

Square matrices with p q = c I and c not zero have q p = c I, because a matrix of finite
size with an inverse on one side has it on the other.  A 1 x 1 matrix is a number: it
equals its transpose, and two of them commute.
"""

from .words import same_size


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


def product(p, q):
    """The product of two polynomials {word: coefficient}."""
    found = {}
    for u, c in p.items():
        for v, d in q.items():
            found[u + v] = found.get(u + v, 0) + c * d
    return found


def one_by_one(statement):
    """Pairs of plain words that say what a 1 x 1 matrix does.

    (a, ()) stands for a = a', and (a, b) for a b = b a.
    """
    loops = sorted({x for w in statement.words for x in scalars(statement, w)})
    yield from ((a, ()) for a in loops)
    yield from ((a, b) for i, a in enumerate(loops) for b in loops[:i])


def scalars(statement, word):
    """The shortest pieces of a word that are 1 x 1."""
    sizes = [statement.sizes[name][1 if t else 0] for name, t in word]
    sizes += [statement.sizes[name][0 if t else 1] for name, t in word[-1:]]
    cuts = [i for i, size in enumerate(sizes) if same_size(size, 1)]
    return [word[i:j] for i, j in zip(cuts, cuts[1:])]
