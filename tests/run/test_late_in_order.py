"""Late readings that arrive in order: many rows at a time, and still each row's own.

The oracles are the filter in rational arithmetic, and the pass that carries what it
awaits beside the state, which a history asks for.
"""

from dataclasses import replace

import exact_filter
import generators
import numpy as np
import pytest
from as_python import as_python
from generators import holes

import luenberger as lb
from luenberger import kernels
from luenberger.kernels import cache, cost
from luenberger.kernels.program import Assign
from luenberger.recursion import late_step
from luenberger.recursion.late_passage import END, Ends, Stretches, gone_through
from luenberger.recursion.late_passage import SILENT as SILENT_END
from luenberger.recursion.late_stretches import PAIR, ROW, SILENT, Rows, Singles

N = 80  # more than one block of rows, see `late_in_order.SHORT`
OWN = np.arange(float(N))[:, None]


def ragged(rng, longest, shape=(N,)):
    """Arrivals of one output, in order, of which several may be at one row."""
    wait = rng.integers(0, longest, size=shape)
    arrival = np.maximum.accumulate(np.arange(shape[0]) + wait)
    return np.minimum(arrival, np.arange(shape[0]) + longest)


def waits(rng, p):
    """Kinds of arrivals that are in order, for p outputs."""
    late = np.zeros(p)
    late[0] = 1
    found = {
        "on time": OWN + 0 * late,
        "one row": OWN + late,
        "a lag": OWN + 17 * late,
        "every output": OWN + 9 + 0 * late,
        "longer than the record": OWN + 3 * N * late,
        "a burst": np.maximum(OWN, 60 * late),
    }
    found["ragged"] = OWN + 0 * late
    found["ragged"][:, 0] = ragged(rng, 15)
    found["in lots"] = np.where(late > 0, 8 * (OWN // 8) + 7, OWN)
    found["never"] = np.where(OWN % 5 == 2, np.inf, found["a lag"])
    found["at times"] = np.where((OWN // 30) % 2 == 1, found["a lag"], OWN)
    found["at times"][:, 0] = np.maximum.accumulate(found["at times"][:, 0])
    return found


PLANTS = {
    "constant": lambda rng: generators.plant(rng, 3, 2, cross=False),
    "without input": lambda rng: generators.plant(rng, 4, 3, m=0, cross=False),
    "one output": lambda rng: generators.plant(rng, 3, 1, cross=False),
    "P0 of the first row": lambda rng: generators.plant(
        rng, 3, 2, cross=False, at_first=True
    ),
    "time-varying": lambda rng: generators.varying(rng, 3, 2, N, cross=False),
}

SOME = ("a lag", "every output", "ragged", "never", "at times")


def compared(plant, y, u, u0, arrival, **options):
    """The largest difference of x, std and P from those of the other pass."""
    given = dict(u0=u0, arrival=arrival)
    wanted = lb.filter_data(plant, y, u, history=True, **given)
    found = lb.filter_data(plant, y, u, **given, **options)
    np.testing.assert_array_equal(found.orders, wanted.orders)
    return max(
        generators.relative(found.x, wanted.x),
        generators.relative(found.std, wanted.std),
        generators.relative(found.P, wanted.P[-1]),
    )


@pytest.mark.parametrize("kind", PLANTS)
def test_it_is_the_pass_that_carries_what_it_awaits(kind):
    rng = np.random.default_rng(8)
    plant = PLANTS[kind](rng)
    y, u, u0 = generators.record(rng, plant, N)
    found = waits(rng, plant.p)
    for name in found if kind in ("constant", "time-varying") else SOME:
        arrival, gaps = found[name], holes(rng, y) if name != "a lag" else y
        assert compared(plant, gaps, u, u0, arrival) < 1e-12, name


def test_compiled_code_gives_the_same():
    """One kernel of each kind; each way of writing them runs as Python below."""
    pytest.importorskip("numba")
    rng = np.random.default_rng(9)
    plant = generators.plant(rng, 2, 2, cross=False)
    y, u, u0 = generators.record(rng, plant, N)
    arrival = waits(rng, plant.p)["ragged"]
    given = plant, holes(rng, y), u, u0, arrival
    assert compared(*given, backend="numba") < 1e-12


@pytest.fixture(params=["numpy", "scalars", "loops"])
def backend(request, monkeypatch):
    """Compiled code runs as Python, without numba; nothing of it is kept."""
    monkeypatch.setattr(cache, "usable_folder", lambda: None)
    monkeypatch.setattr(kernels, "UNROLLED", 0 if request.param == "loops" else 1000)
    with as_python():
        yield "numpy" if request.param == "numpy" else "numba"


@pytest.mark.parametrize("name", ["a lag", "ragged"])
def test_generated_code_gives_the_same(name, backend):
    rng = np.random.default_rng(9)
    plant = PLANTS["constant"](rng)
    y, u, u0 = generators.record(rng, plant, N)
    y = holes(rng, y) if name == "ragged" else y
    arrival = waits(rng, plant.p)[name]
    assert compared(plant, y, u, u0, arrival, backend=backend) < 1e-12


def test_no_estimate_is_good_from_where_compiled_code_gives_up(backend):
    """P of the second row has lost its digits; what follows is not computed."""
    ones = np.ones((3, 1))
    stretches = Stretches(ones, ones, ones, ones, ones)
    begun = Ends(ones, np.array([[1.0], [-0.5], [1]]), np.ones(3, dtype=bool))
    index, compile = np.arange(3), backend == "numba"
    ends = gone_through(begun, index, stretches, index, compile, silent=False)
    if compile:
        assert not ends.good[1:].any()
    else:
        np.testing.assert_array_equal(ends.good, [True, False, True])


def alone(kind, rng, p):
    """A plant of which every output is late, and when its readings arrive."""
    m = 0 if kind == "without input" else 2
    if kind == "time-varying":
        plant = generators.varying(rng, 3, p, N, cross=False)
    else:
        plant = generators.plant(rng, 3, p, m=m, cross=False)
    return plant, OWN + np.full(p, 9)


@pytest.mark.parametrize("kind", ["constant", "without input", "time-varying"])
def test_readings_that_are_all_late(kind, backend):
    """Nothing is on time, so the stretches say nothing, and their lists are short."""
    rng = np.random.default_rng(3)
    plant, arrival = alone(kind, rng, 1)
    y, u, u0 = generators.record(rng, plant, N)
    assert compared(plant, y, u, u0, arrival, backend=backend) < 1e-12
    assert compared(plant, holes(rng, y), u, u0, arrival, backend=backend) < 1e-12


@pytest.mark.parametrize("length", [1, 11, 64])
def test_a_reading_on_time_after_many_that_are_not(length, backend):
    """What is silent is decided by the rows before, so chunks change no bit."""
    rng = np.random.default_rng(5)
    plant, arrival = alone("constant", rng, 2)
    arrival[50:, 1] = np.arange(50, N)
    y, u, u0 = generators.record(rng, plant, N)
    assert compared(plant, y, u, u0, arrival, backend=backend) < 1e-12
    parts = [slice(k, k + length) for k in range(0, N, length)]
    chunks = lb.filter_data(
        plant, (y[s] for s in parts), (u[s] for s in parts), u0=u0,
        arrival=(arrival[s] for s in parts), backend=backend,
    )  # fmt: skip
    found = [(one.x, one.std) for one in chunks]
    whole = lb.filter_data(plant, y, u, u0=u0, arrival=arrival, backend=backend)
    for k, wanted in enumerate((whole.x, whole.std)):
        parts = np.concatenate([one[k] for one in found])
        assert generators.relative(parts, wanted) < 1e-12
        if backend == "numba":  # of the whole record it is known what never arrives
            np.testing.assert_array_equal(parts[:-1], wanted[:-1])


def test_a_stretch_that_says_nothing_takes_its_part_of_the_operations():
    """What is left of each list where the outputs have no rows."""
    sizes = dict(n=6, m=0, p=1, r=6)
    for whole, short in ((ROW, SILENT[ROW]), (PAIR, SILENT[PAIR]), (END, SILENT_END)):
        few, all_ = (one.lowered(("B",)).program for one in (short, whole))
        assert {type(step) for step in few.steps} == {Assign}  # nothing is solved
        counts = [cost.loops(one, sizes).operations for one in (few, all_)]
        assert counts[0] < 0.75 * counts[1], whole.stages.where


@pytest.mark.parametrize("lag", [0, 2, 5, 30])
@pytest.mark.parametrize("noise", ["all", "some process noise", "none in the process"])
def test_it_is_the_filter_in_rational_arithmetic(lag, noise):
    """With singular Q, and a start that is known in one direction only."""
    rng = np.random.default_rng(lag)
    plant = generators.plant(rng, 3, 2, m=0, cross=False)
    if noise != "all":
        rank = 1.0 if noise == "some process noise" else 0.0
        side = rng.normal(size=(3, 1))
        plant = replace(plant, Q=rank * side @ side.T, P0=np.diag([1.0, 2, 0]))
    y, _, _ = generators.record(rng, plant, 8)
    arrival = OWN[:8] + [lag, 0]
    y[3, 0] = y[5, 1] = np.nan
    arrival[4, 0] = np.nan
    model, known = exact_filter.model(plant), []
    for k in range(8):
        seen = np.where(arrival[: k + 1] <= k, y[: k + 1], np.nan)
        exact = exact_filter.rational(np.nan_to_num(seen))
        exact[np.isnan(seen)] = None
        one = exact_filter.run(model, exact)
        known.append((one.x[-1], one.P[-1]))
    x = np.array([np.array(x, dtype=float).ravel() for x, _ in known])
    P = np.array([np.array(P, dtype=float) for _, P in known])
    run = lb.filter_data(plant, y, arrival=arrival)
    assert generators.relative(run.x, x) < 1e-12
    assert generators.relative(run.P, P[-1]) < 1e-12
    std = np.sqrt(np.diagonal(P, axis1=1, axis2=2))
    assert generators.relative(run.std, std) < 1e-12


@pytest.mark.parametrize("length", [1, 7, 64])
def test_chunks_of_any_length(length):
    rng = np.random.default_rng(4)
    plant = generators.plant(rng, 3, 2, cross=False)
    y, u, u0 = generators.record(rng, plant, N)
    y, arrival = holes(rng, y), waits(rng, 2)["ragged"]
    whole = lb.filter_data(plant, y, u, u0=u0, arrival=arrival)
    parts = [slice(k, k + length) for k in range(0, N, length)]
    chunks = lb.filter_data(
        plant, (y[s] for s in parts), (u[s] for s in parts), u0=u0,
        arrival=(arrival[s] for s in parts),
    )  # fmt: skip
    found = [(one.x, one.std) for one in chunks]
    for k, wanted in enumerate((whole.x, whole.std)):
        parts = np.concatenate([one[k] for one in found])
        assert generators.relative(parts, wanted) < 1e-12


@pytest.mark.parametrize("length", [1, 10])
def test_chunks_carry_their_stretches(length, monkeypatch):
    """The rows that stretches grow by are a few for each row, whatever the lag."""
    counts = []

    def counted(own):
        def wrapped(self, stretches, rows):
            counts.append(len(rows))
            return own(self, stretches, rows)

        return wrapped

    monkeypatch.setattr(Rows, "grown", counted(Rows.grown))
    monkeypatch.setattr(Singles, "before", counted(Singles.before))
    plant = generators.plant(np.random.default_rng(5), 3, 2, m=0, cross=False)
    y, *_ = generators.record(np.random.default_rng(6), plant, N)
    parts = [slice(k, k + length) for k in range(0, N, length)]
    for lag in (5, 50):
        counts.clear()
        arrival = OWN + [lag, 0]
        for _ in lb.filter_data(
            plant, (y[s] for s in parts), arrival=(arrival[s] for s in parts)
        ):
            pass
        assert N < sum(counts) < 3 * N


@pytest.fixture
def singly(monkeypatch):
    """The rows that were done one by one."""
    done, own = [], late_step.step

    def counted(settings, state, row):
        done.append(state.instant)
        return own(settings, state, row)

    monkeypatch.setattr(late_step, "step", counted)
    return done


def test_no_row_is_done_by_itself_while_readings_arrive_in_order(singly):
    rng = np.random.default_rng(5)
    plant = generators.plant(rng, 3, 2, cross=False)
    y, u, u0 = generators.record(rng, plant, N)
    for name, arrival in waits(rng, 2).items():
        lb.filter_data(plant, y, u, u0=u0, arrival=arrival)
        assert not singly, name


def test_a_reading_that_overtakes_others_costs_a_few_rows(singly):
    rng = np.random.default_rng(6)
    plant = generators.plant(rng, 3, 2, cross=False)
    y, u, u0 = generators.record(rng, plant, N)
    arrival = OWN + [10, 0]
    arrival[50, 0] = 53
    assert compared(plant, y, u, u0, arrival) < 1e-12
    lb.filter_data(plant, y, u, u0=u0, arrival=arrival)
    assert 1 <= len(singly) - N <= 2 * 60


@pytest.mark.parametrize("P0", [1e4, 1e8])
def test_a_start_that_is_hardly_known_is_done_row_by_row(P0, singly):
    """Else digits would be lost: later rows say much more than earlier ones."""
    rng = np.random.default_rng(7)
    plant = generators.plant(rng, 3, 2, m=0, cross=False)
    plant = replace(plant, P0=P0 * np.eye(3))
    y, u, u0 = generators.record(rng, plant, 60)
    arrival = OWN[:60] + [6, 0]
    model = exact_filter.model(plant)
    run = lb.filter_data(plant, y, arrival=arrival)
    assert 0 < len(singly) < 60
    for k in (2, 5, 6, 7, 11):
        exact = exact_filter.rational(y[: k + 1])
        exact[arrival[: k + 1] > k] = None
        one = exact_filter.run(model, exact)
        P = np.array(one.P[-1], dtype=float)
        assert generators.relative(run.x[k], np.array(one.x[-1], float).ravel()) < 1e-11
        assert generators.relative(run.std[k], np.sqrt(P.diagonal())) < 1e-11


@pytest.mark.parametrize("power", [-30, 30])
def test_units_are_free(power):
    """To the last bit: no sum mixes numbers of different units."""
    rng = np.random.default_rng(8)
    plant = generators.plant(rng, 3, 2, m=0, cross=False)
    y, _, _ = generators.record(rng, plant, 80)
    unit = np.array([2.0**power, 1, 1])
    other = replace(
        plant, A=plant.A * np.outer(unit, 1 / unit), C=plant.C / unit,
        Q=plant.Q * np.outer(unit, unit), P0=plant.P0 * np.outer(unit, unit),
        x0=plant.x0 * unit,
    )  # fmt: skip
    arrival = OWN[:80] + [20, 0]
    wanted = lb.filter_data(plant, y, arrival=arrival)
    run = lb.filter_data(other, y, arrival=arrival)
    np.testing.assert_allclose(run.x / unit, wanted.x, rtol=0, atol=1e-14)
    np.testing.assert_allclose(run.std / unit, wanted.std, rtol=1e-14, atol=0)
