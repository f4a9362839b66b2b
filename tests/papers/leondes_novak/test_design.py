"""The filters against second methods written another way, and run on data."""

import numpy as np
import pytest
from in_parts import in_parts

import luenberger as lb
from luenberger import kernels
from luenberger.papers.leondes_novak.derivation import decorrelation, gain_step
from luenberger.recursion.settings import accurate_outputs, setting


def random_plant(n=4, p=3, m=2, seed=0, S=True, rows=None, **more):
    rng = np.random.default_rng(seed)
    lead = () if rows is None else (rows,)

    def draw(*shape):
        return rng.normal(size=(*lead, *shape))

    A = draw(n, n)
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    root = 0.3 * draw(n + p, n + p)
    W = root @ root.mT
    return lb.Plant(
        A,
        draw(n, m),
        draw(p, n),
        draw(p, m),
        dt=1.0,
        Q=W[..., :n, :n],
        R=W[..., n:, n:],
        S=W[..., :n, n:] if S else None,
        x0=rng.normal(size=n),
        P0=np.eye(n),
        **more,
    )


def record(plant, N, seed=1):
    rng = np.random.default_rng(seed)
    shapes = ((N, plant.p), (N, plant.m), (plant.m,))
    return (rng.normal(size=shape) for shape in shapes)


def textbook_kalman(plant, y, u, u0):
    """Predictor form with the cross covariance, inverses and all."""
    now = plant.at(0)
    x = now.A @ plant.x0 + now.B @ u0
    P = now.A @ plant.P0 @ now.A.T + now.Q
    xs, Ps, Ks = [], [], []
    for k in range(len(y)):
        A, B, C, E, Q, R, S = plant.at(k + 1)
        S = np.zeros((plant.n, plant.p)) if S is None else S
        M = C @ P @ C.T + R
        r = y[k] - C @ x - E @ u[k]
        K = P @ C.T @ np.linalg.inv(M)
        xs.append(x + K @ r), Ps.append(P - K @ M @ K.T), Ks.append(K)
        Kp = (A @ P @ C.T + S) @ np.linalg.inv(M)
        x = A @ x + B @ u[k] + Kp @ r
        P = A @ P @ A.T + Q - Kp @ M @ Kp.T
    return np.array(xs), np.array(Ps), np.array(Ks)


def relative(a, b):
    return np.abs(a - b).max() / np.abs(b).max()


@pytest.mark.parametrize("n, p", [(1, 1), (3, 2), (6, 6), (20, 5)])
@pytest.mark.parametrize("S", [False, True], ids=["S = 0", "S not 0"])
@pytest.mark.parametrize("rows", [None, 52], ids=["constant", "time-varying"])
def test_order_n_is_the_kalman_filter(n, p, S, rows):
    plant, N = random_plant(n, p, seed=n, S=S, rows=rows), 50
    y, u, u0 = record(plant, N)
    x, P, K = textbook_kalman(plant, y, u, u0)
    observer = lb.kalman_filter(plant, steps=N)
    assert relative(observer.V, K) < 1e-12
    covariances = lb.error_covariance(observer, plant, steps=N)
    assert relative(covariances[1:], P) < 1e-12
    assert relative(lb.estimate(observer, lb.Record(y, u, u0=u0)), x) < 1e-12
    filtered = lb.Filter(plant).run(lb.Record(y, u, u0=u0))
    assert relative(filtered.x, x) < 1e-12
    assert relative(filtered.P, P) < 1e-12
    assert relative(filtered.K, K) < 1e-12


@pytest.mark.parametrize("m1", [0, 1, 2, 3, (1,), (0, 2), ("y3",)], ids=str)
@pytest.mark.parametrize("rows", [None, 30], ids=["constant", "time-varying"])
def test_every_order_in_three_ways(m1, rows):
    """As an observer, in one pass, and as the error recursion of that observer."""
    plant, N = random_plant(rows=rows), 25
    y, u, u0 = record(plant, N)
    observer = lb.reduced_order_filter(plant, m1, steps=N)
    accurate = list(accurate_outputs(plant, m1))
    assert observer.order == plant.n - len(accurate)
    assert lb.certify(observer, plant).worst < 1e-13
    filtered = lb.Filter(plant, m1).run(lb.Record(y, u, u0=u0))
    estimates = lb.estimate(observer, lb.Record(y, u, u0=u0))
    assert relative(estimates, filtered.x) < 1e-12
    covariances = lb.error_covariance(observer, plant, steps=N)
    assert relative(covariances[1:], filtered.P) < 1e-12
    assert np.allclose(covariances[0], plant.P0)
    for k in range(N):  # the accurate outputs are treated as exact
        now = plant.at(k + 1)
        shown = now.C @ filtered.x[k] + now.E @ u[k]
        np.testing.assert_allclose(shown[accurate], y[k, accurate], atol=1e-11)


