"""Records in chunks: the same numbers, and no more memory than a chunk takes."""

import tracemalloc
import warnings
from dataclasses import replace

import generators
import numpy as np
import pytest

import luenberger as lb

PLANT = generators.plant(np.random.default_rng(3), 3, 2, m=1)
OBSERVERS = {
    "constant": lb.reduced_order_filter(PLANT, 1),
    "over steps": lb.reduced_order_filter(PLANT, 1, steps=60),
}


def parts(array, sizes):
    return iter(np.split(array, np.cumsum(sizes)[:-1]))


SIZES = [(1,) * 60, (7, 0, 53), (59, 1)]


@pytest.mark.parametrize("sizes", SIZES, ids=["rows", "uneven", "last row"])
@pytest.mark.parametrize("kind", OBSERVERS)
def test_estimates_of_chunks_are_those_of_the_whole(kind, sizes):
    observer = OBSERVERS[kind]
    y, u, u0 = generators.record(np.random.default_rng(4), PLANT, 60)
    start = dict(u0=u0) if kind == "over steps" else dict(x0=[1, 2, 3])
    whole = lb.estimate(observer, y, u, **start)
    chunks = lb.estimate(observer, parts(y, sizes), parts(u, sizes), **start)
    chunks = list(chunks)
    assert [len(chunk) for chunk in chunks] == list(sizes)
    np.testing.assert_allclose(np.concatenate(chunks), whole, rtol=0, atol=1e-13)


ROWS, CHUNKS = 500, 40


def peak(results):
    """Largest memory held while a stream is read, after its first chunks."""
    for _ in range(3):
        next(results)
    tracemalloc.start()
    for _ in results:
        pass
    _, most = tracemalloc.get_traced_memory()
    tracemalloc.stop()
    return most


def zeros(width):
    return (np.zeros((ROWS, width)) for _ in range(CHUNKS))


def test_memory_stays_flat():
    """A chunk with all that is made of it, not the record, which is 40 times that."""
    chunk = ROWS * 8 * (PLANT.p + PLANT.m + 2 * PLANT.n)
    estimates = lb.estimate(OBSERVERS["constant"], zeros(2), zeros(1))
    assert peak(estimates) < 6 * chunk


def test_a_stream_is_read_one_chunk_at_a_time():
    asked = []

    def endless():
        while True:
            asked.append(len(asked))
            yield np.zeros((2, 2))

    results = lb.estimate(OBSERVERS["constant"], endless())
    assert asked == []
    next(results), next(results)
    assert asked == [0, 1]


def test_what_does_not_fit_is_refused_where_it_is_met():
    observer = OBSERVERS["over steps"]
    y = np.zeros((40, 2))
    with pytest.raises(ValueError, match="u must be one too"):
        lb.estimate(observer, iter([y]), np.zeros((40, 1)))
    run = lb.estimate(observer, iter([y, y]))
    next(run)
    with pytest.raises(ValueError, match="y has 80 rows, the filter was designed"):
        next(run)
    run = lb.estimate(observer, iter([y[:1], y[:1]]), iter([np.zeros((1, 1))]))
    next(run)
    with pytest.raises(ValueError, match="u has fewer chunks"):
        next(run)


@pytest.mark.filterwarnings("ignore:Casting complex")
def test_complex_data_are_refused():
    """NumPy would drop the imaginary part, with no more than a warning."""
    plant = lb.Plant([[0.5]], [[1]], [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    observer, y = lb.kalman_filter(plant), np.ones((3, 1))
    for run in (
        lambda: lb.estimate(observer, 1j * y),
        lambda: lb.estimate(observer, y, 1j * y),
        lambda: lb.estimate(observer, y, z0=[1j]),
        lambda: lb.Filter(plant).run(1j * y),
        lambda: lb.Filter(plant).run(lb.Record(y, u0=[1j])),
    ):
        with pytest.raises(ValueError, match="must be .* complex"):
            run()


def test_an_estimate_that_overflows_is_refused_with_its_row():
    """Of an array and of chunks; no warning, and no infinity."""
    observer = lb.Observer(
        [[0.5]], [[]], [[2]], [[1]], [[1.5]], T=[[1]], L=[[1]], dt=1.0,
        state_names=["level"],
    )  # fmt: skip
    y = np.array([[1.0], [1.7e308], [-1.7e308], [1.0]])
    message = "^row 1: the estimate of 'level' overflows; the measurements are too"
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        with pytest.raises(ValueError, match=message):
            lb.estimate(observer, y)
        found = lb.estimate(observer, iter(np.split(y, 4)))
        assert next(found) == [[1.5]]
        with pytest.raises(ValueError, match=message):
            next(found)
    grows = replace(observer, F=[[2.0]])
    with pytest.raises(ValueError, match=r"^row 1023: .* the observer is not stable"):
        lb.estimate(grows, np.ones((1100, 1)))
