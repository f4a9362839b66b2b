"""The sampled loop: Table II, exactness against other integrators, and refusals."""

import math
import pickle
import warnings

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.optimize
import sympy as sp
from matplotlib.figure import Figure

import luenberger as lb
from luenberger import sampling
from luenberger.papers.hsia import system
from luenberger.papers.hsia.derivation import laws as derivation
from luenberger.papers.hsia.derivation import loop
from luenberger.papers.hsia.system import absolute_integral
from luenberger.period import hold

PAPER = lb.Plant([[0, 1], [0, 0]], [[0], [1]], [[100, 10]])
INTEGRATOR = lb.Plant([[0]], [[1]], [[1]])
ROWS = [
    pytest.param(law, value, E, samples, id=f"{law} {value}")
    for law, row in derivation.TABLE_II.items()
    for (value, E), samples in zip(row, derivation.SAMPLES)
]
ADAPTIVE = [row for row in ROWS if row.values[0] != "periodic"]


def run_of(law, value, plant=PAPER, duration=1.2, **options):
    return sampling.simulate(getattr(sampling, law)(value), plant, duration, **options)


def random_plant(seed, n):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) - np.eye(n)
    B, C = rng.normal(size=(n, 1)), rng.normal(size=(1, n))
    return lb.Plant(A, B, C, x0=rng.normal(size=n))


# -- published ----------------------------------------------------------------------


@pytest.mark.parametrize("law, value, E, samples", ROWS)
def test_table_ii(law, value, E, samples):
    run = run_of(law, value)
    if law == "periodic":
        assert run.samples == samples and abs(run.E - E) < 2e-5
    else:
        assert abs(run.samples - samples) <= 1 and abs(run.E / E - 1) < 0.08


def misses(**options):
    return [
        abs(run_of(law, value, **options).E / E - 1)
        for law, value, E, _ in (row.values for row in ADAPTIVE)
    ]


def test_table_ii_on_average():
    assert np.mean(misses()) < 0.025


def test_other_readings_of_the_rate_miss_the_table():
    assert np.mean(misses(rate="difference")) > 0.06
    assert np.mean(misses(rate="after")) > 0.13
    for rate in ("before", "after", "difference"):  # as if the step were not seen
        assert np.mean(misses(rate=rate, first_rate=0.0)) > 1.5


def test_all_four_laws_beat_the_periodic_curve():
    """The paper's second conclusion, at equal numbers of samples."""
    for law, value, _, _ in (row.values for row in ADAPTIVE):
        run = run_of(law, value)
        assert run.E < 0.85 * run_of("periodic", 1.2 / run.samples).E


# -- exact --------------------------------------------------------------------------


def test_an_integrator_by_hand():
    """u = 1 up to t = 1, then 0: y = t, then 1, against y* = 1 - e^-t."""
    run = run_of("periodic", 1.0, INTEGRATOR, 2.0)
    assert run.t.tolist() == [0, 1] and np.allclose(run.u, [1, 0], atol=1e-15)
    assert abs(run.E - (1 / 2 - np.exp(-2))) < 1e-15


def test_the_continuous_response_of_the_paper_in_closed_form():
    derived = loop.VALUES[loop.y_star][0]
    times = np.linspace(0, 1.2, 50)
    expected = sp.lambdify(loop.t, derived, "numpy")(times)
    _, _, found = run_of("root", 0.08).at(times)
    np.testing.assert_allclose(found, expected, atol=1e-13)


def replay(run, plant, reference):
    """y, y* and E by SciPy's integrators, with only the instants taken from `run`."""
    A, B, C, n = plant.A, plant.B[:, 0], plant.C[0], plant.n
    s = np.concatenate([plant.x0, plant.x0])
    ends = [*run.t[1:], run.duration]
    E, y = 0.0, []
    for t, end in zip(run.t, ends):
        u = reference(t) - C @ s[:n]

        def motion(t, s, u=u):
            x, x_star = s[:n], s[n:]
            return np.concatenate(
                [A @ x + B * u, A @ x_star + B * (reference(t) - C @ x_star)]
            )

        options = dict(method="DOP853", rtol=1e-12, atol=1e-13, dense_output=True)
        path = scipy.integrate.solve_ivp(motion, (t, end), s, **options)

        def missed(t, path=path):
            return C @ path.sol(t)[n:] - C @ path.sol(t)[:n]

        grid = np.linspace(t, end, 60)
        d = missed(grid)
        crossings = [
            scipy.optimize.brentq(missed, *grid[k : k + 2], xtol=1e-13)
            for k in np.flatnonzero(d[1:] * d[:-1] < 0)
        ]
        for low, high in zip([t, *crossings], [*crossings, end]):
            E += abs(scipy.integrate.fixed_quad(missed, low, high, n=24)[0])
        y.append(C @ s[:n])
        s = path.y[:, -1]
    return np.array(y), E, s


