"""Many records, smoothed together or one by one, are what each is by itself."""

import concurrent.futures
import dataclasses
import multiprocessing

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger import kernels
from luenberger.fleets import records as filtered
from luenberger.fleets.fleet import Fleet
from luenberger.recursion.settings import Settings
from luenberger.recursion.settled_pass import SettledPass
from luenberger.smoothing import fleet as module
from luenberger.smoothing.lanes import Lanes

needs_numba = pytest.mark.skipif(
    not kernels.runs_compiled("auto", 10**9), reason="numba is an optional extra"
)
spawn = multiprocessing.get_context("spawn")


def only(*ways):
    """The ways in which a test runs."""
    return pytest.mark.parametrize("backend", ways, indirect=True)


def records(seed, M=5, N=18, n=2):
    """Two states, so that one compiled text does for most of the tests."""
    rng = np.random.default_rng(seed)
    plant = generators.plant(rng, n, 2, m=1)
    y, u = rng.standard_normal((M, N, 2)), rng.standard_normal((M, N, 1))
    return plant, y, u


def records_of(plant, y, u):
    """Records as lanes take them."""
    way = SettledPass(Settings(plant, 0), None)
    return filtered.Records(Fleet(way, np.zeros(plant.m), y.shape[1], True), y, u)


def apart(plant):
    """The same plant with independent noises."""
    given = (getattr(plant, name) for name in "ABC")
    noises = dict(Q=plant.Q, R=plant.R, P0=plant.P0)
    return lb.Plant(*given, E=plant.E, dt=1.0, x0=plant.x0, **noises)


def known(kind, plant):
    """A state that is known for good, or three of which only one has noise."""
    A, Q, P0 = plant.A.copy(), np.diag([1.0, 1, 0]), np.diag([1.0, 0, 0])
    A[2] = [0, 0, 1]
    if kind == "chain":
        A, Q, P0 = np.eye(3) + np.eye(3, k=1) / 4, np.diag([0, 0, 1.0]), 0 * P0
    given = A, plant.B, plant.C
    return lb.Plant(*given, dt=1.0, Q=Q, R=np.eye(2), P0=P0, x0=[1, -1, 2])


def same(found, plant, y, u, which=None, digits=1e-10, **how):
    """Each record against the smoother of one."""
    for s in range(len(y)) if which is None else which:
        one = lb.smooth(plant, y[s], u[s], **how)
        for name in ("x", "std", "P"):
            mine, wanted = getattr(found, name)[s], getattr(one, name)
            scale = np.abs(wanted).max()
            rounding = dict(rtol=digits, atol=digits / 100 * scale)
            np.testing.assert_allclose(mine, wanted, **rounding)


EACH = [(seed, m1, lag) for seed in range(3) for m1 in (0, 1) for lag in (None, 4)]


@pytest.mark.parametrize(
    "backend, seed, m1, lag",
    [(way, *one) for way in ("numpy", "python") for one in EACH]
    + [("numba", 0, 0, None)],
    indirect=["backend"],
)
def test_each_record_is_what_it_is_by_itself(seed, m1, lag, backend):
    plant, y, u = records(seed)
    plant = plant if seed else apart(plant)
    y[1, 3:6, 0] = y[1, 9] = np.nan
    y[2, 12:] = y[3] = np.nan  # ends earlier; never measured
    how = dict(m1=m1, lag=lag, u0=[0.4])
    found = lb.smooth(plant, y, u, backend=backend, **how)
    same(found, plant, y, u, backend="numpy", **how)
    assert len(found) == 5 and "5 records of 18 rows" in repr(found)


KINDS = ["cross", "varying", "singular", "exact", "still", "known", "chain"]


