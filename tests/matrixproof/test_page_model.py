"""All that a page, a line or a claim rests on holds at once, somewhere."""

import pytest
from sympy import symbols

from matrixproof import (
    Derivation,
    Expect,
    Identity,
    Line,
    Notation,
    Stage,
    ZeroMatrix,
    page_model,
    text,
)
from matrixproof.lines import Equation, Implies
from matrixproof.page_model import impossible

n, p = symbols("n p", integer=True, positive=True)
letters = Notation()
A, B, K, N, X, Y = (letters(name, n, n, "a matrix") for name in "ABKNXY")
P, Q = (letters(name, n, n, "a covariance", symmetric=True) for name in "PQ")
F, G = letters("F", n, p, "tall or wide"), letters("G", p, n, "wide or tall")
e, v, w, x = (letters(name, n, 1, "a column") for name in "evwx")
I, O, J = Identity(n), ZeroMatrix(n, n), Identity(p)
t = letters.scalar("t", "a number", positive=True)
moment, suppose = letters.moment, letters.suppose

CLASH = {
    "two products": [suppose(A * Y, I), suppose(A * Y, 2 * I)],
    "two values": [suppose(K, I), suppose(N, 2 * I), suppose(K, N)],
    "a square and an inverse": [suppose(A * A, O), suppose(A * B, I)],
    "no trace of a commutator": [suppose(A * B - B * A, I)],
    "a sum of squares": [suppose(A * A.T + B * B.T, O), suppose(A * X, I)],
    "two inverses of what is not square": [suppose(F * G, I), suppose(G * F, 2 * J)],
    "a number that is positive": [suppose(t * A, -A), suppose(A * B, I)],
    "a negative moment": [moment(w * w.T, -I)],
    "moments of one pair": [moment(w * v.T, I), moment(v * w.T, 2 * I)],
    "a noise that is nothing, and another": [
        moment(w * w.T, O),
        moment(w * v.T, I),
    ],
    "the mean is more than the square": [
        moment(w, x),
        moment(w * w.T, O),
        suppose(x.T * x, Identity(1)),
    ],
    "what is made of a noise": [
        suppose(e, A * w),
        moment(w * w.T, I),
        moment(e * e.T, O),
        suppose(A * B, I),
    ],
    "what a definition says of two moments": [
        suppose(e, w + v),
        moment(e * w.T, O),
        moment(v * w.T, O),
        moment(w * w.T, Q),
        suppose(Q * B, I),
    ],
}


@pytest.mark.parametrize("name", CLASH)
def test_what_cannot_hold_at_once_is_refused(name):
    relations = CLASH[name]
    (said,) = impossible(relations, letters.symmetric)
    assert "no model was found" in said and "give a witness" in said
    for relation in relations:
        assert relation.show(text) in said
    for k in range(len(relations)):
        rest = relations[:k] + relations[k + 1 :]
        assert impossible(rest, letters.symmetric) == []


def test_relations_that_do_not_clash_are_not_named():
    spare = suppose(X, A + B)
    (said,) = impossible([spare, *CLASH["two products"], suppose(N, X)])
    assert "A Y = I and A Y = 2 I hold at once" in said and "X =" not in said


TRUE = {
    "white noise": [moment(w * w.T, I), moment(w, ZeroMatrix(n, 1))],
    "noises that belong together": [
        moment(w * w.T, P),
        moment(v * v.T, Q),
        moment(w * v.T, N),
    ],
    "a step": [
        suppose(e, A * x + w),
        moment(x * x.T, P),
        moment(w * w.T, Q),
        moment(x * w.T, O),
        moment(e * e.T, X),
        suppose(X, A * P * A.T + Q),
    ],
    "its fixed point": [
        suppose(e, A * x + w),
        moment(x * x.T, P),
        moment(e * e.T, P),
        moment(w * w.T, Q),
        moment(x * w.T, O),
    ],
    "a difference of constants": [suppose(w, x - v), moment(w * w.T, Q)],
    "one is the other": [suppose(e, 2 * w), moment(e * w.T, 2 * Q), moment(w * w.T, Q)],
    "a mean": [moment(w, x), moment(w * w.T, Q + x * x.T)],
}


@pytest.mark.parametrize("name", TRUE)
def test_what_can_hold_at_once_has_a_model(name):
    assert impossible(TRUE[name], letters.symmetric) == []


def page(*items):
    return Derivation(page=items, letters=letters)


def test_a_page_has_one_model():
    one, two = CLASH["two products"]
    first = letters.chain("", "first", A * Y * A, Line(A, by=[one]))
    second = letters.chain("", "second", A * Y * A, Line(2 * A, by=[two]))
    assert page(one, first).check() == page(two, second).check() == []
    found = page(one, first, two, second)
    (fault,) = found.check()
    assert "A Y = I and A Y = 2 I hold at once" in fault
    assert not found.proved()


