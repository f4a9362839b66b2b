"""Numbers that decide: what is rounding, what is equal, what is too much.

Each with a case just inside and one just outside.
"""

import importlib
from types import SimpleNamespace

import numpy as np
import pytest
import scipy

import luenberger as lb
from luenberger import show
from luenberger.analysis import lightest as forms
from luenberger.numeric import covariances
from luenberger.papers.moore import refusals
from luenberger.papers.poles import arranged
from luenberger.recursion import excitation
from luenberger.recursion.settings import setting

mean_square = importlib.import_module("luenberger.analysis.mean_square")
steady_gain = importlib.import_module("luenberger.recursion.steady_gain")
simulate = importlib.import_module("luenberger.run.simulate")  # lb's is the function


@pytest.mark.parametrize("size", [1.0, 1e-20, 1e20])
@pytest.mark.parametrize(("part", "kept"), [(0.9e-9, True), (1.2e-9, False)])
def test_a_covariance_is_symmetric_and_not_indefinite_but_for_rounding(
    part, kept, size
):
    skewed = size * np.array([[1.0, 0.5 + part], [0.5, 1.0]])
    indefinite = size * np.array([[1.0, 1.0 + part], [1.0 + part, 1.0]])
    for X, why in ((skewed, "symmetric"), (indefinite, "semi-definite")):
        if kept:
            found = covariances.covariance("Q", X, 2)
            assert (found == found.T).all()
        else:
            with pytest.raises(ValueError, match=why):
                covariances.covariance("Q", X, 2)


PLANT = lb.Plant([[0, 1], [-2, -3]], None, [[1.0, 0]])


@pytest.mark.parametrize("size", [1.0, 1e6])
@pytest.mark.parametrize(("off", "pair"), [(0.9e-8, True), (1.1e-8, False)])
def test_conjugates_may_differ_by_rounding(off, pair, size):
    """By 1e-8 of the pole; the second is then taken as the conjugate of the first."""
    first = size * (-0.6 + 0.8j)
    poles = [first, first.conjugate() + off * size]
    if pair:
        found, pairs = arranged(poles, 2, PLANT)
        assert found[1] == found[0].conjugate() and pairs.tolist() == [True, False]
    else:
        with pytest.raises(lb.DesignError, match="needs its conjugate"):
            arranged(poles, 2, PLANT)


@pytest.mark.parametrize("size", [1.0, 1e20])
@pytest.mark.parametrize(("part", "shown"), [(0.9e-12, False), (1.1e-12, True)])
def test_a_number_beside_a_large_one_is_shown_as_zero(part, shown, size):
    text = show.number(part * size, scale=size)
    assert (text != "0") is shown
    text = show.number(size * (1 + 1j * part))
    assert ("j" in text) is shown


@pytest.mark.parametrize(("off", "fits"), [(0.9e-6, True), (1.2e-6, False)])
def test_times_are_those_of_the_samples_to_a_millionth(off, fits):
    t = 0.1 * (1 + off) * np.arange(5)
    uneven = 0.1 * np.arange(5.0)
    uneven[3:] += 0.1 * off
    if fits:
        assert simulate._whole_steps(t, 0.1) == 4
        assert len(simulate._equally_spaced(uneven)) == 5
    else:
        with pytest.raises(ValueError, match="but the plant samples every 0.1 s"):
            simulate._whole_steps(t, 0.1)
        with pytest.raises(ValueError, match="equally spaced times"):
            simulate._equally_spaced(uneven)


@pytest.mark.parametrize("size", [1.0, 1e-15])
@pytest.mark.parametrize(("part", "counts"), [(0.9e-10, False), (1.1e-10, True)])
def test_entries_that_are_rounding_may_be_dropped(part, counts, size):
    X = size * np.array([[3.0, 3 * part]])
    assert bool(forms._rounded(X, 1e-10)[0, 1]) is counts
    for one in (1.0, -1.0):
        near = np.array([[one + part, 2.0]])
        assert (forms._rounded(near, 1e-10)[0, 0] == one) is not counts


