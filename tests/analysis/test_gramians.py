"""Which directions of a Gramian, and which states of an observer, are but rounding."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.analysis import optimality


def spread(values, angle=0.7):
    """A symmetric matrix with these eigenvalues, turned."""
    turn = np.array([[np.cos(angle), -np.sin(angle)], [np.sin(angle), np.cos(angle)]])
    return turn @ np.diag(values) @ turn.T, turn


@pytest.mark.parametrize("size", [1.0, 1e-20, 1e20])
@pytest.mark.parametrize(("weak", "counts"), [(1.1e-7, True), (0.9e-7, False)])
def test_a_weak_direction_is_left_open(weak, counts, size):
    M, turn = spread([size, weak * size])
    found = optimality._settled(M)
    if counts:
        assert found is None  # all are strong: the formulas of the paper stand
    else:
        strong = turn[:, :1]
        np.testing.assert_allclose(found * size, strong @ strong.T, atol=1e-12)


def test_a_gramian_of_nothing_leaves_all_open():
    np.testing.assert_array_equal(optimality._settled(np.zeros((2, 2))), 0)


@pytest.mark.parametrize("T", [1.0, 1e6])
@pytest.mark.parametrize(("part", "moves"), [(1.05e-14, True), (0.95e-14, False)])
def test_a_state_that_hardly_moves_is_silent(part, moves, T):
    """x and v have the standard deviation 1, T x has T, and z+ = d y has d sqrt(2)."""
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[0.75]], R=[[1.0]])
    d = part * T / np.sqrt(2)
    observer = lb.Observer(
        [[0.0]], np.zeros((1, 0)), [[d]], [[1.0]], [[0.0]], T=[[T]], L=[[1.0]], dt=1.0
    )
    _, (x, z, y) = optimality._moments(observer, plant, np.eye(1))
    assert x == pytest.approx([1.0]) and y == pytest.approx([np.sqrt(2)])
    assert z == pytest.approx([part * T if moves else T], rel=1e-9, abs=0)


@pytest.mark.parametrize("name", ["F", "D", "P", "V", "riccati", "aligned", "trace"])
@pytest.mark.parametrize(("residual", "met"), [(0.9e-8, True), (1.1e-8, False)])
def test_every_condition_of_an_optimum_is_met_to_1e_8(name, residual, met):
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[0.75]], R=[[1.0]])
    found = lb.optimality(lb.kalman_filter(plant), plant)
    object.__setattr__(found, name, residual)
    assert found.worst == residual
    if met:
        assert found.require() is found
    else:
        with pytest.raises(
            lb.CertificateError, match=r"missed by 1\.1e-08, above 1e-08"
        ):
            found.require()
