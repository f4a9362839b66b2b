"""Many records in parts: executors, files, functions, and what is refused."""

import concurrent.futures
import multiprocessing
import os
import tracemalloc
from pathlib import Path

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.run import fleet_tasks
from luenberger.run.executor import in_order

PLANT = lb.Plant(
    [[1, 0.1], [0, 1]], [[0], [0.1]], [[1, 0]], dt=0.1, Q=np.diag([1e-4, 1e-2]),
    R=[[0.04]], P0=np.eye(2), state_names=["level", "slope"],
)  # fmt: skip
# of the sizes and without the zeros of tests/fleets, whose compiled code does it too
DENSE = generators.plant(np.random.default_rng(0), 2, 2, cross=False)
spawn = multiprocessing.get_context("spawn")
FIELDS = ("x", "std", "P")


@pytest.fixture(scope="module")
def fleet():
    rng = np.random.default_rng(2)
    y, u = rng.standard_normal((150, 12, 1)), rng.standard_normal((150, 12, 1))
    y[rng.random(y.shape) < 0.1] = np.nan
    y[3, 7:] = np.nan  # ends earlier
    return y, u


@pytest.fixture(scope="module")
def alone(fleet):
    return lb.filter_data(PLANT, *fleet, backend="numpy")


def same(found, wanted):
    for name in FIELDS:
        np.testing.assert_array_equal(getattr(found, name), getattr(wanted, name))


@pytest.mark.parametrize("chunk", [None, 1, 100, 1000])
@pytest.mark.parametrize("workers", [1, 3])
def test_threads_change_no_bit(fleet, alone, workers, chunk):
    with concurrent.futures.ThreadPoolExecutor(workers) as executor:
        how = dict(executor=executor, chunk=chunk, backend="numpy")
        same(lb.filter_data(PLANT, *fleet, **how), alone)


def test_processes_change_no_bit_and_take_inputs_for_all(fleet, alone):
    y, u = fleet
    shared = lb.filter_data(PLANT, y, u[0], backend="numpy")
    with concurrent.futures.ProcessPoolExecutor(2, mp_context=spawn) as executor:
        how = dict(executor=executor, backend="numpy")
        same(lb.filter_data(PLANT, y, u, **how), alone)
        same(lb.filter_data(PLANT, y, u[0], **how), shared)


def test_a_dask_client_changes_no_bit(fleet, alone):
    distributed = pytest.importorskip("distributed", reason="the extra `cluster`")
    local = dict(n_workers=2, processes=False, dashboard_address=None)
    with distributed.LocalCluster(**local) as cluster:
        with distributed.Client(cluster) as client:
            how = dict(executor=client.get_executor(), backend="numpy")
            same(lb.filter_data(PLANT, *fleet, **how), alone)


def of_two_outputs(fleet):
    """The records, each with another one as its second output."""
    y, u = fleet
    return np.concatenate([y, y[::-1]], axis=2), u


def test_compiled_threads_change_no_bit(fleet):
    pytest.importorskip("numba", reason="numba is an optional extra")
    given = DENSE, *of_two_outputs(fleet)
    wanted = lb.filter_data(*given, backend="numba")
    with concurrent.futures.ThreadPoolExecutor(3) as executor:
        how = dict(executor=executor, backend="numba")
        same(lb.filter_data(*given, **how), wanted)


# -- where results go ------------------------------------------------------------------


def test_a_function_gets_the_parts_in_order(fleet, alone):
    parts = []
    with concurrent.futures.ThreadPoolExecutor(3) as executor:
        done = lb.filter_data(
            PLANT, *fleet, backend="numpy", chunk=64, executor=executor,
            into=lambda first, found: parts.append((first, found)),
        )  # fmt: skip
    assert done is None
    assert [(first, len(found)) for first, found in parts] == [
        (0, 64), (64, 64), (128, 22),
    ]  # fmt: skip
    for name in FIELDS:
        whole = np.concatenate([getattr(found, name) for _, found in parts])
        np.testing.assert_array_equal(whole, getattr(alone, name))


class _AtOnce(concurrent.futures.ThreadPoolExecutor):
    """Does a job as soon as it gets it, so as far ahead as it may be."""

    def submit(self, function, /, *arguments):
        done = concurrent.futures.Future()
        done.set_result(function(*arguments))
        return done


