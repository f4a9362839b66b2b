"""How large an error of the estimate may be before an observer is refused.

The residuals of an observer are turned into what they do to the estimate, beside the
estimate itself.  Units of the states play no part in that.
"""

import warnings
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

import luenberger as lb
from luenberger.numeric.even_pair import even_pair
from luenberger.papers import certified
from luenberger.papers.moore import realised
from luenberger.papers.moore.companion_chain import Chain

A = np.array([[0.5, 1.0, 0.2], [-0.3, 0.8, 0.7], [0.1, 0.4, 0.6]])
C = np.array([[1.0, 0.5, 0.0]])


def in_units(units):
    U = np.diag(units)
    return lb.Plant(U @ A / units, None, C / units, dt=1.0)


UNITS = [[1.0, 1.0, 1.0], [2.0**12, 1.0, 2.0**-9], [2.0**-30, 2.0**-30, 2.0**-20]]


def judged(observer, plant):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")  # of a condition: the units are unlike
        d = even_pair(plant.A, plant.C, plant.dt).states
        built = (getattr(observer, X) for X in "FDTPV")
        certified.state_observer(plant, built, d, "Add sensors.")


@pytest.mark.parametrize(("cond", "warned"), [(0.99e10, False), (1.01e10, True)])
def test_an_ill_conditioned_observer_is_warned_of(cond, warned):
    """Two rows of length one at an angle t have the condition cot(t / 2)."""
    plant, t = lb.Plant(np.diag([-1.0, -3.0]), None, [[7.0, 0]]), 2 / cond
    T = 1e3 * np.array([[np.cos(t), np.sin(t)]])
    whole = np.linalg.inv(np.vstack([T, plant.C]))
    built = np.array([[-3.0]]), 2 * T[:, :1] / 7, T, whole[:, :1], whole[:, 1:]
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        certified.state_observer(plant, built, np.ones(2), "Add sensors.")
    assert len(caught) == warned


@pytest.mark.parametrize("units", UNITS)
@pytest.mark.parametrize("what", ["output", "dynamics"])
@pytest.mark.parametrize(("part", "kept"), [(0.99e-4, True), (1.01e-4, False)])
def test_a_ten_thousandth_of_the_state_is_lost(units, what, part, kept):
    """By P T + V C - I, or by P (T A - F T - D C), in states of comparable size.

    The first changes with V, the second with D; each is what it does to the estimate.
    """
    plant, base = in_units(units), in_units(UNITS[0])
    good = lb.deadbeat_observer(base)
    balance = even_pair(plant.A, plant.C, plant.dt).states / units
    # of the states in `base`; the same in all units but for a factor
    v = np.array([[0.3], [-1.0], [0.5]])
    if what == "output":
        V, D = v, np.zeros((2, 1))
        effect = v @ base.C
    else:
        V, D = 0 * v, np.array([[1.0], [-2.0]])
        effect = good.P @ D @ base.C
    size = part / np.linalg.norm(effect / balance[:, None] * balance)
    wrong = replace(good, V=good.V + size * V, D=good.D + size * D)
    U = np.array(units)[:, None]
    wrong = replace(
        wrong, P=U * wrong.P, V=U * wrong.V, T=wrong.T / units, T0=None, G0=None
    )
    if kept:
        judged(wrong, plant)
    else:
        with pytest.raises(lb.DesignError, match="would have no correct digit"):
            judged(wrong, plant)


# -- a functional ------------------------------------------------------------------


def error_of(F, dynamics, output, poles, discrete=False, k=2.0):
    """`_error` of a chain on a plant with A = 0, C = 0 that has these residuals.

    T = 0 but where the residual is; P reads the first state.
    """
    r = len(F)
    n = r  # T A - F T - D C = -D C with C = -1
    P = np.eye(1, r)
    admissible = SimpleNamespace(
        A=np.zeros((n, n)), C=-np.eye(n), k=k * np.eye(1, n)[0], discrete=discrete
    )
    T = np.zeros((r, n))
    T[0, 0] = k + output
    D = dynamics + F @ T
    chain = Chain(np.array(F), D, T, P)
    return realised._error(admissible, chain, np.array(poles)), D, T


@pytest.fixture
def felt(monkeypatch):
    """Errors of the estimate alone: of a residual by itself is a test further down."""
    monkeypatch.setattr(realised, "RESIDUAL_TOL", 1.0)


