"""What is cited is followed: to the chains behind it, and to what these suppose."""

import dataclasses
from types import SimpleNamespace

import pytest
import sympy as sp
from sympy import Trace, symbols

from matrixproof import (
    Chain,
    Derivation,
    Expect,
    Identity,
    Line,
    MatrixSymbol,
    Notation,
    Relation,
    Solve,
    Stage,
    ZeroMatrix,
    prove,
)
from matrixproof.explicit import Claim, Construction
from matrixproof.lines import AtLeast, AtMost, Equation, Implies
from matrixproof.relations import Moment

n, m, p = symbols("n m p", integer=True, positive=True)
A, B, C, D, S, X, Y, Z = (MatrixSymbol(name, n, n) for name in "ABCDSXYZ")
F = MatrixSymbol("F", n, m)
I, ZERO = Identity(n), ZeroMatrix(n, n)


def rel(left, right):
    return Relation(f"{left} = {right}", left, right)


def chain(says, left, *lines, symmetric=(), number=""):
    return Chain(number, says, left, lines, symmetric)


def listed(given, *stages, symmetric=(), **more):
    letters = SimpleNamespace(symmetric=symmetric)
    return Derivation(given=given, stages=stages, letters=letters, **more)


# -- a chain that is cited -------------------------------------------------------------

FALSE = {
    "products commute": chain("products commute", A * B, Line(B * A)),
    "a factor": chain("a factor", A * B, Line(2 * A * B, why="nonsense")),
    "a wrong reason": chain("a wrong reason", A * B, Line(C, by=[rel(B * A, C)])),
    "one that is not needed": chain(
        "one that is not needed", A * B, Line(A * B, by=[rel(C, D)])
    ),
}


def citing(one, says="cites it"):
    """A chain that follows from another one's ends."""
    left, right = one.relation
    return chain(says, left * Y, Line(right * Y, by=[one]))


@pytest.mark.parametrize("false", FALSE.values(), ids=FALSE)
def test_a_chain_that_cites_a_false_one_fails_and_says_so(false):
    direct = citing(false)
    (fault,) = direct.check()[:1]
    assert false.says in fault and false.check()[0] in fault
    through = citing(direct, "cites that")
    assert direct.says in through.check()[0] and false.says in through.check()[0]
    assert "✗" in str(through)
    for one in (direct, through):
        page = Derivation(steps={"it": one})
        assert not page.proved() and page.check()


def test_a_chain_may_cite_a_true_one_and_is_checked_once(monkeypatch):
    meant = rel(C, A * B)
    true = chain("true", C * Y, Line(A * B * Y, by=[meant]))
    for one in (citing(true), citing(citing(true))):
        assert one.check() == []
    asked = []
    monkeypatch.setattr(Line, "complaints", lambda *a: asked.append(a) or [])
    assert chain("again", Z * C * Y, Line(Z * A * B * Y, by=[true])).check() == []
    assert len(asked) == 1  # its own line alone


@pytest.mark.parametrize("false", FALSE.values(), ids=FALSE)
def test_equations_constructions_and_stages_cite_no_false_chain(false):
    left, right = false.relation
    stated = Chain("", "", Equation(X, left), [Implies(Equation(X, right), by=[false])])
    made = Construction("", "", {X: left}, [rel(X, right)], by=[false])
    stage = Stage(X, right, by=(rel(X, left), false))
    for check in (
        stated.check,
        made.check,
        listed((A, B, C), stage).check,
        listed(
            (A, B, C), dataclasses.replace(stage, by=(rel(X, left), false.relation))
        ).check,
    ):
        assert any(false.says in fault for fault in check()), check


def test_a_result_is_what_its_chain_proves():
    true = chain("true", C * Y, Line(A * B * Y, by=[rel(C, A * B)]))
    other = dataclasses.replace(true.relation, right=B * A * Y)
    faults = chain("", C * Y, Line(B * A * Y, by=[other])).check()
    assert "not what its chain proves" in faults[0]
    in_z = true.relation.mapped(lambda e: e.xreplace({C: Z}))
    letters = Notation()
    for name in "ABCYZ":
        letters(name, n, n, name)
    page = ("It cites", chain("other letters", Z * Y, Line(A * B * Y, by=[in_z])))
    found = Derivation(page=page, letters=letters).check()
    assert any("cited and not introduced" in fault for fault in found)


