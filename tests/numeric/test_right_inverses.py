"""Right inverses of a stack are those of `complete`, and those of rational numbers."""

import numpy as np
import pytest
from exact_oracles import solve
from generators import rational

from luenberger.numeric.linalg import complete
from luenberger.numeric.right_inverses import right_inverses

SIZES = [(1, 1), (1, 3), (2, 2), (2, 3), (2, 6), (3, 4), (3, 10)]


def drawn(m1, n, units=1.0, count=30):
    """Rows with zeros in them, of states whose units differ by so much."""
    rng = np.random.default_rng([m1, n])
    C = rng.normal(size=(count, m1, n)) * (rng.random((count, m1, n)) < 0.7)
    return C * units ** np.linspace(0, 1, n)


def weights(n, count):
    root = np.random.default_rng(n).normal(size=(count, n, n))
    return root @ root.mT + 0.1 * np.eye(n)


def exact(C, W):
    """W^-1 C' (C W^-1 C')^-1."""
    C, W = rational(C), rational(W)
    half = solve(W, C.T)
    return solve(C @ half, half.T).T  # the matrix is symmetric


def rows_off(found, wanted):
    """The largest error of a row beside the row: a small state has digits too."""
    size = np.abs(wanted).max(axis=1)
    return (np.abs(found - wanted).max(axis=1)[size > 0] / size[size > 0]).max()


@pytest.mark.parametrize("units", [1.0, 1e-9, 1e9])
@pytest.mark.parametrize(("m1", "n"), SIZES)
def test_each_is_that_of_rational_numbers(m1, n, units):
    C = drawn(m1, n, units)
    found, clear = right_inverses(C)
    assert clear.sum() > 10
    for k in np.flatnonzero(clear)[:10]:
        wanted = exact(C[k], np.eye(n)).astype(float)
        condition = np.linalg.cond(C[k] / np.linalg.norm(C[k], axis=1)[:, None])
        assert rows_off(found[k], wanted) < 1e-14 * condition**2, k


@pytest.mark.parametrize("which", ["none", "one", "each"])
@pytest.mark.parametrize(("m1", "n"), SIZES)
def test_each_is_that_of_one_matrix(m1, n, which):
    C = drawn(m1, n)
    W = {"none": None, "one": weights(n, 1)[0], "each": weights(n, len(C))}[which]
    found, clear = right_inverses(C, W)
    for k in np.flatnonzero(clear):
        _, wanted, _ = complete(C[k], W[k] if which == "each" else W)
        np.testing.assert_allclose(
            found[k], wanted, rtol=0, atol=1e-12 * np.abs(wanted).max() ** 2 + 1e-14
        )


@pytest.mark.parametrize("units", [(1e-160, 1.0, 1e160), (1e150, 1e150, 1e-150)])
def test_units_of_outputs_change_nothing(units):
    C, units = drawn(3, 5), np.array(units)
    found, clear = right_inverses(C * units[:, None])
    wanted, same = right_inverses(C)
    np.testing.assert_array_equal(clear, same)
    np.testing.assert_allclose(found * units, wanted, rtol=1e-9, atol=1e-12)


def test_rows_that_may_depend_on_each_other_are_told():
    """Each of a stack by itself: the others have theirs."""
    near = [[1, 2, 3], [1, 2, 3 + 1e-8]]
    C = np.array(
        [[[1, 2, 3], [0, 1, 0]], near, [[1, 2, 3], [2, 4, 6]], np.zeros((2, 3))]
    )
    found, clear = right_inverses(C)
    assert clear.tolist() == [True, False, False, False]
    assert not found[1:].any()
    np.testing.assert_allclose(C[0] @ found[0], np.eye(2), atol=1e-15)
    assert not right_inverses(np.ones((2, 3, 2)))[1].any()  # more rows than columns


@pytest.mark.parametrize("shape", [(0, 1, 3), (0, 2, 3), (4, 0, 3)])
def test_nothing_is_asked(shape):
    found, clear = right_inverses(np.zeros(shape))
    assert found.shape == (shape[0], shape[2], shape[1]) and clear.all()
