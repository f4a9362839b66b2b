"""Something else in the place of a plant or an observer: said in one way by all."""

import inspect

import numpy as np
import pytest

import luenberger as lb
from luenberger import arguments, export, plot

PLANT = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
OBSERVER = lb.kalman_filter(PLANT)
# imported there, for use there
WITHIN = {
    "export.fitted", "export.require_beside", "export.signals", "plot.from_start",
}  # fmt: skip
RIGHT = {"plant": PLANT, "observer": OBSERVER, "source": PLANT}


def functions():
    """Every public function that takes a plant or an observer, by its name."""
    found = {}
    for module in (lb, lb.sampling, export, plot):
        for name, function in vars(module).items():
            if not inspect.isfunction(function) or name.startswith("_"):
                continue
            if function.__module__.startswith("luenberger."):
                places = first_places(function)
                if set(places) & set(arguments.KINDS):
                    found[f"{module.__name__}.{name}".removeprefix("luenberger.")] = (
                        function
                    )
    return {name: found[name] for name in found if name not in WITHIN}


def first_places(function):
    parameters = inspect.signature(function).parameters.values()
    return [one.name for one in parameters if one.kind is one.POSITIONAL_OR_KEYWORD]


def call(function, **values):
    """With the values, right records, and 1 for whatever else is asked for."""
    given = []
    for name, one in inspect.signature(function).parameters.items():
        if one.kind is one.KEYWORD_ONLY and one.default is one.empty:
            values.setdefault(name, 1)
        elif one.kind is one.POSITIONAL_OR_KEYWORD:
            given.append(values.pop(name, RIGHT.get(name, 1)))
    return function(*given, **values)


FUNCTIONS = functions()
DRAWN_FROM_TABLES = {"plot.error_variance": {}, "plot.gains": np.eye(1)}


def test_all_of_them_are_found():
    assert len(FUNCTIONS) >= 24
    assert {"certify", "estimate", "export.to_c", "sampling.simulate"} <= set(FUNCTIONS)


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize(
    "value, got",
    [
        (3, "an int"),
        (None, "None"),
        ([[0.5]], "a list"),
        (np.eye(2), "an array"),
        (lb.Plant, "the class Plant"),
    ],
    ids=["a number", "nothing", "a list", "a matrix", "a class"],
)
def test_says_what_was_expected_in_which_place(name, value, got):
    function = FUNCTIONS[name]
    others = {"shown": DRAWN_FROM_TABLES.get(name)} if name in DRAWN_FROM_TABLES else {}
    for place, one in zip(arguments.PLACES, first_places(function)):
        if one in arguments.KINDS:
            wanted = "(a Plant|an Observer|an Observer or a Plant)"
            said = f"^expected {wanted} in the {place} place, got {got}; .* makes one$"
            with pytest.raises(ValueError, match=said):
                call(function, **{one: value}, **others)


@pytest.mark.parametrize("name", FUNCTIONS)
def test_says_that_a_plant_and_an_observer_are_exchanged(name):
    function = FUNCTIONS[name]
    places = first_places(function)
    if "source" in places or name in DRAWN_FROM_TABLES:
        return  # either will do there
    swapped = {"plant": OBSERVER, "observer": PLANT}
    given = {one: swapped[one] for one in places if one in swapped}
    advice = {
        ("plant",): "give the Plant that it was designed for",
        ("observer",): "a design such as kalman_filter makes one",
    }.get(tuple(given), rf"the order is \({', '.join(given)}\)")
    with pytest.raises(ValueError, match=f"got (a Plant|an Observer); {advice}$"):
        call(function, **given)


@pytest.mark.parametrize("function", [export.to_c, export.to_control])
def test_a_plant_by_keyword(function, tmp_path):
    more = [tmp_path] if function is export.to_c else []
    with pytest.raises(ValueError, match="expected a Plant as plant=, got an Observer"):
        function(OBSERVER, *more, plant=OBSERVER)


def test_a_sweep_names_the_plant_at_fault():
    with pytest.raises(ValueError, match=r"a Plant as plants\['cart'\], got a dict; "):
        lb.sweep({"Kalman": lb.kalman_filter}, {"right": PLANT, "cart": {}})
