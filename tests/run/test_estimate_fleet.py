"""Many records, each with an observer of its own, are what each is by itself."""

import concurrent.futures
import multiprocessing

import generators
import numpy as np
import pytest

import luenberger as lb

PLANT = generators.plant(np.random.default_rng(3), 3, 2, m=1)
OBSERVERS = {
    "constant": lb.reduced_order_filter(PLANT, 1),
    "all outputs exact": lb.reduced_order_filter(PLANT, 2),
    "over steps": lb.reduced_order_filter(PLANT, 1, steps=25),
}
spawn = multiprocessing.get_context("spawn")


@pytest.fixture(scope="module")
def records():
    rng = np.random.default_rng(5)
    return rng.standard_normal((70, 20, 2)), rng.standard_normal((70, 20, 1))


@pytest.fixture(scope="module")
def pools():
    """One of threads, and one of processes."""
    threads = concurrent.futures.ThreadPoolExecutor(3)
    processes = concurrent.futures.ProcessPoolExecutor(2, mp_context=spawn)
    with threads, processes:
        yield threads, processes


@pytest.fixture(params=["numpy", "numba"])
def backend(request):
    if request.param == "numba":
        pytest.importorskip("numba", reason="numba is an optional extra")
    return request.param


@pytest.mark.parametrize("kind", OBSERVERS)
def test_each_record_is_what_it_is_by_itself(kind, records, backend):
    observer, (y, u) = OBSERVERS[kind], records
    start = dict(u0=[0.2]) if kind == "over steps" else dict(x0=[1, 2, 3])
    found = lb.estimate(observer, y, u, backend=backend, **start)
    assert found.shape == (70, 20, 3)
    for k in (0, 33, 69):
        one = lb.estimate(observer, y[k], u[k], backend="numpy", **start)
        np.testing.assert_allclose(found[k], one, rtol=0, atol=1e-12)


def test_bits_do_not_depend_on_records_beside_nor_workers(records, backend, pools):
    observer, (y, u) = OBSERVERS["constant"], records
    whole = lb.estimate(observer, y, u, backend=backend)
    few = lb.estimate(observer, y[5:9], u[5:9], backend=backend)
    np.testing.assert_array_equal(whole[5:9], few)
    for executor in pools:
        how = dict(executor=executor, chunk=1, backend=backend)
        np.testing.assert_array_equal(lb.estimate(observer, y, u, **how), whole)


def test_lists_and_earlier_ends(records, backend):
    observer, (y, u) = OBSERVERS["constant"], records
    short = [y[0], y[1, :7], y[2, :1], y[3, :0]]
    found = lb.estimate(observer, short, backend=backend)
    for one, mine in zip(short, found):
        wanted = lb.estimate(observer, one, backend="numpy")
        np.testing.assert_allclose(mine[: len(one)], wanted, rtol=0, atol=1e-12)
        assert np.isnan(mine[len(one) :]).all()
    np.testing.assert_array_equal(
        lb.estimate(observer, y, u[0], backend=backend),
        lb.estimate(observer, y, [u[0]] * len(y), backend=backend),
    )


def test_into_files_and_functions(records, tmp_path):
    observer, (y, u) = OBSERVERS["constant"], records
    whole, path, parts = lb.estimate(observer, y, u), tmp_path / "all.npz", []
    assert lb.estimate(observer, y, u, chunk=64, into=path) is None
    np.testing.assert_array_equal(np.load(path)["estimates"], whole)
    lb.estimate(observer, y, u, chunk=64, into=lambda *part: parts.append(part))
    assert [first for first, _ in parts] == [0, 64]
    np.testing.assert_array_equal(np.concatenate([part for _, part in parts]), whole)


def test_a_table_has_the_names_of_estimates(records, tmp_path):
    pandas = pytest.importorskip("pandas", reason="the extra `tables`")
    pytest.importorskip("pyarrow", reason="the extra `tables`")
    observer, (y, u) = OBSERVERS["constant"], records
    lb.estimate(observer, y, u, into=tmp_path / "all.parquet")
    found = pandas.read_parquet(tmp_path / "all.parquet")
    assert list(found) == list(observer.estimate_names)
    np.testing.assert_array_equal(
        found.loc[42].to_numpy(), lb.estimate(observer, y, u)[42]
    )


def test_what_is_wrong_is_said(records):
    observer, (y, u) = OBSERVERS["constant"], records
    gap = np.array(y)
    gap[66, 4, 1] = np.nan
    with pytest.raises(ValueError, match="y in record 66, row 4 is missing .*filter_d"):
        lb.estimate(observer, gap, u)
    with pytest.raises(ValueError, match=r"or \(M, N, 2\) for many records"):
        lb.estimate(observer, y[..., :1])
    with pytest.raises(ValueError, match=r"u must be \(70, 20, 1\), or \(20, 1\)"):
        lb.estimate(observer, y, u[:3])
    with pytest.raises(ValueError, match="into is for many records"):
        lb.estimate(observer, y[0], u[0], into="all.npz")
    with pytest.raises(ValueError, match="30 rows, the filter was designed for 25"):
        lb.estimate(OBSERVERS["over steps"], np.zeros((2, 30, 2)))


def test_an_observer_without_outputs_follows_its_inputs(records, backend):
    plant = lb.Plant([[0.5]], [[1]], np.zeros((0, 1)), dt=1.0)
    observer = lb.Observer(
        [[0.5]], [[1]], np.zeros((1, 0)), [[1]], np.zeros((1, 0)), T=[[1]], L=[[1]],
        dt=1.0,
    )  # fmt: skip
    assert lb.certify(observer, plant).worst < 1e-12
    u = records[1][:3]
    found = lb.estimate(observer, np.zeros((3, 20, 0)), u, backend=backend)
    for k in range(3):
        one = lb.estimate(observer, np.zeros((20, 0)), u[k], backend="numpy")
        np.testing.assert_allclose(found[k], one, rtol=0, atol=1e-13)