def test_two_steps_of_one_name_are_told_apart():
    """The later one would be checked in the place of the other."""
    false, true = FALSE["products commute"], chain("products commute", A, Line(A * I))
    meant = rel(X, A * B)
    stage = Stage(X, B * A, by=(meant, false))
    letters = Notation()
    for name in "ABX":
        letters(name, n, n, name)
    page = Derivation((A, B), (stage,), page=(meant, true), letters=letters)
    assert any("two things are called" in fault for fault in page.check())
    assert not page.proved()


# -- what a chain supposes to be symmetric ---------------------------------------------

ON_SYMMETRY = {
    "at once": (
        chain("at once", A.T * B, Line(C, by=[rel(A * B, C)]), symmetric=(A,)),
        A,
    ),
    "within": (
        chain(
            "within", A * B, Line(A * C, by=[rel(B, C)]), Line(A.T * C), symmetric=[A]
        ),
        A,
    ),
    "of a cited chain": (
        chain(
            "of a cited chain",
            B * S,
            Line(
                B * C, by=[chain("of it", S, Line(C, by=[rel(S.T, C)]), symmetric=[S])]
            ),
            symmetric=[S, D],
        ),
        S,
    ),
    "seen between its ends alone": (
        chain(
            "seen between its ends alone",
            A,
            Line(S, by=[rel(A, S)]),
            Line(S.T),
            Line(B, by=[rel(S.T, B)]),
            symmetric=[S],
        ),
        S,
    ),
}


@pytest.mark.parametrize("name", ON_SYMMETRY)
def test_what_a_cited_chain_supposes_is_supposed_where_it_is_cited(name):
    one, letter = ON_SYMMETRY[name]
    assert one.check() == []
    left, right = one.relation
    bare = chain("bare", Z * left, Line(Z * right, by=[one]))
    assert f"supposes that {letter} is symmetric" in bare.check()[0]
    other = chain("other", Z * left, Line(Z * right, by=[one]), symmetric=[Y])
    assert f"supposes that {letter} is symmetric" in other.check()[0]
    twice = citing(chain("it", Z * left, Line(Z * right, by=[one]), symmetric=[letter]))
    assert f"supposes that {letter} is symmetric" in twice.check()[0]
    said = chain("said", Z * left, Line(Z * right, by=[one]), symmetric=[letter, Y])
    assert said.check() == []


def test_a_symmetry_that_a_chain_does_not_need_is_not_asked_for():
    one = chain("one", A * S, Line(C * S, by=[rel(A, C)]), symmetric=[S])
    assert chain("", Z * A * S, Line(Z * C * S, by=[one])).check() == []


# -- directions, comparisons, means ----------------------------------------------------


@pytest.mark.parametrize(
    "lines",
    [
        [AtLeast(A, root=B), AtMost(A + A * A.T, root=A)],
        [AtMost(A + B * B.T + C * C.T, root=C), AtLeast(A + C * C.T, root=B)],
        [
            AtLeast(A, root=B),
            Line(A * I),
            AtMost(A + D * D.T, root=D),
        ],
    ],
)
def test_a_chain_does_not_go_up_and_down(lines):
    with pytest.raises(ValueError, match="goes up and down"):
        Chain("", "mixed", A + B * B.T, lines)


def test_a_chain_may_go_one_way_twice():
    start = A + B * B.T + C * C.T
    lines = AtLeast(A + B * B.T, root=C), Line(B * B.T + A), AtLeast(A, root=B)
    assert Chain("", "", start, lines).check() == []
    lines = AtMost(A + B * B.T, root=B), AtMost(start, root=C)
    assert Chain("", "", A, lines).check() == []


@pytest.mark.parametrize(
    "step", [A * B == B * A, A * B == A * B, sp.Eq(sp.Integer(1), 2), sp.true]
)
def test_the_outcome_of_a_comparison_is_no_step(step):
    with pytest.raises(TypeError, match=r"step 'it' is .*Claim\(left, right"):
        Derivation(steps={"it": step})