def test_what_has_a_model_is_not_searched_again(monkeypatch):
    """What says no more than was asked before; a witness is always tried."""
    one, two = CLASH["two products"]
    given, symmetric, shown = (one, suppose(X, A + B)), (P, Q), (B.I * P, Q)
    monkeypatch.setattr(page_model, "KNOWN", [])
    assert impossible(given, symmetric, shown) == []
    monkeypatch.setattr(page_model, "one_model", lambda *asked: None)
    assert impossible(given[:1], symmetric[:1], shown[:1]) == []
    for more in (
        ((*given, two), symmetric, shown),
        (given, (*symmetric, A), shown),
        (given, symmetric, (*shown, X.I)),
        (given, symmetric, shown, {B: [[1]]}),
    ):
        assert "no model was found" in impossible(*more)[0]


def test_a_page_spares_its_chains_a_search(monkeypatch):
    asked, search = [], page_model.one_model
    monkeypatch.setattr(page_model, "KNOWN", [])
    monkeypatch.setattr(
        page_model, "one_model", lambda *a: asked.append(a) or search(*a)
    )
    one, two = CLASH["two products"][0], suppose(K, B)
    lines = Line(A * Y * B, by=[two]), Line(B, by=[one])
    items = one, two, letters.chain("", "two lines", A * Y * K, *lines)
    assert page(*items).check() == [] and len(asked) == 1


def test_what_is_inverted_on_a_page_counts():
    nilpotent = suppose(A * A, O)
    square = letters.chain("", "square", A * A * B, Line(O, by=[nilpotent]))
    inverse = letters.chain("", "inverse", A.I * A * B, Line(B, why="cancel"))
    assert page(nilpotent, square).check() == page(inverse).check() == []
    (fault,) = page(nilpotent, square, inverse).check()
    assert "no model was found" in fault and "A A = 0" in fault


def test_what_stages_rest_on_has_one_model():
    one, two = suppose(K, N), suppose(X, N + I)
    stages = Stage(K, N, by=(one,)), Stage(X, N + I, by=(two,))
    assert Derivation((N,), stages).check() == []
    clash = suppose(K + I, N)
    other = Stage(X, K - N, by=(suppose(X, -I), clash))
    (fault,) = Derivation((N,), (stages[0], other)).check()
    assert "no model was found" in fault


def test_an_average_is_by_moments_that_exist():
    for moments, left, right in (
        (CLASH["moments of one pair"], w * v.T + v * w.T, 3 * I),
        (CLASH["a negative moment"], w * w.T, -I),
        ([moment(w * w.T, O), moment(w * v.T, I)], w * w.T + w * v.T, I),
    ):
        (fault,) = Expect(right, moments=moments).complaints(left, ())
        assert "no model was found" in fault


def test_a_witness_takes_the_place_of_a_search():
    hard = suppose(A.T * A, 2 * I), suppose(A + A.T, 2 * I)
    chain = letters.chain("", "used", A.T * A, Line(2 * I, by=hard[:1]))
    again = letters.chain("", "used too", A + A.T, Line(2 * I, by=hard[1:]))
    items = hard[0], chain, hard[1], again
    known = {A: [[1, -1], [1, 1]]}
    right = Derivation(page=items, letters=letters, witness=known)
    assert right.check() == []
    wrong = Derivation(page=items, letters=letters, witness={A: [[1, 1], [1, 1]]})
    (fault,) = wrong.check()
    assert "with this witness" in fault
    with pytest.raises(ValueError, match="P of the witness is not symmetric"):
        impossible([suppose(P, A)], [P], witness={P: [[1, 2], [3, 4]]})


def test_a_witness_has_sizes_of_its_own_and_letters_that_do_not_occur():
    """More sizes than are tried in turn, and one of them larger than any tried."""
    sizes = symbols("a:9", integer=True, positive=True)
    tall = [letters(f"T_{k}", size, n, "tall") for k, size in enumerate(sizes)]
    items = [suppose(T.T * T, I) for T in tall]
    known = {T: [[1, 0], [0, 1]] for T in tall} | {
        tall[0]: [[0, 0]] * 2 + [[1, 0], [0, 1]]
    }
    assert impossible(items, witness=known | {X: [[1]]}) == []
    assert impossible(items, witness=known | {tall[1]: [[1, 0], [0, 2]]})


# -- what an implication rests on -----------------------------------------------------


def test_an_implication_from_what_cannot_hold_is_refused():
    """Without this complaint, anything follows from A B - B A = I."""
    commutator = Equation(A * B - B * A, I)
    follows = Implies(Equation(A * A * B - A * B * A, A))
    assert follows.complaints(commutator, ()) == [
        "no matrices were found that satisfy what is cited"
    ]
    assert follows.complaints(Equation(A * B - B * A, Y), ()) != []
    right = Implies(Equation(A * A * B - A * B * A, A * Y))
    assert right.complaints(Equation(A * B - B * A, Y), ()) == []
