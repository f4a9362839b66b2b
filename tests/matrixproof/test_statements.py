"""A page, statement by statement: what each may say where it stands."""

import random

import pytest
import sympy as sp

from luenberger.papers.leondes_novak.derivation import quadratic, square_root
from matrixproof import (
    Derivation,
    Identity,
    Line,
    Notation,
    Page,
    Relation,
    Stage,
    ZeroMatrix,
)
from matrixproof.derivation import End
from matrixproof.induction import Induced

n, p = sp.symbols("n p", integer=True, positive=True)
letters = Notation()
A, B, K, X, Y, Z = (letters(name, n, n, f"the matrix {name}") for name in "ABKXYZ")
t = letters.scalar("t", "a number")
let, suppose, steady = letters.let, letters.suppose, letters.steady
moment = letters.moment
e = letters("e", n, 1, "a column")
I, zero = Identity(n), ZeroMatrix(n, n)


def new():
    return Page(letters=letters)


def refused(page, statement, says):
    """The statement is refused, and nothing of it is on the page."""
    before = page.page
    with pytest.raises(ValueError, match=says):
        page(statement)
    assert page.page is before


# -- what is defined, supposed, and steady --------------------------------------------


def test_a_page_writes_what_it_makes():
    page = new()
    said = page.let(X, A * B), page.suppose(A * Y, Y, "3"), page.steady(Z, A * Z)
    said += (page.moment(e * e.T, K, "4"),)
    made = let(X, A * B), suppose(A * Y, Y, "3"), steady(Z, A * Z)
    made += (moment(e * e.T, K, "4"),)
    assert page.page == said == made
    assert list(map(type, said)) == list(map(type, made))
    with pytest.raises(ValueError, match="write suppose"):
        page.let(X, B)
    assert page.page == said


@pytest.mark.parametrize(
    ("make", "says"),
    [
        (lambda: let(A * X, B), "A X is none: write suppose"),
        (lambda: let(X.T, B), "X' is none: write suppose"),
        (lambda: let(X, A * X), "in which it occurs: write steady"),
        (lambda: let(t, 2 * t), "in which it occurs"),
        (lambda: steady(X, A * B), "no fixed point: write let"),
    ],
)
def test_words_that_do_not_fit_are_refused(make, says):
    with pytest.raises(ValueError, match=says):
        make()


def test_each_kind_looks_different():
    page = new()
    page(let(X, A * B, "3"), suppose(A * Y, B), steady(Z, A * Z * A.T + B))
    page(moment(e * e.T, K))
    text = str(page)
    assert "  Let X = A B  (3)" in text
    assert "  Suppose A Y = B" in text
    assert "  Steady: Z = A Z A' + B" in text
    assert "  E[e e'] = K" in text
    markdown = page._repr_markdown_()
    for word in ("Let", "Suppose", "Steady:"):
        assert markdown.count(rf"\text{{{word} }}") == 1
    assert str(let(X, A * B, "3")) == "Let (3) X = A B"
    assert str(suppose(A, B, name="both")) == "Suppose both: A = B"
    assert r"\text{Let }X" in let(X, A)._repr_latex_()


def test_a_definition_in_other_letters():
    """It stays one of a letter, and is a hypothesis of anything else."""
    is_X = let(X, A * B, "3")
    renamed = is_X.mapped(lambda e: e.subs(X, Y))
    assert str(renamed) == "Let (3) Y = A B"
    product = is_X.mapped(lambda e: e.subs(X, K * Y))
    assert str(product) == "Suppose (3) K Y = A B"


def test_a_statement_returns_what_it_is_given():
    page = new()
    is_X = let(X, A * B)
    assert page(is_X) is is_X
    assert page("words") == "words"
    both = suppose(A, B), suppose(B, I)
    assert page(*both) == both
    chain = page.chain("", "it is seen", X, Line(A * B, by=(is_X,)))
    assert page.page == (is_X, "words", *both, chain)
    assert page.steps["it is seen"] is chain


def test_what_is_checked_is_the_page_as_it_is():
    """A page that was checked may be continued."""
    page = new()
    is_X = page(let(X, A * B))
    assert page.check() == ["nothing uses X = A B"]
    page.chain("", "it is seen", X, Line(A * B, by=(is_X,)))
    assert page.check() == []
    page.chain("", "it is not", X, Line(B * A, by=(is_X,)))
    assert page.check()[0].startswith("it is not: line 1")


