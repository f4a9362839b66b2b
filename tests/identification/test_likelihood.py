"""The likelihood of a record, against statsmodels, exact rationals and batches."""

import dataclasses

import generators
import numpy as np
import pytest
from exact_filter import rational, zeros
from exact_likelihood import (
    KINDS,
    SCORED,
    beside_noises,
    density,
    direction,
    exact_moments,
    inverse,
    nile,
    rational_plant,
)
from exact_smoother import product
from fractional_passes import factored

import luenberger as lb
from luenberger.filtering import likelihood, passes
from luenberger.filtering.passes import Maps, State, Tape, forward

nan = float("nan")


def test_nile_with_a_wide_start():
    """The local level with a prior variance of 10^7, the first year included."""
    plant = lb.Plant(
        [[1]], None, [[1]], dt=1.0, Q=[[1469.1]], R=[[15099.0]], P0=[[1e7]],
        at_first=True,
    )  # fmt: skip
    run = lb.Filter(plant)
    found = run.log_likelihood(nile())
    assert round(found, 2) == -641.59
    first = run.log_likelihood(nile()[:1])
    assert round(found - first, 2) == -632.54  # the years after the first, given it


# -- against statsmodels ---------------------------------------------------------------


def statsmodels(plant, y):
    model, (mean, P) = beside_noises(plant, y)
    mean[: plant.n] = plant.A @ plant.x0
    P[: plant.n, : plant.n] = plant.A @ plant.P0 @ plant.A.T + plant.Q
    model.ssm.initialize_known(mean, P)
    return model.ssm.loglike()


def case(seed):
    """A random plant and its record, with gaps in two of three cases."""
    rng = np.random.default_rng(seed)
    n, p = rng.integers(1, 6), rng.integers(1, 4)
    plant = generators.plant(rng, n, p, m=0, cross=seed % 2, radius=rng.uniform(0.2, 1))
    y = generators.record(rng, plant, 40)[0]
    if seed % 3:
        y[rng.random(y.shape) < 0.25] = nan
    return plant, y


@pytest.mark.parametrize("seed", range(200))
def test_statsmodels_has_the_same_likelihood(seed):
    plant, y = case(seed)
    wanted = statsmodels(plant, y)
    assert lb.Filter(plant).log_likelihood(y) == pytest.approx(wanted, rel=1e-10)


# -- exactly ---------------------------------------------------------------------------


def exact(plant, y, u, u0, move=None):
    """The density of a whole record, with rationals, and its slope along `move`."""
    return density(*exact_moments(plant, y, u, u0, move))


@pytest.mark.parametrize("kind", KINDS)
def test_the_likelihood_is_the_density_of_the_record(kind):
    plant, *record = rational_plant(kind)
    y, u, u0 = record
    wanted, _ = exact(plant, *record)
    found = lb.Filter(plant).log_likelihood(lb.Record(y, u, u0=u0))
    assert found == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize(("kind", "name"), [x for x in SCORED if x[1] in "QRS"])
def test_the_score_is_that_of_the_density(kind, name):
    plant, *record = rational_plant(kind)
    y, u, u0 = record
    D = direction(plant, name)
    _, wanted = exact(plant, *record, move={name: D})
    slope = getattr(lb.Filter(plant).score(lb.Record(y, u, u0=u0)), name)
    size = np.abs(slope * D).sum()
    assert np.sum(slope * D) == pytest.approx(wanted, abs=1e-11 * size)


@pytest.mark.parametrize("kind", ["perfect", "one perfect"])
def test_the_score_in_the_noise_of_a_perfect_output(kind):
    """It is that from the one side where it is not perfect."""
    plant, *record = rational_plant(kind)
    D = np.zeros((plant.p, plant.p))
    D[0, 0] = 1
    _, wanted = exact(plant, *record, move={"R": D})
    y, u, u0 = record
    found = lb.Filter(plant).score(lb.Record(y, u, u0=u0))
    assert found.R[0, 0] == pytest.approx(wanted, rel=1e-11)


