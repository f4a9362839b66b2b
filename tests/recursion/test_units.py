"""Units play no part: a plant in any units of states and outputs, the same filter.

Units are powers of two, up to 1e13, so that the two plants are exactly the same.
"""

from dataclasses import replace

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.recursion import units
from luenberger.recursion.settings import setting


def in_units(plant, states, outputs):
    """The plant whose state is states * x and whose output is outputs * y."""
    x, y = states[:, None], outputs[:, None]
    return replace(
        plant, A=x * plant.A / states, B=x * plant.B, C=y * plant.C / states,
        E=y * plant.E, Q=x * plant.Q * states, R=y * plant.R * outputs,
        S=None if plant.S is None else x * plant.S * outputs,
        P0=x * plant.P0 * states, x0=states * plant.x0,
    )  # fmt: skip


def drawn(rng, n, p, most=44):
    return 2.0 ** rng.integers(-most, most + 1, n), 2.0 ** rng.integers(-most, most, p)


def sparse(rng, n, p):
    """A plant with many zeros, modes that do not decay, and singular noise."""
    A = rng.integers(-3, 4, (n, n)) * (rng.random((n, n)) < 0.5) / 2
    A = np.triu(A) + np.diag(rng.choice([0.0, 0.5, 0.5, 0.0], n))
    C, H = rng.integers(-2, 3, (p, n)), rng.integers(-2, 3, (n, 1)) / 2
    return lb.Plant(
        A, None, C, dt=1.0, Q=H @ H.T, R=np.diag(rng.choice([0.25, 1.0, 4.0], p)),
        P0=np.eye(n),
    )  # fmt: skip


def dense(rng, n, p):
    return generators.plant(rng, n, p, m=0, rank=n + p)


DESIGNS = {
    "Kalman": lambda plant, W: lb.kalman_filter(plant),
    "reduced": lambda plant, W: lb.reduced_order_filter(plant, 1, weight=W),
    "best constant gain": lambda plant, W: lb.reduced_order_filter(
        plant, 1, weight=W, horizon="steady"
    ),
    "over steps": lambda plant, W: lb.reduced_order_filter(
        plant, 1, weight=W, steps=6
    ),
}  # fmt: skip


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS.keys())
@pytest.mark.parametrize("make", [dense, sparse])
def test_a_filter_is_the_same_in_any_units(design, make):
    """Or is refused in all of them."""
    designed = 0
    for seed in range(8):
        rng = np.random.default_rng(seed)
        n, p = rng.integers(2, 5), rng.integers(1, 3)
        plant = make(rng, n, p)
        states, outputs = drawn(rng, n, p)
        other = in_units(plant, states, outputs)
        found = []
        for one, x in ((plant, np.ones(n)), (other, states)):
            try:
                observer = design(one, np.eye(n) / np.outer(x, x))
            except lb.DesignError as refusal:
                found.append(str(refusal)[:20])
                continue
            steps = observer.steps
            P = lb.error_covariance(observer, one, steps=steps) / np.outer(x, x)
            found.append(P if steps is None else P[-1])
        a, b = found
        assert isinstance(a, str) == isinstance(b, str), (seed, found)
        if isinstance(a, str):
            continue
        designed += 1
        np.testing.assert_allclose(b, a, rtol=0, atol=1e-9 * np.abs(a).max())
    assert designed > 4


def test_the_best_constant_gain_is_not_left_to_the_units():
    """It was the step-wise gain, 17 % worse, for states in units 1e10 apart."""
    A = np.array([[-0.625, 1, 0], [0, -0.625, 0], [0, 0, -0.625]])
    Q = np.array([[13, 5, 3], [5, 2, 1], [3, 1, 1]]) / 16
    weight = np.array([[9.0, 0, 0], [0, 10, -5], [0, -5, 4]])
    plant = lb.Plant(A, None, [[0, 1, 0]], dt=1.0, Q=Q, R=[[0.25]], P0=np.eye(3))
    x = np.array([2.0**20, 2.0**-16, 2.0**-20])
    for one, W in (
        (plant, weight),
        (in_units(plant, x, np.array([2.0**18])), weight / np.outer(x, x)),
    ):
        found = lb.reduced_order_filter(one, 1, weight=W, horizon="steady")
        cost = np.trace(W @ lb.error_covariance(found, one))
        assert cost == pytest.approx(11.888023654749, rel=1e-11)


