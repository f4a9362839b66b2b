"""What all benchmarks share: plants, contestants in turns, ratios with their spread.

A `record` is one row of the table: the time of the first contestant, ours, and for
every contestant the ratio of its time to that one's in the same round: quartiles.
"""

import time

import numpy as np

import luenberger as lb


def plant(n, p, seed=8):
    """A random stable plant with full-rank noise."""
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n))
    A *= 0.95 / np.abs(np.linalg.eigvals(A)).max()
    H, h = rng.normal(size=(n, n)), rng.normal(size=(p, p))
    C = rng.normal(size=(p, n))
    return lb.Plant(A, None, C, dt=1.0, Q=H @ H.T, R=h @ h.T, P0=np.eye(n))


def record_of(plant, rows, rng):
    """Measurements (rows, p) of a run of the plant."""
    w = rng.multivariate_normal(np.zeros(plant.n), plant.Q, rows)
    y = rng.multivariate_normal(np.zeros(plant.p), plant.R, rows)
    x = rng.multivariate_normal(np.zeros(plant.n), plant.P0)
    for k in range(rows):
        x = plant.A @ x + w[k]
        y[k] += plant.C @ x
    return y


def first_prior(plant):
    """The covariance of x[1] before y[1], where most filters start."""
    return plant.A @ plant.P0 @ plant.A.T + plant.Q


def seconds(work):
    """Seconds of processor time, so that a busy machine counts less, and the result."""
    start = time.process_time()
    result = work()
    return time.process_time() - start, result


def in_turns(runs, rounds, work=None, twice=False):
    """Seconds of each contestant in each round, over its amount of `work`, if given.

    With `twice` each runs twice in a row and its second time counts: so nobody pays for
    memory that the one before gave back to the system.
    """
    work = work or {}
    times = {name: [] for name in runs}
    for _ in range(rounds):
        for name, run in runs.items():
            if twice:
                run()
            times[name].append(seconds(run)[0] / work.get(name, 1))
    return times


def record(row, case, unit, times, scale=1.0):
    """One row: medians in `unit`, of which a second has `scale`, and ratios.

    Who was timed in fewer rounds is compared with ours in those.
    """
    base = np.array(next(iter(times.values())))
    found = {}
    for name, all_ in times.items():
        ratios = np.quantile(np.array(all_) / base[: len(all_)], [0.25, 0.5, 0.75])
        median = float(f"{np.median(all_) * scale:.4g}")
        ratios = [float(f"{ratio:.4g}") for ratio in ratios]
        found[name] = {"median": median, "ratios": ratios, "rounds": len(all_)}
    return {"row": row, "case": case, "unit": unit, "contestants": found}


def line(one):
    """A record as text."""
    cells = (
        f"{name} {who['median']:.3g} ({who['ratios'][1]:.3g})"
        for name, who in one["contestants"].items()
    )
    return f"{one['row']}, {one['case']} [{one['unit']}]: " + ", ".join(cells)


def same(name, found, wanted, tolerance=1e-8):
    """Nothing is timed that does not compute the same."""
    if not np.abs(found - wanted).max() <= tolerance * np.abs(wanted).max():
        raise SystemExit(f"{name} computes something else; nothing was timed")
