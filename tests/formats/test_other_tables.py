"""Tables of Polars, xarray and others: columns are found by name, or refused."""

import numpy as np
import pandas as pd
import pytest
from in_parts import in_parts

import luenberger as lb
from luenberger.papers.kawazoe.reconstruction import reconstruct_state

PLANT = lb.Plant(
    [[0.9, 0.1], [0, 0.8]],
    [[1], [0.5]],
    [[1, 0], [0.2, 1]],
    dt=0.5,
    Q=np.eye(2),
    R=np.diag([0.1, 0.2]),
    P0=np.eye(2),
    output_names=["radar", "angle"],
    input_names=["push"],
)
DRAW = np.random.default_rng(20)
Y, U = DRAW.normal(size=(60, 2)), DRAW.normal(size=(60, 1))
TIME = 3 + 0.5 * np.arange(60)
COLUMNS = {"angle": Y[:, 1], "push": U[:, 0], "radar": Y[:, 0]}
OBSERVER = lb.kalman_filter(PLANT)


class Column:
    """A column of a stand-in for Polars."""

    def __init__(self, values):
        self.to_numpy = lambda: np.asarray(values)


def polars_like(held):
    """A table with what Polars has, of no library that need be installed."""

    class DataFrame:
        shape = (len(next(iter(held.values()))), len(held))
        columns = tuple(held)

        def __getitem__(self, name):
            return Column(held[name])

        def __len__(self):
            return self.shape[0]

        def __array__(self, dtype=None, copy=None):
            return np.stack(list(held.values()), axis=1)

        def to_pandas(self):
            raise ModuleNotFoundError("pyarrow is required")

    DataFrame.__module__ = "polars.dataframe.frame"
    return DataFrame()


def other(columns):
    """A table of a library that turns it into one of pandas."""

    class Table:
        def __array__(self, dtype=None, copy=None):
            return np.stack(list(columns.values()), axis=1)

        def to_pandas(self):
            return pd.DataFrame(columns)

    return Table()


def polars(columns):
    pl = pytest.importorskip("polars")
    return pl.DataFrame(columns)


def xarray(columns):
    xr = pytest.importorskip("xarray")
    values = np.stack(list(columns.values()), axis=1)
    return xr.DataArray(values, dims=("row", "ch"), coords={"ch": list(columns)})


def dataset(columns):
    xr = pytest.importorskip("xarray")
    return xr.Dataset({name: ("row", one) for name, one in columns.items()})


TABLES = [polars_like, other, polars, xarray, dataset]
ASKED = {
    "filter": lambda y, *u: lb.Filter(PLANT).run(lb.Record(y, *u)).x,
    "late": lambda y, *u: (
        lb.Filter(PLANT)
        .run(lb.Record(y, *u, arrival=np.arange(60)[:, None] + [[0, 2]]))
        .x
    ),
    "record": lambda y, *u: lb.Filter(PLANT).run(lb.Record(y, *u)).x,
    "smooth": lambda y, *u: lb.Filter(PLANT).smooth(lb.Record(y, *u)).x,
    "estimate": lambda y, *u: lb.estimate(OBSERVER, lb.Record(y, *u)),
    "likelihood": lambda y, *u: lb.Filter(PLANT).log_likelihood(lb.Record(y, *u)),
    "innovations": lambda y, *u: lb.Filter(PLANT).innovations(lb.Record(y, *u)),
    "fit": lambda y, *u: (
        lb.fit_noise(PLANT, lb.Record(y, *u), Q="diagonal", R="diagonal").plant.R
    ),
    "state": lambda y, *u: reconstruct_state(PLANT, y, *u),
}


@pytest.mark.parametrize("asked", ASKED)
@pytest.mark.parametrize("table", TABLES)
def test_columns_are_found_by_name(table, asked):
    f = ASKED[asked]
    y, u = table({k: COLUMNS[k] for k in ("angle", "radar")}), table({"push": U[:, 0]})
    assert np.array_equal(f(y, u), f(Y, U))
    if asked != "state":  # whose inputs are not looked for among outputs
        assert np.array_equal(f(table(COLUMNS)), f(Y, U))


@pytest.mark.parametrize("table", TABLES)
def test_chunks_and_lists_hold_such_tables(table):
    parts = [{k: v[s] for k, v in COLUMNS.items()} for s in (slice(25), slice(25, 60))]
    found = [one.x for one in in_parts(lb.Filter(PLANT), map(table, parts))]
    assert np.array_equal(
        np.concatenate(found), lb.Filter(PLANT).run(lb.Record(Y, U)).x
    )
    run = lb.Filter(PLANT)
    arrays = lb.Record([Y[:25], Y[25:]], [U[:25], U[25:]])
    both = lb.Record([table(one) for one in parts])
    assert run.log_likelihood(both) == run.log_likelihood(arrays)


