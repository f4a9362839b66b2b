"""Something else in the place of a plant or an observer is a TypeError that says so."""

import inspect

import numpy as np
import pytest

import luenberger as lb
from luenberger import arguments, export, plot

PLANT = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
OBSERVER = lb.kalman_filter(PLANT)
RIGHT = {"plant": PLANT, "observer": OBSERVER, "source": PLANT}
WITHIN = {"signals", "fitted", "from_start"}  # imported there, for use there


def functions():
    """Every public function that takes a plant or an observer, by its name."""
    for module in (lb, lb.sampling, export, plot):
        for name in getattr(module, "__all__", vars(module)):
            one = getattr(module, name)
            ours = getattr(one, "__module__", "").startswith("luenberger.")
            if inspect.isfunction(one) and ours and name[0] != "_":
                if name not in WITHIN and {*places(one)} & {*arguments.KINDS}:
                    yield name, one


def places(function):
    parameters = inspect.signature(function).parameters.values()
    return [one.name for one in parameters if one.kind is one.POSITIONAL_OR_KEYWORD]


FUNCTIONS = dict(functions())
DRAWN_FROM_TABLES = {"error_variance": {}, "gains": np.eye(1)}


def test_all_of_them_are_found():
    assert len(FUNCTIONS) >= 20
    assert {"certify", "estimate", "to_c", "kalman_filter"} <= {*FUNCTIONS}


@pytest.mark.parametrize("name", FUNCTIONS)
@pytest.mark.parametrize("value, got", [([[0.5]], "a list"), (lb.Plant, "the class")])
def test_says_what_was_expected(name, value, got):
    function = FUNCTIONS[name]
    for wrong in {*places(function)} & {*arguments.KINDS}:
        given = dict.fromkeys(places(function), 1) | RIGHT | {wrong: value}
        given |= {"shown": DRAWN_FROM_TABLES.get(name)}
        more = inspect.signature(function).parameters.values()
        needed = [one.name for one in more if one.kind is one.KEYWORD_ONLY]
        called = {one: 1 for one in needed if one in ("runs", "steps", "seed")}
        with pytest.raises(TypeError, match=f"{wrong} must be an? .*, got {got}"):
            function(*(given[one] for one in places(function)), **called)


def test_a_plant_beside_an_observer(tmp_path):
    with pytest.raises(TypeError, match="plant must be a Plant, got an Observer"):
        export.to_c(OBSERVER, tmp_path, plant=OBSERVER)
    with pytest.raises(ValueError, match="leave it out"):
        export.to_control(PLANT, plant=PLANT)
