"""What SciPy and python-control test themselves with, as observer problems."""

import warnings

import borrowed_cases as borrowed
import control
import exact_oracles as exact
import mpmath
import numpy as np
import pytest
import scipy.linalg
import scipy.signal

import luenberger as lb

# -- Riccati equations: the Kalman filter of x+ = A'x + w, y = B'x + v ----------------

NEARLY_EXACT = 1e-13  # of a predicted covariance, each entry beside its two sigmas
SENSITIVE = {  # closed-loop poles next to the unit circle, or a nearly singular R
    "darex 8": 1e-11,  # |z| = 0.99998
    "darex 14": 1e-7,  # |z| = 1 - 2e-8
    "carex 8": 1e-10,  # cond(R) = 4e6, and 1e8 in Q
    "carex 13": 1e-11,  # |z| = 0.9993
}


def predicted(plant):
    """The covariance before each sample, from the filter and its error covariance."""
    observer = lb.kalman_filter(plant)
    assert lb.certify(observer, plant).worst < 1e-12
    Sigma = lb.error_covariance(observer, plant)
    A, Q = plant.A, plant.Q
    if plant.S is not None:
        J = np.linalg.solve(plant.R, plant.S.T).T
        A, Q = A - J @ plant.C, Q - J @ plant.S.T
    return observer, A @ Sigma @ A.T + Q


def apart(X, wanted):
    """The largest entry of X - wanted, each beside its two standard deviations."""
    unit = np.sqrt(np.where(wanted.diagonal() > 0, wanted.diagonal(), 1.0))
    return np.abs((X - wanted) / unit / unit[:, None]).max()


@pytest.mark.parametrize(
    "name", [name for name in borrowed.DISCRETE if name != "darex 3"]
)
def test_discrete_riccati_equation(name):
    """Against sixty digits, and never less accurate than SciPy by a digit."""
    A, B, Q, R = borrowed.DISCRETE[name]
    plant = lb.Plant(A.T, None, B.T, Q=Q, R=R, dt=1.0)
    wanted = exact.riccati(A.T, B.T, Q, R)
    _, X = predicted(plant)
    error = apart(X, wanted)
    assert error < SENSITIVE.get(name, NEARLY_EXACT)
    theirs = apart(scipy.linalg.solve_discrete_are(A, B, Q, R), wanted)
    assert error < 10 * theirs + 1e-15


def test_discrete_riccati_equation_without_measurement_noise():
    """darex 3, whose solution is the identity: R = 0."""
    A, B, Q, R = borrowed.DISCRETE["darex 3"]
    plant = lb.Plant(A.T, None, B.T, Q=Q, R=R, dt=1.0)
    observer, X = predicted(plant)
    np.testing.assert_allclose(X, np.eye(2), atol=1e-15)
    np.testing.assert_allclose(observer.poles, 0, atol=1e-8)


def sampled_by_cayley(A, C, Q, R):
    """The discrete plant whose Riccati equation has the continuous one's solution.

    With z = (g + s) / (g - s), x' = A x + w, y = C x + v becomes a plant whose w and
    v are correlated; g is near the rates of the filter, the eigenvalues of the
    Hamiltonian.
    """
    flow = np.block([[A.T, -C.T @ np.linalg.solve(R, C)], [-Q, -A]])
    rates = np.abs(np.linalg.eigvals(flow))
    g = 1.5 * 2 ** np.round(np.log2(rates).mean())  # 1.5: on none of them
    back = np.linalg.inv(g * np.eye(len(A)) - A)
    half, seen = np.sqrt(2 * g) * back, C @ back
    Q, R, S = half @ Q @ half.T, R + seen @ Q @ seen.T, half @ Q @ seen.T
    A, C = back @ (g * np.eye(len(A)) + A), np.sqrt(2 * g) * seen
    return lb.Plant(A, None, C, dt=1.0, Q=(Q + Q.T) / 2, R=(R + R.T) / 2, S=S)


INDEFINITE = ("carex 3", "carex 4")  # Q; that of carex 3 by its rounding
ON_THE_AXIS = "carex 14"  # a pole of the filter at -1e-12
REFUSED = (*INDEFINITE, ON_THE_AXIS)


@pytest.mark.parametrize("name", [k for k in borrowed.CONTINUOUS if k not in REFUSED])
def test_continuous_riccati_equation(name):
    """Through a plant with S; also where SciPy marks its own test as a failure."""
    A, B, Q, R = borrowed.CONTINUOUS[name]
    plant = sampled_by_cayley(A.T, B.T, Q, R)
    wanted = exact.riccati(plant.A, plant.C, plant.Q, plant.R, plant.S)
    _, X = predicted(plant)
    assert apart(X, wanted) < SENSITIVE.get(name, NEARLY_EXACT)
    theirs = scipy.linalg.solve_continuous_are(A, B, Q, R)
    assert apart(theirs, wanted) < 1e-3  # it is the same equation


def test_a_filter_that_forgets_too_slowly_is_refused():
    A, B, Q, R = borrowed.CONTINUOUS[ON_THE_AXIS]
    plant = sampled_by_cayley(A.T, B.T, Q, R)
    with pytest.raises(lb.CertificateError, match="not settle.*largest pole is 1"):
        lb.kalman_filter(plant)


@pytest.mark.parametrize("name", INDEFINITE)
def test_a_riccati_equation_with_an_indefinite_weight_is_no_filter(name):
    A, B, Q, R = borrowed.CONTINUOUS[name]
    with pytest.raises(ValueError, match="Q must be positive semi-definite"):
        sampled_by_cayley(A.T, B.T, Q, R)
    assert np.linalg.eigvalsh(Q)[0] < 0


