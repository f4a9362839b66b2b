"""Products in tiles: every height and width, against NumPy, in Python and compiled."""

import numpy as np
import pytest

from luenberger.kernels import products, stack

HEIGHTS = range(1, products.HEIGHT + 1)
COLUMNS = [1, 2, 3, 4, 7, 8, 13, 19]
TEXT = """
def run(panels, columns, inner, most, scale, D, C, A, a_row, a_col, B):
    product(
        {height}, {start}, panels, columns, inner, most, scale, D, 3, columns + 1,
        C, 2, columns, A, 1, a_row, a_col, B, 4, columns,
    )
"""


def compiled(height, start):
    """`run` by numba."""
    numba = pytest.importorskip("numba", reason="numba is an optional extra")
    space = {"product": stack.ours()["product"]}
    exec(TEXT.format(height=height, start=start), space)
    return numba.njit(space["run"])


def in_python(height, start):
    space = {"product": products.in_python}
    exec(TEXT.format(height=height, start=start), space)
    return space["run"]


@pytest.mark.parametrize("start", [0, 1])
@pytest.mark.parametrize("height", HEIGHTS)
@pytest.mark.parametrize("form", [in_python, compiled])
def test_every_tile(form, height, start):
    """What is computed is right; all else in the target stays as it was."""
    run, rng = form(height, start), np.random.default_rng(height)
    for columns in COLUMNS:
        for panels, inner in ((1, 0), (2, 1), (3, 7)):
            rows = panels * height
            A, B = rng.normal(size=(rows, inner)), rng.normal(size=(inner, columns))
            C = rng.normal(size=(rows, columns))
            wanted = start * C - 0.5 * A @ B
            for turned in (False, True):
                for most in (0, max(columns - 8, 0)):
                    D = np.full((rows + 1) * (columns + 1) + 3, np.nan)
                    left = A.T if turned else A
                    run(
                        panels, columns, inner, most, -0.5, D, shifted(C, 2),
                        shifted(left, 1), 1 if turned else inner,
                        rows if turned else 1, shifted(B, 4),
                    )  # fmt: skip
                    found = D[3:][: rows * (columns + 1)].reshape(rows, -1)
                    first = [min(i // height * height, most) for i in range(rows)]
                    made = np.arange(columns) >= np.array(first)[:, None]
                    np.testing.assert_allclose(
                        found[:, :-1][made], wanted[made], rtol=0, atol=1e-13
                    )
                    assert np.isnan(found[:, -1]).all() and np.isnan(D[:3]).all()
                    assert np.isnan(found[:, :-1][~made]).all()


def shifted(X, by):
    """A flat array that begins after some numbers that nothing may use."""
    return np.concatenate([np.full(by, np.nan), X.ravel()])
