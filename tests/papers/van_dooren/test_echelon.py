"""A staircase form with triangles that can be divided by: the same plant, turned."""

import numpy as np
import pytest

from luenberger.numeric.staircase_form import staircase
from luenberger.papers.van_dooren import rows_of_T


def pair(foot, outputs):
    """Three states: x1 reaches x2, and x3 by `foot`; `outputs` of x2 and x3."""
    A = np.array([[0.3, 0.7, -0.4], [1.0, 0.2, 0.5], [foot, -0.6, 0.1]])
    return A, np.array(outputs, float) @ np.eye(2, 3, k=1)


OUTPUTS = {
    "x2 and x3": [[1, 0], [0, 1]],
    "a third that says the same": [[1, 0], [0, 1], [2, -1]],
    "in other words": [[1, 2], [3, -1], [0.5, 0.7], [1, 1]],
}


def assert_same_plant(form, A, C):
    U, Y = form.U, form.Y
    np.testing.assert_allclose(U.conj().T @ A @ U, form.A, atol=1e-14)
    np.testing.assert_allclose(Y.conj().T @ C @ U, form.C, atol=1e-14)
    np.testing.assert_allclose(U.conj().T @ U, np.eye(len(A)), atol=1e-14)
    np.testing.assert_allclose(Y.conj().T @ Y, np.eye(len(C)), atol=1e-14)


@pytest.mark.parametrize("outputs", OUTPUTS.values(), ids=OUTPUTS)
@pytest.mark.parametrize("kind", [float, complex])
def test_a_form_without_a_foot_is_turned(outputs, kind):
    """The foot is sought in what the library made of it, so many are tried."""
    turned = 0
    for foot in np.linspace(-2, 2, 41):
        A, C = pair(foot, outputs)
        if kind is complex:
            A = A * np.exp(1j * np.outer([0, 1, 2], [1, -1, 0.5]))
        form = staircase(A, C)
        assert_same_plant(form, A, C)
        for width, end in zip(form.blocks, np.cumsum(form.blocks)):
            below = form.A[end:, end - width : end]
            assert not len(below) or np.linalg.matrix_rank(below) == width
        # what has no foot is made: the row of the foot is cleared by a turn
        Q = np.linalg.qr(form.A[1:, :1], mode="complete")[0]
        U, W = form.U.copy(), form.A.copy()
        U[:, 1:], W[:, 1:] = U[:, 1:] @ Q, W[:, 1:] @ Q
        W[1:] = Q.conj().T @ W[1:]
        C_ = form.C.copy()
        C_[:, 1:] = C_[:, 1:] @ Q
        bare = type(form)(**{**vars(form), "U": U, "A": W, "C": C_})
        assert_same_plant(bare, A, C)
        found = rows_of_T.firm(bare)
        turned += found is not bare
        assert_same_plant(found, A, C)
        assert found.blocks == (1, 2)
        assert found.leads.tolist() == [1, 3, 4]
        lead = found.A[1:, 0]
        assert abs(lead[0]) > 0.1 and abs(lead[1]) < 1e-14  # [R; 0], R regular
        corner = found.C[:, 1:]
        assert not np.tril(corner, -1).any() and abs(np.linalg.det(corner[:2])) > 0.1
    assert turned == 41


@pytest.mark.parametrize(("foot", "kept"), [(1.1e-3, True), (0.9e-3, False)])
def test_a_foot_is_judged_beside_the_least_singular_value(foot, kept):
    """[a; foot], of length one; of two columns, the triangle in the last rows."""
    column = np.array([[np.sqrt(1 - foot**2)], [foot]])
    assert bool(rows_of_T._has_foot(column)) is kept
    assert bool(rows_of_T._has_foot(1e9 * column)) is kept
    assert rows_of_T._has_foot(np.array([[1.0, 2], [0, 1e-9]]))  # square: no choice
    wide = np.array([[5.0, 1.0], [1.0, 2.0], [0.0, 3.0]])
    assert rows_of_T._has_foot(wide)
    wide[1, 0] = 0.0
    assert not rows_of_T._has_foot(wide)
