"""Records side by side: each is what it is by itself, and so are its bits."""

import dataclasses

import exact_filter
import numpy as np
import pytest
from as_python import as_python

import luenberger as lb
from luenberger import kernels
from luenberger.fleets import filter_block, in_numpy, own_gain, records
from luenberger.fleets.block import Block
from luenberger.fleets.fleet import Fleet
from luenberger.kernels import cache, fused
from luenberger.recursion.settings import Settings
from luenberger.recursion.settled_pass import SettledPass

N, M = 19, 26
SOME = {"all": slice(None), "gaps": slice(3, 22)}  # records of `measured`
KINDS = ("dense", "sparse", "correlated", "accurate", "known start", "vague start")
KINDS += ("prior", "perfect sensors")
needs_numba = pytest.mark.skipif(
    not kernels.runs_compiled("auto", 10**9), reason="numba is an optional extra"
)
uncompiled = pytest.mark.parametrize("backend", ["numpy", "python"], indirect=True)


def drawn(kind, varying=False, m=1, n=2, p=2, seed=0):
    """A plant of some kind."""
    rng = np.random.default_rng(seed)
    many = (N + 2,) if varying else ()
    A, C = rng.normal(size=(*many, n, n)) / 2, rng.normal(size=(*many, p, n))
    root = rng.normal(size=(*many, n + p, n + p)) / 2
    joint = root @ root.mT
    Q, R, P0, more = joint[..., :n, :n], joint[..., n:, n:], np.eye(n), {}
    if kind == "sparse":  # zeros and ones are known when code is written
        A, C = A * np.triu(np.ones((n, n))), C * np.eye(p, n)
        A[..., 0, 0] = C[..., 0, 0] = 1
    if kind == "correlated":
        more["S"] = joint[..., :n, n:]
    if kind == "known start":
        Q, P0 = np.broadcast_to(np.diag([1.0, 0]), Q.shape), np.zeros((n, n))
    if kind == "vague start":
        P0 = 1e11 * P0
    if kind == "prior":
        more["at_first"] = True
    if kind == "perfect sensors":
        C, R = np.broadcast_to(np.eye(p, n), C.shape), 0 * R
    B, E = rng.normal(size=(*many, n, m)), rng.normal(size=(*many, p, m))
    x0 = rng.normal(size=n)
    return lb.Plant(A, B, C, E=E, dt=1.0, Q=Q, R=R, P0=P0, x0=x0, **more)


def fleet_of(plant, rows=N, compile=False):
    """Any number of records of a plant."""
    way = SettledPass(Settings(plant, 0), None)
    return Fleet(way, np.zeros(plant.m), rows, compile)


def measured(plant, seed=1):
    """Records with gaps of their own, with the same gaps, and without any."""
    rng = np.random.default_rng(seed)
    y, u = rng.normal(size=(M, N, plant.p)), rng.normal(size=(M, N, plant.m))
    y[3, rng.random((N, plant.p)) < 0.3] = np.nan
    y[4, 10:] = np.nan  # ends earlier
    y[5] = y[6, ::2, 0] = y[7, 0] = np.nan
    y[8:22, 4:9, 1] = np.nan  # the same gaps
    return y, u


def same(found, one, s, tolerance=1e-12, least=0.0):
    """To `tolerance` of the largest; what is below `least` is rounding."""
    for name in ("x", "std", "P", "K"):
        mine, wanted = getattr(found, name), getattr(one, name)
        if wanted is not None:
            scale = max(tolerance * np.abs(wanted).max(), least)
            np.testing.assert_allclose(mine[s], wanted, rtol=tolerance, atol=scale)


# each way that records take in all four settings, what differs in a plant alone in two
SETTINGS = [
    (kind, varying, history)
    for kind in KINDS
    for varying in (False, True)
    for history in (False, True)
    if varying == history or kind in ("dense", "correlated")
]


# each compiles what no other one does; of two kinds only records with gaps, as records
# without any need other texts
COMPILED = [("dense", False, False), ("dense", False, True)]
COMPILED += [(kind, False, False) for kind in ("vague start", "correlated", "accurate")]


@pytest.mark.parametrize(
    "backend, kind, varying, history, some",
    [(way, *one, "all") for way in ("numpy", "python") for one in SETTINGS]
    + [("numba", *one, "gaps" if one[0] in KINDS[2:4] else "all") for one in COMPILED],
    indirect=["backend"],
)
def test_a_record_is_what_it_is_by_itself(kind, varying, history, some, backend):
    plant = drawn(kind, varying)
    y, u = (X[SOME[some]] for X in measured(plant))
    settings = dict(m1=int(kind == "accurate"), u0=[0.3], history=history)
    found = lb.filter_data(plant, y, u, backend=backend, **settings)
    digits = 1e-9 if kind == "vague start" else 1e-12  # of all ways, at a pivot of SAFE
    for s in (0, 3, 4, 5, 6, 7, 8, -5, -1):
        one = lb.filter_data(
            plant, y[s], u[s], backend="numpy", settle=None, **settings
        )
        same(found, one, s, digits, 1e-14 * (kind == "perfect sensors"))


