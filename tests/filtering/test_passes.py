"""The recursion against rational arithmetic: in floats, and its text in Fractions."""

import pickle
import subprocess
import sys
from dataclasses import replace
from fractions import Fraction

import exact_filter
import fractional_passes
import numpy as np
import pytest
import sympy as sp
from exact_filter import Model, rational, zeros

import luenberger as lb
from luenberger.errors import DesignError
from luenberger.filtering import pack, passes, quick
from luenberger.filtering.maps import Settings
from luenberger.papers.leondes_novak.derivation import best_coordinates
from matrixproof.models import evaluate

TOL = 1e-9


def in_fractions(problem):
    """x and P of a problem by the text of `passes`, on Fractions."""
    _, _, tape, clash = fractional_passes.passed(problem)
    n = len(problem.model.A)
    P = [((V.T * D) @ V)[:n, :n] for V, D in zip(tape.V, tape.D)]
    return tape.z[:, :n], P, clash


@pytest.mark.parametrize("first", range(0, 60, 10))
def test_the_text_is_exact_on_fractions(first):
    """To the last digit, and what contradicts is found at a difference of any size."""
    for seed in range(first, first + 10):
        problem = exact_filter.problem(seed)
        problem = replace(problem, accurate=())
        x, P, clash = in_fractions(problem)
        exact = problem.exact()
        assert all((a == b).all() for a, b in zip(x, exact.x))
        assert all((a == b).all() for a, b in zip(P, exact.P))
        assert clash == -1
        assert all(type(v) in (int, Fraction) for v in x.flat)
        damaged = problem.damaged(np.random.default_rng(seed))
        assert (in_fractions(damaged)[2] >= 0) == (max(damaged.exact().gaps) > 0)


@pytest.mark.parametrize("first", range(0, 300, 50))
def test_filters_equal_exact_ones(first):
    """Singular Q, R, P0, S, exact outputs, accurate ones, gaps, units far apart."""
    for seed in range(first, first + 50):
        problem = exact_filter.problem(seed)
        run = lb.Filter(problem.plant, problem.accurate).run(problem.record)
        exact = problem.exact()
        x, P = problem.errors(run.x, run.P, exact)
        slack = problem.sensitivity(exact) if max(x, P) > TOL else 0
        assert P <= TOL + slack and x <= TOL + slack + 1e-4 * slack**0.5, seed
        variances = np.diagonal(run.P, axis1=1, axis2=2)
        assert np.allclose(run.std**2, variances, rtol=1e-9, atol=1e-12 * run.P.max())
        damaged = problem.damaged(np.random.default_rng(seed))
        if max(damaged.exact().gaps) > 0:
            with pytest.raises(DesignError, match="at instant [0-9]+ the reading of"):
                lb.Filter(problem.plant, problem.accurate).run(damaged.record)


def a_plant(rng, shared):
    n, p, m = 3, 2, 1
    A, C = rng.normal(size=(n, n)), rng.normal(size=(p, n))
    H = rng.normal(size=(n + p, n + p))
    J = H @ H.T
    S = 0.5 * J[:n, n:] if shared else None
    return lb.Plant(
        0.9 * A / np.abs(np.linalg.eigvals(A)).max(), rng.normal(size=(n, m)), C,
        rng.normal(size=(p, m)), dt=1.0, Q=J[:n, :n], R=J[n:, n:], S=S, P0=np.eye(n),
        x0=[1, 2, 3],
    )  # fmt: skip


