"""The staircase form (7), (8): stable, echelon, redundant outputs, refusals."""

import numpy as np
import pytest
from pairs import AB01OD, hidden_chains, with_stairs

import luenberger as lb
from luenberger.numeric.staircase_form import staircase

EPS = np.finfo(float).eps


@pytest.mark.parametrize("complex_", [False, True])
@pytest.mark.parametrize(
    "n, p", [(1, 1), (2, 1), (5, 2), (7, 3), (9, 9), (4, 7), (40, 6), (120, 1)]
)
def test_form_is_backward_stable_and_echelon(n, p, complex_):
    rng = np.random.default_rng(n + p)
    A, C = rng.standard_normal((2, max(n, p), n))
    A, C = (A + 1j * A[::-1], C - 1j * C[::-1]) if complex_ else (A, C)
    A, C = A[:n], C[:p]
    form = staircase(A, C)
    U, Y = form.U, form.Y
    sizes = [
        np.linalg.norm(U.conj().T @ A @ U - form.A) / np.linalg.norm(A),
        np.linalg.norm(Y.conj().T @ C @ U - form.C) / np.linalg.norm(C),
        np.linalg.norm(U.conj().T @ U - np.eye(n)) / np.sqrt(n),
        np.linalg.norm(Y.conj().T @ Y - np.eye(p)) / np.sqrt(p),
    ]
    assert max(sizes) < 50 * n * EPS
    both = np.vstack([form.A, form.C])
    last = [np.flatnonzero(both[:, c]).max() for c in range(n)]
    assert (form.leads == last).all() and (np.diff(last) > 0).all()
    assert (form.leads > np.arange(n)).all()
    assert sum(form.blocks) == n and sum(form.indices) == n
    assert form.redundant == max(p - n, 0)
    if p <= n:
        assert (form.Y == np.eye(p)).all()


@pytest.mark.parametrize(
    "sizes", [(1, 2, 3), (2, 2, 3, 3), (1, 1, 1, 5), (3, 3), (1,) * 6]
)
@pytest.mark.parametrize("complex_", [False, True])
def test_stairs_are_found(sizes, complex_):
    A, C = with_stairs(sizes, np.random.default_rng(3), complex_)
    form = staircase(A, C)
    assert form.blocks == sizes and form.rank == sizes[-1]
    # observability indices: the conjugate partition, e.g. (1, 2, 3) -> (3, 2, 1)
    assert form.indices == tuple(
        sum(s >= k for s in sizes) for k in range(1, sizes[-1] + 1)
    )


def test_equal_stairs_have_square_triangles_as_printed():
    A, C, _ = hidden_chains(12, 3)
    form = staircase(A, C)
    for j in range(3):
        block = form.A[3 * j + 3 : 3 * j + 6, 3 * j : 3 * j + 3]
        assert not np.tril(block, -1).any()
    assert not np.tril(form.C[:, 9:], -1).any()


def test_redundant_outputs_are_compressed_and_reported():
    A, C, _ = hidden_chains(9, 2)
    mixed = np.vstack([C, C[0] - 2 * C[1], 1e-7 * C[1]])
    form = staircase(A, mixed)
    assert (form.redundant, form.rank, form.tol) == (2, 2, 10 * 9 * EPS)
    assert not form.C[2:].any()
    assert np.linalg.norm(form.Y.T @ mixed @ form.U - form.C) < 1e-14


def test_rows_of_C_are_judged_at_unit_length():
    A, C, _ = hidden_chains(8, 2)
    assert staircase(A, np.diag([1e-8, 1e8]) @ C).rank == 2


@pytest.mark.parametrize("a, c", [(1e150, 1e-150), (1e-200, 1e200), (1e-8, 1e8)])
def test_no_scale_overflows(a, c):
    A, C, _ = hidden_chains(6, 2)
    form = staircase(a * A, c * C)
    assert form.blocks == (2, 2, 2)
    assert np.abs(form.U.T @ A @ form.U - form.A / a).max() < 1e-14


