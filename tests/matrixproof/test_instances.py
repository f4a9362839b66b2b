"""A theorem in other letters, and what theorems rest on."""

import dataclasses

import pytest
import sympy as sp
from damage import damaged_sides
from sympy import Trace

from luenberger.papers.leondes_novak.derivation import huddle, quadratic
from luenberger.smoothing.derivation import next_state
from luenberger.theory import observer
from matrixproof import (
    Chain,
    Identity,
    Line,
    Notation,
    Page,
    Relation,
    ZeroMatrix,
    derive,
    letters,
)
from matrixproof.dependence import behind
from matrixproof.lines import Equation, Iff, Implies
from matrixproof.relations import Moment
from matrixproof.words import ShapeError

A, B, K, M, N, P = letters("A:n*n B:n*n K:n*p M:p*p= N:n*p P:n*n=")
F, G, H, X = letters("F:r*r G:r*r H:r*r X:r*r")
product = Relation("A B = I", A * B, Identity(A.rows))
theorem = derive(B * A * B + A, "7", "a product").use(product)
square = derive(P - K * N.T - N * K.T + K * M * K.T, says="a square")
best = Relation("", letters("Z:n*p")[0] * M, N)
square = square.square(K, best).drop(M)

THEOREMS = {
    f"{name} {title}": chain
    for name, page in {
        "quadratic": quadratic.page,
        "huddle": huddle.page,
        "next_state": next_state.page,
        "observer": observer.page,
    }.items()
    for title, chain in page.steps.items()
    if isinstance(chain, Chain)
}


def renamed(chain):
    """Every letter of a theorem, to one in other sizes, and the sizes themselves."""
    behind_it = [e for r in behind(chain.relations) for e in r.expressions]
    every = [sp.sympify(e) for e in (*chain.expressions, *behind_it)]
    found = {s for e in every for s in e.atoms(sp.MatrixSymbol)}
    sizes = {d for s in found for size in s.shape for d in size.free_symbols}
    other = {d: sp.Symbol(f"{d}_q", **d.assumptions0) for d in sizes}
    return other | {s: s.xreplace(other) for s in found}


def hypotheses(chain, to):
    """What a theorem supposes, in other letters."""
    return [r.mapped(lambda e: e.xreplace(to)) for r in behind(chain.relations)]


@pytest.mark.parametrize("name", THEOREMS)
def test_a_theorem_holds_in_other_letters_and_needs_all_that_it_supposes(name):
    chain = THEOREMS[name]
    to = renamed(chain)
    given = hypotheses(chain, to)
    found = chain.at(to, *given)
    assert found.check() == [] and found.full.check() == []
    assert {str(x) for x in found.rests_on().relations} <= {str(r) for r in given}
    assert len(found.lines) == len(chain.lines)
    for k, relation in enumerate(given):
        others = [r for r in given if r is not relation]
        with pytest.raises(ValueError, match="give it"):
            chain.at(to, *others)
        for _, right in list(damaged_sides(relation.right))[:1]:
            wrong = dataclasses.replace(relation, right=right)
            with pytest.raises(ValueError, match="give it"):
                chain.at(to, *given[:k], wrong, *given[k + 1 :])


@pytest.mark.parametrize("name", THEOREMS)
def test_what_a_theorem_rests_on_is_what_it_fails_without(name):
    chain = THEOREMS[name]
    found = chain.rests_on()
    assert set(found.relations) == set(behind(chain.relations))
    for relation in set(found.relations) & set(chain.relations):
        lines = [
            dataclasses.replace(
                line,
                **{
                    field: tuple(r for r in getattr(line, field) if r != relation)
                    for field in ("by", "moments")
                    if hasattr(line, field)
                },
            )
            for line in chain.lines
        ]
        assert dataclasses.replace(chain, lines=lines).check() != []
    kept = found.symmetric
    assert dataclasses.replace(chain, symmetric=kept).check() == []
    for x in kept:
        fewer = tuple(s for s in kept if s is not x)
        assert dataclasses.replace(chain, symmetric=fewer).check() != []


def test_what_becomes_an_identity_need_not_be_given():
    found = theorem.at({A: Identity(H.rows), B: Identity(H.rows)})
    assert found.check() == [] and found.rests_on().relations == ()
    given = Relation("F = G", F, G)
    half = Chain("", "put in", F * X, [Line(G * X, by=[given])])
    assert half.at({F: H, G: H}).lines == ()  # nothing is left to say


def test_a_hypothesis_may_be_turned_round_or_transposed():
    turned = Relation("", Identity(F.rows), F * G)
    across = Relation("", G.T * F.T, Identity(F.rows))
    for given in (turned, across, (F * G, Identity(F.rows))):
        assert theorem.at({A: F, B: G}, given).check() == []
    for wrong in ((G * F, Identity(F.rows)), (F * G, 2 * Identity(F.rows))):
        with pytest.raises(ValueError, match="A B = I, which is here F G = I: give it"):
            theorem.at({A: F, B: G}, wrong)


def test_a_mean_is_no_equation():
    x, y, S = letters("x:n y:n S:n*n")
    mean = Moment("", x * x.T, S)
    variance = derive(A * x * x.T * A.T, says="a variance").expect(mean)
    assert variance.at({x: y}, Moment("", y * y.T, S)).check() == []
    for wrong in ((y * y.T, S), Moment("", S, y * y.T)):
        with pytest.raises(ValueError, match=r"E\[y y'\] = S: give it"):
            variance.at({x: y}, wrong)
    with pytest.raises(ValueError, match="give it"):  # it averages, and is no identity
        variance.at({x: y, S: y * y.T})
    (fault,) = variance.at({x: A * y}, Moment("", A * y * (A * y).T, S)).check()
    assert "is not one or two symbols" in fault


