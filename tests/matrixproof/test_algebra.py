"""The algebra in its own right: shapes, normal forms, calculus, and why it exists."""

import numpy as np
import pytest
import sympy as sp
from sympy import BlockMatrix, Identity, MatrixSymbol, Trace, ZeroMatrix
from worlds import Numbers

from matrixproof.algebra import Algebra, Traces, product
from matrixproof.explicit import Claim
from matrixproof.words import ShapeError

n, p, m1 = sp.symbols("n p m_1", integer=True, nonnegative=True)
A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, n)
S, M = MatrixSymbol("S", n, n), MatrixSymbol("M", p, p)
X, Y = MatrixSymbol("X", n, p), MatrixSymbol("Y", n, p)
KNOWN = Algebra(symmetric=[S, M])
SIZES = {"n": 4, "p": 3, "m_1": 2}


def numbers(seed=0, algebra=KNOWN, **sizes):
    return Numbers({**SIZES, **sizes}, seed, symmetric=algebra.symmetric)


MATRICES = {
    "sum": A * X + 2 * X * M,
    "transposes": (A * X * M).T - M * X.T * B,
    "products of sums": (A + S) * (X - B * Y) * M.T,
    "powers": (A + B) ** 2 * X,
    "inverse": X * M.I * X.T * A.T + S.I * S * A,
    "transposed inverse": (X * M.I * Y.T).T + (A.I * B).T,
    "identity": (Identity(n) - A) * (Identity(n) + A),
    "zero": A * X * ZeroMatrix(p, n) + B,
    "vanishing": A * S - (S * A.T).T + ZeroMatrix(n, n),
    "scalars": sp.Rational(1, 3) * A * (3 * X) - n * X,
}


@pytest.mark.parametrize("expr", MATRICES.values(), ids=MATRICES.keys())
def test_normal_form_keeps_the_value(expr):
    given, back = numbers(), KNOWN.normal(expr).as_expr()
    np.testing.assert_allclose(given.value(back), given.value(expr), atol=1e-11)


SCALARS = {
    "sum of traces": Trace(A * B) + 3 * Trace(X * M * X.T) - Trace(S),
    "quadratic": Trace((A - X * Y.T) * S * (A - X * Y.T).T) + Trace(Y * M * X.T),
    "symmetric variable": Trace(A * S * B * S) + Trace(S * S * S),
    "inverse": Trace(A * S.I * B) + Trace(X * M.I * X.T),
    "constant": Trace(A * A) + n + Trace(Identity(n)),
    "factored": 2 * (Trace(A * S) - 3 * Trace(X * Y.T)),
}


@pytest.mark.parametrize("expr", SCALARS.values(), ids=SCALARS.keys())
def test_trace_keeps_the_value(expr):
    given, back = numbers(), KNOWN.normal(expr).as_expr()
    np.testing.assert_allclose(given.value(back), given.value(expr), rtol=1e-11)


@pytest.mark.parametrize("variable", [A, S, X, M], ids=lambda s: s.name)
@pytest.mark.parametrize("expr", SCALARS.values(), ids=SCALARS.keys())
def test_gradient_is_the_finite_difference(expr, variable):
    given = numbers(seed=1)
    gradient = given.value(KNOWN.gradient(expr, variable).as_expr())
    base, h = given.value(variable), 1e-5
    assert np.shape(gradient) == base.shape
    rng = np.random.default_rng(2)
    for _ in range(3):
        step = rng.normal(size=base.shape)
        step = step + step.T if variable in KNOWN.symmetric else step
        ends = [given.value(expr, {variable: base + t * step}) for t in (h, -h)]
        slope = (ends[0] - ends[1]) / (2 * h)
        np.testing.assert_allclose(np.sum(gradient * step), slope, rtol=2e-5, atol=1e-5)


def test_differential_is_linear_and_second_differential_is_the_hessian():
    cost = Trace(X * M * X.T) - 2 * Trace(X * Y.T)
    D = MatrixSymbol("D", n, p)
    first = KNOWN.differential(cost, {X: D})
    assert first == 2 * Trace(D * M * X.T) - 2 * Trace(D * Y.T)
    second = KNOWN.differential(first, {X: D})
    assert second == 2 * Trace(D * M * D.T)


def test_trace_is_cyclic_and_transposable():
    assert KNOWN.normal(Trace(A * X * Y.T)) == Trace(Y.T * A * X)
    assert KNOWN.normal(Trace(A * X * Y.T)) == Trace(Y * X.T * A.T)
    assert KNOWN.normal(Trace(A * S * B)) == Trace(B.T * S * A.T)
    assert not (KNOWN.normal(Trace(A * B * S)) == Trace(B * A * S))


