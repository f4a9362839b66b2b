"""`smooth`: the same by other programs, in pieces, in tables; and what it refuses."""

import functools

import many_digits
import numpy as np
import pandas as pd
import pytest
from statsmodels.tsa.statespace.mlemodel import MLEModel

import luenberger as lb
from luenberger import kernels
from luenberger.smoothing import backward
from luenberger.smoothing.finish import ways
from luenberger.smoothing.record import Smoother

SIZES = [(1, 1), (3, 2), (7, 3)]  # the last one is written in loops
NAMES = "x std P lag_one w v".split()
GROWN = 1e-5  # of a standard deviation


def plant_of(seed, n=3, p=2, linked=False, **more):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A /= np.abs(np.linalg.eigvals(A)).max() * rng.uniform(1, 1.5)
    root = rng.normal(size=(n + p, n + p))
    joint = root @ root.T
    noise = dict(Q=joint[:n, :n], R=joint[n:, n:])
    if linked:
        noise["S"] = joint[:n, n:]
    half = rng.normal(size=(n, n))
    C = rng.normal(size=(p, n))
    plant = dict(A=A, B=None, C=C, dt=1.0, P0=half @ half.T, **noise) | more
    return lb.Plant(**plant), rng


def driven(n, p):
    """An input, as the plants of `test_fleet` have one: then the same text does."""
    return dict(B=np.ones((n, 1)) / 2, E=np.ones((p, 1)) / 2)


def only(*ways):
    """The ways in which a test runs."""
    return pytest.mark.parametrize("backend", ways, indirect=True)


def readings(plant, rng, N, holes=0.2):
    y = rng.normal(size=(N, plant.p))
    y[rng.random(y.shape) < holes] = np.nan
    return y


def agree(one, two, rtol=1e-11):
    for name in NAMES:
        a, b = (np.asarray(getattr(found, name)) for found in (one, two))
        scale = np.abs(b).max(initial=0) or 1
        np.testing.assert_allclose(a, b, rtol=0, atol=rtol * scale, err_msg=name)


@pytest.mark.parametrize("seed", range(40))
def test_statsmodels_smooths_the_same(seed):
    plant, rng = plant_of(seed, at_first=True, x0=[1, 2, 3])
    y = readings(plant, rng, 60)
    model = MLEModel(y, k_states=3, k_posdef=3)
    model["design"], model["transition"] = plant.C, plant.A
    model["selection"], model["state_cov"] = np.eye(3), plant.Q
    model["obs_cov"] = plant.R
    model.initialize_known(plant.x0, plant.P0)
    theirs, ours = model.ssm.smooth(), lb.smooth(plant, y)
    size = np.abs(ours.x).max()
    np.testing.assert_allclose(ours.x, theirs.smoothed_state.T, atol=1e-10 * size)
    found = theirs.smoothed_state_cov.transpose(2, 0, 1)
    np.testing.assert_allclose(ours.P, found, atol=1e-10 * np.abs(ours.P).max())
    w = theirs.smoothed_state_disturbance.T
    np.testing.assert_allclose(ours.w, w, atol=1e-10 * np.abs(ours.w).max())
    v = theirs.smoothed_measurement_disturbance.T
    whole = ~np.isnan(y).any(axis=1)
    np.testing.assert_allclose(ours.v[whole], v[whole], atol=1e-10 * size)


@pytest.mark.parametrize(
    "backend, n, p, linked",
    [("python", *size, kind) for size in SIZES for kind in (False, True)]
    + [("numba", 2, 2, False), ("numba", 1, 1, True)],
    indirect=["backend"],
)
def test_compiled_code_does_the_same(n, p, linked, backend):
    plant, rng = plant_of(5, n, p, linked, **driven(n, p))
    y = readings(plant, rng, 60)
    agree(*(lb.smooth(plant, y, backend=b) for b in (backend, "numpy")))


@only("numba")
def test_the_way_back_is_compiled_as_loops(backend, monkeypatch):
    """As for a large plant, whose text takes longer to compile."""
    monkeypatch.setattr(kernels, "UNROLLED", 0)
    anew = functools.cache(kernels.over_record.__wrapped__)
    monkeypatch.setattr(kernels, "over_record", anew)
    plant, rng = plant_of(5, 2, 1)
    y, found = readings(plant, rng, 60), []
    for compile in (True, False):
        one = Smoother(plant, 0, None, None, "numpy")
        one.begin(np.zeros(0))
        one.read(y, None)
        leads = ways(one.settings, 1, ~np.isnan(y))
        found.append(backward.smoothed(one.kept, leads, compile, neighbours=True))
    for name in "x Sigma U lamda deviations".split():
        mine, wanted = (getattr(one, name)[:60] for one in found)
        rounding = 1e-11 * np.abs(wanted).max()
        np.testing.assert_allclose(mine, wanted, rtol=0, atol=rounding, err_msg=name)