def test_gain_is_the_least_of_its_kind():
    """Moving the free part of the gain by any amount raises the trace."""
    plant = random_plant()
    now = setting(plant, [0])
    step = kernels.compiled(gain_step)
    given = dict(A=now.As, Q=now.Qs, C=now.C, R=now.R, Gamma=now.Gamma, Sigma=plant.P0)
    new = step(**given)
    least = np.trace(new["Sigma_next"])
    rng = np.random.default_rng(2)
    for _ in range(50):
        K = new["K"] + now.Phat @ rng.normal(size=(3, 3))
        Y = np.eye(4) - K @ now.C
        moved = Y @ new["Omega"] @ Y.T + K @ now.R @ K.T
        assert np.trace(moved) > least


def test_default_coordinates_are_the_best_and_the_papers_are_reachable():
    plant = random_plant(seed=3)
    rng = np.random.default_rng(4)
    best = reached(plant, None)
    M = np.vstack([plant.C[:1], np.eye(4)[[0, 1, 2]]])
    assert reached(plant, M.T @ M) > best
    assert reached(plant, "canonical") > best
    for _ in range(20):
        M = np.vstack([plant.C[:1], rng.normal(size=(3, 4))])
        assert reached(plant, M.T @ M) >= best


def reached(plant, weight):
    """Error trace after one step from P0, in the user's coordinates."""
    observer = lb.reduced_order_filter(plant, 1, steps=1, weight=weight)
    return np.trace(lb.error_covariance(observer, plant, steps=1)[1])


def test_canonical_choice_is_the_papers_recursion():
    """(20)-(33) run literally in q = M x, with y2 seeing only q2."""
    plant = random_plant(S=False, seed=5)
    M = np.vstack([plant.C, np.linalg.svd(plant.C)[2][3:]])
    inverse = np.linalg.inv(M)
    A, Q = M @ plant.A @ inverse, M @ plant.Q @ M.T
    m1, (n, p) = 1, (plant.n, plant.p)
    H = np.eye(p, n)
    Omega = A @ (M @ plant.P0 @ M.T) @ A.T + Q
    innovation = H @ Omega @ H.T + plant.R
    lower = (Omega @ H.T @ np.linalg.inv(innovation))[m1:]  # (33)
    V = np.vstack([np.eye(m1, p), lower])  # (24)
    observer = lb.reduced_order_filter(plant, m1, steps=1, weight=M.T @ M)
    np.testing.assert_allclose(observer.V[0], inverse @ V, rtol=1e-10, atol=1e-12)


def test_prior_and_posterior_starts_agree():
    """A posterior of x[0] and the prior of x[1] that follows from it."""
    after = random_plant(seed=6)
    before = random_plant(seed=6, at_first=True)
    u0 = np.array([0.3, -1.0])
    object.__setattr__(before, "x0", after.A @ after.x0 + after.B @ u0)
    object.__setattr__(before, "P0", after.A @ after.P0 @ after.A.T + after.Q)
    y, u, _ = record(after, 12)
    for m1 in range(4):
        one = lb.reduced_order_filter(after, m1, steps=12)
        two = lb.reduced_order_filter(before, m1, steps=12)
        np.testing.assert_allclose(one.V, two.V, rtol=1e-11, atol=1e-13)
        np.testing.assert_allclose(
            lb.estimate(one, lb.Record(y, u, u0=u0)),
            lb.estimate(two, lb.Record(y, u)),
            rtol=1e-10,
        )
        np.testing.assert_allclose(
            lb.Filter(before, m1).run(lb.Record(y, u)).x,
            lb.estimate(two, lb.Record(y, u)),
            rtol=1e-10,
        )
        covariances = lb.error_covariance(two, before, steps=12)
        np.testing.assert_allclose(covariances[0], before.P0)
        np.testing.assert_allclose(
            covariances[1:], lb.error_covariance(one, after, steps=12)[1:], rtol=1e-9
        )


def test_another_mean_of_the_initial_state():
    plant = random_plant()
    y, u, u0 = record(plant, 10)
    observer = lb.reduced_order_filter(plant, 2, steps=10)
    other = np.array([1.0, -2.0, 0.5, 3.0])
    moved = random_plant()
    object.__setattr__(moved, "x0", other)
    np.testing.assert_allclose(
        lb.estimate(observer, lb.Record(y, u, u0=u0), x0=other),
        lb.Filter(moved, 2).run(lb.Record(y, u, u0=u0)).x,
        rtol=1e-10,
    )


