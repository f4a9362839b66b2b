"""Prove that an equation follows from others, with a certificate to be checked."""

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from typing import Any

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from . import determinants
from .algebra import Algebra, Polynomial, Traces
from .certificates import spelled_out
from .checker import complaints
from .dependence import declared
from .models import NoModel, possible, refute
from .relations import Given, named, unfounded
from .rewriting import Contradiction, Limit
from .search import LIMITS, searches
from .statements import Statement, read
from .words import Formula, Symbols, Values, plain, same_size


@dataclass(frozen=True)
class Proof:
    """An equation that has been proved, and why it holds.

    Attributes
    ----------
    left, right : expression
    statement : Statement
        The sides and everything they rest on in plain data.
    certificates : dict of str to tuple of terms
        For each block of the claim the terms `(c, u, fact, v)` whose sum
        c u (l - r) v is left - right; `fact` is `(kind, name, transposed)`.
    given, symmetric : tuple
        What was supposed, for `check` to find a model of.
    """

    left: Formula
    right: Formula
    statement: Statement
    certificates: dict = field(repr=False)
    given: tuple = ()
    symmetric: tuple = ()

    @property
    def certificate(self) -> tuple[Any, ...]:
        """All terms, block after block, and those of the lemmas used."""
        return tuple(term for terms in self.certificates.values() for term in terms)

    def complaints(self) -> list[str]:
        """What is wrong; [] if the certificate holds and says something of matrices."""
        found = self.faults() or unfounded(self.given, self.symmetric)
        read_again = read(self.left, self.right, self.given, self.symmetric)[0]
        if replace(self.statement, lemmas={}) != read_again:
            found = ["what was proved is another statement than its sides say"]
        if not found and not possible(
            self.given, self.symmetric, (self.left, self.right)
        ):
            found = [
                "no matrices were found that satisfy what is given and have the "
                "inverses: they may contradict each other"
            ]
        return found

    def faults(self) -> list[str]:
        """What the independent checker has to say against the certificate."""
        wanted = [*self.statement.claims, *self.statement.lemmas]
        missing = [name for name in wanted if name not in self.certificates]
        return [f"no certificate of {name}" for name in missing] + [
            f"{claim}: {fault}"
            for claim, terms in self.certificates.items()
            for fault in complaints(self.statement, claim, terms)
        ]

    def check(self) -> bool:
        """Whether the certificate holds, multiplied out by the independent checker.

        A model of what is given must be found as well, in which everything that is
        inverted has an inverse: what nothing satisfies proves anything.
        """
        return not self.complaints()

    @property
    def cited(self) -> tuple[str, ...]:
        """The names of the given relations that the certificate uses, in order."""
        used = {
            name for _, _, (kind, name, _), _ in self.certificate if kind == "given"
        }
        return tuple(name for name in self.statement.given if name in used)

    def __str__(self):
        lines = [f"{self.left} - ({self.right}) ="]
        for claim, terms in self.certificates.items():
            lines += [f" {claim}:"] if len(self.certificates) > 1 else []
            lines += [f"  {as_line(term)}" for term in terms] or ["  0"]
        return "\n".join(lines)


def as_line(term):
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
        "exchanged": f"[{name}: p q = c I, so q p = c I]",
        "number": "[a 1 x 1 matrix is a number]",
    }[kind]
    return " ".join(filter(None, [f"{c} *", mark(u), said + "'" * transposed, mark(v)]))


class Unproved(Exception):
    """An equation that could not be proved from what was given.

    Attributes
    ----------
    left_over : normal form
        What left - right becomes under the relations; `as_expr()` gives it in SymPy.
    counterexample : dict or None
        {symbol: explicit Matrix} that satisfies everything given and not the equation.
    complete : bool
        True if every consequence of the relations rewrites to zero, so that the
        equation does not follow by rewriting; False if the search met its limit.
    """

    def __init__(
        self,
        message: str,
        left_over: Formula,
        complete: bool,
        counterexample: Values | None = None,
    ) -> None:
        super().__init__(message)
        self.left_over, self.complete = left_over, complete
        self.counterexample = counterexample


