"""The best filter of an order for a known input with statistics."""

import dataclasses
import re

import generators
import numpy as np
import pytest
import scipy.linalg

import luenberger as lb
from luenberger.analysis.error_covariance import mean_error
from luenberger.papers.haddad_bernstein.design import fixed_order_search

PLANT = generators.plant(np.random.default_rng(5), 3, 2, m=2, radius=0.8)
LAG = lb.Plant(
    [[0.6, 0.2], [0, 0.7]], None, [[1, 0], [1, 1]], dt=1.0,
    Q=[[1, 0.5], [0.5, 1]], R=[[0.5, 0], [0, 0.2]], S=[[0.1, 0], [0, 0.1]],
)  # fmt: skip
INPUTS = {"level": [2.0, -1.0], "white": [[4, 1], [1, 2]], "model": LAG}


def cost(observer, U, plant=PLANT):
    return np.trace(lb.error_covariance(observer, plant.with_input(U)))


@pytest.mark.parametrize("U", INPUTS.values(), ids=INPUTS)
@pytest.mark.parametrize("feedthrough", [True, False])
def test_no_gain_near_it_is_better(U, feedthrough):
    """Every entry of F, G, D, P and, where they are free, V, W moved both ways."""
    given, told = dict(feedthrough=feedthrough), PLANT.with_input(U)
    found = fixed_order_search(told, 1, starts=4, **given).best
    least = cost(found.observer, U)
    assert found.cost == pytest.approx(least, rel=1e-10)
    assert found.optimality.worst < 1e-8
    level = U is INPUTS["level"]
    shown = lb.optimality(found.observer, told, **given)
    assert shown.worst < 1e-8 and shown.cost == pytest.approx(least, rel=1e-10)
    free = "FGDP" + "VW" * feedthrough
    for name in free:
        X = getattr(found.observer, name)
        for index in np.ndindex(X.shape):
            for step in (1e-4, -1e-4):
                moved = X.copy()
                moved[index] += step
                other = dataclasses.replace(found.observer, **{name: moved})
                worse = cost(other, U)
                assert worse > least * (1 - 1e-12)
                assert level or worse < least * (1 + 1e-3)
    plain = fixed_order_search(PLANT, 1, starts=4, feedthrough=feedthrough).best
    assert cost(plain.observer, U) > 1.01 * least


def test_a_level_costs_nothing():
    """W alone takes every level out; the rest is the filter for u = 0."""
    found = lb.fixed_order_filter(PLANT.with_input(INPUTS["level"]), 1, starts=4)
    plain = lb.fixed_order_filter(PLANT, 1, starts=4)
    for level in ([2.0, -1.0], [0.0, 5.0]):
        np.testing.assert_allclose(
            mean_error(found, PLANT.with_input(level)), 0, atol=1e-12
        )
        assert cost(found, level) == pytest.approx(cost(plain, 0), rel=1e-12)
    assert np.abs(mean_error(plain, PLANT.with_input([2.0, -1.0]))).max() > 0.1
    off = lb.optimality(plain, PLANT.with_input([2.0, -1.0]))
    assert off.mean > 0.1 and off.cost == pytest.approx(cost(plain, [2.0, -1.0]))
    with pytest.raises(lb.CertificateError, match="absence of a mean error"):
        off.require()


def test_an_input_at_rest_enters_as_it_does_without_statistics():
    """The second input never moves, or only as the first does."""
    rest = lb.fixed_order_filter(PLANT.with_input([[4, 0], [0, 0]]), 1, starts=4)
    plain = lb.fixed_order_filter(PLANT, 1, starts=4)
    T = rest.T
    G = T @ PLANT.B - rest.D @ PLANT.E
    np.testing.assert_allclose(rest.G[:, 1], G[:, 1], rtol=1e-12)
    np.testing.assert_allclose(rest.W[:, 1], -(rest.V @ PLANT.E)[:, 1], rtol=1e-12)
    assert np.abs(rest.D - plain.D).max() > 1e-3
    tied = lb.fixed_order_filter(PLANT.with_input([[4, 2], [2, 1]]), 1, starts=4)
    one = dataclasses.replace(
        PLANT, B=PLANT.B @ [[1], [0.5]], E=PLANT.E @ [[1], [0.5]], input_names=None
    )
    alone = lb.fixed_order_filter(one.with_input([[4]]), 1, starts=4)
    assert cost(tied, [[4, 2], [2, 1]]) == pytest.approx(cost(alone, [[4]], one))
    none = lb.fixed_order_filter(PLANT.with_input(np.zeros((2, 2))), 1, starts=4)
    np.testing.assert_allclose(none.D, plain.D, rtol=1e-12)


def test_full_order_needs_no_statistics_and_a_tone_is_refused():
    full = lb.fixed_order_filter(PLANT.with_input(INPUTS["white"]), 3)
    np.testing.assert_array_equal(full.G, lb.fixed_order_filter(PLANT, 3).G)
    tone = lb.Plant([[0, 1], [-1, 0]], None, np.eye(2), dt=1.0, x0=[1, 0])
    with pytest.raises(lb.DesignError, match=r"mode 0 \+- 1j on the unit circle"):
        lb.fixed_order_filter(PLANT.with_input(tone), 1)
    with pytest.raises(lb.DesignError, match=r"mode 0 \+- 1j on the unit circle"):
        lb.optimality(full, PLANT.with_input(tone))


@pytest.mark.parametrize("tone", ["a sine", "a sine on a level"])
def test_the_advice_for_a_tone_gives_what_is_best_for_it(tone):
    """The code of the message is run as it stands; no gain near its filter is better.

    Gains move by a tenth of their size, beside which 0.999 is near enough to 1.
    """
    turn = np.array([[np.cos(0.7), -np.sin(0.7)], [np.sin(0.7), np.cos(0.7)]])
    U = lb.Plant(turn, None, np.eye(2), dt=1.0, x0=[3, 0])
    if tone == "a sine on a level":
        A = np.block([[turn, np.zeros((2, 1))], [np.zeros((1, 2)), 1.0]])
        U = lb.Plant(A, None, [[1, 0, 1], [0, 1, 0]], dt=1.0, x0=[3, 0, 2])
    with pytest.raises(lb.DesignError) as refusal:
        lb.fixed_order_filter(PLANT.with_input(U), 1)
    advice = re.search(r"(dataclasses\.replace\(.*?\)), where X", str(refusal.value))[1]
    X, s, steps = 0.0, U.x0, 20_000
    for _ in range(steps):
        X, s = X + np.outer(s, s) / steps, U.A @ s
    drifts = eval(advice, dict(dataclasses=dataclasses, U=U, X=X))
    kept = scipy.linalg.solve_discrete_lyapunov(drifts.A, drifts.Q)
    np.testing.assert_allclose(kept, X, atol=2e-3 * X.max())
    found = lb.fixed_order_filter(PLANT.with_input(drifts), 1, starts=4)
    assert lb.optimality(found, PLANT.with_input(drifts)).worst < 1e-8
    least = cost(found, U)  # the tone itself
    assert least == pytest.approx(cost(found, drifts), rel=0.05)
    assert cost(lb.fixed_order_filter(PLANT, 1, starts=4), U) > 2 * least
    for name in "FGDPVW":
        X = getattr(found, name)
        for index in np.ndindex(X.shape):
            for step in (0.1, -0.1):
                moved = X.copy()
                moved[index] += step * np.abs(X).max()
                other = dataclasses.replace(found, **{name: moved})
                assert cost(other, U) > least
