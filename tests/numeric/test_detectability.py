"""Which modes the outputs do not see: the same in all units of states and outputs."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.numeric.detectability import dies_out, hidden_modes
from luenberger.numeric.linalg import UNIT_TOL

SEEDS = range(60)


def tracker(unit):
    """Position and velocity, the velocity counted in units of `unit`."""
    g = np.array([0.5, 1 / unit])
    return lb.Plant(
        [[1, unit], [0, 1]], None, [[1, 0]], dt=1.0, Q=np.outer(g, g), R=[[1]]
    )


@pytest.mark.parametrize("unit", [1e-12, 1e12, 1e15])
def test_the_unit_of_velocity_is_free(unit):
    gain = lb.kalman_filter(tracker(unit)).V[:, 0]
    np.testing.assert_allclose(gain * [1, unit], [0.75, 0.5], rtol=1e-9)
    hidden = lb.Plant(
        [[1, 0], [unit, 1.5]], None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]]
    )
    with pytest.raises(
        lb.DesignError, match=r"not detectable: the plant mode at 1\.5 d"
    ):
        lb.kalman_filter(hidden)


def pair(rng, hidden, dense):
    """A, C with these modes hidden, one below the other; the other modes are seen."""
    n, p, k = (
        int(rng.integers(len(hidden) + 1, 9)),
        int(rng.integers(1, 4)),
        len(hidden),
    )
    m = n - k
    A, C = np.zeros((n, n)), np.zeros((p, n))
    A[:m, :m], C[:, :m] = rng.normal(size=(m, m)), rng.normal(size=(p, m))
    A[:m, :m] *= rng.uniform(0.5, 1.6) / np.abs(np.linalg.eigvals(A[:m, :m])).max()
    A[m:, m:] = np.triu(rng.normal(size=(k, k)), 1) + np.diag(hidden)
    A[m:, :m] = rng.normal(size=(k, m))
    if not dense:
        A[:m, :m] *= rng.random((m, m)) < 0.6
        order = rng.permutation(n)
        return A[order][:, order], C[:, order]
    left, right = (np.linalg.qr(rng.normal(size=(n, n)))[0] for _ in range(2))
    T = left * 10 ** rng.uniform(-1, 1, n) @ right
    return np.linalg.solve(T, A @ T), C @ T


def in_other_units(rng, A, C):
    d, s = (10 ** rng.uniform(-12, 12, size) for size in (len(A), len(C)))
    return A / d[:, None] * d, C * s[:, None] * d


def gap(A, C):
    """Distance of the pencil to rank loss at the unstable modes, as SVD sees it."""
    eye, unit = np.eye(len(A)), C / np.linalg.norm(C, axis=1)[:, None]
    values = [mode for mode in np.linalg.eigvals(A) if abs(mode) >= 1]
    pencils = (np.vstack([A - mode * eye, unit]) for mode in values)
    return min((np.linalg.svd(M)[1][-1] for M in pencils), default=np.inf)


@pytest.mark.parametrize("dense", [True, False], ids=["dense", "sparse"])
@pytest.mark.parametrize("seed", SEEDS)
def test_hidden_modes_are_found_in_all_units(seed, dense):
    rng = np.random.default_rng(seed)
    hidden = [(1.0,), (1.3, -1.1), (1.0, 1.0), (-1.5,), (2.0, 1.0, 1.7)][seed % 5]
    A, C = pair(rng, hidden, dense)
    for same in ((A, C), in_other_units(rng, A, C)):
        found = np.array(hidden_modes(*same, 1 - UNIT_TOL))
        for mode in hidden:
            assert np.abs(found - mode).min(initial=9) < 1e-5


@pytest.mark.parametrize("dense", [True, False], ids=["dense", "sparse"])
@pytest.mark.parametrize("seed", SEEDS)
def test_nothing_is_hidden_where_all_is_seen_in_all_units(seed, dense):
    rng = np.random.default_rng(seed)
    A, C = pair(rng, (), dense)
    if gap(A, C) < 1e-6:
        A = A + 1e-2 * rng.normal(size=A.shape)
    assert gap(A, C) > 1e-6
    for same in ((A, C), in_other_units(rng, A, C)):
        assert not hidden_modes(*same, 1 - UNIT_TOL)


@pytest.mark.parametrize("seed", range(20))
def test_a_hidden_mode_that_a_seen_one_shares(seed):
    """The two are one defective pair, which rounding splits by 1e-8."""
    rng = np.random.default_rng(seed)
    T = np.linalg.qr(rng.normal(size=(3, 3)))[0]
    A, C = np.array([[1, 0, 0], [1, 1, 0], [0, 0, 0.5]]), np.array([[1.0, 0, 1]])
    (mode,) = hidden_modes(T.T @ A @ T, C @ T, 1 - UNIT_TOL)
    assert abs(mode - 1) < 1e-9


@pytest.mark.parametrize("apart, seen", [(1e-8, True), (1e-12, False)])
def test_modes_that_one_output_can_hardly_tell_apart(apart, seen):
    A, C = np.diag([1.5, 1.5 + apart]), np.array([[1.0, 1.0]])
    assert bool(hidden_modes(A, C, 1.0)) != seen


def test_states_without_a_way_to_an_output():
    A = np.array([[0.5, 1e9, 0], [0, 2.0, 0], [1, 1, -3.0]])
    assert hidden_modes(A, np.array([[1.0, 0, 0]]), 1.0) == [-3.0]
    assert sorted(hidden_modes(A, np.zeros((0, 3)), 1.0)) == [-3.0, 2.0]


@pytest.mark.parametrize("seed", range(5))
def test_modes_that_all_decay_are_told_by_powers(seed):
    """Never of one that does not, however far rounding moves a power."""
    rng = np.random.default_rng(seed)
    told = 0
    for n in (1, 2, 3, 8, 30):
        for radius in (0.0, 0.5, 0.95, 0.999, 1.0, 1.001, 1.5):
            for units in (1.0, 1e4, 1e12):
                A = rng.normal(size=(n, n))
                A *= radius / np.abs(np.linalg.eigvals(A)).max()
                scale = units ** np.linspace(0, 1, n)
                found = dies_out(A / scale * scale[:, None])
                assert not found or radius < 1
                told += found
    assert told >= 20


@pytest.mark.parametrize("a", [10, 1e3, 1e6, 1e9, 1e12, 1e15])
def test_a_square_that_rounding_makes_small_says_nothing(a):
    """Its exact square is four times the identity, beside terms as large as a^2."""
    assert not dies_out(np.array([[a, a - 2], [-a - 2, -a]]))


def test_powers_of_no_state_and_of_states_that_overflow():
    assert dies_out(np.zeros((0, 0)))
    assert dies_out(np.array([[0, 1e5], [0, 0]]))
    assert not dies_out(np.full((2, 2), 1e200))
