"""NaN in a record: that channel was not measured at that instant."""

import dataclasses

import generators
import numpy as np
import pandas as pd
import pytest
from generators import holes
from in_parts import in_parts

import luenberger as lb

CASES = ["S = 0", "S", "time-varying", "time-varying, S"]


@pytest.fixture(params=CASES)
def case(request):
    rng = np.random.default_rng(12)
    cross = request.param.endswith("S")
    if request.param.startswith("time"):
        plant = generators.varying(rng, 4, 3, 60, m=2, cross=cross)
    else:
        plant = generators.plant(rng, 4, 3, m=2, cross=cross)
    y, u, u0 = generators.record(rng, plant, 60)
    return plant, holes(rng, y), u, u0


def test_kalman_filter_drops_the_rows(case):
    plant, y, u, u0 = case
    x, P, K = generators.kalman(plant, y, u, u0)
    run = lb.Filter(plant).run(lb.Record(y, u, u0=u0))
    assert generators.relative(run.P, P) < 1e-12
    assert generators.relative(run.K, K) < 1e-12
    assert generators.relative(run.x, x) < 1e-12
    np.testing.assert_array_equal(run.K.any(axis=1), ~np.isnan(y))


def test_rational_arithmetic_agrees(case):
    plant, y, u, u0 = case
    y = y[:6]
    x, P = generators.exact(plant, y, u[:6], u0)
    run = lb.Filter(plant).run(lb.Record(y, u[:6], u0=u0))
    assert generators.relative(run.P, P) < 1e-12
    assert generators.relative(run.x, x) < 1e-12


@pytest.mark.parametrize("m1", [0, 1, 2, [2], [0, 2]])
def test_a_complete_record_is_the_designed_filter(m1, case):
    plant, y, u, u0 = case
    y = np.nan_to_num(y)
    steps = 30
    observer = lb.reduced_order_filter(plant, m1, steps=steps)
    run = lb.Filter(plant, m1).run(lb.Record(y[:steps], u[:steps], u0=u0))
    wanted = lb.estimate(observer, lb.Record(y[:steps], u[:steps], u0=u0))
    assert generators.relative(run.x, wanted) < 1e-11
    covariance = lb.error_covariance(observer, plant, steps=steps)
    assert generators.relative(run.P, covariance[1:]) < 1e-11


def constrained_gain(Omega, C, R, accurate):
    """The K of least trace with C1 K = [I 0], from the Lagrange conditions.

    Stationarity K M + C1' Lambda = Omega C' and the constraint are solved together,
    column by column of K, as one linear system; nothing is decorrelated or split.
    """
    n, p = Omega.shape[0], len(C)
    C1 = C[accurate]
    m1 = len(C1)
    M = C @ Omega @ C.T + R
    system = np.block(
        [
            [np.kron(M.T, np.eye(n)), np.kron(np.eye(p), C1.T)],
            [np.kron(np.eye(p), C1), np.zeros((m1 * p, m1 * p))],
        ]
    )
    wanted = np.eye(p)[accurate]  # C1 K = the accurate rows of I
    right = np.concatenate([(Omega @ C.T).ravel("F"), wanted.ravel("F")])
    return np.linalg.solve(system, right)[: n * p].reshape(n, p, order="F")


def constrained_filter(plant, y, u, u0, accurate):
    """Reduced-order filter with missing rows, by `constrained_gain` at each step.

    Predictor form with S: w is estimated from the residual, J = S R^-1 of the
    outputs that came.
    """
    first = plant.at(0)
    x = first.A @ plant.x0 + first.B @ u0
    Omega = first.A @ plant.P0 @ first.A.T + first.Q
    xs, Ps, orders = [], [], []
    for k in range(len(y)):
        now, seen = plant.at(k + 1), ~np.isnan(y[k])
        C, R = now.C[seen], now.R[np.ix_(seen, seen)]
        S = np.zeros((plant.n, plant.p)) if now.S is None else now.S
        S = S[:, seen]
        taken = np.isin(np.flatnonzero(seen), accurate)
        K = constrained_gain(Omega, C, R, taken)
        known = y[k][seen] - (now.E @ u[k])[seen]
        x = x + K @ (known - C @ x)
        left = np.eye(plant.n) - K @ C
        P = left @ Omega @ left.T + K @ R @ K.T
        xs.append(x)
        Ps.append(P)
        orders.append(plant.n - taken.sum())
        # x+ - x^+ = A e + w - J rho with e = -(left e^-) + K v, rho = v - C e
        J = np.linalg.solve(R, S.T).T
        x = now.A @ x + now.B @ u[k] + J @ (known - C @ x)
        move = now.A - J @ C
        Omega = move @ P @ move.T + now.Q - J @ S.T
    return np.array(xs), np.array(Ps), np.array(orders)