DEFINED = {
    "twice": ([let(X, A)], "X = A says what X is; write suppose"),
    "of what is supposed": ([suppose(X, A)], "X = A is said of X before"),
    "of what a hypothesis has in it": ([suppose(A * X, B)], "A X = B is said of X"),
    "on the right of one": ([suppose(A * A, X)], "A A = X is said of X before"),
    "of a mean": ([moment(e * e.T, X)], "is said of X before"),
    "of a fixed point": ([steady(X, A * X)], "is said of X before"),
    "in a circle": ([let(B, A * X)], "X is part of what it stands for"),
    "in a long circle": ([let(Y, X), let(Z, A * Y), let(B, Z)], "X is part of"),
}


@pytest.mark.parametrize("case", DEFINED)
def test_a_letter_is_defined_once_and_first(case):
    said, says = DEFINED[case]
    page = new()
    page(*said)
    refused(page, let(X, B), says)
    page(suppose(X, B))  # which says nothing of being new
    found = Derivation(page=(*said, let(X, B)), letters=letters).check()
    assert any(says in fault for fault in found)


def test_a_letter_may_be_used_before_it_is_defined():
    """By a definition or a chain, which hold whatever it is."""
    page = new()
    is_Y = page(let(Y, A * X))
    page.chain("", "a product", Y * B, Line(A * X * B, by=(is_Y,)))
    is_X = page(let(X, B))
    page.chain("", "a square", Y, Line(A * B, by=(is_Y, is_X)))
    assert page.check() == []


# -- scopes ---------------------------------------------------------------------------


def in_a_scope():
    page = new()
    is_X = page(let(X, A * B))
    with page.scope(suppose(A * B, I)) as inverse:
        one = page.chain("", "one", X, Line(A * B, by=(is_X,)), Line(I, by=(inverse,)))
        other = page.chain("", "other", X.T, Line(B.T * A.T, by=(is_X,)))
    return page, inverse, one, other


def test_what_is_supposed_ends_with_its_scope():
    page, inverse, one, other = in_a_scope()
    assert page.check() == []
    refused(page, letters.chain("", "late", A * B, Line(I, by=(inverse,))), "has ended")
    refused(page, letters.chain("", "late", X, Line(I, by=(one,))), "late: rests on A")
    again = letters.chain("", "again", X * X, Line(X, by=(one,)))
    refused(page, letters.chain("", "far", X * X, Line(X, by=(again,))), "has ended")
    stage = Stage(X, I, by=(one,))
    refused(page, Derivation((A,), (stage,), says="a list"), "a list: rests on A B = I")
    page.chain("", "free", X.T, Line(B.T * A.T, by=(other,)))  # needs no hypothesis
    assert page.check() == []
    assert str(page).count("What follows does not rest on A B = I.") == 1
    assert "What follows does not rest on $A B = I$." in page._repr_markdown_()


def test_a_derivation_of_items_is_held_to_the_same():
    page, inverse, _, _ = in_a_scope()
    late = letters.chain("", "late", A * B, Line(I, by=(inverse,)))
    found = Derivation(page=(*page.page, late), letters=letters).check()
    assert found == ["late: rests on A B = I, whose scope has ended"]
    open_page = tuple(x for x in page.page if not isinstance(x, End))
    assert Derivation(page=(*open_page, late), letters=letters).check() == []


def test_a_letter_stands_for_something_else_in_another_scope():
    page = new()
    for value in (A, B):
        with page.scope(let(X, value)) as is_X:
            name = f"its square is {value}'s"
            page.chain("", name, X * X, Line(value * value, by=(is_X,)))
    assert page.check() == []
    page(let(X, I))
    refused(page, let(X, A), "X = I says what X is")


def test_scopes_stand_in_scopes():
    page = new()
    with page.scope(suppose(A, I)) as outer:
        with page.scope(suppose(B, I)) as inner:
            page.chain("", "both", A * B, Line(I, by=(outer, inner)))
        refused(page, letters.chain("", "b", B, Line(I, by=(inner,))), "B = I, whose")
        page.chain("", "a", A, Line(I, by=(outer,)))
    refused(page, letters.chain("", "a'", A.T, Line(I, by=(outer,))), "A = I, whose")
    page(outer)  # said again, for all that follows
    page.chain("", "a again", A.T, Line(I, by=(outer,)))
    assert page.check() == []


def test_what_a_scope_says_again_holds_after_it():
    """A scope ends where its own first words stand, not where these stood before."""
    page = new()
    is_A = page(suppose(A, I))
    page.chain("", "before", A * B, Line(B, by=(is_A,)))
    with page.scope(is_A, suppose(B, I)) as (_, is_B):
        page.chain("", "both", A * B, Line(I, by=(is_A, is_B)))
    page.chain("", "after", B * A, Line(B, by=(is_A,)))
    refused(page, letters.chain("", "b", B, Line(I, by=(is_B,))), "B = I, whose")
    assert page.check() == []