REFUSED = {
    "product": lambda: KNOWN.normal(X * X),
    "product of unequal symbols": lambda: KNOWN.normal(sp.MatMul(A, M)),
    "sum": lambda: KNOWN.normal(sp.MatAdd(X, Y.T)),
    "trace": lambda: KNOWN.normal(Trace(sp.MatMul(A, X))),
    "blocks": lambda: KNOWN.normal(BlockMatrix([[A, X]]) * BlockMatrix([[X.T], [A]])),
    "partition": lambda: KNOWN.normal(
        BlockMatrix([[A], [X.T]]) + BlockMatrix([[X.T], [A]])
    ),
}


@pytest.mark.parametrize("build", REFUSED.values(), ids=REFUSED.keys())
def test_shapes_are_checked(build):
    with pytest.raises(ShapeError):
        build()


def test_sympy_itself_accepts_such_a_product():
    assert sp.MatMul(X, X).shape == (n, p)


def test_unnamed_inverse_is_refused():
    with pytest.raises(TypeError, match="name the composite"):
        KNOWN.normal((S + A).I)
    with pytest.raises(TypeError, match="not linear"):
        KNOWN.normal(Trace(A) * Trace(B))


def test_mutual_inverses_cancel_and_others_do_not():
    assert KNOWN.normal(X * M.I * M * X.T) == X * X.T
    assert KNOWN.normal(A.T * (A.I).T) == Identity(n)
    assert not KNOWN.normal(A * (A.I).T).is_scaled_identity


def test_inverses_cancel_across_the_seam_of_a_trace():
    assert KNOWN.normal(Trace(B * A * X * X.T * B.I)) == Trace(X * X.T * A)
    assert KNOWN.normal(Trace(A * B * A.I)) == Trace(B)
    pair = KNOWN.letter(A), KNOWN.letter(A, inverted=True)
    assert Traces(KNOWN, [(pair, 2)]) == 2 * n
    assert KNOWN.normal(Trace(A * B * (A.I).T)) != Trace(B)


def blocks(sizes=None):
    K = MatrixSymbol("K", n - m1, m1)
    P = BlockMatrix([[ZeroMatrix(m1, n - m1)], [Identity(n - m1)]])
    V = BlockMatrix([[Identity(m1)], [K]])
    C = BlockMatrix([[Identity(m1), ZeroMatrix(m1, n - m1)]])
    T = BlockMatrix([[-K, Identity(n - m1)]])
    return K, P, V, C, T


def test_blocks_meet_identities():
    _, P, V, C, T = blocks()
    whole = P * T + V * C
    assert (KNOWN.normal(whole) - Identity(n)).is_zero
    assert KNOWN.normal(whole - Identity(n)).is_zero
    assert not KNOWN.normal(whole + Identity(n)).is_zero
    assert KNOWN.normal(T * V).is_zero
    assert KNOWN.normal(Trace(whole)) == n


def test_an_identity_before_or_behind_blocks_changes_nothing():
    _, P, V, _, _ = blocks()
    both = BlockMatrix([[P, V]])
    for factors in ((Identity(n), both), (both, Identity(n))):
        same = sp.MatMul(*factors, evaluate=False)
        assert (KNOWN.normal(same) - KNOWN.normal(both)).is_zero


@pytest.mark.parametrize("size", [0, n], ids=["none", "all"])
def test_blocks_at_limiting_sizes(size):
    _, P, V, C, T = blocks()
    whole = (P * T + V * C).subs(m1, size)
    assert (KNOWN.normal(whole) - Identity(n)).is_zero


def test_empty_matrices_are_zero():
    none, wide = MatrixSymbol("O", n, 0), MatrixSymbol("U", 0, n)
    assert KNOWN.normal(none * wide).is_zero
    assert KNOWN.normal(Identity(0)).is_zero
    assert KNOWN.normal(Trace(wide * none)).is_zero
    assert KNOWN.normal(A + none * wide) == A


def test_block_value():
    K, P, V, C, T = blocks()
    given = numbers()
    expr = V * K.T * T * V * C + 2 * P * T
    np.testing.assert_allclose(
        given.value(KNOWN.normal(expr).as_expr()), given.value(expr), atol=1e-12
    )


def test_a_claim_is_evaluated():
    assert Claim(sp.Matrix([[2]]), sp.Matrix([[2]])).is_zero
    assert not Claim(sp.eye(2)).is_zero


def test_canary_sympy_differentiates_a_sum_of_traces_to_zero():
    """When this fails, SymPy has changed: see whether the layer is still needed."""
    wrong = (Trace(X.T * A * X) + Trace(X.T * Y)).diff(X)
    assert str(wrong) == "0"
    right = KNOWN.gradient(Trace(X.T * A * X) + Trace(X.T * Y), X)
    assert right == (A + A.T) * X + Y


def test_zeros_before_blocks_have_their_own_rows():
    column = KNOWN.normal(BlockMatrix([[A], [X.T]]))
    zeros = KNOWN.normal(ZeroMatrix(m1, n + p))
    assert product(zeros, column).shape == (m1, n)