@pytest.mark.parametrize("m1", [0, 1, 2])
@pytest.mark.parametrize("shared", [False, True])
def test_parts_of_a_record_are_the_record_bit_for_bit(m1, shared):
    rng = np.random.default_rng(m1)
    plant = a_plant(rng, shared)
    y, u = rng.normal(size=(50, 2)), rng.normal(size=(50, 1))
    y[rng.random(y.shape) < 0.2] = np.nan
    record, run = lb.Record(y, u, u0=[0.3]), lb.Filter(plant, m1)
    whole, end, parts = run.run(record), None, []
    for part in record.split(7):
        parts.append(run.run(part, start=end))
        end = parts[-1].end
    for name in ("x", "std", "P", "K"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert (joined == getattr(whole, name)).all()


@pytest.mark.parametrize("m1", [0, 1, 2])
@pytest.mark.parametrize("shared", [False, True])
def test_gains_and_covariances_are_those_of_the_recursion(m1, shared):
    """What K makes of x, and Joseph's form of P, for gains read off the tape."""
    rng = np.random.default_rng(m1)
    plant = a_plant(rng, shared)
    y = rng.normal(size=(20, 2))
    run = lb.Filter(plant, m1).run(y)
    S = np.zeros((3, 2)) if plant.S is None else plant.S
    J = np.linalg.solve(plant.R, S.T).T
    As, Qs = plant.A - J @ plant.C, plant.Q - J @ S.T
    x, P, A = plant.x0, plant.P0, plant.A
    ahead, Q = A @ x, plant.Q
    for k in range(20):
        Omega = (A if k == 0 else As) @ P @ (A if k == 0 else As).T
        Omega += Q if k == 0 else Qs
        K, Y = run.K[k], np.eye(3) - run.K[k] @ plant.C
        x = ahead + K @ (y[k] - plant.C @ ahead)
        P = Y @ Omega @ Y.T + K @ plant.R @ K.T
        assert np.allclose(run.x[k], x, atol=1e-12)
        assert np.allclose(run.P[k], P, atol=1e-12)
        assert np.allclose(plant.C[:m1] @ x, y[k, :m1])
        ahead = A @ x + J @ (y[k] - plant.C @ x)


def matrices(rng, n, kind):
    """A and C of n states; those of a kind have zeros and ones, or change."""
    A, C = rng.normal(size=(n, n)), rng.normal(size=(min(n, 2), n))
    if kind == "zeros":
        A, C = np.triu(A, 1) + np.eye(n), np.eye(n)[: len(C)]
    A = np.stack([A, 0.9 * A] * 20) if kind == "varying" else A
    return A, C


@pytest.mark.parametrize("kind", ["noisy", "gaps", "exact", "zeros", "varying"])
@pytest.mark.parametrize("n", [1, 2, 3])
def test_scalars_find_the_bits_of_the_loops(monkeypatch, n, kind):
    """Compiled or not, what is kept on the tape too, with zeros and ones in A and C."""
    rng = np.random.default_rng(n)
    A, C = matrices(rng, n, kind)
    R = np.eye(len(C)) * (kind != "exact") + 0.0
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(n), R=R, P0=np.eye(n))
    y = rng.normal(size=(30, len(C)))
    if kind == "gaps":
        y[rng.random(y.shape) < 0.3] = np.nan

    def found(many, early):
        monkeypatch.setattr(pack, "MANY", many)
        monkeypatch.setattr(pack, "early", lambda work: early)
        run = lb.Filter(plant).run(y)
        return run.x, run.std, run.P, run.K

    loops = found(10**9, False)
    for others in (found(1, False), found(1, True)):
        assert all(map(np.array_equal, loops, others))


def test_the_first_record_does_not_wait_for_a_compiler():
    """It is loaded for more rows, which have the same bits."""
    program = """
import sys, numpy as np, luenberger as lb
plant = lb.Plant([[0.9, 1], [0, 0.5]], [[0], [1]], [[1, 0]], dt=1.0, Q=np.eye(2),
                 R=[[1]], P0=np.eye(2))
y = np.random.default_rng(0).normal(size=(1500, 1))
y[20:22] = np.nan
first = lb.Filter(plant).run(lb.Record(y, y > 0))
print("numba" in sys.modules, len(first.settled_at))
while "numba" not in sys.modules:
    last = lb.Filter(plant).run(lb.Record(y, y > 0))
print(np.array_equal(first.x, last.x), np.array_equal(first.std, last.std))
"""
    found = subprocess.run([sys.executable, "-c", program], capture_output=True)
    assert found.stdout.decode().split() == ["False", "1", "True", "True"]