def test_a_varying_plant_is_scored_with_the_matrices_of_each_instant():
    rng = np.random.default_rng(5)
    plant = generators.varying(rng, 2, 1, 3, m=1)
    plant = dataclasses.replace(
        plant, **{k: np.round(getattr(plant, k), 2) for k in ("A", "B", "C", "E")}
    )
    y, u, u0 = generators.record(rng, plant, 3)
    found = lb.Filter(plant).score(lb.Record(y, u, u0=u0))
    for name in "QRS":
        shape = getattr(plant, name).shape
        D = rng.integers(-2, 3, shape[1:]).astype(float)
        D = D + D.T if name in "QR" else D
        _, wanted = exact(plant, y, u, u0, {name: np.broadcast_to(D, shape)})
        slope = getattr(found, name)
        size = np.abs(slope * D).sum()
        assert np.sum(slope * D) == pytest.approx(wanted, abs=1e-9 * size)


def test_outputs_that_are_correlated_are_scored_together():
    """Readings are combined by triangles, another for each pattern of gaps."""
    rng = np.random.default_rng(3)
    for seed in range(6):
        plant = generators.plant(rng, 3, 3, m=0, cross=seed % 2)
        y = generators.record(rng, plant, 30)[0]
        y[rng.random(y.shape) < 0.3] = nan
        found = lb.Filter(plant).score(y)
        for name in "QR":
            X = getattr(plant, name)
            D = rng.normal(size=X.shape)
            D = (D + D.T) * np.sqrt(np.outer(X.diagonal(), X.diagonal())) * 1e-5
            up, down = (
                lb.Filter(
                    dataclasses.replace(plant, **{name: X + s * D})
                ).log_likelihood(y)
                for s in (1, -1)
            )
            wanted = (up - down) / 2
            size = np.abs(getattr(found, name) * D).sum()
            assert (getattr(found, name) * D).sum() == pytest.approx(
                wanted, abs=1e-5 * size
            )


@pytest.mark.parametrize("seed", range(12))
def test_the_text_of_the_score_is_the_page_on_fractions(seed):
    """One reading at a time, some of them missing, equals whole rows to the last digit.

    The rows are those of identification/derivation/score.py.
    """
    rng = np.random.default_rng(seed)
    n, p, rows = (int(k) for k in rng.integers(1, 4, 3))
    whole = lambda *size: rational(rng.integers(-3, 4, size))  # noqa: E731
    A, C, y, H = whole(n, n), whole(p, n), whole(rows, p), whole(n + p, n + p)
    joint = product(H, H.T) if seed % 2 else np.diag(np.diag(product(H, H.T)))
    joint = joint + rational(np.eye(n + p))
    Q, S, R = joint[:n, :n], joint[:n, n:], joint[n:, n:]
    seen = rng.random((rows, p)) < 0.8
    if seed % 2:  # every noise beside the state, as where S is not zero
        V, d = factored(joint)
        B, at_row = np.hstack([A, V.T[:n]]), np.hstack([C, V.T[n:]])
        G, r, N = zeros(n, 0), zeros(p), 2 * n + p
    else:
        half = factored(Q)
        B, at_row, d, N = A, C, zeros(0), n
        G, r = half[0].T, np.diag(R)  # of the text's unit noises
    own = zeros(n, n)
    maps = Maps(B[None], B[None], G[None], zeros(1, n, 0), zeros(1, n, 0),
                at_row[None], r[None], d[None])  # fmt: skip
    state = State(zeros(N), rational(np.eye(N)), zeros(N), zeros(p, N), zeros(p))
    state.D[:n], state.D[n:] = rational(np.ones(n)), d
    if not seed % 2:
        Q = product(G, G.T)
    sizes = [(0, n), (0, N), (0, N, N), (0, N), (rows, p, N), (rows, p), (rows, p)]
    tape = Tape(*(zeros(*size) for size in sizes))
    values, at = np.where(seen, y, float("nan")), np.zeros(rows + 1, dtype=int)
    room = zeros(rows, n), zeros(rows, n)
    forward.on(TINY=0, CLASH=0)(values, zeros(rows, n), at, maps, state, *room, tape)
    found = zeros(n, n), zeros(1, p, p), zeros(1, n, p)
    passes.score.on()(at, maps, tape, zeros(n), own, *found)

    x, Omega, kept = zeros(n, 1), product(A, A.T) + Q, []
    for k in range(rows):
        here = np.flatnonzero(seen[k])
        Ck, Rk, Sk = C[here], R[np.ix_(here, here)], S[:, here]
        if not seed % 2:
            Sk = zeros(n, len(here))
        W = inverse(product(Ck, Omega, Ck.T) + Rk)[0] if len(here) else zeros(0, 0)
        G_k = product(product(A, Omega, Ck.T) + Sk, W)
        nu = y[k, here][:, None] - product(Ck, x)
        kept.append((here, Ck, G_k, W, product(W, nu)))
        M = product(Ck, Omega, Ck.T) + Rk
        Omega = product(A, Omega, A.T) + Q - product(G_k, M, G_k.T)
        x = product(A, x) + product(G_k, nu)
    eta, Pi = zeros(n, 1), zeros(n, n)
    wanted = zeros(n, n), zeros(p, p), zeros(n, p)
    for here, C_k, G_k, W, e in reversed(kept):
        Z, k = np.vstack([A, C_k]), np.vstack([eta, e - product(G_k.T, eta)])
        told = np.hstack([np.eye(n, dtype=int), -G_k])
        Pi_J = product(told.T, Pi, told)
        Pi_J[n:, n:] += W
        gJ = product(k, k.T) - Pi_J  # twice
        wanted[0][:] += gJ[:n, :n]
        wanted[1][np.ix_(here, here)] += gJ[n:, n:]
        wanted[2][:, here] += gJ[:n, n:]
        eta, Pi = product(Z.T, k), product(Z.T, Pi_J, Z)
    wanted[0][:] += product(eta, eta.T) - Pi  # of the noise before the first row
    for one, other in zip(found, wanted):
        assert (one.reshape(other.shape) == other).all()


