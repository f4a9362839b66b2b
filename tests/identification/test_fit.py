"""Fits of noises and parameters, held against known answers and laws.

Standard errors hang on the model, not on the numbers that it is written in, and hold
the truth as often as they promise.
"""

import dataclasses
import pathlib

import numpy as np
import pytest
from coverage_of_errors import of_plant, share

import luenberger as lb
from luenberger.run import measurements

PLANTS = pathlib.Path(__file__).parents[2] / "notebooks" / "plants"
LEVEL = lb.Plant([[1]], None, [[1]], dt=1.0)
POSITION = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0)


def recorded(name):
    plant = lb.Plant.from_json(PLANTS / f"{name}.json")
    if plant.dt == 0:
        plant = plant.sampled(0.1)
    return plant, measurements.read(PLANTS / f"{name}.csv", plant)


NILE, NILE_DATA = recorded("nile")


def drawn(seed, rows, plant, Q, R):
    """A noisy record of a plant at rest."""
    rng = np.random.default_rng(seed)
    x, y = np.zeros(plant.n), []
    half = np.linalg.cholesky(Q), np.linalg.cholesky(R)
    for _ in range(rows):
        y.append(plant.C @ x + half[1] @ rng.normal(size=plant.p))
        x = plant.A @ x + half[0] @ rng.normal(size=plant.n)
    return np.array(y)


def test_the_nile():
    """Durbin and Koopman (2012), section 2.10.3; it is told, and told again alike."""
    told = list[int]()
    fit = lb.fit_noise(NILE, NILE_DATA.y, progress=lambda done, _: told.append(done))
    assert float(f"{fit.plant.R[0, 0]:.5g}") == 15099
    assert float(f"{fit.plant.Q[0, 0]:.5g}") == pytest.approx(1469.1, abs=0.11)
    assert fit.whiteness.white and fit.unidentifiable == []
    lines = repr(fit).splitlines()
    errors = dict(Q=1280.2, R=3145.5)  # statsmodels: "approx"
    for line, (name, error) in zip(lines, errors.items()):
        value, found = getattr(fit.plant, name)[0, 0], fit.standard_errors[name][0, 0]
        assert found == pytest.approx(error, rel=2e-3)
        assert f"{value:.5g}, standard error {found:.2g}" in line
    assert lines[2] == f"log-likelihood {fit.log_likelihood:.2f}"
    assert lines[3:] == fit.whiteness.sentences
    assert told == sorted(told) and len(told) > 5
    again = lb.fit_noise(NILE, NILE_DATA.y).plant
    assert again.Q.tobytes() == fit.plant.Q.tobytes()


