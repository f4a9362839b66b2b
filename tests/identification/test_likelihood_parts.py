"""The likelihood of many records in parts: on any executor, bit for bit the same."""

import concurrent.futures
import multiprocessing

import numpy as np
import pytest

import luenberger as lb
from luenberger import kernels

PLANT = lb.Plant(
    [[1, 0.1], [0, 0.9]], [[0], [0.1]], [[1, 0]], dt=0.1, Q=np.diag([1e-2, 1e-1]),
    R=[[0.4]], P0=np.eye(2),
)  # fmt: skip
BACKENDS = ["numpy"] + ["numba"] * kernels.runs_compiled("auto", 10**9)


@pytest.fixture(scope="module")
def many():
    rng = np.random.default_rng(5)
    y, u = rng.standard_normal((130, 6, 1)), rng.standard_normal((130, 6, 1))
    y[rng.random(y.shape) < 0.1] = np.nan
    y[:, 3] = np.nan  # all have gaps, and so one text
    return y, u


def same(one, other):
    (value, slope), (wanted, slopes) = one, other
    np.testing.assert_array_equal(value, wanted)
    assert slope.keys() == slopes.keys() and slopes
    for name in slopes:
        np.testing.assert_array_equal(slope[name], slopes[name])


@pytest.mark.parametrize("each", [False, True])
@pytest.mark.parametrize("backend", BACKENDS)
def test_executors_change_no_bit(many, backend, each):
    how = dict(backend=backend, gradient=True, each=each)
    wanted = lb.log_likelihood(PLANT, *many, **how)
    for workers in (1, 3):
        with concurrent.futures.ThreadPoolExecutor(workers) as executor:
            same(lb.log_likelihood(PLANT, *many, executor=executor, **how), wanted)


def test_processes_change_no_bit(many):
    spawn = multiprocessing.get_context("spawn")
    how = dict(backend="numpy", gradient=True)
    wanted = lb.log_likelihood(PLANT, *many, **how)
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=spawn) as executor:
        same(lb.log_likelihood(PLANT, *many, executor=executor, **how), wanted)


def test_parts_are_the_sum_of_all(many):
    y, u = many
    alone = [lb.log_likelihood(PLANT, *one) for one in zip(y, u)]
    np.testing.assert_allclose(lb.log_likelihood(PLANT, y, u), sum(alone), rtol=1e-12)
    each = lb.log_likelihood(PLANT, y, u, each=True)
    np.testing.assert_allclose(each, alone, rtol=1e-12)


@pytest.mark.parametrize("each", [False, True])
def test_a_record_behind_the_first_part_is_named(each):
    exact = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]], P0=[[1]])
    y = np.ones((100, 2, 1))
    y[70, 1] = 2  # a state that stays cannot be read as 1 and as 2
    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        with pytest.raises(lb.DesignError, match=r"^record 70: .*instant 2"):
            lb.log_likelihood(exact, y, each=each, executor=executor)


def test_what_is_wrong_is_said(many):
    y, u = many
    with pytest.raises(ValueError, match="executor is for many records"):
        lb.log_likelihood(PLANT, y[0], u[0], executor=3)
    with pytest.raises(ValueError, match="must be a concurrent.futures.Executor"):
        lb.log_likelihood(PLANT, y, u, executor=3)
    assert lb.log_likelihood(PLANT, y[:0], u[:0]) == 0
