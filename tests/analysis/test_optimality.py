"""`optimality`: what it measures is right, and every kind of fault shows."""

import functools
from dataclasses import fields, replace

import generators
import numpy as np
import pytest
import scipy.linalg
from fixed_order_plants import STABLE, made, noisy

import luenberger as lb
from luenberger.papers.haddad_bernstein.design import fixed_order_search

MEASURED = ("F", "D", "P", "V", "riccati", "estimate", "adjoint", "idempotent")


@functools.cache
def designed(seed=1, order=2, noises=2, **options):
    plant = noisy(seed, 5, 2, noises=noises, m=1)
    return plant, lb.fixed_order_filter(plant, order, starts=2, **options)


def moment(observer, plant):
    """E[s s'] of s = [x; z], by one Kronecker system."""
    n, r = plant.n, observer.order
    systems = [(plant.A, plant.C, observer.F)]
    systems += [(A1, C1, np.zeros((r, r))) for A1, C1 in plant.multiplicative]
    whole = [
        np.block([[A, np.zeros((n, r))], [observer.D @ C, F]]) for A, C, F in systems
    ]
    H = np.block([[np.eye(n), np.zeros((n, plant.p))], [np.zeros((r, n)), observer.D]])
    V = H @ np.block([[plant.Q, plant.S], [plant.S.T, plant.R]]) @ H.T
    left = np.eye((n + r) ** 2) - sum(np.kron(M, M) for M in whole)
    return np.linalg.solve(left, V.ravel()).reshape(n + r, n + r)


def cost(observer, plant, weight):
    """(3.5) from that moment, noise by noise."""
    X = moment(observer, plant)
    V, R = observer.V, plant.R
    total = V @ R @ V.T
    for k, C in enumerate([plant.C, *(C1 for _, C1 in plant.multiplicative)]):
        miss = np.hstack([observer.L - V @ C, -observer.P])
        if k:
            miss = np.hstack([-V @ C, 0 * observer.P])
        total = total + miss @ X @ miss.T
    return np.trace(weight @ total)


@pytest.mark.parametrize("noises", [0, 1, 2])
def test_cost_of_any_observer(noises):
    plant = noisy(1, 5, 2, noises=noises, m=1)
    weight = np.diag([1.0, 2, 3, 4, 5])
    rng = np.random.default_rng(0)
    o = lb.Observer(
        F=generators.dynamics(rng, 3, 0.8), G=np.zeros((3, 1)),
        D=rng.normal(size=(3, 2)), P=rng.normal(size=(5, 3)),
        V=rng.normal(size=(5, 2)), T=rng.normal(size=(3, 5)), L=np.eye(5), dt=1.0,
    )  # fmt: skip
    found = lb.optimality(o, plant, weight=weight)
    assert found.cost == pytest.approx(cost(o, plant, weight), rel=1e-12)
    assert found.trace > 0.1 and found.worst > 0.1


@pytest.mark.parametrize("noises", [0, 2])
@pytest.mark.parametrize("feedthrough", [True, False])
def test_optimum_meets_every_condition(feedthrough, noises):
    plant, o = designed(noises=noises, feedthrough=feedthrough)
    found = lb.optimality(o, plant)
    assert found.worst < 1e-12
    assert set(found.residuals) == {
        *MEASURED[:3], *MEASURED[4:], "aligned", "trace", *("V" if feedthrough else ())
    }  # fmt: skip
    assert found.cost == pytest.approx(cost(o, plant, np.eye(5)), rel=1e-12)
    tau, G, Gam = found.tau, found.G, found.Gam
    assert np.abs(Gam @ G.T - np.eye(2)).max() < 1e-12
    assert np.abs(tau - G.T @ Gam).max() < 1e-12
    assert np.abs(Gam - o.T).max() < 1e-8 * np.abs(o.T).max()
    assert np.abs((np.eye(5) - o.V @ plant.C) @ G.T - o.P).max() < 1e-10
    X = moment(o, plant)
    Q1, Q12, Q2 = X[:5, :5], X[:5, 5:], X[5:, 5:]
    assert np.abs(found.Q - Q1 + Q12 @ np.linalg.solve(Q2, Q12.T)).max() < 1e-12
    lifted = tau @ found.Qh @ tau.T
    assert np.abs(found.Q + lifted - Q1).max() < 1e-10 * np.abs(Q1).max()
    for name in ("tau", "Qh", "Ph"):
        assert np.linalg.matrix_rank(tau @ found.Qh, 1e-8) == 2, name


@pytest.mark.parametrize("name", ["F", "D", "P", "V"])
@pytest.mark.parametrize("size", [1e-2, 1e-5])
def test_a_wrong_matrix_shows_in_proportion(name, size):
    plant, o = designed()
    value = getattr(o, name)
    noise = np.random.default_rng(3).normal(size=value.shape)
    wrong = replace(o, **{name: value + size * noise})
    found = lb.optimality(wrong, plant)
    assert 0.02 * size < getattr(found, name) < 50 * size
    assert found.worst > 0.02 * size
    assert found.cost > lb.optimality(o, plant).cost
    with pytest.raises(lb.CertificateError, match="not optimal at its order.*starts"):
        found.require()