def test_a_residual_and_a_claim_are_steps():
    steps = {"residual": sp.Integer(0), "claim": Claim(sp.eye(2), sp.eye(2))}
    assert Derivation(steps=steps).proved()
    assert not Derivation(steps={"residual": sp.Integer(1)}).proved()


@pytest.mark.parametrize("kind", [Line, AtLeast])
def test_a_mean_is_not_cited_as_an_equation(kind):
    w = MatrixSymbol("w", n, 1)
    mean = Moment("E[w w'] = S", w * w.T, S)
    with pytest.raises(TypeError, match=r"E\[w w'\] = S is a mean"):
        kind(S, by=[mean])
    with pytest.raises(TypeError, match="is a mean"):
        Stage(S, w * w.T, by=(mean,)).complaints()
    assert Chain("", "", w * w.T, [Expect(S, moments=[mean])]).check() == []


# -- stages ----------------------------------------------------------------------------


@pytest.mark.parametrize(
    "steps",
    [
        {},
        {"1 = 1": Claim(sp.eye(1), sp.eye(1))},
        {"zero": sp.Integer(0)},
        {"a chain": chain("a chain", A * (B + C), Line(A * B + A * C))},
    ],
)
def test_every_stage_needs_a_reason(steps):
    bare = listed((A, B), Stage(X, A - B), steps=steps)
    assert bare.check() == ["nothing proves X = A - B"] and not bare.proved()
    half = listed((A, B), Stage(X, A - B, by=(rel(X, A - B),)), Stage(Y, A + B))
    assert half.check() == ["nothing proves Y = A + B"]
    assert listed((A, B), Stage(X, A - B, by=(rel(X, A - B),)), steps=steps).proved()


def defined(target, formula, **more):
    stage = Stage(target, formula, **more)
    meant = rel(target, stage.expression)
    return dataclasses.replace(stage, by=(meant, *stage.by))


NOT_SYMMETRIC = {
    "a product": ((A, B), (), [defined(X, A * B, symmetric=True)]),
    "of symmetric factors": ((A, B), (A, B), [defined(X, A * B, symmetric=True)]),
    "the target's letter says so": (
        (A, B),
        (X,),
        [defined(X, A * B, symmetric=True)],
    ),
    "an earlier target's letter says so": (
        (A, B),
        (X, Y),
        [defined(X, A * B), defined(Y, X + B * B.T, symmetric=True)],
    ),
    "a skew part": ((A, S), (S,), [defined(X, S + A - A.T, symmetric=True)]),
    "by one side": ((A, S), (S,), [defined(X, A * S * A, symmetric=True)]),
    "as the definition turned": (
        (A, B),
        (X,),
        [Stage(X, B.T * A.T, symmetric=True, by=(rel(X, A * B),))],
    ),
}


@pytest.mark.parametrize("name", NOT_SYMMETRIC)
def test_a_stage_is_not_symmetric_because_it_says_so(name):
    given, symmetric, stages = NOT_SYMMETRIC[name]
    found = listed(given, *stages, symmetric=symmetric)
    assert any("nothing shows that it is" in fault for fault in found.check())
    assert not found.proved()


N, M, K, R = MatrixSymbol("N", n, p), *(MatrixSymbol(x, p, p) for x in "MKR")
H, G = MatrixSymbol("H", p, n), MatrixSymbol("G", n, p)
SHOWN = {
    "a square": ((A,), (), [defined(X, A * A.T, symmetric=True)]),
    "a sandwich": ((A, S), (S,), [defined(X, A * S * A.T + S, symmetric=True)]),
    "by an earlier stage": (
        (H, S, R),
        (S, R),
        [defined(N, S * H.T), defined(M, H * N + R, symmetric=True)],
    ),
    "by a solve": (
        (H, S, R),
        (S, R),
        [
            defined(M, H * S * H.T + R, symmetric=True),
            defined(G, Solve(S * H.T, M)),
            defined(X, S - G * H * S, symmetric=True),
        ],
    ),
    "by a reason": (
        (G, N, S),
        (S, M),
        [defined(X, S - G * N.T, symmetric=True, by=(rel(G * M, N),))],
    ),
}


