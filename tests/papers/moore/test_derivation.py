"""Moore's derivation: errata that are tried, and kernels that build an observer."""

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp

from luenberger import kernels
from luenberger.papers.moore.derivation import (
    companion_row,
    errata,
    observer_input,
    recurrence,
)
from matrixproof.derivation import vanishes


def test_no_recurrence_is_violated_at_full_order():
    """r = n: S has no rows, so every characteristic polynomial is admissible."""
    assert recurrence.recurrence_rows([1, 2, 3, 1], 3).shape == (0, 3)


@pytest.mark.parametrize("place", errata.entries())
def test_errata_are_tried(place):
    printed, ours = errata.entries()[place]
    assert not vanishes(printed) and vanishes(ours)


def exact(rows):
    return np.array([[Fraction(x) for x in row] for row in rows], dtype=object)


def rational_case():
    """A plant, beta, D and k with k beta(A) = sum D_i C A^(r-i), all in Fractions."""
    A = exact([[0, 1, 0, 2], ["1/2", 0, 1, 0], [0, -1, 0, 1], [1, 0, "1/3", -2]])
    C = exact([[1, 0, 2, 0], [0, 1, 0, 0]])
    beta = [Fraction(3, 4), Fraction(2), Fraction(1, 5)]
    D = exact([[1, -2], ["1/3", 0], [2, "1/7"]])
    power, total, shown = exact(np.eye(4, dtype=int).tolist()), 0, 0
    for j, b in enumerate([*beta, Fraction(1)]):
        total = total + b * power
        shown = shown + (D[2 - j : 3 - j] @ C @ power if j < 3 else 0)
        power = power @ A
    k = sp.Matrix(shown.tolist()) * sp.Matrix(total.tolist()).inv()
    return A, C, beta, D, exact([[Fraction(int(x.p), int(x.q)) for x in k]])


def test_the_kernel_builds_an_exact_observer_row_by_row():
    A, C, beta, D, k = rational_case()
    step = kernels.compiled(companion_row)
    rows = [k]
    for i, b in enumerate(reversed(beta)):
        given = dict(t=rows[-1], A=A, b=exact([[b]]), k=k, d=D[i : i + 1], C=C)
        rows.append(step(**given)["t_next"])
    *rows, after = rows
    T = np.vstack(rows)
    F = exact([[-beta[2], 1, 0], [-beta[1], 0, 1], [-beta[0], 0, 0]])
    assert not after.any() and not (T @ A - F @ T - D @ C).any()
    B, E = exact([[1], [0], [2], [1]]), exact([["1/2"], [3]])
    G = kernels.compiled(observer_input)(T=T, B=B, D=D, E=E)["G"]
    assert (G == T @ B - D @ E).all()
    # run it, by hand: the error is P F^j (z - T x) whatever the input does
    x, z = exact([[1], [-2], [3], [1]]), exact([[5], [0], ["-1/3"]])
    error = z - T @ x
    for j in range(6):
        assert (z[:1] - k @ x == error[:1]).all()
        u = exact([[j * j - 2]])
        y = C @ x + E @ u
        x, z, error = A @ x + B @ u, F @ z + G @ u + D @ y, F @ error