both = pytest.mark.parametrize("backend", ["numpy", "numba"])


@both
@pytest.mark.parametrize("history", [False, True])
@pytest.mark.parametrize("executor", [None, _AtOnce(1), _AtOnce(2)])
def test_parts_may_have_the_memory_of_earlier_ones(fleet, executor, history, backend):
    if backend == "numba":
        pytest.importorskip("numba", reason="numba is an optional extra")
    y, u = (np.concatenate([X] * 5) for X in of_two_outputs(fleet))
    y[64:200] = 1.0  # parts without gaps, behind one with gaps and before some
    how = dict(backend=backend, history=history, chunk=64, executor=executor)
    wanted, parts, places = lb.filter_data(DENSE, y, u, **how), [], []

    def copied(first, found):
        places.append(found.x.__array_interface__["data"][0])
        kept = {name: getattr(found, name) for name in FIELDS + ("K",) * history}
        parts.append({name: X.copy() for name, X in kept.items()})

    assert lb.filter_data(DENSE, y, u, into=copied, reuse=True, **how) is None
    assert [len(one["x"]) for one in parts] == [64] * 11 + [46]
    for name in parts[0]:
        whole = np.concatenate([one[name] for one in parts])
        np.testing.assert_array_equal(whole, getattr(wanted, name), err_msg=name)
    rooms = 1 if executor is None else 1 + 2 * executor._max_workers
    assert len(set(places)) == rooms
    assert places == (places[:rooms] * 12)[:12]


def test_parts_have_memory_of_their_own_unless_it_is_said(fleet, alone):
    parts = []
    lb.filter_data(
        PLANT,
        *fleet,
        backend="numpy",
        chunk=64,
        into=lambda first, found: parts.append(found),
    )
    for name in FIELDS:  # they are read when all are there
        whole = np.concatenate([getattr(found, name) for found in parts])
        np.testing.assert_array_equal(whole, getattr(alone, name))


@pytest.mark.parametrize("history", [False, True])
def test_an_npz_file_has_the_arrays(fleet, tmp_path, history):
    how = dict(backend="numpy", history=history)
    wanted, path = lb.filter_data(PLANT, *fleet, **how), tmp_path / "fleet.npz"
    assert lb.filter_data(PLANT, *fleet, chunk=64, into=path, **how) is None
    with np.load(path) as found:
        assert set(found) == {"x", "std", "P", *(["K"] if history else [])}
        for name in found:
            np.testing.assert_array_equal(found[name], getattr(wanted, name))
    assert os.listdir(tmp_path) == ["fleet.npz"]


def test_a_parquet_file_is_a_table(fleet, alone, tmp_path):
    pandas = pytest.importorskip("pandas", reason="the extra `tables`")
    pytest.importorskip("pyarrow", reason="the extra `tables`")
    path = tmp_path / "fleet.parquet"
    lb.filter_data(PLANT, *fleet, backend="numpy", chunk=64, into=str(path))
    found = pandas.read_parquet(path)
    assert found.index.names == ["record", "instant"]
    assert list(found) == ["level", "slope", "level_sigma", "slope_sigma"]
    x = found[["level", "slope"]].to_numpy().reshape(alone.x.shape)
    np.testing.assert_array_equal(x, alone.x)
    np.testing.assert_array_equal(found.loc[(3, 12)].to_numpy()[2:], alone.std[3, 11])


def test_a_file_without_its_packages_is_refused(fleet, tmp_path, monkeypatch):
    monkeypatch.setitem(__import__("sys").modules, "pyarrow", None)
    with pytest.raises(ImportError, match=r"luenberger\[tables\].*\.npz"):
        lb.filter_data(PLANT, *fleet, into=tmp_path / "fleet.parquet")
    assert os.listdir(tmp_path) == []


def test_two_columns_of_one_name_are_refused(fleet, tmp_path):
    pytest.importorskip("pyarrow", reason="the extra `tables`")
    from dataclasses import replace

    plant = replace(PLANT, state_names=["x", "x_sigma"])
    with pytest.raises(ValueError, match="'x_sigma' would be the name of two columns"):
        lb.filter_data(plant, *fleet, into=tmp_path / "fleet.parquet")