@pytest.mark.parametrize("name", SHOWN)
def test_a_stage_is_symmetric_by_letters_stages_and_reasons(name):
    given, symmetric, stages = SHOWN[name]
    assert listed(given, *stages, symmetric=symmetric).check() == []


def test_a_reason_for_symmetry_is_needed_too():
    (stage,) = SHOWN["by a reason"][2]
    bare = dataclasses.replace(stage, by=stage.by[:1])
    assert "nothing shows" in listed((G, N, S), bare, symmetric=(S, M)).check()[0]
    idle = dataclasses.replace(stage, by=(*stage.by, rel(A * B, C)))
    (fault,) = listed((G, N, S), idle, symmetric=(S, M)).check()
    assert fault.endswith("does not need A B = C")


UNEVEN = {
    "any matrix": ((A, B), (), [defined(X, Solve(B, A))]),
    "as its equation": ((A, B), (), [Stage(X, Solve(B, A), by=(rel(X * A, B),))]),
    "a sum": ((A, B, S), (S,), [defined(X, Solve(B, S + A))]),
    "an earlier stage": (
        (A, B, S),
        (S,),
        [defined(Y, S * A * S), defined(X, Solve(B, Y))],
    ),
    "whose letter says so": (
        (A, B, S),
        (S, Y),
        [defined(Y, S * A * S), defined(X, Solve(B, Y))],
    ),
}


@pytest.mark.parametrize("name", UNEVEN)
def test_a_solve_takes_a_symmetric_matrix(name):
    given, symmetric, stages = UNEVEN[name]
    found = listed(given, *stages, symmetric=symmetric)
    assert any("by one triangle of it" in fault for fault in found.check())
    assert not found.proved()


@pytest.mark.parametrize("over", [S, S + A * A.T, A.T * S * A], ids=str)
def test_a_solve_with_what_is_symmetric(over):
    assert listed((A, B, S), defined(X, Solve(B, over)), symmetric=(S,)).check() == []
    turned = defined(Y, over), defined(X, Solve(B, Y))
    assert listed((A, B, S), *turned, symmetric=(S,)).check() == []


@pytest.mark.parametrize(
    ("stages", "fault"),
    [
        ([defined(X, X + A)], "X = X + A reads X"),
        ([defined(X, Y + A), defined(Y, X + A)], "X = Y + A reads Y"),
        ([defined(X, 2 * A), defined(X, 3 * A)], "X is there before"),
        ([defined(A, 2 * B)], "A is there before"),
        ([defined(X, A + C)], "X = A + C reads C"),
    ],
)
def test_stages_are_in_order_and_assign_once(stages, fault):
    found = listed((A, B), *stages)
    assert any(fault in said for said in found.check()), found.check()
    assert not found.proved()


# -- constructions ---------------------------------------------------------------------

