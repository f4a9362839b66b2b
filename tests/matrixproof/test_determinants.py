"""Determinants of any size: products, inverses, block triangles, exchanges."""

from dataclasses import replace

import pytest
from sympy import Determinant as det
from sympy import Trace, log, symbols

from matrixproof import BlockMatrix, Chain, Identity, Line, ZeroMatrix, letters, prove
from matrixproof.models import evaluate
from matrixproof.proofs import Unproved

A, B, C, D = letters("A:n*m B:m*n C:m*n D:m*m")
X, Y, T, S, U, V, W = letters("X:n*n Y:n*n T:n*n S:n*n= U:n*k V:k*n W:k*k")
n, m = A.shape
one, other = Identity(n), Identity(m)
none = ZeroMatrix(m, n)
full = BlockMatrix([[X, A], [C, D]])
upper, upper_2 = (BlockMatrix([[x, A], [none, D]]) for x in (X, Y))

HOLD = {
    "an exchange": (det(one + A * B), det(other + B * A), []),
    "with a minus": (det(one - A * B), det(other - B * A), []),
    "with a sum": (det(one + A * B + A * C), det(other + (B + C) * A), []),
    "with a number": (
        det(2 * one + A * B) * 2**m,
        det(2 * other + B * A) * 2**n,
        [],
    ),
    "a product": (det(X * Y), det(X) * det(Y), []),
    "a product in turn": (det(X * Y * T), det(T * X * Y), []),
    "an inverse": (det(X.I), 1 / det(X), []),
    "a transpose": (det(X.T), det(X), []),
    "a power": (det(X**3), det(X) ** 3, []),
    "a multiple": (det(3 * X), 3**n * det(X), []),
    "the identity": (det(one), 1, []),
    "an upper triangle": (det(upper), det(X) * det(D), []),
    "a lower triangle": (det(upper.T), det(X) * det(D), []),
    "of triangles": (det(upper * upper_2), det(X) * det(Y) * det(D) ** 2, []),
    "a Schur complement": (det(full), det(X) * det(D - C * X.I * A), []),
    "both complements": (
        det(X) * det(D - C * X.I * A),
        det(D) * det(X - A * D.I * C),
        [],
    ),
    "similar matrices": (det(T.I * X * T), det(X), []),
    "the lemma": (det(X + U * V), det(X) * det(Identity(V.rows) + V * X.I * U), []),
    "with a weight": (
        det(X + U * W * V),
        det(X) * det(W) * det(W.I + V * X.I * U),
        [],
    ),
    "a definition": (det(S), det(X) * det(Y), [(S, X * Y)]),
    "beside a trace": (det(X * Y) + Trace(A * B), Trace(B * A) + det(Y * X), []),
    "logarithms": (log(det(X * Y)), log(det(X)) + log(det(Y)), []),
    "logarithms exchanged": (log(det(one + A * B)), log(det(other + B * A)), []),
}
FALSE = {
    "an exchange with another sign": (det(one + A * B), det(other - B * A), []),
    "a number without its power": (det(2 * one + A * B), det(2 * other + B * A), []),
    "a sum": (det(X + Y), det(X) + det(Y), []),
    "a product as a sum": (det(X * Y), det(X) + det(Y), []),
    "an inverse as it is": (det(X.I), det(X), []),
    "a multiple as of a number": (det(3 * X), 3 * det(X), []),
    "no triangle": (det(full), det(X) * det(D), []),
    "a complement with another sign": (det(full), det(X) * det(D + C * X.I * A), []),
    "of one, whatever it is": (det(X), 1, []),
    "a definition with another sign": (det(S), det(X) * det(Y), [(S, X + Y)]),
    "a product of what is not square": (det(one + A * B), 1 + Trace(A * B), []),
    "logarithms with another sign": (log(det(X * Y)), log(det(X)) - log(det(Y)), []),
    "a logarithm lost": (log(det(X * Y)), log(det(X)), []),
}


@pytest.mark.parametrize("name", HOLD)
def test_what_holds_is_proved_at_symbolic_sizes(name):
    proof = prove(*HOLD[name])
    assert proof.check() and proof.complaints() == []


@pytest.mark.parametrize("name", FALSE)
def test_what_is_false_is_refuted_by_matrices(name):
    left, right, given = FALSE[name]
    with pytest.raises(Unproved, match="it is false") as refused:
        prove(left, right, given)
    found = refused.value.counterexample
    assert evaluate(left, found) != evaluate(right, found)


def test_each_step_says_its_rule_and_is_held_to_it():
    proof = prove(det(one + A * B), det(other + B * A))
    (step,) = proof.steps
    assert str(step).endswith("[an exchange]")
    for wrong in (
        replace(step, within=step.within[::-1]),
        replace(step, parts=(step.parts[0] + step.parts[0],)),
        replace(step, proofs=step.proofs[:1]),
        replace(step, rule="a product"),
        replace(step, scale=symbols("c")),
    ):
        assert replace(proof, steps=(wrong,)).complaints()
    (triangle,) = prove(det(upper), det(X) * det(D)).steps
    for wrong in (
        replace(triangle, of=full),
        replace(triangle, parts=(X, X)),
        replace(triangle, rule="a transpose", of=X.T),
    ):
        assert wrong.complaints()
    assert replace(proof, steps=()).complaints()


def test_it_is_a_line_of_a_chain():
    line = Line(log(det(X)) + log(det(Y)), why="of a product")
    assert Chain("", "", log(det(X * Y)), [line]).check() == []
    (fault,) = Chain("", "", log(det(X)), [Line(log(det(Y)), why="")]).check()
    assert "the sides are 0 and log(" in fault
    given = [(S, X * Y), (T, Y * X)]
    assert prove(det(S), det(T), given).cited == ("S = X*Y", "T = Y*X")


def test_definitions_that_go_round_come_to_an_end():
    assert prove(det(S), det(X) * det(Y), [(S, X * Y), (X, S * Y)]).check()