def test_m1_equal_p_does_not_use_the_cross_covariance():
    """(9) has one solution then, so decorrelation leaves F and D alone."""
    with_S, without = random_plant(S=True), random_plant(S=False)
    one = lb.reduced_order_filter(with_S, 3, steps=2)
    gain = setting(with_S, [0, 1, 2])
    T = one.T[0]
    np.testing.assert_allclose(one.F[0], one.T[1] @ without.A @ gain.Phat, atol=1e-12)
    np.testing.assert_allclose(one.D[0], one.T[1] @ without.A @ one.V[0], atol=1e-12)
    assert T.shape == (1, 4)


def test_all_states_measured_gives_order_zero():
    plant = random_plant(n=3, p=3)
    observer = lb.reduced_order_filter(plant, 3)
    assert observer.order == 0 and lb.certify(observer, plant).stable
    y, u, _ = record(plant, 5)
    direct = np.linalg.solve(plant.C, (y - u @ plant.E.T).T).T
    np.testing.assert_allclose(
        lb.estimate(observer, lb.Record(y, u)), direct, rtol=1e-9
    )
    trace = np.trace(lb.error_covariance(observer, plant))
    inverse = np.linalg.inv(plant.C)
    np.testing.assert_allclose(trace, np.trace(inverse @ plant.R @ inverse.T))


def test_chunks_give_what_one_pass_gives():
    plant = random_plant()
    y, u, u0 = record(plant, 20)
    whole = lb.Filter(plant, 1).run(lb.Record(y, u, u0=u0))
    cuts = [slice(0, 3), slice(3, 4), slice(4, 20)]
    records = [lb.Record(y[c], u[c], u0=u0 if c.start == 0 else None) for c in cuts]
    parts = in_parts(lb.Filter(plant, 1), records)
    np.testing.assert_array_equal(np.vstack([part.x for part in parts]), whole.x)


def test_error_covariance_of_a_wrong_plant_counts_the_state():
    """Joint moments against a long simulation of E[e e'] written out here."""
    plant = random_plant(m=0)
    believed = lb.Plant(0.7 * plant.A, None, plant.C, dt=1.0, Q=plant.Q, R=plant.R)
    observer = lb.reduced_order_filter(believed, 1)
    F, _, D, P, V, _ = observer.at(0)
    big = np.block([[plant.A, np.zeros((4, 3))], [D @ plant.C, F]])
    drive = np.block([[np.eye(4), np.zeros((4, 3))], [np.zeros((3, 4)), D]])
    noise = np.block([[plant.Q, plant.S], [plant.S.T, plant.R]])
    X = np.zeros((7, 7))
    for _ in range(2000):
        X = big @ X @ big.T + drive @ noise @ drive.T
    out = np.hstack([V @ plant.C - np.eye(4), P])
    wanted = out @ X @ out.T + V @ plant.R @ V.T
    got = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(got, wanted, rtol=1e-9)
    over = lb.error_covariance(observer, plant, steps=2000)[-1]
    np.testing.assert_allclose(over, wanted, rtol=1e-9)


def test_kernel_source_holds_no_inverse_and_keeps_symmetry():
    source = kernels.compiled(gain_step).source
    assert "inv(" not in source and "solve_right" in source
    for name in ("Omega", "M", "Sigma_next"):
        assert f"{name} = symmetrise(" in source


def test_kernels_take_names_only_and_the_right_ones():
    with pytest.raises(TypeError, match="unexpected keyword|missing"):
        kernels.compiled(decorrelation)(A=np.eye(2))
    with pytest.raises(TypeError, match="positional"):
        kernels.compiled(decorrelation)(np.eye(2))


def test_multiply_adds_by_hand():
    F, G, D = [[0.5, 0], [0, 0.1]], [[1], [0]], [[2], [3]]
    P, V = [[0, 0], [1, 0], [0, 1]], [[1], [4], [0]]
    observer = lb.Observer(F, G, D, P, V, T=np.ones((2, 3)), L=np.eye(3))
    # z+: 2 + 1 + 2; w^: rows "y", "z1 + 4 y", "z2": the copies are free
    assert lb.export.multiply_adds(observer) == 5 + 2


@pytest.mark.parametrize("field", ["F", "G", "D", "P", "V", "T", "W"])
@pytest.mark.parametrize("steps", [None, 3], ids=["constant", "over steps"])
def test_certificate_notices_damage(field, steps):
    import dataclasses

    plant = random_plant()
    sound = lb.reduced_order_filter(plant, 1, steps=steps)
    damaged = getattr(sound, field).copy()
    damaged[(0,) * damaged.ndim] += 1e-3
    broken = dataclasses.replace(sound, **{field: damaged})
    assert lb.certify(broken, plant).worst > 1e-6
    with pytest.raises(lb.CertificateError, match="residual is"):
        lb.certify(broken, plant).require()