@only("python")
def test_compiled_code_leaves_rows_that_lose_digits_to_numpy(backend):
    plant, rng = plant_of(5, P0=1e14 * np.eye(3))
    y = readings(plant, rng, 60)
    y[20:40] = np.nan
    agree(*(lb.smooth(plant, y, backend=b) for b in (backend, "numpy")), 1e-9)


@pytest.mark.parametrize(
    "backend, n, p",
    [("python", 3, 2), ("python", 8, 3), ("numba", 1, 1)],
    indirect=["backend"],
)
def test_compiled_code_of_a_plant_that_differs_from_row_to_row(n, p, backend):
    plant, rng = plant_of(4, n, p)
    vary = {k: getattr(plant, k) for k in ("A", "C", "Q", "R")}
    for k, X in vary.items():
        vary[k] = X * rng.uniform(0.3, 1, (62, 1, 1) if k in "QR" else (62, *X.shape))
    A, C, Q, R = vary.values()
    plant = lb.Plant(A, None, C, dt=1.0, Q=Q, R=R, P0=plant.P0)
    y = readings(plant, rng, 60)
    agree(*(lb.smooth(plant, y, backend=b) for b in (backend, "numpy")))


@only("python")
@pytest.mark.parametrize("kind", ["known", "alike"])
@pytest.mark.parametrize("n, p", [(3, 1), (8, 2)], ids=["scalars", "loops"])
def test_compiled_code_gives_up_single_rows_and_goes_on(
    n, p, kind, backend, monkeypatch
):
    """Now and then two states are set alike: NumPy does those rows.

    A state that is set to zero, and so is known, stays in compiled code.
    """
    plant, rng = plant_of(3, n, p)
    y, rows = readings(plant, rng, 150), [0, 3, 40, 41, 75, 149]
    every = {k: np.repeat(getattr(plant, k)[None], 152, axis=0) for k in "ACQR"}
    A, C, Q, R = every.values()
    if kind == "known":
        A[rows, 0] = Q[rows, 0] = Q[rows, :, 0] = 0
    else:
        A[rows, 0], Q[rows, 0] = A[rows, 1], Q[rows, 1]
        Q[rows, :, 0] = Q[rows, :, 1]
    plant = lb.Plant(A, None, C, dt=1.0, Q=Q, R=R, P0=plant.P0)
    done, by_hand = backward._row, []

    def row(kept, ways, k, *more):
        by_hand.append(k)
        return done(kept, ways, k, *more)

    monkeypatch.setattr(backward, "_row", row)
    found = lb.smooth(plant, y, backend=backend)
    assert set(by_hand) <= set(rows) and bool(by_hand) == (kind == "alike")
    agree(found, lb.smooth(plant, y, backend="numpy"), 1e-9)


def growing(n):
    """A plant with an unstable mode; of two states, one that is compiled anyway."""
    mode = np.array([[1, 0.5, -1], [0.3, 1, 0.2], [-0.7, 0.4, 1]])[:n, :n]
    A = mode @ np.diag([2, 0.9, 0.5][:n]) @ np.linalg.inv(mode)
    if n == 2:
        return plant_of(5, 2, 2, A=A, **driven(2, 2))[0]
    noise = dict(Q=np.diag([1, 2, 0.1]), R=[[1]], P0=np.eye(3))
    return lb.Plant(A, None, [[1, 2, -1]], dt=1.0, **noise)


