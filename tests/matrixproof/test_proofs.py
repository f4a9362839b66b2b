"""The prover: identities proved, certificates checked, damage noticed."""

import dataclasses
import pathlib
import re
import time
from functools import cache

import pytest
import sympy as sp
from identities import FALSE, TRUE, parts
from in_use import derivations

from matrixproof import (
    BlockMatrix,
    Identity,
    Line,
    MatrixSymbol,
    Relation,
    ZeroMatrix,
    checker,
    letters,
    prove,
)
from matrixproof.checker import complaints, fact
from matrixproof.lines import follows
from matrixproof.models import denial, evaluate
from matrixproof.proofs import Proof, Unproved
from matrixproof.rewriting import Contradiction, Limit

n, m = sp.symbols("n m", integer=True, positive=True)
A, B, C, S = (MatrixSymbol(name, n, n) for name in "ABCS")
U, V = MatrixSymbol("U", n, m), MatrixSymbol("V", m, n)


@cache
def proved(name):
    """The proof of an identity of the table, and the seconds it took."""
    start = time.process_time()
    proof = prove(*parts(TRUE[name]))
    return proof, time.process_time() - start


@pytest.mark.parametrize("name", TRUE)
def test_identity_is_proved_within_a_second(name):
    proof, seconds = proved(name)
    assert proof.complaints() == []
    assert seconds < 1


@pytest.mark.parametrize("name", FALSE)
def test_false_variant_is_refuted_by_explicit_matrices(name):
    left, right, given, symmetric = parts(FALSE[name])
    with pytest.raises(Unproved) as failure:
        prove(left, right, given, symmetric)
    assert not failure.value.left_over.is_zero
    found = failure.value.counterexample
    for a, b in given:
        assert evaluate(a, found) == evaluate(b, found)
    for s in symmetric:
        assert found[s] == found[s].T
    assert evaluate(left, found) != evaluate(right, found)


# -- damage ---------------------------------------------------------------------------


def damaged(statement, term):
    """(what, the term with one thing wrong), where that makes a difference."""
    c, u, name, v = term
    kind, key, transposed = name
    letter = ((next(iter(statement.sizes)), False),)
    yield "dropped", None
    yield "sign", (-c, u, name, v)
    yield "coefficient", (c + 1, u, name, v)
    yield "u", (c, u + letter, name, v)
    yield "v", (c, u, name, letter + v)
    if u:
        yield "u shortened", (c, u[1:], name, v)
        flipped = (u[0][0], not u[0][1])
        yield "u transposed", (c, (flipped, *u[1:]), name, v)
    if v:
        yield "v shortened", (c, u, name, v[:-1])
    if kind in ("cyclic", "turned"):
        return
    others = [("given", k, False) for k in statement.given if ("given", k) != name[:2]]
    others += [(side, k, False) for k in statement.inverses for side in SIDES]
    others += [(kind, key, not transposed), ("given", "nothing", False)]
    known = fact(statement, name, u, v)
    for other in others:
        if other[1] == "nothing" or not same(fact(statement, other, u, v), known):
            yield f"relation {other}", (c, u, other, v)


SIDES = ("right inverse", "left inverse")


def same(one, other):
    (_, left), (_, right) = one, other
    words = {*left, *right}
    return all(left.get(w, 0) == right.get(w, 0) for w in words)


def vacuous(statement, term):
    """Whether a term is zero in itself, as tr(A A) - tr(A A) is."""
    _, terms = fact(statement, term[2], term[1], term[3])
    return not any(terms.values())