REFERENCES = {
    "step": (sampling.step(0.7), lambda t: 0.7),
    "ramp": (sampling.ramp(2.0), lambda t: 2 * t),
    "sine": (sampling.sine(1.5, 3.0, 0.4), lambda t: 1.5 * np.sin(3 * t + 0.4)),
}


@pytest.mark.parametrize("kind", REFERENCES)
@pytest.mark.parametrize("seed, n", [(1, 1), (2, 2), (3, 3), (4, 5)])
def test_against_another_integrator(seed, n, kind):
    plant, (reference, r) = random_plant(seed, n), REFERENCES[kind]
    law = sampling.absolute(0.6, T_min=0.1, T_max=0.5)
    run = sampling.simulate(law, plant, 2.5, reference=reference)
    y, E, s = replay(run, plant, r)
    np.testing.assert_allclose(run.y, y, atol=1e-9)
    np.testing.assert_allclose(run.u, [r(t) for t in run.t] - y, atol=1e-9)
    assert abs(run.E - E) < 1e-8
    expected = [r(2.5), plant.C[0] @ s[:n], plant.C[0] @ s[n:]]
    np.testing.assert_allclose(np.ravel(run.at([2.5])), expected, atol=1e-9)


def test_the_rate_is_the_slope_of_the_error_on_the_side_asked_for():
    reference, step = sampling.sine(1.0, 4.0), 1e-7
    for side, reading in ((-1, "before"), (1, "after")):
        run = run_of("absolute", 0.3, reference=reference, rate=reading)
        for t, rate in zip(run.t[1:], run.rates[1:]):
            r, y, _ = run.at(np.sort([t + side * 2 * step, t + side * step]))
            slope = ((r - y)[1] - (r - y)[0]) / step
            assert abs(abs(slope) - rate) < 1e-4 * (1 + rate)
    run = run_of("absolute", 0.3, rate="difference")
    np.testing.assert_allclose(
        run.rates[1:], np.abs(np.diff(run.u)) / run.periods[:-1], rtol=1e-12
    )


def test_a_relative_degree_of_two_leaves_no_jump_in_the_slope():
    plant = lb.Plant([[0, 1], [0, -1]], [[0], [1]], [[1, 0]])
    before, after = (
        run_of("absolute", 3.0, plant, 5.0, rate=rate) for rate in ("before", "after")
    )
    np.testing.assert_allclose(before.t, after.t, atol=1e-12)


def test_finer_sampling_approaches_the_continuous_loop():
    """E is of first order in the period: halving it halves E."""
    errors = [run_of("periodic", T).E for T in (0.01, 0.005, 0.0025)]
    assert np.allclose(np.divide(errors[:-1], errors[1:]), 2, atol=0.06)


def test_a_mode_far_faster_than_the_samples():
    """In the first period y* - y = -(1 - z)^2 / 2 with z = e^(-a t)."""
    a, T = 300.0, 0.5
    run = run_of("periodic", T, lb.Plant([[-a]], [[a]], [[1]]), T)
    assert abs(run.E - (T - 2 / a + 1 / (2 * a)) / 2) < 1e-15


