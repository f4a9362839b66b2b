"""Relations have models, false claims are refuted, and nothing is taken on trust."""

import time

import pytest
import sympy as sp
from identities import FALSE, TRUE, parts
from sympy import Identity, Matrix, MatrixSymbol, Rational, Trace, ZeroMatrix

from matrixproof import Relation, prove, refute
from matrixproof.exact import System, Unsolvable, roots
from matrixproof.models import NoModel, differ, evaluate, model

n, p, m = sp.symbols("n p m", integer=True, positive=True)
A, B, T = (MatrixSymbol(name, n, n) for name in "ABT")
C, K = MatrixSymbol("C", p, n), MatrixSymbol("K", n, p)
ONE, ZERO = Identity(n), ZeroMatrix


def symbols_in(relations):
    sides = [side for relation in relations for side in relation]
    return set().union(*(side.atoms(MatrixSymbol) for side in sides))


# -- models ---------------------------------------------------------------------------

SETS = {
    "right inverse": ([(C * K, Identity(p))], []),
    "idempotent": ([(T * T, T)], []),
    "nilpotent": ([(T**3, ZeroMatrix(n, n)), (A * T, B)], []),
    "orthogonal": ([(T * T.T, ONE)], []),
    "Cholesky": ([(A, T * T.T)], [A]),
    "Lyapunov": ([(A, T * A * T.T + B)], [A, B]),
    "commuting": ([(A * B, B * A), (A * T, T * A)], []),
    "Moore-Penrose": (
        [(C * K * C, C), (K * C * K, K), ((C * K).T, C * K), ((K * C).T, K * C)],
        [],
    ),
    "projection of less than full rank": (
        [(T, K * C), (C * K, Identity(p)), (A * T, ZeroMatrix(n, n))],
        [],
    ),
    "inverse of a sum": ([((A + B).I * T, ONE), (A.I * T, B)], [A]),
    "trace": ([(Trace(A * B), sp.Integer(0)), (A, B + T)], [A]),
    "sizes": ([(MatrixSymbol("X", n - p, n) * K, ZeroMatrix(n - p, p))], []),
}

ONE_IS_ZERO = {"trace"}


@pytest.mark.parametrize("name", SETS)
def test_a_model_satisfies_its_relations(name):
    relations, symmetric = SETS[name]
    values = model(relations, symmetric)
    assert set(values) == symbols_in(relations)
    for left, right in relations:
        assert evaluate(left, values) == evaluate(right, values)
    for symbol in symmetric:
        assert values[symbol] == values[symbol].T
    assert not any(
        v.is_zero_matrix for s, v in values.items() if s != A or "Chol" in name
    )


def test_a_model_is_the_same_every_time():
    relations, symmetric = SETS["Lyapunov"]
    assert model(relations, symmetric) == model(relations, symmetric)


def test_what_is_free_and_symmetric_is_positive_definite():
    assert model([(A, B + T)], [B])[B].is_positive_definite


def test_scalars_have_values():
    s = sp.Symbol("s")
    values = model([(A * A, s * ONE)])
    assert values[A] ** 2 == values[s] * sp.eye(values[A].rows)
    assert isinstance(values[s], sp.Rational)


def test_other_expressions_get_values_and_their_inverses_exist():
    values = model([(A, T * T.T)], also=[(A + B).I])
    assert set(values) == {A, B, T}
    assert (values[A] + values[B]).det() != 0


def test_powers_ask_for_larger_sizes():
    g, c = MatrixSymbol("g", n, 1), MatrixSymbol("c", 1, n)
    chain = [(c * A**j * g, ZeroMatrix(1, 1)) for j in range(4)]
    values = model([*chain, (c * A**4 * g, Identity(1))])
    assert values[A].rows >= 5


def test_a_product_over_no_columns_is_zero():
    none = MatrixSymbol("none", n, 0)
    values = model([(A, B + none * none.T)])
    assert (
        values[A] == values[B]
        and not values[A].is_zero_matrix
        and values[none].cols == 0
    )


