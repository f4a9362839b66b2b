"""What a comparison calls exact, sound and zero: just inside and just outside."""

from types import SimpleNamespace

import numpy as np
import pytest

import luenberger as lb
from luenberger.certificate import Certificate
from luenberger.compare import measure
from luenberger.compare.attempts import Attempt


def resting(gain, R=1.0, C=1.0):
    """x+ = x / 2 with no noise, and its filter with this gain instead of 0."""
    plant = lb.Plant([[0.5]], None, [[C]], dt=1.0, Q=[[0.0]], R=[[R]])
    left = 1 - gain * C
    observer = lb.Observer(
        [[0.5 * left]], np.zeros((1, 0)), [[0.5 * gain]], [[left]], [[gain]],
        T=[[1.0]], L=[[1.0]], dt=1.0,
    )  # fmt: skip
    lb.certify(observer, plant).require()
    return observer, plant


@pytest.mark.parametrize(
    ("R", "C"), [(1.0, 1.0), (1e6, 1.0), (1.0, 1e-3), (1e-12, 8.0)]
)
@pytest.mark.parametrize(("part", "kept"), [(1.05e-14, True), (0.95e-14, False)])
def test_variance_that_a_gain_of_rounding_lets_in_is_zero(part, kept, R, C):
    """x is known to be 0, so its best gain is 0 and what R does is rounding.

    e+ = (1 - g C) e / 2 - g v has the variance g^2 R / (1 - (1 - g C)^2 / 4), about
    4/3 g^2 R; it is compared with R / C^2, that of an estimate y / C.
    """
    observer, plant = resting(part * np.sqrt(3 / 4) / C, R, C)
    found = measure.steady_covariance(observer, plant)[0, 0]
    assert found == (
        pytest.approx(part**2 * R / C**2, rel=1e-6, abs=0) if kept else 0.0
    )


@pytest.mark.parametrize(("part", "kept"), [(1.05e-14, True), (0.95e-14, False)])
def test_an_output_that_does_not_see_a_state_lets_nothing_into_it(part, kept):
    """Of two states at rest one is measured; the least that R lets in is into that."""
    one, _ = resting(part * np.sqrt(3 / 4))
    zero, half = np.zeros((2, 1)), 0.5 * np.eye(2)
    half[0, 0] = one.F[0, 0]
    P = np.diag([one.P[0, 0], 1.0])
    plant = lb.Plant(0.5 * np.eye(2), None, [[1, 0]], dt=1.0, Q=0 * P, R=[[1.0]])
    observer = lb.Observer(
        half, zero[:, :0], [one.D[0], [0]], P, [one.V[0], [0]], T=np.eye(2),
        L=np.eye(2), dt=1.0,
    )  # fmt: skip
    lb.certify(observer, plant).require()
    found = measure.steady_covariance(observer, plant)
    wanted = [pytest.approx(part**2, rel=1e-6, abs=0) if kept else 0.0, 0.0]
    assert found.diagonal().tolist() == wanted


def test_without_outputs_nothing_is_let_in():
    plant = lb.Plant(
        [[0.5]], None, np.zeros((0, 1)), dt=1.0, Q=[[0]], R=np.zeros((0, 0))
    )
    zero = np.zeros((1, 0))
    observer = lb.Observer([[0.5]], zero, zero, [[1]], zero, T=[[1]], L=[[1]], dt=1.0)
    assert measure.steady_covariance(observer, plant) == 0


def test_variance_of_what_is_driven_is_kept_however_small():
    observer, plant = resting(1e-15)
    driven = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1e-40]], R=[[1.0]])
    assert measure.steady_covariance(observer, driven)[0, 0] > 0


@pytest.mark.parametrize(("worst", "exact"), [(0.9e-9, True), (1.1e-9, False)])
def test_exact_is_what_a_certificate_requires(worst, exact):
    certificate = Certificate(0.0, 0.0, worst, 0.0, np.array([0.5]), True)
    one = Attempt("Kalman filter", "", certificate=certificate)
    assert one.exact is exact and one.sound is exact
    if exact:
        certificate.require()
    else:
        with pytest.raises(lb.CertificateError, match="output residual is 1.1e-09"):
            certificate.require()


@pytest.mark.parametrize(("worst", "sound"), [(0.9e-8, True), (1.1e-8, False)])
def test_sound_is_what_an_optimum_requires(worst, sound):
    conditions = dict.fromkeys(
        "F D P V riccati estimate adjoint idempotent".split(), 0.0
    )
    conditions |= dict.fromkeys("aligned trace cost".split(), 0.0)
    matrices = dict.fromkeys("tau Q Qh Ph G Gam".split())
    found = lb.optimality.__globals__["Optimality"](**conditions | matrices)
    object.__setattr__(found, "adjoint", worst)
    certificate = SimpleNamespace(worst=1.0, stable=True)
    one = Attempt("fixed-order filter", "", certificate=certificate, optimality=found)
    assert one.sound is sound
    if sound:
        found.require()
    else:
        with pytest.raises(lb.CertificateError, match=r"\(3.16\) is missed by 1.1e-08"):
            found.require()
