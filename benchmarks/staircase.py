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

"pole error" is the largest distance of an eigenvalue of the matrix that the method
returns (F, or A11 - L A21) from its pole, matched one to one; "by gain" is the same
for A11 - L A21 with the gain our observer implies.
"""

import argparse
import math
import time
import warnings

import numpy as np
import scipy.linalg
import scipy.signal
from scipy.optimize import linear_sum_assignment

import luenberger as lb

DENSE = ((10, 2), (20, 5), (50, 5), (50, 15))
SIZES = ((10, 2), (20, 2), (50, 5), (100, 4), (200, 4), (400, 4), (800, 4), (1000, 4))
LIMITS = {"place_poles": 50, "control.place": 20, "place_varga": 400}
HEAD = (
    f"{'n':>5} {'p':>3}  {'method':<18} {'seconds':>9} {'hessenb.':>9} "
    f"{'pole error':>11} {'by gain':>9} {'|gain|':>9} {'cond':>9}"
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


def timed(work, repeats):
    """Best time of `repeats` runs, and the result."""
    best = math.inf
    for _ in range(repeats):
        start = time.perf_counter()
        with warnings.catch_warnings():
            warnings.simplefilter("ignore")
            result = work()
        best = min(best, time.perf_counter() - start)
    return best, result


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


def rows(plant, poles, limits):
    """One table row per method: name, seconds, hessenbergs, errors, gain, cond."""
    A, C, n, p = plant.A, plant.C, plant.n, plant.p
    Q, A11, A21 = reduced(A, C)
    repeats = 5 if n <= 200 else 2
    unit, _ = timed(lambda: scipy.linalg.hessenberg(A), 3 * repeats)
    yield "hessenberg", unit, 1.0, None, None, None, None
    seconds, _ = timed(lambda: lb.staircase(A, C), repeats)
    yield "staircase", seconds, seconds / unit, None, None, None, None
    for method in ("minimum-norm", "back-substitution"):

        def work(method=method):
            return lb.reduced_order_observer(plant, poles, method=method)

        seconds, observer = timed(work, repeats)
        T = observer.T @ Q
        gain = -np.linalg.solve(T[:, : n - p], T[:, n - p :])
        yield (
            method, seconds, seconds / unit, pole_error(observer.F, poles),
            pole_error(A11 - gain @ A21, poles), np.linalg.norm(gain, 2),
            lb.certify(observer, plant).cond,
        )  # fmt: skip
    for name, work in peers(n, A11, A21, poles, limits):
        try:
            seconds, gain = timed(work, 1 if n >= 50 else 3)
        except Exception as error:
            print(f"{n:5d} {p:3d}  {name:<18} failed: {error}")
            continue
        error = pole_error(A11 - gain @ A21, poles)
        T = np.hstack([np.eye(n - p), -gain]) @ Q.T
        yield (
            name, seconds, seconds / unit, error, error, np.linalg.norm(gain, 2),
            np.linalg.cond(np.vstack([T, C])),
        )  # fmt: skip


def shown(n, p, name, seconds, ratio, *rest):
    cells = " ".join(
        f"{'' if value is None else f'{value:.1e}':>{width}}"
        for value, width in zip(rest, (11, 9, 9, 9))
    )
    return f"{n:5d} {p:3d}  {name:<18} {seconds:9.4f} {ratio:9.1f} {cells}"


def targets(table):
    """The figures that were asked for, from this run."""
    if (50, "place_poles") in table:
        mine, theirs = table[50, "minimum-norm"], table[50, "place_poles"]
        print(
            f"n = 50, p = 5: place_poles / minimum norm = {theirs[0] / mine[0]:.0f} "
            f"(asked: 100); pole error {mine[2]:.1e} ({mine[3]:.1e} by gain) against "
            f"{theirs[2]:.1e}"
        )
    for method in ("minimum-norm", "back-substitution"):
        if (800, method) in table:
            growth = math.log(table[800, method][0] / table[200, method][0], 4)
            print(
                f"{method}: time grows as n^{growth:.2f}, n = 200 to 800 (asked: 3.3)"
            )
    if (400, "minimum-norm") in table:
        print(
            f"n = 400, p = 4: minimum norm takes {table[400, 'minimum-norm'][1]:.0f} "
            "Hessenberg reductions (asked: 60)"
        )


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--quick", action="store_true")
    quick = parser.parse_args().quick
    limits = LIMITS | ({"place_poles": 20} if quick else {})
    table = {}
    print(HEAD)
    for n, p in SIZES:
        if quick and n > 200:
            break
        for name, *values in rows(*hidden_chains(n, p), limits):
            table[n, name] = values
            print(shown(n, p, name, *values), flush=True)
    print("dense random matrices")
    for n, p in DENSE:
        for name, *values in rows(*dense(n, p), limits):
            print(shown(n, p, name, *values), flush=True)
    targets(table)


if __name__ == "__main__":
    main()
