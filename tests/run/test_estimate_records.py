"""`estimate`: its equations, many records, and what is refused."""

import warnings
from dataclasses import replace

import generators
import numpy as np
import pytest

import luenberger as lb

PLANT = generators.plant(np.random.default_rng(3), 3, 2, m=1)
OBSERVERS = {
    "constant": lb.reduced_order_filter(PLANT, 1),
    "all outputs exact": lb.reduced_order_filter(PLANT, 2),
    "over steps": lb.reduced_order_filter(PLANT, 1, steps=60),
}
U0 = {"over steps": dict(u0=[0.2])}


def begun(kind):
    return {} if kind in U0 else dict(x0=[1, 2, 3])


@pytest.fixture
def records():
    rng = np.random.default_rng(5)
    return rng.standard_normal((7, 20, 2)), rng.standard_normal((7, 20, 1))


@pytest.mark.parametrize("kind", OBSERVERS)
def test_each_record_is_what_it_is_by_itself(kind, records):
    observer, (y, u) = OBSERVERS[kind], records
    before = U0.get(kind, {})
    found = lb.estimate(observer, lb.Record(y, u, **before), **begun(kind))
    assert found.shape == (7, 20, 3)
    for mine, *one in zip(found, y, u):
        alone = lb.estimate(observer, lb.Record(*one, **before), **begun(kind))
        np.testing.assert_array_equal(mine, alone)


@pytest.mark.parametrize("kind", OBSERVERS)
def test_estimates_follow_the_equations_of_an_observer(kind, records):
    observer, y, u = OBSERVERS[kind], records[0][0], records[1][0]
    z = observer.z0
    for k, found in enumerate(lb.estimate(observer, lb.Record(y, u))):
        F, G, D, P, V, W = observer.at(k)
        wanted = P @ z + V @ y[k] + W @ u[k]
        np.testing.assert_allclose(found, wanted, rtol=1e-12, atol=1e-12)
        z = F @ z + G @ u[k] + D @ y[k]


def test_a_simulation_begins_with_the_input_before_its_first_row():
    observer, x0, u = OBSERVERS["over steps"], np.array([1.0, -2, 3]), np.ones((20, 1))
    run = lb.simulate(PLANT, observer, 20, u=u, u0=[0.7], x0=x0)
    np.testing.assert_allclose(run.x[0], PLANT.A @ x0 + PLANT.B @ [0.7], rtol=1e-12)
    np.testing.assert_allclose(run.x[1], PLANT.A @ run.x[0] + PLANT.B @ u[0])
    found = lb.estimate(observer, lb.Record(run.y, u, u0=[0.7]))
    np.testing.assert_allclose(run.w_hat, found, rtol=1e-10)


def test_lists_tables_and_one_input_for_all(records):
    observer, (y, u) = OBSERVERS["constant"], records
    several = [y[0], y[1, :7], y[2, :0]]
    found = lb.estimate(observer, lb.Record(several, [u[0], u[1, :7], u[2, :0]]))
    for k, mine in enumerate(found):
        one = lb.estimate(observer, lb.Record(several[k], u[k, : len(mine)]))
        np.testing.assert_array_equal(mine, one)
    whole = lb.estimate(observer, lb.Record(y, u[0]))
    np.testing.assert_array_equal(
        whole, lb.estimate(observer, lb.Record(y, u[[0] * 7]))
    )
    np.testing.assert_array_equal(
        whole, lb.estimate(observer, lb.Record([*y], [u[0]] * 7))
    )
    pandas = pytest.importorskip("pandas", reason="the extra `tables`")
    names = observer.output_names or ["a", "b"]
    tables = [pandas.DataFrame(one, index=range(3, 23), columns=names) for one in y]
    for k, table in enumerate(lb.estimate(observer, lb.Record(tables, 0))):
        assert list(table.index) == [*range(3, 23)]
        alone = lb.estimate(observer, lb.Record(y[k], 0))
        np.testing.assert_array_equal(table.to_numpy(), alone)


def test_what_is_wrong_is_said(records):
    observer, (y, u) = OBSERVERS["constant"], records
    gap = np.array(y)
    gap[6, 4, 1] = np.nan
    with pytest.raises(ValueError, match="y in record 6, row 4 is missing .*Filter"):
        lb.estimate(observer, lb.Record(gap, u))
    with pytest.raises(ValueError, match="record 6: y has values .* first in row 4"):
        lb.estimate(observer, lb.Record([*gap], [*u]))
    with pytest.raises(ValueError, match=r"or \(M, N, 2\) for many records"):
        lb.estimate(observer, y[..., :1])
    with pytest.raises(ValueError, match=r"u must be \(7, 20, 1\), or \(20, 1\)"):
        lb.estimate(observer, lb.Record(y, u[:3]))
    with pytest.raises(ValueError, match="70 rows, the filter was designed for 60"):
        lb.estimate(OBSERVERS["over steps"], np.zeros((2, 70, 2)))
    grows = lb.Observer([[2.0]], [[]], [[2]], [[1]], [[1.5]], T=[[1]], L=[[1]], dt=1.0)
    y = np.zeros((3, 1100, 1))
    y[1] = 1
    with pytest.raises(ValueError, match="record 1: row 1023: .* not stable"):
        lb.estimate(grows, y)


def test_an_observer_without_outputs_follows_its_inputs(records):
    observer = lb.Observer(
        [[0.5]], [[1]], np.zeros((1, 0)), [[1]], np.zeros((1, 0)), T=[[1]], L=[[1]],
        dt=1.0,
    )  # fmt: skip
    u = records[1][:3]
    found = lb.estimate(observer, lb.Record(np.zeros((3, 20, 0)), u))
    for k in range(3):
        one = lb.estimate(observer, lb.Record(np.zeros((20, 0)), u[k]))
        np.testing.assert_array_equal(found[k], one)


@pytest.mark.filterwarnings("ignore:Casting complex")
def test_complex_data_are_refused():
    """NumPy would drop the imaginary part, with no more than a warning."""
    plant = lb.Plant([[0.5]], [[1]], [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    observer, y = lb.kalman_filter(plant), np.ones((3, 1))
    for run in (
        lambda: lb.estimate(observer, 1j * y),
        lambda: lb.estimate(observer, lb.Record(y, 1j * y)),
        lambda: lb.estimate(observer, y, z0=[1j]),
        lambda: lb.Filter(plant).run(1j * y),
        lambda: lb.Filter(plant).run(lb.Record(y, u0=[1j])),
    ):
        with pytest.raises(ValueError, match="must be .* complex"):
            run()


def test_an_estimate_that_overflows_is_refused_with_its_row():
    """There is no warning, and no infinity."""
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
    grows = replace(observer, F=[[2.0]])
    with pytest.raises(ValueError, match=r"^row 1023: .* the observer is not stable"):
        lb.estimate(grows, np.ones((1100, 1)))