def test_a_velocity_in_light_years_is_detectable():
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=[[0.25, 0.5], [0.5, 1]], R=[[1]],
        P0=np.eye(2),
    )  # fmt: skip
    alpha_beta = [[0.75], [0.5]]  # Kalata (1984)
    for size in (1e-16, 1e-12, 1e12, 1e16):
        x = np.array([1.0, size])
        found = lb.kalman_filter(in_units(plant, x, np.ones(1)))
        np.testing.assert_allclose(found.V / x[:, None], alpha_beta, rtol=1e-12)


@pytest.mark.filterwarnings("error")
def test_units_that_only_an_exponent_holds():
    """An output of 1e200, and covariances of 1e300 and 1e-300."""
    A = [[0.5, 0.1], [0, 0.6]]
    plant = lb.Plant(A, None, [[1e200, 1]], dt=1.0, Q=np.eye(2), R=[[1]])
    found = lb.kalman_filter(plant)
    np.testing.assert_allclose(found.V[0], 1e-200, rtol=1e-12)
    assert lb.certify(found, plant).worst < 1e-14
    for size, m1 in ((1e160, 0), (1e300, 0), (1e300, 1)):
        gains = []
        for one in (1.0, size):
            C, R = [[one, 0]], [[0.0]]
            plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(2), R=R)
            best = lb.reduced_order_filter(plant, m1, horizon="steady")
            gains.append(best.V[:, 0] * one)
        np.testing.assert_allclose(gains[1], gains[0], rtol=1e-9)
    gains = []
    for size in (1e-300, 1.0, 1e300):
        Q, R = size * np.eye(2), [[size]]
        plant = lb.Plant(A, None, [[1, 0]], dt=1.0, Q=Q, R=R)
        gains.append(lb.reduced_order_filter(plant, 1, horizon="steady").V)
    np.testing.assert_allclose(gains, np.broadcast_to(gains[1], (3, 2, 1)), rtol=1e-9)


@pytest.mark.parametrize("T", [1e-6, 0.1, 2.0])
def test_a_plant_is_discretised_in_any_units(T):
    """Q had lost five digits where the units are 1e13 apart."""
    rng = np.random.default_rng(2)
    for _ in range(10):
        A, B = rng.integers(-3, 4, (3, 3)), rng.integers(-3, 4, (3, 2))
        H = rng.integers(-2, 3, (3, 1))
        x, u = 2.0 ** rng.integers(-26, 27, 3), 2.0 ** rng.integers(-26, 27, 2)
        y = x[:, None]
        one = lb.Plant(A, B, [[1, 0, 0]], Q=H @ H.T, R=[[1]])
        other = replace(one, A=y * A / x, B=y * B / u, Q=y * one.Q * x, C=one.C / x)
        one, other = (lb.sampling.discretise(plant, [T]) for plant in (one, other))
        for name, left, right in (("A", x, x), ("B", x, u), ("Q", x, 1 / x)):
            wanted = getattr(one, name)[0]
            found = getattr(other, name)[0] / left[:, None] * right
            np.testing.assert_allclose(
                found, wanted, rtol=0, atol=1e-13 * np.abs(wanted).max()
            )


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")
def test_a_certificate_whose_terms_overflow_is_none():
    """Its residual would be divided by infinity and look perfect."""
    big = 1e200
    observer = lb.Observer(
        [[0.5]], np.zeros((1, 0)), [[big]], [[1]], [[0]], T=[[1]], L=[[1]], dt=1.0
    )
    plant = lb.Plant([[0.5]], None, [[big]], dt=1.0)
    with pytest.raises(lb.CertificateError, match="dynamics residual is nan"):
        lb.certify(observer, plant).require()


def test_without_noise_the_gain_of_least_norm_is_zero():
    """A stable plant that nothing disturbs: the recursion ended in NaN."""
    A = [[0.625, 0, 0], [0, 0.625, 0], [-0.5, -0.5, 0.375]]
    plant = lb.Plant(A, None, [[0, 1, -2]], dt=1.0, Q=np.zeros((3, 3)), R=[[0]])
    observer = lb.kalman_filter(plant)
    assert not observer.V.any() and not lb.error_covariance(observer, plant).any()


