"""What a certificate says in any units, over time, and of each pole."""

from dataclasses import replace

import numpy as np
import pytest

import luenberger as lb


def over_steps(*F):
    """An observer whose error obeys e[k + 1] = F[k] e[k]."""
    F, N = np.array(F, float), len(F)
    r = F.shape[1]
    rows = lambda *shape: np.zeros((N, *shape))  # noqa: E731
    T = np.broadcast_to(np.eye(r), (N, r, r))
    return lb.Observer(
        F, rows(r, 0), rows(r, 1), T, rows(r, 1), T=T, L=np.eye(r), dt=1.0,
        T0=np.eye(r), G0=np.zeros((r, 0)),
    )  # fmt: skip


def plant(r):
    return lb.Plant(np.eye(r), None, np.ones((1, r)), dt=1.0)


TURN = [[0.0, 2.0], [0.0, 0.0]]
KEEP_FIRST = [[1.0, 0.0], [0.0, 0.0]]
KEEP_LAST = [[0.0, 0.0], [0.0, 1.0]]


@pytest.mark.parametrize(
    ("rows", "stable"),
    [
        # e2 becomes 2 e1, and e1 is kept: an error of (0, 1) has doubled
        ([TURN, KEEP_FIRST], False),
        # e1 is kept, e2 lost; and e1 is not turned: nothing is left
        ([KEEP_FIRST, TURN], True),
        ([KEEP_LAST, TURN], False),
        ([TURN, KEEP_LAST], True),
    ],
)
def test_rows_act_in_the_order_of_time(rows, stable):
    assert lb.certify(over_steps(*rows), plant(2)).stable is stable


@pytest.mark.parametrize(("growth", "stable"), [(1 - 1e-9, True), (1.0, False)])
def test_contraction_is_of_the_largest_error_not_of_the_slowest_pole(growth, stable):
    """[[0, g], [0, 0]] has both poles at zero and passes an error of size 1 on as g."""
    found = lb.certify(over_steps([[0, growth], [0, 0]]), plant(2))
    assert found.stable is stable


@pytest.mark.parametrize("F", [[[0.6, 0.6], [0, 0]], [[0.6, 0], [0.6, 0]]])
def test_size_of_an_error_is_its_length(F):
    """Of |F| = 0.6 sqrt(2): the largest sum of a row or column would be 1.2."""
    assert lb.certify(over_steps(F), plant(2)).stable


def test_no_states_no_poles():
    zero = np.zeros((2, 0))
    observer = lb.Observer(
        zero[:0], zero[:0], zero[:0], zero, zero, T=zero.T, L=np.eye(2), dt=1.0
    )
    found = lb.certify(observer, lb.Plant(np.eye(2), None, zero.T, dt=1.0))
    assert found.stable and found.sensitivity.shape == (0,)


@pytest.mark.parametrize("seed", range(5))
def test_poles_of_a_symmetric_matrix_are_as_sensitive_as_can_be(seed):
    """1 / |y'x| is 1 at best: rounding does not make it less."""
    F = np.random.default_rng(seed).normal(size=(6, 6))
    F = 0.1 * (F + F.T)
    zero = np.zeros((6, 1))
    observer = lb.Observer(
        F, zero[:, :0], zero, np.eye(6), zero, T=np.eye(6), L=np.eye(6), dt=1.0
    )
    found = lb.certify(observer, plant(6)).sensitivity
    assert (found >= 1).all() and found == pytest.approx(1, abs=1e-12)


@pytest.mark.parametrize("order", [[0, 1, 2, 3], [3, 1, 2, 0], [2, 3, 0, 1]])
def test_each_pole_has_its_own_sensitivity(order):
    """F has poles 0.1, 0.2 of a shear, (1 + c^2)^1/2 each, and 0.5, 0.9 alone: 1.

    Whatever the order of the states; of [[0.1, d], [0, 0.2]] is c = d / 0.1.
    """
    F = np.diag([0.1, 0.2, 0.5, 0.9])
    F[0, 1] = 3.0
    F = F[np.ix_(order, order)]
    zero = np.zeros((4, 1))
    observer = lb.Observer(
        F, zero[:, :0], zero, np.eye(4), zero, T=np.eye(4), L=np.eye(4), dt=1.0
    )
    found = lb.certify(observer, plant(4))
    wanted = dict(zip((0.1, 0.2, 0.5, 0.9), (901**0.5, 901**0.5, 1, 1)))
    assert len(found.poles) == 4
    for pole, size in zip(found.poles, found.sensitivity):
        (mine,) = (s for p, s in wanted.items() if abs(p - pole) < 1e-9)
        assert size == pytest.approx(mine, rel=1e-9)


def changed(observer, plant, rng):
    """The two with every state, output, input, estimate and z in another unit."""
    sizes = (plant.n, plant.p, plant.m, observer.order, len(observer.L))
    x, y, u, z, w = (2.0 ** rng.integers(-40, 41, size) for size in sizes)

    def moved(owner, **maps):
        pairs = ((k, getattr(owner, k) / a[:, None] * b) for k, (a, b) in maps.items())
        return replace(owner, **dict(pairs))

    return (
        moved(
            observer, F=(z, z), G=(z, u), D=(z, y), P=(w, z), V=(w, y), W=(w, u),
            T=(z, x), L=(w, x),
        ),
        moved(plant, A=(x, x), B=(x, u), C=(y, x), E=(y, u)),
    )  # fmt: skip


def in_integers(rng, dt):
    """An observer of x that meets its equations exactly, and its plant."""
    n, p, m = 3, int(rng.integers(1, 3)), 2
    A, B = rng.integers(-3, 4, (n, n)), rng.integers(-3, 4, (n, m))
    C, E = rng.integers(-3, 4, (p, n)), rng.integers(-3, 4, (p, m))
    D, V, T = rng.integers(-3, 4, (n, p)), rng.integers(-3, 4, (n, p)), np.eye(n)
    observer = lb.Observer(
        A - D @ C, B - D @ E, D, np.eye(n), V, T=T, L=T + V @ C, W=-V @ E, dt=dt
    )
    return observer, lb.Plant(A, B, C, E, dt=dt)


@pytest.mark.parametrize("dt", [0.0, 1.0])
@pytest.mark.parametrize("fault", "FGDPVWTL")
def test_a_fault_weighs_the_same_in_any_units(fault, dt):
    """As one part in a thousand of any entry, where the rest is exact."""
    for seed in range(6):
        rng = np.random.default_rng([ord(fault), seed])
        observer, plant = in_integers(rng, dt)
        wrong = getattr(observer, fault).copy()
        entry = tuple(rng.integers(0, size) for size in wrong.shape)
        wrong[entry] += (abs(wrong[entry]) or 1.0) / 1024
        broken = replace(observer, **{fault: wrong})
        found = lb.certify(broken, plant)
        for _ in range(3):
            right, other = changed(observer, plant, rng)
            assert lb.certify(right, other).worst == 0
            other = lb.certify(*changed(broken, plant, rng))
            for name in ("dynamics", "input", "output", "feedthrough"):
                wanted = getattr(found, name)
                assert getattr(other, name) == pytest.approx(wanted, rel=1e-9, abs=0)
        assert found.worst > 1e-6, (seed, entry)