@pytest.mark.parametrize("accurate", [[0], [2], [0, 1], [0, 1, 2]], ids=str)
def test_a_missing_accurate_output_is_filtered_like_a_state(accurate, case):
    """The order rises by one for each accurate output that did not come, and falls
    again with it; covariance and estimate are those of the constrained least trace."""
    plant, y, u, u0 = case
    x, P, orders = constrained_filter(plant, y, u, u0, accurate)
    run = lb.Filter(plant, accurate).run(lb.Record(y, u, u0=u0))
    assert generators.relative(run.P, P) < 1e-10
    assert generators.relative(run.x, x) < 1e-10
    assert orders.min() < orders.max() == 4
    missing = np.isnan(y).sum(axis=1) == 3
    assert missing.any() and not run.K[missing].any()


def test_an_accurate_output_is_reproduced_where_it_came():
    rng = np.random.default_rng(1)
    plant = generators.plant(rng, 4, 3, m=2)
    y, u, u0 = generators.record(rng, plant, 40)
    y = holes(rng, y)
    run = lb.Filter(plant, [0, 2]).run(lb.Record(y, u, u0=u0))
    said = run.x @ plant.C.T + u @ plant.E.T
    for j in (0, 2):
        came = ~np.isnan(y[:, j])
        np.testing.assert_allclose(said[came, j], y[came, j], rtol=0, atol=1e-11)
        gap = np.abs(said[~came, j] - y[~came, j])
        assert np.isnan(gap).all()
    came = ~np.isnan(y[:, 1])
    assert np.abs(said[came, 1] - y[came, 1]).max() > 0.1


@pytest.mark.parametrize("m1", [0, 2])
def test_rows_that_are_missing_altogether_are_predictions(m1):
    rng = np.random.default_rng(2)
    plant = generators.plant(rng, 3, 2, m=1, cross=False)
    y, u, u0 = generators.record(rng, plant, 12)
    y[5:] = np.nan
    run = lb.Filter(plant, m1).run(lb.Record(y, u, u0=u0))
    for k in range(5, 12):
        x = plant.A @ run.x[k - 1] + plant.B @ u[k - 1]
        np.testing.assert_allclose(run.x[k], x, rtol=1e-12)
        P = plant.A @ run.P[k - 1] @ plant.A.T + plant.Q
        np.testing.assert_allclose(run.P[k], P, rtol=1e-12, atol=1e-14)
    nothing = lb.Filter(plant, m1).run(lb.Record(np.full((3, 2), np.nan), u[:3], u0=u0))
    x = plant.x0
    for k, before in enumerate((u0, u[0], u[1])):
        x = plant.A @ x + plant.B @ before
        np.testing.assert_allclose(nothing.x[k], x, rtol=1e-12)


