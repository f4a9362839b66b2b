"""A line that differentiates or averages does not take for constant what is not."""

import pytest
import sympy as sp
from sympy import Determinant, Trace, symbols

from matrixproof import (
    Derivation,
    Expect,
    Identity,
    Line,
    MatrixSymbol,
    Notation,
    Relation,
    ZeroMatrix,
)
from matrixproof.dependence import Scope
from matrixproof.operators import Differential, Gradient

n = symbols("n", integer=True, positive=True)
letters = Notation()
A, C, S, X, Z = (letters(name, n, n, "a matrix") for name in "ACSXZ")
dX, dS = (letters(name, n, n, "an increment") for name in ("dX", "dS"))
e, v, w, x = (letters(name, n, 1, "a column") for name in "evwx")
t = letters.scalar("t", "a number")
P = letters("P", n, n, "a covariance", symmetric=True)
dP = letters("dP", n, n, "its increment", symmetric=True)
O = ZeroMatrix(n, n)

square = letters.suppose(S, X.T * X)
through = letters.suppose(Z, S + A)
fixed = letters.suppose(P, X * P * X.T + A)
tie = letters.suppose(X * Z, A)
size = letters.suppose(t, Trace(X))
same = letters.suppose(e, w)
turned = letters.suppose(w, e)
moves = letters.suppose(v, A * x + w)
mean, white = letters.moment(w, ZeroMatrix(n, 1)), letters.moment(w * w.T, P)
state = letters.moment(e * e.T, A)
apart = letters.moment(e * w.T, O)

GRADIENT, MOVED = {"of": X}, {"of": {X: dX}}
HIDDEN = {  # what the line takes for constant: relations of the page, start, line
    "S": ([square], Trace(S), Gradient(O, **GRADIENT)),
    "Z, twice removed": ([square, through], Trace(Z), Gradient(O, **GRADIENT)),
    "P, a fixed point": ([fixed], Trace(P * A), Gradient(O, **GRADIENT)),
    "Z, by an equation": ([tie], Trace(X * Z), Gradient(Z.T, **GRADIENT)),
    "t, a number": ([size], t * Trace(X), Gradient(t * Identity(n), **GRADIENT)),
    "X, backwards": ([square], Trace(S * X), Gradient(X.T, of=S)),
    "S, moved": ([square], S * A, Differential(O, **MOVED)),
    "S, beside X": ([square], X * S, Differential(dX * S, **MOVED)),
    "X, backwards, moved": ([square], X * S, Differential(X * dS, of={S: dS})),
    "e, the noise": ([same, mean], e * w.T, Expect(O, moments=[mean])),
    "e, the noise, turned": ([turned, mean], e * w.T, Expect(O, moments=[mean])),
    "v, the next state": ([moves, mean], v * w.T, Expect(O, moments=[mean])),
    "e, random elsewhere": ([mean, state], e * w.T, Expect(O, moments=[mean])),
}


def page(relations, start, line):
    chain = letters.chain("", "a line that goes wrong", start, line)
    return Derivation(page=(*relations, chain), letters=letters)


def constants(found):
    return [fault for fault in found.check() if "for constant" in fault]


@pytest.mark.parametrize("name", HIDDEN)
def test_what_the_page_says_moves_is_not_constant(name):
    relations, start, line = HIDDEN[name]
    letter = name[0]
    faults = constants(page(relations, start, line))
    assert any(f"line 1 takes {letter} for constant" in fault for fault in faults)
    assert not page(relations, start, line).proved()
    assert constants(page([], start, line)) == []


@pytest.mark.parametrize("operation", ["gradient", "differential", "expectation"])
def test_a_chain_alone_knows_what_it_cites(operation):
    start, before, line = {
        "gradient": (Trace(X.T * X), Line(Trace(S), by=[square]), HIDDEN["S"][2]),
        "differential": (X.T * X * A, Line(S * A, by=[square]), HIDDEN["S, moved"][2]),
        "expectation": (
            w * w.T,
            Line(e * w.T, by=[same]),
            HIDDEN["e, the noise"][2],
        ),
    }[operation]
    (fault,) = letters.chain("", "alone", start, before, line).check()
    relation = same if operation == "expectation" else square
    assert fault.startswith("line 2 takes") and relation.name in fault
    assert "put that in first" in fault