def test_memory_is_for_a_few_parts(tmp_path):
    """An array on disk is read, and a file written, a part at a time."""
    M, N = 1280, 40
    y = np.lib.format.open_memmap(tmp_path / "y.npy", "w+", float, (M, N, 1))
    y[:] = np.random.default_rng(0).standard_normal(y.shape)
    y.flush()
    del y
    y = np.load(tmp_path / "y.npy", mmap_mode="r")
    how = dict(backend="numpy", chunk=64, into=tmp_path / "fleet.npz")
    lb.filter_data(PLANT, y[:64], **how)
    tracemalloc.start()
    lb.filter_data(PLANT, y, **how)
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    whole = (tmp_path / "fleet.npz").stat().st_size
    assert most < whole / 4


def test_an_executor_has_a_few_parts_at_a_time():
    """Parts are made when there is room for them, not all at once."""
    made, done = [], []

    def jobs():
        for k in range(20):
            made.append(k)
            assert len(made) - len(done) <= 4  # one more than `ahead`: it is next
            yield k

    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        for k in in_order(abs, jobs(), executor, 3):
            done.append(k)
    assert done == made == list(range(20))


# -- what is refused -------------------------------------------------------------------


@pytest.mark.parametrize(
    ("how", "said"),
    [
        (dict(executor=3), "executor must be a concurrent.futures.Executor"),
        (dict(into=3), "into must be a function of .* or the path of a file, got 3"),
        (dict(into="fleet.csv"), r"ends in \.npz or \.parquet, got 'fleet.csv'"),
        (dict(chunk=0), "chunk must be a number of records, got 0"),
        (dict(chunk=True), "chunk must be a number of records, got True"),
        (dict(arrival=[[0]]), "arrival is for one record"),
        (dict(reuse=True), "reuse=True is for into=FUNCTION"),
        (dict(reuse=True, into="fleet.npz"), "reuse=True is for into=FUNCTION"),
        (dict(reuse=1, into=print), "reuse must be True or False, got 1"),
    ],
)
def test_what_is_wrong_is_said(fleet, how, said):
    with pytest.raises(ValueError, match=said):
        lb.filter_data(PLANT, *fleet, **how)


def test_a_file_that_cannot_be_written_is_said_first(fleet, tmp_path, monkeypatch):
    monkeypatch.setattr(fleet_tasks, "_do", None)  # nothing is filtered before
    missing = tmp_path / "missing" / "fleet.npz"
    with pytest.raises(FileNotFoundError, match="missing/fleet.npz"):
        lb.filter_data(PLANT, *fleet, into=missing)
    (tmp_path / "folder.npz").mkdir()
    with pytest.raises(ValueError, match="is a folder; name a file"):
        lb.filter_data(PLANT, *fleet, into=tmp_path / "folder.npz")


def test_what_is_for_many_records_is_refused_for_one(fleet):
    calls = dict(executor=3), dict(chunk=5), dict(into="fleet.npz")
    for how in (*calls, dict(into=print, reuse=True)):
        name = next(iter(how))
        with pytest.raises(ValueError, match=f"{name} is for many records"):
            lb.filter_data(PLANT, fleet[0][0], fleet[1][0], **how)


def test_a_record_that_fails_is_named_and_nothing_is_written(tmp_path):
    exact = lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]], P0=[[1]])
    y = np.ones((100, 2, 1))
    y[70, 1] = y[90, 1] = 2  # a state that stays cannot be read as 1 and as 2
    path = tmp_path / "fleet.npz"
    path.write_bytes(b"old")
    with concurrent.futures.ThreadPoolExecutor(2) as executor:
        with pytest.raises(lb.DesignError, match=r"^record 70: at instant 2.*y\[k\]"):
            lb.filter_data(exact, y, chunk=1, executor=executor, into=path)
    assert path.read_bytes() == b"old" and os.listdir(tmp_path) == ["fleet.npz"]
    with pytest.raises(lb.DesignError, match="P0") as refused:  # is of the plant
        lb.filter_data(lb.Plant([[1]], None, [[1]], dt=1.0, Q=[[0]], R=[[0]]), y)
    assert "one by one" not in str(refused.value)