@pytest.mark.parametrize("P0", [1, 1e10])
@pytest.mark.parametrize("kind", ["gaps", "zeros", "varying"])
@pytest.mark.parametrize("n", [1, 3])
def test_scalars_find_the_way_back(monkeypatch, n, kind, P0):
    """Sums in another order; the first rows of a vague prior lose digits."""
    rng = np.random.default_rng(n)
    A, C = matrices(rng, n, kind)
    more = dict(R=np.eye(len(C)), P0=P0 * np.eye(n))
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.eye(n), **more)
    y = rng.normal(size=(30, len(C)))
    if kind == "gaps":
        y[rng.random(y.shape) < 0.3] = np.nan
    loops = lb.Filter(plant).smooth(y)
    monkeypatch.setattr(pack, "MANY", 1)
    scalars = lb.Filter(plant).smooth(y)
    np.testing.assert_allclose(scalars.std, loops.std, rtol=1e-9)
    np.testing.assert_allclose(scalars.x, loops.x, rtol=0, atol=1e-9)
    np.testing.assert_allclose(scalars.w, loops.w, rtol=0, atol=1e-9)


def test_each_of_many_outputs_may_be_missing():
    """More than a number has bits; their noises differ, and are correlated."""
    p = 70
    R = np.diag(np.arange(1.0, p + 1)) + 0.5
    plant = lb.Plant([[1]], None, np.ones((p, 1)), dt=1.0, Q=[[0]], R=R, P0=[[1]])
    y = np.random.default_rng(0).normal(size=(3, p))
    for k in range(2):
        y[k, p - 1 - k] = np.nan
    found, information, told = lb.Filter(plant).run(y), 1.0, 0.0
    for row, x, P in zip(y, found.x, found.P):
        some = ~np.isnan(row)
        weights = np.linalg.solve(R[np.ix_(some, some)], np.ones(some.sum()))
        information, told = information + weights.sum(), told + weights @ row[some]
        assert np.allclose([x[0], P[0, 0]], [told / information, 1 / information])


def by_the_page(A, Q, C, R, Sigma):
    """One step of the recursion that `best_coordinates` derives, in Fractions."""
    step = best_coordinates.gain_step
    given = dict(A=A, Q=Q, C=C, R=R, Sigma=Sigma, Gamma=zeros(len(A), len(C)))
    values = {}
    for symbol in step.given:
        X = given[symbol.name.removesuffix("s")]
        values[symbol] = sp.Matrix(*X.shape, [sp.Rational(str(v)) for v in X.flat])
    for stage in step.stages:
        values[stage.target] = evaluate(stage.expression, values)
    last = values[step.stages[-1].target].tolist()
    return np.array([[Fraction(int(v.p), int(v.q)) for v in row] for row in last])


@pytest.mark.parametrize("seed", range(4))
def test_the_factors_are_the_covariance_that_notebooks_derive(seed):
    """U D U' of the text is Sigma of `best_coordinates`, to the last digit."""
    rng = np.random.default_rng(seed)
    n, p = 2 + seed % 2, 1 + seed % 3
    draw = lambda *shape: rational(rng.integers(-3, 4, shape).astype(float))  # noqa: E731
    G, H, W = draw(n, n), draw(n, n), draw(p, p)
    A, C, Q, P0 = draw(n, n), draw(p, n), G @ G.T, H @ H.T
    R = W @ W.T + rational(np.eye(p))
    none = exact_filter.zeros
    m = Model(A, none(n, 0), C, none(p, 0), Q, R, none(n, p), P0, none(n))
    y = draw(3, p)
    problem = exact_filter.Problem(None, m, y, (), ())
    Sigma = P0
    for P in in_fractions(problem)[1]:
        Sigma = by_the_page(A, Q, C, R, Sigma)
        assert (P == Sigma).all()


def many_states(r=1.0):
    rng = np.random.default_rng(5)
    n, p = 8, 3
    A, C, G = (rng.normal(size=s) for s in ((n, n), (p, n), (n, n)))
    A *= 0.9 / np.abs(np.linalg.eigvals(A)).max()
    plant = lb.Plant(A, None, C, dt=1.0, Q=G @ G.T, R=np.diag([1, 1, r]), P0=np.eye(n))
    y = rng.normal(size=(60, p))
    y[rng.random(y.shape) < 0.2] = np.nan
    return plant, y


def test_many_states_are_filtered_as_few_are(monkeypatch):
    plant, y = many_states()
    found = lb.Filter(plant).run(y)
    assert found.end.P is not None
    parts, end = [], None
    for part in lb.Record(y).split(13):
        parts.append(lb.Filter(plant).run(part, start=end))
        end = parts[-1].end
    assert np.array_equal(np.concatenate([part.x for part in parts]), found.x)
    assert np.array_equal(np.concatenate([part.std for part in parts]), found.std)
    monkeypatch.setattr(pack, "is_quick", lambda *_: False)
    factors = lb.Filter(plant).run(y)
    assert factors.end.P is None
    assert np.allclose(found.x, factors.x, rtol=1e-12, atol=1e-12)
    assert np.allclose(found.std, factors.std, rtol=1e-12, atol=0)