def swinging(damping, rate=1.0):
    return np.array([[-damping, rate], [-rate, -damping]]), [
        -damping + 1j * rate,
        -damping - 1j * rate,
    ]


@pytest.mark.parametrize("damping", [0.1, 1e-3])
def test_an_error_is_looked_for_where_the_observer_swings(damping, felt):
    """|P (i w - F)^-1 d| at the frequency w of a pole is d / (2 damping), not d."""
    F, poles = swinging(damping)
    d = np.zeros((2, 2))
    d[0, 0] = 1e-8
    found, *_ = error_of(F, d, 0.0, poles)
    s = 1j
    exact = abs((s + damping) / ((s + damping) ** 2 + 1)) * 1e-8 / 2
    assert found == pytest.approx(exact, rel=1e-6, abs=0)
    assert found == pytest.approx(1e-8 / (4 * damping), rel=0.02, abs=0)


@pytest.mark.parametrize("discrete", [False, True])
def test_an_error_is_looked_for_at_rest(discrete, felt):
    """A residual that a swing at w hides shows in a constant x."""
    F, poles = swinging(0.5)
    swing, rest = (np.exp(1j * np.angle(poles[0])), 1) if discrete else (1j, 0)
    inverse = np.linalg.inv(swing * np.eye(2) - F)[0]
    # real d with P (i - F)^-1 d = -c: no error at the frequency of the poles
    c = 1e-9
    d = np.linalg.solve(np.array([inverse.real, inverse.imag]), [-c, 0.0])
    dynamics = np.zeros((2, 2))
    dynamics[:, 0] = d
    found, *_ = error_of(F, dynamics, c, poles, discrete)
    wanted = abs(c + np.linalg.solve(rest * np.eye(2) - F, d)[0]) / 2
    assert wanted > c / 10 and found == pytest.approx(wanted, rel=1e-5, abs=0)


@pytest.mark.parametrize(("pole", "slowness"), [(0.9, 10.0), (-0.9, 10.0), (0.2, 1.25)])
def test_in_discrete_time_an_error_is_looked_for_on_the_circle(pole, slowness, felt):
    """Of a pole at -0.9 at z = -1, of one at 0.9 at z = 1."""
    found, *_ = error_of(np.array([[pole]]), np.array([[1e-8]]), 0.0, [pole + 0j], True)
    assert found == pytest.approx(1e-8 * slowness / 2, rel=1e-6, abs=0)


@pytest.mark.parametrize("size", [1e-3, 1.0, 1e3])
def test_a_residual_that_the_certificate_would_see_is_an_error(size):
    """1e-10 of its terms in T A - F T = D C counts as 1e-6 of k x, if that is more."""
    F = np.array([[-1e6]])
    d = np.array([[size * 1e-4]])
    found, D, T = error_of(F, d, 0.0, [-1e6 + 0j], k=size)
    terms = np.linalg.norm(T) * 1e6 + np.linalg.norm(D)
    assert found == pytest.approx(1e4 * np.linalg.norm(d) / terms, rel=1e-6, abs=0)


@pytest.mark.parametrize(("error", "kept"), [(0.9e-6, True), (1.1e-6, False)])
def test_an_observer_that_adds_a_millionth_is_refused(monkeypatch, error, kept):
    monkeypatch.setattr(realised, "_error", lambda *_: error)
    plant = lb.Plant([[0.1, 1], [0, -0.3]], None, [[1, 0]])
    for options in ({}, dict(order=1), dict(poles=[-1.0, -2.0])):
        if kept:
            lb.functional_observer(plant, [1.0, -0.7], **options)
        else:
            with pytest.raises(lb.DesignError, match=r"an error of 1e-06"):
                lb.functional_observer(plant, [1.0, -0.7], **options)


@pytest.mark.parametrize(("error", "tried"), [(0.9e-12, False), (1.1e-12, True)])
def test_other_coordinates_are_tried_where_digits_are_lost(monkeypatch, error, tried):
    found = []
    monkeypatch.setattr(realised, "_error", lambda *_: found.append(1) or error)
    plant = lb.Plant([[0.1, 1], [0, -0.3]], None, [[1, 0]])
    lb.functional_observer(plant, [1.0, -0.7], poles=[-1.0, -2.0])
    assert (len(found) > 1) is tried
