"""What is not a number: masked, missing, times, text.  Wherever numbers enter."""

import dataclasses
import datetime
import warnings
from decimal import Decimal
from fractions import Fraction

import numpy as np
import pandas as pd
import pytest
import sympy

import luenberger as lb
from luenberger.numeric import staircase_form
from luenberger.numeric.staircase_form import staircase
from luenberger.papers.kawazoe.reconstruction import reconstruct_state

MASKED = np.ma.array([[999.0]], mask=[[True]])
TIMES = np.array([[1]], "datetime64[ns]")
REFUSED = {
    "a masked entry": (MASKED, r"is missing"),
    "a list of masked rows": ([MASKED[0]], r"is missing"),
    "a masked integer": (np.ma.array([[7]], mask=[[True]]), r"is missing"),
    "the masked constant": ([[np.ma.masked]], "not finite"),
    "None": ([[None]], "is missing"),
    "pandas.NA": ([[pd.NA]], "is missing"),
    "a column with NA": (pd.DataFrame({"a": pd.array([None], "Int64")}), "not finite"),
    "datetime64": (TIMES, "times"),
    "timedelta64": (np.array([[1]], "timedelta64[ns]"), "times"),
    "NaT": (np.array([["NaT"]], "datetime64[s]"), "times"),
    "pandas.NaT": ([[pd.NaT]], "times"),
    "a Timestamp": ([[pd.Timestamp("2020-01-01")]], "times"),
    "a date": ([[datetime.date(2020, 1, 1)]], "times"),
    "a timedelta": ([[datetime.timedelta(1)]], "timedelta"),
    "text": ([["1"]], "text"),
    "bytes": ([[b"1"]], "text"),
    "text among objects": (np.array([["1"]], object), "text"),
    "a column of text": (pd.DataFrame([["1"]]), "text"),
    "truth": ([[True]], "truth values"),
    "truth among objects": (np.array([[True]], object), "truth values"),
    "a letter": ([[sympy.Symbol("a")]], "Cannot convert"),
}
ABSENT = ("a masked entry", "a list of masked rows", "a masked integer")
ABSENT += ("the masked constant", "None", "pandas.NA")
PLANT = dict(A=[[0.5]], B=[[1]], C=[[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])


@pytest.fixture(autouse=True)
def no_warning():
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        yield


def plant(**options):
    return lb.Plant(**PLANT | options)


@pytest.mark.parametrize("name", REFUSED)
def test_no_plant_is_made_of(name):
    value, said = REFUSED[name]
    for key in "ABCQRE":
        with pytest.raises(ValueError, match=f"{key} .*{said}"):
            plant(**{key: value})
    with pytest.raises(ValueError, match=rf"A.*{said}"):
        plant(multiplicative=[(value, [[0]])])


@pytest.mark.parametrize(
    "value",
    [0.5, Decimal("0.5"), Fraction(1, 2), sympy.Rational(1, 2), np.float32(0.5)],
)
def test_every_kind_of_number_makes_one(value):
    for A in ([[value]], np.array([[value]], object), pd.DataFrame([[value]])):
        assert plant(A=A).A == 0.5
    assert plant(A=np.ma.array([[0.5]], mask=[[False]])).A == 0.5


def estimates():
    """Every place where a record or a state is read, as a function of a value."""
    here = plant()
    observer = lb.kalman_filter(here)
    two = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0)
    return {
        "y of a record": lambda X: lb.Filter(here).run(X),
        "u of a record": lambda X: lb.Filter(here).run(lb.Record([[1.0]], X)),
        "u0 of a record": lambda X: lb.Filter(here).run(lb.Record([[1.0]], u0=one(X))),
        "weight": lambda X: lb.Filter(here, weight=X).run([[1.0]]),
        "y of estimate": lambda X: lb.estimate(observer, X),
        "u of estimate": lambda X: lb.estimate(observer, lb.Record([[1.0]], X)),
        "x0 of estimate": lambda X: lb.estimate(observer, [[1.0]], x0=one(X)),
        "z0 of estimate": lambda X: lb.estimate(observer, [[1.0]], z0=one(X)),
        "u of simulate": lambda X: lb.simulate(here, observer, 1, u=one(X)),
        "t of simulate": lambda X: lb.simulate(here, observer, one(X)),
        "x0 of simulate": lambda X: lb.simulate(here, observer, 1, x0=one(X)),
        "claimed": lambda X: lb.monte_carlo(
            here, observer, runs=1, steps=1, seed=1, claimed=X
        ),
        "y of reconstruct_state": lambda X: reconstruct_state(two, [one(X), one(X)]),
        "poles": lambda X: lb.reduced_order_observer(two, one(X)),
        "poles of a functional": lambda X: lb.functional_observer(
            two, [[1, 1]], poles=one(X)
        ),
        "k": lambda X: lb.functional_observer(here, X),
        "L": lambda X: lb.fixed_order_filter(here, 1, L=X),
        "A of staircase": lambda X: staircase(X, [[1]]),
        "periods": lambda X: lb.sampling.discretise(
            lb.Plant([[0]], None, [[1]]), one(X)
        ),
    }


