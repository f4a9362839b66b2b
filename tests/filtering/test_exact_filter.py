"""The library's filters agree with rational arithmetic where covariances are singular.

The problems are those of `exact_filter.problem`: rows of A and C that annihilate the
uncertain direction, Q, R, P0 of every rank, S, gaps, accurate outputs, unstable modes
and states in units from 1e-6 to 1e6.  Many more are judged by `tests/support/judge`.
"""

import dataclasses

import exact_filter
import generators
import numpy as np
import pytest
from in_full import in_full

import luenberger as lb
from luenberger.filtering import maps
from luenberger.recursion import root_step
from luenberger.recursion.settings import setting
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
        now = setting(lb.Plant(np.eye(n), None, C, dt=1.0, Q=0 * H, R=R))
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


def test_a_row_that_annihilates_the_uncertain_direction():
    """3 * .1 is not .3, and what that leaves of a variance of zero is no variance."""
    plant = lb.Plant(
        [[-0.5, 2], [-3 * 0.1, -2 * 0.1]], None, [[1, 0]], dt=1.0,
        Q=np.zeros((2, 2)), R=[[1.0]], P0=[[4, -6], [-6, 9]],
    )  # fmt: skip
    wanted = plant.A @ plant.P0 @ plant.A.T
    (found,) = in_full(plant, [[np.nan]]).P
    np.testing.assert_allclose(found, wanted, rtol=1e-14, atol=1e-14)
    assert found[0, 0] == pytest.approx(49, rel=1e-14)


def test_one_direction_seen_by_a_good_sensor():
    """The first standard deviation came out as 1.41, the estimate far off."""
    plant = lb.Plant(
        [[2, -3, 1], [0.3, -0.1, 0.1], [-1, 1.5, 1.5]], None, [[0, 2, -2]], dt=1.0,
        Q=np.zeros((3, 3)), R=[[1e-3]], P0=0.49 * np.outer([0, 1, 1], [0, 1, 1]),
    )  # fmt: skip
    y = np.array([[0.3], [0.1], [-0.2], [0.4]])
    x, P = generators.exact(plant, y)
    run = in_full(plant, y)
    np.testing.assert_allclose(run.x, x, rtol=1e-12, atol=1e-15)
    np.testing.assert_allclose(run.P, P, rtol=1e-9, atol=1e-15)
    observer = lb.kalman_filter(plant, steps=4)
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
        with pytest.raises(lb.DesignError, match="instant 4 .*'y1'.* contradicts"):
            in_full(CYCLE, y)
    else:
        run = in_full(CYCLE, y)
        np.testing.assert_allclose(run.x[3], run.x[0], rtol=1e-14)


