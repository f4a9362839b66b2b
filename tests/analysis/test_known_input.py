"""Errors that a known input causes: against moments side by side, rationals, runs."""

import dataclasses
import functools
from fractions import Fraction

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis.error_covariance import mean_error

STEPS = 4


def model_of(rng, m, states=2, **options):
    """A stable model of m inputs with noises that are correlated."""
    half = rng.normal(size=(states + m, states + m))
    noise = half @ half.T
    A = rng.normal(size=(states, states))
    A *= 0.7 / np.abs(np.linalg.eigvals(A)).max()
    C = rng.normal(size=(m, states))
    given = dict(Q=noise[:states, :states], R=noise[states:, states:])
    return lb.Plant(A, None, C, dt=1.0, S=noise[:states, states:], **given, **options)


def side_by_side(observer, plant, model, steps):
    """E[e e'] at rows of the observer, from the moments of s, x and z and the noise."""
    o, j, n, r = observer, model.n, plant.n, observer.order
    m, p, varying = plant.m, plant.p, observer.steps is not None
    s = np.concatenate([model.x0, plant.x0, o.z0])
    P0 = np.zeros((j + n + r, j + n + r))
    P0[:j, :j], P0[j : j + n, j : j + n] = model.P0, plant.P0
    M, found = np.outer(s, s) + P0, []
    zeros = np.zeros
    rows = range(-varying, steps + (not varying))
    for k in rows:
        i = plant.at(k + varying)
        F, G, D, P, V, W = o.at(max(k, 0))
        if k < 0:  # z waits at instant 0, and takes u0 with it
            F, G, D = np.eye(r), o.G0, zeros((r, p))
        # noises: w_u, v_u, w, v
        Q, R, S = i.covariances()
        N = zeros((j + m + n + p, j + m + n + p))
        N[:j, :j], N[:j, j : j + m], N[j : j + m, j : j + m] = model.Q, model.S, model.R
        N[j : j + m, :j] = model.S.T
        N[j + m :, j + m :] = np.block([[Q, S], [S.T, R]])
        u = np.hstack(
            [model.C, zeros((m, n + r)), zeros((m, j)), np.eye(m), zeros((m, n + p))]
        )
        y = (
            np.hstack([zeros((p, j)), i.C, zeros((p, r + j + m + n)), np.eye(p)])
            + i.E @ u
        )
        x = np.eye(n, u.shape[1], j)
        z = np.eye(r, u.shape[1], j + n)
        at_s, w_u = np.eye(j, u.shape[1]), np.eye(j, u.shape[1], j + n + r)
        w = np.eye(n, u.shape[1], j + n + r + j + m)
        if k >= 0:
            both = np.block(
                [[M, zeros((len(M), len(N)))], [zeros((len(N), len(M))), N]]
            )
            e = P @ z + V @ y + W @ u - o.L @ x
            noisy = (V @ C1 @ x for _, C1 in plant.multiplicative)
            found.append(sum(one @ both @ one.T for one in (e, *noisy)))
        else:
            both = np.block(
                [[M, zeros((len(M), len(N)))], [zeros((len(N), len(M))), N]]
            )
            found.append(o.L @ plant.P0 @ o.L.T)
        ahead = [model.A @ at_s + w_u, i.A @ x + i.B @ u + w, F @ z + G @ u + D @ y]
        ahead = np.vstack(ahead)
        M = ahead @ both @ ahead.T
        for A1, C1 in plant.multiplicative:
            V_k = zeros((len(ahead), n))
            V_k[j : j + n], V_k[j + n :] = A1, D @ C1
            X = x @ both @ x.T
            M = M + V_k @ X @ V_k.T
    return np.array(found)


def unfit(rng, plant, model_believed=0.6, **options):
    """A filter of another plant: wrong in A, B, C and E."""
    wrong = {name: getattr(plant, name) * model_believed for name in "ABCE"}
    return lb.reduced_order_filter(dataclasses.replace(plant, **wrong), 1, **options)