@pytest.mark.parametrize("name", TRUE)
def test_checker_rejects_every_damaged_certificate(name):
    proof, _ = proved(name)
    statement = proof.statement
    for claim, terms in proof.certificates.items():
        for i, term in list(enumerate(terms))[:: 1 + len(terms) // 4]:
            assert not vacuous(statement, term)
            for what, wrong in damaged(statement, term):
                other = [*terms[:i], *([wrong] if wrong else []), *terms[i + 1 :]]
                assert complaints(statement, claim, other), (i, what)


def test_checker_needs_every_block():
    proof = proved("block inverse")[0]
    some = dict(list(proof.certificates.items())[1:])
    assert proof.check()
    assert not dataclasses.replace(proof, certificates=some).check()


def test_checker_looks_at_shapes():
    proof = proved("push-through")[0]
    for name in proof.statement.sizes:
        sizes = {**proof.statement.sizes, name: (n, sp.Symbol("k"))}
        wrong = dataclasses.replace(proof.statement, sizes=sizes)
        assert complaints(wrong, "claim", proof.certificate)


def test_checker_does_not_take_a_symbol_for_symmetric():
    proof = prove(S.T * A, S * A, symmetric=[S])
    nothing = dataclasses.replace(proof.statement, symmetric=frozenset())
    assert proof.check()
    assert complaints(nothing, "claim", proof.certificate)


def test_checker_does_not_take_a_lemma_on_trust():
    proof = prove(B * A, Identity(n), [(A * B, Identity(n))])
    (name,) = proof.statement.lemmas
    p, q, c = proof.statement.lemmas[name]
    assert proof.check()
    without = {k: v for k, v in proof.certificates.items() if k != name}
    assert not dataclasses.replace(proof, certificates=without).check()
    itself = proof.certificates | {name: ((1, (), ("exchanged", name, False), ()),)}
    assert not dataclasses.replace(proof, certificates=itself).check()
    for wrong in [(p, q, 0), (p, q, 2), (p, q, sp.Symbol("c")), (q, p, c)]:
        statement = dataclasses.replace(proof.statement, lemmas={name: wrong})
        assert not dataclasses.replace(proof, statement=statement).check()


def test_checker_exchanges_square_matrices_only():
    proof = prove(B * A, Identity(n), [(A * B, Identity(n))])
    sizes = {"A": (n, m), "B": (m, n)}
    statement = dataclasses.replace(proof.statement, sizes=sizes)
    assert complaints(statement, "claim", proof.certificates["claim"])


def test_checker_shares_no_code_with_the_prover():
    source = pathlib.Path(checker.__file__).read_text(encoding="utf-8")
    imports = re.findall(r"^ *(?:import|from) .*", source, re.M)
    assert imports == ["import sympy as sp"]


# -- what a proof says ----------------------------------------------------------------


def test_a_proof_cites_what_it_used():
    one, two = Relation("one", A * B, Identity(n)), Relation("two", C * A, Identity(n))
    idle = Relation("idle", S * B, C)
    proof = prove(B, C, [idle, one, two])
    assert proof.cited == ("one", "two")
    assert "[one]" in str(proof) and "[two]" in str(proof)


def test_relations_of_one_name_are_told_apart():
    twice = [Relation("r", A * B, Identity(n)), Relation("r", C * A, Identity(n))]
    proof = prove(B, C, twice)
    assert proof.cited == ("r", "r (2)")
    assert proof.check()


def test_symbols_of_one_name_are_told_apart():
    small = MatrixSymbol("A", m, m)
    with pytest.raises(Unproved):
        prove(A * U, U * small)
    assert prove(A * A * U, U * small * small, [(A * U, U * small)]).check()


def test_what_is_not_proved_says_how_far_it_went():
    with pytest.raises(Unproved, match="it is false") as failure:
        prove(A * B, B * A)
    assert failure.value.complete
    assert failure.value.left_over.as_expr() == A * B - B * A
    with pytest.raises(Unproved, match="does not follow") as failure:
        prove(A, ZeroMatrix(n, n), [(A.T * A, ZeroMatrix(n, n))])  # by signs only
    assert failure.value.complete and failure.value.counterexample is None
    short = [("inverses", Limit(degree=3))]
    with pytest.raises(Unproved, match="limit at degree 4") as failure:
        prove(*parts(TRUE["pseudo-inverse is unique"]), limits=short)
    assert not failure.value.complete
    assert failure.value.counterexample is None
    short = [("inverses", Limit(steps=5))]
    with pytest.raises(Unproved, match="limit at degree 2;"):
        prove(*parts(TRUE["pseudo-inverse is unique"]), limits=short)


def test_a_line_that_no_model_denies_need_not_follow():
    """A'A = 0 makes a real A zero, which the prover does not see: no reason is idle."""
    zero = ZeroMatrix(n, n)
    squares = Relation("no squares", A.T * A, zero)
    assert denial(A, zero, (squares,), ()) is None
    assert not follows(A, zero, (squares,), ())
    assert follows(B * A.T * A, zero, (squares,), ())


def test_left_over_spells_composites_out():
    with pytest.raises(Unproved) as failure:
        prove((A + B).I, A.I)
    assert str(failure.value.left_over) == "(A + B)**(-1) - A**(-1)"


def test_a_block_matrix_has_one_inverse():
    """Its blocks are letters, so that what is before it meets it block by block."""
    D, W = MatrixSymbol("D", m, m), MatrixSymbol("W", n, m)
    blocks = BlockMatrix([[A, ZeroMatrix(n, m)], [V, D]])
    tall = BlockMatrix([[W], [D]])
    assert prove(blocks.I * blocks * tall, tall).check()
    assert prove(blocks.I * tall + blocks.I * tall, 2 * blocks.I * tall).check()
    with pytest.raises(Unproved):
        prove(blocks.I * tall, blocks.I * tall + tall)


def test_a_composite_that_is_symmetric_has_a_symmetric_inverse():
    inner = V * S * V.T
    assert prove(inner.I.T, inner.I, symmetric=[S]).check()
    with pytest.raises(Unproved):
        prove(inner.I.T, inner.I)


def test_what_has_no_scalar_value_is_refused():
    with pytest.raises(TypeError):
        prove(sp.Trace(A) * B, B)
    with pytest.raises(TypeError, match="not a relation"):
        prove(A, B, [A])
    assert prove(A - A, ZeroMatrix(n, n)).certificate == ()


# -- the claims of the library --------------------------------------------------------


def test_every_line_of_the_library_has_a_certificate(monkeypatch):
    """A line follows if its certificate holds: one that does not is an error."""
    steps = [step for found in derivations() for step in found.steps.values()]
    lines = sum(len(getattr(step, "lines", ())) for step in steps)  # checked as proved
    assert lines > 700
    monkeypatch.setattr(Proof, "faults", lambda proof: ["left over"])
    with pytest.raises(AssertionError, match="does not hold"):
        Line(A * (B + C)).complaints(A * B + A * C, ())


# -- what is known only times a number ------------------------------------------------


def test_eigenvectors_of_a_symmetric_matrix_are_orthogonal():
    A, u, v, a, b = letters("A:n*n= u:n v:n alpha beta")
    known = [(A * u, a * u), (A * v, b * v)]
    proof = prove(a * u.T * v, b * u.T * v, known)
    assert proof.check() and len(proof.cited) == 2
    with pytest.raises(Unproved) as e:  # where a = b they need not be
        prove(u.T * v, 0, known)
    assert e.value.counterexample
    with pytest.raises(Unproved):
        prove(a * u.T * v, b * u.T * v, known[:1])


def test_eigenvectors_on_both_sides_without_a_division():
    M, B, X, w, v, a, b = letters("M:n*n B:m*m X:n*m w:1*n v:m alpha beta")
    known = [(w * M, a * w), (B * v, b * v), (M * X, X * B)]
    twice = a**2 * w * X * v - a * b * w * X * v
    assert prove(twice, 0, known).check()
    with pytest.raises(Unproved):
        prove(a * w * X * v + b * w * X * v, 0, known)


def test_a_commutator_is_no_identity():
    X, Y, Z = letters("X:n*n Y:n*n Z:n*n")
    with pytest.raises(Contradiction, match="the trace of .* says that n = 0"):
        prove(X * Y, Y * X, [(X * Y - Y * X, Identity(X.rows))])
    with pytest.raises(Unproved):
        prove(X * Y, Y * X, [(X * Y - Y * X, Z)])
