"""Families: letters with an index, sums over it, and moments of independent noises."""

from dataclasses import replace

import numpy as np
import pytest
import sympy as sp
from sympy import Trace

from matrixproof import (
    Chain,
    Expect,
    Identity,
    Line,
    Notation,
    derive,
    latex,
    letters,
    prove,
    text,
)
from matrixproof.checker import complaints
from matrixproof.families import over
from matrixproof.orders import at_least, prove_at_least
from matrixproof.proofs import Unproved
from matrixproof.relations import named
from matrixproof.symbols import Member

sum_i, A_i, B_i, x_i = letters("sum_i A_i:n*n B_i:n*n x_i:n")
Q, W, V, P, T = letters("Q:n*n= W:n*n= V:n*n= P:n*n= T:n*n")
z, z_next, w, F = letters("z:n z_next:n w:n F:n*n")
is_V = V, W + sum_i * A_i * Q * A_i.T

HOLD = {
    "a definition": (V - W, sum_i * A_i * Q * A_i.T, [is_V]),
    "multiplied from outside": (T * V, T * W + sum_i * T * A_i * Q * A_i.T, [is_V]),
    "another relation within": (sum_i * A_i * Q, sum_i * B_i, [(A_i * Q, B_i)]),
    "a sum within a sum, closed": (
        sum_i * A_i * V * A_i.T,
        sum_i * A_i * (W + P) * A_i.T,
        [(V, W + P)],
    ),
    "a trace": (Trace(P * (V - W)), sum_i * Trace(Q * A_i.T * P * A_i), [is_V]),
    "inverses": (V.I, (W + sum_i * A_i * Q * A_i.T).I, [is_V]),
    "an inverse of each": (
        sum_i * (A_i + W).I * A_i,
        sum_i * Identity(W.rows) - sum_i * (A_i + W).I * W,
        [],
    ),
    "a product of two": (
        (sum_i * A_i) * (sum_i * B_i).T,
        ((sum_i * B_i) * (sum_i * A_i).T).T,
        [],
    ),
}
FALSE = {
    "one member of its sum": (A_i * Q, B_i, [(sum_i * A_i * Q, sum_i * B_i)]),
    "the same for each, summed": (sum_i * Q, Q, []),
    "a member before a sum": (A_i * V, A_i * W + sum_i * A_i * A_i * Q * A_i.T, [is_V]),
    "and behind": (V * A_i, W * A_i + sum_i * A_i * Q * A_i.T * A_i, [is_V]),
    "a product of two sums": (
        (sum_i * A_i) * (sum_i * B_i).T,
        sum_i * A_i * B_i.T,
        [],
    ),
    "a square of a sum": (V * V.T, sum_i * A_i * A_i.T, [(V, sum_i * A_i)]),
    "a sum taken for a number": (sum_i * W, sum_i * V, [(sum_i * sp.S(2) * W, V)]),
    "a sum cancelled": (W, V, [(sum_i * W, sum_i * V)]),
    "a wrong sign": (V, W - sum_i * A_i * Q * A_i.T, [is_V]),
}


@pytest.mark.parametrize("name", HOLD)
def test_what_holds_is_proved_for_any_number_of_members(name):
    left, right, given = HOLD[name]
    assert prove(left, right, given).check()


@pytest.mark.parametrize("name", FALSE)
def test_what_is_false_is_not_proved(name):
    with pytest.raises(Unproved):
        prove(*FALSE[name])


