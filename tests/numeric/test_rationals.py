"""Elimination in Fractions against SymPy: wide, tall, singular and empty matrices."""

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from luenberger.numeric import rationals

SHAPES = [(2, 4), (4, 2), (3, 3), (1, 5), (5, 1), (0, 3), (3, 6)]


def matrix(shape, rank, seed):
    """Fractions with a rank of `rank` at most, some rows and columns zero."""
    rng = np.random.default_rng(seed)
    parts = [
        np.array([Fraction(int(x), int(rng.integers(1, 7))) for x in one.flat],
                 dtype=object).reshape(one.shape)
        for one in (rng.integers(-3, 4, (shape[0], rank)),
                    rng.integers(-3, 4, (rank, shape[1])))
    ]  # fmt: skip
    return parts[0] @ parts[1] if rank else rationals.zeros(*shape)


def in_sympy(M):
    entries = [sp.Rational(x.numerator, x.denominator) for x in M.flat]
    return sp.Matrix(*M.shape, entries)


@pytest.mark.parametrize("seed", range(2))
@pytest.mark.parametrize("rank", [0, 1, 2, 5])
@pytest.mark.parametrize("shape", SHAPES)
def test_echelon_form_and_null_space(shape, rank, seed):
    M = matrix(shape, rank, seed)
    echelon, pivots = rationals.reduced(M)
    wanted, places = in_sympy(M).rref()
    assert tuple(pivots) == tuple(places)
    assert in_sympy(echelon) == wanted[: len(places), :]
    null = rationals.null_space(M)
    assert null.shape == (shape[1], shape[1] - len(pivots))
    assert not (M @ null).any()
    free = [j for j in range(shape[1]) if j not in pivots]
    np.testing.assert_array_equal(null[free], rationals.eye(len(free)))


@pytest.mark.parametrize("seed", range(3))
def test_rows_are_accepted_if_they_are_new(seed):
    M = matrix((7, 4), 3, seed)
    span, accepted = rationals.Span(), []
    for k, row in enumerate(M):
        new = span.accept(row)
        assert new == (in_sympy(M[: k + 1]).rank() > len(accepted))
        accepted += [k] if new else []
    assert len(accepted) == in_sympy(M).rank()


@pytest.mark.parametrize("seed", range(3))
def test_a_linear_system_is_solved_exactly(seed):
    A, X = matrix((4, 4), 5, seed), matrix((4, 2), 5, seed + 1)
    assert in_sympy(A).det() != 0
    np.testing.assert_array_equal(rationals.solve(A, A @ X), X)
