"""Rows with one gain beside the full recursion, and where they begin and end."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.filtering import tail

ROWS = 1500


def settling(n, p, m=1, seed=0, **options):
    rng = np.random.default_rng([n, p, seed])
    A = rng.normal(size=(n, n))
    A *= rng.uniform(0.5, 1.2) / np.abs(np.linalg.eigvals(A)).max()
    G, H = rng.normal(size=(n, n)), rng.normal(size=(p, p))
    given = dict(Q=G @ G.T, R=H @ H.T + 0.1 * np.eye(p), P0=np.eye(n), dt=1.0)
    B, C = rng.normal(size=(n, m)), rng.normal(size=(p, n))
    return lb.Plant(A, B, C, rng.normal(size=(p, m)), **(given | options)), rng


def both(plant, record):
    """What a filter finds, and what the full recursion does."""
    run = lb.Filter(plant)
    full = list(run._windows(lb.Record.of(record).on(plant), None, "readings"))
    x, variances = (
        np.concatenate([getattr(one, name) for one in full])
        for name in ("x", "variances")
    )
    return run.run(record), x, np.sqrt(variances)


@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(("n", "p"), [(1, 1), (2, 1), (3, 2), (5, 1), (8, 3)])
def test_the_tail_is_the_recursion(n, p, seed):
    """Up to what the covariances differ by; with inputs, correlated R and a gap."""
    plant, rng = settling(n, p, seed=seed)
    y, u = rng.normal(size=(ROWS, p)), rng.normal(size=(ROWS, 1))
    y[600:603, 0] = np.nan
    found, x, std = both(plant, lb.Record(y, u))
    assert found.settled_at.tolist() == [512, 1115]
    unit = std.min(axis=0)
    size = np.abs(x).max()
    assert (np.abs(found.x - x) / unit).max() < 1e-10 + 1e-13 * size / unit.min()
    assert np.abs(found.std / std - 1).max() < 1e-11


@pytest.mark.parametrize("size", [1, 100, 512, 700])
def test_parts_are_the_whole_bit_for_bit(size):
    plant, rng = settling(2, 1)
    y = rng.normal(size=(ROWS, 1))
    y[700:702] = np.nan
    run, end, parts = lb.Filter(plant), None, []
    for part in lb.Record(y).split(size):
        parts.append(run.run(part, start=end))
        end = parts[-1].end
    whole = run.run(y)
    for name in ("x", "std"):
        joined = np.concatenate([getattr(part, name) for part in parts])
        assert (joined == getattr(whole, name)).all()
    first = size * np.arange(len(parts))
    joined = np.concatenate([k + part.settled_at for k, part in zip(first, parts)])
    starts = [k for k in joined if k - 1 not in joined and k % size or k in (512, 1214)]
    assert set(whole.settled_at) == set(starts) == {512, 1214}


def test_the_ball_is_not_left_and_not_entered_early():
    """Thompson's metric: no row expands it; what is just outside is no tail."""
    plant, _ = settling(3, 1)
    run = lb.Filter(plant)
    run.run(np.zeros((600, 1)))
    one = run.settings._steady[0]
    Sigma = (one.V.T * one.D) @ one.V
    for part, inside in ((0.4, True), (0.6, False)):
        D = one.D.copy()
        D[0] *= 1 + part * tail.EPS
        assert one.holds(one.V, D, tail.EPS / 2) == inside
    R, C, A, Q = plant.R, plant.C, plant.A, plant.Q
    S, far = Sigma * 1.5, []
    for _ in range(20):
        far.append(np.abs(np.linalg.eigvals(np.linalg.solve(Sigma, S)) - 1).max())
        S = A @ S @ A.T + Q
        S = S - S @ C.T @ np.linalg.solve(C @ S @ C.T + R, C @ S)
    assert (np.diff(far) < 1e-12).all() and far[-1] < 1e-3


@pytest.mark.parametrize("kind", ["exact", "still", "unseen", "slow", "varying"])
def test_where_nothing_is_steady_the_recursion_runs(kind):
    """Exact outputs, states without noise, states that no output shows, slow ones."""
    A, C = np.diag([0.9, 0.5]), np.array([[1.0, 1.0]])
    more = dict(Q=np.eye(2), R=np.eye(1))
    if kind == "exact":
        more["R"] = np.zeros((1, 1))
    elif kind == "still":
        A, more["Q"] = np.diag([1, 0.5]), np.diag([0, 1])
    elif kind == "unseen":
        A, C = np.diag([1.01, 0.5]), np.array([[0.0, 1.0]])
    elif kind == "slow":
        A, more["Q"] = np.diag([1, 0.5]), np.diag([1e-8, 1])
    else:
        A = np.stack([A] * (ROWS + 1))
    plant = lb.Plant(A, None, C, dt=1.0, P0=np.eye(2), **more)
    y = np.random.default_rng(0).normal(size=(ROWS, 1))
    found, x, std = both(plant, y)
    assert not found.settled_at.size
    assert (found.x == x).all() and (found.std == std).all()