@pytest.mark.parametrize("rows", [60, 1500])
@pytest.mark.parametrize("gaps", [0, 0.004, 0.2])
@pytest.mark.parametrize("n", [1, 2, 3, 7])
def test_at_the_most_likely_values_the_exact_score_is_zero(n, gaps, rows):
    """Of long and short records, whose start is known or not; a settled filter too."""
    rng = np.random.default_rng(n)
    A = 0.8 * np.linalg.qr(rng.normal(size=(n, n)))[0]
    B, C = rng.normal(size=(n, 1)), np.eye(n)[: (n + 1) // 2]
    P0 = None if rows == 60 else np.eye(n)
    plant = lb.Plant(A, B, C, dt=1.0, P0=P0, Q=np.eye(n))
    u, x, y = rng.normal(size=(rows, 1)), 1e3 * np.ones(n), np.empty((rows, len(C)))
    x = x if P0 is None else rng.normal(size=n)
    for k in range(rows):
        x = A @ x + B @ (u[k - 1] if k else [0.0]) + rng.normal(size=n)
        y[k] = C @ x + rng.normal(size=len(C))
    y[rng.random(y.shape) < gaps] = np.nan
    forms = dict(Q="scaled", R="diagonal") if n > 3 else dict(Q="diagonal")
    fit = lb.fit_noise(plant, lb.Record(y, u), **forms)
    run, record, errors = lb.Filter(fit.plant), lb.Record(y, u), fit.standard_errors
    assert fit.log_likelihood == run.log_likelihood(record)
    score = run.score(record)
    slopes = [*(score.R * errors["R"]).ravel(), *(score.Q * errors["Q"]).diagonal()]
    if n > 3:
        slopes[-n:] = [np.trace(score.Q) * errors["q[0]"]]
    assert np.nanmax(np.abs(slopes)) < 2e-3  # in units of errors; NaN at a bound


def test_a_ball_on_a_beam():
    """Gain, intensity, sensor and offset at once, by a function of the parameters."""
    plant, data = recorded("ball-and-beam")
    one, dt = np.hstack([data.u, np.ones_like(data.u)]), 0.1
    spread = np.array([[dt**3 / 3, dt**2 / 2], [dt**2 / 2, dt]])  # white acceleration

    def made(values):
        gain, offset = values
        b = plant.B / 4.45 * gain
        wide = np.hstack([b, b * offset])
        return lb.Plant(plant.A, wide, plant.C, dt=dt, P0=np.eye(2) / 10)

    fit = lb.fit_noise(
        made([4, 0]),
        lb.Record(data.y, one),
        Q=lambda q: q[0] * spread,
        start={"Q": [1e-4]},
        parameters=(made, {"gain": 4.0, "offset": 0.0}),
    )
    assert fit.parameters["gain"] == pytest.approx(4.450, abs=2e-3)
    assert fit.parameters["q[0]"] == pytest.approx(1.726e-4, rel=5e-3)
    assert fit.parameters["offset"] == pytest.approx(4.2e-4, rel=2e-2)
    assert fit.plant.R[0, 0] == pytest.approx(1.005e-6, rel=2e-3)
    assert fit.log_likelihood == pytest.approx(5020.3, abs=10)  # of another start
    assert fit.whiteness.autocorrelation[0, 0, 0] == pytest.approx(0.10, abs=0.01)
    assert fit.whiteness.sized and not fit.whiteness.white
    assert 0.1 < fit.standard_errors["gain"] < 0.2


@pytest.mark.parametrize("method", ["likelihood", "autocovariance"])
def test_several_records_of_one_plant(method):
    Q, R = np.array([[0.5]]), np.array([[2.0]])
    parts = [drawn(k, 400, LEVEL, Q, R) + 100 * k for k in range(3)]
    fit = lb.fit_noise(LEVEL, parts, method=method)
    assert abs(fit.plant.Q - Q)[0, 0] < 4 * fit.standard_errors["Q"][0, 0] < 0.5
    assert abs(fit.plant.R - R)[0, 0] < 4 * fit.standard_errors["R"][0, 0] < 0.8
    assert len(fit.innovations) == 3 and len(fit.innovations[2]) == 400
    again = lb.fit_noise(LEVEL, lb.Record(np.array(parts)), method=method)
    assert again.plant.Q.tobytes() == fit.plant.Q.tobytes()
    rows = [[one] for one in parts[0][:, 0]]  # a list of rows is one record
    assert lb.fit_noise(LEVEL, rows, method=method).innovations.shape == (400, 1)


def test_a_fit_knows_the_input_before_its_record_and_the_times_of_its_rows():
    rng, plant = np.random.default_rng(6), lb.Plant([[0.9]], [[1]], [[1]], dt=1.0)
    u, x, y = rng.normal(size=(200, 1)), np.zeros(1), np.empty((200, 1))
    for k in range(200):
        x = 0.9 * x + (u[k - 1] if k else 50.0) + rng.normal(size=1)
        y[k] = x + rng.normal(size=1)
    known = dataclasses.replace(plant, P0=[[0.0]])
    fits = [lb.fit_noise(known, lb.Record(y, u, u0=u0)) for u0 in ([50.0], None)]
    assert fits[0].log_likelihood > fits[1].log_likelihood + 20
    with pytest.raises(ValueError, match="row 4: it is 4.59"):
        lb.fit_noise(plant, lb.Record(y, u, time=np.arange(200) ** 1.1))
    with pytest.raises(ValueError, match="leave `arrival` out"):
        lb.fit_noise(plant, lb.Record(y, u, arrival=np.arange(200)[:, None]))


def test_a_filter_of_the_plant_leaves_no_trace_in_a_fit():
    """A plant keeps the matrices of its filter; those that are tried have theirs."""
    y = drawn(2, 200, LEVEL, np.eye(1), np.eye(1))
    first, other = (
        dataclasses.replace(LEVEL, Q=[[9.0]], R=[[9.0]], P0=[[1.0]]) for _ in "ab"
    )
    lb.Filter(first).run(y)
    found, same = (lb.fit_noise(plant, y).log_likelihood for plant in (first, other))
    assert found == same


def test_units_change_nothing_but_the_numbers():
    x, y = np.array([2.0**40, 2.0**-37]), 2.0**-40
    Q, R = np.diag([0.5, 0.2]), np.array([[1.0]])
    data = drawn(5, 300, POSITION, Q, R)
    other = lb.Plant(POSITION.A / x[:, None] * x, None, POSITION.C / y * x, dt=1.0)
    fit = lb.fit_noise(POSITION, data, Q="diagonal")
    again = lb.fit_noise(other, data / y, Q="diagonal")
    scale = np.outer(x, x)
    np.testing.assert_allclose(
        again.plant.Q * scale, fit.plant.Q, rtol=1e-4, atol=1e-12
    )
    np.testing.assert_allclose(again.plant.R * y * y, fit.plant.R, rtol=1e-4)
    np.testing.assert_allclose(
        again.standard_errors["Q"] * scale,
        fit.standard_errors["Q"],
        rtol=1e-3,
        atol=1e-9,
    )


def test_a_plant_that_varies_over_time():
    rng, rows = np.random.default_rng(7), 600
    A = 0.9 + 0.2 * np.sin(np.arange(rows + 1))[:, None, None]
    plant = lb.Plant(A, None, [[1]], dt=1.0)
    x, y = 0.0, []
    for k in range(rows):
        y.append(x + 2 * rng.normal())
        x = A[k + 1, 0, 0] * x + rng.normal()
    fit = lb.fit_noise(plant, y)
    assert abs(fit.plant.Q[0, 0] - 1) < 3 * fit.standard_errors["Q"][0, 0] < 1
    assert abs(fit.plant.R[0, 0] - 4) < 3 * fit.standard_errors["R"][0, 0] < 2
    with pytest.raises(lb.DesignError, match="method='likelihood'"):
        lb.fit_noise(plant, y, method="autocovariance")


def test_entries_of_the_plant_by_name():
    plant = lb.Plant([[0.5]], [[2.0]], [[1]], dt=1.0)
    rng = np.random.default_rng(8)
    u, x, y = rng.normal(size=(800, 1)), 0.0, []
    for one in u[:, 0]:
        y.append(x + 0.5 * rng.normal())
        x = 0.8 * x + 3 * one + rng.normal()
    fit = lb.fit_noise(
        plant, lb.Record(y, u), parameters={"A[0,0]": 0.5, "B[0,0]": 2.0}
    )
    for name, true in (("A[0,0]", 0.8), ("B[0,0]", 3.0)):
        assert abs(fit.parameters[name] - true) < 3 * fit.standard_errors[name] < 0.3
    assert fit.plant.A[0, 0] == fit.parameters["A[0,0]"]


def test_a_variance_of_zero_is_said_to_be_at_its_bound():
    """White noise about a level that does not walk."""
    y = np.random.default_rng(1).normal(size=(100, 1))
    fit = lb.fit_noise(LEVEL, y)
    assert fit.plant.Q[0, 0] < 1e-3
    flat = lb.fit_noise(
        LEVEL, y - np.repeat(y.reshape(-1, 10).mean(axis=1), 10)[:, None]
    )
    assert flat.plant.Q[0, 0] == 0
    assert "Q has rank 0 of 1" in flat.unidentifiable[0]
    assert np.isnan(flat.standard_errors["Q"]).all()
    assert flat.standard_errors["R"][0, 0] > 0


BEHIND = lb.Plant([[0.9, 0.1], [0, 0.8]], None, [[1, 0]], dt=1.0)  # one state hidden


def test_autocovariances_say_which_variance_is_at_its_bound():
    """It has no standard error of 1e-33, and it is not known."""
    fits = []
    for seed in range(3):
        y = drawn(seed, 150, BEHIND, np.diag([1, 0.25]), np.eye(1))
        options = dict(Q="diagonal", R="diagonal", method="autocovariance")
        fits.append(lb.fit_noise(BEHIND, y, **options))
    gone = [fit for fit in fits if fit.plant.Q[1, 1] < 1e-6]
    assert gone
    for fit in gone:
        assert fit.plant.Q[1, 1] == 0
        assert np.isnan(fit.standard_errors["Q"][1, 1])
        assert fit.unidentifiable[0].startswith("Q[1,1] is at its bound")
    assert all(0 < fit.standard_errors["Q"][0, 0] < 1 for fit in fits)


def never(done, total):
    raise AssertionError("a search has begun")


@pytest.mark.parametrize("method", ["likelihood", "autocovariance"])
def test_a_known_covariance_of_both_noises_may_forbid_a_variance_of_zero(
    method, recwarn
):
    """With S[1] a Q[1,1] of zero is no covariance; the bound is not tried there."""
    for seed in range(3):
        y = drawn(seed, 400, BEHIND, np.diag([1, 0.25]), np.eye(1))
        options = dict(Q="diagonal", R="diagonal", method=method)
        fit = lb.fit_noise(BEHIND, y, S=[[0.1], [0.0]], **options)
        np.testing.assert_array_equal(fit.plant.S, [[0.1], [0]])
        beside = lb.fit_noise(BEHIND, y, **options)
        assert fit.log_likelihood == pytest.approx(beside.log_likelihood, abs=0.1)
        with pytest.raises(lb.DesignError, match="S, which is known, is too large"):
            lb.fit_noise(BEHIND, y, S=[[100], [0]], progress=never, **options)
    assert not recwarn.list


def test_what_is_known_stays():
    plant = dataclasses.replace(LEVEL, R=[[2.0]])
    y = drawn(9, 300, LEVEL, np.array([[0.5]]), np.array([[2.0]]))
    fit = lb.fit_noise(plant, y, R=None)
    assert fit.plant.R[0, 0] == 2 and fit.standard_errors["R"][0, 0] == 0
    half = dataclasses.replace(LEVEL, Q=[[0.25]], R=[[1.0]])
    scaled = lb.fit_noise(half, y, Q="scaled", R="scaled")
    full = lb.fit_noise(LEVEL, y)
    np.testing.assert_allclose(scaled.plant.Q, full.plant.Q, rtol=1e-4)
    assert scaled.parameters["q[0]"] == pytest.approx(4 * full.plant.Q[0, 0], rel=1e-4)


TWO = lb.Plant([[0.5]], None, [[1], [1]], dt=1.0)
HALF = lb.Plant([[0.5]], None, [[1]], dt=1.0)


Y = drawn(1, 50, LEVEL, np.eye(1), np.eye(1))


@pytest.mark.parametrize(
    ("plant", "y", "options", "said"),
    [
        (POSITION, Y, {}, r"no record of this plant determines Q\[0,0\] and Q\[0,1\]"),
        (lb.Plant([[0]], None, [[1]], dt=1.0), Y, {}, "apart, but only the sum"),
        (LEVEL, Y[:4], {}, "too short: 4 readings, less 1 that the unknown start"),
        (LEVEL, np.full((50, 1), 3.0), {}, "'y1' is constant in the record, at 3"),
        (LEVEL, np.full((50, 1), np.nan), {}, "have no measurement in the record"),
        (LEVEL, np.arange(50.0), dict(R=None), "it has none"),
        (lb.Plant([[1]], None, [[1]]), Y, {}, "dt = 0"),
        (lb.Plant(np.eye(2) * 2, None, [[1, 0]], dt=1.0), Y, {}, "not detectable"),
        (LEVEL, Y, dict(method="guess"), "method must be one of"),
        (LEVEL, Y, dict(method=np.ones(2)), "method must be one of"),
        (LEVEL, 1e200 * Y, {}, "'y1' has readings up to .* larger unit"),
        (LEVEL, Y, dict(start=[1]), "start must be a dict"),
        (LEVEL, Y, dict(Q="round"), "Q must be 'full'"),
        (LEVEL, Y, dict(Q="scaled"), "times a number, and the plant has none"),
        (LEVEL, Y, dict(S=[[1, 2]]), "S must be 1 x 1"),
        (LEVEL, Y, dict(S="full"), "it is not fitted"),
        (LEVEL, Y, dict(Q=np.diag, start={"Q": ["a"]}), "a function of positive"),
        (LEVEL, Y, dict(Q=np.diag, start={"Q": [np.inf]}), "a function of positive"),
        (LEVEL, Y, dict(parameters={"D[0,0]": 1}), "are no entries of the plant"),
        (LEVEL, Y, dict(parameters={"A[1,0]": 1}), r"there is no A\[1,0\]: A is 1 x 1"),
        (LEVEL, Y, dict(parameters={"A[0,0]": "x"}), "is no number"),
        (LEVEL, Y, dict(parameters=[1]), "parameters must be"),
        (LEVEL, lb.Record([Y, Y], 5), {}, r"record 0: u must be \(N, 0\)"),
        (LEVEL, [], {}, "have no measurement in the record"),
        (LEVEL, {"y": Y}, {}, "y must be an array .* not 'dict'"),
        (TWO, [np.ones(9), np.ones(8)], {}, "y must be an array of numbers"),
        (TWO, [np.ones((9, 2)), np.ones(9)], {}, r"record 1: y must be \(N, 2\)"),
        (LEVEL, Y, dict(parameters={"A[0,0]": 1}, method="autocovariance"), "out"),
        (LEVEL, Y, dict(R=[[0]]), "with R=None here"),
        (LEVEL, Y, dict(parameters=(lambda v: None, {"a": 1})), "returns must be a Pl"),
        (LEVEL, Y, dict(parameters=(lambda v: POSITION, {"a": 1})), "n, m, p"),
        (HALF, 2.0 * 0.5 ** np.arange(40.0), {}, "without any noise"),
    ],
)  # fmt: skip
def test_what_cannot_be_fitted_is_refused(plant, y, options, said, recwarn):
    with pytest.raises((ValueError, TypeError), match=said):
        lb.fit_noise(plant, y, **options)
    assert not recwarn.list


# -- standard errors -------------------------------------------------------------------

A = np.array([[0.8, 0.3], [-0.2, 0.6]])
Q = np.array([[1.0, 0.4], [0.4, 0.8]])
BOTH = lb.Plant(A, None, np.eye(2), dt=1.0, Q=Q, R=0.2 * np.eye(2), P0=np.eye(2))


def record(plant, rows=600, seed=4):
    return lb.simulate(plant, lb.kalman_filter(plant), rows, seed=seed).y


def test_a_sum_of_correlated_numbers_has_the_error_of_the_sum():
    """Q in full, and as G diag(q) G': the same Q, which three numbers q make."""
    y = record(BOTH)
    G = [[1, 0, 1], [0, 1, 1]]
    full, parts = lb.fit_noise(BOTH, y, R=None), lb.fit_noise(BOTH, y, Q=G, R=None)
    np.testing.assert_allclose(parts.plant.Q, full.plant.Q, rtol=1e-3)
    wanted, found = full.standard_errors["Q"], parts.standard_errors["Q"]
    np.testing.assert_allclose(found, wanted, rtol=1e-2)
    assert parts.standard_errors["q[2]"] == pytest.approx(wanted[0, 1], rel=1e-2)
    q = [parts.standard_errors[f"q[{k}]"] for k in range(3)]
    alone = np.hypot(q[0], q[2])  # as if q[0] and q[2] erred independently
    assert abs(alone / wanted[0, 0] - 1) > 0.05


ONE = lb.Plant(A, None, [[1, 0]], dt=1.0, Q=np.diag([0.5, 2]), R=[[1]], P0=np.eye(2))


@pytest.mark.parametrize(
    ("function", "slope"),
    [
        (np.diag, lambda q: 1 + 0 * q),
        (lambda q: np.diag(3 * q), lambda q: 3 + 0 * q),
        (lambda q: np.diag(q**2), lambda q: 2 * q),
    ],
)
def test_a_function_of_numbers_has_the_errors_of_the_entries_it_makes(function, slope):
    y = record(ONE)
    plain = lb.fit_noise(ONE, y, Q="diagonal")
    start = {"Q": [1.0, 1.0]}
    found = lb.fit_noise(ONE, y, Q=function, start=start)
    wanted = plain.standard_errors["Q"].diagonal()
    made = found.standard_errors["Q"].diagonal()
    np.testing.assert_allclose(found.plant.Q, plain.plant.Q, atol=2e-3)
    np.testing.assert_allclose(made, wanted, rtol=2e-2)
    q = np.array([found.parameters[f"q[{k}]"] for k in range(2)])
    error = [found.standard_errors[f"q[{k}]"] for k in range(2)]
    np.testing.assert_allclose(error, wanted / slope(q), rtol=2e-2)
    (R,) = found.standard_errors["R"]
    assert R == pytest.approx(plain.standard_errors["R"][0], rel=2e-2)


def test_two_standard_errors_hold_the_truth():
    """A few of the thousand plants of `python tests/support/coverage_of_errors.py`."""
    found = [one for seed in range(16) for one in of_plant(seed, (2, 1))]
    part, entries = share(found)
    assert entries > 30 and 0.85 <= part
    spread = np.std([off for off, ok in found if ok])
    assert 0.75 < spread < 1.3
