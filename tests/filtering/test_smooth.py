"""`Filter.smooth` against joint conditioning in Fractions, and in parts and tables."""

from dataclasses import replace

import exact_filter
import exact_smoother
import fractional_passes as fractions
import numpy as np
import pandas as pd
import pytest
from exact_filter import rational, zeros
from exact_smoother import Batch, floats

import luenberger as lb
from luenberger.errors import DesignError
from luenberger.filtering import back, passes
from luenberger.run import filter as run

TOL = 1e-9
NAMES = "x std P lag_one w v".split()


def exactly(problem, lag=None):
    """x, P, lag_one, w, v of a problem as Fractions, accurate outputs met."""
    m = problem.model
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(exact_smoother, "model", lambda plant: m)
        x, P, lag_one, w, v = Batch(problem.plant, problem.y).smooth(lag)
    moved = None
    for k, row in enumerate(problem.y if problem.accurate else ()):
        met = [j for j in problem.accurate if row[j] is not None]
        G, C, R = zeros(len(m.A), len(m.C)), m.C, m.R
        G[:, met] = exact_filter.gamma_of(C[met], np.ones(len(met), dtype=bool))
        rho = np.array([0 if a is None else a for a in row], dtype=object) - C @ x[k]
        x[k] = x[k] + G @ rho
        P[k] = P[k] + G @ (R - C @ P[k] @ C.T) @ G.T
        if k:
            lag_one[k] = lag_one[k] - G @ C @ lag_one[k] @ moved.T
        moved = G @ C
    return x, P, lag_one, w, v


def sizes(plant, x, P):
    """What numbers of each state, and their errors, are made of."""
    A, P0, Q = (np.abs(getattr(plant, k)) for k in ("A", "P0", "Q"))
    std = np.sqrt(np.maximum(np.einsum("kii->ki", P), 0)).max(axis=0)
    std = np.maximum(std, np.sqrt(P0.diagonal())) + np.sqrt(Q.diagonal())
    std = np.maximum(std, A @ std)
    mean = np.maximum(np.abs(x).max(axis=0), np.abs(plant.x0))
    mean = np.maximum(mean, A @ mean) + std
    return np.where(mean > 0, mean, 1), np.where(std > 0, std, 1)


def errors(problem, found, lag=None):
    """The largest errors of x, P, lag_one, w, v and std."""
    x, P, lag_one, w, v = map(floats, exactly(problem, lag))
    plant = problem.plant
    mean, std = sizes(plant, x, P)
    unit, shown = np.outer(std, std), np.abs(plant.C) @ mean
    shown = shown + np.sqrt(plant.R.diagonal())
    squares = np.einsum("kii->ki", P)
    parts = (
        (found.x - x) / mean, (found.P - P) / unit, (found.lag_one - lag_one) / unit,
        (found.w - w) / mean, (found.v - v) / np.where(shown > 0, shown, 1),
        (found.std**2 - squares) / std**2,
    )  # fmt: skip
    return [np.abs(part).max(initial=0) for part in parts]


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_records_are_smoothed_as_by_conditioning(first):
    """Singular Q, R, P0, S, exact outputs, accurate ones, gaps, with a lag or none."""
    for seed in range(first, first + 50):
        problem = exact_filter.problem(seed)
        lag = None if seed % 3 else seed % 4
        one = lb.Filter(problem.plant, problem.accurate)
        found = one.smooth(problem.record, lag)
        assert max(errors(problem, found, lag)) < TOL, seed
        damaged = problem.damaged(np.random.default_rng(seed))
        if max(damaged.exact().gaps) > 0:
            with pytest.raises(DesignError, match="contradicts what is known"):
                one.smooth(damaged.record)


@pytest.mark.parametrize("seed", range(0, 40))
def test_both_texts_are_exact_on_fractions(seed):
    """To the last digit, also where covariances are singular and nothing has noise."""
    problem = replace(exact_filter.problem(seed), accurate=())
    x, P, lag_one, w, _ = exactly(problem)
    n, (maps, at, tape, _) = x.shape[1], fractions.passed(problem)
    z, S, whole = zeros(*tape.z.shape), zeros(*x.shape), zeros(*P.shape)
    before, left = zeros(2, 2, *tape.V.shape[1:]), zeros(*x.shape)
    back_by = passes.backward.on(TINY=0, LOST=0, FEW=0 if seed % 2 else 9)
    assert back_by(at, maps, tape, z, S, whole, left, before) == -1
    assert (z[:, :n] == x).all() and (whole == P).all()
    assert (S == np.einsum("kii->ki", P)).all()
    assert (z[:, n:] @ maps.B[0][:, n:].T == w).all()
    gains = zeros(len(x), n, n)
    passes.rts.on(TINY=0)(at, maps, tape, gains)
    assert (tape.z[:, :n] == x).all()
    for k, (V, D) in enumerate(zip(tape.V, tape.D)):
        assert (((V.T * D) @ V)[:n, :n] == P[k]).all()
        assert k == 0 or (P[k] @ gains[k - 1].T == lag_one[k]).all()


