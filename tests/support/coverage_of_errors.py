"""How often two standard errors around a fit hold the truth, on random plants.

    python tests/support/coverage_of_errors.py 1000

takes some minutes and prints the share, off the bounds and beside a variance that was
found to be zero; `tests/identification/test_fit.py` does the same with few plants.
Cramer and Rao's errors promise 95.4 % in the long run.
"""

import sys
from concurrent.futures import ProcessPoolExecutor

import numpy as np

import luenberger as lb
from luenberger.identification.identifiability import identifiability

ROWS = 4000


def plant_and_record(seed, sizes=None):
    """A stable plant, its Q and R, which a record determines, and a long record."""
    rng = np.random.default_rng(seed)
    while True:
        n, p = sizes or (rng.integers(1, 4), rng.integers(1, 3))
        A = rng.normal(size=(n, n))
        A *= rng.uniform(0.5, 0.95) / np.abs(np.linalg.eigvals(A)).max()
        C = rng.normal(size=(p, n))
        plant = lb.Plant(A, None, C, dt=1.0)
        Q = np.diag(rng.uniform(0.3, 3, n))
        half = rng.normal(size=(p, p))
        R = half @ half.T + 0.3 * np.eye(p)
        if not identifiability(plant, Q="diagonal").sentences:
            return plant, Q, R, record(rng, A, C, Q, R)


def record(rng, A, C, Q, R):
    w = rng.normal(size=(ROWS + 100, len(A))) * np.sqrt(Q.diagonal())
    v = rng.normal(size=(ROWS + 100, len(C))) @ np.linalg.cholesky(R).T
    x, y = np.zeros(len(A)), np.empty(v.shape)
    for k in range(len(y)):
        y[k] = C @ x + v[k]
        x = A @ x + w[k]
    return y[100:]


def of_plant(seed, sizes=None):
    """Of each entry: its error in standard errors, and if the fit is off its bounds.

    A variance that is found to be zero is at its bound, and has no error.  Those of
    the others are the ones that hold without the bound.
    """
    plant, Q, R, y = plant_and_record(seed, sizes)
    fit = lb.fit_noise(plant, y, Q="diagonal")
    errors = fit.standard_errors
    inside = bool(np.isfinite(errors["Q"]).all() and np.isfinite(errors["R"]).all())
    found = []
    for letter, true in (("Q", Q), ("R", R)):
        value, error = getattr(fit.plant, letter), errors[letter]
        for i, j in zip(*np.triu_indices(len(true))):
            if letter == "R" or i == j:
                found.append(((value - true)[i, j] / error[i, j], inside))
    return found


def share(found, off_bounds=True):
    """The part of the entries that two errors hold, and how many there are.

    Those of fits off their bounds, or of the others.
    """
    of = np.array([off for off, ok in found if ok == off_bounds and np.isfinite(off)])
    return float((np.abs(of) <= 2).mean()) if len(of) else np.nan, len(of)


def main(count):
    with ProcessPoolExecutor(2) as pool:
        found = [one for part in pool.map(of_plant, range(count)) for one in part]
    for where, off_bounds in (("off their bounds", True), ("beside a bound", False)):
        part, entries = share(found, off_bounds)
        print(
            f"{100 * part:.1f} % of {entries} entries of fits {where}, {count} plants"
        )


if __name__ == "__main__":
    main(int(sys.argv[1]) if len(sys.argv) > 1 else 1000)