def test_a_stiff_and_a_badly_scaled_plant():
    """Coordinates and a fast mode that does not show change nothing."""
    plain = run_of("linear", 0.01)
    scale = np.diag([1e6, 1e-4])
    bad = lb.Plant(
        scale @ PAPER.A @ np.linalg.inv(scale),
        scale @ PAPER.B,
        PAPER.C @ np.linalg.inv(scale),
    )
    stiff = lb.Plant(
        scipy.linalg.block_diag(PAPER.A, [[-2000]]),
        [*PAPER.B, [1]],
        np.hstack([PAPER.C, [[0]]]),
    )
    for plant in (bad, stiff):
        run = run_of("linear", 0.01, plant)
        np.testing.assert_allclose(run.t, plain.t, atol=1e-10)
        assert abs(run.E - plain.E) < 1e-10


def by_isolation(coefficients):
    """The integral of |p|, its sign changes isolated between those of p'."""
    p = np.polynomial.Polynomial(coefficients)

    def crossings(p):
        if p.degree() < 1:
            return []
        ends = [0, *crossings(p.deriv()), 1]
        changes = (k for k in range(len(ends) - 1) if p(ends[k]) * p(ends[k + 1]) < 0)
        return [scipy.optimize.brentq(p, *ends[k : k + 2], xtol=1e-15) for k in changes]

    return np.abs(np.diff(p.integ()([0, *crossings(p), 1]))).sum()


@pytest.mark.parametrize("kind", ["series", "graded", "double root", "no root at all"])
def test_absolute_integral(kind):
    rng = np.random.default_rng(7)
    factorial = np.cumprod([1, *range(1, 20)])
    for _ in range(60):
        c = rng.normal(size=20) / factorial
        if kind == "graded":
            c *= 10.0 ** -rng.uniform(0, 12, size=20)
        if kind == "double root":
            near = np.polynomial.Polynomial([0.09, -0.6, 1]) + 1e-9 * rng.normal()
            c = (np.polynomial.Polynomial(c[:18]) * near).coef
        if kind == "no root at all":
            c[0] = 10.0
        assert abs(absolute_integral(c) - by_isolation(c)) < 1e-14
    assert absolute_integral(np.zeros(20)) == 0


def test_bernstein_coefficients():
    c, t = np.random.default_rng(2).normal(size=20), np.linspace(0, 1, 7)
    b = system.BERNSTEIN @ c
    n = len(c) - 1
    basis = [math.comb(n, j) * t**j * (1 - t) ** (n - j) for j in range(n + 1)]
    np.testing.assert_allclose(b @ basis, np.polynomial.Polynomial(c)(t), atol=1e-13)


# -- counting, bounds, determinism --------------------------------------------------


@pytest.mark.parametrize("T, samples", [(0.04, 30), (0.06, 20), (0.08, 15), (0.1, 12)])
def test_samples_are_the_instants_before_the_end(T, samples):
    """1.2 / T is whole, up to rounding: the instant 1.2 itself is not counted."""
    run = run_of("periodic", T)
    assert run.samples == samples and run.t[0] == 0
    np.testing.assert_allclose(run.t, T * np.arange(samples), atol=1e-14)
    assert run_of("periodic", T, duration=1.2 + 1e-6).samples == samples + 1


def test_counts_do_not_hang_on_rounding():
    for count in range(2, 80):
        run = sampling.simulate(sampling.periodic(1.2 / count), INTEGRATOR, 1.2)
        assert run.samples == count


@pytest.mark.parametrize("unit", [2.0**-30, 2.0**30])
def test_the_end_is_the_same_in_any_unit_of_time(unit):
    for count in (7, 49, 61):
        plant = lb.Plant([[0.0]], [[1.0 / unit]], [[1.0]])
        periods = sampling.periodic(1.2 * unit / count)
        assert sampling.simulate(periods, plant, 1.2 * unit).samples == count


@pytest.mark.parametrize("law, value, E, samples", ADAPTIVE)
def test_periods_keep_their_bounds(law, value, E, samples):
    run = run_of(law, value)
    assert run.periods.min() >= 0.02 and run.periods.max() <= 0.1
    assert run.periods[0] == 0.02  # a step has infinite rate
    np.testing.assert_allclose(np.diff(run.t), run.periods[:-1], atol=1e-15)
    other = getattr(sampling, law)(value, T_min=0.03, T_max=0.07)
    periods = sampling.simulate(other, PAPER, 1.2).periods
    assert periods[0] == 0.03 and periods.max() <= 0.07


