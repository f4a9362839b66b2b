"""Many records of one plant are what each is by itself."""

import numpy as np
import pytest

import luenberger as lb


def plant_and_records(seed, noisy=True, cross=False, M=5, N=20):
    rng = np.random.default_rng(seed)
    n, p, m = 3, 2, 1
    A, C = rng.standard_normal((n, n)) / 2, rng.standard_normal((p, n))
    root = rng.standard_normal((n + p, n + p)) / 2
    joint = root @ root.T
    R = joint[n:, n:] if noisy else np.zeros((p, p))
    plant = lb.Plant(
        A, rng.standard_normal((n, m)), C, E=rng.standard_normal((p, m)), dt=1.0,
        Q=joint[:n, :n], R=R, P0=np.eye(n), x0=rng.standard_normal(n),
        S=joint[:n, n:] if cross else None,
    )  # fmt: skip
    return plant, rng.standard_normal((M, N, p)), rng.standard_normal((M, N, m))


def alone(*given, **settings):
    """A record by itself, in full, as many records are."""
    return lb.filter_data(*given, settle=None, **settings)


def same(found, one, s):
    for name in ("x", "std", "P", "K"):
        mine, wanted = getattr(found, name), getattr(one, name)
        if wanted is not None:
            scale = np.abs(wanted).max()
            np.testing.assert_allclose(mine[s], wanted, rtol=1e-12, atol=1e-12 * scale)


@pytest.mark.parametrize("history", [False, True])
@pytest.mark.parametrize("seed", range(3))
@pytest.mark.parametrize(
    ("m1", "noisy", "cross"), [(0, True, False), (0, False, False), (0, True, True),
                               (1, True, True)],
)  # fmt: skip
def test_many_records_are_each_by_itself(history, seed, m1, noisy, cross):
    plant, y, u = plant_and_records(seed, noisy, cross)
    y[1, 3:6, 0] = y[1, 9] = np.nan
    y[2, 15:] = y[3] = np.nan  # ends earlier; never measured
    settings = dict(m1=m1, u0=[0.3], history=history)
    found = lb.filter_data(plant, y, u, **settings)
    for s in range(len(y)):
        same(found, alone(plant, y[s], u[s], **settings), s)
    assert len(found) == 5 and "5 records of 20 rows" in repr(found)


def test_bits_do_not_depend_on_the_records_beside_it():
    plant, y, u = plant_and_records(7, cross=True, M=70)
    y[4, 5] = np.nan
    whole = lb.filter_data(plant, y, u)
    order = np.random.default_rng(0).permutation(70)
    mixed = lb.filter_data(plant, y[order], u[order])
    for name in ("x", "std", "P"):
        X = getattr(whole, name)
        np.testing.assert_array_equal(X[order], getattr(mixed, name))
        np.testing.assert_array_equal(
            X[3:5], getattr(lb.filter_data(plant, y[3:5], u[3:5]), name)
        )


def test_one_input_for_all_and_a_continuous_plant():
    plant, y, u = plant_and_records(1)
    found = lb.filter_data(plant, y, u[0])
    same(found, alone(plant, y[2], u[0]), 2)
    walk = lb.Plant([[0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    time = [0, 1, 5, 6]
    found = lb.filter_data(walk, y[:, :4, :1], time=time)
    same(found, alone(walk, y[2, :4, :1], time=time), 2)


def test_what_is_wrong_is_said():
    plant, y, u = plant_and_records(1)
    with pytest.raises(
        ValueError, match=r"or \(M, N, 2\) for many records, got \(5, 20, 1\)"
    ):
        lb.filter_data(plant, y[..., :1])
    with pytest.raises(ValueError, match="for all records"):
        lb.filter_data(plant, y, u[:, :4])
    exact = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]], P0=[[1]])
    with pytest.raises(lb.DesignError, match=r"record 1: at instant 2"):
        lb.filter_data(exact, np.array([[[1.0], [1.0]], [[1.0], [2.0]]]))
