"""Rows of a record in lanes, beside the same one by one."""

import numpy as np
import pytest

from luenberger.kernels import stack
from luenberger.kernels.lanes import arguments, in_lanes, source
from luenberger.recursion.settled_rows import ROW

COUNT = 8


def plain(sizes):
    """`in_lanes` of Python, not compiled."""
    program = ROW.program
    names, here = arguments(ROW, program), stack.plain()
    exec(source(ROW, program, dict(sizes), COUNT), here)
    return lambda **arrays: here["run"](*(arrays[name] for name in names))


def compiled(sizes):
    pytest.importorskip("numba")
    return in_lanes(ROW, sizes, 2 * COUNT)  # as a filter of 3 states has them


SIZES = [(1, 1, 1), (3, 2, 2), (7, 3, 1), (13, 5, 4)]


@pytest.mark.parametrize(
    "made, n, k, j", [*((plain, *size) for size in SIZES), (compiled, 3, 6, 2)]
)
def test_lanes_run_as_rows_do(made, n, k, j):
    rng = np.random.default_rng(n)
    Phi = rng.standard_normal((n, n)) / (2 * n)
    G_r, W_x, W_r = (rng.standard_normal(size) for size in ((n, k), (j, n), (j, k)))
    r, xs = rng.standard_normal((200, k)), np.full((200, n), np.nan)
    begins = np.array([0, 10, 20, 37, 60, 90, 120, 150, *[160] * 8])
    shows = begins + [0, 4, 0, 7, 1, 9, 30, 2, *[5] * 8]
    ends = begins + [10, 10, 17, 20, 30, 9, 30, 1, *[40] * 8]
    x = rng.standard_normal((len(begins), n))
    x[8:] = x[8]  # a lane that is run more than once, to fill up
    wanted, most, after = xs.copy(), np.zeros(n + k + 1), x.copy()
    for lane, (first, show, end) in enumerate(zip(begins, shows, ends)):
        for row in range(first, end):
            weighed = W_x @ after[lane] + W_r @ r[row]
            after[lane] = Phi @ after[lane] + G_r @ r[row]
            if row >= show:
                wanted[row] = after[lane]
                kept = np.concatenate([after[lane], r[row], [weighed @ weighed]])
                most = np.maximum(most, np.abs(kept))
    largest = np.zeros(n + k + 1)
    made((("n", n), ("k", k), ("j", j)))(
        begins=begins, shows=shows, ends=ends, Phi=Phi, G_r=G_r, W_x=W_x, W_r=W_r,
        x=x, r=r, written=xs, largest=largest,
    )  # fmt: skip
    np.testing.assert_allclose(xs, wanted, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(x, after, rtol=1e-12, atol=1e-13)
    np.testing.assert_allclose(largest, most, rtol=1e-12)