def test_more_samples_for_larger_coefficients():
    for law in ("quadratic", "absolute", "linear"):
        counts = [run_of(law, value).samples for value in (1e-4, 0.01, 1.0)]
        assert counts == sorted(counts) and counts[0] < counts[-1]
    assert run_of("root", 0.2).samples < run_of("root", 0.02).samples


def test_runs_repeat_exactly():
    first, second = run_of("root", 0.08), run_of("root", 0.08)
    assert first.E == second.E and (first.t == second.t).all()
    assert (first.y == second.y).all()


def test_any_callable_is_a_law():
    def mine(rate):
        return 0.1 / (1 + rate) ** 0.5 if rate < 1e9 else 0.02

    law = sampling.bounded(mine, 0.02, 0.1)
    run = sampling.simulate(law, PAPER, 1.2)
    assert run.E == sampling.simulate(mine, PAPER, 1.2).E
    assert repr(law) == "bounded(mine, 0.02, 0.1)"
    own = sampling.bounded(lambda rate: 0.1 / (0.275 * rate + 1), 0.02, 0.1)
    assert (
        abs(sampling.simulate(own, PAPER, 1.2).E - run_of("absolute", 0.275).E) < 1e-15
    )


def test_laws_say_what_they_are():
    assert repr(sampling.periodic(0.04)) == "periodic(0.04)"
    assert repr(sampling.quadratic(0.05)) == "quadratic(0.05)"
    assert repr(sampling.root(1, T_max=0.5)) == "root(1, T_min=0.02, T_max=0.5)"
    for law, value in ((sampling.linear(0.01), 0.06), (sampling.periodic(0.3), 0.3)):
        periods = law([-4, 4])  # of |e'|, and of arrays
        assert np.shape(periods) == (2,) and np.allclose(periods, value)


@pytest.mark.parametrize("kind", derivation.TABLE_II)
def test_laws_can_be_sent_to_another_process(kind):
    law = getattr(sampling, kind)(0.05)
    sent = pickle.loads(pickle.dumps(law))
    assert repr(sent) == repr(law)
    assert [sent(rate) for rate in (0, 3, np.inf)] == [
        law(rate) for rate in (0, 3, np.inf)
    ]


def test_at_rest_law_3_samples_as_seldom_as_it_may():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        assert sampling.root(0.08)(0.0) == sampling.root(0.08)(0) == 0.1


def test_a_start_away_from_rest():
    law = sampling.periodic(1.0)
    run = sampling.simulate(law, INTEGRATOR, 2.0, x0=[1.0])
    assert run.E == 0 and (run.u == 0).all()
    moved = lb.Plant([[0]], [[1]], [[1]], x0=[1.0])
    assert sampling.simulate(law, moved, 2.0).E == 0


def test_an_unstable_loop_is_followed_while_it_is_finite():
    slow = run_of("periodic", 3.0, INTEGRATOR, 30.0, x0=[0.0])  # x+ = -2 x + 3
    np.testing.assert_allclose(slow.y, 1 - (-2.0) ** np.arange(10), rtol=1e-9)


def test_plot_of_a_run():
    run = run_of("root", 0.08)
    ax = Figure().subplots()
    assert lb.plot.sampled_response(run, ax, output="angle (rad)") is ax
    assert (ax.get_ylabel(), ax.get_xlabel()) == ("angle (rad)", "time (s)")
    star, y, dots = ax.lines
    assert all(not one.get_label().startswith("_") for one in ax.lines)
    assert (dots.get_xdata() == run.t).all() and (dots.get_ydata() == run.y).all()
    _, expected, continuous = run.at(y.get_xdata())
    assert (y.get_ydata() == expected).all() and (star.get_ydata() == continuous).all()


# -- the discrete plant -------------------------------------------------------------


def noisy(seed, n, p=2):
    rng = np.random.default_rng(seed)
    root = rng.normal(size=(n, n - 1))
    plant = random_plant(seed, n)
    return lb.Plant(
        plant.A, plant.B, rng.normal(size=(p, n)), Q=root @ root.T, R=np.eye(p),
        P0=np.eye(n), x0=plant.x0, state_names=[f"s{k}" for k in range(n)],
    )  # fmt: skip