def test_several_hypotheses_end_together():
    page = new()
    with page.scope(suppose(A, I), suppose(B, I)) as (one, two):
        page.chain("", "both", A * B, Line(I, by=(one, two)))
    assert "What follows does not rest on A = I and B = I." in str(page)


def test_the_end_of_a_scope_says_whether_more_was_introduced():
    page = new()
    with page.scope(suppose(A, I)) as one:
        with page.scope(suppose(B, I)) as two:
            page.chain("", "both", A * B, Line(I, by=(one, two)))
        page("words")
    with page.scope(suppose(A, I), suppose(B, I)) as both:
        is_X = page(let(X, A * B))
        page.chain("", "it", X, Line(I, by=(is_X, *both)))
    with page.scope(suppose(A, I)):
        page(let(Y, A))
    ends = [str(item) for item in page.page if isinstance(item, End)]
    assert ends == [
        "What follows does not rest on B = I.",
        "What follows does not rest on A = I.",
        "What follows does not rest on A = I and B = I, nor on what was introduced "
        "with them.",
        "What follows does not rest on A = I, nor on what was introduced with it.",
    ]


def test_a_scope_begins_with_what_is_supposed():
    page = new()
    for nothing in ((), ("words",)):
        with pytest.raises(ValueError, match="begins with what is supposed"):
            with page.scope(*nothing):
                pass


def test_what_is_refused_leaves_nothing_behind():
    page = new()
    with pytest.raises(ValueError, match="says what X is"):
        page(let(X, A), let(X, B))
    assert page.page == ()
    with pytest.raises(ValueError, match="says what X is"):
        with page.scope(let(X, A)) as is_X:
            page.chain("", "it is seen", X, Line(A, by=(is_X,)))
            page(let(X, B))
    assert page.page == () and page.steps == {}
    page(let(X, B))


def test_there_is_a_model_of_what_holds_at_once():
    """Scopes may exclude each other; within one, or around it, nothing may."""
    page = new()
    for value in (I, 2 * I):
        with page.scope(suppose(A * Y, value)) as product:
            page.chain("", f"{value}", A * Y * B, Line(value * B, by=(product,)))
    assert page.check() == []
    around = new()
    outside = around(suppose(A * Y, I))
    around.chain("", "one", A * Y, Line(I, by=(outside,)))
    with around.scope(suppose(A * Y, 2 * I)) as inside:
        around.chain("", "two", A * Y, Line(2 * I, by=(inside,)))
    (found,) = around.check()
    assert "A Y = I and A Y = 2 I hold at once" in found
    after = new()
    with after.scope(suppose(A * Y, 2 * I)) as inside:
        after.chain("", "two", A * Y, Line(2 * I, by=(inside,)))
    outside = after(suppose(A * Y, I), suppose(A, zero))
    after.chain("", "one", A * Y, Line(I, by=outside[:1]))
    after.chain("", "none", A, Line(zero, by=outside[1:]))
    (found,) = after.check()
    assert "A Y = I and A = 0 hold at once" in found


# -- the order of reading -------------------------------------------------------------


def test_nothing_cites_what_comes_later():
    is_X = let(X, A * B)
    chain = letters.chain("", "it is seen", X, Line(A * B, by=(is_X,)))
    refused(new(), chain, r"it is seen: X = A B is cited and not introduced")
    found = Derivation(page=(chain, is_X), letters=letters).check()
    assert found == ["it is seen: X = A B is cited and not introduced"]
    assert Derivation(page=(is_X, chain), letters=letters).check() == []


def cited(item):
    """The relations that an item of a page cites, without those that are proved."""
    if isinstance(item, Derivation):
        found = [r for stage in item.stages for r in stage.reasons]
    else:
        found = [] if isinstance(item, str | Relation) else item.relations
    return {r for r in found if not hasattr(r, "chain")}