def test_residuals_of_the_equations_as_printed():
    """(3.14)-(3.16), typed in, at an estimator that misses them all."""
    plant, o = designed()
    wrong = replace(o, F=0.9 * o.F, D=1.1 * o.D)
    found = lb.optimality(wrong, plant)
    A, C, V, eye = plant.A, plant.C, wrong.V, np.eye(5)
    Q1 = moment(wrong, plant)[:5, :5]
    pairs, tau = plant.multiplicative, found.tau
    Q, Qh, Ph = found.Q, found.Qh, found.Ph
    V1 = plant.Q + sum(Ai @ Q1 @ Ai.T for Ai, _ in pairs)
    V12 = plant.S + sum(Ai @ Q1 @ Ci.T for Ai, Ci in pairs)
    V2 = plant.R + sum(Ci @ Q1 @ Ci.T for _, Ci in pairs)
    Qs, V2s = A @ Q @ C.T + V12, C @ Q @ C.T + V2
    K = Qs @ np.linalg.inv(V2s)
    free, missed = (eye - tau), eye - V @ C
    unit = np.sqrt(np.diag(Q1))
    for name, residual, size, power in (
        ("riccati", A @ Q @ A.T + V1 - K @ Qs.T + free @ Qh @ free.T - Q, Q1, -1),
        ("estimate", A @ tau @ Qh @ tau.T @ A.T + K @ Qs.T - Qh, Qh, -1),
        (
            "adjoint",
            (A - K @ C).T @ tau.T @ Ph @ tau @ (A - K @ C) + missed.T @ missed - Ph,
            Ph,
            1,
        ),
    ):
        scale = np.outer(unit**power, unit**power)
        wanted = np.linalg.norm(residual * scale) / np.linalg.norm(size * scale)
        assert getattr(found, name) == pytest.approx(wanted, rel=1e-8), name
    left, right = tau @ Qh - Qh @ tau.T, Ph @ tau - tau.T @ Ph
    both = (
        np.linalg.norm(left / np.outer(unit, unit))
        / np.linalg.norm(Qh / np.outer(unit, unit)),
        np.linalg.norm(right * np.outer(unit, unit))
        / np.linalg.norm(Ph * np.outer(unit, unit)),
    )
    assert found.aligned == pytest.approx(max(both), rel=1e-8)


@pytest.mark.parametrize("m1", [0, 1, 2])
def test_exact_filters(m1):
    """The Kalman filter is optimal at its order, that of Leondes and Novak is not."""
    plant = generators.plant(np.random.default_rng(m1), 5, 2)
    o = lb.reduced_order_filter(plant, m1)
    found = lb.optimality(o, plant)
    assert found.cost == pytest.approx(lb.error_covariance(o, plant).trace(), rel=1e-11)
    if m1 == 0:
        assert found.worst < 1e-11 and found.require() is found
        assert np.abs(found.tau - np.eye(5)).max() < 1e-9
    else:
        assert found.worst > 1e-3


def test_optimum_that_ignores_the_multiplicative_noise_is_none():
    plant, _ = designed()
    quiet = replace(plant, multiplicative=())
    o = lb.fixed_order_filter(quiet, 2, starts=2)
    assert lb.optimality(o, quiet).worst < 1e-12 < 1e-4 < lb.optimality(o, plant).worst


def test_other_weight_other_optimum():
    plant, _ = designed()
    weight = np.diag([1.0, 10, 1, 1, 5])
    o = lb.fixed_order_filter(plant, 2, weight=weight, starts=2)
    assert lb.optimality(o, plant, weight=weight).worst < 1e-12
    assert lb.optimality(o, plant).worst > 1e-4


def test_without_feedthrough_v_is_not_asked():
    plant, o = designed(feedthrough=False)
    assert lb.optimality(o, plant).V is None
    free = lb.optimality(o, plant, feedthrough=True)
    assert free.V > 1e-3 and max(free.F, free.D, free.P) < 1e-12
    with pytest.raises(ValueError, match="feedthrough=False, but the observer's V"):
        lb.optimality(lb.kalman_filter(quiet(plant)), quiet(plant), feedthrough=False)


def quiet(plant):
    return replace(plant, multiplicative=())


def test_states_that_are_silent_or_unused():
    """Q2 and P2 singular: two states never move, and one of them is not asked for."""
    plant = made(
        np.diag([0.9, 0.5, 0.3, 0.2]),
        [[1, 0, 1, 0]],
        Q=np.diag([1, 1, 0, 0]),
        R=[[1]],
        S=np.zeros((4, 1)),
    )
    for L in (np.eye(4), np.eye(4)[:1]):
        found = fixed_order_search(plant, 4, L=L).best
        assert found.optimality.worst < 1e-12
        assert np.abs(found.optimality.tau - np.eye(4)).max() < 1e-12
        wrong = replace(found.observer, D=found.observer.D + 0.1)
        assert lb.optimality(wrong, plant).worst > 1e-3