def test_equal_periods_give_the_plant_that_is_held():
    plant = noisy(5, 3)
    sampled = sampling.discretise(plant, [0.3] * 4)
    A, B = hold(plant.A, plant.B, 0.3)
    assert sampled.steps == 5 and sampled.dt == 0.3
    for i in range(5):
        np.testing.assert_allclose(sampled.at(i).A, A, rtol=1e-14)
        np.testing.assert_allclose(sampled.at(i).B, B, rtol=1e-14)
        np.testing.assert_array_equal(sampled.at(i).A, sampled.A[0])
        np.testing.assert_array_equal(sampled.at(i).B, sampled.B[0])
    assert sampled.state_names == plant.state_names
    assert (sampled.x0 == plant.x0).all() and (sampled.P0 == plant.P0).all()


def test_rows_follow_the_periods():
    plant, periods = noisy(6, 3), [0.5, 0.1, 0.5, 0.2]
    sampled = sampling.discretise(plant, periods)
    for i, T in enumerate([*periods, 0.2]):
        np.testing.assert_allclose(sampled.at(i).A, scipy.linalg.expm(plant.A * T))
    assert sampled.dt == pytest.approx(np.mean(periods))
    prior = lb.Plant([[0]], None, [[1]], at_first=True, input_names=[], name="tank")
    kept = sampling.discretise(prior, [1.0])
    assert (kept.at_first, kept.name) == (True, "tank")
    assert (sampled.C == plant.C).all() and (sampled.R == plant.R).all()


@pytest.mark.parametrize("T", [0.05, 1.0, 8.0])
@pytest.mark.parametrize("seed, n", [(1, 2), (2, 4)])
def test_noise_against_quadrature(seed, n, T):
    plant = noisy(seed, n)

    rates, modes = np.linalg.eig(plant.A)
    inverse = np.linalg.inv(modes)

    def flow(t):
        Phi = (modes * np.exp(rates * t) @ inverse).real
        return Phi @ plant.Q @ Phi.T

    ends = np.linspace(0, T, 13)
    nodes, weights = np.polynomial.legendre.leggauss(16)
    expected = sum(
        w * (b - a) / 2 * flow((a + b) / 2 + (b - a) / 2 * x)
        for a, b in zip(ends, ends[1:])
        for x, w in zip(nodes, weights)
    )
    found = sampling.discretise(plant, [T]).at(0).Q
    np.testing.assert_allclose(found, expected, atol=1e-11 * np.abs(expected).max())


def test_noise_of_a_fast_stable_plant_over_a_long_period():
    """e^(-A t) overflows; the noise is the steady one."""
    plant = lb.Plant(np.diag([-1.0, -3000]), None, np.eye(2), Q=np.diag([2.0, 6]))
    Q = sampling.discretise(plant, [50.0]).at(0).Q
    np.testing.assert_allclose(Q, np.diag([1, 1e-3]), rtol=1e-12, atol=1e-18)


def test_a_period_in_two_parts_is_the_whole():
    plant = noisy(7, 3)
    parts = sampling.discretise(plant, [0.2, 0.5])
    whole = sampling.discretise(plant, [0.7]).at(0)
    first, second = parts.at(0), parts.at(1)
    np.testing.assert_allclose(second.A @ first.A, whole.A)
    np.testing.assert_allclose(second.A @ first.B + second.B, whole.B)
    np.testing.assert_allclose(second.A @ first.Q @ second.A.T + second.Q, whole.Q)


def test_the_sampled_loop_is_this_plant_with_its_own_inputs():
    run = run_of("root", 0.08)
    sampled = sampling.discretise(PAPER, run.periods)
    x = np.zeros(2)
    for i in range(run.samples):
        assert abs((sampled.C @ x)[0] - run.y[i]) < 1e-12
        x = sampled.at(i).A @ x + sampled.at(i).B[:, 0] * run.u[i]


