"""Chains are checked line by line, show what was checked, and refuse decoration."""

import dataclasses
import re

import pytest
import sympy as sp
from pages import GAIN, PROJECTION
from sympy import Matrix, Trace

from luenberger.papers.leondes_novak import derivation as recursions
from matrixproof import (
    BlockMatrix,
    Chain,
    Expect,
    Identity,
    Line,
    MatrixSymbol,
    Notation,
    Relation,
    Stage,
    ZeroMatrix,
)
from matrixproof.explicit import Construction, Counterexample
from matrixproof.lines import AtLeast, AtMost, Equation, Iff, Implies
from matrixproof.operators import Differential, Gradient, Transposed

n, p = sp.symbols("n p", integer=True, positive=True)
A, B, M, Q, X, Y = (MatrixSymbol(name, n, n) for name in "ABMQXY")
I, ZERO = Identity(n), ZeroMatrix(n, n)
CHAINS = {f"({chain.number})": chain for chain in (*GAIN, *PROJECTION)}
CITED = [
    (name, k, j)
    for name, chain in CHAINS.items()
    for k, line in enumerate(chain.lines)
    for j in range(len(line.by))
]


def with_line(chain, k, line):
    lines = [line if i == k else old for i, old in enumerate(chain.lines)]
    return dataclasses.replace(chain, lines=lines)


# -- the pages -------------------------------------------------------------------------


@pytest.mark.parametrize("name", CHAINS)
def test_every_line_follows_and_needs_its_reasons(name):
    assert CHAINS[name].check() == []


@pytest.mark.parametrize(("name", "k", "j"), CITED)
def test_a_line_fails_without_one_of_its_reasons(name, k, j):
    chain = CHAINS[name]
    line = chain.lines[k]
    by = line.by[:j] + line.by[j + 1 :]
    damaged = with_line(chain, k, dataclasses.replace(line, by=by))
    (fault,) = damaged.check()
    assert fault.startswith(f"line {k + 1} does not follow")
    assert "what is left over is" in fault
    assert "the sides are" in fault


@pytest.mark.parametrize("name", CHAINS)
def test_a_spare_reason_is_refused(name):
    chain = CHAINS[name]
    spare = Relation("spare", X * Y, Y)
    line = chain.lines[-1]
    damaged = with_line(chain, len(chain.lines) - 1, cited(line, spare))
    assert damaged.check() == [f"line {len(chain.lines)} does not need spare"]


def cited(line, *more):
    return dataclasses.replace(line, by=(*line.by, *more))


@pytest.mark.parametrize("name", CHAINS)
def test_a_wrong_sign_is_noticed(name):
    chain = CHAINS[name]
    last = chain.lines[-1]
    wrong = dataclasses.replace(last, right=-last.right)
    (fault,) = with_line(chain, len(chain.lines) - 1, wrong).check()
    assert "does not follow" in fault


def test_chains_cite_what_they_use():
    assert [r.name for r in GAIN[0].relations] == ["M = C Ω C' + R", "N", "K_mv M = N"]


def test_a_chain_proves_that_its_ends_are_equal():
    meant = Relation("M = A + B", M, A + B)
    chain = Chain("3", "", A * M, [Line(A * (A + B), by=[meant]), Line(A * A + A * B)])
    found = chain.relation
    assert (found.left, found.right) == (A * M, A * A + A * B)
    assert found.name == "(3) A M = A A + A B"
    assert Line(A * A * A + A * B * A, by=[found]).complaints(A * M * A, ()) == []


# -- kinds of line ---------------------------------------------------------------------

