"""Prove that an equation follows from others, with a certificate to be checked."""

from dataclasses import dataclass, field

from .certificates import spelled_out
from .checker import complaints
from .models import NoModel, refute
from .polynomials import Polynomial, Traces
from .search import LIMITS, searches
from .statements import Statement, read


@dataclass(frozen=True)
class Proof:
    """An equation that has been proved, and why it holds.

    Attributes
    ----------
    left, right : expression
        The two sides.
    statement : Statement
        The sides and everything they rest on in plain data.
    certificates : dict of str to tuple of terms
        For each block of the claim the terms `(c, u, fact, v)` whose sum
        c u (l - r) v is left - right; `fact` is `(kind, name, transposed)`.
    """

    left: object
    right: object
    statement: Statement
    certificates: dict = field(repr=False)

    @property
    def certificate(self):
        """All terms, block after block."""
        return tuple(term for terms in self.certificates.values() for term in terms)

    def complaints(self):
        """What the independent checker has to say against the certificate."""
        missing = [c for c in self.statement.claims if c not in self.certificates]
        return [f"no certificate of {c}" for c in missing] + [
            f"{claim}: {fault}"
            for claim, terms in self.certificates.items()
            for fault in complaints(self.statement, claim, terms)
        ]

    def check(self):
        """Whether the certificate, multiplied out by the independent checker, holds."""
        return not self.complaints()

    @property
    def cited(self):
        """The names of the given relations that the certificate uses, in order."""
        used = {
            name for _, _, (kind, name, _), _ in self.certificate if kind == "given"
        }
        return tuple(name for name in self.statement.given if name in used)

    def __str__(self):
        lines = [f"{self.left} - ({self.right}) ="]
        lines += [f"  {text(term)}" for term in self.certificate] or ["  0"]
        return "\n".join(lines)


def text(term):
    """One term of a certificate as a line."""
    c, u, (kind, name, transposed), v = term
    mark = lambda word: " ".join(n + "'" * t for n, t in word)  # noqa: E731
    said = {
        "given": f"[{name}]",
        "symmetric": f"[{name}' = {name}]",
        "right inverse": f"[{name} is an inverse, on the right]",
        "left inverse": f"[{name} is an inverse, on the left]",
        "cyclic": "[tr(X Y) = tr(Y X)]",
        "turned": "[tr X' = tr X]",
    }[kind]
    return " ".join(filter(None, [f"{c} *", mark(u), said + "'" * transposed, mark(v)]))


class Unproved(Exception):
    """An equation that could not be proved from what was given.

    Attributes
    ----------
    left_over : normal form
        What left - right becomes under the relations; `as_expr()` gives it in SymPy.
    counterexample : dict or None
        {symbol: explicit Matrix} with exact entries that satisfies everything given
        and not the equation, if one was found.
    complete : bool
        True if every consequence of the relations rewrites to zero, so that the
        equation does not follow by rewriting; False if the search met its limit.
    """

    def __init__(self, message, left_over, complete, counterexample=None):
        super().__init__(message)
        self.left_over, self.complete = left_over, complete
        self.counterexample = counterexample


def prove(left, right, given=(), symmetric=(), limits=LIMITS):
    """Prove `left = right` for all matrices that satisfy what is given.

    Parameters
    ----------
    left, right : MatrixExpr or scalar expression in traces
        The two sides.  Inverses of composites and partitioned matrices are allowed.  A
        right side of 0 fits every left side.
    given : iterable of Relation or (left, right)
        What may be used.  An inverse brings its own defining equations with it.
    symmetric : iterable of MatrixSymbol
        Symbols that equal their transpose.
    limits : sequence of (order, Limit)
        Which orders of letters are tried, and how far each is pursued.

    Returns
    -------
    Proof
        With a certificate that `Proof.check` multiplies out independently.

    Raises
    ------
    Unproved
        It does not follow by rewriting, or the search met its limit; with what is left
        over, and a counterexample if one was found.
    ShapeError
        Shapes do not fit at symbolic sizes, or an inverse is not square.
    Contradiction
        The relations say that an identity matrix is zero.

    Examples
    --------
    The push-through identity: both inverses are of sums, and of different sizes.

    >>> from sympy import Identity, MatrixSymbol, symbols
    >>> from luenberger.symbolic import prove
    >>> n, m = symbols("n m", integer=True, positive=True)
    >>> A, B = MatrixSymbol("A", n, m), MatrixSymbol("B", m, n)
    >>> left = (Identity(n) + A * B).I * A
    >>> right = A * (Identity(m) + B * A).I
    >>> proof = prove(left, right)
    >>> proof.check()
    True
    >>> len(proof.certificate)
    2

    Notes
    -----
    What does not follow by rewriting may still be true of matrices.  Two square
    matrices with A B = I have B A = I, but that uses the finite size of A.
    """
    statement, free = read(left, right, given, symmetric)
    outcome = None
    for search in searches(statement, limits):
        outcome = search.run()
        if outcome == "proved":
            return Proof(left, right, statement, certificates(search))
        if outcome == "complete":
            break
    raise unproved(left, right, given, symmetric, search, free, outcome)


def certificates(search):
    """{claim: terms} of a search that has proved every claim."""
    return {
        claim: spelled_out(search.problem, claim, search.engine.flatten(why))
        for claim, (_, why) in search.targets.items()
    }


def unproved(left, right, given, symmetric, search, free, outcome):
    """The exception, with what is left over and a counterexample if there is one."""
    claim, rest = next((c, rest) for c, (rest, _) in search.targets.items() if rest)
    over = normal_form(search.problem, free, claim, rest)
    complete = outcome == "complete"
    if complete:
        why = "it does not follow from these relations by rewriting"
    else:
        why = f"the search met its limit{search.reached}"
    found = counterexample(left, right, given, symmetric)
    if found is not None:
        why = "it is false; see the counterexample"
    block = claim.removeprefix("claim")
    return Unproved(
        f"not proved{block}: {why}; left over: {over}", over, complete, found
    )


def normal_form(problem, free, claim, rest):
    """What is left over, as a polynomial of the free algebra."""
    letters = {
        (name, t): free.letter(atom, t, inverted)
        for (atom, inverted), name in free.names.items()
        for t in (False, True)
    }
    pairs = [
        (tuple(letters[x] for x in problem.spelled(w)), problem.coefficient(c))
        for w, c in rest.items()
    ]
    shape = problem.statement.claims[claim][0][0]
    return Traces(free, pairs) if shape is None else Polynomial(free, pairs, shape)


def counterexample(left, right, given, symmetric):
    """{symbol: explicit Matrix} that refutes the claim, or None."""
    try:
        return refute(left, right, given, symmetric)
    except NoModel:
        return None
