"""What reads and marks answers: kind to form, strict in what counts."""

import numpy as np
import pytest
import sympy as sp

from luenberger.coursework import (
    array,
    by_name,
    choice,
    choices,
    expression,
    instance,
    mark_lines,
    matrix,
    number,
    numbers,
    pick,
    same,
    spot,
)
from matrixproof import Expect, Line, Notation

a, r, Lambda = letters = sp.symbols("a r_1 Lambda_0", positive=True)
n, own = sp.Symbol("n", integer=True, positive=True), Notation()
A, B, C, D = (own(name, n, n, name) for name in "ABCD")
e, w = own("e", n, 1, "error"), own("w", n, 1, "noise")
P = own("P", n, n, "covariance", symmetric=True)
is_C, is_D = own.let(C, A * B), own.let(D, C.T)
is_P, apart = own.moment(e * e.T, P), own.moment(e * w.T, sp.ZeroMatrix(n, n))


@pytest.mark.parametrize(
    "form",
    [
        "2 a r1 + Lambda_0/3", "q = 2 A R_1 + lambda0 / 3", "[2ar_1 + Lambda_{0}/3]",
        "$2·a·r_{1} + Lambda_0/3$", 2 * sp.Symbol("a") * sp.Symbol("R1") + Lambda / 3,
        [[2 * a * r + Lambda / 3]], sp.Matrix([2 * a * r + Lambda / 3]),
        sp.Eq(sp.Symbol("q"), 2 * a * r + Lambda / 3),
    ],
    ids=str,
)  # fmt: skip
def test_the_same_expression_in_another_form_is_read(form):
    assert sp.simplify(expression(form, letters, "q") - (2 * a * r + Lambda / 3)) == 0


def test_minus_squares_and_brackets_are_read():
    wanted = a**2 - (1 + a) ** 2 * r
    assert sp.expand(expression("a² − [1+a]^2 r1", letters, "q") - wanted) == 0
    assert expression("sqrt(a) a(1 + a)", letters, "q") == sp.sqrt(a) * a * (1 + a)


@pytest.mark.parametrize(
    ("wrong", "says"),
    [
        (None, "got None"), ([1, 2], "got a list of 2"), ("2 +", "got the text '2 +'"),
        ("b a", "got the text 'b a'"), (sp.Symbol("b"), "got one with b"),
        (len, "got a builtin_function_or_method"), ("__import__('os')", "got the text"),
        (np.eye(2), "got an array of shape (2, 2)"),
        (sp.Matrix([[a, r]]), "got an array of shape (1, 2)"),
    ],
    ids=str,
)  # fmt: skip
def test_what_is_no_expression_is_said_plainly(wrong, says):
    with pytest.raises(AssertionError) as caught:
        expression(wrong, letters, "q")
    begins = "q: expected an expression in a, r_1, Lambda_0, "
    assert str(caught.value).startswith(begins + says)


def test_letters_of_two_cases_are_kept_apart():
    q, Q = sp.symbols("q Q")
    assert expression("q + 2 Q", (q, Q), "x") == q + 2 * Q
    with pytest.raises(AssertionError, match="expected an expression in q, Q"):
        expression("r", (q, Q), "x")


def test_numbers_are_read():
    for form in (1.5, "1.5", "1,5", "3/2", [1.5], np.array(1.5), sp.Rational(3, 2)):
        assert number(form, "q") == 1.5
    for wrong in (None, "abc", np.nan, True, a, [1, 2], "1.5 and more"):
        with pytest.raises(AssertionError, match="q: expected a number, got"):
            number(wrong, "q")
    for form in ((1, 2), "[1; 2]", "1 2", np.array([[1], [2]]), {"r": 2, "q": 1}):
        assert numbers(form, ["q", "r"]) == [1, 2]
    for wrong in (1, (1, 2, 3), "1", {"q": 1}, "1,2,3"):
        with pytest.raises(AssertionError, match="expected"):
            numbers(wrong, ["q", "r"])


def test_choices_are_read():
    assert [choice(form, "abc", "x") for form in ("B", "(b)", "b.", ["b"])] == ["b"] * 4
    assert choice(np.bool_(False), ("yes", "no"), "x") == "no"
    for wrong in ("d", 2, None, "ab"):
        with pytest.raises(AssertionError, match="x: expected one of a, b, c, got"):
            choice(wrong, "abc", "x")


def test_infinity_is_a_number_where_it_may_be_one():
    for form in (np.inf, "inf", " OO", sp.oo, [float("inf")]):
        assert number(form, "q", infinite=True) == np.inf
        with pytest.raises(AssertionError, match="q: expected a number, got"):
            number(form, "q")


def test_tables_are_read():
    for form in ("[-2 a, r1]", "-2a, r_1", [-2 * a, "r1"], sp.Matrix([[-2 * a, r]])):
        assert same(matrix(form, (1, 2), letters, "T"), sp.Matrix([[-2 * a, r]]))
    for form in (
        "[[1,2],[3,4]]",
        "1, 2; 3, 4",
        [["1", 2], (3.0, [4])],
        np.arange(1, 5),
    ):
        wide = not isinstance(form, np.ndarray)
        found = array(form, (2, 2) if wide else (4, 1), "K")
        assert found.ravel().tolist() == [1, 2, 3, 4]
    for wrong in (None, 3, "1, 2", [[1], [2, 3]], np.eye(3), [[1, 2], [3, "x"]]):
        with pytest.raises(AssertionError, match="K: expected a"):
            array(wrong, (2, 2), "K")