# -- lists -----------------------------------------------------------------------------


def test_a_list_of_records_is_an_array_of_them(fleet, alone):
    y, u = fleet
    for kind in (list, np.ndarray.tolist):
        found = lb.filter_data(PLANT, kind(y), kind(u), backend="numpy")
        same(found, alone)


def test_shorter_records_of_a_list_end_earlier(fleet):
    y, u = fleet
    lengths = [12, 5, 9]
    short = [one[:rows] for one, rows in zip(y, lengths)]
    inputs = [one[:rows] for one, rows in zip(u, lengths)]
    found = lb.filter_data(PLANT, short, inputs, backend="numpy")
    assert found.x.shape == (3, 12, 2)
    for k, rows in enumerate(lengths):
        one = lb.filter_data(PLANT, short[k], inputs[k], settle=None)
        np.testing.assert_allclose(found.x[k, :rows], one.x, rtol=0, atol=1e-13)
    assert np.isfinite(found.x).all()
    assert (np.diff(found.std[1, 5:, 1]) > 0).all()  # nothing is read any more


@pytest.mark.parametrize(
    ("y", "u", "said"),
    [
        ([np.zeros((3, 1)), np.zeros((3, 2))], None, r"record 1 of y must be \(N, 1\)"),
        ([np.zeros((3, 1))], [np.zeros((2, 1))], "record 0: y has 3 rows but u has 2"),
        ([np.zeros((3, 1))], [np.zeros((3, 1))] * 2, "y has 1 records but u has 2"),
        (np.zeros((2, 3, 4, 1)), None, r"or \(M, N, 1\) for many records, got"),
        (np.zeros((2, 3, 2)), None, r"or \(M, N, 1\) for many records, got"),
        (np.zeros((2, 3, 1)), np.zeros((2, 1)), r"u must be \(2, 3, 1\), or \(3, 1\)"),
        (np.zeros((2, 3, 1)), np.zeros((3, 3, 1)), r"u must be \(2, 3, 1\)"),
        ([[[0.0], ["a"]]], None, "record 0 of y must be an array of numbers"),
    ],
)
def test_shapes_that_do_not_fit_are_said(y, u, said):
    with pytest.raises(ValueError, match=said):
        lb.filter_data(PLANT, y, u)


def test_numbers_that_are_none_are_said_with_record_and_row(fleet):
    y, u = (np.array(X) for X in fleet)
    y[100, 4] = np.inf
    with pytest.raises(ValueError, match="y in record 100, row 4 is infinite"):
        lb.filter_data(PLANT, y, u, chunk=64, into=lambda first, found: None)
    u[90, 2] = np.nan
    with pytest.raises(ValueError, match="u in record 90, row 2 is missing or not"):
        lb.filter_data(PLANT, fleet[0], u)
    with pytest.raises(ValueError, match="u in row 2 is missing or not finite"):
        lb.filter_data(PLANT, fleet[0], u[90])


def test_a_list_of_tables_is_refused():
    pandas = pytest.importorskip("pandas", reason="the extra `tables`")
    tables = [pandas.DataFrame({"y1": [1.0, 2.0]})] * 2
    with pytest.raises(ValueError, match="record 0 of y is a table, .*to_numpy"):
        lb.filter_data(PLANT, tables)


def test_records_without_a_reading_are_predictions(fleet):
    y, u = fleet
    y = np.full_like(y[:2], np.nan)
    found = lb.filter_data(PLANT, y, u[:2])
    x, before = np.zeros((2, 2)), np.zeros((2, 1))
    for k in range(12):
        x, before = x @ PLANT.A.T + before @ PLANT.B.T, u[:2, k]
        np.testing.assert_allclose(found.x[:, k], x, rtol=0, atol=1e-14)


def test_no_records_are_no_result(tmp_path):
    found = lb.filter_data(PLANT, np.zeros((0, 5, 1)))
    assert found.x.shape == (0, 5, 2) and len(found) == 0
    lb.filter_data(PLANT, np.zeros((0, 5, 1)), into=tmp_path / "none.npz")
    assert np.load(tmp_path / "none.npz")["P"].shape == (0, 2, 2)
    assert Path(tmp_path / "none.npz").is_file()
