"""Rows (15)-(21), pairs (26)-(33) and operation counts, against dense systems."""

import warnings

import numpy as np
import pytest
from pairs import characteristic, conjugates, hidden_chains, with_stairs

import luenberger as lb
from luenberger.numeric import staircase_form
from luenberger.numeric.staircase_form import staircase
from luenberger.papers.van_dooren import design as design
from luenberger.papers.van_dooren import rows_of_T
from luenberger.papers.van_dooren.derivation import counts, errata
from luenberger.papers.van_dooren.rows_of_T import Order, minimum_norm, solve_rows
from matrixproof.derivation import vanishes

METHODS = ("minimum-norm", "back-substitution")


def figure(name, **sizes):
    """The paper's figure, or that of what is done here, at given sizes."""
    return float(
        counts.COUNTS[name].subs({getattr(counts, k): v for k, v in sizes.items()})
    )


def rows_of(form, poles, pairs, method):
    return solve_rows(form, Order(poles, pairs), design.METHODS[method])


@pytest.mark.parametrize("complex_", [False, True])
@pytest.mark.parametrize("sizes", [(2, 2, 2), (1, 2, 3), (1, 1, 2, 4), (3,) * 15])
def test_minimum_norm_is_what_a_dense_solver_finds(sizes, complex_):
    """(18), (20), (21) row by row with numpy.linalg.lstsq on the whole M_i."""
    rng = np.random.default_rng(1)
    form = staircase(*with_stairs(sizes, rng, complex_))
    n, r = sum(sizes), sizes[-1]
    poles = rng.standard_normal(n - r) + (1j * rng.standard_normal(n - r)) * complex_
    poles = poles.astype(complex)
    rows = rows_of(form, poles, np.zeros(n - r, bool), "minimum-norm")
    for i in range(n - r):
        f = poles[i] if complex_ else poles[i].real
        shifted = form.A - f * np.eye(n)
        M = np.vstack([-rows.T[:i], shifted[i + 1 :], -form.C])
        x = np.linalg.lstsq(M.T, -shifted[i], rcond=None)[0]
        mine = np.concatenate([rows.F[i, :i], rows.T[i, i + 1 :], rows.D[i]])
        assert np.linalg.norm(mine - x) < 1e-9 * (1 + np.linalg.norm(x))


def doubled(form, T, i, a, b):
    """(32), (33) as printed, and whether tau is known (1) or unknown."""
    n, r = len(form.A), form.rank
    K = np.kron(form.A - a * np.eye(n), np.eye(2)) - np.kron(
        np.eye(n), [[0, -b], [b, 0]]
    )
    rest = -np.kron(form.C[:r], np.eye(2))
    above = -np.kron(T[:i], np.eye(2))
    printed = np.vstack([above, K[2 * i + 3 :], rest])
    repaired = np.vstack([above, K[2 * i + 2 :], rest])
    return printed, -(K[2 * i + 1] + K[2 * i + 2]), repaired, -K[2 * i + 1]


def a_pair_after(i, form, f, solve):
    """The pair f and its conjugate in rows i and i + 1, real poles above them."""
    rows = rows_of_T.Rows(form)
    for k in range(i):
        rows.add(k, -1.0 - k, solve(rows, k, -1.0 - k, False))
    rows.add(i, f, solve(rows, i, f, True), True)
    return rows