def test_filters_take_the_sampled_plant():
    run = run_of("absolute", 0.275)
    plant = lb.Plant(
        PAPER.A, PAPER.B, PAPER.C, Q=np.diag([0, 4.0]), R=[[0.01]], P0=np.eye(2)
    )
    sampled, N = sampling.discretise(plant, run.periods), run.samples
    observer = lb.reduced_order_filter(sampled, 1, steps=N)
    kalman = lb.kalman_filter(sampled, steps=N)
    least = lb.error_covariance(kalman, sampled, steps=N).trace(axis1=1, axis2=2)
    reduced = lb.error_covariance(observer, sampled, steps=N).trace(axis1=1, axis2=2)
    assert len(reduced) == N + 1 and (reduced >= least - 1e-12).all()
    y = np.random.default_rng(3).normal(size=(N, 1))
    one_pass = lb.Filter(sampled, 1).run(y)
    np.testing.assert_allclose(one_pass.P.trace(axis1=1, axis2=2), reduced[1:])
    np.testing.assert_allclose(lb.estimate(observer, y), one_pass.x, atol=1e-9)
    with pytest.raises(lb.DesignError, match="take steps <="):
        lb.kalman_filter(sampled, steps=N + 1)


# -- refusals -----------------------------------------------------------------------

PLAIN = sampling.periodic(0.1)
BAD_LAWS = {
    "negative": (lambda rate: -0.1, r"period -0.1 at t = 0 s.*positive, finite"),
    "zero": (lambda rate: 0.0, "period 0.0 at"),
    "nan": (lambda rate: np.nan, "period nan at"),
    "never again": (lambda rate: np.inf, "period inf at.*bounded"),
    "nothing": (lambda rate: None, "period None at"),
    "array": (lambda rate: np.array([0.1, 0.2]), r"period \[0.1 0.2\] at"),
    "complex": (lambda rate: np.complex128(0.1 + 1j), r"period \(0.1\+1j\) at t = 0 s"),
    "truth": (lambda rate: True, "period True at t = 0 s"),
    "text": (lambda rate: "0.1", "period 0.1 at t = 0 s"),
    "later": (lambda rate: 0.1 if rate > 1e9 else -1, "period -1 at t = 0.1 s, rate"),
    "too often": (lambda rate: 1e-7, "more than 1000000 samples.*longer shortest"),
}


@pytest.mark.parametrize("name", BAD_LAWS)
def test_bad_periods_are_refused(name):
    law, message = BAD_LAWS[name]
    with pytest.raises(lb.DesignError, match=message):
        sampling.simulate(law, PAPER, 1.2)


def test_bounds_do_not_hide_a_period_that_is_not_a_number():
    law = sampling.bounded(lambda rate: np.nan, 0.02, 0.1)
    with pytest.raises(lb.DesignError, match=r"bounded\(<lambda>.*period nan"):
        sampling.simulate(law, PAPER, 1.2)