def value(expr, known, members):
    """An expression by NumPy, its sums over members that differ."""
    if isinstance(expr, sp.MatAdd):
        return sum(value(x, known, members) for x in expr.args)
    if isinstance(expr, sp.MatMul):
        number, factors = expr.as_coeff_matrices()
        signs = number.atoms(type(sum_i))
        total = 0
        for k in range(len(members)) if signs else [None]:
            here = known if k is None else {**known, **members[k]}
            product = np.eye(2)
            for x in factors:
                product = product @ value(x, here, members)
            total = total + product
        return float(number.subs(dict.fromkeys(signs, 1))) * total
    if isinstance(expr, sp.Transpose):
        return value(expr.arg, known, members).T
    if isinstance(expr, sp.Inverse):
        return np.linalg.inv(value(expr.arg, known, members))
    return np.eye(2) if isinstance(expr, sp.Identity) else known[expr]


@pytest.mark.parametrize("count", [0, 1, 3])
def test_members_may_differ(count):
    """Not only for equal members, as the models have them."""
    rng = np.random.default_rng(count)
    draw = lambda: rng.normal(size=(2, 2))  # noqa: E731
    members = [{A_i: draw(), B_i: draw()} for _ in range(count)]
    known = {W: draw(), Q: draw(), T: draw()}
    known[V] = value(is_V[1], known, members)
    for name in ("a definition", "multiplied from outside", "inverses"):
        left, right, _ = HOLD[name]
        ends = (value(side, known, members) for side in (left, right))
        np.testing.assert_allclose(*ends, err_msg=name)
    product = derive((T + sum_i * A_i) * (W + sum_i * B_i)).expand()
    doubled = sp.Tuple(product.right).atoms(Member)
    assert {text(x) for x in doubled} == {"A_i", "B_i", "B_j"}


def test_a_sum_takes_in_no_member_beside_it():
    for make in (
        lambda: derive(A_i * V).put(is_V).check(),
        lambda: prove(A_i * (sum_i * B_i), V),
        lambda: prove(sum_i * (W + sum_i * B_i), V),
    ):
        try:
            found = make()
        except ValueError as e:
            found = [str(e)]
        assert found and ("stands beside a sum" in found[0] or "within" in found[0])
    put_in = Line(sum_i * B_i * A_i, by=[(V, sum_i * B_i)])
    (fault,) = Chain("", "", V * A_i, [put_in]).check()
    assert "stands beside a sum over i" in fault


def test_the_checker_refuses_each_way_out_of_a_sum():
    proof = prove(T * V, T * W + sum_i * T * A_i * Q * A_i.T, [is_V])
    statement, terms = proof.statement, proof.certificates["claim"]
    assert complaints(statement, "claim", terms) == []
    ((c, u, fact, v),) = terms
    for wrong in (
        (c * sum_i, u, fact, v),
        (c / sum_i, u, fact, v),
        (c, (("A_i", False),), fact, v),
        (c, u, fact, (("A_i", True),)),
    ):
        (fault,) = complaints(statement, "claim", [wrong])
        assert "sum_i" in fault and "ValueError" in fault
    told = {s: frozenset() for s in statement.sums}
    blind = replace(statement, sums=told)
    assert (
        "left over" in complaints(blind, "claim", [(c, (("A_i", False),), fact, v)])[0]
    )


def test_it_is_shown_as_it_is_read():
    assert text(W - 2 * sum_i * A_i * Q * A_i.T) == "W - 2 Σ_i A_i Q A_i'"
    assert latex(sum_i * A_i) == r"\sum_{i} A_{i}"
    both = (sum_i * A_i) * (sum_i * B_i)
    assert text(both) == "(Σ_i A_i) (Σ_i B_i)"
    assert text(derive(both).expand().right) == "Σ_i Σ_j A_i B_j"
    assert text(P * (sum_i * A_i)) == "Σ_i P A_i"
    own = Notation()("A1", 2, 2, "for programs", index="i", family="A")
    assert (own.name, text(own), latex(own.other)) == ("A1", "A_i", "A_{j}")


MOMENTS = (
    (x_i * x_i.T, Q),
    (x_i * x_i.other.T, 0 * Q),
    (z * x_i.T, 0 * Q),
    (z * z.T, P),
    (w * w.T, W),
    (z * w.T, 0 * Q),
    (x_i * w.T, 0 * Q),
)
moves = z_next, F * z + sum_i * A_i * x_i + w


