"""Deadbeat observers: Van Dooren's with all poles zero, exact after p_M samples."""

import warnings
from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from drawn import bounded
from hypothesis import given
from hypothesis import strategies as st

import luenberger as lb
from luenberger.papers.kawazoe.derivation import deadbeat
from luenberger.papers.kawazoe.derivation import form as canonical
from luenberger.papers.kawazoe.derivation.deadbeat import Pi
from luenberger.papers.kawazoe.form import observability_form
from luenberger.papers.kawazoe.reconstruction import reconstruct_state

PATTERNS = [*canonical.PATTERNS, (1,), (3,), (1, 2), (4, 1), (1, 3, 2)]
METHODS = ("staircase", "canonical")


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_design_follows_the_derivation(indices):
    """In Kawazoe's own coordinates the exact design is the derivation, with numbers."""
    of = canonical.Pattern(indices)
    numbers = {s: sp.Rational(k + 1, 3 + k % 4) for k, s in enumerate(symbols(of.Phi))}
    Phi = of.Phi.subs(numbers)
    plant = lb.Plant(Phi.tolist(), None, of.H.tolist(), dt=1.0)
    found = lb.deadbeat_observer(plant, method="canonical")
    derived = {
        s.name: value.subs(numbers) for s, value in deadbeat.observer(of).items()
    }
    derived["T"] = derived.pop("T_U") * deadbeat.by_level(of)[Pi]
    for name in "TFD":
        expected = np.array(derived[name].tolist(), float).reshape(derived[name].shape)
        assert np.allclose(getattr(found, name), expected, rtol=1e-14)


def symbols(matrix):
    return sorted(matrix.free_symbols, key=str)


def record(plant, N, seed=1):
    rng = np.random.default_rng(seed)
    u, x = rng.normal(size=(N, plant.m)), [rng.normal(size=plant.n)]
    for k in range(N - 1):
        x.append(plant.A @ x[k] + plant.B @ u[k])
    x = np.array(x)
    return x, x @ plant.C.T + u @ plant.E.T, u


def errors(observer, plant, N=20):
    """Largest error of the estimate at each sample, from a wrong start."""
    x, y, u = record(plant, N)
    start = 10 * np.random.default_rng(3).normal(size=observer.order)
    return np.abs(lb.estimate(observer, lb.Record(y, u), z0=start) - x).max(axis=1)


def random_plant(seed, n, p, singular=False):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) / np.sqrt(n)
    A = A @ np.diag([0, *np.ones(n - 1)]) if singular else A
    B, E = rng.normal(size=(n, 1)), rng.normal(size=(p, 1))
    noise = dict(Q=np.eye(n), R=np.eye(p))
    return lb.Plant(A, B, rng.normal(size=(p, n)), E, dt=1.0, **noise)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("singular", [False, True])
