"""The chain of factors that runs is what the page proves: run on symbols."""

import numpy as np
import pytest
import sympy as sp

from luenberger.papers.moore import companion_chain as running

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


def expanded(X):
    return np.vectorize(sp.expand, otypes=[object])(X)