def test_what_another_chain_proved_ties_as_its_reasons_do():
    earlier = letters.chain("", "put in", X.T * X, Line(S, by=[square]))
    line = Line(Trace(S), by=[earlier])
    chain = letters.chain("", "cited", Trace(X.T * X), line, HIDDEN["S"][2])
    found = Derivation(page=(square, earlier, chain), letters=letters)
    assert any("takes S for constant" in fault for fault in found.check())


def test_what_is_put_in_first_is_differentiated():
    start = Line(Trace(X.T * X), by=[square])
    chain = letters.chain("", "right", Trace(S), start, Gradient(2 * X, **GRADIENT))
    assert Derivation(page=(square, chain), letters=letters).check() == []


def test_the_letters_of_a_definition_are_constant_where_another_one_moves():
    line = Gradient(A.T, **GRADIENT)
    chain = letters.chain("", "right", Trace(A * X), line)
    put = letters.chain("", "put in", Z * C, Line((S + A) * C, by=[through]))
    found = Derivation(page=(chain, through, put), letters=letters)
    assert found.check() == []


def test_what_is_held_is_said():
    line = Gradient(Z.T, of=X, held=(Z,))
    chain = letters.chain("", "held", Trace(X * Z), line)
    use = letters.chain("", "used", X * Z, Line(A, by=[tie]))
    found = Derivation(page=(tie, chain, use), letters=letters)
    assert found.check() == []
    assert "Z held" in str(chain) and r"Z\text{ held}" in chain._repr_latex_()


def test_random_letters_of_the_line_are_averaged():
    moments = [white, state, apart]
    line = Expect(P + A, moments=moments)
    chain = letters.chain("", "right", (e + w) * (e + w).T, line)
    assert Derivation(page=(*moments, chain), letters=letters).check() == []


def test_what_a_random_letter_is_measured_from_may_be_constant():
    apart = letters.suppose(w, x - v)
    chain = letters.chain("", "right", v * w.T, Expect(O, moments=[mean]))
    assert constants(Derivation(page=(apart, mean, chain), letters=letters)) == []
    both = letters.chain("", "x too", x * w.T, Expect(O, moments=[mean]))
    found = Derivation(page=(apart, mean, chain, both), letters=letters)
    assert len(constants(found)) == 2


FUNCTIONS = {
    "determinant": Determinant(X),
    "square of its logarithm": sp.log(Determinant(X)) ** 2,
    "an entry": X[0, 0] ** 2,
    "its trace times a trace": Determinant(X) * Trace(A),
    "square of a trace": Trace(X) ** 2,
}


@pytest.mark.parametrize("name", FUNCTIONS)
def test_what_cannot_be_differentiated_is_refused(name):
    for right in (O, A):
        (fault,) = Gradient(right, of=X).complaints(FUNCTIONS[name], ())
        assert "cannot be worked out" in fault


def test_functions_that_are_not_known_are_refused():
    f = sp.Function("f")
    assert Gradient(sp.Integer(0), of=t).complaints(f(t), ())
    assert Gradient(sp.diff(f(t), t), of=t).complaints(f(t), ())
    assert Differential(t * dX, of={X: dX, t: sp.Symbol("dt")}).complaints(t * X, ())
    assert Differential(O, of={X: dX}).complaints(Determinant(X) * A, ())
    assert Expect(w[0, 0] * A, moments=[mean]).complaints(w[0, 0] * A, ())
    assert Expect(O, moments=[mean]).complaints(Determinant(w * w.T) * A, ())


def test_the_increment_of_a_symmetric_matrix_is_symmetric():
    line = Differential(dX * A, of={P: dX})
    (fault,) = line.complaints(P * A, (P,))
    assert "declare that symmetric" in fault
    assert Differential(dP * A, of={P: dP}).complaints(P * A, (P, dP)) == []


def test_definitions_are_followed_in_any_order():
    """What is defined last may be what all the others are made of."""
    A, B, C, X = (MatrixSymbol(name, n, n) for name in "ABCX")
    made = (C, 2 * B), (B, 3 * A), (A, X.T * X)
    relations = [Relation(f"of {left}", left, right) for left, right in made]
    assert set(Scope(relations).tied([X])) == {A, B, C}
    assert set(Scope(relations[1:]).tied([X])) == {A, B}
