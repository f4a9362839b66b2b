"""What must not be provable, and what must not even be written."""

import pytest
import sympy as sp
from sympy import Trace, symbols

from matrixproof import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix, prove
from matrixproof.algebra import Algebra
from matrixproof.explicit import Claim
from matrixproof.proofs import Unproved
from matrixproof.rewriting import Contradiction
from matrixproof.words import ShapeError

n, m, p, q = symbols("n m p q", integer=True, positive=True)
a = symbols("a")
A, B, S = (MatrixSymbol(name, n, n) for name in "ABS")
X, K = MatrixSymbol("X", n, m), MatrixSymbol("K", m, n)


# -- normal forms of another algebra --------------------------------------------------


def test_a_normal_form_does_not_smuggle_a_symmetry_in():
    other = Algebra([S])
    with pytest.raises(ValueError, match="made with S symmetric"):
        Algebra().normal(other.normal(S.T * X))


def test_normal_forms_of_an_equal_algebra_are_its_own():
    one, other = Algebra([S]), Algebra([S])
    assert other.normal(one.normal(S.T * A)) == S * A


def test_normal_forms_of_a_weaker_algebra_are_made_again():
    value = Algebra([S]).normal(Algebra().normal(A * S.T))
    assert value == A * S and value.algebra.symmetric == {S}


# -- relations about the identity -----------------------------------------------------


def test_a_relation_for_the_identity_does_not_match_everywhere():
    given = [(Identity(n), A * B)]
    for left, right in (
        (S, A * B * S * A),
        (Identity(m), ZeroMatrix(m, m)),
        (A * S, S),
    ):
        with pytest.raises(Unproved):
            prove(left, right, given)
    assert prove(A * B * S, S, given).check()


@pytest.mark.parametrize("right", [2 * Identity(n), ZeroMatrix(n, n)])
def test_an_identity_that_is_nothing_is_a_contradiction(right):
    with pytest.raises(Contradiction, match="no matrices"):
        prove(A, B, [(Identity(n), right)])


def test_relations_that_contradict_each_other_prove_nothing():
    with pytest.raises(Contradiction):
        prove(A, S, [(A * B, Identity(n)), (A * B, ZeroMatrix(n, n))])


# -- sizes ----------------------------------------------------------------------------


def diagonal(*sizes):
    zero = ZeroMatrix
    return BlockMatrix(
        [[Identity(i) if i is j else zero(i, j) for j in sizes] for i in sizes]
    )


def test_an_identity_is_as_large_as_the_blocks_it_meets():
    with pytest.raises(ShapeError):
        prove(diagonal(p, q), Identity(m))
    with pytest.raises(ShapeError):
        Algebra().normal(sp.MatMul(diagonal(p, q), Identity(m)))
    assert prove(diagonal(p, q), Identity(p + q)).check()
    assert prove(diagonal(p, m - p), Identity(m)).check()


def test_a_zero_is_as_large_as_the_blocks_it_meets():
    difference = diagonal(p, q) - diagonal(p, q)
    with pytest.raises(ShapeError):
        prove(difference, ZeroMatrix(m, m))
    assert prove(difference, ZeroMatrix(p + q, p + q)).check()


def test_sides_of_different_shapes_are_refused():
    with pytest.raises(ShapeError):
        prove(X, K)
    with pytest.raises(ShapeError):
        prove(Trace(A), A)
    with pytest.raises(ShapeError):
        prove(X, X, [(A, Identity(m))])


NONSENSE = {
    "product": lambda: X * X,
    "sum": lambda: X + K,
    "scalar added": lambda: A + 1,
    "inverse of what is not square": lambda: X * X.I,
    "power of what is not square": lambda: X**-1,
    "square of what is not square": lambda: X**2,
    "zero of another shape": lambda: A * ZeroMatrix(q, m),
    "identity of another size": lambda: A * Identity(q),
    "identity of another size, SymPy's": lambda: sp.Identity(q) * A,
    "inverse of a product that is not square": lambda: (A * X).I,
    "difference of sizes": lambda: Identity(n) - X * MatrixSymbol("L", m, p),
}


@pytest.mark.parametrize("build", NONSENSE.values(), ids=NONSENSE)
def test_nonsense_is_refused_when_it_is_written(build):
    with pytest.raises(ShapeError):
        build()


def test_both_shapes_are_named():
    with pytest.raises(ShapeError, match=r"X of shape \(n, m\) by A of shape \(n, n\)"):
        X * A


# -- nothing cancels before we look ---------------------------------------------------


def test_an_inverse_of_a_product_needs_the_product_alone():
    """(X K)^-1 X K = I is right, and K (X K)^-1 X = I is not."""
    assert prove((X * K).I * X * K, Identity(n)).check()
    with pytest.raises(Unproved):
        prove(K * (X * K).I * X, Identity(m))


def test_terms_stay_in_the_order_written():
    assert str(B + A - S * A) == "B + A - S*A"
    assert str((B + A) * S.T) == "(B + A)*S.T"
    assert str(A.I * A) == "A**(-1)*A"
    assert str((Identity(n) - X * K).xreplace({X: A * X})) == "I - A*X*K"
    assert str((A * B).T) == "(A*B).T"


@pytest.mark.parametrize("empty", [sp.zeros(0, 0), sp.zeros(0, 3), sp.zeros(2, 0)])
def test_claims_about_empty_matrices_are_refused(empty):
    with pytest.raises(ValueError, match="empty"):
        assert not Claim(empty, empty).is_zero


# -- dividing by what may vanish ------------------------------------------------------


def test_nothing_is_divided_by_a_scalar_that_may_vanish():
    with pytest.raises(Unproved) as failure:
        prove(A, ZeroMatrix(n, n), [(a * A, ZeroMatrix(n, n))])
    assert not failure.value.complete
    b = symbols("b", positive=True)
    assert prove(A, ZeroMatrix(n, n), [(b * A, ZeroMatrix(n, n))]).check()


def test_factors_are_exchanged_where_the_number_is_not_zero():
    with pytest.raises(Unproved):
        prove(B * A, a * Identity(n), [(A * B, a * Identity(n))])
    with pytest.raises(Unproved):
        prove(X * K, Identity(n), [(K * X, Identity(m))])


def test_sizes_may_be_equal():
    """(n - m) A = 0 does not say that A is 0."""
    with pytest.raises(Unproved):
        prove(A, ZeroMatrix(n, n), [((n - m) * A, ZeroMatrix(n, n))])
