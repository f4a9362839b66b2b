"""The library's filters agree with rational arithmetic where covariances are singular.

The problems are those of `exact_filter.problem`: rows of A and C that annihilate the
uncertain direction, Q, R, P0 of every rank, S, gaps, accurate outputs, unstable modes
and states in units from 1e-6 to 1e6.  Many more are judged by `tests/support/judge`.
"""

import exact_filter
import generators
import numpy as np
import pytest
from in_full import in_full

import luenberger as lb
from luenberger.recursion import root_step
from luenberger.recursion.settings import Settings
from tests.papers.leondes_novak import test_perfect_measurements


@pytest.mark.parametrize("seed", range(10))
def test_the_oracle_agrees_with_the_one_that_augments_the_state(seed):
    """Two filters in Fractions that share no formula: noise as state, or as gain."""
    plant, y, u, u0 = test_perfect_measurements.integer_plant(seed)
    found = exact_filter.run(plant, y, u, u0)
    x, P = exact_filter.as_floats(found)
    wanted_x, wanted_P = generators.exact(plant, y, u, u0)
    np.testing.assert_allclose(x, wanted_x, rtol=1e-15, atol=0)
    np.testing.assert_allclose(P, wanted_P, rtol=1e-15, atol=0)
    assert max(found.gaps) == 0


@pytest.mark.parametrize("accurate", [(), (0,), (0, 1)])
def test_the_oracle_takes_accurate_outputs_at_their_word(accurate):
    problem = next(p for p in map(exact_filter.problem, range(99)) if len(p.y[0]) > 2)
    found = exact_filter.run(problem.model, problem.y, accurate=accurate)
    C = problem.model.C
    for x, y in zip(found.x, problem.y):
        for j in accurate:
            assert y[j] is None or C[j] @ x == y[j]


def test_the_oracle_decides_a_contradiction_exactly():
    """A^3 = I, so the fourth reading must be the first; no bit less."""
    plant = lb.Plant(
        [[-2, 3], [-1, 1]], None, [[2, 1]], dt=1.0, Q=np.zeros((2, 2)), R=[[0]],
        P0=np.eye(2),
    )  # fmt: skip
    y = np.array([[0.13], [np.nan], [np.nan], [0.13]])
    assert exact_filter.run(plant, y).gaps == [0, 0, 0, 0]
    y[3] = np.nextafter(0.13, 1)
    assert exact_filter.run(plant, y).gaps[3] == np.spacing(0.13)


# -- the library beside the oracle ----------------------------------------------------

TOL = 1e-9  # beside what each number was made of
HARD = [1617, 1660, 6344, 6350]  # S with known outputs; outputs of no size at all
DAMAGED = [420, 1618, 2660, 2835]  # readings up to 1e10 deviations off


@pytest.mark.parametrize("seed", [0, 1, 2, 3, *HARD])
def test_singular_problems_are_right_or_refused_for_a_reason(seed):
    """Estimates and covariances of the filter, the gains over steps and the error.

    Records fit the model exactly, so a refusal would be a false contradiction.
    """
    problem = exact_filter.problem(seed)
    found = problem.exact()
    assert max(found.gaps) == 0
    run = in_full(problem.plant, problem.record, m1=list(problem.accurate))
    require_right(run, problem, found, seed)


def require_right(run, problem, found, seed):
    off_x, off_P = problem.errors(run.x, run.P, found)
    slack = 0.0
    if max(off_x, off_P) > TOL:
        slack = problem.sensitivity(found)
    assert off_P < TOL + slack, (seed, off_P, slack, problem.kinds)
    slack += 1e-4 * slack**0.5
    assert off_x < TOL + slack, (seed, off_x, slack, problem.kinds)


@pytest.mark.parametrize("seed", [*HARD, *DAMAGED])
def test_a_damaged_reading_is_refused_exactly_where_it_contradicts(seed):
    """No contradiction is accepted, and nothing else is refused, or wrong."""
    problem = exact_filter.problem(seed).damaged(np.random.default_rng(seed))
    given = dict(m1=list(problem.accurate))
    if max(problem.exact().gaps) > 0:
        with pytest.raises(lb.DesignError, match="contradict"):
            in_full(problem.plant, problem.record, **given)
    else:
        run = in_full(problem.plant, problem.record, **given)
        require_right(run, problem, problem.exact(), seed)


def test_gains_of_outputs_with_all_sorts_of_noise_have_all_digits():
    """Deviations of 1 to 1e-10: to M = C Omega C' + R the smaller ones are rounding."""
    rng = np.random.default_rng(3)
    for _ in range(40):
        n, p = rng.integers(1, 5, size=2)
        C = rng.normal(size=(p, n)) * 10.0 ** rng.integers(-6, 7, size=(p, 1))
        H = rng.normal(size=(n, n)) * 10.0 ** rng.integers(-3, 4, size=n)
        R = np.diag(100.0 ** -rng.uniform(0, 10, p))
        now = Settings(lb.Plant(np.eye(n), None, C, dt=1.0, Q=0 * H, R=R), 0).at(0)
        H_minus, V = exact_filter.rational(H), exact_filter.rational(now.V)
        L = exact_filter.rational(C) @ H_minus
        M = L @ L.T + V @ V.T
        K = exact_filter.solve(M, H_minus @ L.T)[0].astype(float)
        unit = np.sqrt(M.diagonal().astype(float))
        found = root_step.definite(now, H, unit)["Kmv"]
        e = unit * rng.normal(size=p)
        assert np.abs((found - K) @ e).max() < 1e-12 * np.abs(K @ e).max()