@pytest.mark.parametrize("steps", [None, STEPS], ids=["constant", "over steps"])
@pytest.mark.parametrize("what", ["model", "level", "white", "multiplicative"])
def test_moments_from_the_start_on(steps, what):
    rng = np.random.default_rng(3)
    pairs = [(0.2 * rng.normal(size=(3, 3)), rng.normal(size=(2, 3)))]
    more = dict(multiplicative=pairs) if what == "multiplicative" else {}
    plant = generators.plant(rng, 3, 2, m=2, cross=True, **more)
    observer = unfit(rng, dataclasses.replace(plant, multiplicative=()), steps=steps)
    model = model_of(rng, 2, x0=[1.0, -2.0], P0=[[2.0, 1.0], [1.0, 3.0]])
    none = dict(dt=1.0, Q=[[0]], S=np.zeros((1, 2)), P0=[[0]])
    U = model
    if what == "level":
        U = [3.0, -1.0]
        model = lb.Plant([[1]], None, [[3], [-1]], R=np.zeros((2, 2)), x0=[1], **none)
    if what == "white":
        U = model.R
        model = lb.Plant([[0]], None, [[0], [0]], R=U, **none)
    found = lb.error_covariance(observer, plant.with_input(U), steps=STEPS)
    wanted = side_by_side(observer, plant, model, STEPS)
    np.testing.assert_allclose(found, wanted, rtol=1e-10)


def test_a_model_without_a_start_has_run_for_long():
    """Its P0 is then what its own noise keeps up, by hand Q / (1 - A^2)."""
    rng = np.random.default_rng(4)
    plant = generators.plant(rng, 2, 1, m=1, radius=0.6)
    observer = unfit(rng, plant)
    given = dict(A=[[0.6]], B=None, C=[[1]], dt=1.0, Q=[[3.2]], R=[[0.1]])
    models = (lb.Plant(**given, P0=P0) for P0 in (None, [[5.0]], [[4.0]]))
    runs = [lb.error_covariance(observer, plant.with_input(U), steps=3) for U in models]
    np.testing.assert_allclose(runs[0], runs[1], rtol=1e-12)
    assert generators.relative(runs[0], runs[2]) > 1e-3


@pytest.mark.parametrize("what", ["exact in A and C", "nothing exact"])
@pytest.mark.parametrize("multiplicative", [False, True])
def test_the_steady_state_is_where_the_steps_lead(what, multiplicative):
    rng = np.random.default_rng(5)
    pairs = [(0.1 * rng.normal(size=(3, 3)), 0.1 * rng.normal(size=(2, 3)))]
    plant = generators.plant(rng, 3, 2, m=1, radius=0.6)
    observer = unfit(rng, plant)
    if what == "exact in A and C":
        observer = lb.reduced_order_filter(plant, 1)
        observer = dataclasses.replace(observer, G=observer.G + 0.1, W=observer.W + 0.2)
    plant = dataclasses.replace(plant, multiplicative=pairs if multiplicative else ())
    for U in ([2.0], [[4.0]], model_of(rng, 1, states=1), 0):
        found = lb.error_covariance(observer, plant.with_input(U))
        last = lb.error_covariance(observer, plant.with_input(U), steps=150)[-1]
        np.testing.assert_allclose(found, last, rtol=1e-8)


def motor(dt=0.01, Q=1e-2, R=1e-4):
    """Speed and current of a motor, from its voltage; the speed is measured."""
    A, B = [[-1.0, 20.0], [-2.0, -50.0]], [[0.0], [100.0]]
    return lb.Plant(A, B, [[1, 0]], Q=Q * np.eye(2), R=[[R]]).sampled(dt)


@functools.cache
def of_order_one():
    """A filter of the motor that its input disturbs; P0 does not change it."""
    return lb.fixed_order_filter(motor(), 1)


def square_wave(half, volts, dt):
    """A wave that keeps each sign for `half` samples: its samples, handed on."""
    shift = np.eye(half, k=1)
    shift[-1, 0] = -1
    return lb.Plant(shift, None, np.eye(1, half), dt=dt, x0=np.full(half, volts))


