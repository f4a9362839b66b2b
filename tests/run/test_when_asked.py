"""Deviations of rows with one gain are written when somebody asks for them."""

import copy
import pickle
from dataclasses import FrozenInstanceError, fields, replace

import numpy as np
import pytest

import luenberger as lb
from luenberger.recursion import state
from luenberger.run.when_asked import Ending

WALK = lb.Plant([[1.0]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[100]])
Y = np.random.default_rng(5).standard_normal((200, 1))


def found(y=Y, **given):
    return lb.filter_data(WALK, y, backend="numpy", **given)


@pytest.mark.parametrize("history", [False, True])
def test_they_are_those_of_the_full_recursion(history):
    one, full = found(history=history), found(settle=None)
    (row,) = one.settled_at
    assert isinstance(vars(one)["std"], Ending) and row < 100
    assert one.std.shape == (200, 1) and one.std is one.std
    np.testing.assert_allclose(one.std, full.std, rtol=1e-9)
    np.testing.assert_array_equal(one.std[:row], full.std[:row])
    assert (one.std[row:] == one.std[-1]).all()


def test_they_are_those_of_the_covariances():
    one = found(history=True)
    np.testing.assert_allclose(one.std[:, 0] ** 2, one.P[:, 0, 0], rtol=1e-15)


@pytest.mark.parametrize("gap", [50, 120, 198, 199])
def test_rows_before_and_behind_a_gap_have_theirs(gap):
    y = Y.copy()
    y[gap] = np.nan
    one, full = found(y), found(y, settle=None)
    assert len(one.settled_at) and 0 < one.settle_bound < 1e-6
    np.testing.assert_allclose(one.std, full.std, rtol=one.settle_bound)


@pytest.mark.parametrize("gap", [None, 2, 50, 120, 198])
@pytest.mark.parametrize("settle", [1e-9, 1e-17])
def test_room_for_the_first_rows_becomes_room_for_all(monkeypatch, gap, settle):
    """Where there are many numbers; with a tolerance no row has the gain of another."""
    y = Y.copy()
    if gap is not None:
        y[gap] = np.nan
    whole = found(y, settle=settle)
    monkeypatch.setattr(state, "FEW", 20)  # the first look is at row 16
    monkeypatch.setattr(state, "MUCH", 0)
    one = found(y, settle=settle)
    for name in ("x", "std", "P", "settled_at"):
        np.testing.assert_array_equal(getattr(one, name), getattr(whole, name))
    assert bool(len(one.settled_at)) == (settle > 1e-12)


def test_no_room_is_taken_for_rows_that_nobody_asked_for(monkeypatch):
    monkeypatch.setattr(state, "FEW", 30)
    monkeypatch.setattr(state, "MUCH", 0)
    one = found()
    early = vars(one)["std"].early
    assert len(early) == one.settled_at[0] and early.base.nbytes <= 30 * 8


def test_chunks_have_theirs():
    whole = found()
    parts = list(found(iter([Y[k : k + 30] for k in range(0, 200, 30)])))
    joined = np.concatenate([part.std for part in parts])
    np.testing.assert_array_equal(joined, whole.std)


def test_uneven_and_sampled_records_have_theirs():
    plant = lb.Plant([[-1.0]], None, [[1]], Q=[[1]], R=[[1]], P0=[[1]])
    given = dict(time=np.arange(200) * 0.5, backend="numpy")
    one, full = (lb.filter_data(plant, Y, settle=s, **given) for s in (1e-9, None))
    assert len(one.settled_at)
    np.testing.assert_allclose(one.std, full.std, rtol=1e-9)


def test_copies_keep_the_promise():
    wanted = found().std
    for copied in (pickle.loads(pickle.dumps(found())), copy.deepcopy(found())):
        np.testing.assert_array_equal(copied.std, wanted)
    np.testing.assert_array_equal(replace(found(), x=None).std, wanted)
    assert "std" in [field.name for field in fields(found())]
    assert replace(found(), std=None).std is None


def test_a_result_does_not_change():
    one = found()
    with pytest.raises(FrozenInstanceError):
        one.std = None
    with pytest.raises(AttributeError, match="std"):
        getattr(type(one), "std")  # noqa: B009


def test_tables_have_them_at_once():
    pandas = pytest.importorskip("pandas")
    table = pandas.DataFrame(Y, columns=WALK.output_names)
    one = found(table, time="rows")
    np.testing.assert_array_equal(one.std.to_numpy(), found().std)
    assert one.std.attrs["settled_at"] == one.settled_at.tolist() != []
