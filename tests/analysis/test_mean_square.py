"""Second moments under multiplicative noise, against Kronecker products."""

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis import mean_square
from luenberger.numeric.covariance_maps import Sums, dominant, packing

SIZES = [1, 2, 3, 5, 8, 9, 12]  # dense up to 8 states, Arnoldi's iteration above


def noisy(seed, n, *, noises=2, radius=0.9, strength=0.2):
    """A stable A, pairs (A_i, C_i), and the covariance of an additive noise."""
    rng = np.random.default_rng(seed)
    A = generators.dynamics(rng, n, radius)
    size = strength / np.sqrt(n * max(noises, 1))
    pairs = [
        (size * rng.normal(size=(n, n)), rng.normal(size=(2, n))) for _ in range(noises)
    ]
    half = rng.normal(size=(n, n))
    return A, pairs, half @ half.T


def kronecker(A, pairs):
    return np.kron(A, A) + sum(np.kron(A1, A1) for A1, _ in pairs)


def solved_densely(A, pairs, V):
    n = len(A)
    return np.linalg.solve(np.eye(n * n) - kronecker(A, pairs), V.ravel()).reshape(n, n)


def scaled(pairs, s):
    return [(s * A1, C1) for A1, C1 in pairs]


def dense_radius(A, pairs):
    return np.abs(np.linalg.eigvals(kronecker(A, pairs))).max()


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("noises", [0, 1, 3])
def test_second_moment_is_the_dense_solution(n, noises):
    A, pairs, V = noisy(n, n, noises=noises)
    X = mean_square.second_moment(A, pairs, V)
    wanted = solved_densely(A, pairs, V)
    np.testing.assert_allclose(X, wanted, atol=1e-11 * np.abs(wanted).max())
    np.testing.assert_array_equal(X, X.T)


@pytest.mark.parametrize("n", SIZES)
@pytest.mark.parametrize("noises", [0, 1, 3])
def test_radius_is_the_dense_one(n, noises):
    A, pairs, _ = noisy(n, n, noises=noises)
    found = mean_square.radius(A, pairs)
    assert found == pytest.approx(dense_radius(A, pairs), rel=1e-11)


@pytest.mark.parametrize("n", SIZES)
def test_radius_of_a_plant_that_is_not_stable(n):
    A, pairs, _ = noisy(n, n, radius=1.3, strength=2.0)
    found = mean_square.radius(A, pairs)
    assert found == pytest.approx(dense_radius(A, pairs), rel=1e-11) and found > 1


@pytest.mark.parametrize("n", SIZES)
def test_largest_scaling_is_where_the_dense_radius_passes_one(n):
    A, pairs, _ = noisy(n, n)
    low, high = 1.0, 100.0
    assert (
        dense_radius(A, scaled(pairs, low)) < 1 < dense_radius(A, scaled(pairs, high))
    )
    for _ in range(30):
        middle = (low + high) / 2
        stable = dense_radius(A, scaled(pairs, middle)) < 1
        low, high = (middle, high) if stable else (low, middle)
    assert mean_square.largest_scaling(A, pairs) == pytest.approx(low, rel=1e-6)


@pytest.mark.parametrize("n", [4, 12])
def test_close_to_the_limit_the_equation_still_holds(n):
    A, pairs, V = noisy(n, n)
    pairs = scaled(pairs, (1 - 1e-8) * mean_square.largest_scaling(A, pairs))
    X = mean_square.second_moment(A, pairs, V)
    gap = V + A @ X @ A.T + sum(A1 @ X @ A1.T for A1, _ in pairs) - X
    assert np.abs(gap).max() < 1e-13 * np.abs(X).max()
    assert np.linalg.eigvalsh(X)[0] > 0 and np.trace(X) > 1e6 * np.trace(V)


@pytest.mark.parametrize("factor", [1.001, 3.0], ids=["just above", "far above"])
@pytest.mark.parametrize("n", [4, 12])
def test_above_the_limit_it_is_refused(n, factor):
    A, pairs, V = noisy(n, n)
    limit = mean_square.largest_scaling(A, pairs)
    pairs = scaled(pairs, factor * limit)
    wanted = (
        f"spectral radius of .* is {dense_radius(A, pairs):.6g}.*"
        f"less than {1 / factor:.6g} times"
    )
    with pytest.raises(lb.DesignError, match=wanted):
        mean_square.second_moment(A, pairs, V)


def test_an_unstable_mode_is_named():
    A = np.diag([0.5, -1.25, 0.3])
    with pytest.raises(lb.DesignError, match="A itself has the mode -1.25 on or outsi"):
        mean_square.second_moment(A, [], np.eye(3))
    assert mean_square.largest_scaling(A, []) == 0