# -- records ---------------------------------------------------------------------------


def test_records_of_one_plant_multiply():
    plant, y, u, u0 = rational_plant("two")
    run = lb.Filter(plant)
    one, other = lb.Record(y, u), lb.Record(y[:2], u[:2])
    both = lb.Record([y, y[:2]], [u, u[:2]])
    each = [run.log_likelihood(k) for k in (one, other)]
    assert run.log_likelihood(both) == pytest.approx(sum(each), rel=1e-14)
    for name in "QRS":
        wanted = sum(getattr(run.score(k), name) for k in (one, other))
        np.testing.assert_allclose(getattr(run.score(both), name), wanted, rtol=1e-12)
    array = lb.Record(np.array([y, y]), u)
    assert run.log_likelihood(array) == pytest.approx(2 * each[0], rel=1e-14)
    assert u0 is not None


def test_what_is_not_measured_says_nothing():
    plant, y, u, _ = rational_plant("two")
    run, record = lb.Filter(plant), lb.Record(np.full_like(y, nan), u)
    assert run.log_likelihood(record) == 0
    assert not any(getattr(run.score(record), name).any() for name in "QRS")
    assert run.log_likelihood(lb.Record(y[:0], u[:0])) == 0


def test_names_of_columns():
    import pandas as pd

    plant, y, u, _ = rational_plant("two")
    table = pd.DataFrame({"u1": u[:, 0], "y2": y[:, 1], "y1": y[:, 0]}, index=range(4))
    run = lb.Filter(plant)
    assert run.log_likelihood(table) == run.log_likelihood(lb.Record(y, u))
    assert run.log_likelihood([table]) == run.log_likelihood(lb.Record(y, u))
    left = run.innovations(table)
    assert list(left.columns) == ["y1", "y2"] and list(left.index) == [0, 1, 2, 3]