@pytest.mark.parametrize("table", TABLES)
def test_a_lacking_column_is_named(table):
    y = table({"angle": Y[:, 1], "sonar": Y[:, 0]})
    with pytest.raises(ValueError, match="no column 'radar'"):
        lb.Filter(PLANT).run(lb.Record(y, U))


@pytest.mark.parametrize("table", [polars_like, polars])
def test_a_column_of_times_is_checked_against_dt(table):
    found = lb.Filter(PLANT).run(table(COLUMNS | {"t": TIME}))
    assert np.array_equal(found.x, lb.Filter(PLANT).run(lb.Record(Y, U)).x)
    assert type(found.x) is pd.DataFrame
    with pytest.raises(ValueError, match="row 1: its time is 1 s after"):
        lb.Filter(PLANT).run(table(COLUMNS | {"t": 2 * TIME}))


def test_xarray_gives_its_times_and_keeps_them():
    xr = pytest.importorskip("xarray")
    y = xr.DataArray(
        Y[:, ::-1],
        dims=("time", "ch"),
        coords={"time": TIME, "ch": ["angle", "radar"]},
    )
    found = lb.Filter(PLANT).run(lb.Record(y, U))
    assert np.array_equal(found.x, lb.Filter(PLANT).run(lb.Record(Y, U)).x)
    assert np.array_equal(found.x.index, TIME)
    with pytest.raises(ValueError, match="row 1: its time is 1 s after"):
        lb.Filter(PLANT).run(lb.Record(y.assign_coords(time=2 * TIME), U))
    bare = y.drop_vars("time")  # a dimension of that name, without times
    assert np.array_equal(lb.Filter(PLANT).run(lb.Record(bare, U)).x, found.x)


def test_xarray_without_names_or_of_many_records():
    xr = pytest.importorskip("xarray")
    with pytest.raises(ValueError, match=r"no column 'radar'; it has \[0, 1\]"):
        lb.Filter(PLANT).run(lb.Record(xr.DataArray(Y), U))
    many = xr.DataArray(np.stack([Y, Y]), dims=("record", "row", "ch"))
    assert lb.Filter(PLANT).run(lb.Record(many, U)).x.shape == (2, 60, 2)
    named = many.assign_coords(ch=["angle", "radar"])
    with pytest.raises(ValueError, match=r"y.sel\(ch=\[...\]\).values"):
        lb.Filter(PLANT).run(lb.Record(named, U))


def test_a_labelled_start_is_found_by_name():
    xr = pytest.importorskip("xarray")
    x0 = xr.DataArray([2.0, 1.0], dims="state", coords={"state": ["x2", "x1"]})
    found = lb.estimate(OBSERVER, lb.Record(Y, U), x0=x0)
    assert np.array_equal(found, lb.estimate(OBSERVER, lb.Record(Y, U), x0=[1.0, 2.0]))


def test_a_column_alone_is_the_one_channel():
    pl = pytest.importorskip("polars")
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    y = pl.Series("any", [1.0, None, 2.0])
    expected = lb.Filter(plant).run([1.0, np.nan, 2.0]).x
    assert np.array_equal(lb.Filter(plant).run(y).x, expected)


def test_what_does_not_become_a_table_is_refused():
    class LazyFrame:
        __module__ = "polars.lazyframe.frame"

        @property
        def columns(self):
            raise AttributeError("collect it")

        def to_numpy(self):
            raise AttributeError("collect it")

    class Slow:
        columns = ("angle", "radar")

    for y in (LazyFrame(), Slow()):
        with pytest.raises(ValueError, match="Give a pandas DataFrame"):
            lb.Filter(PLANT).run(lb.Record(y, U))


def test_arrivals_are_found_by_name():
    late = np.arange(60)[:, None] + [[0, 3]]
    expected = lb.Filter(PLANT).run(lb.Record(Y, U, arrival=late)).x
    y, arrival = polars_like(COLUMNS), polars_like({"angle": late[:, 1]})
    found = lb.Filter(PLANT).run(lb.Record(y, arrival=arrival))
    assert np.array_equal(found.x, expected)
    y = polars_like(COLUMNS | {"t": TIME})
    with pytest.raises(ValueError, match="set_index\\('t'\\)"):
        lb.Filter(PLANT).run(lb.Record(y, arrival=arrival))