@only("numpy", "python")
@pytest.mark.parametrize("kind", KINDS)
def test_plants_of_every_kind(kind, backend):
    rng = np.random.default_rng(4)
    plant, y, u = records(4, M=3, n=3)
    if kind == "varying":
        plant = generators.varying(rng, 3, 2, 30, m=1)
    elif kind == "cross":
        root = rng.standard_normal((5, 5))
        joint = root @ root.T
        plant = lb.Plant(
            plant.A, plant.B, plant.C, E=[[0.3], [1]], dt=1.0, Q=joint[:3, :3],
            S=joint[:3, 3:], R=joint[3:, 3:], P0=np.eye(3), x0=[1, 2, 3],
        )  # fmt: skip
    elif kind in ("known", "chain"):
        plant = known(kind, plant)
    else:
        R = np.zeros((2, 2)) if kind == "exact" else np.eye(2)
        P0 = np.diag([0.0, 0, 1]) if kind == "singular" else np.eye(3)
        Q = np.zeros((3, 3)) if kind == "still" else plant.Q
        plant = lb.Plant(plant.A, plant.B, plant.C, dt=1.0, Q=Q, R=R, P0=P0)
    y[:, 5:9, 1] = np.nan  # the same gaps
    y = np.concatenate([y, y[:1]])
    u = np.concatenate([u, u[:1]])
    y[3, 4:6] = y[3, 12:] = np.nan  # others, and an end
    found = lb.smooth(plant, y, u, backend=backend)
    same(found, plant, y, u, backend="numpy")


def test_records_with_the_same_gaps_are_filtered_once(monkeypatch):
    plant, y, u = records(1, M=70)
    y[:, 5:8] = np.nan
    y[4, 2] = np.nan
    read, numbers = module._Smooth.read, []
    monkeypatch.setattr(
        module._Smooth, "read",
        lambda self, y, u, number: numbers.append(number) or read(self, y, u, number),
    )  # fmt: skip
    lb.smooth(plant, y, u, backend="numpy")
    assert numbers == [0, 4]


def test_bits_do_not_depend_on_records_beside_nor_threads(backend):
    plant, y, u = records(7, M=70)
    plant = apart(plant)
    y[4, 5] = y[66, 5] = y[20:40, 3] = np.nan
    whole = lb.smooth(plant, y, u, backend=backend)
    order = np.random.default_rng(0).permutation(70)
    mixed = lb.smooth(plant, y[order], u[order], backend=backend)
    few = lb.smooth(plant, y[3:6], u[3:6], backend=backend)
    with concurrent.futures.ThreadPoolExecutor(3) as executor:
        threads = lb.smooth(plant, y, u, backend=backend, executor=executor, chunk=64)
    for name in ("x", "std", "P"):
        X = getattr(whole, name)
        np.testing.assert_array_equal(getattr(mixed, name), X[order])
        np.testing.assert_array_equal(getattr(few, name), X[3:6])
        np.testing.assert_array_equal(getattr(threads, name), X)


@needs_numba
def test_processes_change_no_bit():
    plant, y, u = records(7, M=70)
    plant = apart(plant)
    y[4, 5] = y[66, 5] = y[20:40, 3] = np.nan
    whole = lb.smooth(plant, y, u, backend="numba")
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=spawn) as executor:
        parts = lb.smooth(plant, y, u, backend="numba", executor=executor, chunk=64)
    for name in ("x", "std", "P"):
        np.testing.assert_array_equal(getattr(parts, name), getattr(whole, name))


@pytest.mark.parametrize(
    "backend, varying, n, M",
    [("python", False, 3, 40), ("python", True, 3, 40), ("numba", False, 2, 40),
     ("numba", True, 1, 8)],
    indirect=["backend"],
)  # fmt: skip
def test_lanes_smooth_all_that_they_can(backend, varying, n, M, monkeypatch):
    plant, y, u = records(8, 40, n=n)
    if varying:
        plant = generators.varying(np.random.default_rng(8), n, 2, 30, m=1)
    plant = apart(plant)
    y[3, 4:9], y[4, 11:], y[5], y[6, ::2, 0] = [np.nan] * 4
    y[10:20, 3:6, 1] = y[20:30, -2:] = np.nan  # the same gaps
    y, u = y[:M], u[:M]  # a few have no gaps that many share, and need less code
    monkeypatch.setattr(module._Smooth, "read", None)  # nothing is left for it
    found = lb.smooth(plant, y, u, u0=[0.3], backend=backend)
    monkeypatch.undo()
    some = [s for s in (0, 3, 4, 5, 6, 10, 19, 20, 39) if s < M]
    same(found, plant, y, u, some, u0=[0.3], backend="numpy")
    for s in some:  # alone, in the lanes of one record
        one = lb.smooth(plant, y[s : s + 1], u[s : s + 1], u0=[0.3], backend=backend)
        for name in ("x", "std", "P"):
            np.testing.assert_array_equal(
                getattr(one, name)[0], getattr(found, name)[s]
            )