@pytest.mark.parametrize(
    "backend, n", [("numpy", 3), ("numba", 2)], indirect=["backend"]
)
@pytest.mark.parametrize("lag", [None, 40])
def test_a_gap_in_which_an_unstable_mode_grows(backend, n, lag):
    """A millionfold; what later rows say is then small beside it."""
    plant = growing(n)
    y = np.random.default_rng(1).normal(size=(40, plant.p))
    y[10:30] = np.nan
    x, P, lag_one = many_digits.smoothed(plant, y)
    found = lb.smooth(plant, y, backend=backend, lag=lag)
    std = np.sqrt(np.einsum("kii->ki", P))
    assert np.abs((found.x - x) / std).max() < GROWN
    assert np.abs((found.P - P) / std[:, None] / std[..., None]).max() < GROWN
    before = np.concatenate([[np.ones(n)], std[:-1]])
    errors = (found.lag_one - lag_one) / std[..., None] / before[:, None]
    assert np.abs(errors).max() < GROWN


@only("numpy", "python")
def test_a_lag_beyond_the_record_is_the_whole_record(backend):
    plant, rng = plant_of(7, linked=True)
    y = readings(plant, rng, 50)
    whole = lb.smooth(plant, y, backend=backend)
    agree(lb.smooth(plant, y, lag=60, backend=backend), whole)


def test_no_lag_is_the_filter():
    plant, rng = plant_of(8)
    y = readings(plant, rng, 50)
    found = lb.filter_data(plant, y, history=True)
    none = lb.smooth(plant, y, lag=0)
    np.testing.assert_allclose(none.x, found.x, rtol=1e-12)
    np.testing.assert_allclose(none.P, found.P, rtol=1e-12)


@pytest.mark.parametrize("linked", [False, True], ids=["apart", "correlated"])
@pytest.mark.parametrize("m1", [0, 1])
@pytest.mark.parametrize("lag", [0, 1, 5, 50])
def test_pieces_are_the_whole(lag, m1, linked):
    plant, rng = plant_of(9, linked=linked)
    y = readings(plant, rng, 40)
    whole = lb.smooth(plant, y, lag=lag, m1=m1)
    pieces = list(lb.smooth(plant, iter(np.split(y, [3, 4, 20])), lag=lag, m1=m1))
    assert len(pieces) == 5
    for name in NAMES:
        joined = np.concatenate([getattr(one, name) for one in pieces])
        np.testing.assert_allclose(joined, getattr(whole, name), atol=1e-12)


@pytest.mark.parametrize("linked", [False, True], ids=["apart", "correlated"])
def test_a_plant_that_changes(linked):
    """With the same matrices at every instant it is the constant one."""
    plant, rng = plant_of(10, linked=linked)
    y = readings(plant, rng, 30)
    N = 32
    every = {k: np.broadcast_to(getattr(plant, k), (N, *getattr(plant, k).shape))
             for k in ("A", "C", "Q", "R")}  # fmt: skip
    more = dict(S=np.broadcast_to(plant.S, (N, 3, 2))) if linked else {}
    varying = lb.Plant(
        every["A"], None, every["C"], dt=1.0, Q=every["Q"], R=every["R"],
        P0=plant.P0, **more,
    )  # fmt: skip
    for options in ({}, dict(lag=4), dict(m1=1), dict(m1=1, lag=3)):
        agree(lb.smooth(varying, y, **options), lb.smooth(plant, y, **options))


def test_accurate_outputs_are_met_and_cost_least():
    plant, rng = plant_of(11)
    y = readings(plant, rng, 30)
    free, met = lb.smooth(plant, y), lb.smooth(plant, y, m1=1)
    there = ~np.isnan(y[:, 0])
    np.testing.assert_allclose((met.x @ plant.C.T)[there, 0], y[there, 0], rtol=1e-12)
    np.testing.assert_allclose(met.x[~there], free.x[~there], rtol=1e-12)
    np.testing.assert_allclose(met.w, free.w, rtol=1e-12)
    trace = [np.trace(one.P, axis1=1, axis2=2) for one in (free, met)]
    assert (trace[1] >= trace[0] - 1e-12).all()
    filtered = lb.filter_data(plant, y, m1=1, history=True).P
    assert (trace[1] <= np.trace(filtered, axis1=1, axis2=2) + 1e-12).all()


def test_covariances_of_accurate_outputs_are_those_of_errors():
    """P and lag_one by linearity: each estimate is a sum of y, and errors follow."""
    plant, _ = plant_of(12)
    N, n, p = 5, plant.n, plant.p
    unit = np.eye(N * p).reshape(N * p, N, p)
    gains = np.array([lb.smooth(plant, y, m1=1).x for y in unit])  # (N p, N, n)
    joint = _joint(plant, N)
    X, Y = joint[: (N + 1) * n], joint[(N + 1) * n :]
    errors = [gains[:, k].T @ Y - X[(k + 1) * n : (k + 2) * n] for k in range(N)]
    found = lb.smooth(plant, np.zeros((N, p)), m1=1)
    for k in range(N):
        np.testing.assert_allclose(found.P[k], errors[k] @ errors[k].T, atol=1e-10)
        before = errors[k - 1] if k else -X[:n]
        want = errors[k] @ before.T
        if k:
            np.testing.assert_allclose(found.lag_one[k], want, atol=1e-10)


