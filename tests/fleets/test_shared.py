"""Deviations that many records share, and the turning of rows into lanes."""

from concurrent.futures import ThreadPoolExecutor

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger import kernels
from luenberger.fleets.block import deviations, one_for_all
from luenberger.kernels import cache, turning
from luenberger.numeric.linalg import finite
from luenberger.run import filter_fleet

needs_numba = pytest.mark.skipif(
    not kernels.runs_compiled("auto", 10**9), reason="numba is an optional extra"
)
# of the sizes and without the zeros of `test_panels`, whose compiled code does it too
PLANT = generators.plant(np.random.default_rng(0), 2, 2, cross=False)
ROOM = np.random.default_rng(0).uniform(1, 4, (5, 3, 2))


def test_deviations_are_roots_of_whoever_has_the_variances():
    room = ROOM.copy()
    room[0, 1, 1] = -1e-17  # rounding
    back = np.array([0, 1, 0, 1, 4])
    found = deviations(room.copy(), back)
    for s, first in enumerate([0, 0, 2, 2, 0]):
        wanted = np.sqrt(np.maximum(room[first], 0))
        np.testing.assert_array_equal(found[s], wanted)
    assert found.flags.writeable


def test_what_all_share_is_there_once():
    room = one_for_all(4, (3, 2))
    room[2] = ROOM[0]
    for variances, back in [(room, [0] * 4), (np.stack([ROOM[0]] * 4), [0, 1, 0, 1])]:
        found = deviations(variances, np.array(back))
        np.testing.assert_array_equal(found, np.stack([np.sqrt(ROOM[0])] * 4))
        assert found.strides[0] == 0 and not found.flags.writeable


def test_a_fleet_without_gaps_holds_one_record_of_deviations(backend):
    y = np.random.default_rng(1).normal(size=(70, 20, 2))
    found = lb.filter_data(PLANT, y, backend=backend)
    assert found.std is found.std and found.std.strides[0] == 0
    with pytest.raises(ValueError, match="read-only"):
        found.std[3] = 0
    one = lb.filter_data(PLANT, y[5], settle=None, backend="numpy")
    np.testing.assert_allclose(found.std[5], one.std, rtol=1e-12)
    y[69, 4] = np.nan
    other = lb.filter_data(PLANT, y, backend=backend)
    np.testing.assert_allclose(other.std[:69], found.std[:69], rtol=1e-12)
    assert (other.std[69, 4] > found.std[69, 4]).all()


def test_deviations_are_worked_out_once(backend):
    """Many ask at the same time; a root is not taken of a root."""
    y = np.random.default_rng(2).normal(size=(70, 20, 2))
    y[np.random.default_rng(3).random(y.shape) < 0.2] = np.nan
    found, wanted = (lb.filter_data(PLANT, y, backend=backend) for _ in range(2))
    with ThreadPoolExecutor(8) as executor:
        asked = list(executor.map(lambda _: found.std, range(64)))
    assert all(one is found.std for one in asked)
    np.testing.assert_array_equal(found.std, wanted.std)
    diagonal = np.sqrt(found.P.diagonal(axis1=1, axis2=2))
    np.testing.assert_allclose(found.std[:, -1], diagonal, rtol=1e-12)


def test_what_is_masked_or_huge_is_looked_at_closely():
    A, unit = [[0.9, 0.1], [0, 0.8]], np.eye(2)
    plant = lb.Plant(A, None, [[1, 0]], dt=1.0, Q=unit, R=[[1]], P0=unit)
    y = np.ma.array(np.ones((3, 4, 1)), mask=np.zeros((3, 4, 1), dtype=bool))
    y.mask[1, 2] = True
    gaps = np.where(y.mask, np.nan, 1.0)
    found, wanted = (lb.filter_data(plant, Y) for Y in (y, gaps))
    np.testing.assert_array_equal(found.x, wanted.x)
    assert finite(np.ones(3)) and not finite(np.array([1, np.nan]))
    assert not finite(np.array([np.inf, -np.inf]))
    huge = np.full((3, 4, 1), 1e308)  # their sum is none of the floats
    assert not finite(huge)
    np.testing.assert_allclose(
        lb.filter_data(plant, huge).x / 1e308,
        lb.filter_data(plant, huge / 1e308).x,
        rtol=1e-12,
    )


TEXT = """
def run(X_, rows_, lanes_):
    for i in range(0, X_.shape[1], 8):
        {how}(X_, rows_, 8, i, lanes_, i * 16 + 8, 16)
"""


@needs_numba
@pytest.mark.parametrize("how", ["to_lanes", "to_rows"])
def test_eight_by_eight_are_turned(how):
    rng = np.random.default_rng(4)
    X, lanes = rng.normal(size=(30, 24)), rng.normal(size=24 * 16)
    rows = rng.permutation(30)[:16]
    run = cache.compiled(TEXT.format(how=how), ("f8[:,::1]", "i8[::1]", "f8[::1]"))
    mine, wanted = (X.copy(), lanes.copy()), (X.copy(), lanes.copy())
    run(mine[0], rows, mine[1])
    inside = wanted[1].reshape(24, 16)[:, 8:]
    if how == "to_lanes":
        inside[:] = X[rows[8:]].T
    else:
        wanted[0][rows[8:]] = inside.T
    for found, right in zip(mine, wanted):
        np.testing.assert_array_equal(found, right)
    plain = X.copy(), lanes.copy()
    step = getattr(turning, f"{how}_in_python")
    for i in range(0, 24, 8):
        step(plain[0], rows, 8, i, plain[1], i * 16 + 8, 16)
    for found, right in zip(plain, wanted):
        np.testing.assert_array_equal(found, right)


@pytest.mark.parametrize("wrong", [np.nan, np.inf])
def test_inputs_are_looked_at_where_no_reading_is_missing(wrong):
    pushed = lb.Plant([[0.9]], [[1]], [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    u = np.ones((3, 4, 1))
    u[1, 2] = wrong
    with pytest.raises(ValueError, match="u in record 1, row 2 is missing or not"):
        lb.filter_data(pushed, np.ones((3, 4, 1)), u)


def test_a_way_is_kept_for_each_thread():
    plant = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    here = filter_fleet.way_of(plant, 0, None)
    assert filter_fleet.way_of(plant, 0, None) is here
    with ThreadPoolExecutor(1) as executor:
        there = executor.submit(filter_fleet.way_of, plant, 0, None).result()
    assert there is not here