def test_the_best_estimate_without_states_meets_every_condition():
    plant = quiet(designed()[0])
    X = scipy.linalg.solve_discrete_lyapunov(plant.A, plant.Q)
    C, none = plant.C, np.zeros((0, 0))
    V = np.linalg.solve(C @ X @ C.T + plant.R, C @ X).T
    o = lb.Observer(
        none, np.zeros((0, plant.m)), np.zeros((0, plant.p)), np.zeros((plant.n, 0)), V,
        T=np.zeros((0, plant.n)), L=np.eye(plant.n), W=-V @ plant.E, dt=plant.dt,
    )  # fmt: skip
    found = lb.optimality(o, plant)
    assert found.worst < 1e-12
    assert found.cost == pytest.approx(np.trace(X - V @ C @ X), rel=1e-12)
    assert lb.optimality(replace(o, V=1.1 * V), plant).V > 1e-3


@pytest.mark.parametrize("size", [1e-5, 1e5])
def test_units_play_no_part(size):
    plant, o = designed()
    wrong = replace(o, F=0.9 * o.F)
    X, Y, Z = np.array([1, size, 1, 1 / size, 1]), np.array([size, 1]), [1, size]
    Z = np.array(Z)
    scaled = replace(
        plant,
        A=plant.A * X[:, None] / X,
        B=plant.B * X[:, None],
        C=plant.C * Y[:, None] / X,
        E=plant.E * Y[:, None],
        Q=plant.Q * X[:, None] * X,
        R=plant.R * Y[:, None] * Y,
        S=plant.S * X[:, None] * Y,
        P0=plant.P0 * X[:, None] * X,
        multiplicative=[
            (A1 * X[:, None] / X, C1 * Y[:, None] / X)
            for A1, C1 in plant.multiplicative
        ],
    )
    other = replace(
        wrong, F=wrong.F * Z[:, None] / Z, G=wrong.G * Z[:, None],
        D=wrong.D * Z[:, None] / Y, P=wrong.P / Z, V=wrong.V / Y,
        T=wrong.T * Z[:, None] / X, T0=None, L=wrong.L / X,
    )  # fmt: skip
    one, two = lb.optimality(wrong, plant), lb.optimality(other, scaled)
    for name, value in one.residuals.items():
        assert two.residuals[name] == pytest.approx(value, rel=1e-6), name
    assert two.cost == pytest.approx(one.cost, rel=1e-10)
    for name, scale in (
        ("tau", X[:, None] / X),
        ("Q", X[:, None] * X),
        ("Qh", X[:, None] * X),
        ("Ph", 1 / X[:, None] / X),
        ("G", X / Z[:, None]),
        ("Gam", Z[:, None] / X),
    ):
        wanted = getattr(one, name) * scale
        gap = np.abs((getattr(two, name) - wanted) / scale).max()
        assert gap < 1e-7 * np.abs(getattr(one, name)).max(), name


def test_the_first_condition_that_is_missed_is_named():
    plant, o = designed()
    found = lb.optimality(o, plant)
    assert found.require(1e-10) is found
    for field in fields(found):
        if field.name in found.residuals:
            spoilt = replace(found, **{field.name: np.nan})
            with pytest.raises(lb.CertificateError, match=r"\(\d\.\d+\)"):
                spoilt.require()
            with pytest.raises(lb.CertificateError, match="is missed by 1.0e-03"):
                replace(found, **{field.name: 1e-3}).require()


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"A": [[1.1, 0], [0, 0.5]]}, "not mean-square stable"),
        ({"R": None}, "needs both noise covariances"),
        ({"A": [[0.5, 0.1j], [0, 0.2]]}, "complex"),
        ({"multiplicative": [(1.2 * np.eye(2), [[0, 0]])]}, "not mean-square stable"),
    ],
)
def test_plants_without_a_cost(changes, message):
    o = lb.fixed_order_filter(made(**STABLE), 1, starts=2)
    with pytest.raises(lb.DesignError, match=message):
        lb.optimality(o, made(**(STABLE | changes)))


@pytest.mark.parametrize(
    "wrong, options, error, message",
    [
        (lambda o: replace(o, F=[[1.5]]), {}, lb.DesignError, "the mode 1.5 on or out"),
        (lambda o: replace(o, dt=0.0), {}, ValueError, "dt=0"),
        (lambda o: o, {"weight": np.eye(3)}, ValueError, "weight must be 2 x 2"),
        (lambda o: o, {"weight": -np.eye(2)}, ValueError, "positive semi-definite"),
        (lambda o: o, {"feedthrough": "no"}, ValueError, "feedthrough must be True"),
    ],
)
def test_observers_without_a_cost(wrong, options, error, message):
    plant = made(**STABLE)
    o = lb.fixed_order_filter(plant, 1, starts=2)
    with pytest.raises(error, match=message):
        lb.optimality(wrong(o), plant, **options)
    late = lb.kalman_filter(replace(plant, P0=np.eye(2)), steps=3)
    with pytest.raises(lb.DesignError, match="constant observer"):
        lb.optimality(late, plant)
    still = lb.Plant(STABLE["A"], None, STABLE["C"])
    with pytest.raises(lb.DesignError, match="for discrete time"):
        lb.optimality(replace(o, dt=0.0), still)