def test_what_moves_is_a_letter_and_no_other_one_moves_with_it():
    slope = derive(Trace(K * M * K.T), says="a slope").gradient(K)
    L, S = letters("L:r*r S:r*r=")
    assert slope.at({K: L, M: S}).check() == []
    with pytest.raises(ValueError, match="K moves, so F G cannot stand for it"):
        slope.at({K: F * G, M: S})
    both = slope.at({K: L, M: L + L.T})  # d/dL tr(L (L + L') L')
    assert "does not follow" in both.check()[0]


def test_a_symmetric_letter_stands_for_what_is_symmetric():
    R = letters("R:r*r=")[0]
    Q, V, L = letters("Q:r*r V:r*r L:r*r")
    turned = derive(K * M, says="a transpose").transpose()
    assert turned.at({M: F * R * F.T, K: V}).check() == []
    assert turned.at({M: Q, K: V}).symmetric == (Q,)  # supposed to be, and said so
    assert turned.at({M: F * Q * F.T, K: V}, symmetric=(Q,)).check() == []
    with pytest.raises(ValueError, match="M is symmetric in a transpose, and nothing"):
        turned.at({M: F * Q * F.T, K: V})
    assert turned.at({M: Q, K: V}).rests_on().symmetric == (Q,)


def test_sizes_follow_from_letters_and_cannot_differ():
    assert theorem.at({A: F, B: G}, (F * G, Identity(F.rows))).left.shape == F.shape
    with pytest.raises(ShapeError, match="B is .r, r. in these letters, and K is"):
        theorem.at({A: F, B: K})
    with pytest.raises(ShapeError, match="and t is a number"):
        theorem.at({A: sp.Symbol("t")})


def test_zeros_and_identities_leave_short_lines():
    sum_ = Relation("", X, F + G * H)
    chain = Chain("", "a sum", X * F, [Line(F * F + G * H * F, by=[sum_])])
    gone = ZeroMatrix(F.rows, F.rows)
    found = chain.at({G: gone}, (X, F))
    assert found.right == F * F and found.check() == []
    assert chain.at({G: Identity(F.rows)}, (X, F + H)).right == F * F + H * F


def test_what_a_theorem_does_not_need_here_is_not_cited():
    first, second = Relation("", X, G * H), Relation("", G * F, H)
    chain = Chain("", "both", X * F + G * F, [Line(G * H * F + H, by=[first, second])])
    gone = ZeroMatrix(F.rows, F.rows)
    found = chain.at({G: gone, H: gone, X: gone})
    assert found.check() == [] and found.rests_on().relations == ()
    found = chain.at({F: gone}, (X, G * H), (gone, H))
    assert found.check() == [] and len(found.rests_on().relations) == 1


def test_it_is_shown_short_and_its_lines_are_there():
    given = Relation("(9) F G = I", F * G, Identity(F.rows))
    found = theorem.at({A: F, B: G}, given, number="8", says="in F")
    assert str(found).splitlines() == [
        "(8) in F",
        "  G F G + F",
        "    = G + F  theorem: (7) a product, with (9)  ✓",
    ]
    assert len(str(found.full).splitlines()) == 3
    assert r"\text{theorem: (7) a product, with }" in found._repr_latex_()
    slope = derive(Trace(square.left), says="a slope").expand().gradient(K)
    assert [row.sign for row in slope.at({}).rows(sp.latex)] == ["", "="]
    assert "≥" in str(square.at({K: K}, *square.relations))
    wrong = dataclasses.replace(found, lines=[Line(F, by=[given])])
    assert "✗" in str(wrong) and wrong.check() != []


def test_lines_that_are_not_shown_may_be_wide():
    grown = F * G + F * F * F * F - F * F * F * F
    chain = Chain("", "and back", F * G, [Line(grown), Line(F * G)])
    (long,) = letters("L" * 30 + ":r*r")
    found = chain.at({}, F=long)
    assert found.check() == [] and "needs a letter" in found.full.check()[0]


def test_the_sign_between_its_ends_is_the_weakest():
    same, less = Equation(F * H, G), Equation(F * H * X, G * X)
    both = Chain("", "both ways", Equation(F, G * H.I), [Iff(same)])
    one = Chain("", "one way", Equation(F, G * H.I), [Iff(same), Implies(less)])
    assert "⇔ F H = G" in str(both.at({})) and "⇒ F H X = G X" in str(one.at({}))
    assert "⇔" not in str(one.at({}))


def test_a_page_gives_a_theorem_all_that_it_says():
    notation = Notation()
    C, D = (notation(x, F.rows, F.rows, f"the matrix {x}") for x in "CD")
    page = Page(letters=notation, source="us")
    with pytest.raises(ValueError, match="C D = I: give it"):
        page.at("1", "too early", theorem, A=C, B=D)
    page(notation.suppose(C * D, Identity(F.rows)))
    found = page.at("1", "a product", theorem, A=C, B=D)
    later = page.chain("2", "used", D * C * D, Line(D, by=[page.page[0]]))
    assert page.page[-2:] == (found, later) and page.check() == []


def test_inverses_held_letters_and_typed_lines_are_listed():
    t = sp.Symbol("t")
    S = letters("S:n*n")[0]
    chain = derive(A + P / t, "1", "typed").insert(A * S * S.I + P / t)
    assert chain.rests_on().invertible == (S, t)
    assert "Inserted = A S S⁻¹ + (1/t) P" in str(chain.rests_on())
    assert "S can be inverted" in str(chain.rests_on())
    tied = Relation("P = K K'", P, K * K.T)
    cost = derive(Trace(P), says="held").put((P, K * M * K.T))
    held = cost.gradient(K, held=(M,))
    assert held.rests_on().held == (M,)
    assert tied not in held.rests_on().relations
