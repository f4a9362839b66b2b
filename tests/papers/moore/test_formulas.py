"""The chain of factors that runs is what the page proves: run on symbols."""

import numpy as np
import pytest
import sympy as sp

from luenberger.papers.moore import companion_chain as running
from luenberger.papers.moore.driven import driven
from tests.papers.moore.test_orthonormal import POLES, problem

FACTORS = {"one": [2], "two": [1, 1], "a pair first": [2, 1], "a pair last": [1, 2]}


def named(letter, *shape):
    names = [f"{letter}_{'_'.join(map(str, at))}" for at in np.ndindex(*shape)]
    return np.array(sp.symbols(names), dtype=object).reshape(shape)


@pytest.mark.parametrize("degrees", FACTORS.values(), ids=FACTORS)
def test_only_the_row_behind_the_last_is_left(degrees):
    """(5) row by row, with symbols for the plant, the factors and D."""
    n, p, order = 2, 2, sum(degrees)
    A, C, k, D = named("a", n, n), named("c", p, n), named("k", n), named("d", order, p)
    factors = [list(named(f"b_{i}", size)) for i, size in enumerate(degrees)]
    T, after = running.rows(A, C, k, factors, D)
    F = running.dynamics(factors, lambda *shape: np.zeros(shape, int).astype(object))
    left = expanded(T @ A - F @ T - D @ C)
    assert not left[:-1].any()
    assert not expanded(left[-1] - after).any()
    assert not expanded(T[0] - k).any()
    # what D takes away from that row, D_i being row i
    inputs = running.injections(A, C, factors)
    _, alone = running.rows(A, C, k, factors, 0 * D)
    taken = sum(D[i] @ inputs[i] for i in range(order))
    assert not expanded(alone - taken - after).any()
    # with the polynomial's own factors it is k beta(A)
    powers = k
    for factor in factors:
        square = [powers]
        for _ in factor:
            square.append(square[-1] @ A)
        powers = square[-1] + sum(b * row for b, row in zip(factor, square))
    assert not expanded(alone - powers).any()


@pytest.mark.parametrize("poles", POLES.values(), ids=POLES)
@pytest.mark.parametrize("seed", range(2))
def test_rows_that_are_driven_to_zero_solve_the_page_s_equations(poles, seed):
    """(5), (7) of what `driven` finds, before anything is made of it."""
    poles = np.array(poles, complex)
    A, C, k = problem(poles, seed=seed)
    found = driven(A, C, k, poles)
    F, D, T, P = found.F, found.D, found.T, found.P
    np.testing.assert_allclose(T @ A - F @ T, D @ C, atol=1e-11 * np.linalg.norm(A))
    np.testing.assert_allclose(P @ T, k[None], atol=1e-11 * np.linalg.norm(k))


def expanded(X):
    return np.vectorize(sp.expand, otypes=[object])(X)
