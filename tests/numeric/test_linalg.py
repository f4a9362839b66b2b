"""Singular, redundant, unseen, on the circle: each decision from both sides."""

import numpy as np
import pytest
import scipy.linalg
from exact_oracles import solve
from generators import rational

import luenberger as lb
from luenberger.numeric import detectability, linalg
from luenberger.recursion.weight import positive_weight

TURN = np.array([[0.6, -0.8], [0.8, 0.6]])


def correlated(d, units=(1.0, 1.0)):
    """A covariance of two outputs; d is 1 - correlation^2, about."""
    r = np.sqrt(1 - d)
    return np.array([[1, r], [r, 1]]) * np.outer(units, units)


@pytest.mark.parametrize("units", [(1.0, 1.0), (1e-6, 1e5)])
@pytest.mark.parametrize(("d", "two"), [(1e-12, True), (3e-13, False)])
def test_an_output_that_says_what_another_says_has_no_weight_of_its_own(d, two, units):
    """The eigenvalues 1 -+ r of the correlation count from 2e-13 on; 1 - r is d / 2."""
    X = correlated(d, units)
    rank = np.linalg.matrix_rank(
        linalg.pseudo_inverse(X) * np.outer(units, units), 1e-3
    )
    assert rank == (2 if two else 1)
    assert linalg.null_directions(X).shape[1] == (0 if two else 1)
    assert bool(linalg.nonsingular(X)) is two
    assert linalg.nonsingular(np.stack([np.eye(2), X])).tolist() == [True, two]


def test_a_pseudo_inverse_answers_for_all_that_a_covariance_can_ask():
    """X X^+ X = X, and X^+ with a zero row for what has no variance."""
    X = scipy.linalg.block_diag(correlated(0.0, (1e-4, 3.0)), 0.0, 5.0)
    found = linalg.pseudo_inverse(X)
    np.testing.assert_allclose(X @ found @ X, X, rtol=1e-9, atol=0)
    assert not found[2].any() and not found[:, 2].any()
    blind = linalg.null_directions(X)
    np.testing.assert_allclose(X @ blind, 0, atol=1e-12)
    assert blind.shape == (4, 2)


@pytest.mark.parametrize("shape", [(3, 2), (2, 3, 2), (4, 2, 3, 2)])
def test_stacks_are_solved_one_by_one(shape):
    rng = np.random.default_rng(0)
    N, M = rng.normal(size=shape), correlated(0.5)
    stack = np.broadcast_to(M, (*shape[:-2], 2, 2))
    for X in (linalg.solve_right(N, M), linalg.solve_right(N, stack)):
        np.testing.assert_allclose(X @ M, N, rtol=1e-12, atol=1e-14)
    assert linalg.solve_right(N[..., :0, :], M).shape == (*shape[:-2], 0, 2)


# -- outputs taken as accurate ---------------------------------------------------------


@pytest.mark.parametrize("units", [1.0, 1e-8])
@pytest.mark.parametrize(("angle", "kept"), [(2.2e-10, True), (1.8e-10, False)])
def test_accurate_outputs_that_almost_agree_are_refused(angle, kept, units):
    """Rows at half this angle have a second pivot of that, whatever their units."""
    slope = 0.25 * np.pi - 0.5 * angle  # of the other row, 45 degrees
    C1 = np.array([[0.5**0.5, 0.5**0.5, 0], [np.cos(slope), np.sin(slope), 0]])
    C1[1] *= units
    if kept:
        Phat, Gamma1, That = linalg.complete(C1)
        both = C1 @ Gamma1 * [[1, units], [1 / units, 1]]
        np.testing.assert_allclose(both, np.eye(2), atol=1e-5)
        np.testing.assert_allclose(C1 @ Phat, 0, atol=1e-12)
    else:
        with pytest.raises(lb.DesignError, match="linearly dependent"):
            linalg.complete(C1)