def ways_back(problem, monkeypatch, lost=passes.LOST):
    """The largest errors of what is smoothed, and which rows lost digits."""
    found, ours = [], back._factors

    def seen(tape, first, *rest):
        found.append(first - 1)
        return ours(tape, first, *rest)

    monkeypatch.setattr(back, "_factors", seen)
    ways = dict(loops=passes.backward.on(LOST=lost), text=passes.backward.on(LOST=lost))
    for name, way in ways.items():
        monkeypatch.setattr(back, name, lambda *_, way=way: way)
    one = lb.Filter(problem.plant)
    return max(errors(problem, one.smooth(problem.record))), set(found)


def test_digits_decide_which_way_back_is_taken(monkeypatch):
    """Of problem 104 four digits of a covariance are left, by differences alone."""
    free = replace(exact_filter.problem(104), accurate=())
    error, lost = ways_back(free, monkeypatch)
    assert error < TOL and lost == {3}
    error, lost = ways_back(free, monkeypatch, 0)
    assert error > 1e-6 and not lost


@pytest.mark.parametrize("m1", [0, 1])
@pytest.mark.parametrize("P0", [1, 1e8])
@pytest.mark.parametrize("n", [2, 8])
def test_many_states_are_smoothed_as_through_the_next_state(n, P0, m1, monkeypatch):
    """Also where the first rows lose digits, as those of a vague prior do."""
    one = lb.Filter(wandering(n, P0=P0 * np.eye(n)), m1)
    found = one.smooth(a_record())
    for name in ("loops", "text"):
        monkeypatch.setattr(back, name, lambda *_: lambda at, *_: len(at) - 2)
    wanted = one.smooth(a_record())
    wide = np.sqrt(np.einsum("kii->ki", wanted.P))
    assert (np.abs(found.x - wanted.x) < 1e-9 * wide).all()
    for name in ("P", "lag_one"):
        close = dict(rtol=0, atol=1e-9 * (wide.max(axis=0) ** 2).max())
        np.testing.assert_allclose(getattr(found, name), getattr(wanted, name), **close)
    np.testing.assert_allclose(found.std, wanted.std, rtol=1e-9)
    np.testing.assert_allclose(found.w, wanted.w, atol=1e-9)


@pytest.mark.parametrize("lag", [None, 1])
@pytest.mark.parametrize("first", range(0, 60, 20))
def test_an_unknown_start_is_smoothed_as_a_wide_one(first, lag):
    """In Fractions, with a variance of 10^60; a record may leave some of it open."""
    for seed in range(first, first + 20):
        problem = replace(exact_filter.problem(seed), accurate=())
        m, plant = problem.model, problem.plant
        if abs(np.linalg.det(plant.A)) < 1e-9 or (m.S != 0).any():
            continue  # the prior of the first sample is not that before it
        wide = rational(np.eye(len(m.A))) * 10**60
        exact = exactly(replace(problem, model=m._replace(P0=wide)), lag)
        x, P, shares, w, _ = map(floats, exact)
        one = lb.Filter(lb.Plant(plant.A, None, plant.C, dt=1.0, Q=plant.Q, R=plant.R))
        found, known = one.smooth(problem.record, lag), np.abs(P) < 1e30
        shown = np.einsum("kii->ki", known)
        assert (np.isfinite(found.std) == shown).all(), seed
        mean, spread = (
            1 + np.abs(x[shown]).max(initial=0),
            np.abs(P[known]).max(initial=1),
        )
        np.testing.assert_allclose(found.P[known], P[known], rtol=0, atol=1e-9 * spread)
        np.testing.assert_allclose(found.x[shown], x[shown], rtol=0, atol=1e-9 * mean)
        if known.all():
            apart = np.abs(found.lag_one[1:] - shares[1:])
            assert apart.max(initial=0) < 1e-9 * spread
            np.testing.assert_allclose(found.w, w, rtol=0, atol=1e-9 * mean)


