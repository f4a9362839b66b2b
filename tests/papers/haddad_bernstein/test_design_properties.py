"""What must hold of fixed-order filters whatever the plant."""

from dataclasses import replace

import generators
import numpy as np
import pytest
import raw_fixed_order as plain

import luenberger as lb
from luenberger.papers.haddad_bernstein.design import fixed_order_search


@pytest.mark.parametrize("seed", [0, 1, 11, 35])
def test_gradient_of_the_independent_code(seed):
    """The yardstick itself, against differences."""
    plant, order, L, feedthrough = plain.random_problem(seed)
    raw = plain.Raw(plant, order, L, feedthrough)
    rng = np.random.default_rng(seed)
    parts = [0.1 * rng.normal(size=s) for s in ((order, order), (order, plant.p))]
    parts += [rng.normal(size=(len(L), k)) for k in (order, plant.p)]
    x = raw.join(*parts)
    along = rng.normal(size=x.shape)
    wanted = (raw(x + 1e-5 * along)[0] - raw(x - 1e-5 * along)[0]) / 2e-5
    assert raw(x)[1] @ along == pytest.approx(wanted, rel=1e-6)


@pytest.mark.parametrize("seed", [1, 6, 18, 31, 59])
def test_never_above_random_descents_on_the_raw_parameters(seed):
    """Five problems, with several minima."""
    plant, order, L, feedthrough = plain.random_problem(seed)
    raw = plain.Raw(plant, order, L, feedthrough)
    options = dict(feedthrough=feedthrough, starts=12)
    found = fixed_order_search(plant, order, L=L, **options)
    cost = raw.of(*plain.parameters(found.best.observer))
    assert cost == pytest.approx(found.best.cost, rel=1e-10)
    assert cost <= plain.baseline(raw, runs=6) * (1 + 1e-7)
    for one in found.minima:
        assert one.optimality.worst < 1e-8
        _, gradient = raw(raw.join(*plain.parameters(one.observer)))
        assert np.linalg.norm(gradient) < 1e-8 * np.linalg.norm(plant.Q)


@pytest.mark.parametrize("seed, horizon", [(0, "step"), (1, "steady"), (2, "step")])
def test_never_above_leondes_and_novak(seed, horizon):
    """Their filter is one of the estimators of its order, L = I."""
    plant = generators.plant(np.random.default_rng(seed), 5, 3, m=0)
    for m1 in (1, 2, 3):
        theirs = lb.reduced_order_filter(plant, m1, horizon=horizon)
        ours = fixed_order_search(plant, 5 - m1, starts=3).best
        assert ours.cost <= lb.error_covariance(theirs, plant).trace() * (1 + 1e-12)


@pytest.mark.parametrize("seed, feedthrough", [(3, True), (5, False)])
def test_cost_falls_with_the_order(seed, feedthrough):
    plant, *_ = plain.random_problem(seed)
    options = dict(feedthrough=feedthrough, starts=4)
    costs = [
        fixed_order_search(plant, order, **options).best.cost
        for order in range(1, plant.n + 1)
    ]
    assert (np.diff(costs) < 0).all()


@pytest.mark.parametrize("seed", range(2))
def test_coordinates_of_the_plant_play_no_part(seed):
    rng = np.random.default_rng(seed)
    plant = generators.plant(rng, 5, 2, radius=0.9)
    change = np.linalg.qr(rng.normal(size=(5, 5)))[0] * rng.uniform(0.5, 2, 5)
    back = np.linalg.inv(change)
    other = replace(
        plant,
        A=change @ plant.A @ back,
        B=change @ plant.B,
        C=plant.C @ back,
        Q=change @ plant.Q @ change.T,
        S=change @ plant.S,
        x0=change @ plant.x0,
    )
    L = rng.normal(size=(2, 5))
    one = lb.fixed_order_filter(plant, 2, L=L, starts=6)
    two = lb.fixed_order_filter(other, 2, L=L @ back, starts=6)
    signs = np.sign(np.sum((two.T @ change) * one.T, axis=1))
    for name in "FGDPVTW":
        wanted, found = getattr(one, name), getattr(two, name)
        found = found @ change if name == "T" else found
        found = signs[:, None] * found if name in "FGDT" else found
        found = found * signs if name in "FP" else found
        assert np.abs(found - wanted).max() < 1e-7 * np.abs(wanted).max(), name


@pytest.mark.parametrize("seed", range(2))
def test_scaling_the_weight_scales_the_cost(seed):
    rng = np.random.default_rng(seed)
    plant = generators.plant(rng, 5, 2, radius=0.9, m=0)
    root = rng.normal(size=(5, 5))
    weight = root @ root.T + np.eye(5)
    half = np.linalg.cholesky(weight).T
    one, more, turned = (
        fixed_order_search(plant, 2, starts=4, **options).best
        for options in (dict(weight=weight), dict(weight=1e3 * weight), dict(L=half))
    )
    assert more.cost == pytest.approx(1e3 * one.cost, rel=1e-10)
    assert turned.cost == pytest.approx(one.cost, rel=1e-10)
    V = one.observer.V
    assert np.abs(more.observer.V - V).max() < 1e-7
    assert np.abs(turned.observer.V - half @ V).max() < 1e-6


@pytest.mark.parametrize("seed", range(2))
def test_less_noise_costs_less(seed):
    """An estimator of the noisier plant serves the quieter one at least as well."""
    plant, order, L, feedthrough = plain.random_problem(3 * seed + 2)
    options = dict(L=L, feedthrough=feedthrough, starts=4)
    loud = fixed_order_search(plant, order, **options).best
    quiet = [(0.5 * A1, 0.5 * C1) for A1, C1 in plant.multiplicative]
    soft = fixed_order_search(replace(plant, multiplicative=quiet), order, **options)
    none = fixed_order_search(replace(plant, multiplicative=()), order, **options)
    assert none.best.cost < soft.best.cost < loud.cost


def test_a_hundred_states_take_a_moment():
    """No Kronecker product is formed: that of plant and filter would take 1 GB."""
    rng = np.random.default_rng(0)
    plant = plain.random_plant(rng, plain.dense(rng, 100), 2, 0, 100)
    found = fixed_order_search(plant, 5, starts=3)
    assert found.best.optimality.worst < 1e-8