@pytest.mark.parametrize("weight", [None, np.diag([1.0, 4.0, 9.0, 0.25])])
def test_right_inverse_is_the_one_of_least_weighted_trace(weight):
    C1 = np.array([[1.0, 2, 0, 1], [0, 1, -1, 3]])
    W = np.eye(4) if weight is None else weight
    Phat, Gamma1, That = linalg.complete(C1, weight)
    back = np.linalg.inv(W)
    wanted = back @ C1.T @ np.linalg.inv(C1 @ back @ C1.T)
    np.testing.assert_allclose(Gamma1, wanted, rtol=1e-12, atol=1e-14)
    whole = np.vstack([That, C1]) @ np.hstack([Phat, Gamma1])
    np.testing.assert_allclose(whole, np.eye(4), atol=1e-13)
    rows = Phat[(Phat != 0).sum(axis=1) == 1]
    assert (np.sort(rows, axis=0)[-1] == 1).all()  # states that keep their names


@pytest.mark.parametrize(("least", "kept"), [(2e-14, True), (0.5e-14, False)])
@pytest.mark.parametrize("units", [(1.0, 1.0), (1e-5, 1e7)])
def test_a_weight_is_definite_at_unit_diagonal(least, kept, units):
    W = np.array([[1, 1 - least], [1 - least, 1]]) * np.outer(units, units)
    if kept:
        assert positive_weight(W, 2) is not None
    else:
        with pytest.raises(lb.DesignError, match="must be positive definite"):
            positive_weight(W, 2)


# -- modes --------------------------------------------------------------------------


@pytest.mark.parametrize(("short", "decays"), [(1.1e-9, True), (0.9e-9, False)])
def test_a_mode_next_to_the_circle_does_not_decay(short, decays):
    A = np.diag([1 - short, 0.5])
    assert linalg.decaying(np.array([1 - short]), True).tolist() == [decays]
    if decays:
        detectability.require_detectable(A, np.array([[0.0, 1.0]]))
    else:
        with pytest.raises(
            lb.DesignError, match="not detectable: the plant mode at 1 "
        ):
            detectability.require_detectable(A, np.array([[0.0, 1.0]]))


@pytest.mark.parametrize("rate", [1.0, 1e8])
@pytest.mark.parametrize(
    ("modes", "decays"),
    [
        ([-1.0, -1.1e-13], [True, True]),
        ([-1.0, -0.9e-13], [True, False]),  # beside the largest it may be a zero
        ([-1.1e-9 + 1j, -1.1e-9 - 1j], [True, True]),
        ([-0.9e-9 + 1j, -0.9e-9 - 1j], [False, False]),  # beside its own frequency
        ([1.0, 0.0], [False, False]),
        ([0.0, 0.0], [False, False]),
    ],
)
def test_in_continuous_time_a_mode_is_judged_beside_its_size(modes, decays, rate):
    assert linalg.decaying(rate * np.array(modes), False).tolist() == decays


@pytest.mark.parametrize("output", [1.0, 1e-9, 1e9])
@pytest.mark.parametrize("size", [0.5, 1.0, 100.0])
@pytest.mark.parametrize(("part", "hidden"), [(0.9e-10, True), (1.5e-10, False)])
def test_a_mode_is_unseen_below_1e_10(part, hidden, size, output):
    """C v of a unit eigenvector v, C of length one; the other mode shares in it."""
    A = TURN @ np.diag([1.0, -1.0]) @ TURN.T * size
    C = output * np.array([[part, 1.0]]) @ TURN.T
    found = detectability.hidden_modes(A, C)
    assert found == (pytest.approx([size]) if hidden else [])


def test_eigenvalues_of_blocks_are_those_of_the_blocks():
    """A triple 0.5 stays one; LAPACK on the whole scatters it by 1e-5."""
    A = 0.5 * np.eye(3) + np.eye(3, k=1)
    assert linalg.eigenvalues(A).tolist() == [0.5] * 3
    assert linalg.eigenvalues(A.T).tolist() == [0.5] * 3
    block = np.array([[0.0, 1], [-1, 0]])
    whole = scipy.linalg.block_diag(A, block, [[7.0]])
    whole[0, 4] = whole[2, 5] = 3.0
    for X in (whole, whole.T):
        found = np.sort_complex(linalg.eigenvalues(X))
        np.testing.assert_allclose(found, [-1j, 1j, 0.5, 0.5, 0.5, 7], atol=1e-12)


