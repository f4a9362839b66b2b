"""Any plant and functional: a certified observer or a refusal, and Moore's remark."""

from fractions import Fraction

import numpy as np
from drawn import bounded
from hypothesis import assume, given
from hypothesis import strategies as st

import luenberger as lb
from luenberger.papers.moore.recurrences import recurrences

quick = bounded(20)
seeds = st.integers(0, 2**32 - 1)
sizes = st.integers(1, 6)
times = st.sampled_from([0.0, 0.5])


def integers(rng, *shape, most=4):
    return rng.integers(-most, most + 1, shape)


def designed(plant, k, **options):
    """The observer, or None; NaN nowhere, whatever happens."""
    try:
        observer = lb.functional_observer(plant, k, **options)
    except (lb.DesignError, lb.CertificateError) as refusal:
        assert "nan" not in str(refusal)
        return None
    for name in "FGDPVTW":
        assert np.isfinite(getattr(observer, name)).all(), name
    assert not observer.V.any() and not observer.W.any()
    certificate = lb.certify(observer, plant)
    assert certificate.worst < 1e-10 and certificate.stable
    return observer


def kappa(plant, k):
    """k in Moore's coordinates: k A^i g, C A^j g = 0 for j < n - 1, C A^(n-1) g = 1."""
    rows = [plant.C[0]]
    for _ in range(plant.n - 1):
        rows.append(rows[-1] @ plant.A)
    g = np.linalg.solve(np.array(rows), np.eye(plant.n)[-1])
    values = []
    for _ in range(plant.n):
        values.append(k @ g)
        g = plant.A @ g
    return np.array(values)


@bounded(40)
@given(seeds, sizes, st.integers(1, 3), times, st.integers(-6, 6), st.integers(-6, 6))
def test_floats_of_any_scale(seed, n, p, dt, a, c):
    rng = np.random.default_rng(seed)
    A = rng.standard_normal((n, n)) * (1.0 if dt else 10.0**a)
    C, B = rng.standard_normal((p, n)) * 10.0**c, rng.standard_normal((n, 1))
    plant = lb.Plant(A, B, C, rng.standard_normal((p, 1)), dt=dt)
    k = rng.standard_normal(n) * 10.0 ** rng.integers(-5, 6)
    observer = designed(plant, k)
    assert observer is not None  # observable: some order up to n will do
    assert observer.order <= n
    for found in recurrences(plant, k, orders=range(1, observer.order)):
        assert not found.stable


@quick
@given(seeds, st.integers(1, 5), st.integers(1, 2), times, st.booleans())
def test_exact_observers_are_exact_and_agree_with_floats(seed, n, p, dt, thirds):
    rng = np.random.default_rng(seed)
    parts = [integers(rng, *shape) for shape in ((n, n), (n, 1), (p, n), (p, 1), (n,))]
    A, B, C, E, k = (X * Fraction(1, 3) if thirds else X for X in parts)
    plant = lb.Plant(A, B, C, E, dt=dt)
    observer = designed(plant, k)
    floats = lb.Plant(plant.A, plant.B, plant.C, plant.E, dt=dt)
    other = designed(floats, k.astype(float))
    assert (observer is None) == (other is None)
    if observer is None:
        return
    assert observer.order == other.order
    o, exact = observer.exact, plant.exact
    A, B, C, E = (exact[name] for name in "ABCE")
    if observer.order:
        assert not (o["T"] @ A - o["F"] @ o["T"] - o["D"] @ C).any()
        assert not (o["T"] @ B - o["G"] - o["D"] @ E).any()
        assert not (o["P"] @ o["T"] - o["L"]).any()
    assert (o["L"] == k[None]).all() and not o["V"].any() and not o["W"].any()


@quick
@given(seeds, st.integers(2, 6), st.booleans())
def test_one_sign_needs_every_state(seed, n, negative):
    """Moore's remark: k of one sign in his coordinates, in continuous time."""
    rng = np.random.default_rng(seed)
    A, C = rng.standard_normal((n, n)), rng.standard_normal((1, n))
    plant = lb.Plant(A, None, C)
    turned = np.array([kappa(plant, row) for row in np.eye(n)])  # kappa = k turned
    wanted = rng.uniform(0.1, 1, n) * rng.choice([0, 1], n) * (-1 if negative else 1)
    wanted[rng.integers(n)] = -1 if negative else 1
    k = np.linalg.solve(turned.T, wanted)
    for found in recurrences(plant, k, orders=range(1, n)):
        assert not found.stable and found.decided != "search"
    for order in range(1, n):
        try:
            lb.functional_observer(plant, k, order=order)
        except lb.DesignError as refusal:
            assert "entries of k have one sign" in str(refusal)
            assert f"all n = {n} states" in str(refusal)
        else:
            raise AssertionError(f"order {order} was accepted")
    assert lb.functional_observer(plant, k).order == n


@quick
@given(seeds, st.integers(2, 6))
def test_fewer_states_need_both_signs(seed, n):
    rng = np.random.default_rng(seed)
    plant = lb.Plant(rng.standard_normal((n, n)), None, rng.standard_normal((1, n)))
    k = rng.standard_normal(n)
    observer = designed(plant, k)
    assume(observer is not None)  # it may be refused for its digits
    signs = np.sign(kappa(plant, k))
    assert observer.order == n or len(set(signs) - {0}) == 2


@quick
@given(seeds, st.integers(1, 4), st.integers(1, 2), times)
def test_poles_found_are_poles_admitted(seed, r, p, dt):
    rng = np.random.default_rng(seed)
    n = 2 * r + int(rng.integers(0, 3))
    A, C = rng.standard_normal((n, n)), rng.standard_normal((p, n))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    plant = lb.Plant(A, None, C, dt=dt)
    k = rng.standard_normal(n)
    for order in range(1, n + 1):
        found = recurrences(plant, k, orders=[order])[0]
        if found.stable and found.margin > 1e-2:
            again = designed(plant, k, poles=found.poles)
            assert again is not None and again.order == order
            gap = np.abs(np.poly(again.poles) - np.poly(found.poles))
            assert gap.max() < 1e-9 * np.abs(np.poly(found.poles)).max()
            off = found.poles.copy()
            off[np.argmax(np.abs(off.imag))] *= 1.01  # breaks a pair, or moves one
            if not off.imag.any() and found.dimension == 0:
                assert designed(plant, k, poles=off) is None
            break
