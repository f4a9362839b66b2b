"""What does a row cost where one channel is late, beside running the filter again?

Operations are counted in the stage lists, as loops: a row of the filter that waits for
`lag` readings of one output, the others on time, and lag + 1 rows of the filter that
would be run again instead.  Times are processor times of `filter_data` in NumPy over
rows, beside running it again from a stored state, which takes lag + 1 rows.

Run:  OMP_NUM_THREADS=1 python benchmarks/late_readings.py [--quick]
"""

import sys

import numpy as np
from common import plant, seconds

import luenberger as lb
from luenberger.kernels import cost, lowered
from luenberger.papers.leondes_novak.derivation import (
    filter_step,
    late_ahead,
    late_corrected,
    late_fresh,
    late_known,
)

SIZES = [(3, 1), (3, 2), (6, 2), (10, 2), (10, 4)]
LAG = 50


def operations(stages, sizes, outputs=(), **options):
    """Of one pass, with loops that do not know any zeros in the matrices."""
    return cost.loops(lowered(stages, outputs, **options), sizes).operations


def again(n, p):
    """One row of the filter, without inputs."""
    return operations(
        filter_step, dict(n=n, p=p, m=0), ["Sigma_next", "x_next"],
        zero=["J", "Gamma", "B", "E"], symmetric=("Q", "R", "Sigma"),
        same=[("As", "A")],
    )  # fmt: skip


def waiting(n, p):
    """One row that waits: predict, take p readings, use p of which one is old."""
    sizes = dict(n=n, p=p, m=0, q=LAG - 1)
    none = dict(zero=["J", "B", "E"])
    parts = (
        (late_ahead, sizes, ["X_h_next", "Omega", "x_minus"], ("Qs", "Sigma")),
        (late_fresh, sizes, ["y_minus", "N", "N_h", "M"], ("R", "Omega")),
        (late_known, dict(s=n + LAG, k=p), [], ("P_rr", "P_tt")),
        (late_corrected, dict(s=n + LAG, k=p), [], ()),
    )
    return sum(operations(s, z, o, symmetric=y, **none) for s, z, o, y in parts)


def times(n, p, rows, rounds):
    """Processor time of a row that waits beside LAG + 1 rows: the median ratio."""
    made = plant(n, p)
    y = np.random.default_rng(1).normal(size=(rows, p))
    arrival = np.arange(float(rows))[:, None] + [LAG, *([0] * (p - 1))]
    ratios = []
    for _ in range(rounds):
        late, _ = seconds(lambda: lb.filter_data(made, y, arrival=arrival))
        once, _ = seconds(lambda: lb.filter_data(made, y, backend="numpy"))
        ratios.append(late / once / (LAG + 1))
    return np.median(ratios)


def main(quick):
    rows, rounds = (200, 3) if quick else (1000, 11)
    print(f"lag {LAG}    again    waiting   ratio   ratio of times, NumPy")
    for n, p in SIZES:
        one, late = (LAG + 1) * again(n, p), waiting(n, p)
        ratio = times(n, p, rows, rounds)
        print(f"{n:3} {p:3} {one:9} {late:9} {late / one:8.2f} {ratio:8.3f}")


if __name__ == "__main__":
    main("--quick" in sys.argv)