SQUARE = Relation("M = B B'", M, B * B.T)
e, w = MatrixSymbol("e", n, 1), MatrixSymbol("w", n, 1)
WHITE = [(e * e.T, X), (w * w.T, Q), (e * w.T, ZERO)]
dX = MatrixSymbol("dX", n, n)
Z, W = MatrixSymbol("Z", 2 * n, 2 * n), MatrixSymbol("W", 2 * n, 2 * n)
BLOCKS = Relation("Z", Z, BlockMatrix([[A, B], [B.T, X]]))
TWICE = Relation("W = Z Z", W, Z * Z)
ROW = Relation("H", MatrixSymbol("H", n, 2 * n), BlockMatrix([[A, B]]))
COLUMN = Relation("V", MatrixSymbol("V", 2 * n, n), BlockMatrix([[X], [M]]))
OPENED = [[A * A + M, A * B + B * X], [B.T * A + X * B.T, B.T * B + X * X]]
r, t = sp.symbols("r t", positive=True)
KINDS = {
    "cyclic": (Trace(A * B), Line(Trace(B * A))),
    "substitute": (A * M, Line(A * B * B.T, by=[SQUARE])),
    "recognise": (A * B * B.T, Line(A * M, by=[SQUARE])),
    "blocks put in": (W, Line(BlockMatrix(OPENED), by=[TWICE, BLOCKS, SQUARE])),
    "blocks in a relation": (
        A * X + B * M,
        Line(Y, by=[ROW, COLUMN, Relation("H V = Y", ROW.left * COLUMN.left, Y)]),
    ),
    "blocks recognised": (BlockMatrix(OPENED), Line(W, by=[SQUARE, BLOCKS, TWICE])),
    "at least": (X + A * M * A.T, AtLeast(X, by=[SQUARE], root=A * B)),
    "at least, trace": (Trace(X + A * A.T), AtLeast(Trace(X), root=A)),
    "at most": (X, AtMost(X + A * A.T, root=A)),
    "transposed": (A * B, Transposed(B.T * A.T)),
    "gradient": (Trace(X * M * X.T), Gradient(2 * X * M, of=X)),
    "gradient in a number": (r / t + t**2, Gradient(2 * t - r / t**2, of=t)),
    "differential": (X * X, Differential(X * dX + dX * X, of={X: dX})),
    "expect": (
        (A * e + w) * (A * e + w).T,
        Expect(A * X * A.T + Q, moments=WHITE),
    ),
    "expect, scalar": (Trace(B * e * e.T), Expect(Trace(B * X), moments=WHITE[:1])),
    "expect, form": (Trace(e.T * B * e), Expect(Trace(B * X), moments=WHITE[:1])),
    "implies": (Equation(A, B), Implies(Equation(A * X, B * X))),
    "iff": (Equation(A * X, B), Iff(Equation(A, B * X.I))),
}


def test_numbers_may_be_inverted_and_have_roots():
    """What is tried is positive where the letter is, and no denominator is zero."""
    left = r * t + 1 / (r - t)
    assert Chain("", "", left, [Line(left * 1)]).check() == []
    right = r * (t - 1 / sp.sqrt(r)) * (t + 1 / sp.sqrt(r))
    assert Chain("", "", r * t**2 - 1, [Line(right)]).check() == []
    (fault,) = Chain("", "", r * t**2 - 1, [Line(right + 1 / (r - t))]).check()
    assert (
        "left over" in fault and "-" not in fault.partition("; with")[2].split(",")[0]
    )
    for wrong in (right + 1, right + sp.sqrt(r) / t, 1 / t - sp.sqrt(r)):
        (fault,) = Chain("", "", r * t**2 - 1, [Line(wrong)]).check()
        assert "does not follow" in fault and "the sides are" in fault


@pytest.mark.parametrize("name", KINDS)
def test_kind_of_line_is_checked(name):
    left, line = KINDS[name]
    assert (
        Chain("1", name, left, [line], (M, Q, X)[: 2 + ("expect" in name)]).check()
        == []
    )


WRONG = {
    "cyclic": (Trace(A * B * X), Line(Trace(A * X * B)), "does not follow"),
    "substitute and more": (
        A * M,
        Line(B * B.T * A, by=[SQUARE]),
        "does not follow",
    ),
    "blocks, another": (Z, Line(BLOCKS.right.T, by=[BLOCKS]), "does not follow"),
    "blocks, a relation that is not cited": (
        W,
        Line(BlockMatrix(OPENED), by=[TWICE, BLOCKS]),
        "does not follow",
    ),
    "blocks, a relation that is idle": (
        Z,
        Line(BLOCKS.right, by=[BLOCKS, SQUARE]),
        "does not need M = B B'",
    ),
    "blocks that are idle": (
        A * M,
        Line(A * B * B.T, by=[SQUARE, BLOCKS]),
        "does not need Z",
    ),
    "at least, wrong way": (X, AtLeast(X + A * A.T, root=A), "does not follow"),
    "at most, wrong root": (X, AtMost(X + A * A.T, root=A.T), "does not follow"),
    "transposed": (A * B, Transposed(A.T * B.T), "does not follow"),
    "gradient": (Trace(X * M * X.T), Gradient(X * M, of=X), "does not follow"),
    "gradient of a matrix": (X, Gradient(I, of=X), "cannot be worked out"),
    "gradient in a number": (
        r / t + t**2,
        Gradient(2 * t + r / t**2, of=t),
        "does not follow",
    ),
    "gradient of a matrix in a number": (
        ZERO,
        Gradient(ZERO, of=t),
        "only a scalar has a gradient",
    ),
    "gradient of traces in a number": (
        t * Trace(X),
        Gradient(Trace(X), of=t),
        "in a matrix only",
    ),
    "differential": (X * X, Differential(2 * X * dX, of={X: dX}), "does not follow"),
    "expect, moment missing": (
        (A * e + w) * (A * e + w).T,
        Expect(A * X * A.T + Q, moments=WHITE[:2]),
        "E[e w'] is not among the moments",
    ),
    "expect, moment idle": (
        A * e * e.T,
        Expect(A * X, moments=WHITE[:2]),
        "does not need E[w w'] = Q",
    ),
    "expect, still random": (
        A * e * e.T,
        Expect(A * e * e.T, moments=WHITE[:1]),
        "still has a random symbol",
    ),
    "expect, fourth degree": (
        e * e.T * A * e * e.T,
        Expect(X * A * X, moments=WHITE[:1]),
        "not of second degree",
    ),
    "implies, not so": (
        Equation(A * X, B * X),
        Implies(Equation(A, B)),
        "does not foll",
    ),
    "implies, idle": (Equation(A, B), Implies(Equation(X, X)), "the line before"),
    "iff, one way only": (
        Equation(A, B),
        Iff(Equation(A * X, B * X)),
        "this line, back",
    ),
    "reasons that no finite matrices satisfy": (
        A * B,
        Line(B * A + I, by=[(A * B, B * A + I)]),
        "no matrices were found that satisfy what is cited",
    ),
    "contradictory reasons": (
        A,
        Line(0 * A, by=[(X, ZERO), (X * Y, I)]),
        "no matrices satisfy them",
    ),
}


