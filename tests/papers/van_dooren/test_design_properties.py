"""Random pairs: a certified observer or a refusal, never NaN or a silent miss."""

import warnings

import numpy as np
from drawn import bounded
from hypothesis import given
from hypothesis import strategies as st
from pairs import conjugates, hidden_chains, with_stairs

import luenberger as lb
from luenberger.numeric.staircase_form import staircase

quick = bounded(70)
methods = st.sampled_from(["minimum-norm", "back-substitution"])
stair_sizes = st.lists(st.integers(1, 4), min_size=1, max_size=5).map(sorted)
exponents = st.integers(-8, 8)


def poles_for(order, rng, kind, complex_):
    """Poles inside the unit circle: distinct, all equal, in pairs, or a mixture."""
    if kind == "pairs":
        return conjugates(order, rng)
    if kind == "equal pairs":
        return np.resize([0.2 + 0.3j, 0.2 - 0.3j], order // 2 * 2).tolist() + [0.1] * (
            order % 2
        )
    if kind == "equal":
        return np.full(order, 0.25)
    poles = 0.8 * rng.random(order) - 0.4
    return poles + 0.3j * rng.random(order) if complex_ else poles


def designed(plant, poles, method):
    """The observer and its certificate, or the refusal; NaN nowhere."""
    with warnings.catch_warnings():
        warnings.simplefilter("ignore", RuntimeWarning)
        warnings.simplefilter("error", np.exceptions.ComplexWarning)
        try:
            observer = lb.reduced_order_observer(plant, poles, method=method)
        except (lb.DesignError, lb.CertificateError) as refusal:
            assert "nan" not in str(refusal)
            return None, refusal
    for name in "FGDPVTW":
        assert np.isfinite(getattr(observer, name)).all(), name
    certificate = lb.certify(observer, plant)
    assert certificate.worst <= 1e-9 and certificate.stable
    whole = observer.P @ observer.T + observer.V @ plant.C - np.eye(plant.n)
    assert np.abs(whole).max() < 1e-3
    return observer, certificate


def assert_poles(observer, poles, complex_):
    wanted = np.asarray(poles, dtype=complex)
    diagonal = observer.F.diagonal()
    assert (diagonal == (wanted if complex_ else wanted.real)).all()
    found = np.sort_complex(observer.poles)
    gap = np.abs(np.poly(found) - np.poly(wanted)).max(initial=0)
    assert gap < 1e-12 * max(np.abs(np.poly(wanted)).max(initial=0), 1)


@quick
@given(
    stair_sizes,
    st.integers(0, 2**32 - 1),
    st.sampled_from(["distinct", "equal", "pairs", "equal pairs"]),
    st.booleans(),
    methods,
    exponents,
    exponents,
    st.integers(0, 2),
)
def test_random_stairs_and_scales(sizes, seed, kind, complex_, method, a, c, redundant):
    rng = np.random.default_rng(seed)
    A, C = with_stairs(tuple(sizes), rng, complex_)
    A = A * 10.0**a / np.linalg.norm(A, 2)
    C = np.vstack([C, rng.standard_normal((redundant, len(C))) @ C]) * 10.0**c
    B, E = rng.standard_normal((len(A), 2)), rng.standard_normal((len(C), 2))
    plant = lb.Plant(A, B, C, E, dt=1.0)
    poles = poles_for(len(A) - sizes[-1], rng, kind, complex_)
    observer, certificate = designed(plant, poles, method)
    if observer is not None:
        assert_poles(observer, poles, complex_)
        assert observer.is_complex <= complex_
        assert certificate.cond >= 1


@quick
@given(
    st.integers(1, 20),
    st.integers(1, 5),
    st.integers(0, 2**32 - 1),
    st.sampled_from(["distinct", "equal", "pairs", "equal pairs"]),
    st.booleans(),
    methods,
)
def test_well_conditioned_pairs_are_never_refused(n, p, seed, kind, complex_, method):
    A, C, rng = hidden_chains(max(n, p), p, seed, complex_)
    plant = lb.Plant(A, None, C, dt=1.0)
    poles = poles_for(len(A) - p, rng, kind, complex_)
    observer, certificate = designed(plant, poles, method)
    assert observer is not None, certificate
    assert_poles(observer, poles, complex_)
    assert certificate.worst < 1e-13


@quick
@given(
    st.lists(st.integers(1, 3), min_size=2, max_size=4).map(sorted),
    st.integers(0, 2**32 - 1),
    st.floats(-17, 0),
    st.sampled_from(["distinct", "equal", "pairs"]),
    methods,
)
def test_nearly_unobservable_pairs(sizes, seed, exponent, kind, method):
    """One stair made small, down to rounding: an observer or a refusal."""
    rng = np.random.default_rng(seed)
    n, top = sum(sizes), sizes[0]
    A, C = with_stairs(tuple(sizes), rng)
    form = staircase(A, C)
    weak = np.array(form.A)
    weak[top : top + sizes[1], :top] *= 10.0**exponent
    A = form.U @ (weak / np.linalg.norm(weak, 2)) @ form.U.T
    plant = lb.Plant(A, None, C, dt=1.0)
    poles = poles_for(n - sizes[-1], rng, kind, False)
    observer, outcome = designed(plant, poles, method)
    if observer is None:
        assert "unobservable" in str(outcome) or "not observable" in str(outcome)
    else:
        assert_poles(observer, poles, False)


@quick
@given(st.integers(1, 8), st.integers(1, 8), st.integers(0, 2**32 - 1), st.booleans())
def test_form_of_any_pair_with_small_integers(n, p, seed, complex_):
    """Integers in -1 .. 1 give every rank and many pairs that are not observable."""
    rng = np.random.default_rng(seed)
    A, C = rng.integers(-1, 2, (n, n)), rng.integers(-1, 2, (p, n))
    if complex_:
        A, C = A + 1j * rng.integers(-1, 2, (n, n)), C * 1j
    seen = np.vstack([C @ np.linalg.matrix_power(A, k) for k in range(n)])
    rank = np.linalg.matrix_rank(seen)
    try:
        form = staircase(A, C)
    except lb.DesignError:
        assert rank < n
        return
    assert rank == n
    levels = [
        np.linalg.matrix_rank(seen[: p * (k + 1)]) for k in range(len(form.blocks))
    ]
    assert list(form.blocks[::-1]) == np.diff([0, *levels]).tolist()
    scale = 50 * n * np.finfo(float).eps
    U, Y = form.U, form.Y
    assert np.linalg.norm(U.conj().T @ A @ U - form.A) <= scale * np.linalg.norm(A)
    assert np.linalg.norm(Y.conj().T @ C @ U - form.C) <= scale * np.linalg.norm(C)
    assert np.linalg.norm(U.conj().T @ U - np.eye(n)) <= scale * np.sqrt(n)
