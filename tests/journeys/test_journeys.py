"""Five jobs from end to end, each a script as short as the library allows today."""

import pathlib
import runpy
import sys

import pytest

HERE = pathlib.Path(__file__).parent
NO_SCRIPTS = {"conftest.py", pathlib.Path(__file__).name}
SCRIPTS = sorted(path for path in HERE.glob("*.py") if path.name not in NO_SCRIPTS)


@pytest.mark.parametrize("script", SCRIPTS, ids=[path.stem for path in SCRIPTS])
def test_a_journey_ends_where_the_true_plant_says(script, monkeypatch):
    """Its numbers agree with simulations of the plant; the script asserts it."""
    monkeypatch.setattr(sys, "argv", [str(script)])
    runpy.run_path(str(script), run_name="__main__")


def test_all_five_are_there():
    assert len(SCRIPTS) == 5