@pytest.mark.parametrize(("part", "exact"), [(0.9e-9, True), (1.2e-9, False)])
def test_an_error_is_free_of_the_input_if_the_certificate_says_so(part, exact):
    """G is off by this part of its terms, T B and G."""
    plant = lb.Plant([[0.5]], [[1.0]], [[1]], dt=1.0, Q=[[1]], R=[[1]])
    good = lb.kalman_filter(plant)
    terms = abs(good.T[0, 0] * 1.0) + abs(good.G[0, 0])
    wrong = lb.Observer(good.F, good.G + part * terms, good.D, good.P, good.V,
                        T=good.T, L=good.L, W=good.W, dt=1.0)  # fmt: skip
    if exact:
        lb.error_covariance(wrong, plant)
    else:
        with pytest.raises(lb.DesignError, match="depends on the known input"):
            lb.error_covariance(wrong, plant)


@pytest.mark.parametrize(("least", "lost"), [(0.9e-9, True), (1.1e-9, False)])
def test_a_pencil_loses_rank_below_1e_9(least, lost):
    def pencil(angle):
        return np.diag([1.0, np.hypot(least, angle - 0.3)]).astype(complex)

    found = excitation._loss(pencil, 1.0, 0.31)
    assert (found is not None) is lost
    if lost:
        assert found == pytest.approx(0.3, abs=1e-9)


@pytest.mark.parametrize("size", [1.0, 1e9])
@pytest.mark.parametrize(("least", "enough"), [(1.2e-9, True), (0.8e-9, False)])
def test_noise_that_does_not_reach_an_output_is_not_enough(
    monkeypatch, least, enough, size
):
    monkeypatch.setattr(
        excitation, "_pencil", lambda now: (lambda a: size * np.diag([1.0, least]), 1.0)
    )
    now = SimpleNamespace(As=np.eye(1))
    if enough:
        excitation.require_noise_enough(now)
    else:
        with pytest.raises(lb.DesignError, match=r"outputs \[0\]"):
            excitation.require_noise_enough(now)


@pytest.mark.parametrize(("part", "named"), [(1.5e-10, True), (0.5e-10, False)])
def test_rows_of_a_recurrence_that_are_met_are_not_listed(part, named):
    """With beta = 0.5 + s: kappa_0 / 2 + kappa_1 = 0 but for a part of its terms."""
    kappa = np.array([2.0, -1.0 * (1 - 2 * part), 5.0])
    one = SimpleNamespace(kappa=kappa, sigma=1.0)
    text = refusals._violated(one, np.array([-0.5]))
    assert ("row 0 comes to" in text) is named and "row 1 comes to" in text


@pytest.mark.parametrize("size", [1.0, 1e-20])
@pytest.mark.parametrize(("left", "found"), [(0.9e-12, True), (1.2e-12, False)])
def test_a_second_moment_leaves_next_to_nothing_over(left, found, size, monkeypatch):
    """Where GMRES gets no further: X = V by all it has, and is off by `left`."""
    solver = lambda _, b, **options: (0 * b, 1)  # noqa: E731
    monkeypatch.setattr(scipy.sparse.linalg, "gmres", solver)
    V, none = size * np.eye(2), np.zeros((2, 2))
    X = V * (1 + left)
    if found:
        assert (mean_square._solve(none, none[None], V, X) == X).all()
    else:
        with pytest.raises(lb.CertificateError, match="not found to rounding"):
            mean_square._solve(none, none[None], V, X)


@pytest.mark.parametrize("size", [1.0, 1e-20])
@pytest.mark.parametrize(("below", "taken"), [(0.9e-8, True), (1.1e-8, False)])
def test_a_steady_state_starts_from_a_covariance(below, taken, size, monkeypatch):
    """That of SciPy, unless it is more indefinite than rounding makes it."""
    Omega = size * np.diag([1.0, -below])
    monkeypatch.setattr(
        steady_gain.scipy.linalg, "solve_discrete_are", lambda *_: Omega
    )
    plant = lb.Plant(
        np.eye(2) / 2, None, np.eye(2), dt=1.0, Q=size * np.eye(2), R=size * np.eye(2)
    )
    start = steady_gain._start(setting(plant))
    np.testing.assert_array_equal(start, Omega if taken else 4 * size * np.eye(2))


def test_what_cancels_in_the_decorrelated_plant_is_judged_by_its_terms():
    """A - J C is rounding here; what it is the difference of is not."""
    Q, S, R = [[0.09]], [[0.03]], [[0.01]]
    plant = lb.Plant([[0.3]], None, [[0.1]], dt=1.0, Q=Q, R=R, S=S)
    move = setting(plant).move
    assert abs(move.A[0, 0]) < 1e-15
    assert move.size[0, 0] == pytest.approx(0.6, rel=1e-12)