@pytest.mark.parametrize(
    "relations",
    [
        [(A * A, A), (A * A, 2 * A), (A, ONE)],
        [(A * B - B * A, ONE)],
        [(C * K, Identity(p)), (C, ZeroMatrix(p, n))],
        [(T * T, ZeroMatrix(n, n)), (T * A, ONE)],
        [(A * A.T, -ONE)],
    ],
    ids=["I = 2 I", "commutator", "zero times K", "nilpotent inverse", "negative"],
)
def test_relations_that_contradict_each_other_have_no_model(relations):
    assert model(relations) is None
    with pytest.raises(NoModel, match="contradict each other"):
        refute(A, 2 * A, relations)


# -- refutations ----------------------------------------------------------------------


@pytest.mark.parametrize("name", FALSE)
def test_false_claim_is_refuted_within_a_second(name):
    left, right, given, symmetric = parts(FALSE[name])
    start = time.process_time()
    values = refute(left, right, given, symmetric)
    assert time.process_time() - start < 1
    assert evaluate(left, values) != evaluate(right, values)
    for relation in given:
        assert evaluate(relation[0], values) == evaluate(relation[1], values)
    assert all(values[s] == values[s].T for s in symmetric)


@pytest.mark.parametrize("name", list(TRUE)[::6])
def test_true_claim_is_not_refuted(name):
    assert refute(*parts(TRUE[name])) is None


def test_a_square_left_inverse_cannot_be_told_from_a_right_one():
    assert refute(B * A, ONE, [(A * B, ONE)]) is None


def test_identities_of_unrelated_sizes_are_told_apart():
    blocks = sp.BlockMatrix(
        [[Identity(n), ZeroMatrix(n, p)], [ZeroMatrix(p, n), Identity(p)]]
    )
    assert refute(Trace(blocks), Trace(Identity(m))) is not None


def test_a_claim_against_zero_is_refuted():
    assert refute(A * B, 0) is not None
    assert refute(A - A, 0) is None


# -- exact values ---------------------------------------------------------------------


def test_values_are_exact():
    values = {A: Matrix([[1, 2], [3, 5]]), B: Matrix([[0, 1], [1, 0]])}
    assert evaluate((A * B).I.T, values) == (values[A] * values[B]).inv().T
    assert evaluate(Trace(A.I * B / 3) + 1, values) == Rational(8, 3)
    assert evaluate(sp.BlockMatrix([[A, B]]), values).shape == (2, 4)
    assert not differ(A * A.I, ONE, values)


def test_empty_blocks_have_values():
    empty = MatrixSymbol("E", n, p)
    values = {empty: sp.zeros(2, 0), A: Matrix([[1, 2], [3, 4]])}
    assert evaluate(A * empty * empty.T, values) == sp.zeros(2, 2)
    assert evaluate(empty.T * A, values).shape == (0, 2)


def test_a_singular_matrix_has_no_inverse():
    with pytest.raises(ZeroDivisionError, match="A is singular"):
        evaluate(A.I, {A: Matrix([[1, 1], [1, 1]])})


def test_shapes_that_do_not_fit_are_refused():
    with pytest.raises(ValueError, match="shapes"):
        evaluate(A, {A: sp.ones(2, 3)})


def test_roots_are_exact_and_rational():
    assert roots({("x", "x"): 1, (): -2}) == []
    assert roots({("x", "x"): 4, (): -9}) == [Rational(-3, 2), Rational(3, 2)]


def test_equations_that_contradict_are_noticed():
    system = System()
    system.require({("x",): 1, ("y",): 1})
    with pytest.raises(Unsolvable):
        system.require({("x",): 2, ("y",): 2, (): 1})


def test_a_model_notices_a_wrong_sign():
    relation = Relation("M = C A C' + T", MatrixSymbol("M", p, p), C * A * C.T)
    values = model([relation], [A])
    assert differ(relation.left, -relation.right, values)
    assert prove(relation.left, relation.right, [relation]).check()