@pytest.mark.parametrize("seed", range(40))
def test_any_order_is_accepted_exactly_if_nothing_is_cited_early(seed):
    """The statements of a page, some of them elsewhere, against a plain count."""
    rng = random.Random(seed)
    items = list(quadratic.page.page)
    for _ in range(rng.randint(0, 2)):
        items.insert(rng.randrange(len(items)), items.pop(rng.randrange(len(items))))
    early = [
        r
        for k, item in enumerate(items)
        for r in cited(item)
        if not any(r == x for x in items[:k] if isinstance(x, Relation))
    ]
    defined = {x.left: k for k, x in enumerate(items) if type(x).__name__ == "Let"}
    spoken = [
        x.left
        for k, x in enumerate(items)
        if isinstance(x, Relation) and type(x).__name__ != "Let"
        for letter, at in defined.items()
        if k < at and letter in {*x.left.atoms(type(A)), *x.right.atoms(type(A))}
    ]
    page = Page(letters=quadratic.page.letters)
    try:
        page(*items)
        accepted = True
    except ValueError:
        accepted = False
    assert accepted == (not early and not spoken)


def test_each_scope_of_a_page_is_needed():
    """Without its scopes the page on square roots says two things of one letter."""
    items = [x for x in square_root.page.page if not isinstance(x, End)]
    with pytest.raises(ValueError, match="K_mv"):
        Page(letters=square_root.page.letters)(*items)
    assert sum(isinstance(x, End) for x in square_root.page.page) == 3


# -- induction -------------------------------------------------------------------------


def powers():
    """A page on which no power of F moves x, with what may be wrong about it."""
    own = Notation()
    F, F_0, F_k, F_next = (own(s, n, n, "a power") for s in "F F_0 F_k F_next".split())
    x = own("x", n, 1, "a column")
    found = Page(letters=own)
    stays = found(own.suppose(F * x, x))
    more = found(own.let(F_next, F * F_k))
    one = found.chain("", "the first", F * x, Line(x, by=[stays]))
    with found.scope(own.suppose(F_k * x, x)) as so_far:
        step = found.chain(
            "", "one more", F_next * x, Line(x, by=[more, so_far, stays])
        )
    told = {"base": one, "step": step, "first": {F_k: F}, "then": {F_k: F_next}}
    return found, so_far, told, (F, F_0, F_k, F_next, x, stays, more)


def test_what_holds_at_first_and_goes_on_holds_at_every_k():
    found, so_far, told, (F, _, F_k, _, x, stays, _) = powers()
    always = found.induction("", "no power moves it", so_far, **told)
    assert always.check() == [] and found.check() == []
    assert so_far not in always.relations and stays in always.relations
    cited = found.chain("", "used", F * F_k * x, Line(F * x, by=[always.relation]))
    assert cited.check() == [] and found.check() == []
    said = always.rests_on()
    assert so_far not in said.relations and stays in said.relations
    assert "induction: the first; one more" in str(always)


def test_an_induction_is_refused_where_a_part_of_it_is_missing():
    found, so_far, told, (F, F_0, F_k, F_next, x, stays, more) = powers()
    plain = found.letters.chain("", "by itself", F * x, Line(x, by=[stays]))
    supposed = found.letters.chain("", "supposed", F_k * x, Line(x, by=[so_far]))
    wrong = found.letters.chain("", "wrong", F_next * x, Line(2 * x, by=[more, so_far]))
    cases = {
        "has a base that proves F x = x, and not F₀ x = x": {"first": {F_k: F_0}},
        "has a step that proves F₊ x = x, and not F x = x": {"then": {F_k: F}},
        "has a step that does not suppose the statement": {
            "step": plain,
            "then": {F_k: F},
        },
        "has a base that supposes what is to be proved": {
            "base": supposed,
            "first": {F_k: F_k},
        },
        "has a step that fails": {"step": wrong},
        "does not say what F_k is": {"then": {}},
    }
    for said, change in cases.items():
        line = Induced(so_far.right, statement=so_far, **{**told, **change})
        chain = found.letters.chain("", "x", so_far.left, line)
        assert any(said in fault for fault in chain.check()), (said, chain.check())


def test_what_was_supposed_in_the_scope_beside_the_statement_stays_there():
    own = Notation()
    F, F_k, F_next = (own(s, n, n, "a power") for s in "F F_k F_next".split())
    x = own("x", n, 1, "a column")
    found = Page(letters=own)
    stays = found(own.suppose(F * x, x))
    one = found.chain("", "the first", F * x, Line(x, by=[stays]))
    with found.scope(own.suppose(F_k * x, x)) as so_far:
        only = found(own.suppose(F_next, F * F_k))
        step = found.chain(
            "", "one more", F_next * x, Line(x, by=[only, so_far, stays])
        )
    at = {"first": {F_k: F}, "then": {F_k: F_next}}
    with pytest.raises(ValueError, match="whose scope has ended"):
        found.induction("", "always", so_far, base=one, step=step, **at)
