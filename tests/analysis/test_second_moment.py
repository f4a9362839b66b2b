"""How well the second moment must satisfy its equation, and when it is improved."""

import numpy as np
import pytest
import scipy

import luenberger as lb
from luenberger.analysis import mean_square
from luenberger.numeric.covariance_maps import stack

A, V = np.array([[0.5]]), np.array([[1.0]])
X = np.array([[4 / 3]])  # X = X / 4 + 1
RESIDUAL = 3 / 4  # relative, of (1 + d) X, in parts of d


def solved(monkeypatch, d, answer):
    """From a start that is wrong by a part d, with `answer` instead of GMRES."""
    calls = []

    def instead(operator, left, **options):
        calls.append(left)
        return answer * left, 0

    monkeypatch.setattr(scipy.sparse.linalg, "gmres", instead)
    return mean_square._solve(A, stack(A, []), V, (1 + d) * X), len(calls)


def test_a_combination_that_no_noise_moves_has_no_variance():
    """0.1 x1 - 0.3 x2 of x1 = 3 x2: its variance rounds to something below zero."""
    one = np.array([[0.0, 0, 0], [0, 0, 0], [0.1, -0.3, 0]])
    found = mean_square.second_moment(one, [], np.outer([3.0, 1, 0], [3.0, 1, 0]))
    np.testing.assert_array_equal(found, [[9, 3, 0], [3, 1, 0], [0, 0, 0]])


def test_rounding_is_judged_by_the_variances_that_were_added(monkeypatch):
    """x1 of deviation 4 x 3, less 2 x 3, from A, and 1 x 3 from the noise, and 7."""
    monkeypatch.setattr(mean_square, "RESIDUAL_TOL", np.inf)
    monkeypatch.setattr(mean_square, "ROUNDS", 1)
    monkeypatch.setattr(mean_square, "semidefinite", lambda X, size: size)
    A, noise = np.array([[4.0, -2], [0, 0.5]]), np.array([[[0.0, 1], [0, 0]]])
    V, X = np.diag([7.0, 0]), np.full((2, 2), 9.0)
    solver = lambda _, left, **options: (0 * left, 0)  # noqa: E731
    monkeypatch.setattr(scipy.sparse.linalg, "gmres", solver)
    size = mean_square._solve(A / 8, noise / 8, V, X)
    np.testing.assert_array_equal(size, [(18**2 + 3**2) / 64 + 7, 1.5**2 / 64])


@pytest.mark.parametrize("sign", [1, -1])
@pytest.mark.parametrize(("residual", "met"), [(0.95e-12, True), (1.05e-12, False)])
def test_an_equation_is_met_to_1e_12(monkeypatch, residual, met, sign):
    d = sign * residual / RESIDUAL
    if met:
        found, _ = solved(monkeypatch, d, answer=0.0)
        assert found[0, 0] == pytest.approx((1 + d) * 4 / 3, rel=4e-16, abs=0)
    else:
        with pytest.raises(lb.CertificateError, match=r"residual stays at 1\.[01]e-12"):
            solved(monkeypatch, d, answer=0.0)


@pytest.mark.parametrize(("d", "rounds"), [(1e-13, 1), (4e-16, 0)])
def test_what_can_be_improved_is_improved(monkeypatch, d, rounds):
    """1 = L (1 - L^-1), so GMRES has nothing to do without multiplicative noise."""
    found, calls = solved(monkeypatch, d, answer=1.0)
    assert calls == rounds
    assert found[0, 0] == pytest.approx(4 / 3, rel=5e-16, abs=0)


def test_a_solver_that_no_longer_helps_is_left_and_the_best_answer_kept(monkeypatch):
    found, calls = solved(monkeypatch, 1e-12, answer=2.1)  # worse each time
    assert calls == 1
    assert found[0, 0] == pytest.approx((1 + 1e-12) * 4 / 3, rel=4e-16, abs=0)


def test_rounds_go_on_while_each_halves_the_residual(monkeypatch):
    found, calls = solved(monkeypatch, 1e-6, answer=0.6)  # 0.4 is left each time
    assert calls == 20 and abs(found[0, 0] * 3 / 4 - 1) < 1e-6 * 0.4**19 * 1.5
    with pytest.raises(lb.CertificateError, match="residual stays"):
        solved(monkeypatch, 1e-6, answer=0.4)  # 0.6 is left: it is given up at once


@pytest.mark.parametrize(
    ("part", "off"), [(1e-6, 1e-12), (1e-8, 1e-12), (5e-9, 1e-8), (1e-12, 1e-11)]
)
def test_radius_leaves_out_no_noise_that_matters(part, off):
    """[[a]], [[b]] have the radius a^2 + b^2, which is a^2 to some 1e-9."""
    b = np.sqrt(part) * 0.5
    found = mean_square.radius(np.array([[0.5]]), [(np.array([[b]]), np.zeros((1, 1)))])
    assert found == pytest.approx(0.25 * (1 + part), rel=off, abs=0)


def test_scaled_to_its_radius_a_plant_is_at_its_limit():
    """X = (A X A' + B X B') / r has a solution X > 0: the dense eigenvector."""
    rng = np.random.default_rng(3)
    A, B = rng.normal(size=(2, 3, 3)) / 2
    r = mean_square.radius(A, [(B, np.zeros((1, 3)))])
    values, vectors = np.linalg.eig(np.kron(A, A) + np.kron(B, B))
    k = np.argmax(np.abs(values))
    assert r == pytest.approx(values[k].real, rel=1e-12)
    Y = vectors[:, k].real.reshape(3, 3)
    assert (np.linalg.eigvalsh(Y * np.sign(np.trace(Y))) > 0).all()