@pytest.mark.parametrize(
    "A, C, message",
    [
        (np.zeros((0, 0)), np.zeros((1, 0)), "A must not be empty"),
        ([[1, 2, 3], [4, 5, 6]], [[1, 0]], "A must be 2 x 2, got 2 x 3"),
        (np.eye(2), [[1, 0, 0]], "C must be 1 x 2, got 1 x 3"),
        ([[np.nan]], [[1]], "not finite"),
        ([["1"]], [[1]], "array of real numbers"),
    ],
)
def test_wrong_shapes_and_numbers(A, C, message):
    with pytest.raises(ValueError, match=message):
        staircase(A, C)


def test_tolerance_is_the_users():
    A, C = np.diag([1.0, 2.0]), [[1.0, 1e-6]]
    assert staircase(A, C).blocks == (1, 1)
    with pytest.raises(lb.DesignError, match="eigenvalue.s. 2"):
        staircase(A, C, tol=1e-3)
    for tol in (-1, 1, np.nan, "x"):
        with pytest.raises(ValueError, match="tol must be a number in"):
            staircase(A, C, tol=tol)


def test_slicot_ab01od():
    """SLICOT AB01OD example: stairs 2, 2, 1 of the dual pair, four decimals."""
    form = staircase(*AB01OD)
    assert form.blocks == (1, 2, 2)
    for mine, published in [
        (form.C[:, 3:], [[31.1199, 47.6865], [3.248, 0.0]]),
        (form.A[3:, 1:3], [[14.4576, 7.6855], [0, 1.4805]]),
        (form.A[1:3, :1], [[-30.4822, 0.6745]]),
    ]:
        values = [
            np.linalg.svd(X, compute_uv=False) for X in (mine, np.array(published))
        ]
        assert np.abs(values[0] - values[1]).max() < 5e-4


def test_unobservable_modes_are_named_with_their_stability():
    """harold's Kalman decomposition: eigenvalues 2, -3, 2, observability rank 2."""
    A = [[2, 1, 1], [5, 3, 6], [-5, -1, -4]]
    with pytest.raises(
        lb.DesignError, match="-3 of A.*time the stable ones are -3; in"
    ):
        staircase(A, [[1, 0, 0]])
    plant = lb.Plant(A, None, [[1, 0, 0]])
    with pytest.raises(lb.DesignError, match=r"Stable among them: -3\."):
        lb.reduced_order_observer(plant, [-1, -1])
    discrete = lb.Plant(A, None, [[1, 0, 0]], dt=1.0)
    with pytest.raises(lb.DesignError, match=r"Stable among them: none\."):
        lb.reduced_order_observer(discrete, [0, 0])


@pytest.mark.parametrize(
    "A, C, modes",
    [
        (np.zeros((2, 2)), [[1, 0]], "0"),
        (np.diag([1.0, -2, 0.5]), [[1, 0, 0]], "-2, 0.5"),
        (np.eye(3), np.zeros((1, 3)), "1"),
        (np.eye(2), np.zeros((0, 2)), "1"),
        ([[0, 1, 0], [-1, 0, 0], [0, 0, 3]], [[0, 0, 1]], r"0 \+- 1j"),
    ],
)
def test_unobservable_pairs(A, C, modes):
    with pytest.raises(lb.DesignError, match=rf"eigenvalue\(s\) -?{modes} of A"):
        staircase(A, C)


def test_a_mode_on_the_boundary_is_not_called_stable():
    """Two coupled oscillators, seen where the antisymmetric swing is still."""
    A = [[0, 0, 1, 0], [0, 0, 0, 1], [-2, 1, 0, 0], [1, -2, 0, 0]]
    with pytest.raises(lb.DesignError, match="time the stable ones are none; in dis"):
        staircase(A, [[1, 1, 0, 0]])