BITS = "dense", "correlated", "accurate", "known start"


@pytest.mark.parametrize(
    "backend, kind",
    [(way, kind) for way in ("numpy", "python") for kind in BITS]
    + [("numba", "dense")],
    indirect=["backend"],
)
def test_bits_hang_on_no_other_record(kind, backend):
    plant = drawn(kind)
    y, _ = measured(plant)

    def filtered(which, history=False):
        return lb.filter_data(
            plant, y[which], m1=int(kind == "accurate"), history=history,
            backend=backend,
        )  # fmt: skip

    whole, kept = filtered(np.arange(M)), filtered(np.arange(M), history=True)
    order = np.random.default_rng(2).permutation(M)
    parts = [order, np.arange(7, 24), np.array([3]), np.array([9]), np.array([0])]
    for which in (*parts, np.arange(8, 12)):
        mine = filtered(which)
        for name in ("x", "std", "P"):
            wanted = getattr(whole, name)[which]
            np.testing.assert_array_equal(getattr(mine, name), wanted, err_msg=name)
    np.testing.assert_array_equal(kept.x, whole.x)
    np.testing.assert_array_equal(kept.std, whole.std)
    np.testing.assert_array_equal(kept.P[:, -1], whole.P)
    np.testing.assert_array_equal(filtered([9], history=True).K[0], kept.K[9])


@uncompiled
def test_the_same_gaps_are_one_covariance(monkeypatch, backend):
    plant, calls = drawn("correlated"), []
    y, u = measured(plant)
    one = records.Records.one
    monkeypatch.setattr(
        records.Records, "one", lambda self, *a: calls.append(a) or one(self, *a)
    )
    lb.filter_data(plant, y, u, backend=backend)
    assert [s for s, *_ in calls] == [0, 3, 4, 5, 6, 7, 8]


def test_numpy_takes_rows_of_many_records_at_once(monkeypatch):
    plant, calls = drawn("dense", varying=True), []
    y, u = measured(plant)
    one = records.Records.one
    monkeypatch.setattr(
        records.Records, "one", lambda self, *a: calls.append(a[0]) or one(self, *a)
    )
    monkeypatch.setattr(in_numpy, "MOST", 5)  # several parts
    found = lb.filter_data(plant, y, u, backend="numpy")
    assert calls == [0]  # which has no gaps
    monkeypatch.undo()
    np.testing.assert_array_equal(
        found.x, lb.filter_data(plant, y, u, backend="numpy").x
    )


def test_columns_that_lose_digits_are_left():
    rng = np.random.default_rng(4)
    A, C = rng.normal(size=(2, 2)) / 2, rng.normal(size=(2, 2))
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(2), R=np.eye(2), P0=1e11 * np.eye(2))
    y = rng.normal(size=(6, N, 2))
    y[2, 3], y[3, 0], y[4:] = np.nan, np.nan, np.nan
    fleet = fleet_of(plant)
    given, whole = records.Records(fleet, y, np.zeros((6, N, 0))), fleet.whole
    out = Block.empty(fleet.settings, y.shape, False)
    left = in_numpy.many(out, given, np.arange(2, 6), whole)
    assert 2 in left and 4 not in left
    found = lb.filter_data(plant, y, backend="numpy")
    for s in range(6):
        same(found, lb.filter_data(plant, y[s], backend="numpy", settle=None), s, 1e-9)


@uncompiled
def test_singular_covariances_are_exact(backend):
    third, half = 1 / 4, 1 / 2
    plant = lb.Plant(
        [[1, half], [0, 1]], None, [[1, 0], [1, 0]], dt=1.0, Q=[[0, 0], [0, half]],
        R=[[half, 0], [0, third]], P0=np.zeros((2, 2)), x0=[1, -1],
    )  # fmt: skip
    y = np.random.default_rng(3).integers(-8, 8, (20, 12, 2)) / 8
    y[3, 2:5] = y[4, 0] = y[5, ::2, 0] = y[6, 1:, 1] = np.nan
    found = lb.filter_data(plant, y, history=True, backend=backend)
    for s in (0, 3, 4, 5, 6):
        x, P = exact_filter.as_floats(exact_filter.run(plant, y[s]))
        np.testing.assert_allclose(found.x[s], x, rtol=1e-12, atol=1e-13)
        np.testing.assert_allclose(found.P[s], P, rtol=1e-12, atol=1e-13)


@pytest.mark.parametrize(
    "backend, kind",
    [("python", kind) for kind in ("dense", "known start", "vague start")]
    + [("numba", "dense"), ("numba", "vague start")],
    indirect=["backend"],
)
def test_a_lane_that_cannot_go_on_is_left(kind, backend):
    plant = drawn(kind)
    y, u = measured(plant)
    fleet = fleet_of(plant, compile=True)
    given, whole = records.Records(fleet, y, u), fleet.whole
    assert own_gain.does(whole)
    out = Block.empty(fleet.settings, y.shape, False)
    left = own_gain.own(out, given, np.arange(3, 22), whole)
    if kind == "vague start":  # a lane that reads nothing can go on
        assert 4 in left and 5 not in left
        assert set(range(8, 22)) <= set(left)  # with the same gaps
    else:
        assert not len(left)