def test_entries_are_found_by_name_and_in_order():
    for form in ({"Order_1": 1, "order 2": 2}, [1, 2], (1, 2), np.array([1, 2])):
        assert by_name(form, ["order 1", "order 2"], "x") == {
            "order 1": 1,
            "order 2": 2,
        }
    for wrong in ({"order 1": 1}, {1: 1, 2: 2}, [1], None, "12"):
        with pytest.raises(
            AssertionError, match="x: expected entries order 1; order 2"
        ):
            by_name(wrong, ["order 1", "order 2"], "x")
    for form in ({"P", "G"}, "g; p", ("G", "(P)")):
        assert choices(form, ["P", "G", "H"], "x") == {"P", "G"}
    assert choices(set(), ["P"], "x") == set()
    for wrong in (None, 1, "P, Q"):
        with pytest.raises(AssertionError, match="x: expected (some|one) of P, G, got"):
            choices(wrong, ["P", "G"], "x")
    with pytest.raises(AssertionError, match="x: expected Line, got None"):
        instance(None, Line, "x")


def test_a_mistake_is_spotted_in_any_form():
    with pytest.raises(AssertionError, match="Twice."):
        spot((a + 1) ** 2, {"Once.": a, "Twice.": a**2 + 2 * a + 1})
    spot(a, {"Twice.": 2 * a})
    assert same([a, 1], [a, 1]) and not same([a, 1], [a, 1, 1])


def test_an_answer_is_the_same_as_far_as_its_symbols_go():
    """Numbers that a symbol cannot have refute nothing."""
    b, k = sp.Symbol("b", negative=True), sp.Symbol("k", even=True)
    T = sp.MatrixSymbol("T", 2, 2)
    assert same(sp.sqrt(b**2), -b) and not same(sp.sqrt(b**2), b)
    assert same((-1) ** (k + b), (-1) ** b) and same(T[0, 1] + T[0, 0], sum(T[0, :]))
    assert same(1 / a + 1 / (1 - a), 1 / (a - a**2)) and not same(1 / a, 1 / (1 - a))
    assert not same(T[0, 0], T[0, 1]) and not same(sp.sqrt(b), b)
    assert same(sp.sin(a) ** 2 + sp.cos(a) ** 2, 1) and not same(a / (a - 2), 0)


def test_numbers_of_a_student_are_spread_and_stay():
    drawn = [pick(f"student {k}", "factor", range(5)) for k in range(300)]
    assert min(drawn.count(value) for value in range(5)) > 30
    assert (
        pick("Ann-7", "factor", range(99)) == pick("ann 7", "factor", range(99)) == 55
    )
    assert pick("ann7", "other", range(99)) != pick("ann7", "factor", range(99))


RIGHT = [Line(C * C.T, by=(is_D,)), Line(A * B * C.T, by=(is_C,))]


def marks(lines, **more):
    return mark_lines(lines, C * D, goal=A * B * (A * B).T, steps=3, **more)


def test_a_chain_without_a_fault_has_all_points_however_long():
    last = Line(A * B * B.T * A.T, by=(is_C,))
    assert marks([*RIGHT, last]).points(4) == 4
    idle = Line(C * C.T, why="as it is")  # a free line
    assert marks([RIGHT[0], idle, *RIGHT[1:], last]).points(4) == 4
    assert marks([Line(A * B * (A * B).T, by=(is_C, is_D))]).points(4) == 4


def test_a_slip_costs_one_line_carried_on_or_undone():
    slip = Line(C * C, by=(is_D,))
    on = [slip, Line(A * B * C, by=(is_C,)), Line(A * B * A * B, by=(is_C,))]
    assert (marks(on).right, marks(on).wrong, marks(on).arrives) == (2, 1, False)
    undone = [slip, RIGHT[1], Line(A * B * B.T * A.T, by=(is_C,))]
    for lines in (on, undone):
        found = marks(lines, known=(is_C, is_D))
        assert (found.right, found.wrong, found.points(3)) == (2, 1, 2)


def test_a_chain_that_stops_too_early_is_a_line_short():
    found = mark_lines(RIGHT[:1], C * D, goal=A * B * (A * B).T, steps=1)
    assert (found.right, found.wrong, found.points(2)) == (1, 0, 1)


def test_an_expectation_that_is_put_right_costs_one_line():
    lines = [Expect(2 * P, moments=(is_P,)), Line(P)]
    assert mark_lines(lines, e * e.T, goal=P).wrong == 1


def test_lines_that_say_nothing_earn_nothing():
    idle = [Line(C * D)] * 9
    assert marks(idle).points(3) == 0 and "should go on" in str(marks(idle))
    assert marks([Line(A * B * B.T * A.T)]).points(3) == 0


def test_the_first_line_the_missing_reason_and_the_lesson_are_named():
    lacks = [Line(A * B * C.T, by=(is_C,))]
    found = marks(lacks, known=(is_C, is_D), lessons={"Think of D.": A * B * C.T})
    assert found.says[0].startswith("line 1 does not follow from C = A B: what is left")
    assert found.says[1:] == ("line 1 follows if it cites D = C' too", "Think of D.")


def test_a_reason_too_many_is_a_fault_unless_it_is_free():
    lines, left = [Expect(P, moments=(is_P, apart))], e * e.T
    assert mark_lines(lines, left, goal=P).points(1) == 0
    assert mark_lines(lines, left, goal=P, free=(apart,)).points(1) == 1


@pytest.mark.parametrize("wrong", [None, "proof", [C * D], [], 3], ids=str)
def test_what_is_no_chain_is_said_plainly(wrong):
    with pytest.raises(AssertionError, match="expected|no lines"):
        marks(wrong)