@pytest.mark.parametrize("n, p", [(2, 1), (4, 1), (5, 2), (6, 2), (7, 3), (6, 4)])
def test_exact_after_p_M_samples(n, p, singular, method):
    plant = random_plant(10 * n + p, n, p, singular)
    observer = lb.deadbeat_observer(plant, method=method)
    samples = observability_form(plant).samples
    assert observer.order == n - p and samples == -(-n // p)
    certificate = lb.certify(observer, plant)
    assert certificate.worst < 1e-14 and (certificate.poles == 0).all()
    assert not np.linalg.matrix_power(observer.F, samples - 1).any()
    error = errors(observer, plant)
    assert error[samples - 1 :].max() < 1e-9 < 1e-3 < error[0]


def test_the_estimate_is_the_reconstructed_state():
    plant = random_plant(5, 6, 2)
    x, y, u = record(plant, 12)
    observer = lb.deadbeat_observer(plant)
    estimate = lb.estimate(observer, lb.Record(y, u), z0=np.ones(4))
    state = reconstruct_state(plant, y, u, at="end")
    assert np.allclose(estimate[2:], state, rtol=0, atol=1e-9)


def test_published_ogata():
    """Ogata, Discrete-Time Control Systems 2e, chapter 6: double integrator, 0.2 s.

    Minimum order: Ke = 5, z+ = 0 z - 5 y + 0.1 u, and
    x2^(k) = 5 y(k) - 5 y(k-1) + 0.1 u(k-1), which is a 2-sample reconstruction.
    """
    h = Fraction(1, 5)
    exact = lb.Plant([[1, h], [0, 1]], [[h**2 / 2], [h]], [[1, 0]], dt=0.2)
    floats = lb.Plant(exact.A, exact.B, exact.C, dt=0.2)
    for method in METHODS:
        for plant in (exact, floats):
            o = lb.deadbeat_observer(plant, method=method)
            assert o.order == 1 and o.F == 0
            found = [o.V[1, 0], (o.P @ o.D)[1, 0], (o.P @ o.G)[1, 0]]
            assert np.allclose(found, [5, -5, 0.1], rtol=0, atol=1e-12)
    form = observability_form(exact)
    x = reconstruct_state(
        exact, [[Fraction(3)], [Fraction(4)]], [[Fraction(2)], [Fraction(0)]], at="end"
    )
    assert x[0, 1] == 5 * 4 - 5 * 3 + Fraction(1, 10) * 2
    assert form.samples == 2
    # full order predictor: A - K C nilpotent for Ke = [2, 5], and only for it
    K = np.array([[2], [5]])
    closed = floats.A - K @ floats.C
    assert np.allclose(closed @ closed, 0, atol=1e-12)


def response(observer, terms):
    """What the estimate makes of y and u: V, P D, P F D, ..., free of coordinates."""
    o, out, power = observer, [np.hstack([observer.V, observer.W])], observer.P
    for _ in range(terms):
        out.append(power @ np.hstack([o.D, o.G]))
        power = power @ o.F
    return np.array(out)


@pytest.mark.parametrize("n", [2, 3, 5, 8])
def test_one_output_is_van_dooren_with_poles_zero(n):
    """One output leaves no freedom: the same observer up to coordinates of z."""
    plant = random_plant(n, n, 1)
    mine = lb.deadbeat_observer(plant)
    for method in ("minimum-norm", "back-substitution"):
        other = lb.reduced_order_observer(plant, np.zeros(n - 1), method=method)
        a, b = response(mine, n + 2), response(other, n + 2)
        assert np.allclose(a, b, rtol=0, atol=1e-9 * np.abs(b).max())
        M = np.linalg.lstsq(mine.T.T, other.T.T, rcond=None)[0].T  # T_other = M T
        both = np.vstack([mine.T, plant.C])
        X = other.T @ np.linalg.inv(both)
        assert np.allclose(X[:, -1:] @ plant.C + X[:, :-1] @ mine.T, other.T)
        M = X[:, :-1]
        assert np.allclose(M @ mine.F, other.F @ M, atol=1e-8 * np.abs(M).max())


def test_one_output_is_ackermann():
    """Independent: Ackermann's formula on the dual of the reduced problem."""
    n = 5
    rng = np.random.default_rng(11)
    A, B = rng.normal(size=(n, n)), rng.normal(size=(n, 1))
    plant = lb.Plant(A, B, np.eye(n)[:1], dt=1.0)
    Abb, Aab = A[1:, 1:], A[:1, 1:]
    O = np.vstack([Aab @ np.linalg.matrix_power(Abb, k) for k in range(n - 1)])  # noqa: E741
    Ke = np.linalg.matrix_power(Abb, n - 1) @ np.linalg.solve(O, np.eye(n - 1)[:, -1:])
    observer = lb.deadbeat_observer(plant)
    assert np.allclose(observer.V, np.vstack([[[1]], Ke]), rtol=1e-8)


@pytest.mark.parametrize("indices", [(2, 2), (3, 1), (2, 2, 1), (3, 2)], ids=str)
def test_several_outputs_solve_van_doorens_rows(indices):
    """T has the form (13) in staircase coordinates, with F strictly lower there.

    Van Dooren's least-norm rows are another solution: nilpotent too, but in general
    exact only after n - p + 1 samples.
    """
    n, p = sum(indices), len(indices)
    plant = random_plant(n, n, p)
    mine = lb.deadbeat_observer(plant)
    other = lb.reduced_order_observer(plant, np.zeros(n - p))
    assert not np.triu(mine.F).any() and not np.triu(other.F).any()
    assert errors(mine, plant)[-(-n // p) - 1 :].max() < 1e-9
    assert errors(other, plant)[n - p :].max() < 1e-9
    # both T, and C, span the state space, and both satisfy (4)
    for observer in (mine, other):
        assert np.linalg.matrix_rank(np.vstack([observer.T, plant.C])) == n
        assert lb.certify(observer, plant).worst < 1e-14


def test_noise_of_both_is_finite_and_comparable():
    plant = random_plant(3, 6, 2)
    mine = lb.deadbeat_observer(plant)
    other = lb.reduced_order_observer(plant, np.zeros(4))
    best = lb.kalman_filter(plant)
    trace = [np.trace(lb.error_covariance(o, plant)) for o in (best, mine, other)]
    assert trace[0] < min(trace[1:]) and np.isfinite(trace).all()


def rotated(A, C, seed, B=None):
    """The same plant in other orthonormal coordinates."""
    n = len(A)
    turn = scipy.linalg.qr(np.random.default_rng(seed).normal(size=(n, n)))[0]
    B = np.ones((n, 1)) if B is None else B
    return lb.Plant(turn @ A @ turn.T, turn @ B, C @ turn.T, dt=1.0)


HIDDEN = np.zeros((6, 6))
HIDDEN[0, 1] = HIDDEN[1, 2] = 1  # three states in a chain that no output sees
HIDDEN[:3, 3:] = [[1, 2, 0], [0, 1, 1], [3, 0, 1]]
HIDDEN[3:, 3:] = [[0.5, 1, 0], [0, 0.2, 1], [0.3, 0, 0.9]]
SEES = np.array([[0, 0, 0, 1, 0, 0.5]])


@pytest.mark.parametrize("seed", range(6))
def test_hidden_modes_that_die_out(seed):
    plant = rotated(HIDDEN, SEES, seed)
    observer = lb.deadbeat_observer(plant)
    assert observer.order == 5
    assert (lb.certify(observer, plant).poles == 0).all()
    assert errors(observer, plant)[3:].max() < 1e-9  # max(p_M - 1, 3) = 3


def test_a_plant_that_forgets_needs_no_output():
    plant = lb.Plant([[0, 1], [0, 0]], [[1], [1]], [[0, 0]], dt=1.0)
    observer = lb.deadbeat_observer(plant)
    assert observer.order == 2 and not observer.D.any()
    assert errors(observer, plant)[2:].max() < 1e-12


@pytest.mark.parametrize("scale", [1, 1e-8, 1e8])
def test_delay_line(scale):
    """Singular and nilpotent A, every state seen."""
    plant = lb.Plant(np.eye(4, k=-1) * scale, None, np.eye(4)[3:], dt=1.0)
    observer = lb.deadbeat_observer(plant)
    assert lb.certify(observer, plant).worst < 1e-15 and observer.order == 3


def test_redundant_outputs():
    plant = random_plant(8, 5, 2)
    mix = np.array([[1, 0], [0, 1], [1, 1], [0, 2]])
    more = lb.Plant(plant.A, plant.B, mix @ plant.C, mix @ plant.E, dt=1.0)
    for method in METHODS:
        observer = lb.deadbeat_observer(more, method=method)
        assert observer.order == 3 and lb.certify(observer, more).worst < 1e-14
        assert errors(observer, more)[2:].max() < 1e-9


def test_all_states_measured():
    plant = random_plant(4, 3, 3)
    observer = lb.deadbeat_observer(plant)
    assert observer.order == 0 and errors(observer, plant).max() < 1e-10


def test_complex_plant():
    rng = np.random.default_rng(2)
    A = rng.normal(size=(5, 5)) + 1j * rng.normal(size=(5, 5))
    C = rng.normal(size=(2, 5)) + 1j * rng.normal(size=(2, 5))
    plant = lb.Plant(A, rng.normal(size=(5, 1)), C, dt=1.0)
    for method in METHODS:
        observer = lb.deadbeat_observer(plant, method=method)
        assert lb.certify(observer, plant).worst < 1e-14
        assert not np.linalg.matrix_power(observer.F, 2).any()


def network():
    """80 units coupled at random, one electrode: cond(P) is 3e17."""
    rng = np.random.default_rng(5)
    A, C = rng.normal(size=(80, 80)) / np.sqrt(80), rng.normal(size=(1, 80))
    return lb.Plant(A, None, C, dt=1.0)


def test_staircase_keeps_the_digits_that_the_canonical_form_loses():
    plant = network()
    form = observability_form(plant)
    assert form.cond > 1e16
    modes = [np.sort_complex(np.linalg.eigvals(X)) for X in (form.Phi, plant.A)]
    assert np.abs(modes[0] - modes[1]).max() > 0.1
    with pytest.raises(lb.DesignError, match="Use method='staircase'"):
        lb.deadbeat_observer(plant, method="canonical")
    observer = lb.deadbeat_observer(plant)
    x, y, _ = record(plant, 85)
    error = np.abs(lb.estimate(observer, y) - x).max(axis=1)
    assert error[79] < 1e-10 * np.abs(x[79]).max()


@pytest.mark.parametrize(
    "call, error, message",
    [
        (
            lambda: lb.deadbeat_observer(lb.Plant([[1]], None, [[1]])),
            lb.DesignError,
            "continuous",
        ),
        (
            lambda: lb.deadbeat_observer(
                lb.Plant(np.stack([np.eye(2)] * 3), None, np.eye(2), dt=1.0)
            ),
            lb.DesignError,
            "time-varying",
        ),
        (
            lambda: lb.deadbeat_observer(
                lb.Plant([[1]], None, [[1]], dt=1), method="x"
            ),
            ValueError,
            "method must be 'staircase' or 'canonical', got 'x'",
        ),
        (
            lambda: lb.deadbeat_observer(
                rotated(HIDDEN + np.diag([0.25, 0, 0, 0, 0, 0]), SEES, 0)
            ),
            lb.DesignError,
            r"mode\(s\) 0.25 do not reach.*finite time. An observer with other poles",
        ),
        (
            lambda: lb.deadbeat_observer(
                rotated(HIDDEN + np.diag([0, 0, -1.5, 0, 0, 0]), SEES, 0)
            ),
            lb.DesignError,
            r"mode\(s\) -1.5 do not reach.*finite time. Add a sensor",
        ),
        (
            lambda: lb.deadbeat_observer(
                lb.Plant(np.diag([0.4, 0.5, 0]), None, [[0, 0, 1]], dt=1.0)
            ),
            lb.DesignError,
            r"mode\(s\) 0.4, 0.5 do not reach the outputs and are not zero.*decays",
        ),
        (
            lambda: lb.deadbeat_observer(rotated(HIDDEN, SEES, 0), method="canonical"),
            lb.DesignError,
            "modes 0 do not reach them. They die out in finite time",
        ),
        (
            lambda: lb.deadbeat_observer(slow(24)),
            lb.DesignError,
            r"cond\(\[T; C\]\) = .*no correct digit. Add sensors",
        ),
    ],
)
def test_refusals(call, error, message):
    with pytest.raises(error, match=message):
        call()


def slow(n):
    """Modes crowded on a line, one output."""
    return lb.Plant(np.diag(np.linspace(0.4, 1, n)), None, np.ones((1, n)), dt=1.0)


def test_warning_names_the_condition():
    with pytest.warns(RuntimeWarning, match=r"cond\(\[T; C\]\) = .*can lose 1. digits"):
        lb.deadbeat_observer(slow(11))


@bounded(70)
@given(
    n=st.integers(1, 8),
    p=st.integers(1, 8),
    seed=st.integers(0, 10**6),
    kind=st.sampled_from(["plain", "integer", "structured", "nearly hidden", "sparse"]),
    scale=st.sampled_from([0, 3, 8]),
)
def test_certified_or_refused(n, p, seed, kind, scale):
    """Any pair, any units: a certified observer or a refusal, and never NaN."""
    plant = awkward(np.random.default_rng(seed), n, p, kind, scale)
    for method in METHODS:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", RuntimeWarning)
            try:
                observer = lb.deadbeat_observer(plant, method=method)
            except (lb.DesignError, lb.CertificateError):
                continue
        certificate = lb.certify(observer, plant)
        assert certificate.worst < 1e-9 and certificate.stable
        assert np.isfinite(observer.P).all() and not certificate.poles.any()
        # a column of C that is almost zero may be called zero: one state more
        assert n - np.linalg.matrix_rank(unit_rows(plant)) <= observer.order <= n


def unit_rows(plant):
    """C with outputs and states in comparable units, for its rank."""
    C = plant.C
    for _ in range(20):
        for axis in (0, 1):
            size = np.abs(C).max(axis=axis, keepdims=True)
            C = C / np.where(size > 0, size, 1)
    return C


def awkward(rng, n, p, kind, scale):
    A, C = rng.normal(size=(n, n)), rng.normal(size=(p, n))
    if kind == "integer":
        A, C = rng.integers(-3, 4, (n, n)), rng.integers(-2, 3, (p, n))
    if kind == "structured":  # repeated modes and chains
        A = np.eye(n) * rng.choice([0, 0.5, 1]) + np.eye(n, k=1)
        C = np.eye(n)[rng.integers(0, n, p)]
    if kind == "sparse":
        A = A * (rng.random((n, n)) < 0.4)
    if kind == "nearly hidden":
        A[: n - n // 2, n - n // 2 :] *= 10.0 ** -rng.integers(6, 16)
        C[:, n - n // 2 :] *= 10.0 ** -rng.integers(6, 16)
    d, s = 10 ** rng.uniform(-scale, scale, n), 10 ** rng.uniform(-scale, scale, p)
    if scale:
        A, C = A / d[:, None] * d, C * d / s[:, None]
    return lb.Plant(A, None, C, dt=1.0)