a, b, c = (MatrixSymbol(x, 1, 2) for x in "abc")
u = MatrixSymbol("u", 2, 1)
V, W = MatrixSymbol("V", m, n), MatrixSymbol("W", n, m)
solves = rel(F * V, A)
EMPTY = {
    "of itself": ({X: X}, [rel(A * X, B)], [rel(A * X, B)], ()),
    "by what is asked": ({X: Y}, [rel(A * X, B)], [rel(A * X, B), rel(X, Y)], ()),
    "of each other": (
        {X: Y, Y: X},
        [rel(A * X, B), rel(A * Y, B)],
        [rel(A * X, B), rel(A * Y, B)],
        (),
    ),
    "of another that is made": ({X: Y, Y: A}, [rel(X, A), rel(Y, A)], [], ()),
    "the inverse of a nilpotent matrix": (
        {X: A.I},
        [rel(A * X, I), rel(A * A * X, ZERO)],
        [rel(A * A, ZERO)],
        (),
    ),
    "the inverse of what has a kernel": (
        {X: (A * B).I * A},
        [rel(X * B, I)],
        [rel(A * B * A, ZERO)],
        (),
    ),
    "the inverse of a number and a column": (
        {a: u.T * (u * u.T).I},
        [rel(u * a, Identity(2))],
        [],
        (),
    ),
    "the inverse of zero": ({X: (A - B).I}, [rel((A - B) * X, I)], [rel(A, B)], ()),
    "a symmetric quotient": ({X: C * B.I}, [rel(X * B, C)], [], (X,)),
    "a symmetric product": ({X: A * B}, [rel(X, A * B)], [], (X, A, B)),
    "a symmetric letter": ({X: A}, [rel(X + B, A + B)], [], (X,)),
    "of another size": ({X: Identity(m)}, [rel(X * X, X)], [], ()),
    "a row for a column": ({W: V}, [rel(W * V, W * V)], [], ()),
    "a number for a matrix": ({X: Identity(1)}, [rel(X * X, X)], [], ()),
    "of which nothing is asked": ({X: A}, [rel(A * B, C)], [rel(A * B, C)], ()),
}


@pytest.mark.parametrize("name", EMPTY)
def test_what_is_not_constructed(name):
    values, satisfies, by, symmetric = EMPTY[name]
    assert Construction("", name, values, satisfies, by, symmetric).check()


BUILT = {
    "an inverse": ({X: A.I}, [rel(A * X, I), rel(X * A, I)], [], ()),
    "two at once": ({X: A, Y: B}, [rel(X * Y, A * B)], [], ()),
    "a symmetric square": ({X: A * A.T}, [rel(X, A * A.T)], [], (X,)),
    "by a reason symmetric": (
        {X: A},
        [rel(X, A)],
        [rel(A, A.T)],
        (X,),
    ),
    "a right inverse": (
        {W: V.T * (V * V.T).I},
        [rel(V * W, Identity(m))],
        [],
        (),
    ),
}


@pytest.mark.parametrize("name", BUILT)
def test_what_is_constructed(name):
    values, satisfies, by, symmetric = BUILT[name]
    assert Construction("", name, values, satisfies, by, symmetric).check() == []


# -- certificates ----------------------------------------------------------------------


def with_lemmas():
    """Two lemmas, p q = I, of which each turns the other."""
    proof = prove(B * A, I, [(A * B, I)])
    assert proof.check() and len(proof.statement.lemmas) == 1
    ((name, (one, two, number)),) = proof.statement.lemmas.items()
    return proof, name, one, two, number


def forged(proof, lemmas, certificates):
    statement = dataclasses.replace(proof.statement, lemmas=lemmas)
    more = proof.certificates | certificates
    return dataclasses.replace(proof, statement=statement, certificates=more)


def exchanged(name):
    return ((1, (), ("exchanged", name, False), ()),)


def test_a_lemma_does_not_rest_on_itself():
    proof, name, one, two, number = with_lemmas()
    square = {name: (one, one, number)}  # A A = I: the other way round, it is the same
    fake = forged(proof, square, {name: exchanged(name)})
    assert any("rests on itself" in fault for fault in fake.complaints())
    assert not fake.check()


def test_lemmas_do_not_rest_on_each_other():
    proof, name, one, two, number = with_lemmas()
    both = {name: (one, two, number), "turned": (two, one, number)}
    loop = {name: exchanged("turned"), "turned": exchanged(name)}
    fake = forged(proof, both, loop)
    assert any("rests on itself" in fault for fault in fake.complaints())
    assert not fake.check()


def test_a_lemma_may_rest_on_an_earlier_one():
    proof, name, one, two, number = with_lemmas()
    both = {name: (one, two, number), "turned": (two, one, number)}
    true = forged(proof, both, {"turned": exchanged(name)})
    assert true.check()
    early = dict(reversed(both.items()))
    assert not forged(proof, early, {"turned": exchanged(name)}).check()


def test_traces_follow_what_they_cite():
    false = FALSE["products commute"]
    one = chain("a trace", Trace(A * B * C), Line(Trace(B * A * C), by=[false]))
    assert "products commute" in one.check()[0]