def one(X):
    return X.to_numpy()[0] if isinstance(X, pd.DataFrame) else X[0]


TRUTH = ("truth", "truth among objects")  # a switch may be read as 0 or 1
NAMED = ("a column with NA",)  # a table is read by its columns' names


@pytest.mark.parametrize("place", estimates())
def test_refused_wherever_numbers_enter(place):
    read = estimates()[place]
    for name, (value, _) in REFUSED.items():
        if name in TRUTH + NAMED or (place == "y of a record" and name in ABSENT):
            continue
        with pytest.raises(ValueError):
            read(value)
            pytest.fail(f"{place} took {name}")


@pytest.mark.parametrize("name", ABSENT)
def test_what_is_absent_from_a_record_was_not_measured(name):
    wanted = lb.Filter(plant()).run([[1.0], [np.nan], [2.0]]).x
    found = lb.Filter(plant()).run([[1.0], REFUSED[name][0][0], [2.0]]).x
    np.testing.assert_array_equal(found, wanted)


def test_a_column_with_gaps_was_not_measured_there():
    table = pd.DataFrame({"y1": pd.array([1, None, 2], "Int64")})
    wanted = lb.Filter(plant()).run([[1.0], [np.nan], [2.0]]).x
    np.testing.assert_array_equal(lb.Filter(plant()).run(lb.Record(table, 0)).x, wanted)


@pytest.mark.parametrize("kind", ["datetime64[ns]", "timedelta64[ns]", "str", "object"])
def test_a_column_of_times_or_text_is_refused(kind):
    table = pd.DataFrame({"y1": pd.Series([1, 2]).astype(kind)})
    with pytest.raises(ValueError, match="'y1' of y holds .*, not real numbers"):
        lb.Filter(plant()).run(table)


def test_a_mask_is_kept_in_every_shape_of_a_record():
    wanted = lb.Filter(plant()).run([[1.0], [np.nan]]).x
    mask, y = [False, True], [1.0, 999.0]
    for record in (
        np.ma.array(y, mask=mask),
        np.ma.array(y, mask=mask)[:, None],
        list(np.ma.array(y, mask=mask)[:, None]),
        np.ma.array([1, 999], mask=mask),
        np.ma.array(y, mask=mask, dtype=object),
    ):
        np.testing.assert_array_equal(lb.Filter(plant()).run(record).x, wanted)


def test_a_record_is_read_where_it_is():
    """A long record must not be copied to be looked at."""
    from luenberger.run.checked import rows

    y = np.zeros((5, 1))
    y.setflags(write=False)
    assert np.shares_memory(rows("y", y, 1), y)


@pytest.mark.parametrize(
    "dt", [10**400, np.timedelta64(1, "s"), "1", True, np.nan, -1, 1j, None]
)
def test_a_period_that_is_none(dt):
    with pytest.raises(ValueError, match="dt must be 0 .* or a period in seconds, got"):
        plant(dt=dt)


def test_a_period_too_long_to_be_written():
    with pytest.raises(ValueError, match="int of too many digits"):
        plant(dt=10**5000)


STACK = np.ones((3, 2, 2))
SEEN = lb.Plant(np.diag([0.5, 0.2]), None, np.eye(2), dt=1.0, Q=np.eye(2), R=np.eye(2))
CONSTANT = {
    "multiplicative": lambda: dataclasses.replace(
        SEEN, multiplicative=[(STACK, np.eye(2))]
    ),
    "P0": lambda: dataclasses.replace(SEEN, P0=STACK),
    "L of an observer": lambda: lb.Observer(*[np.eye(2)] * 5, T=np.eye(2), L=STACK),
    "L": lambda: lb.fixed_order_filter(SEEN, 1, L=STACK),
    "L of a comparison": lambda: lb.compare(SEEN, L=STACK),
    "A": lambda: staircase_form.staircase(STACK, np.eye(2)),
}


@pytest.mark.parametrize("name", CONSTANT)
def test_a_stack_is_refused_where_one_matrix_is_meant(name):
    with pytest.raises(ValueError, match=r"must be a matrix; it has shape \(3, 2, 2\)"):
        CONSTANT[name]()
