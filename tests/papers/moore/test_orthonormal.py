"""Observers of a functional whose rows of T are orthonormal: conjugate poles too."""

import numpy as np
import pytest
import scipy.linalg

from luenberger.papers.moore.driven import driven
from luenberger.papers.moore.orthonormal import _row, orthonormal

POLES = {
    "real": [-1.0, -2.5, -0.3],
    "a pair": [-1 + 2j, -1 - 2j],
    "a pair and more": [-0.5 + 0.1j, -0.5 - 0.1j, -2.0, -1 + 3j, -1 - 3j],
}


def problem(poles, n=6, p=2, seed=0):
    rng = np.random.default_rng(seed)
    A, C = rng.normal(size=(n, n)), rng.normal(size=(p, n))
    k = sum(
        (c @ C @ np.linalg.inv(A - pole * np.eye(n))).real
        for pole, c in zip(poles, rng.normal(size=(len(poles), p)))
    )
    return A, C, k  # a functional that has an observer with these poles


@pytest.mark.parametrize("poles", POLES.values(), ids=POLES)
@pytest.mark.parametrize("seed", range(3))
def test_an_observer_in_orthonormal_coordinates(poles, seed):
    poles = np.array(poles, complex)
    A, C, k = problem(poles, seed=seed)
    found = orthonormal(A, C, k, driven(A, C, k, poles), poles)
    F, D, T, P = found.F, found.D, found.T, found.P
    assert all(np.isrealobj(X) for X in (F, D, T, P))
    np.testing.assert_allclose(T @ T.T, np.eye(len(poles)), atol=1e-13)
    np.testing.assert_allclose(T @ A - F @ T, D @ C, atol=1e-12 * np.linalg.norm(A))
    np.testing.assert_allclose(P @ T, k[None], atol=1e-12 * np.linalg.norm(k))
    np.testing.assert_allclose(
        np.sort_complex(np.linalg.eigvals(F)), np.sort_complex(poles), atol=1e-9
    )
    blocks = np.tril(F, -2)
    assert not blocks.any()  # triangular, but for the blocks of pairs
    values = scipy.linalg.schur(F, output="complex")[0].diagonal()
    assert len(values) == len(poles)


def test_a_row_is_the_nearest_that_its_equation_leaves():
    """Of all t (A - a I) = f T + d C that are orthogonal to T."""
    rng = np.random.default_rng(7)
    A, C, wanted = rng.normal(size=(5, 5)), rng.normal(size=(2, 5)), rng.normal(size=5)
    first = scipy.linalg.null_space(np.vstack([A - 0.2 * np.eye(5), C]).T)[:, :1].T
    first = first / np.linalg.norm(first[:, :5])
    T, D, F = first[:, :5], -first[:, 5:], np.array([[0.2]])
    t, f, d = _row(A, C, 0.3, T, F, D, wanted)
    pencil = A - 0.3 * np.eye(5)
    np.testing.assert_allclose(t @ pencil, f @ T + d @ C, atol=1e-13)
    apart = np.eye(5) - T.T @ T
    every = scipy.linalg.null_space(np.vstack([pencil, T, C]).T)[:5].T @ apart
    span = scipy.linalg.orth(every.T)
    assert span.shape[1] == 2  # there is a choice
    near = span @ span.T @ apart @ wanted / np.linalg.norm(apart @ wanted)
    np.testing.assert_allclose(t, near, atol=1e-13)