@pytest.mark.parametrize(
    "sizes", [(1, 1, 1, 1), (1, 1, 2), (1, 2, 2), (2, 2, 2), (2, 3, 3), (1, 1, 1, 3, 3)]
)
def test_pair_solves_the_paper_s_system_where_that_has_a_solution(sizes):
    """Rank 2n - 1 of the printed Mb where the stair is one wide, 2n otherwise."""
    rng = np.random.default_rng(2)
    form = staircase(*with_stairs(sizes, rng))
    n, r = sum(sizes), sizes[-1]
    a, b = -0.7, 1.3
    for i in range(n - r - 1):
        rows = a_pair_after(i, form, a + 1j * b, minimum_norm)
        printed, right, repaired, right_repaired = doubled(form, rows.T, i, a, b)
        wide = form.leads[i] > i + 1
        assert np.linalg.matrix_rank(printed) == 2 * n - (not wide)
        assert np.linalg.matrix_rank(repaired) == 2 * n
        assert printed.shape == (2 * (n + r) - 3, 2 * n)
        tau = rows.T[i + 1, i + 1]
        first, second = rows.T[i], rows.T[i + 1]
        x = [rows.F[i + 1, :i], rows.F[i, :i], second[i + 1 :], first[i + 1 :]]
        x = [np.stack(x[k : k + 2], axis=1).ravel() for k in (0, 2)]
        x = np.concatenate([*x, np.stack([rows.D[i + 1], rows.D[i]], axis=1).ravel()])
        scale = np.linalg.norm(x) * np.linalg.norm(repaired)
        assert np.linalg.norm(x @ repaired - right_repaired) < 1e-13 * scale
        assert (rows.F[i : i + 2, i : i + 2] == [[a, -b], [b, a]]).all()
        if wide:
            best = np.linalg.lstsq(printed.T, right, rcond=None)[0]
            assert tau == pytest.approx(1, abs=1e-12)
            short = np.delete(x, 2 * i)
            assert np.linalg.norm(short - best) < 1e-8 * np.linalg.norm(best)
        else:
            assert tau == pytest.approx(b / form.A[i + 1, i], rel=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("b", [1e-12, 1e-6, 1.0, 1e3])
def test_one_output_with_complex_poles_for_every_size_of_the_imaginary_part(method, b):
    """tau = b / X: rescaled when it is far from one; the poles stay right."""
    A, C, _ = hidden_chains(5 if b <= 1 else 3, 1)
    plant = lb.Plant(A, None, C)
    poles = [-1 + 1j * b, -1 - 1j * b] * (plant.n // 2)
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        observer = lb.reduced_order_observer(plant, poles, method=method)
    assert (observer.F.diagonal() == -1).all()
    for k in range(0, plant.n - 1, 2):
        block = observer.F[k : k + 2, k : k + 2]
        assert np.linalg.det(block) == pytest.approx(1 + b * b, rel=1e-14)
        assert block[0, 1] * block[1, 0] == pytest.approx(-b * b, rel=1e-14)


@pytest.mark.parametrize("tau", [0.0, np.inf, np.nan])
def test_a_pair_whose_second_row_meets_no_new_state_is_refused(tau):
    A, C, _ = hidden_chains(4, 1)
    form = staircase_form.staircase(A, C)

    def solve(rows, *row):
        x = minimum_norm(rows, *row)
        x[0] = complex(1, tau)
        return x

    with pytest.raises(lb.DesignError, match="the pair -1 .- 2j cannot be given to"):
        a_pair_after(0, form, -1 + 2j, solve)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n", [2, 3, 4, 7, 12])
def test_one_output_with_complex_poles(n, method):
    """The case that the printed block system cannot solve at all."""
    A, C, rng = hidden_chains(n, 1)
    plant = lb.Plant(
        A, rng.standard_normal((n, 2)), C, rng.standard_normal((1, 2)), dt=1.0
    )
    poles = conjugates(n - 1, rng)
    observer = lb.reduced_order_observer(plant, poles, method=method)
    assert not observer.is_complex
    wanted = characteristic(poles)
    assert np.abs(characteristic(observer.poles) - wanted).max() < 1e-13
    certificate = lb.certify(observer, plant)
    assert certificate.stable and certificate.worst < 1e-14


def factor_counting(M, r):
    """Householder factorisation with reflectors of r entries; its multiply-adds."""
    M, count = np.array(M), 0
    n = M.shape[1]
    for j in range(n):
        v = M[j : j + r, j].copy()
        v[0] += np.copysign(np.linalg.norm(v), v[0])
        size = v @ v
        if size:
            below = M[j : j + r, j:]
            below -= np.outer(2 * v / size, v @ below)
            count += 2 * below.size
    return M, count


def test_count_of_one_factorisation():
    """(21): r n^2 with reflectors of r entries, counted on a real M_i."""
    n, r = 240, 4
    A, C, _ = hidden_chains(n, r)
    form = staircase(A, C)
    M = np.vstack([form.A[1:], -form.C])  # M_1 with f = 0
    R, count = factor_counting(M, r)
    assert np.abs(np.tril(R[:n], -1)).max() < 1e-13 and np.abs(R[n:]).max() < 1e-13
    assert count == pytest.approx(figure("one M_i", n=n, r=r), rel=0.02)


@pytest.fixture
def counted(monkeypatch):
    """Multiply-adds of the factorisations from here on, by the sizes of panels."""
    found = []

    def sweep(rows, *row, original=rows_of_T._sweep):
        w, factors = original(rows, *row)
        left = sum(map(len, w))
        for part, Q in zip(w, factors):
            left -= len(part)
            found.append(len(Q) ** 2 * left + len(Q) * len(part) ** 2)
        return w, factors

    monkeypatch.setattr(rows_of_T, "_sweep", sweep)
    return found


@pytest.mark.parametrize("n, p", [(200, 4), (400, 20)])
def test_count_of_minimum_norm_as_run(n, p, counted):
    """Panels of k columns cost (k + r - 1)^2 / k in place of 2 r per column."""
    form = staircase(*hidden_chains(n, p)[:2])
    rows_of(form, np.zeros(n - p, complex), np.zeros(n - p, bool), "minimum-norm")
    k = max(rows_of_T.PANEL, p)
    assert len(counted) >= (n - p) * n / (2 * k)
    assert sum(counted) < (1 + p / k) ** 2 * k / 2 * n**3 / 3 * 1.3


def test_count_of_pairs_as_run(counted):
    """(34), remark 2(a): in real operations twice the rows of (22), half of (34)."""
    n, r = 120, 2
    form, found = staircase(*hidden_chains(n, r)[:2]), []
    for poles in (np.full(n - r, -1.0 + 0j), np.tile([-1 + 1j, -1 - 1j], (n - r) // 2)):
        counted.clear()
        rows_of(form, poles, poles.imag > 0, "minimum-norm")
        found.append(sum(counted))
    real, paired = found[0], 4 * found[1]  # a complex one is four real ones
    all_rows, by_pairs, doubled = (
        figure(name, n=n, r=r)
        for name in ("all rows", "pairs, complex rows", "pairs, doubled real systems")
    )
    assert paired / real == pytest.approx(by_pairs / all_rows, rel=0.02)
    assert paired / real == pytest.approx(doubled / all_rows / 2, rel=0.02)


def test_count_of_the_staircase_as_run(monkeypatch):
    """(23): (3 n + r) n^2 at most, 8/3 n^3 as done."""
    counted = []

    def turn(X, V, S, small, original=staircase_form._turn):
        if V is not None:
            rows, k = X.shape
            counted.append(2 * rows * k * V.shape[1] + rows * V.shape[1] ** 2)
        counted.append(X.shape[0] * len(small) ** 2)
        original(X, V, S, small)

    monkeypatch.setattr(staircase_form, "_turn", turn)
    n, p = 240, 4
    staircase(*hidden_chains(n, p)[:2])
    assert sum(counted) < figure("staircase", n=n, r=p)
    assert sum(counted) == pytest.approx(8 / 3 * n**3, rel=0.1)


@pytest.mark.parametrize("place", errata.entries())
def test_errata_are_tried(place):
    printed, ours = errata.entries()[place]
    assert not vanishes(printed) and vanishes(ours)