def wandering(n=2, steps=None, **more):
    """A plant, and with steps one whose matrices differ from instant to instant."""
    rng = np.random.default_rng(3)
    A, C, H = rng.normal(size=(n, n)), rng.normal(size=(2, n)), rng.normal(size=(n, n))
    A /= np.abs(np.linalg.eigvals(A)).max()
    given = dict(
        A=A, B=np.ones((n, 1)), C=C, E=np.ones((2, 1)), Q=H @ H.T + np.eye(n),
        R=np.diag([0.5, 2.0]), P0=np.eye(n), x0=np.arange(n),
    ) | more  # fmt: skip
    if steps:
        for name, low in dict(A=0.5, C=0.5, Q=0.3, R=0.3).items():
            X = np.asarray(given[name])
            given[name] = X * rng.uniform(low, 1, (steps, 1, 1))
    return lb.Plant(given.pop("A"), given.pop("B"), given.pop("C"), dt=1.0, **given)


def a_record(rows=30, p=2):
    rng = np.random.default_rng(7)
    y = rng.normal(size=(rows, p))
    y[rng.random(y.shape) < 0.3] = np.nan
    return lb.Record(y, rng.normal(size=(rows, 1)), u0=[0.5])


def agree(one, two, tol=1e-10):
    for name in NAMES:
        a, b = (np.asarray(getattr(found, name)) for found in (one, two))
        rounding = tol * np.abs(b).max(initial=1e-300)
        np.testing.assert_allclose(a, b, rtol=0, atol=rounding, err_msg=name)


WAYS = {
    "by innovations": {},
    "through the next state": dict(R=np.diag([0.0, 2.0])),
    "correlated": dict(S=0.3 * np.ones((2, 2))),
    "a prior": dict(at_first=True),
    "outputs alike": dict(R=np.ones((2, 2))),
}


@pytest.mark.parametrize("m1", [0, 1])
@pytest.mark.parametrize("lag", [None, 0, 3])
@pytest.mark.parametrize("more", WAYS.values(), ids=WAYS)
def test_windows_are_the_whole_record(more, lag, m1, monkeypatch):
    """A plant that is the same at each instant, whose rows are done a few at a time."""
    plant = wandering(**more)
    every = {k: np.stack([getattr(plant, k)] * 40) for k in "ABCEQR"}
    if plant.S is not None:
        every["S"] = np.stack([plant.S] * 40)
    rest = dict(dt=1.0, P0=plant.P0, x0=plant.x0, at_first=plant.at_first)
    varying = lb.Plant(**every, **rest)
    monkeypatch.setattr(run, "ROWS", 7)
    wanted = lb.Filter(plant, m1).smooth(a_record(), lag)
    agree(lb.Filter(varying, m1).smooth(a_record(), lag), wanted)


@pytest.mark.parametrize("R", [np.diag([0.5, 2.0]), np.diag([0.0, 2.0])])
def test_windows_of_a_plant_that_changes(R, monkeypatch):
    """Each row moves on by its own matrices, the last one of a window as well."""
    found = []
    for rows in (100, 7):
        monkeypatch.setattr(run, "ROWS", rows)
        found.append(lb.Filter(wandering(steps=40, R=R)).smooth(a_record()))
    agree(*found)


RANKS = {
    "Q": {"Q": {3: 0 * np.eye(2), 5: np.ones((2, 2))}},
    "R": {"R": {2: np.ones((2, 2)), 4: 0 * np.eye(2)}},
    "both": {
        "S": {1: 0.3 * np.eye(2)},
        "Q": {3: 0 * np.eye(2)},
        "R": {4: np.ones((2, 2))},
    },
}


@pytest.mark.parametrize("changes", RANKS.values(), ids=RANKS)
def test_ranks_may_change_from_instant_to_instant(changes, monkeypatch):
    """Beside a plant of one rank that has all but the same numbers."""
    wanted = {k: np.stack([np.eye(2)] * 8) for k in "ACQR"}
    wanted["S"], near = np.zeros((8, 2, 2)), None
    for name, values in changes.items():
        for k, X in values.items():
            wanted[name][k] = X
    y = np.random.default_rng(1).normal(size=(6, 2))
    y[:, 1] = np.where(np.isin(np.arange(6), [1, 3]), y[:, 0], y[:, 1])
    y[4, 0] = np.nan
    near = wanted | {k: wanted[k] + 1e-9 * np.eye(2) for k in "QR"}
    one, two = (
        lb.Filter(lb.Plant(B=None, dt=1.0, P0=np.eye(2), **X)) for X in (wanted, near)
    )
    agree(one.smooth(y), two.smooth(y), 1e-3)
    np.testing.assert_allclose(one.run(y).x, two.run(y).x, atol=1e-6)