@pytest.mark.parametrize("other", [None, 1e-3], ids=["alone", "beside a noisy one"])
@pytest.mark.parametrize("rows, left", [(10, True), (30, False)])
def test_rounding_that_grows_through_a_gap_is_no_contradiction(rows, left, other):
    """The state is known exactly, and starts as near as can be on the stable mode.

    In the rows without the noise-free output the unstable mode makes rounding larger,
    until it is as large as what there is of the state: then the record is refused.
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
        x, _ = generators.exact(plant, np.full((rows + 6, len(C)), np.nan))
        y = x @ plant.C.T
        y[3 : rows + 3, 0] = np.nan
        if left:
            run = in_full(plant, y)
            assert np.abs(run.x - x).max() < 1e-13 * 2.5**rows, seed
            y[-1, 0] += 1e-3
        with pytest.raises(lb.DesignError, match="contradict"):
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
    """15 instants, so that rounding grows behind states that are known exactly.

    In one it grows 14 times a row, as S feeds exact readings back, until no digits are
    left; in one no output shows an unstable mode.
    """
    refused = []
    for seed in range(100):
        plant, *_ = test_perfect_measurements.integer_plant(seed)
        rng = np.random.default_rng(seed)
        joint = np.block([[plant.Q, plant.S], [plant.S.T, plant.R]])
        H, start = joint, plant.P0  # columns that the noise can really take
        y, u, u0 = generators.integer_record(rng, plant, H, start, steps=15)
        if np.abs(y).max() < 2**50:  # beyond it the record itself is rounded
            try:
                assert np.isfinite(in_full(plant, y, u, u0=u0).x).all(), seed
            except lb.DesignError:
                refused.append(seed)
    assert refused == [33, 88]


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
    """y = -b beside states of size 1: 1e-24 of a variance is used, 1e-32 is none."""
    plant = lb.Plant(
        [[1, 0], [1, 1]], None, [[1, -1]], dt=1.0, Q=np.zeros((2, 2)), R=[[0]],
        P0=np.diag([1, std**2]),
    )  # fmt: skip
    if not real:
        with pytest.raises(lb.DesignError, match="contradicts what is known"):
            in_full(plant, [[-0.7 * std]])
        return
    run = in_full(plant, [[-0.7 * std]])
    assert run.x[0, 1] - run.x[0, 0] == pytest.approx(0.7 * std, rel=1e-3)


# -- what other forms of the filter had to be told ------------------------------------


def test_redundant_outputs_that_never_arrive_together():
    """They cannot both be treated as exact, but nothing asks for that."""
    plant = lb.Plant(
        [[0.9, 0.1], [0, 0.8]], None, [[1, 0], [2, 0]], dt=1.0, Q=np.eye(2),
        R=np.eye(2), P0=np.eye(2),
    )  # fmt: skip
    y = np.random.default_rng(1).normal(size=(12, 2))
    y[::2, 0], y[1::2, 1] = np.nan, np.nan
    assert np.isfinite(in_full(plant, y, m1=2).x).all()
    y[5] = 1
    with pytest.raises(lb.DesignError, match="dependent"):
        in_full(plant, y, m1=2)


def test_noise_free_for_a_while_and_a_contradiction():
    """R is zero at instants 10 to 12."""
    R = np.ones((30, 2, 2)) * np.eye(2)
    R[10:13] = 0
    plant = lb.Plant([[0.9]], None, [[1], [1]], dt=1.0, Q=[[1]], R=R, P0=[[1]])
    y = np.ones((29, 2))
    x, _ = generators.exact(plant, y)
    np.testing.assert_allclose(in_full(plant, y).x, x, rtol=1e-14)
    y[10] = [1, 2]  # instant 11
    with pytest.raises(lb.DesignError, match="instant 11 .*contradict"):
        in_full(plant, y)


@pytest.mark.parametrize("weight", [np.eye(4), np.diag([1.0, 2, 3, 4])])
@pytest.mark.parametrize("unit", [1e-6, 1e6])
def test_units_of_states_and_outputs(unit, weight):
    """Accurate outputs with noise, while the plant changes, with gaps."""
    rng, N = np.random.default_rng(3), 30
    plant = generators.varying(rng, 4, 3, N, m=1, cross=False)
    y, u, _ = generators.record(rng, plant, N)
    y = generators.holes(rng, y, 0.05)
    states = unit ** np.array([1.0, 0, 0.5, 1])
    outputs = unit ** np.array([0.0, 1, 1])
    T, S = np.diag(states), np.diag(outputs)
    other = lb.Plant(
        T @ plant.A / states, T @ plant.B, S @ plant.C / states, S @ plant.E, dt=1.0,
        Q=T @ plant.Q @ T, R=S @ plant.R @ S, P0=T @ plant.P0 @ T, x0=T @ plant.x0,
    )  # fmt: skip
    same = weight / states / states[:, None]
    found = in_full(other, y * outputs, u, m1=2, weight=same)
    wanted = in_full(plant, y, u, m1=2, weight=weight)
    np.testing.assert_allclose(found.x / states, wanted.x, rtol=1e-9, atol=1e-12)
    np.testing.assert_allclose(found.std / states, wanted.std, rtol=1e-9)


def test_accurate_outputs_that_depend_on_each_other_at_one_instant():
    """It is refused, unless one of them did not arrive there."""
    rng, N = np.random.default_rng(4), 30
    plant = generators.varying(rng, 4, 3, N, m=1, cross=False)
    C = plant.C.copy()
    C[12, 1] = 2 * C[12, 0]
    plant = dataclasses.replace(plant, C=C)
    y, u, _ = generators.record(rng, plant, N)
    with pytest.raises(lb.DesignError, match="dependent"):
        in_full(plant, y, u, m1=2)
    y[11, 1] = np.nan
    assert np.isfinite(in_full(plant, y, u, m1=2).x).all()


def test_a_small_difference_of_what_moves_together_keeps_its_digits():
    """Noise moves the states together, and one output is a difference of two.

    At instant 4 nothing drives them, and the instant tells them exactly.
    """
    rng = np.random.default_rng(412)
    Q = np.ones((4, 4)) + 1e-4 * np.diag(rng.uniform(0.5, 2, 4))
    one = np.array([5e-3, 0, 1, 0])
    Q = (Q + np.outer(one, one)) * np.ones((9, 1, 1))
    Q[4] = 0
    C = rng.normal(size=(3, 4))
    C[0] = [1, -1, 0, 0]
    plant = lb.Plant(
        generators.dynamics(rng, 4, 0.7), rng.normal(size=(4, 1)), C, np.zeros((3, 1)),
        Q=Q, R=np.diag([0, 4e-12, 0]), P0=np.eye(4), dt=1.0,
    )  # fmt: skip
    y, u, u0 = generators.record(rng, plant, 8)
    x, P = generators.exact(plant, y, u, u0)
    found = in_full(plant, y, u, u0=u0)
    slack = 1e-6 * np.sqrt(P.astype(float).diagonal(axis1=1, axis2=2))
    assert (np.abs(found.x - x.astype(float)) < slack + 1e-10).all()


@pytest.mark.parametrize("still", range(1, 9))
def test_a_reading_that_was_known_is_noticed_in_each_row(still):
    rng, Q = np.random.default_rng(still), np.eye(3) * np.ones((12, 1, 1))
    Q[still] = 0
    A, C = generators.dynamics(rng, 3, 0.9), rng.normal(size=(3, 3))
    plant = lb.Plant(A, None, C, dt=1.0, Q=Q, R=np.zeros((3, 3)), P0=np.eye(3))
    y = rng.normal(size=(11, 3))
    y[still] = np.nan, np.nan, C[2] @ A @ np.linalg.solve(C, y[still - 1])
    found = in_full(plant, y)
    np.testing.assert_allclose(found.std[still], 0, atol=1e-13)
    y[still, 2] += 0.01
    with pytest.raises(lb.DesignError, match=rf"instant {still + 1} .*contradicts"):
        in_full(plant, y)


def test_an_unstable_state_that_nothing_sees_is_refused():
    """Before its variance passes all bounds."""
    plant = lb.Plant(
        np.diag([1e30, 0.5]), None, [[0, 1]], dt=1.0, Q=np.eye(2), R=[[1]], P0=np.eye(2)
    )
    with pytest.raises(lb.DesignError, match="no output shows the unstable mode"):
        in_full(plant, np.zeros((20, 1)))


def test_patterns_of_missing_outputs_do_not_pile_up(monkeypatch):
    """Of twelve outputs there are 4096; each would keep its matrices."""
    monkeypatch.setattr(maps, "PATTERNS", 20)
    plant = lb.Plant(
        [[0.5]], None, np.ones((12, 1)), dt=1.0, Q=[[1]], R=np.eye(12), P0=[[1]]
    )
    rng = np.random.default_rng(8)
    y = rng.normal(size=(80, 12))
    y[rng.random(y.shape) < 0.5] = np.nan
    one, end, x = lb.Filter(plant), None, []
    for part in np.split(y, 8):
        found = one.run(part, start=end)
        x.append(found.x)
        end = found.end
    wanted, _ = generators.exact(plant, y)
    np.testing.assert_allclose(np.concatenate(x), wanted, rtol=1e-12)
    assert len(one.settings._known) <= 20
