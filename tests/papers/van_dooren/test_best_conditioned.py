"""The free entries of the rows and the order of the poles, and what is made of them."""

import warnings

import numpy as np
import pytest
import scipy.linalg
import scipy.optimize
from pairs import conjugates, hidden_chains

import luenberger as lb
from luenberger.numeric.staircase_form import find_in_even_units
from luenberger.papers.poles import arranged
from luenberger.papers.van_dooren import best_conditioned as best
from luenberger.papers.van_dooren.rows_of_T import (
    Order,
    firm,
    minimum_norm,
    slopes,
    solve_rows,
    with_entries,
)


def shaft(stiffness=7719.0, sensors=(0, 3)):
    """Motor and load: two angles, two speeds (rad/s), a current (A)."""
    J_motor, J_load, damping = 0.01, 0.04, 0.05
    A = np.zeros((5, 5))
    A[0, 2] = A[1, 3] = 1
    twist = np.array([-stiffness, stiffness, -damping, damping])
    A[2, :4], A[2, 4], A[3, :4] = twist / J_motor, 0.5 / J_motor, -twist / J_load
    A[4, 2], A[4, 4] = -5, -20
    return lb.Plant(A, None, np.eye(5)[list(sensors)])


POLES = [-201 + 1503j, -201 - 1503j, -22]


def both_ways(plant, poles, **units):
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        return [
            lb.reduced_order_observer(plant, poles, **how, **units)
            for how in ({"method": "minimum-norm"}, {})
        ]


def noise(observer):
    """Largest standard deviation that white noise of the sensors leaves."""
    S = scipy.linalg.solve_continuous_lyapunov(
        observer.F, -1e-6 * observer.D @ observer.D.T
    )
    return np.sqrt(np.diag(observer.P @ S @ observer.P.T)).max()


def test_a_common_pair_of_poles_has_an_observer_that_keeps_its_digits():
    plant = shaft()
    paper, ours = both_ways(plant, POLES)
    certificates = [lb.certify(one, plant) for one in (paper, ours)]
    assert certificates[0].cond > 1e11 and certificates[1].cond < 1e4
    assert noise(ours) < noise(paper) / 50
    assert np.linalg.norm(ours.V) < np.linalg.norm(paper.V) / 50
    assert certificates[1].worst < 1e-14
    for one in (paper, ours):
        assert sorted(one.F.diagonal()) == sorted(np.real(POLES))
        wanted = np.poly(POLES).real
        np.testing.assert_allclose(np.poly(one.F), wanted, rtol=1e-12)
    again = lb.reduced_order_observer(plant, POLES)
    assert all((getattr(again, X) == getattr(ours, X)).all() for X in "FGDPVT")


def test_the_rows_of_the_paper_are_warned_of_and_a_comparison_has_ours():
    plant = shaft()
    with pytest.warns(RuntimeWarning, match=r"cond.*in another order"):
        lb.reduced_order_observer(plant, POLES, method="minimum-norm")
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        ours = lb.reduced_order_observer(plant, POLES)
        table = lb.compare(plant, lb.candidates(plant, poles=POLES))
    (found,) = (one for one in table if one.method == "reduced-order observer")
    assert np.linalg.norm(found.observer.V) == pytest.approx(np.linalg.norm(ours.V))


def drive(dt):
    """A motor on an elastic shaft, whose current and speed are read."""
    A = [[-500, -25, 0, 0], [500, -1, -1e4, 0], [0, 20, 0, -20], [0, 0, 2000, -0.4]]
    noises = dict(Q=np.diag([1, 100, 0.01, 1000]), R=1e-3 * np.eye(2))
    return lb.Plant(A, None, np.eye(2, 4), **noises).sampled(dt)


@pytest.mark.parametrize("dt", [1e-3, 5e-4])
@pytest.mark.parametrize("s", [-100 + 80j, -200 + 10j, -300 + 200j])
def test_the_mirror_image_of_a_pair_is_searched_too(s, dt):
    """All observers with a pair of poles are those of one complex number g.

    t (A - a I) = g C with g = (g_1, 1), and T = [Re t; Im t].  No g is much better.
    """
    plant, a = drive(dt), np.exp(s * dt)
    paper, ours = both_ways(plant, [a, a.conj()])
    found, before = lb.certify(ours, plant).cond, lb.certify(paper, plant).cond
    assert found < 300 and before > 500 * found
    M = plant.C @ np.linalg.inv(plant.A - a * np.eye(4))

    def cond(part):
        t = (part[0] + 1j * part[1]) * M[0] + M[1]
        T = np.vstack([t.real, t.imag])
        return np.linalg.cond(np.vstack([T / np.linalg.norm(T), plant.C]))

    starts = np.random.default_rng(3).normal(size=(10, 2))
    least = min(
        scipy.optimize.minimize(cond, one, method="Nelder-Mead").fun for one in starts
    )
    assert found < 3 * least
    sigma = [lb.error_covariance(one, plant)[3, 3] ** 0.5 for one in (paper, ours)]
    assert sigma[1] < 5 < sigma[0] / 3


@pytest.mark.parametrize(
    "plant, poles",
    [
        (shaft(60.0, (0, 4)), [-50 + 50j, -50 - 50j, -80]),
        (shaft(6000.0, (0,)), [-400, -410, -420, -430]),  # one output: no freedom
        (lb.Plant([[0, 1], [2, 3]], None, np.eye(2)), []),
    ],
)
def test_rows_that_are_well_conditioned_or_have_no_choice_are_those_of_the_paper(
    plant, poles
):
    paper, ours = both_ways(plant, poles)
    assert all((getattr(paper, X) == getattr(ours, X)).all() for X in "FGDPVT")