@only("python")
@pytest.mark.parametrize("kind", ["known", "chain"])
def test_what_is_known_exactly_is_smoothed_in_lanes(kind, backend, monkeypatch):
    plant, y, u = records(5, M=12, n=3)
    plant = known(kind, plant)
    y[2, 3:6], y[3, ::2, 0] = np.nan, np.nan
    monkeypatch.setattr(module._Smooth, "read", None)
    found = lb.smooth(plant, y, u, backend=backend)
    monkeypatch.undo()
    same(found, plant, y, u, backend="numpy")
    for s in (0, 2):
        one = lb.smooth(plant, y[s], u[s], backend=backend)
        np.testing.assert_allclose(found.x[s], one.x, rtol=1e-10, atol=1e-12)
        np.testing.assert_allclose(found.P[s], one.P, rtol=1e-10, atol=1e-12)
    if kind == "known":
        assert not found.P[:, :, 2].any() and not found.P[:, :, :, 2].any()


@only("python")
def test_growth_is_noticed_where_no_lane_fails(backend):
    plant = lb.Plant(
        np.diag([10.0, 0.5]), None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]], P0=np.eye(2)
    )
    y = np.zeros((4, 20, 1))
    y[1, 3] = y[2, 4:] = y[3, 4:14] = np.nan
    with pytest.raises(lb.DesignError, match=r"^record 2: too few digits are left"):
        lb.smooth(plant, y[:3], backend=backend)
    with pytest.raises(lb.DesignError, match=r"^record 1: too few digits are left"):
        lb.smooth(plant, y[[0, 3]], backend=backend)


# by the pass in which they lose them
LOSING = {"forward": [*range(30)], "back": [3, 4, *range(12, 24)]}


def losing_digits(bad):
    """The first readings of a vague start, or long gaps before them."""
    plant, y, u = records(2, M=30, N=12)
    P0 = 1e12 * np.eye(2) if bad == "forward" else np.diag([1e4, 1])
    y[3, 0] = y[4, 0] = y[4, 5] = y[12:24, 0] = np.nan
    return dataclasses.replace(apart(plant), P0=P0), y, u


@only("python", "numba")
@pytest.mark.parametrize("bad", LOSING)
def test_a_lane_that_loses_digits_is_left(bad, backend):
    plant, y, u = losing_digits(bad)
    room = [np.empty((30, 12, *shape)) for shape in ((2,), (2,), (2, 2))]
    left = Lanes.of(records_of(plant, y, u)).smooth(*room)
    assert left.tolist() == LOSING[bad]
    done = np.setdiff1d(np.arange(30), left)
    same(lb.SmoothedFleet(*room), plant, y, u, done, digits=1e-8, backend="numpy")


@only("python")
@pytest.mark.parametrize("bad", LOSING)
def test_a_record_that_lanes_leave_is_smoothed_by_itself(bad, backend):
    plant, y, u = losing_digits(bad)
    found = lb.smooth(plant, y, u, backend=backend)
    same(found, plant, y, u, digits=1e-8, backend="numpy")


@needs_numba
def test_what_lanes_do_not_take():
    def lanes(plant, rows=5):
        y, u = (np.zeros((2, rows, k)) for k in (plant.p, plant.m))
        return Lanes.of(records_of(plant, y, u))

    def walk(n=1, p=1, R=1.0):
        R = R * np.eye(p)
        return lb.Plant(np.eye(n), None, np.eye(p, n), dt=1.0, Q=np.eye(n), R=R,
                        P0=np.eye(n))  # fmt: skip

    assert lanes(walk()) is not None
    assert lanes(walk(R=0.0)) is None and lanes(walk(), 0) is None
    assert lanes(walk(40, 8)) is None and lanes(walk(), 200_000) is None


@only("python")
def test_few_rows_are_compiled_where_such_were_before(backend, monkeypatch):
    plant, y, u = records(9)
    plant, used = apart(plant), []
    of = Lanes.of
    monkeypatch.setattr(Lanes, "of", lambda one: used.append(one) or of(one))
    lb.smooth(plant, y, u)
    assert not used
    lb.smooth(plant, y[0], u[0], backend=backend)  # the code of one record
    lb.smooth(plant, y, u)
    assert not used
    lb.smooth(plant, y, u, backend=backend)
    lb.smooth(plant, y, u)
    assert len(used) == 2