@pytest.mark.parametrize("name", borrowed.NOT_COVARIANCES)
def test_a_riccati_equation_that_is_no_filter(name):
    A, B, Q, R, why = borrowed.NOT_COVARIANCES[name]
    with pytest.raises(ValueError, match=why):
        lb.kalman_filter(lb.Plant(A.T, None, B.T, Q=Q, R=R, dt=1.0))


# -- pole placement -------------------------------------------------------------------


def lagging(A, B, poles):
    """Full-order placement as a reduced-order observer problem, and its poles.

    The sensors lag: s' = -s + B'x, y = s.  An observer of order n for this plant has
    F similar to A' - M B'.  It must be stable, so A and poles are moved to the left
    together; M does not change.
    """
    n, m = B.shape
    poles = np.array(poles, dtype=complex)
    left = max(0.0, poles.real.max() + 1)
    whole = np.block([[A.T - left * np.eye(n), np.zeros((n, m))], [B.T, -np.eye(m)]])
    plant = lb.Plant(whole, None, np.hstack([np.zeros((m, n)), np.eye(m)]))
    return plant, poles - left, left


def gain(observer, n):
    """M of z = x - M s, from T [x; s]."""
    return -np.linalg.solve(observer.T[:, :n], observer.T[:, n:])


def characteristic(matrix):
    """Coefficients of det(s - matrix), with as many digits as it takes."""
    with mpmath.workdps(60):
        M = mpmath.matrix(matrix.tolist())
        found, power = [mpmath.mpf(1)], mpmath.eye(M.rows)
        for k in range(1, M.rows + 1):  # Faddeev and LeVerrier
            moved = M * power
            found.append(-sum(moved[i, i] for i in range(M.rows)) / k)
            power = moved + found[-1] * mpmath.eye(M.rows)
        return np.array([float(c) for c in found])


def missed(matrix, poles):
    """How far a characteristic polynomial is off, beside its terms' magnitudes."""
    wanted = np.poly(poles).real
    return (np.abs(characteristic(matrix) - wanted) / np.poly(-np.abs(poles))).max()


@pytest.mark.parametrize("name", borrowed.PLACEMENT)
@pytest.mark.parametrize("method", ["minimum-norm", "back-substitution"])
def test_all_poles_are_placed(name, method):
    A, B, poles = borrowed.PLACEMENT[name]
    plant, moved, left = lagging(A, B, poles)
    observer = lb.reduced_order_observer(plant, moved, method=method)
    assert max(exact.certificate(observer, plant)) < 1e-13
    order = np.lexsort((moved.imag, moved.real))
    found = np.sort_complex(observer.poles)
    np.testing.assert_allclose(found, moved[order], rtol=1e-13, atol=1e-13)
    M = gain(observer, len(A))
    closed = A.T - left * np.eye(len(A)) - M @ B.T
    # A far larger than the poles wanted of it costs digits, whoever solves it
    lost = lb.certify(observer, plant).cond * np.linalg.norm(A) / np.abs(moved).min()
    assert missed(closed, moved) < 1e-14 * max(lost, 100)
    if B.shape[1] == 1 and len(set(poles)) == len(poles):  # there is one such gain
        theirs = scipy.signal.place_poles(A, B, poles).gain_matrix
        np.testing.assert_allclose(M.T, theirs, rtol=1e-10)
        acker = control.place_acker(A, B, poles)
        np.testing.assert_allclose(M[:, 0], acker, rtol=1e-10)


def test_scipy_refuses_what_is_placed_here():
    """More equal poles than inputs: a defective F, which its methods cannot make."""
    A, B, poles = borrowed.PLACEMENT["control, three at one place"]
    with pytest.raises(ValueError, match="repeated"):
        scipy.signal.place_poles(A, B, poles)
    plant, moved, _ = lagging(A, B, poles)
    observer = lb.reduced_order_observer(plant, moved)
    assert (observer.F.diagonal() == moved.real).sum() == 4


@pytest.mark.parametrize("name", ["double", "car, near zero", "two null vectors"])
def test_poles_that_do_not_decay_are_refused_as_they_are_given(name):
    A, B, poles = borrowed.PLACEMENT[name]
    plant, moved, left = lagging(A, B, poles)
    assert left > 0
    with pytest.raises(lb.CertificateError, match="not stable"):
        lb.reduced_order_observer(plant, moved + left)


def test_a_pair_that_cannot_be_placed_is_refused_with_its_modes():
    """TestPlacePoles.test_errors of SciPy: ones((4, 4)) and ones((4, 2))."""
    with pytest.raises(ValueError, match="not controllable|can't be placed|cannot"):
        scipy.signal.place_poles(np.ones((4, 4)), np.ones((4, 2)), (1, 2, 3, 4))
    plant = lb.Plant(np.ones((4, 4)), None, np.ones((2, 4)))
    with pytest.raises(lb.DesignError, match="not observable: the eigenvalue.*0"):
        lb.reduced_order_observer(plant, [-1, -2, -3])


@pytest.mark.parametrize("states", range(1, 6))
def test_random_systems_of_python_control(states):
    """TestStatefbk.testAcker: poles of one random system given to another."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", DeprecationWarning)
        np.random.seed(states)
        sys, poles = control.rss(states, 1, 1), control.rss(states, 1, 1).poles()
    plant, moved, _ = lagging(sys.A, sys.B, poles)
    observer = lb.reduced_order_observer(plant, moved)
    acker = control.place_acker(sys.A, sys.B, poles)
    M = gain(observer, states)
    np.testing.assert_allclose(M[:, 0], acker, atol=1e-9 * np.abs(acker).max())