def test_gains_over_steps_have_the_covariance_that_is_exact():
    """`kalman_filter(steps=)` run by `estimate`; `error_covariance(steps=)` of it."""
    done = 0
    for problem in map(exact_filter.problem, range(100)):
        if "gaps" in problem.kinds or problem.accurate:
            continue
        found, steps = problem.exact(), len(problem.y)
        observer = lb.kalman_filter(problem.plant, steps=steps)
        x = lb.estimate(observer, problem.record)
        P = lb.error_covariance(observer, problem.plant, steps=steps)[1:]
        worst = problem.errors(x, P, found)
        assert max(worst) < 1e-7, (worst, problem.kinds)
        done += 1
    assert done > 15


# -- cases that were wrong without a word ---------------------------------------------

BACKENDS = ["numpy", "numba"]


@pytest.fixture(params=BACKENDS)
def backend(request):
    if request.param == "numba":
        pytest.importorskip("numba", reason="numba is an optional extra")
    return request.param


def test_a_row_that_annihilates_the_uncertain_direction(backend):
    """3 * .1 is not .3, and what that leaves of a variance of zero is no variance."""
    plant = lb.Plant(
        [[-0.5, 2], [-3 * 0.1, -2 * 0.1]], None, [[1, 0]], dt=1.0,
        Q=np.zeros((2, 2)), R=[[1.0]], P0=[[4, -6], [-6, 9]],
    )  # fmt: skip
    wanted = plant.A @ plant.P0 @ plant.A.T
    (found,) = in_full(plant, [[np.nan]], backend=backend).P
    np.testing.assert_allclose(found, wanted, rtol=1e-14, atol=1e-14)
    assert found[0, 0] == pytest.approx(49, rel=1e-14)