@pytest.mark.parametrize("name", WRONG)
def test_wrong_line_is_refused(name):
    left, line, words = WRONG[name]
    faults = Chain("1", name, left, [line], (M, Q)).check()
    assert faults
    assert words in faults[0]


def test_a_counterexample_is_shown_to_the_reader():
    (fault,) = Chain("", "", (A + B).I, [Line(A.I + B.I)]).check()
    assert re.search(r"with A = \S+, B = \S+, the sides are \S+ and \S+$", fault)


def test_a_line_that_needs_a_letter_is_refused():
    long = A * B * X * Y * M * Q * A * B * X * Y * M * Q * A * B * X * Y * M * Q * A * B
    chain = Chain("1", "long", (long + X) * long, [Line(long * long + X * long)])
    (fault,) = chain.check()
    assert re.fullmatch(
        r"line 1 is \d+ characters wide; 110 fit, so .* a letter", fault
    )


def test_a_chain_of_equations_takes_no_equivalences():
    with pytest.raises(TypeError, match="line 1 of chain .* is a Implies"):
        Chain("1", "", A, [Implies(Equation(A, B))])
    with pytest.raises(TypeError, match="goes on with Implies or Iff"):
        Chain("1", "", Equation(A, B), [Line(A)])


def test_a_chain_never_changes():
    with pytest.raises(dataclasses.FrozenInstanceError):
        GAIN[0].number = "1"


# -- constructions and counterexamples -------------------------------------------------

C, G = MatrixSymbol("C", p, n), MatrixSymbol("G", n, p)
RIGHT_INVERSE = Relation("C G = I", C * G, Identity(p))


def construction(value, by):
    return Construction(
        "24",
        "a gain that meets the condition",
        {MatrixSymbol("K", n, p): value},
        satisfies=[Relation("C K = I", C * MatrixSymbol("K", n, p), Identity(p))],
        by=by,
    )


def test_a_construction_is_checked():
    assert construction(G, [RIGHT_INVERSE]).check() == []
    (fault,) = construction(2 * G, [RIGHT_INVERSE]).check()
    assert fault.startswith("C K = I is not satisfied: what is left over is I")
    spare = Relation("spare", A * B, B)
    assert construction(G, [RIGHT_INVERSE, spare]).check() == ["does not need spare"]
    endless = Relation("no finite matrices", A * B, B * A + I)
    faults = Construction(
        "", "", {X: A * B - B * A}, [Relation("X = I", X, I)], [endless]
    ).check()
    (fault,) = faults
    assert fault.startswith("no matrices were found that satisfy what is cited")


def test_a_construction_that_fails_is_marked():
    right, wrong = (construction(k * G, [RIGHT_INVERSE]) for k in (1, 2))
    assert "✓" in str(right) and "✗" not in str(right)
    assert "✗" in str(wrong) and "✓" not in str(wrong)
    assert r"\times" in wrong._repr_latex_()


def counterexample(a, b, given=()):
    values = {A: Matrix(a), B: Matrix(b)}
    return Counterexample("7", "a false claim", A * B, B * A, values, given, [A])


