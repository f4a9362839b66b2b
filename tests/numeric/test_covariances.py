"""What is a covariance, whatever units its rows are in."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.numeric.covariances import covariance

SMALL = 2.0**-34  # of a variance in small units, such as rad^2: about 6e-11


def plant(**noise):
    given = dict(Q=np.eye(2), R=[[1.0]], P0=np.eye(2))
    return lb.Plant(np.eye(2) / 2, None, [[1.0, 0]], dt=1.0, **given | noise)


def beside_large(block):
    """The block in small units, beside the large variance of another state."""
    X = np.zeros((3, 3))
    X[0, 0], X[1:, 1:] = 1e12, SMALL * np.array(block)
    return X


@pytest.mark.parametrize(
    ("noise", "said"),
    [
        (
            dict(Q=-SMALL * np.eye(2)),
            r"Q must be .*: Q\[0, 0\] on its diagonal is -5.8",
        ),
        (dict(Q=np.diag([1, -SMALL])), r"Q\[1, 1\] on its diagonal is -5.8"),
        (dict(Q=np.diag([1e12, -1e-300])), r"Q\[1, 1\] on its diagonal is -1e-300"),
        (dict(R=[[-SMALL]]), r"R\[0, 0\] on its diagonal"),
        (dict(P0=np.diag([-SMALL, 1])), r"P0\[0, 0\] on its diagonal"),
        (dict(Q=[[0, SMALL], [SMALL, 0]]), r"Q\[0, 0\] is 0, but Q\[0, 1\] .* 5.8"),
        (dict(P0=[[1, SMALL], [SMALL, 0]]), r"P0\[1, 1\] is 0, but P0\[0, 1\]"),
        (dict(Q=[[1, 0], [SMALL, 0]]), r"Q\[1, 1\] is 0, but Q\[1, 0\]"),
        (dict(Q=[np.eye(2), np.diag([1, -SMALL])]), r"Q\[1, 1, 1\] on its diagonal"),
        (
            dict(Q=[np.eye(2), np.eye(2), [[1, 2], [2, 1]]]),
            r"eigenvalue -1, most of it in row \d of Q\[2\]",
        ),
        (
            dict(Q=np.diag([1, 0]), S=[[0], [SMALL]]),
            r"\[\[Q, S\], \[S', R\]\]\[1, 1\] is 0",
        ),
        (dict(R=[[0]], S=[[0], [SMALL]]), r"\[\[Q, S\], \[S', R\]\]\[2, 2\] is 0"),
        (
            dict(Q=SMALL * np.eye(2), R=[[SMALL]], S=[[0], [1.1 * SMALL]]),
            r"\[\[Q, S\], .* eigenvalue -0\.1, most of it in row [12] of \[\[Q, S\]",
        ),
    ],
)
def test_what_no_noise_has_is_refused_in_small_units_too(noise, said):
    with pytest.raises(ValueError, match=said):
        plant(**noise)


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ([[1, 0.9], [-0.9, 1]], r"symmetric: X\[1, 2\].* differ by 1\.8e\+00 of sqrt"),
        ([[1, 0.5], [0.5 + 2e-9, 1]], r"symmetric: X\[1, 2\].* differ by 2\.0e-09"),
        ([[1, 2], [2, 1]], "eigenvalue -1, most of it in row [12] of X"),
        ([[1, 0], [1e-3, 0]], r"X\[2, 2\] is 0, but X\[2, 1\]"),
        ([[1, 1e300], [1e300, 1]], r"eigenvalue -1e\+300, most of it in row [12] of X"),
    ],
)
def test_a_large_variance_of_another_unit_hides_nothing(block, said):
    with pytest.raises(ValueError, match=said):
        covariance("X", beside_large(block), 3)


def test_what_overflows_in_its_units_is_refused():
    with pytest.raises(ValueError, match="eigenvalue -inf, most of it in row 1 of X"):
        covariance("X", [[1, 0, 0], [0, 1e-200, 1e200], [0, 1e200, 1e-200]], 3)


def variety(rng):
    """A covariance with the rounding of how it was made, or something near one."""
    n, rank = int(rng.integers(1, 6)), int(rng.integers(1, 4))
    G = rng.normal(size=(n, rank))
    still = rng.random(n) < 0.2
    G[still] = 0
    X = sum((np.outer(g, g) for g in G.T), np.zeros((n, n)))
    i, j = rng.integers(n, size=2)
    match rng.integers(5):
        case 0:  # each entry rounded for itself
            X = X + X * rng.uniform(-4e-16, 4e-16, size=(n, n))
        case 1:
            X[i, i] -= rng.choice([1e-14, 1e-6, 1]) * X[i, i]
        case 2:
            X[i, j] += rng.choice([1e-14, 1e-6]) * np.sqrt(X[i, i] * X[j, j])
        case 3:
            X[i, j] = X[j, i] = -X[i, j]
        case 4:
            X[i, i] -= 1e-17
    return X


def verdict(X):
    try:
        return covariance("X", X, len(X))
    except ValueError as error:
        return str(error).partition(":")[0]


def test_units_play_no_part():
    """Of 600 matrices D X D with powers of 2 is a covariance where X is one."""
    rng, seen = np.random.default_rng(31), set()
    for _ in range(600):
        X = variety(rng)
        unit = 2.0 ** rng.integers(-30, 31, size=len(X))
        D = np.outer(unit, unit)
        mine, theirs = verdict(X), verdict(D * X)
        if isinstance(mine, str):
            assert theirs == mine
        else:
            assert (theirs == D * mine).all()
        seen.add(mine if isinstance(mine, str) else "accepted")
    assert len(seen) == 3  # and two ways to be refused


@pytest.mark.parametrize("seed", range(20))
def test_what_was_computed_in_floating_point_is_accepted(seed):
    """Singular ones, in any units, summed in an order of each entry's own."""
    rng = np.random.default_rng(seed)
    n, rank = int(rng.integers(2, 9)), int(rng.integers(1, 3))
    G = rng.normal(size=(n, rank)) * 10.0 ** rng.uniform(-9, 9, size=(n, 1))
    X = np.array([[sum(rng.permutation(g * h)) for h in G] for g in G])
    X = X * (1 + rng.uniform(-2e-16, 2e-16, size=X.shape))
    found = covariance("X", X, n)
    assert (found == found.T).all()
    np.testing.assert_allclose(found, X, rtol=1e-13, atol=0)
    size = np.sqrt(np.diag(X))
    printed = np.round(X / size / size[:, None], 12)  # correlations of twelve digits
    covariance("X", printed * size * size[:, None], n)


def test_what_the_library_computes_is_taken_back():
    """Covariances of a filter with an exact output, and of a sampled plant."""
    rng = np.random.default_rng(5)
    for _ in range(30):
        n = int(rng.integers(2, 5))
        A, unit = rng.normal(size=(n, n)), 10.0 ** rng.uniform(-5, 5, size=n)
        A, C = unit[:, None] * A / unit, np.eye(n)[:1]
        G = unit[:, None] * rng.normal(size=(n, 1))
        given = dict(Q=G @ G.T, P0=np.diag(unit**2))
        exact = lb.Plant(0.2 * A, None, C, dt=1.0, R=[[0]], **given)
        P = lb.Filter(exact).run(np.zeros((12, 1))).P
        assert all((covariance("P", X, n) == X).all() for X in P)
        A[n // 2 :, : n // 2] = 0  # no noise reaches the rest
        G[n // 2 :] = 0
        order = rng.permutation(n)
        A, Q = A[order][:, order], (G @ G.T)[order][:, order]
        still = lb.Plant(A, None, C, Q=Q, R=[[1]]).sampled(0.3)
        assert (np.diag(still.Q)[np.argsort(order)][n // 2 :] == 0).all()