def test_noise_that_never_feeds_back_may_have_any_strength():
    for n in (4, 12):
        A, above = 0.5 * np.eye(n), np.triu(np.ones((n, n)), 1)
        pairs = [(above, np.zeros((1, n)))]
        assert mean_square.largest_scaling(A, pairs) == np.inf
        assert mean_square.radius(A, pairs) == 0.25
        X = mean_square.second_moment(A, scaled(pairs, 100), np.eye(n))
        wanted = np.zeros((n, n))  # row by row from the last, which no noise reaches
        for i in reversed(range(n)):
            below = wanted[i + 1 :, i + 1 :].sum()
            wanted[i, i] = (1 + 1e4 * below) / 0.75
            for j in range(i + 1, n):
                more = wanted[i + 1 :, j + 1 :].sum()
                wanted[i, j] = wanted[j, i] = 1e4 * more / 0.75
        spread = np.sqrt(wanted.diagonal())
        assert (np.abs(X - wanted) <= 1e-11 * np.outer(spread, spread)).all()


def test_no_noise_acts_on_the_state():
    A = np.array([[0.5, 1], [0, -0.8]])
    pairs = [(np.zeros((2, 2)), np.ones((1, 2)))]
    assert mean_square.largest_scaling(A, pairs) == np.inf
    assert mean_square.radius(A, pairs) == mean_square.radius(A, []) == 0.8**2