def test_a_counterexample_is_checked():
    a, b = [[1, 0], [0, 2]], [[0, 1], [0, 0]]
    assert counterexample(a, b).check() == []
    assert counterexample(a, [[1, 0], [0, 1]]).check() == ["the sides are equal"]
    idempotent = Relation("A A = A", A * A, A)
    assert counterexample(a, b, [idempotent]).check() == ["does not satisfy A A = A"]
    assert counterexample([[1, 1], [0, 2]], b).check() == ["A is not symmetric"]


# -- shown -----------------------------------------------------------------------------


def test_a_page_in_a_terminal():
    assert str(PROJECTION[1]).splitlines() == [
        "(3.6) τ is a projection",
        "  τ τ",
        "    = G' Γ G' Γ  (3.8) τ = G' Γ  ✓",
        "    = G' Γ       Γ G' = I        ✓",
        "    = τ          (3.8) τ = G' Γ  ✓",
    ]


def test_a_page_in_a_notebook():
    assert PROJECTION[0]._repr_latex_() == (
        r"$$\begin{aligned} \Gamma G' &= \Gamma \hat Q \Gamma' Q_{2}^{-1} && "
        r"\text{(4.13)}\; G' Q_{2} = \hat Q \Gamma' && \checkmark \\[2pt] "
        r"&= I && \text{(4.14)}\; \Gamma \hat Q \Gamma' = Q_{2} && \checkmark "
        r"\end{aligned} \tag{3.9}$$"
    )


@pytest.mark.parametrize("name", KINDS)
def test_kind_of_line_is_shown(name):
    left, line = KINDS[name]
    chain = Chain("1", name, left, [line], (M, Q))
    assert f" {line.sign} " in str(chain)
    latex = chain._repr_latex_()
    assert line.latex_sign in latex
    assert latex.count("{") == latex.count("}")
    assert not re.search(r"\^\{?(T|\\top)", latex)


def test_a_failing_line_is_marked():
    chain = Chain("1", "wrong", A * B, [Line(B * A)])
    assert "✗" in str(chain) and "line 1 does not follow" in str(chain)
    assert (
        r"\times" in chain._repr_latex_() and r"\checkmark" not in chain._repr_latex_()
    )


def test_operators_are_shown_before_the_sign():
    expect = Chain("1", "", *[KINDS["expect"][0]], [KINDS["expect"][1]])
    assert "    E[·] = A X A' + Q" in str(expect)
    assert "E[e e'] = X, E[w w'] = Q, E[e w'] = 0" in str(expect)
    gradient = Chain("1", "", Trace(X * M), [Gradient(M.T, of=X)])
    assert r"\frac{\partial}{\partial X}[\,\cdot\,] &= M'" in gradient._repr_latex_()


def test_a_derivation_is_shown_as_its_stages():
    shown = str(recursions.gain_step()).splitlines()
    assert shown[0].startswith("from one error covariance to the next")
    assert "  K_mv = Ω C' M⁻¹          (33)" in shown
    assert len(shown) == 7
    latex = recursions.gain_step()._repr_latex_()
    assert r"K_{\mathrm{mv}} &= \Omega C' M^{-1} && \text{(33)}" in latex


def test_a_stage_is_shown():
    stage = recursions.estimate_step().stages[0]
    assert str(stage) == "x₋ = A x + B u + J ρ  (43)"
    assert stage._repr_latex_() == (
        r"$\displaystyle x_{-} = A x + B u + J \rho \qquad \text{(43)}$"
    )


def test_a_stage_of_blocks_puts_its_definition_in():
    """A letter for blocks has no blocks of its own until they are put in."""
    whole = MatrixSymbol("W", n + p, n + p)
    C = MatrixSymbol("C", p, n)
    blocks = BlockMatrix([[A, C.T], [C, Identity(p)]])
    turned = BlockMatrix([[A, -C.T], [C, Identity(p)]])
    meant = Relation("W", whole, blocks)
    assert Stage(whole, blocks, by=(meant,)).complaints() == []
    assert "does not follow" in Stage(whole, turned, by=(meant,)).complaints()[0]


def test_a_letter_may_stand_for_something_else_on_one_page():
    letters = Notation()
    Z = letters("Z", n, n, "of the paper", symmetric=True)
    page = letters.here()
    other = page("Z", n, p, "of the page")
    assert page.meaning == {other: "of the page"} and page.symmetric == ()
    assert letters.meaning == {Z: "of the paper"} and letters.symmetric == (Z,)
    for notation in (letters, page):
        with pytest.raises(ValueError, match="the letter Z is taken"):
            notation("Z", p, p, "twice")


def test_every_stage_needs_a_reason_where_one_has_it():
    first, *others = recursions.gain_step().stages
    bare = dataclasses.replace(first, by=())
    found = dataclasses.replace(recursions.gain_step(), stages=(bare, *others))
    assert found.check() == ["nothing proves Ω = A Σ A' + Q"]
    assert not found.proved()