E = np.eye(2)
REFUSED = {
    "law": (lambda: sampling.simulate(0.1, PAPER, 1.2), "callable from rate to period"),
    "period": (lambda: sampling.periodic(0.0), "T must be a positive number, got 0.0"),
    "period inf": (lambda: sampling.periodic(np.inf), "T must be a positive number"),
    "alpha": (lambda: sampling.quadratic(-1), "alpha must be a positive number"),
    "alpha nan": (lambda: sampling.absolute(np.nan), "alpha must be a positive number"),
    "C": (lambda: sampling.root("x"), "C must be a positive number, got 'x'"),
    "K": (lambda: sampling.linear(True), "K must be a positive number, got True"),
    "bounds": (
        lambda: sampling.linear(1, T_min=0.2),
        "bounds are out of order: T_min = 0.2 s is longer than T_max = 0.1 s",
    ),
    "own bounds": (
        lambda: sampling.bounded(abs, 1, 0.5),
        "bounds are out of order",
    ),
    "T_min": (lambda: sampling.root(1, T_min=0), "T_min must be a positive number"),
    "own law": (lambda: sampling.bounded(0.1, 1, 2), "callable from rate to period"),
    "duration": (lambda: sampling.simulate(PLAIN, PAPER, 0), "duration must be posit"),
    "duration nan": (
        lambda: sampling.simulate(PLAIN, PAPER, np.nan),
        "duration must be positive and finite",
    ),
    "duration kind": (
        lambda: sampling.simulate(PLAIN, PAPER, [1]),
        "duration must be a number of seconds",
    ),
    "rate": (
        lambda: sampling.simulate(PLAIN, PAPER, 1, rate="left"),
        r"rate must be one of \('before', 'after', 'difference'\), got 'left'",
    ),
    "first rate": (
        lambda: sampling.simulate(PLAIN, PAPER, 1, first_rate=np.nan),
        "first_rate must be a number or infinity",
    ),
    "reference": (
        lambda: sampling.simulate(PLAIN, PAPER, 1, reference=1.0),
        r"reference must be `sampling.step\(size\)`",
    ),
    "reference with input": (
        lambda: sampling.simulate(PLAIN, PAPER, 1, reference=PAPER),
        "no inputs and one output",
    ),
    "size": (lambda: sampling.step(np.inf), "size has entries that are not finite"),
    "start": (
        lambda: sampling.simulate(PLAIN, PAPER, 1, x0=[1]),
        r"x0 must have shape \(2,\)",
    ),
    "times": (
        lambda: run_of("periodic", 0.1).at([0, 1.3]),
        "times must lie between 0 and 1.2 s",
    ),
    "one time": (
        lambda: run_of("periodic", 0.1).at(0.5),
        "times must be a list of seconds, got array",
    ),
    "complex times": (
        lambda: run_of("periodic", 0.1).at([0.5j]),
        "times must be an array of real numbers",
    ),
    "period of zero": (
        lambda: sampling.discretise(PAPER, [0.1, 0, 0.1]),
        r"periods\[1\] is 0 s",
    ),
    "no periods": (lambda: sampling.discretise(PAPER, []), "must be a list of seconds"),
    "period not finite": (lambda: sampling.discretise(PAPER, [np.inf]), "not finite"),
}
DESIGNS = {
    "discrete": (
        lambda: sampling.simulate(PLAIN, lb.Plant([[0]], [[1]], [[1]], dt=0.1), 1),
        "dt = 0.1: it is sampled already",
    ),
    "varying": (
        lambda: sampling.simulate(PLAIN, lb.Plant([[[0]]], [[1]], [[1]]), 1),
        "constant, real matrices",
    ),
    "two outputs": (
        lambda: sampling.simulate(PLAIN, lb.Plant(E, [[1], [0]], E), 1),
        "the plant has 1 and 2.*Close the other loops",
    ),
    "feedthrough": (
        lambda: sampling.simulate(PLAIN, lb.Plant([[0]], [[1]], [[1]], [[0.5]]), 1),
        "feedthrough E = 0.5: its output jumps",
    ),
    "too fast": (
        lambda: sampling.simulate(PLAIN, lb.Plant([[-1e9]], [[1]], [[1]]), 1),
        r"rates up to 1e\+09 per second",
    ),
    "divergence": (
        lambda: run_of("periodic", 3.0, lb.Plant([[5]], [[1]], [[1]]), 300.0),
        "the sampled loop diverges: beyond t = .*Sample more often",
    ),
    "discrete already": (
        lambda: sampling.discretise(lb.Plant([[1]], None, [[1]], dt=1.0), [1]),
        "discrete already",
    ),
    "correlated": (
        lambda: sampling.discretise(
            lb.Plant([[1]], None, [[1]], Q=[[1]], R=[[1]], S=[[0.1]]), [1]
        ),
        "the plant has S",
    ),
    "multiplicative": (
        lambda: sampling.discretise(
            lb.Plant([[1]], None, [[1]], multiplicative=[([[1]], [[0]])]), [1]
        ),
        "multiplicative noise is not",
    ),
    "growth": (
        lambda: sampling.discretise(
            lb.Plant([[3]], [[1]], [[1]], Q=[[1]], R=[[1]]), [1, 1e3]
        ),
        "within a period of 1000 s the plant grows beyond",
    ),
    "varying noise": (
        lambda: sampling.discretise(lb.Plant([[[1]]], None, [[1]]), [1]),
        "only constant, real plants",
    ),
}


@pytest.mark.parametrize("name", REFUSED)
def test_refusals(name):
    request, message = REFUSED[name]
    with pytest.raises(ValueError, match=message) as caught:
        request()
    assert not isinstance(caught.value, lb.DesignError)


@pytest.mark.parametrize("name", DESIGNS)
def test_designs_refused(name):
    request, message = DESIGNS[name]
    with pytest.raises(lb.DesignError, match=message):
        request()