@pytest.mark.parametrize(
    "backend, noises",
    [(way, noises) for way in ("numpy", "python") for noises in ("apart", "correlated")]
    + [("numba", "apart")],
    indirect=["backend"],
)
def test_without_gaps_covariances_are_there_once(noises, backend):
    plant, y, u = records(6, M=9)
    plant = apart(plant) if noises == "apart" else plant
    found = lb.smooth(plant, y, u, backend=backend)
    same(found, plant, y, u, backend="numpy")
    for X in (found.std, found.P):
        assert X.strides[0] == 0 and not X.flags.writeable
    one = lb.smooth(plant, y[:1], u[:1], backend=backend)
    np.testing.assert_array_equal(one.P[0], found.P[8])
    np.testing.assert_array_equal(one.x[0], found.x[0])
    assert one.P.flags.writeable
    y[8, 3] = np.nan
    other = lb.smooth(plant, y, u, backend=backend)
    assert other.P.flags.writeable
    np.testing.assert_array_equal(other.P[:8], found.P[:8])


def test_covariances_whose_digits_would_go_are_carried_another_way(monkeypatch):
    """Rows before the first reading, of which later ones say nearly all."""
    A = np.array([[1.0, 0.1], [0, 1]])
    plant = lb.Plant(A, None, [[1, 0]], dt=1.0, Q=1e-4 * np.eye(2), R=[[1]],
                     P0=1e6 * np.eye(2))  # fmt: skip
    y = np.random.default_rng(1).standard_normal((3, 40, 1))
    y[:, :3] = np.nan
    lost, ask = [], module.covariances
    monkeypatch.setattr(
        module, "covariances", lambda *a: [lost.append(ask(*a)), lost[-1]][1]
    )
    found = lb.smooth(plant, y, backend="numpy")
    assert lost == [None]
    same(found, plant, y, np.zeros((3, 40, 0)), backend="numpy")


def test_a_continuous_plant_and_one_input_for_all():
    plant, y, u = records(2)
    found = lb.smooth(plant, y, u[0])
    same(found, plant, y, [u[0]] * 5)
    walk = lb.Plant([[0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    time = [0, 1, 5, 6]
    found = lb.smooth(walk, y[:, :4, :1], time=time)
    same(found, walk, y[:, :4, :1], [None] * 5, time=time)


def test_into_a_file_and_lists(tmp_path):
    plant, y, u = records(3)
    short = [y[0], y[1, :7]]
    found = lb.smooth(plant, short, [u[0], u[1, :7]])
    one = lb.smooth(plant, y[1, :7], u[1, :7])
    np.testing.assert_allclose(found.x[1, :7], one.x, rtol=1e-10, atol=1e-12)
    assert lb.smooth(plant, y, u, into=tmp_path / "all.npz") is None
    whole = lb.smooth(plant, y, u)
    with np.load(tmp_path / "all.npz") as kept:
        for name in ("x", "std", "P"):
            np.testing.assert_array_equal(kept[name], getattr(whole, name))


def test_what_is_wrong_is_said():
    plant, y, u = records(3)
    with pytest.raises(ValueError, match=r"or \(M, N, 2\) for many records"):
        lb.smooth(plant, y[..., :1], u)
    with pytest.raises(ValueError, match="chunk is for many records"):
        lb.smooth(plant, y[0], u[0], chunk=64)
    with pytest.raises(ValueError, match="lag must be a number of rows"):
        lb.smooth(plant, y, u, lag=-1)
    exact = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]], P0=[[1]])
    with pytest.raises(lb.DesignError, match=r"^record 1: at instant 2.*y\[k\]"):
        lb.smooth(exact, np.array([[[1.0], [1.0]], [[1.0], [2.0]]]))


def test_no_rows_and_no_records():
    plant, y, u = records(3)
    assert lb.smooth(plant, y[:0], u[:0]).P.shape == (0, 18, 2, 2)
    assert lb.smooth(plant, y[:, :0], u[:, :0]).P.shape == (5, 0, 2, 2)
