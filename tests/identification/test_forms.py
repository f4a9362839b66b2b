"""Forms of unknown covariances: where their vectors lead, and how fast."""

import numpy as np
import pytest

from luenberger.identification.forms import form_of
from luenberger.identification.standard_errors import face

RNG = np.random.default_rng(3)
G = RNG.normal(size=(3, 2))
UNIT = np.array([1.0, 2.0**-30, 2.0**30])


def squares(q):
    return q[0] * np.eye(3) + q[1] * np.ones((3, 3))


FORMS = {
    "full": ("full", None),
    "diagonal": ("diagonal", None),
    "G": (G, None),
    "function": (squares, [0.5, 2.0]),
}


def made(name, unit=None):
    wanted, start = FORMS[name]
    return form_of("Q", wanted, 3, None, start, np.ones(3) if unit is None else unit)


@pytest.mark.parametrize("name", ["diagonal", "G", "function"])
def test_a_variance_at_its_bound_is_zero(name):
    form = made(name)
    theta = np.zeros(form.count)
    theta[0] = -np.inf
    least = np.zeros(form.count)
    least[1:] = 1
    wanted = dict(diagonal=np.diag, G=lambda q: G * q @ G.T, function=squares)[name]
    assert (form.matrix(theta) == wanted(least)).all()


@pytest.mark.parametrize("name", FORMS)
def test_slopes_are_the_differences(name):
    form = made(name)
    theta, step = RNG.normal(size=form.count) / 3, 1e-6
    for k, slope in enumerate(form.slopes(theta)):
        up, down = (
            form.matrix(theta + s * np.eye(len(theta))[k]) for s in (step, -step)
        )
        np.testing.assert_allclose(slope, (up - down) / (2 * step), atol=1e-8)


@pytest.mark.parametrize("name", FORMS)
def test_a_covariance_is_found_again_from_its_vector(name):
    form = made(name)
    X = form.matrix(RNG.normal(size=form.count) / 3)
    if name != "function":  # which begins where its caller says
        again = form.matrix(form.at(X, np.ones(3)))
        np.testing.assert_allclose(again, X, rtol=1e-9, atol=1e-12)
    assert len(form.labels) == form.count == len(form.directions(np.zeros(form.count)))
    assert np.linalg.eigvalsh(X)[0] > -1e-14


def test_directions_add_up_to_the_covariance():
    theta = RNG.normal(size=6) / 3
    X = made("full").matrix(theta)
    entries = X[np.triu_indices(3)]
    np.testing.assert_allclose(
        np.tensordot(entries, made("full").directions(theta), 1), X, rtol=1e-12
    )
    q = np.exp(2 * theta[:2])
    np.testing.assert_allclose(
        np.tensordot(q, made("G").directions(theta[:2]), 1),
        G @ np.diag(q) @ G.T,
        rtol=1e-12,
    )
    np.testing.assert_allclose(
        np.tensordot(q, made("function").directions(theta[:2]), 1),
        squares(q),
        rtol=1e-8,
    )


def test_units_far_apart_are_the_normal_case():
    form, one = made("full", UNIT), made("full")
    theta = RNG.normal(size=6) / 3
    scaled = one.matrix(theta) * UNIT * UNIT[:, None]
    np.testing.assert_array_equal(form.matrix(theta), scaled)
    np.testing.assert_allclose(form.at(scaled, UNIT), theta, rtol=1e-9)


def test_a_singular_start_is_lifted():
    X = np.diag([1.0, 0.0, 4.0])
    for name in ("full", "diagonal"):
        form = made(name)
        found = form.matrix(form.at(X, np.ones(3)))
        np.testing.assert_allclose(found.diagonal(), [1, 1e-6, 4], rtol=1e-3)


@pytest.mark.parametrize(("name", "rank"), [("full", 2), ("diagonal", 2), ("G", 1)])
def test_a_variance_that_is_not_needed_is_set_to_zero(name, rank):
    """Likely is all that moves the first two coordinates alone."""
    form = form_of("Q", G if name == "G" else name, 3, None, None, np.ones(3))
    X = np.diag([1.0, 2.0, 1e-12])
    parts = form.parts if name == "G" else None
    if name == "G":
        X = parts[0] + 1e-12 * parts[1]
    theta = form.at(X, np.ones(3) * 1e-9)
    wanted = np.diag([1.0, 2.0, 0.0]) if name != "G" else parts[0]
    vague = np.full(form.count, np.inf)  # errors
    found = face(form, theta, lambda Y: np.abs(Y - wanted).max() < 1e-9, vague)
    np.testing.assert_allclose(found.X, wanted, atol=1e-9)
    assert np.linalg.matrix_rank(found.X, tol=1e-13) == rank
    assert len(found.sentences) == 1
    if name == "diagonal":
        assert found.bound.tolist() == np.diag([False, False, True]).tolist()
    if name == "G":
        assert found.values["q[1]"] == 0 and found.gone == ("q[1]",)
    untouched = face(form, theta, lambda Y: False, vague)
    np.testing.assert_allclose(untouched.X, X, rtol=1e-9, atol=1e-12)
    assert untouched.sentences == () and not untouched.bound.any()
