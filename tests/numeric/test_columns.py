"""Many matrices side by side are each what it is by itself."""

import numpy as np
import pytest

from luenberger.numeric import columns, factors, linalg
from luenberger.numeric.columns import Columns

M = 11


def drawn(rows, cols, seed=0):
    return np.random.default_rng(seed).normal(size=(M, rows, cols))


def each(X):
    """(M, rows, cols)."""
    return X.X[:, :, :M].transpose(2, 0, 1)


def test_products_sums_and_turns():
    A, B, one = drawn(3, 4), drawn(4, 2, 1), drawn(3, 4, 2)[0]
    a, b, c = Columns.many(A), Columns.many(B), Columns.one(one)
    np.testing.assert_allclose(each(a.dot(b)), A @ B, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(each(c.dot(b)), one @ B, rtol=1e-13, atol=1e-14)
    np.testing.assert_allclose(each(a.T.dot(c)), A.mT @ one, rtol=1e-13, atol=1e-14)
    np.testing.assert_array_equal(each(a + c), A + one)
    np.testing.assert_array_equal(each(a - c), A - one)
    np.testing.assert_array_equal(each(a.of(np.array([4, 2])))[:2], A[[4, 2]])
    np.testing.assert_array_equal(Columns.many(A[:, :, 0]).X[:, 0, :M].T, A[:, :, 0])
    assert Columns.many(np.zeros((M, 0))).X.shape == (0, 1, 16)


@pytest.mark.parametrize("p", [1, 2, 5])
def test_solved_from_the_right(p):
    root, N = drawn(p, p), drawn(3, p, 1)
    definite = root @ root.mT + np.eye(p)
    found = columns.solve_right(Columns.many(N), Columns.many(definite))
    np.testing.assert_allclose(
        each(found), linalg.solve_right(N, definite), rtol=1e-10, atol=1e-12
    )
    one = columns.solve_right(Columns.one(N[0]), Columns.many(definite))
    np.testing.assert_allclose(
        each(one), linalg.solve_right(N[0][None], definite), rtol=1e-10, atol=1e-12
    )
    definite[3, -1] = definite[3, :, -1] = 0
    found = columns.solve_right(Columns.many(N), Columns.many(definite))
    assert np.isnan(each(found)[3]).any() and not np.isnan(each(found)[4]).any()


def test_firm_as_one_by_one():
    root = drawn(3, 3)
    X = root @ root.mT
    X[1, 2] = X[1, :, 2] = 0  # known
    X[2] = root[2, :, :2] @ root[2, :, :2].T  # singular
    X[3] *= 1e-12
    X[4] = -X[4]
    size = np.ones((M, 3))
    size[1, 2] = 0
    found = columns.firm(Columns.many(X), np.pad(size.T, ((0, 0), (0, 5))))[:M]
    wanted = [factors.firm(one, of) for one, of in zip(X, size)]
    np.testing.assert_array_equal(found, wanted)
    assert not found[[2, 3, 4]].any() and found[[0, 1]].all()


@pytest.mark.parametrize("many", [1, 3, 8, 9])
def test_bits_do_not_hang_on_how_many_there_are(many):
    A, B = drawn(3, 4), drawn(4, 3, 1)
    definite = A @ A.mT + np.eye(3)
    whole = columns.solve_right(Columns.many(A @ B), Columns.many(definite))
    whole = whole.dot(Columns.many(A))
    some = columns.solve_right(Columns.many((A @ B)[:many]),
                               Columns.many(definite[:many]))  # fmt: skip
    some = some.dot(Columns.many(A[:many]))
    np.testing.assert_array_equal(some.X[:, :, :many], whole.X[:, :, :many])