@uncompiled
def test_the_record_is_named(backend):
    plant = lb.Plant(
        np.diag([10.0, 0.5]), None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]], P0=np.eye(2)
    )
    y = np.zeros((4, 20, 1))
    y[1:, 3] = np.nan  # short enough
    filter_block(fleet_of(plant, 20), y, np.zeros((4, 20, 0)))
    y[2, 3:15] = y[3, 3:15] = np.nan
    with pytest.raises(lb.DesignError, match=r"^record 2: too few digits are left"):
        lb.filter_data(plant, y, backend=backend)
    compile = backend == "numba"
    with pytest.raises(lb.DesignError, match=r"^record 103: too few digits"):
        fleet = fleet_of(plant, 20, compile)
        filter_block(fleet, y[3:], np.zeros((1, 20, 0)), first=103)


@uncompiled
@pytest.mark.parametrize("many", [1, 10])
def test_growth_is_noticed_where_no_pivot_fails(many, backend):
    plant = lb.Plant(
        np.diag([10.0, 0.5]), None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1]], P0=np.eye(2)
    )
    y = np.zeros((2 + many, 20, 1))
    y[1, 3] = y[2:, 4:] = np.nan  # and a lane before it that has a gap too
    with pytest.raises(lb.DesignError, match=r"^record 2: too few digits are left"):
        lb.filter_data(plant, y, backend=backend)


@needs_numba
def test_extremes_are_of_every_row(monkeypatch):
    plant, seen = drawn("dense"), []
    y, u = measured(plant)
    y[3:7, -1] = np.nan  # the last row is the largest, also of those at hand
    y[5, 15] = np.nan

    def grown(self, which, variances, at, least, most):
        seen.append((variances[at], least[at], most[at]))

    monkeypatch.setattr(records.Records, "grown", grown)
    lb.filter_data(plant, y, u, backend="numba")
    assert len(seen) > 1
    for variances, least, most in seen:
        np.testing.assert_array_equal(variances.min(axis=1), least)
        np.testing.assert_array_equal(variances.max(axis=1), most)


@needs_numba
def test_one_input_for_all():
    plant = drawn("dense")
    y, u = measured(plant)
    found = lb.filter_data(plant, y, u[0], backend="numba")
    for s in (0, 3):
        same(found, lb.filter_data(plant, y[s], u[0], settle=None), s)


@needs_numba
def test_sizes_beyond_panels():
    assert own_gain.does(fleet_of(drawn("dense"), compile=True).whole)
    big = drawn("dense", n=30, p=6)
    assert not own_gain.does(fleet_of(big, compile=True).whole)


@needs_numba
def test_lanes_read_the_matrices_of_every_row():
    """Of one state, which is known at first: a text of two takes longer to compile."""
    plant = drawn("dense", varying=True, n=1)
    Q = plant.Q.copy()
    Q[:4] = 0
    plant = dataclasses.replace(plant, Q=Q, P0=[[0]])
    y, u = (X[3:8] for X in measured(plant))
    found = lb.filter_data(plant, y, u, backend="numba")
    assert not found.std[:, :4].any() and found.std[:, 4:].all()
    for s in range(5):
        one = lb.filter_data(plant, y[s], u[s], settle=None, backend="numpy")
        same(found, one, s)


def test_lanes_are_compiled_in_the_order_of_their_text(monkeypatch):
    """Else the bits of a record would hang on how a compiler writes its lanes."""
    plant, orders = drawn("dense"), []
    y, u = measured(plant)
    with as_python():
        compiled = cache.compiled
        monkeypatch.setattr(
            cache, "compiled",
            lambda text, types, exact=False: orders.append(("in panels" in text, exact))
            or compiled(text, types, exact),
        )  # fmt: skip
        lb.filter_data(plant, y, u, backend="numba")
        monkeypatch.undo()
    assert (True, True) in orders and (True, False) not in orders


@pytest.mark.parametrize(
    "terms, number, text",
    [
        ([(1.0, ["a", "b"]), (1.0, ["c"])], 0.0, "fma(a, b, c)"),
        ([(-1.0, ["a", "b"]), (1.0, ["c"])], 0.0, "fma(-a, b, c)"),
        ([(1.0, ["a", "b"]), (-2.0, ["c", "d"])], 0.0, "fma(-(2.0 * c), d, a * b)"),
        ([(-1.0, ["a"])], 1.0, "1.0 - a"),
        ([(-1.0, ["a", "b"])], 0.0, "-a * b"),
        ([(1.0, ["a"]), (1.0, ["b"])], 0.0, "a + b"),
        ([(-1.0, ["a", "b", "c"]), (1.0, ["d"])], 0.0, "fma(-(a * b), c, d)"),
        ([], 0.0, ""),
    ],
)
def test_products_are_joined_with_sums(terms, number, text):
    assert fused.joined(terms, number) == text