def test_innovations_are_those_of_a_triangle():
    """Normalised by the triangle of Cholesky of their covariance."""
    plant, y, u, _ = rational_plant("two")
    plant = dataclasses.replace(plant, S=None)
    found = lb.Filter(plant).innovations(lb.Record(y[:1], u[:1]))[0]
    x, P = plant.A @ plant.x0, plant.A @ plant.P0 @ plant.A.T + plant.Q
    M = plant.C @ P @ plant.C.T + plant.R
    nu = y[0] - plant.C @ x - plant.E @ u[0]
    wanted = np.linalg.solve(np.linalg.cholesky(M), nu)
    np.testing.assert_allclose(found, wanted, rtol=1e-12)


def test_a_continuous_plant_is_sampled_at_the_instants_of_a_record():
    plant = lb.Plant([[-1.0]], None, [[1]], Q=[[2]], R=[[1]], P0=[[1]])
    time, y = np.array([0.0, 0.5, 1.5, 1.75]), np.array([[1.0], [2], [0], [1]])
    found = lb.Filter(plant).log_likelihood(lb.Record(y, time=time))
    x, P, wanted = 0.0, 1.0, 0.0
    for dt, (one,) in zip([0.5, 0.5, 1.0, 0.25], y):
        a = np.exp(-dt)
        x, P = a * x, a * a * P + 1 - a * a  # Q of white noise of intensity 2
        wanted -= (np.log(2 * np.pi * (P + 1)) + (one - x) ** 2 / (P + 1)) / 2
        x, P = x + P / (P + 1) * (one - x), P / (P + 1)
    assert found == pytest.approx(wanted, rel=1e-12)


def test_accurate_outputs_are_those_without_noise():
    plant, y, u, _ = rational_plant("one perfect")
    record = lb.Record(y, u)
    one = lb.Filter(plant, 1).log_likelihood(record)
    assert one == lb.Filter(plant).log_likelihood(record)
    with pytest.raises(lb.DesignError, match="'y2' is noisy.*not white"):
        lb.Filter(plant, 2).log_likelihood(record)


def test_an_impossible_record_is_refused():
    plant, y, u, _ = rational_plant("determined")
    y = y.copy()
    y[2, 1] += 1
    with pytest.raises(lb.DesignError, match="instant 3"):
        lb.Filter(plant).log_likelihood(lb.Record(y, u))


@pytest.mark.parametrize("power", [-40, 40])
@pytest.mark.parametrize("kind", ["two", "one perfect"])
def test_units_of_outputs_only_add_a_constant(kind, power):
    plant, y, u, u0 = rational_plant(kind)
    wanted = lb.Filter(plant).log_likelihood(lb.Record(y, u, u0=u0))
    unit = np.array([2.0**power, 1])
    other = dataclasses.replace(
        plant, C=plant.C * unit[:, None], E=plant.E * unit[:, None],
        R=plant.R * unit * unit[:, None],
        S=None if plant.S is None else plant.S * unit,
    )  # fmt: skip
    found = lb.Filter(other).log_likelihood(lb.Record(y * unit, u, u0=u0))
    assert found + 4 * power * np.log(2) == pytest.approx(wanted, rel=1e-12)


@pytest.mark.parametrize("n", [1, 3, 8])
def test_a_filter_that_settles_has_the_score_of_the_whole_recursion(n):
    """In rows between gaps, and of correlated outputs."""
    rng = np.random.default_rng(n)
    plant = generators.plant(rng, n, min(n, 2), m=1, cross=0, radius=0.9)
    y, u, u0 = generators.record(rng, plant, 900)
    y[[3, 400, 401, 700], 0] = nan
    run, rows = lb.Filter(plant), lb.Record(y, u, u0=u0).on(plant)
    whole, settled = (run.passed(rows, keep) for keep in ("readings", "settled"))
    assert sum(part.stop - part.start for part in settled[0].settled) > 300
    values = [likelihood.value(one, plant) for one in (whole, settled)]
    assert values[1] == pytest.approx(values[0], rel=1e-12)
    one, other = (likelihood.score(k, plant, joint=False) for k in (whole, settled))
    for name in "QR":
        X, Y = getattr(one, name), getattr(other, name)
        np.testing.assert_allclose(Y, X, atol=1e-9 * np.abs(X).max())