def test_one_direction_seen_by_a_good_sensor(backend):
    """The first standard deviation came out as 1.41, the estimate far off."""
    plant = lb.Plant(
        [[2, -3, 1], [0.3, -0.1, 0.1], [-1, 1.5, 1.5]], None, [[0, 2, -2]], dt=1.0,
        Q=np.zeros((3, 3)), R=[[1e-3]], P0=0.49 * np.outer([0, 1, 1], [0, 1, 1]),
    )  # fmt: skip
    y = np.array([[0.3], [0.1], [-0.2], [0.4]])
    x, P = generators.exact(plant, y)
    run = in_full(plant, y, backend=backend)
    np.testing.assert_allclose(run.x, x, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(run.P, P, rtol=1e-9, atol=1e-15)
    observer = lb.kalman_filter(plant, steps=4, backend=backend)
    np.testing.assert_allclose(lb.estimate(observer, y), x, rtol=1e-11, atol=1e-15)
    found = lb.error_covariance(observer, plant, steps=4)[1:]
    np.testing.assert_allclose(found, P, rtol=1e-9, atol=1e-15)


def test_an_encoder_at_rest_beside_a_rate_sensor_agrees_with_itself():
    """y = 0 exactly: readings are compared with what they met, not with each other."""
    for seed in range(60):
        rng = np.random.default_rng(seed)
        dt, q, r = rng.choice([0.01, 0.1, 0.5]), *10.0 ** rng.integers(-4, 2, size=2)
        plant = lb.Plant(
            [[1, dt], [0, 0.9]], None, np.eye(2), dt=dt, Q=np.diag([0, q]),
            R=np.diag([0, r]), P0=np.eye(2),
        )  # fmt: skip
        y = np.column_stack([np.zeros(20), rng.normal(size=20) * np.sqrt(r)])
        x = in_full(plant, y).x
        assert np.abs(x[:, 0]).max() < 1e-13 * (1 + np.abs(x).max()), seed


CYCLE = lb.Plant(
    [[-2, 3], [-1, 1]], None, [[2, 1]], dt=1.0, Q=np.zeros((2, 2)), R=[[0]],
    P0=np.eye(2),
)  # fmt: skip


@pytest.mark.parametrize("fourth, refused", [(0.13, False), (-0.109, True)])
def test_what_is_known_after_gaps_can_be_contradicted(fourth, refused):
    y = [[0.13], [np.nan], [np.nan], [fourth]]  # A^3 = I
    if refused:
        with pytest.raises(lb.DesignError, match="instant 4 .*'y1'.* by 0.239"):
            in_full(CYCLE, y)
    else:
        run = in_full(CYCLE, y)
        np.testing.assert_allclose(run.x[3], run.x[0], rtol=1e-14)


@pytest.mark.parametrize("other", [None, 1e-3], ids=["alone", "beside a noisy one"])
def test_rounding_that_grows_through_a_gap_is_no_contradiction(other):
    """The state is known exactly, and starts as near as can be on the stable mode.

    Over 30 instants without the noise-free output the unstable mode makes of the
    rounding as much as there is left of the state.
    """
    for seed in range(6):
        rng = np.random.default_rng(seed)
        modes = rng.normal(size=(2, 2))
        A = modes @ np.diag([rng.uniform(1.5, 2.5), 0.6]) @ np.linalg.inv(modes)
        C, R = rng.normal(size=(1, 2)), [[0.0]]
        if other is not None:
            C, R = np.vstack([C, [1, 0]]), np.diag([0, other])
        plant = lb.Plant(
            A, None, C, dt=1.0, Q=np.zeros((2, 2)), R=R, P0=np.zeros((2, 2)),
            x0=modes[:, 1],
        )  # fmt: skip
        x, _ = generators.exact(plant, np.full((36, len(C)), np.nan))
        y = x @ plant.C.T
        y[3:34, 0] = np.nan
        run = in_full(plant, y)
        assert np.abs(run.x - x).max() < 1e-13 * 2.5**36, seed
        y[35, 0] += 1e-12 * 2.5**36
        with pytest.raises(lb.DesignError, match="instant 36 .*contradict"):
            in_full(plant, y)


@pytest.mark.parametrize("offset, refused", [(1e-7, False), (1e-5, True)])
def test_a_record_may_be_rounded_by_one_part_in_a_million(offset, refused):
    y = [[0.13], [np.nan], [np.nan], [0.13 * (1 + offset)]]
    if refused:
        with pytest.raises(lb.DesignError, match="contradict"):
            in_full(CYCLE, y)
    else:
        assert np.isfinite(in_full(CYCLE, y).x).all()


def test_integer_records_that_fit_exactly_are_not_refused():
    """15 instants, so that rounding grows behind states that are known exactly."""
    for seed in range(100):
        plant, *_ = test_perfect_measurements.integer_plant(seed)
        rng = np.random.default_rng(seed)
        joint = np.block([[plant.Q, plant.S], [plant.S.T, plant.R]])
        H, start = joint, plant.P0  # columns that the noise can really take
        y, u, u0 = generators.integer_record(rng, plant, H, start, steps=15)
        if np.abs(y).max() < 2**50:  # beyond it the record itself is rounded
            assert np.isfinite(in_full(plant, y, u, u0=u0).x).all(), seed


# -- (33) with R singular and S: which J ----------------------------------------------


def two_plants():
    """One noisy output and one noise-free, S with the first; both see state 1."""
    Q, S = np.diag([1.0, 2]), np.array([[0.5, 0], [0.25, 0]])
    return lb.Plant(
        [[1, 1], [0, 0.5]], None, [[1, 1], [1, 0]], dt=1.0, Q=Q, R=np.diag([1.0, 0]),
        S=S, P0=np.eye(2),
    )  # fmt: skip


@pytest.mark.parametrize(
    "accurate, matters", [((), False), ((1,), False), ((0,), True)], ids=str
)
def test_which_J_matters_only_beside_a_noisy_output_taken_at_its_word(
    accurate, matters, monkeypatch
):
    """J R = S leaves J free where R is blind; S R^+ is what the library takes.

    Another J tells the filter the residual of the noise-free output too.  That is
    zero unless a noisy output is treated as exact
    (papers/leondes_novak/derivation/stages.py).
    """
    plant = two_plants()
    y = np.array([[1.0, 2], [0, 1], [3, -1], [2, 2]])
    run = in_full(plant, y, m1=list(accurate))
    x, P = exact_filter.as_floats(exact_filter.run(plant, y, accurate=accurate))
    np.testing.assert_allclose(run.x, x, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(run.P, P, rtol=1e-12, atol=1e-14)
    least = exact_filter.J_of
    more = exact_filter.rational(np.array([[0, 0.75], [0, 0.25]]))
    monkeypatch.setattr(exact_filter, "J_of", lambda S, R: least(S, R) + more)
    _, other = exact_filter.as_floats(exact_filter.run(plant, y, accurate=accurate))
    assert (abs(np.trace(P[-1]) - np.trace(other[-1])) > 1e-4) == matters


@pytest.mark.parametrize("std, real", [(1e-12, True), (1e-16, False)])
def test_a_small_variance_is_real_until_it_is_rounding(std, real):
    """y = -b beside states of size 1: 1e-24 of a variance is used, 1e-32 is not."""
    plant = lb.Plant(
        [[1, 0], [1, 1]], None, [[1, -1]], dt=1.0, Q=np.zeros((2, 2)), R=[[0]],
        P0=np.diag([1, std**2]),
    )  # fmt: skip
    run = in_full(plant, [[-0.7 * std]])
    found = run.x[0, 1] - run.x[0, 0]
    assert found == pytest.approx(0.7 * std if real else 0, rel=1e-3, abs=1e-20)