def test_two_plants_side_by_side_are_each_solved_to_their_own_size():
    """One has a billion times the other's deviations; neither knows of the other."""
    rng = np.random.default_rng(5)
    small, large = (replace(dense(rng, 2, 1), S=None) for _ in range(2))
    alone = lb.kalman_filter(small)
    for size in (1e-9, 1e9):
        block = {
            name: np.block(
                [[getattr(small, name), 0 * getattr(small, name)],
                 [0 * getattr(small, name), factor * getattr(large, name)]]
            )
            for name, factor in (("A", 1), ("C", 1), ("Q", size**2), ("R", size**2))
        }  # fmt: skip
        both = lb.Plant(block["A"], None, block["C"], dt=1.0, Q=block["Q"],
                        R=block["R"])  # fmt: skip
        found = lb.kalman_filter(both)
        np.testing.assert_allclose(found.V[:2, :1], alone.V, rtol=1e-11)
        P = lb.error_covariance(found, both)[:2, :2]
        wanted = lb.error_covariance(alone, small)
        np.testing.assert_allclose(P, wanted, rtol=1e-11)


def test_a_filter_is_as_far_from_the_best_in_any_units():
    """Also beside states that no noise reaches, and for estimates in light years."""
    measured = 0
    for seed in range(30):
        rng = np.random.default_rng([5, seed])
        n, p = rng.integers(2, 5), rng.integers(1, 3)
        A, C = rng.integers(-3, 4, (n, n)) / 8, rng.integers(-2, 3, (p, n))
        A[: n // 2, n // 2 :] = A[n // 2 :, : n // 2] = 0
        H = rng.integers(-2, 3, (n, 1)) / 2
        plant = lb.Plant(A, None, C, dt=1.0, Q=H @ H.T, R=np.eye(p), P0=np.eye(n))
        others = A - np.diag(A.diagonal())
        alone = ~np.vstack([others, others.T, C, H.T]).any(axis=0)
        if alone.any() or np.abs(np.linalg.eigvals(A)).max() > 0.95:
            continue
        x, y = drawn(rng, n, p)
        best = lb.kalman_filter(plant)
        for one in (best, replace(best, D=best.D * 1.001)):
            other = replace(
                one, D=one.D / y, P=one.P * x[:, None], T=one.T / x,
                V=one.V * x[:, None] / y,
            )  # fmt: skip
            a = lb.optimality(one, plant).residuals
            b = lb.optimality(
                other, in_units(plant, x, y), weight=np.eye(n) / np.outer(x, x)
            ).residuals
            measured += 1
            assert b == pytest.approx(a, rel=1e-6, abs=1e-11), seed
    assert measured > 20


def test_a_setting_in_other_units_is_that_of_the_plant_in_them():
    """Every matrix of it, the sizes that rounding is judged by among them."""
    plant = lb.Plant(
        [[0.5, 1], [-0.25, 0.75]], None, [[1, 0], [1, 2]], dt=1.0, Q=np.eye(2),
        R=np.diag([1.0, 4]), S=[[0.5, 0.25], [0, 1]], P0=np.eye(2),
    )  # fmt: skip
    states, outputs = np.array([8.0, 0.5]), np.array([2.0, 16])
    moved = in_units(plant, 1 / states, 1 / outputs)
    now, wanted = (setting(one, [0]) for one in (plant, moved))
    found = units.in_units(now, states, outputs)
    for name in ("A", "C", "Q", "R", "J", "V", "deviation", "As", "Qs", "Gamma"):
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name), name)
    for name in ("A", "Q", "size"):
        one, other = (getattr(x.move, name) for x in (found, wanted))
        np.testing.assert_array_equal(one, other, name)


def test_the_unit_of_a_state_that_nothing_touches_changes_no_verdict():
    """Its residuals are of the user's unit, and zero or not in all of them."""
    judged = 0
    for seed in range(12):
        rng = np.random.default_rng([77, seed])
        A, H = np.zeros((3, 3)), np.zeros((3, 1))
        A[:2, :2], A[2, 2] = rng.integers(-3, 4, (2, 2)) / 8, 0.5
        H[:2], C = rng.integers(1, 3, (2, 1)), np.array([[1.0, -1, 0]])
        plant = lb.Plant(A, None, C, dt=1.0, Q=H @ H.T, R=[[1]], P0=np.eye(3))
        best = lb.kalman_filter(plant)
        if not best.D.any():  # no gain to make worse
            continue
        judged += 1
        for one, optimal in ((best, True), (replace(best, D=best.D * 1.001), False)):
            for size in (2.0**-40, 1.0, 2.0**40):
                x = np.array([1.0, 1.0, size])
                other = replace(one, P=one.P * x[:, None], T=one.T / x,
                                V=one.V * x[:, None])  # fmt: skip
                moved, W = in_units(plant, x, np.ones(1)), np.diag(x**-2)
                found = lb.optimality(other, moved, weight=W).residuals
                worst = max(value or 0 for value in found.values())
                assert (worst < 1e-9) == optimal, (seed, size)
    assert judged > 8