def test_what_is_not_kept_is_not_written(monkeypatch):
    """In Python, which tells of a place that is not there."""
    plant, y = many_states()
    found = lb.Filter(plant).log_likelihood(y)
    monkeypatch.setattr(quick.forward, "fast", quick.forward.on())
    assert np.isclose(lb.Filter(plant).log_likelihood(y), found, rtol=1e-12)


def test_a_covariance_close_to_singular_is_left_to_factors(monkeypatch):
    """A reading of noise 1e-10 beside states of order one: the whole record again."""
    plant, y = many_states(1e-20)
    found = lb.Filter(plant).run(y)
    assert found.end.P is None
    monkeypatch.setattr(pack, "is_quick", lambda *_: False)
    assert np.array_equal(found.x, lb.Filter(plant).run(y).x)


@pytest.mark.parametrize("grows", [1.5, 2.5])
def test_a_covariance_of_an_unstable_plant_stays_symmetric(monkeypatch, grows):
    """What is not symmetric grows by the square of this at each row."""
    plant, y = many_states()
    plant = replace(plant, A=grows * plant.A)
    found = lb.Filter(plant).run(y)
    assert np.array_equal(found.end.P, found.end.P.T)
    monkeypatch.setattr(pack, "is_quick", lambda *_: False)
    factors = lb.Filter(plant).run(y)
    assert np.allclose(found.std, factors.std, rtol=1e-9, atol=0)


def test_a_sensor_that_leaves_few_digits_is_left_to_factors():
    """The next rows would hide it: eight of them are filtered before a test."""
    plant, y = many_states(1e-11)
    y[:] = np.where(np.arange(60)[:, None] == 2, y, np.nan)
    found = lb.Filter(plant).run(y[:7])
    assert found.end.P is None


def hostile(seed):
    """Many states: sensors of any accuracy, Q of any rank, an unstable plant, gaps."""
    rng = np.random.default_rng([77, seed])
    n, p, N = (int(rng.choice(sizes)) for sizes in ([7, 8, 11], [1, 2, 4], [3, 13, 40]))
    A = np.eye(n) + np.eye(n, k=1) * rng.choice([0.01, 1])
    if rng.random() < 0.7:
        A = rng.integers(-2, 3, (n, n)) * (rng.random((n, n)) < 0.5)
        A = A * rng.choice([0.5, 0.99, 1.2, 2]) / (abs(np.linalg.eigvals(A)).max() or 1)
    C = (
        np.eye(n)[rng.integers(0, n, p)]
        if rng.random() < 0.5
        else rng.normal(size=(p, n))
    )
    C[-1] = C[0] + rng.choice([0, 1e-6, 1]) * C[-1]
    G = rng.integers(-2, 3, (n, rng.integers(0, n + 1)))
    Q = 10.0 ** rng.integers(-8, 3) * G @ G.T + 10.0 ** rng.integers(-15, 0) * np.eye(n)
    r = 10.0 ** rng.choice([-15, -12, -8, -4, -1, 0, 1], p)
    start = 10.0 ** rng.choice([-6, 0, 0, 3, 8])
    plant = lb.Plant(A, None, C, dt=1.0, Q=Q, R=np.diag(r), P0=start * np.eye(n))
    y = np.where(rng.random((N, p)) < 0.1, np.nan, rng.normal(size=(N, p)))
    return plant, y


@pytest.mark.parametrize("first", range(0, 150, 50))
def test_the_covariance_itself_is_right_or_not_used(monkeypatch, first):
    tried, used = pack.is_quick, 0
    for seed in range(first, first + 50):
        plant, y = hostile(seed)
        settings = Settings(plant)
        begin = pack.begin(settings, np.zeros(0)), y, np.zeros((len(y), 0)), "back"
        monkeypatch.setattr(pack, "is_quick", tried)
        try:
            found = pack.over(settings, *begin)
        except DesignError as error:
            assert "digits" in str(error)
            continue
        if found.end.P is None:
            continue
        used += 1
        monkeypatch.setattr(pack, "is_quick", lambda *_: False)
        V, D = pack.over(settings, *begin).tape[2:4]
        P = np.einsum("tka,tk,tkb->tab", V, D, V)
        std = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
        off = (found.tape.V - P) / std[:, None] / std[:, :, None]
        assert np.abs(off).max() < 1e-5, seed
    assert used > 10