def prove(
    left: Formula,
    right: Formula,
    given: Given = (),
    symmetric: Symbols = (),
    limits: Sequence[tuple[str, Limit]] = LIMITS,
) -> Proof:
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
    >>> from matrixproof import letters, prove
    >>> K, M, N = letters("K:n*p M:p*p N:n*p")
    >>> prove(K, N * M.I, given=[(K * M, N)]).check()
    True

    Notes
    -----
    Beyond the equations that are given, it is used that square matrices with
    p q = c I have q p = c I, which the certificate has as a lemma, and that a 1 x 1
    matrix is a number.  What rests on signs is not used: A'A = 0 has A = 0 for real
    matrices, and does not follow by rewriting.

    Where nothing is given, both sides are rational functions of free entries; scalars
    other than sizes may then be divided by, as s - t is in the resolvent identity.
    Otherwise only what is certainly not zero is divided by.
    """
    proof, *failed = attempted(left, right, given, symmetric, limits)
    if proof is None:
        raise unproved(left, right, given, symmetric, *failed)
    return proof


KEEPING: list[list[Proof]] = []  # the lists of `kept`


@contextmanager
def kept() -> Iterator[list[Proof]]:
    """A list to which every proof is added that is found in the block, by any caller.

    >>> from matrixproof import letters
    >>> A, B = letters("A:n*n B:n*n")
    >>> with kept() as found:
    ...     proof = prove(A * (B + A), A * B + A * A)
    >>> found == [proof]
    True
    """
    KEEPING.append([])
    try:
        yield KEEPING[-1]
    finally:
        KEEPING.pop()


def attempted(left, right, given=(), symmetric=(), limits=LIMITS):
    """The proof, or None; the last search, the algebra in which it was read, the end.

    It does not ask for a counterexample where there is no proof.
    """
    given = named(given)
    symmetric = declared(symmetric, (left, right, *given))
    sides = [sp.sympify(plain(side)) for side in (left, right)]
    if any(side.has(sp.Determinant) for side in sides):
        return determinants.attempted(*sides, given, symmetric)
    statement, free = read(left, right, given, symmetric)
    outcome = None
    for search in searches(statement, limits):
        outcome = search.run()
        if outcome == "proved":
            told = *certified(search), given, symmetric
            proof = Proof(left, right, *told)
            if statement.sums and proof.faults():  # it took a sum for a number
                outcome = "limit"
                continue
            for found in KEEPING:
                found.append(proof)
            return proof, search, free, outcome
        if outcome == "complete":
            break
    return None, search, free, outcome


def certified(search):
    """The statement with the lemmas that were used, and {claim: terms} of all."""
    problem, engine = search.problem, search.engine
    whys = {name: engine.flatten(why) for name, (_, why) in search.targets.items()}
    waiting = list(whys)
    while waiting:
        for ref in {max(ref, ~ref) for _, ref, _ in whys[waiting.pop()]}:
            kind, name = problem.facts[ref]
            if kind == "exchanged" and name not in whys:
                whys[name] = engine.flatten([(1, (), search.lemmas[name][3], ())])
                waiting.append(name)
    used = {name: search.lemmas[name] for name in search.lemmas if name in whys}
    plain = {name: lemma(problem, *parts) for name, parts in used.items()}
    problem.statement = replace(problem.statement, lemmas=plain)
    terms = {name: spelled_out(problem, name, why) for name, why in whys.items()}
    return problem.statement, terms


def lemma(problem, p, q, c, node):
    """A lemma in plain data: its two factors and the number."""
    letter = next(w[0] for w in p if w)
    sides = problem.side(p, letter), problem.side(q, letter)
    return *sides, problem.coefficient(c)


def unproved(left, right, given, symmetric, search, free, outcome):
    """The exception, with what is left over and a counterexample if there is one."""
    refuse_traces(given, symmetric)
    open_ = [(c, rest) for c, (rest, _) in search.targets.items() if rest]
    if open_:
        over = normal_form(search.problem, free, *open_[0])
    else:  # it would hold if the signs of sums were numbers
        over = free.normal(left) - right
    claim = open_[0][0] if open_ else "claim"
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


def refuse_traces(given, symmetric):
    """Raise for a relation whose trace is that of nothing, as of X Y - Y X = I."""
    for r in named(given):
        square = isinstance(r.left, MatrixExpr) and same_size(*r.left.shape)
        if square and not sp.sympify(r.left - r.right).has(sp.BlockMatrix):
            terms = Algebra(symmetric).normal(sp.Trace(r.left - r.right)).terms
            if [*terms] == [()] and sp.sympify(terms[()]).is_zero is False:
                raise Contradiction(
                    f"the trace of {r.name} says that {abs(terms[()])} = 0: no "
                    "matrices satisfy it"
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