def test_a_square_wave_leaves_what_a_run_shows():
    """Without noise the mean over a period is all there is, and a run has it."""
    half, plant = 25, motor(Q=0.0, R=0.0)
    observer = of_order_one()
    found = lb.error_covariance(
        observer, plant.with_input(square_wave(half, 12.0, plant.dt))
    )
    sign = np.where(np.arange(1001) // half % 2 == 0, 12.0, -12.0)
    run = lb.simulate(plant, observer, 1000, u=sign[:, None])
    e = run.error[1000 - 2 * half : 1000]
    np.testing.assert_allclose(found, e.T @ e / len(e), rtol=1e-9)
    assert (
        found[0, 0] > 1 and not lb.error_covariance(observer, plant.with_input(0)).any()
    )
    with_noise = lb.error_covariance(
        observer, motor().with_input(square_wave(half, 12.0, 0.01))
    )
    alone = lb.error_covariance(observer, motor().with_input(0))
    np.testing.assert_allclose(with_noise, found + alone, rtol=1e-9)


def test_waves_that_differ_in_phase_only_leave_the_same():
    """P0 of the model says how the phases are spread; a mean over time has them all."""
    plant, observer = motor(), of_order_one()
    turn, c, s = 0.3, np.cos(0.3), np.sin(0.3)
    given = dict(A=[[c, -s], [s, c]], B=None, C=[[1, 0]], dt=plant.dt)
    one = lb.Plant(**given, x0=[3, 0], P0=np.zeros((2, 2)))
    spread = lb.Plant(**given, P0=4.5 * np.eye(2))
    X = [lb.error_covariance(observer, plant.with_input(U)) for U in (one, spread)]
    np.testing.assert_allclose(X[0], X[1], rtol=1e-10)
    z = np.exp(1j * turn)  # and by the frequency response, side by side
    x = np.linalg.solve(z * np.eye(2) - plant.A, plant.B)
    y, o = plant.C @ x, observer
    e = o.P @ np.linalg.solve(z - o.F, o.G + o.D @ y) + o.V @ y + o.W - x
    gain = (e @ e.conj().T).real * 3**2 / 2
    alone = lb.error_covariance(observer, plant.with_input(0))
    np.testing.assert_allclose(X[0], alone + gain, rtol=1e-10)


@pytest.mark.parametrize("unit", [1.0, 2.0**40, 2.0**-40])
@pytest.mark.parametrize("R", [0, 1])
def test_a_gain_that_is_off_by_a_ten_thousandth_in_exact_rationals(unit, R):
    """e+ = (1 - g) (a e - w - d u) + g v: level, white and first-order inputs."""
    a, d, g = Fraction(1, 2), Fraction(1, 10000), Fraction(3, 4)
    q, r, level, c = Fraction(1, 4), Fraction(R), Fraction(12), Fraction(7, 8)
    f = (1 - g) * a
    noise = ((1 - g) ** 2 * q + g**2 * r) / (1 - f**2)
    bias = -(1 - g) * d * level / (1 - f)
    white = (d * (1 - g) * level) ** 2 / (1 - f**2)
    # u+ = c u + ..., of variance 144: E[e u] = f c E[e u] - (1 - g) d c 144
    cross = -(1 - g) * d * c * level**2 / (1 - f * c)
    first = (-2 * f * (1 - g) * d * cross + (d * (1 - g) * level) ** 2) / (1 - f**2)
    plant = lb.Plant(
        [[0.5]], [[1.0001 * unit]], [[1]], dt=1.0, Q=[[0.25 * unit**2]],
        R=[[R * unit**2]],
    )  # fmt: skip
    observer = lb.Observer(
        [[float(f)]], [[unit]], [[float(a * g)]], [[float(1 - g)]], [[float(g)]],
        T=[[1]], L=[[1]], dt=1.0,
    )  # fmt: skip
    with pytest.raises(lb.DesignError, match="depends on the known input"):
        lb.error_covariance(observer, plant)
    drift = lb.Plant([[7 / 8]], None, [[1]], dt=1.0, Q=[[144 * 15 / 64]])
    exactly = {"level": bias**2, "white": white, "first": first}
    for name, U in (("level", [12]), ("white", [[144]]), ("first", drift)):
        X = lb.error_covariance(observer, plant.with_input(U))
        wanted = float(noise + exactly[name]) * unit**2
        assert X[0, 0] == pytest.approx(wanted, rel=1e-11)
    mean = mean_error(observer, plant.with_input([12]))
    assert mean == pytest.approx([float(bias) * unit], rel=1e-11)
    assert not mean_error(observer, plant.with_input([[144]])).any()


def test_a_state_that_grows_unseen_by_the_error_does_no_harm():
    """The angle of a shaft integrates its speed; a wrong damping errs in the speed."""

    def shaft(damping):
        A, B = [[0, 1], [0, -damping]], [[0], [5]]
        noise = dict(Q=np.diag([0, 0.1]), R=[[1e-4]], P0=np.zeros((2, 2)))
        return lb.Plant(A, B, [[1, 0]], **noise).sampled(0.1)

    true, observer = shaft(2.6), lb.reduced_order_filter(shaft(2.0), 0)
    for U in ([1.0], [[1.0]]):
        found = lb.error_covariance(observer, true.with_input(U))
        last = lb.error_covariance(observer, true.with_input(U), steps=300)[-1]
        np.testing.assert_allclose(found, last, rtol=1e-7)
    bias = mean_error(observer, true.with_input([1.0]))
    run = lb.simulate(true, observer, 400, u=np.ones((401, 1)))
    np.testing.assert_allclose(bias, run.error[-1], rtol=1e-8)
    still = np.zeros((2, 2))
    off = lb.Plant(true.A * 1.01, true.B, [[0, 1]], Q=still, R=[[1]], dt=0.1)
    with pytest.raises(lb.DesignError, match="no steady state: the observer does not"):
        lb.error_covariance(observer, off.with_input(0))


def integrator(turned, C):
    """An integrator of u, and two states that decay, in coordinates `turned`."""
    A = turned @ np.diag([1, 0.5, 0.3]) @ np.linalg.inv(turned)
    B, noise = turned @ [[1], [1], [0]], dict(Q=np.eye(3), R=[[1]], P0=np.eye(3))
    return lb.Plant(A, B, C @ np.linalg.inv(turned), dt=1.0, **noise)


@pytest.mark.parametrize("U", [0, [1.0], [[1.0]]], ids=["none", "level", "white"])
def test_a_mode_on_the_circle_that_the_error_shows_is_refused(U):
    """Rounding puts it within the circle or without; an integral has no steady state.

    A sensor that is off by a tenth shows the integrator in the error.
    """
    rng, within = np.random.default_rng(8), 0
    C = np.array([[1.0, 0.5, 0.2]])
    for _ in range(20):
        turned = rng.normal(size=(3, 3))
        plant, true = integrator(turned, C), integrator(turned, 1.1 * C)
        within += np.abs(np.linalg.eigvals(true.A)).max() < 1
        observer = lb.kalman_filter(plant)
        with pytest.raises(lb.DesignError, match="has the mode 1 on or outside"):
            lb.error_covariance(observer, true.with_input(U))
    assert within > 3
    other = integrator(turned, C)
    aside = dataclasses.replace(other, B=1.5 * other.B)  # u counts, its integral not
    found = lb.error_covariance(observer, aside.with_input(U))
    last = lb.error_covariance(observer, aside.with_input(U), steps=400)[-1]
    np.testing.assert_allclose(found, last, rtol=1e-7)


def test_an_input_that_does_not_reach_the_error_needs_no_statistics():
    """It drives a state of its own, which the observer neither follows nor wants."""
    A, Q = np.diag([0.9, 0.5, 0.7]), np.diag([1.0, 1.0, 0.0])
    A[0, 1] = 0.3
    plant = lb.Plant(A, [[0], [0], [1]], [[1, 0, 0]], dt=1.0, Q=Q, R=[[1]])
    observer = lb.fixed_order_filter(plant, 1, L=[[1, 0, 0]])
    assert lb.certify(observer, plant).dynamics > 1e-3
    alone = lb.error_covariance(observer, plant)
    np.testing.assert_array_equal(
        alone, lb.error_covariance(observer, plant.with_input([5.0]))
    )
    coupled = dataclasses.replace(plant, B=[[0], [1e-6], [1]])
    with pytest.raises(lb.DesignError, match="depends on the known input"):
        lb.error_covariance(observer, coupled)


REFUSED = {
    "U must be a level .* got 12.0; one input has the level \\[12.0\\]": 12.0,
    "U must be a level .* got shape \\(1, 1, 1\\)": [[[12.0]]],
    "U must be a level .* got {'voltage': 12}": {"voltage": 12},
    "U must be a level .* or 0; got '12'": "12",
    "U\\[0\\] is nan": [np.nan],
    "U must have shape \\(1,\\)": [1.0, 2.0],
    "U must be 1 x 1": np.eye(2),
    "U must be .*semi-definite": [[-1.0]],
    "one for each input": lb.Plant([[0.5]], None, [[1], [1]], dt=0.01),
    "U.sampled\\(dt\\)": lb.Plant([[-1]], None, [[1]]),
    "mode 1.5 outside": lb.Plant([[1.5]], None, [[1]], dt=0.01),
    "mode 1 on .*, and noise": lb.Plant([[1]], None, [[1]], dt=0.01, Q=[[1]]),
    "repeated|outside": lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=0.01, x0=[0, 1]),
}


@pytest.mark.parametrize(("reason", "U"), REFUSED.items(), ids=range(len(REFUSED)))
def test_statistics_that_are_none(reason, U):
    plant = motor()
    observer = of_order_one()
    with pytest.raises(ValueError, match=reason):
        lb.error_covariance(observer, plant.with_input(U))


def test_figures_for_u_equal_to_zero_say_so():
    plant = dataclasses.replace(motor(), P0=np.eye(motor().n))
    disturbed, exact = of_order_one(), lb.kalman_filter(plant)
    assert "u = 0" in lb.optimality(disturbed, plant).note
    assert lb.optimality(disturbed, plant.with_input([1.0])).note == ""
    assert lb.optimality(exact, plant).note == ""
    for observer, said in ((disturbed, True), (exact, False)):
        found = lb.monte_carlo(plant, observer, runs=2, steps=2, seed=8)
        assert ("u = 0" in found.note) == said