@pytest.mark.parametrize("n", [2, 12])
def test_radius_where_many_eigenvalues_share_it(n):
    """Rotations: A(x)A has eigenvalues all around the circle of its radius."""
    turn = np.array([[0.6, -0.8], [0.8, 0.6]])
    A, pairs = np.kron(np.eye(n // 2), 0.9 * turn), [(0.3 * np.eye(n), None)]
    assert mean_square.radius(A, pairs) == pytest.approx(0.81 + 0.09, rel=1e-13)
    limit = np.sqrt(0.19) / 0.3
    assert mean_square.largest_scaling(A, pairs) == pytest.approx(limit, rel=1e-13)
    A, pairs = np.zeros((n, n)), [(A, None)]  # the noise turns, and nothing else
    assert mean_square.radius(A, pairs) == pytest.approx(0.81, rel=1e-13)
    assert mean_square.largest_scaling(A, pairs) == pytest.approx(1 / 0.9, rel=1e-13)


@pytest.mark.parametrize("n", [5, 15])
def test_radius_of_a_delay_line(n):
    """The noise feeds the end of n delays back to their start."""
    A, back = np.eye(n, k=-1), np.zeros((n, n))
    back[0, -1] = 0.3
    assert mean_square.radius(A, [(back, None)]) == pytest.approx(
        0.09 ** (1 / n), rel=1e-12
    )
    assert mean_square.largest_scaling(A, [(back, None)]) == pytest.approx(1 / 0.3)


@pytest.mark.parametrize("n", [3, 12])
def test_units_of_the_states_play_no_part(n):
    A, pairs, V = noisy(n, n)
    X = mean_square.second_moment(A, pairs, V)
    unit = 10.0 ** np.random.default_rng(n).integers(-7, 8, n)
    there, back = unit[:, None] / unit, unit[:, None] * unit
    turned = [(A1 * there, C1 / unit) for A1, C1 in pairs]
    found = mean_square.second_moment(A * there, turned, V * back) / back
    np.testing.assert_allclose(found, X, atol=1e-12 * np.abs(X).max())
    for question in (mean_square.radius, mean_square.largest_scaling):
        assert question(A * there, turned) == pytest.approx(
            question(A, pairs), rel=1e-9
        )


def test_noise_on_part_of_the_state_leaves_the_rest_at_zero():
    A, pairs = np.diag([0.5, 0.5, 0.9]), [(np.diag([0.3, 0.2, 0.1]), None)]
    X = mean_square.second_moment(A, pairs, np.diag([1.0, 0, 0]))
    np.testing.assert_allclose(X, np.diag([1 / (0.75 - 0.09), 0, 0]), rtol=1e-13)
    assert not mean_square.second_moment(A, pairs, np.zeros((3, 3))).any()
    A = np.diag([0.9, 0.5, 0.3, 0.2])
    X = mean_square.second_moment(A, [], np.diag([1.0, 1, 0, 0]))
    assert not X[2:].any() and not X[:, 2:].any()


def test_same_answer_every_time():
    A, pairs, V = noisy(3, 20)
    for question in (mean_square.radius, mean_square.largest_scaling):
        assert question(A, pairs) == question(A, pairs)
    once, again = (mean_square.second_moment(A, pairs, V) for _ in range(2))
    assert once.tobytes() == again.tobytes()


def test_sixty_states():
    A, pairs, V = noisy(1, 60, radius=0.98)
    X = mean_square.second_moment(A, pairs, V)
    gap = V + A @ X @ A.T + sum(A1 @ X @ A1.T for A1, _ in pairs) - X
    assert np.linalg.norm(gap) < 1e-13 * np.linalg.norm(X)
    s = mean_square.largest_scaling(A, pairs)
    assert mean_square.radius(A, scaled(pairs, s)) == pytest.approx(1, rel=1e-11)


def test_scalar_plant_in_closed_form():
    """a = 1/2 with noise 1/4, c = 1 with noise 1/2, Q = 1, R = 1/2."""
    plant = lb.Plant(
        [[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[0.5]],
        multiplicative=[([[0.25]], [[0]]), ([[0]], [[0.5]])],
    )  # fmt: skip
    found = mean_square.equivalent_noise(plant)
    assert found.X == pytest.approx(16 / 11, rel=1e-14)
    assert found.Q == pytest.approx(1 + 1 / 11, rel=1e-14)
    assert found.R == pytest.approx(1 / 2 + 4 / 11, rel=1e-14) and found.S == 0
    # the Kalman filter of the equivalent plant has the closed-form error
    prior = (39 + np.sqrt(30705)) / 176
    equivalent = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=found.Q, R=found.R)
    observer = lb.kalman_filter(equivalent)
    gain = prior / (prior + found.R[0, 0])
    assert observer.V == pytest.approx(gain, rel=1e-12)
    assert gain == pytest.approx(0.5849584829495541, rel=1e-12)
    posterior = lb.error_covariance(observer, plant)
    assert posterior == pytest.approx(0.5051914170927967, rel=1e-12)


def test_second_moment_of_de_konings_plant():
    """De Koning (1992), scaled by 0.75, without its multiplicative noise."""
    A = np.array([[0.5319, 0.226275], [0.13605, 0.714375]])
    X = mean_square.second_moment(A, [], np.diag([0.5627, 0.7357]))
    wanted = 1.1245761822914373, 0.6306081649229096, 1.7952844264517869
    np.testing.assert_allclose(X[np.triu_indices(2)], wanted, rtol=1e-12)


def test_equivalent_noise_adds_both_cross_terms():
    """Q, S, R are those of the joint covariance with [A_i; C_i] X [A_i; C_i]'."""
    rng = np.random.default_rng(5)
    A, pairs, _ = noisy(6, 3)
    plant = generators.plant(rng, 3, 2, m=0, multiplicative=pairs)
    plant = lb.Plant(A, None, plant.C, dt=1.0, Q=plant.Q, R=plant.R, S=plant.S,
                     multiplicative=pairs)  # fmt: skip
    X, Q, S, R = mean_square.equivalent_noise(plant)
    np.testing.assert_allclose(X, solved_densely(A, pairs, plant.Q), rtol=1e-11)
    both = [np.vstack(pair) for pair in pairs]
    joint = np.block([[plant.Q, plant.S], [plant.S.T, plant.R]])
    joint = joint + sum(M @ X @ M.T for M in both)
    np.testing.assert_allclose(np.block([[Q, S], [S.T, R]]), joint, rtol=1e-12)


def test_without_multiplicative_noise_the_plant_is_its_own_equivalent():
    plant = generators.plant(np.random.default_rng(2), 3, 2, radius=0.8)
    X, Q, S, R = mean_square.equivalent_noise(plant)
    for found, wanted in ((Q, plant.Q), (S, plant.S), (R, plant.R)):
        np.testing.assert_array_equal(found, wanted)
    np.testing.assert_allclose(X, plant.A @ X @ plant.A.T + Q, rtol=1e-12)


@pytest.mark.parametrize(
    "changes, message",
    [
        (dict(A=[[1.2]]), "mode 1.2 on or outside the unit circle"),
        (dict(multiplicative=[([[0.9]], [[0]])]), r"A_i\(x\)A_i is 1.06.*than 0.96225"),
        (dict(A=[[[0.5]]] * 3), "varies in time"),
        (dict(Q=None), "covariances Q and R"),
        (dict(R=None), "covariances Q and R"),
        (dict(dt=0), "dt > 0"),
    ],
    ids=["unstable", "too much noise", "time-varying", "no Q", "no R", "continuous"],
)
def test_plants_without_equivalent_noise(changes, message):
    given = dict(A=[[0.5]], B=None, C=[[1]], dt=1.0, Q=[[1]], R=[[1]]) | changes
    with pytest.raises(lb.DesignError, match=message):
        mean_square.equivalent_noise(lb.Plant(**given))


def test_packing_keeps_lengths_and_comes_back():
    pack, unpack = packing(4)
    half = np.random.default_rng(0).normal(size=(3, 4, 4))
    X = half @ half.mT
    np.testing.assert_allclose(unpack(pack(X)), X, rtol=1e-15)
    lengths = np.linalg.norm(X, axis=(1, 2))
    np.testing.assert_allclose(np.linalg.norm(pack(X), axis=1), lengths, rtol=1e-14)


def test_sums_of_powers():
    A = generators.dynamics(np.random.default_rng(1), 4, 0.97)
    X, total, power = np.diag([1.0, 2, 0, 0]), np.zeros((4, 4)), np.eye(4)
    for _ in range(1500):
        total, power = total + power @ X @ power.T, A @ power
    np.testing.assert_allclose(Sums(A)(X), total, rtol=1e-11)


def test_radius_of_a_map_that_takes_everything_to_zero():
    shift = np.eye(12, k=1)
    assert dominant(lambda X: shift @ X @ shift.T, 12) == 0