CLUSTERED = {
    "one multiple pole": np.full(9, 0.9),
    "a cluster": 0.9 + 1e-9 * np.arange(9),
    "equal pairs": np.array([0.2 + 0.7j, 0.2 - 0.7j] * 4 + [0.8]),
    "all zero": np.zeros(9),
}


@pytest.mark.parametrize("kind", CLUSTERED)
@pytest.mark.parametrize("complex_", [False, True])
def test_repeated_and_clustered_poles(kind, complex_, monkeypatch):
    """Searched in every case, and taken where it is any better."""
    monkeypatch.setattr(best, "WELL", 0.0)
    monkeypatch.setattr(best, "MUCH", 1.0)
    A, C, _ = hidden_chains(12, 3, complex_=complex_)
    plant = lb.Plant(A + 0.5 * A @ A, None, C, dt=1.0)
    paper, ours = both_ways(plant, CLUSTERED[kind], units="given")
    assert not np.allclose(paper.T, ours.T)
    before, after = (slant_of(one, plant) for one in (paper, ours))
    assert after < before
    assert lb.certify(ours, plant).worst < 1e-13
    wanted = CLUSTERED[kind] if complex_ else CLUSTERED[kind].real
    assert (np.sort(ours.F.diagonal()) == np.sort(wanted)).all()


def slant_of(observer, plant):
    """J from its definition, in the units given."""
    both = np.vstack([observer.T, plant.C])
    lengths = np.linalg.norm(both, axis=1)
    return np.linalg.norm(np.linalg.inv(both) * lengths) ** 2


def test_fifty_states():
    """25 carts between springs, a sensor on every second, poles in pairs."""
    springs = 2 * np.eye(25) - np.eye(25, k=1) - np.eye(25, k=-1)
    springs[0, 0] = springs[-1, -1] = 1
    below = np.hstack([-springs, -0.1 * springs - 0.05 * np.eye(25)])
    A = np.vstack([np.eye(50)[25:], below])
    plant = lb.Plant(A, None, np.eye(50)[:24:2])
    poles = [-a + side * a for a in np.linspace(1, 3, 19) for side in (1j, -1j)]
    paper, ours = both_ways(plant, poles)
    before, after = (lb.certify(one, plant) for one in (paper, ours))
    assert after.cond < before.cond / 5 and after.worst < 1e-13
    assert np.linalg.norm(ours.V) < np.linalg.norm(paper.V) / 2


@pytest.mark.parametrize("kind", ["real", "pairs", "complex"])
def test_slopes_by_differences(kind):
    """The gradient of log J in every free entry, in central differences."""
    A, C, rng = hidden_chains(7, 2, complex_=kind == "complex")
    A = A + 0.5 * rng.standard_normal((7, 7))
    plant = lb.Plant(A, None, C, dt=1.0)
    poles = {
        "real": 0.5 * rng.random(5),
        "pairs": conjugates(5, rng),
        "complex": 0.3 * (rng.random(5) + 1j * rng.random(5)),
    }[kind]
    _, form = find_in_even_units(plant.A, plant.C, plant.dt)
    form, order = firm(form), Order(*arranged(poles, 5, plant))
    weights = np.exp2(rng.integers(-2, 3, 7))
    plain = solve_rows(form, order, minimum_norm)
    free = [plain.free(step) for step in plain.steps]
    free = [y + 0.1 * rng.standard_normal(y.shape) for y in free]

    def J(free):
        rows = solve_rows(form, order, with_entries(free))
        return np.log(best.slant(rows, weights)[0])

    rows = solve_rows(form, order, with_entries(free))
    value, slope = best.slant(rows, weights)
    found = slopes(rows, slope)
    assert any(np.abs(one).max() > 1e-2 * value for one in found)
    for k, y in enumerate(free):
        for j in range(len(y)):
            for unit in (1.0, 1j) if np.iscomplexobj(y) else (1.0,):
                step = np.zeros_like(y)
                step[j] = 1e-6 * unit
                ends = [
                    J([*free[:k], y + side, *free[k + 1 :]]) for side in (step, -step)
                ]
                wanted = (np.conj(found[k][j]) * unit).real / value
                assert (ends[0] - ends[1]) / 2e-6 == pytest.approx(wanted, abs=1e-7)


@pytest.mark.parametrize("kind", ["real", "pairs"])
def test_the_rows_of_least_norm_come_back_from_their_free_entries(kind):
    A, C, rng = hidden_chains(9, 3)
    poles = {"real": 0.5 * rng.random(6), "pairs": conjugates(6, rng)}[kind]
    plant = lb.Plant(A, None, C, dt=1.0)
    _, form = find_in_even_units(plant.A, plant.C, plant.dt)
    form, order = firm(form), Order(*arranged(poles, 6, plant))
    rows = solve_rows(form, order, minimum_norm)
    free = [rows.free(step) for step in rows.steps]
    again = solve_rows(form, order, with_entries(free))
    for X in "TFD":
        wanted = getattr(rows, X)
        np.testing.assert_allclose(getattr(again, X), wanted, atol=1e-12)
