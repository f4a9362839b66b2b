"""Van Dooren's observer beside pole placement on the dual reduced problem.

    python benchmarks/staircase.py            the whole table, about five minutes
    python benchmarks/staircase.py --quick    n up to 200, without place_poles at n = 50

Every method gets the same plant, poles and run.  The first plants are p chains of
delays with small random couplings, turned by a random orthogonal matrix, so that T and
C are well conditioned at every size; the last ones are dense random matrices.  The
poles are real, distinct and random.

* luenberger: `reduced_order_observer` from (A, C) to the certified Observer, by
  minimum norm and by back substitution; the time includes the certificate.
* place_poles (SciPy, method "YT"), python-control `place` and `place_varga` (needs
  slycot): the gain L that gives A11 - L A21 the poles, where C = [0 I] after an
  orthogonal change of state; the time is of the gain alone.
* hessenberg: `scipy.linalg.hessenberg` of A, the yardstick; times are in these units.

Times are medians of processor time, in turns.

"pole error" is the largest distance of an eigenvalue of the matrix that the method
returns (F, or A11 - L A21) from its pole, matched one to one; "by gain" is the same
for A11 - L A21 with the gain our observer implies.
"""

import math
import sys
import warnings

import numpy as np
import scipy.linalg
import scipy.signal
from common import in_turns, line, record, seconds
from scipy.optimize import linear_sum_assignment

import luenberger as lb

DENSE = ((10, 2), (20, 5), (50, 5), (50, 15))
SIZES = ((10, 2), (20, 2), (50, 5), (100, 4), (200, 4), (400, 4), (800, 4), (1000, 4))
OURS = "minimum-norm", "back-substitution"
SLOW = 5.0  # seconds; who takes longer is timed once
LIMITS = {"place_poles": 50, "control.place": 20, "place_varga": 400}
HEAD = (
    f"{'n':>5} {'p':>3}  {'method':<18} {'seconds':>9} {'hessenb.':>9} "
    f"{'pole error':>11} {'by gain':>10} {'|gain|':>10} {'cond':>10}"
)


def hidden_chains(n, p, seed=0):
    """A plant whose outputs are delayed states, and poles."""
    rng = np.random.default_rng(seed)
    A = np.eye(n, k=-p) + 0.3 * np.triu(rng.standard_normal((n, n)), 1 - p) / n
    Q = scipy.linalg.qr(rng.standard_normal((n, n)))[0]
    poles = 0.5 * rng.random(n - p) - 0.25
    return lb.Plant(Q @ A @ Q.T, None, np.eye(n)[n - p :] @ Q.T, dt=1.0), poles


def dense(n, p, seed=0):
    """A plant of normally distributed entries, and poles."""
    rng = np.random.default_rng(seed)
    A, C = rng.standard_normal((n, n)) / math.sqrt(n), rng.standard_normal((p, n))
    return lb.Plant(A, None, C), -1 - rng.random(n - p)


def reduced(A, C):
    """Q with C Q = [0 R], and A11, A21 of Q'A Q: the dual reduced problem."""
    n, p = A.shape[0], C.shape[0]
    Q = scipy.linalg.qr(C.T)[0]
    Q = np.hstack([Q[:, p:], Q[:, :p]])
    turned = Q.T @ A @ Q
    return Q, turned[: n - p, : n - p], turned[n - p :, : n - p]


def pole_error(matrix, poles):
    found = np.linalg.eigvals(matrix)
    gaps = np.abs(found[:, None] - np.asarray(poles))
    rows, cols = linear_sum_assignment(gaps)
    return gaps[rows, cols].max()


def peers(n, A11, A21, poles, limits):
    """(name, function that returns the gain L) of every peer that can be run."""
    if n <= limits["place_poles"]:
        yield (
            "place_poles",
            lambda: scipy.signal.place_poles(A11.T, A21.T, poles).gain_matrix.T,
        )
    try:
        import control
    except ImportError:
        return
    if n <= limits["control.place"]:
        yield "control.place", lambda: np.asarray(control.place(A11.T, A21.T, poles)).T
    try:
        import slycot  # noqa: F401
    except ImportError:
        return
    if n <= limits["place_varga"]:
        yield (
            "place_varga",
            lambda: np.asarray(control.place_varga(A11.T, A21.T, poles)).T,
        )


def contestants(plant, poles, A11, A21, limits):
    """Ours first: ratios are to its time."""
    ours = {
        method: lambda method=method: lb.reduced_order_observer(
            plant, poles, method=method
        )
        for method in OURS
    }
    A, C = plant.A, plant.C
    ours["hessenberg"] = lambda: scipy.linalg.hessenberg(A)
    ours["staircase"] = lambda: lb.staircase(A, C)
    return ours | dict(peers(plant.n, A11, A21, poles, limits))


def tried(runs):
    """Results, and the runs to be timed: a peer may fail, and is left out then.

    The only times of those who take more than SLOW seconds come third.
    """
    found, again, once = {}, {}, {}
    for name, work in runs.items():
        try:
            taken, found[name] = seconds(work)
        except Exception as error:
            print(f"{name} failed: {error}")
            continue
        if taken < SLOW:
            again[name] = work
        else:
            once[name] = [taken]
    return found, again, once


def rows(plant, poles, limits):
    """Times of all methods, and of each: errors, gain, cond."""
    C, n, p = plant.C, plant.n, plant.p
    Q, A11, A21 = reduced(plant.A, C)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        found, runs, once = tried(contestants(plant, poles, A11, A21, limits))
        times = in_turns(runs, 5 if n <= 200 else 3) | once
    figures = {}
    for name, got in found.items():
        if name in OURS:
            T = got.T @ Q
            gain = -np.linalg.solve(T[:, : n - p], T[:, n - p :])
            error, cond = pole_error(got.F, poles), lb.certify(got, plant).cond
        elif name in LIMITS:
            gain, error = got, pole_error(A11 - got @ A21, poles)
            T = np.hstack([np.eye(n - p), -gain]) @ Q.T
            cond = np.linalg.cond(np.vstack([T, C]))
        else:
            continue
        by_gain = pole_error(A11 - gain @ A21, poles)
        figures[name] = error, by_gain, np.linalg.norm(gain, 2), cond
    return times, figures


def shown(n, p, times, figures):
    """A line a method, times in Hessenberg reductions too."""
    unit = np.median(times["hessenberg"])
    for name, all_ in times.items():
        taken = np.median(all_)
        cells = "".join(f" {value:10.1e}" for value in figures.get(name, ()))
        print(f"{n:5} {p:3}  {name:<18} {taken:9.4f} {taken / unit:9.1f} {cells}")


COLUMNS = {
    "minimum-norm": "NumPy",
    "back-substitution": "back substitution",
    "hessenberg": "Hessenberg reduction",
    "place_poles": "SciPy",
    "place_varga": "python-control",
}


def records(quick=False):
    """A row a size, seconds; the accuracy is printed."""
    limits = LIMITS | ({"place_poles": 20} if quick else {})
    print(HEAD)
    for make, sizes in ((hidden_chains, SIZES), (dense, DENSE)):
        for n, p in sizes:
            if quick and n > 200:
                break
            times, figures = rows(*make(n, p), limits)
            shown(n, p, times, figures)
            if make is hidden_chains:
                columns = {COLUMNS[k]: t for k, t in times.items() if k in COLUMNS}
                yield record("staircase and poles", f"n = {n}, p = {p}", "s", columns)
        print("above: chains of delays; below: dense random matrices")


if __name__ == "__main__":
    for one in records("--quick" in sys.argv):
        print(line(one), flush=True)