def _joint(plant, N):
    """States 0 .. N and outputs 1 .. N as sums of independent unit numbers."""
    n, p = plant.n, plant.p
    size = n + N * n + N * p
    L0, Lw, Lv = map(np.linalg.cholesky, (plant.P0, plant.Q, plant.R))
    X, Y = [np.hstack([L0, np.zeros((n, size - n))])], []
    for k in range(N):
        x = plant.A @ X[-1]
        x[:, n + k * n : n + (k + 1) * n] += Lw
        y = plant.C @ x
        y[:, n + N * n + k * p : n + N * n + (k + 1) * p] += Lv
        X.append(x)
        Y.append(y)
    return np.vstack(X + Y)


def test_the_smoothed_rows_move_as_the_plant():
    plant, rng = plant_of(13, linked=True)
    y = readings(plant, rng, 30)
    found = lb.smooth(plant, y)
    moved = found.x[:-1] @ plant.A.T + found.w[:-1]
    np.testing.assert_allclose(found.x[1:], moved, atol=1e-11)
    shown = found.x @ plant.C.T + found.v
    there = ~np.isnan(y)
    np.testing.assert_allclose(shown[there], y[there], atol=1e-12)


def test_tables_in_and_tables_out():
    plant, rng = plant_of(14)
    y = readings(plant, rng, 20)
    days = pd.date_range("2026-01-01", periods=20, freq="s")
    table = pd.DataFrame(y, index=days, columns=plant.output_names)
    found, plain = lb.smooth(plant, table), lb.smooth(plant, y)
    assert list(found.x.columns) == list(plant.state_names)
    assert list(found.v.columns) == list(plant.output_names)
    for name in ("x", "std", "w", "v"):
        assert getattr(found, name).index.equals(days)
    agree(found, plain)
    pieces = list(lb.smooth(plant, iter([table[:7], table[7:]]), lag=3))
    assert pd.concat([one.x for one in pieces]).index.equals(days)


def test_no_rows_at_all():
    plant, _ = plant_of(15)
    for lag in (None, 2):
        found = lb.smooth(plant, np.zeros((0, 2)), lag=lag)
        assert found.x.shape == (0, 3) and found.lag_one.shape == (0, 3, 3)


def test_what_cannot_be_smoothed_is_refused():
    plant, rng = plant_of(16)
    y = readings(plant, rng, 5)
    with pytest.raises(ValueError, match="y comes in chunks.*Give lag="):
        lb.smooth(plant, iter([y]))
    for lag in (-1, 1.5, True, "three"):
        with pytest.raises(ValueError, match="lag must be a number of rows"):
            lb.smooth(plant, y, lag=lag)
    with pytest.raises(ValueError, match="y is infinite in row 2"):
        lb.smooth(plant, [[0, 0], [0, 0], [np.inf, 0]])
    with pytest.raises(lb.DesignError, match="plant has no Q"):
        lb.smooth(lb.Plant([[1]], None, [[1]], dt=1.0), [[1]])
    with pytest.raises(lb.DesignError, match="covariance P0"):
        lb.smooth(lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]]), [[1]])
    with pytest.raises(ValueError, match="backend must be"):
        lb.smooth(plant, y, backend="fast")


def test_contradictions_are_those_of_the_filter():
    noise = dict(Q=[[1]], R=np.zeros((2, 2)), P0=[[1]])
    plant = lb.Plant([[1]], None, [[1], [1]], dt=1.0, **noise)
    with pytest.raises(lb.DesignError, match="contradict each other"):
        lb.smooth(plant, [[1, 2]])


def test_memory_of_a_stream_is_flat():
    plant, rng = plant_of(17)
    one = Smoother(plant, 0, 4, None, "auto")
    one.begin(np.zeros(0))
    for _ in range(5):
        one.step(None, readings(plant, rng, 50), None)
        assert len(one.kept) == len(one.y) == 6  # one before those that wait