@pytest.mark.parametrize("sizes", [(1,) * 60, (7, 0, 53), (59, 1)], ids=str)
@pytest.mark.parametrize("m1", [0, 2])
def test_parts_are_one_pass_bit_for_bit(m1, sizes, case):
    plant, y, u, u0 = case
    run, edges = lb.Filter(plant, m1), np.cumsum(sizes)[:-1]
    whole = run.run(lb.Record(y, u, u0=u0))
    cut = [slice(a, b) for a, b in zip([0, *edges], [*edges, 60])]
    parts = list(in_parts(run, (lb.Record(y[c], u[c], u0=u0) for c in cut)))
    assert [len(part.x) for part in parts] == list(sizes)
    for name in ("x", "std", "P", "K"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        np.testing.assert_array_equal(joined, getattr(whole, name), err_msg=name)


def test_tables_in_parts_are_one_table(tmp_path):
    """As the page of records has it: pandas reads a file a thousand rows at a time."""
    plant = generators.plant(np.random.default_rng(3), 3, 2, m=1)
    plant = dataclasses.replace(plant, dt=0.1)
    y, u, _ = generators.record(np.random.default_rng(4), plant, 2500)
    names = [*plant.output_names, *plant.input_names]
    time = pd.Index(np.arange(1, 2501) / 10, name="time")
    table = pd.DataFrame(np.hstack([y, u]), time, names)
    table.to_csv(tmp_path / "long.csv")
    run, end, found = lb.Filter(plant), None, []
    for part in pd.read_csv(tmp_path / "long.csv", index_col="time", chunksize=1000):
        found.append(run.run(part, start=end))
        end = found[-1].end
    joined = pd.concat(one.x for one in found)
    whole = run.run(table)
    pd.testing.assert_frame_equal(joined, whole.x, rtol=1e-12)
    assert list(whole.std.columns) == list(plant.state_names)
    late = table.set_axis(time + 0.5 * (np.arange(2500) > 999))
    end = run.run(late.iloc[:1000]).end
    with pytest.raises(ValueError, match="^row 1000: its time is 0.6 s after"):
        run.run(late.iloc[1000:], start=end)


@pytest.mark.parametrize("m1", [0, 1])
def test_prior_of_the_first_sample_is_the_posterior_moved_once(m1, case):
    plant, y, u, u0 = case
    first = plant.at(0)
    y = y.copy()
    y[0, :] = [np.nan, 0.3, np.nan]
    moved = lb.Plant(
        plant.A, plant.B, plant.C, plant.E, dt=1.0, Q=plant.Q, R=plant.R, S=plant.S,
        x0=first.A @ plant.x0 + first.B @ u0,
        P0=first.A @ plant.P0 @ first.A.T + first.Q, at_first=True,
    )  # fmt: skip
    a = lb.Filter(plant, m1).run(lb.Record(y, u, u0=u0))
    b = lb.Filter(moved, m1).run(lb.Record(y, u))
    assert generators.relative(b.P, a.P) < 1e-12
    assert generators.relative(b.x, a.x) < 1e-12
    unmoved = lb.Filter(moved, m1).run(
        lb.Record(y, u, u0=u0 + 5)
    )  # no step before y[1]
    np.testing.assert_array_equal(unmoved.x, b.x)


def test_the_input_before_the_first_sample_counts(case):
    plant, y, u, u0 = case
    a = lb.Filter(plant).run(lb.Record(y, u, u0=u0))
    b = lb.Filter(plant).run(lb.Record(y, u))
    assert np.abs(a.x[0] - b.x[0]).max() > 1e-3
    x, _, _ = generators.kalman(plant, y, u, np.zeros(2))
    assert generators.relative(b.x, x) < 1e-12


def test_missing_values_lose_accuracy_and_never_gain_it(case):
    """K differs, P grows: the variance of every combination of states rises."""
    plant, y, u, u0 = case
    less = lb.Filter(plant).run(lb.Record(y, u, u0=u0)).P
    more = lb.Filter(plant).run(lb.Record(np.nan_to_num(y), u, u0=u0)).P
    gain = np.linalg.eigvalsh(less - more).min(axis=1)
    assert gain.min() > -1e-12 * np.abs(less).max()


def test_noise_free_output_missing_and_back():
    """A perfect position sensor that drops out: predicted, then taken exactly again."""
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=[[1 / 3, 1 / 2], [1 / 2, 1]],
        R=[[0]], P0=np.eye(2),
    )  # fmt: skip
    y = np.array([[1.0], [2], [np.nan], [np.nan], [6], [7]])
    run = lb.Filter(plant, 1).run(y)
    x, P = generators.exact(plant, y)
    np.testing.assert_allclose(run.x, x, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.P, P, rtol=0, atol=1e-12)
    np.testing.assert_allclose(run.std[[0, 1, 4, 5], 0], 0, atol=1e-7)
    assert (run.std[[2, 3], 0] > 0.5).all()


def test_infinite_or_misshapen_data_are_refused():
    plant = generators.plant(np.random.default_rng(3), 2, 2, m=1)
    y, u = np.zeros((4, 2)), np.zeros((4, 1))
    bad = y.copy()
    bad[2, 1] = np.inf
    with pytest.raises(ValueError, match="y is infinite in row 2"):
        lb.Filter(plant).run(lb.Record(bad, u))
    with pytest.raises(ValueError, match="u has values that are missing.*row 0"):
        lb.Filter(plant).run(lb.Record(y, np.full((4, 1), np.nan)))
    with pytest.raises(ValueError, match=r"y must be \(N, 2\), got \(4, 3\)"):
        lb.Filter(plant).run(lb.Record(np.zeros((4, 3)), u))
    with pytest.raises(ValueError, match="y has 4 rows but u has 3"):
        lb.Filter(plant).run(lb.Record(y, u[:3]))
    short = generators.varying(np.random.default_rng(3), 2, 2, 3, m=1)
    with pytest.raises(ValueError, match="instants 0 .. 3, the data reach instant 4"):
        lb.Filter(short).run(lb.Record(y, u))


@pytest.mark.parametrize("weight", [None, [[2, 1], [1, 3]], "canonical"], ids=str)
def test_accurate_outputs_are_met_whatever_the_units_of_states(weight):
    """A position in nanometres beside an angle: C C' would lose the angle."""
    C = np.array([[-3.75e8, -0.66], [-6.34e7, 1.27]])
    plant = lb.Plant(
        0.9 * np.eye(2), None, C, dt=1.0, Q=np.eye(2), R=np.eye(2), P0=np.eye(2)
    )
    y = np.random.default_rng(1).normal(size=(5, 2))
    run = lb.Filter(plant, 2, weight=weight).run(y)
    np.testing.assert_allclose(run.x @ C.T, y, rtol=0, atol=1e-12)
