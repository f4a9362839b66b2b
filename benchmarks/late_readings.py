"""What does a row cost where one channel is late, beside running the filter again?

Operations are counted in the stage lists, as loops: of a row of the pass that does many
rows at a time, of a row of the filter that carries the `lag` readings it waits for, and
of lag + 1 rows of the filter that would be run again instead.  The other outputs are on
time.  Times are processor times of `filter_data` in NumPy, and compiled, beside lag + 1
times that of a filter with every reading on time.

Run:  OMP_NUM_THREADS=1 python benchmarks/late_readings.py [--quick]
"""

import sys
from dataclasses import replace

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
from luenberger.recursion.late_passage import END
from luenberger.recursion.late_passage import SILENT as SILENT_END
from luenberger.recursion.late_stretches import PAIR, ROW, SILENT, SINGLE

SIZES = [(3, 1), (3, 2), (6, 1), (6, 2), (10, 1), (10, 2)]
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


def in_order(n, p):
    """One row of a constant plant: a filter that knows all, and its way to now.

    With one output nothing is on time, and the lists are those of `SILENT`.
    """
    sizes, once = dict(n=n, p=max(p - 1, 1), m=0, r=n), [ROW, SINGLE, PAIR, END]
    if p == 1:
        once = [*(SILENT[one] for one in once[:3]), SILENT_END]
    once = [replace(one, definite=()) for one in once]  # tested in one row of eight
    counts = [
        cost.loops(one.lowered(("B", "E")).program, sizes).operations for one in once
    ]
    return again(n, p) + sum(counts) + counts[-1]  # two ends


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


def times(n, p, rows, rounds, backend):
    """Processor time of a late row beside LAG + 1 rows on time: the median ratio."""
    made = plant(n, p)
    y = np.random.default_rng(1).normal(size=(rows, p))
    arrival = np.arange(float(rows))[:, None] + [LAG, *([0] * (p - 1))]
    ratios = []
    for _ in range(rounds + 1):
        late, _ = seconds(
            lambda: lb.filter_data(made, y, arrival=arrival, backend=backend)
        )
        once, _ = seconds(lambda: lb.filter_data(made, y, settle=None, backend=backend))
        ratios.append(late / once / (LAG + 1))
    return np.median(ratios[1:])  # the first compiles


def main(quick):
    few, many, rounds = (500, 20_000, 3) if quick else (4000, 200_000, 7)
    print(f"lag {LAG}    operations of                 ratio of      ratio of times")
    print("  n   p   again  in order  waiting   in order  waiting   NumPy  compiled")
    for n, p in SIZES:
        one = (LAG + 1) * again(n, p)
        counts = in_order(n, p), waiting(n, p)
        ratios = [f"{count / one:9.3f}" for count in counts]
        taken = [
            times(n, p, rows, rounds, backend)
            for rows, backend in ((few, "numpy"), (many, "numba"))
        ]
        print(
            f"{n:3} {p:3} {one:7}", *(f"{count:8}" for count in counts), *ratios,
            *(f"{ratio:8.3f}" for ratio in taken), flush=True,
        )  # fmt: skip


if __name__ == "__main__":
    main("--quick" in sys.argv)