def test_an_elimination_finds_what_is_not_definite():
    P = np.eye(4) + 0.1
    room = np.zeros((4, 4))
    assert quick.definite(P, room)
    P[2] = P[1]
    P[:, 2] = P[:, 1]
    assert not quick.definite(P, room)
    assert not quick.definite(np.full((1, 1), np.nan), room)


@pytest.mark.parametrize("P0", [None, np.eye(3)])
def test_what_cancels_to_rounding_is_no_contradiction(P0):
    """A state that exact readings tell to be zero keeps rounding of what they were."""
    A = [[0, -1, 0], [-1, -0.6, -1], [-1, -0.8, 0.2]]
    C, H = [[0.3, -0.4, -0.4], [0.3, 0.2, 0], [0.4, 0.5, 0.5]], np.c_[[0.3, 0, 0.2]]
    plant = lb.Plant(A, None, C, dt=1.0, Q=np.zeros((3, 3)), R=H @ H.T, P0=P0)
    y = np.array([[-0.15, 0, -0.1], [-0.06, 0, -0.04], [0.12, 0, 0.08]])
    assert np.abs(lb.Filter(plant).run(y).x[1:]).max() < 1e-15
    y[2, 1] = 1e-6
    with pytest.raises(DesignError, match="at instant 3 the reading of"):
        lb.Filter(plant).run(y)


def test_a_small_variance_beside_large_ones_is_no_rounding():
    """What a variance is made of is that of its own row, times what it reads."""
    made, W, V, D = np.zeros(2), np.zeros((2, 3)), np.eye(2), np.array([2.0, 3.0])
    B, G = np.diag([1e-8, 1.0]), np.array([[0.0], [5.0]])
    passes.rows_ahead(B, G, V, D, W, 0, made)
    assert np.allclose(made, [2e-16, 28], rtol=1e-14, atol=0)
    plant = lb.Plant(
        B, None, [[0, 1]], dt=1.0, Q=np.zeros((2, 2)), R=[[1]], P0=np.eye(2)
    )
    assert np.isclose(lb.Filter(plant).run([[np.nan]]).std[0, 0], 1e-8, rtol=1e-12)


def test_noises_that_outputs_share_begin_each_row_as_nothing():
    """Two readings that differ contradict, however small they are."""
    plant = lb.Plant(
        [[1]], None, [[1], [1]], dt=1.0, Q=[[0]], R=np.ones((2, 2)), P0=[[0]]
    )  # fmt: skip
    assert lb.Filter(plant).run([[1e-9, 1e-9]] * 2).x[-1] == 0
    with pytest.raises(DesignError, match="at instant 2 the reading of 'y2'"):
        lb.Filter(plant).run([[1e-9, 1e-9], [1e-9, 2e-9]])


def test_a_plant_keeps_the_matrices_of_its_filter():
    """Not those of other filters, nor for a copy that may be another plant."""
    more = dict(Q=np.eye(2), P0=np.eye(2), dt=1.0)
    plant = lb.Plant(np.eye(2) / 2, None, np.eye(2), R=np.eye(2), **more)
    y = np.random.default_rng(0).normal(size=(9, 2))
    x = lb.Filter(plant).run(y).x
    assert lb.Filter(plant).settings is lb.Filter(plant).settings
    exact = lb.Filter(plant, m1=1)
    assert exact.settings.accurate and exact.settings is not lb.Filter(plant).settings
    assert np.allclose(exact.run(y).x[:, 0], y[:, 0])
    other = replace(plant, R=9 * np.eye(2))
    assert abs(lb.Filter(other).run(y).x - x).max() > 0.1
    copy = pickle.loads(pickle.dumps(plant))
    assert "_filter" in vars(plant) and "_filter" not in vars(copy)
    assert np.array_equal(lb.Filter(copy).run(y).x, x)