def test_noises_of_a_family_add_what_each_adds():
    second = derive(z_next * z_next.T).put(moves).expect(*MOMENTS)
    assert second.check() == []
    assert text(second.right) == "F P F' + Σ_i A_i Q A_i' + W"
    assert "E[x_i x_j'] = 0 (i ≠ j)" in str(second)
    cost = derive(Trace(T * z_next * z_next.T)).put(moves).expect(*MOMENTS)
    assert cost.check() == []
    slope = derive(Trace(T * sum_i * A_i * Q * A_i.T)).gradient(T)
    assert text(slope.right) == "Σ_i A_i Q A_i'"


def test_that_they_are_independent_is_needed():
    product = z_next * z_next.T
    for moments in (
        MOMENTS[:1] + MOMENTS[2:],
        (MOMENTS[0], (x_i * x_i.other.T, Q), *MOMENTS[2:]),
        (MOMENTS[0], (x_i, 0 * x_i), *MOMENTS[2:]),
    ):
        with pytest.raises(ValueError, match="not among the moments"):
            derive(product).put(moves).expect(*moments)
    start = (sum_i * A_i * x_i) * (sum_i * A_i * x_i).T
    wrong = Expect((sum_i * A_i * Q) * (sum_i * A_i).T, moments=MOMENTS[:2])
    assert Chain("", "", start, [wrong]).check()[0].startswith("line 1 does not follow")


def test_a_sum_of_squares_is_dropped():
    line = derive(W + sum_i * A_i * Q * A_i.T).drop(Q)
    assert line.check() == [] and text(line.right) == "W"
    assert "Σ_i A_i L_Q (A_i L_Q)' ≥ 0" in str(line)
    with pytest.raises(ValueError, match="no term is a square"):
        derive(W - sum_i * A_i * Q * A_i.T).drop(Q)


def test_a_sum_is_at_least_what_is_in_it():
    more = W + sum_i * A_i * Q * A_i.T + P
    given = at_least(Q), at_least(P)
    assert prove_at_least(more, W, given).check()
    down = derive(more).at_least(W, *given)
    assert down.check() == [] and "Σ_i A_i L_Q (A_i L_Q)'" in str(down)
    above = at_least(Q, P)
    assert prove_at_least(sum_i * A_i * Q * A_i.T, sum_i * A_i * P * A_i.T, [above])
    for left, right in ((W, more), (sum_i * A_i * P * A_i.T, sum_i * A_i * Q * A_i.T)):
        with pytest.raises(Unproved):
            prove_at_least(left, right, (*given, above))


def test_one_member_is_not_moved_alone():
    cost = Trace(T * (sum_i * A_i * Q * A_i.T))
    with pytest.raises(TypeError, match="A_i is one of a family"):
        derive(cost).gradient(A_i)
    (dA_i,) = letters("dA_i:n*n")
    with pytest.raises(TypeError, match="A_i is one of a family"):
        derive(sum_i * A_i * Q).differential({A_i: dA_i})
    both = derive((sum_i * A_i) * W * (sum_i * B_i).T).expand()
    said = both.known + ((A_i, T * W), (B_i, T * P))
    for x in (A_i, B_i):  # shown as A_i and B_j
        tied = replace(both, known=named([said[0] if x is A_i else said[1]]))
        with pytest.raises(ValueError, match=f"takes {x} for constant"):
            replace(tied, left=Trace(both.right * T), lines=()).gradient(T)


def test_a_definition_with_a_sum_is_recognised():
    line = derive(T * W * T.T + sum_i * T * A_i * Q * A_i.T * T.T).fold(is_V)
    assert line.check() == [] and line.right == T * V * T.T
    assert Chain("", "", V, [Line(W, by=[is_V])]).check()
    assert over("i") == sum_i