def test_uneven_instants_are_those_of_the_sampled_plant(monkeypatch):
    rng = np.random.default_rng(2)
    periods = rng.uniform(0.5, 2, 30)
    noises = dict(Q=np.diag([0, 1]), R=np.eye(2), P0=np.eye(2))
    plant = lb.Plant([[0, 1], [0, -0.1]], [[0], [1]], np.eye(2), **noises)
    record = a_record()
    periods[0] = periods[1]  # that before the first row is like the first one
    sampled = lb.Filter(lb.sampling.discretise(plant, periods)).smooth(record)
    times = np.concatenate([[0.0], np.cumsum(periods[1:])])
    timed = lb.Record(record.y, record.u, time=times, u0=[0.5])
    for rows in (100, 7):
        monkeypatch.setattr(run, "ROWS", rows)
        agree(lb.Filter(plant).smooth(timed), sampled)


def test_a_lag_is_a_record_that_ends_earlier():
    one, record = lb.Filter(wandering()), a_record(12)
    found, filtered = one.smooth(record, lag=2), one.run(record)
    for k in (0, 4, 9, 11):
        part = lb.Record(record.y[: k + 3], record.u[: k + 3], u0=record.u0)
        ends = one.smooth(part)
        np.testing.assert_allclose(found.x[k], ends.x[k], rtol=1e-12)
        np.testing.assert_allclose(found.lag_one[k], ends.lag_one[k], atol=1e-12)
    np.testing.assert_allclose(one.smooth(record, lag=0).P, filtered.P, atol=1e-12)
    agree(one.smooth(record, lag=50), one.smooth(record))


def test_smoothed_rows_move_as_the_plant():
    plant, record = wandering(S=0.3 * np.ones((2, 2))), a_record()
    found, y, u = lb.Filter(plant).smooth(record), record.y, record.u
    moved = found.x @ plant.A.T + u @ plant.B.T + found.w
    np.testing.assert_allclose(found.x[1:], moved[:-1], atol=1e-12)
    shown = found.x @ plant.C.T + u @ plant.E.T + found.v
    np.testing.assert_allclose(shown[y == y], y[y == y], atol=1e-12)


def test_accurate_outputs_are_met_at_little_cost():
    plant, record = wandering(), a_record()
    free, met = (lb.Filter(plant, m1).smooth(record) for m1 in (0, 1))
    shown = met.x @ plant.C[:1].T + record.u @ plant.E[:1].T
    there = record.y[:, :1] == record.y[:, :1]
    np.testing.assert_allclose(shown[there], record.y[:, :1][there], atol=1e-12)
    traces = [np.trace(X, axis1=1, axis2=2)
              for X in (free.P, met.P, lb.Filter(plant, 1).run(record).P)]  # fmt: skip
    assert (np.diff(traces, axis=0) > -1e-12).all()


def test_tables_come_back_as_tables():
    plant, record = wandering(state_names=["far", "fast"]), a_record()
    days = pd.date_range("2026-01-01", periods=30, freq="s", name="day")
    y = pd.DataFrame(record.y, days, plant.output_names)
    found = lb.Filter(plant).smooth(lb.Record(y, record.u, u0=record.u0))
    assert list(found.names) == ["far", "fast"] and found.index.equals(days)
    assert list(found.x) == ["far", "fast"] and list(found.v) == list(y)
    for name in ("x", "std", "w", "v"):
        assert getattr(found, name).index.equals(days)
    agree(found, lb.Filter(plant).smooth(record))


def test_each_run_is_smoothed_by_itself():
    plant, rng = wandering(), np.random.default_rng(5)
    one, y, u = lb.Filter(plant), rng.normal(size=(3, 9, 2)), rng.normal(size=(9, 1))
    for runs, inputs in ((y, u), (list(y), [u] * 3)):
        found = one.smooth(lb.Record(runs, inputs))
        assert len(found) == 3
        for k in range(3):
            agree(found[k], one.smooth(lb.Record(y[k], u)), 0)


@pytest.mark.parametrize("lag", [None, 2])
@pytest.mark.parametrize("m1", [0, 1])
def test_no_rows_at_all(lag, m1):
    found = lb.Filter(wandering(), m1).smooth(np.zeros((0, 2)), lag)
    assert found.x.shape == found.std.shape == found.w.shape == (0, 2)
    assert found.P.shape == found.lag_one.shape == (0, 2, 2)
    assert found.v.shape == (0, 2)


@pytest.mark.parametrize("lag", [-1, 1.5, True, "three"])
def test_a_lag_is_a_number_of_rows(lag):
    with pytest.raises(ValueError, match="lag must be a number of rows, 0 or more"):
        lb.Filter(wandering()).smooth(a_record(), lag)