def test_eigenvalues_of_coupled_pairs_are_not_scattered():
    """A double +-j; LAPACK on the whole, where 0.5 goes last, scatters it by 1e-8."""
    pair = np.array([[0.0, 2], [-0.5, 0]])
    pairs = np.kron(np.eye(2), pair) + np.kron(np.eye(2, k=1), [[1.0, 2], [3, 4]])
    whole = scipy.linalg.block_diag([[7.0]], [[0.5]], pairs)
    whole[0] = 7.0
    for X in (whole, whole.T):
        found = np.sort_complex(linalg.eigenvalues(X))
        np.testing.assert_allclose(found, [-1j, -1j, 1j, 1j, 0.5, 7], atol=1e-14)


@pytest.mark.parametrize("pole", [0.0, 0.9, 1 - 1e-6, 1 - 1e-13])
def test_a_sum_of_powers_goes_on_until_nothing_is_added(pole):
    """1 / (1 - pole^2), to what rounding of the pole's powers leaves of 1 - pole^2."""
    F = np.array([[pole, 1e6], [0, 0.0]])
    X = linalg.lyapunov(F, np.diag([1.0, 1.0]))
    wanted = (1 + 1e12) / ((1 - pole) * (1 + pole))
    assert X[0, 0] == pytest.approx(wanted, rel=1e-12 + 1e-20 / (1 - pole))
    assert X[1, 1] == 1.0 and X[0, 1] == 0.0


@pytest.mark.parametrize(
    ("values", "text"),
    [
        ([0.5 + 1e-13j, -1], "-1, 0.5"),
        ([0.5 + 4e-7j, 0.5 - 4e-7j], "0.5"),
        ([0.5 + 6e-7j, 0.5 - 6e-7j], "0.5 +- 6e-07j"),
        ([1j, -1j, 0.25], "0 +- 1j, 0.25"),
        ([1 / 3, 1 / 3], "0.333333"),
    ],
)
def test_modes_are_listed_once(values, text):
    assert linalg.modes(np.array(values)) == text


def test_rows_are_as_independent_in_any_units():
    """Up to 2^40; as the exact right inverse of least weighted norm."""
    for seed in range(60):
        rng = np.random.default_rng(seed)
        n = int(rng.integers(2, 5))
        m1 = int(rng.integers(1, n + 1))
        C1 = rng.integers(-3, 4, (m1, n)).astype(float)
        x, y = 2.0 ** rng.integers(-40, 41, n), 2.0 ** rng.integers(-40, 41, m1)
        other = C1 / y[:, None] * x
        if np.linalg.matrix_rank(C1) < m1:
            with pytest.raises(lb.DesignError, match="linearly dependent"):
                linalg.complete(other)
            continue
        Phat, Gamma1, That = linalg.complete(other)
        exact, C = rational(C1), rational(other)
        wanted = solve(C @ C.T, C).T
        assert off_rows(Gamma1.T, wanted.T) < 1e-12, seed
        found = linalg.complete(other, np.diag(x * x))[1] * x[:, None] / y
        wanted = solve(exact @ exact.T, exact).T
        assert off_rows(found, wanted) < 1e-12, seed
        np.testing.assert_allclose(That @ Phat, np.eye(n - m1), atol=1e-9)


def test_states_that_share_no_output_get_nothing_from_each_other():
    """In bad units the gain on y1, y2 of the states that only y3 shows was 500."""
    C1 = np.array([[0, 0, -3e-4, 3e-11], [0, 0, 2e-5, 1e-12], [-1e3, -1e11, 0, 0]])
    found = linalg.complete(C1)[1]
    C = rational(C1)
    wanted = solve(C @ C.T, C).T.astype(float)
    np.testing.assert_allclose(found, wanted, rtol=1e-13, atol=1e-12)


def off_rows(found, exact):
    """How far each row is off, beside its own size; the worst."""
    size = np.abs(exact.astype(float)).max(axis=1, keepdims=True)
    gap = (rational(found) - exact).astype(float)
    return np.abs(gap / np.where(size > 0, size, 1.0)).max()


@pytest.mark.parametrize("size", [1e160, 1e200, 1e300, 1e-300])
def test_no_square_of_a_row_overflows(size):
    Phat, Gamma1, That = linalg.complete(np.array([[size, 0.0]]))
    np.testing.assert_array_equal(Phat, [[0], [1]])
    np.testing.assert_allclose(Gamma1, [[1 / size], [0]], rtol=1e-15)
