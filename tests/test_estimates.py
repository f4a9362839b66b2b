"""Estimates by name: combinations of states that are asked for."""

import copy
import pickle

import numpy as np
import pytest

import luenberger as lb
from luenberger.cli import main

ROWS = {"torque (Nm)": [0.0, 60, 120], "drift (rad/s)": [1, -1, 0]}


def shaft(**given):
    """Two speeds and a twist, of which one speed is read."""
    A = [[0.9, 0.05, -0.2], [0.02, 0.95, 0.1], [0.1, -0.1, 1.0]]
    known = dict(dt=0.01, Q=np.diag([0.1, 0.2, 0.01]), R=[[0.01]], P0=np.eye(3))
    called = dict(state_names=["motor", "load", "twist"], output_names=["tacho"])
    B, C = [[0.5], [0], [0]], [[1, 0, 0]]
    return lb.Plant(A, B, C, **known | called | given)


DESIGNS = {
    "Kalman": lambda L: lb.kalman_filter(shaft(), L=L),
    "over steps": lambda L: lb.kalman_filter(shaft(), L=L, steps=4),
    "Leondes-Novak": lambda L: lb.reduced_order_filter(shaft(), 1, L=L),
    "fixed order": lambda L: lb.fixed_order_filter(shaft(), 2, L=L, starts=2),
    "Van Dooren": lambda L: lb.reduced_order_observer(shaft(), [0.2, 0.3], L=L),
    "Kawazoe": lambda L: lb.deadbeat_observer(shaft(), L=L),
    "Moore": lambda L: lb.functional_observer(shaft(), L),
}


@pytest.mark.parametrize("name", DESIGNS)
def test_every_design_takes_rows_by_name(name, tmp_path):
    one = DESIGNS[name](ROWS)
    assert (one.L == [*ROWS.values()]).all() and one.estimate_names == tuple(ROWS)
    one.to_json(tmp_path / "one.json")
    again = lb.Observer.from_json(tmp_path / "one.json")
    assert again.estimates == tuple(ROWS) and again.state_names == shaft().state_names
    assert one.named(shaft(state_names=["a", "b", "c"])).estimate_names == tuple(ROWS)
    picked = DESIGNS[name](["twist"])
    assert picked.estimate_names == ("twist",) and (picked.L == [[0, 0, 1]]).all()


def test_forms_and_combinations_are_named():
    one = lb.kalman_filter(shaft(), L=ROWS)
    assert one.modal().estimate_names == one.companion().estimate_names == tuple(ROWS)
    assert one.combined({"half": [0.5, 0]}).estimate_names == ("half",)
    assert one.combined([0.5, 0]).estimate_names == ("w1",)


def test_names_stand_in_the_exported_source_and_in_data_frames(tmp_path):
    pandas = pytest.importorskip("pandas")
    one = lb.kalman_filter(shaft(), L=ROWS)
    _, header = lb.export.to_c(one, tmp_path, name="shaft")
    assert '[0]  "torque (Nm)"' in header.read_text()
    record = pandas.DataFrame({"tacho": [0.0, 1], "u1": [0, 0]})
    found = lb.estimate(one, lb.Record(record[["tacho"]], record[["u1"]]))
    assert list(found.columns) == [*ROWS]


def test_a_plant_keeps_its_estimates(tmp_path):
    plant = shaft(estimates=ROWS)
    plant.to_json(tmp_path / "plant.json")
    assert '"estimates": {"torque (Nm)": [0.0, 60.0, 120.0]' in (
        (tmp_path / "plant.json").read_text()
    )
    again = lb.Plant.from_json(tmp_path / "plant.json")
    for one in (again, copy.deepcopy(plant), pickle.loads(pickle.dumps(plant))):
        assert {k: row.tolist() for k, row in one.estimates.items()} == ROWS
        with pytest.raises(ValueError, match="read-only"):
            one.estimates["torque (Nm)"][0] = 1
    assert lb.kalman_filter(plant, L="torque (Nm)").L.tolist() == [[0, 60, 120]]
    assert "estimates" not in repr(lb.kalman_filter(plant).estimate_names)
    assert (lb.kalman_filter(plant).L == np.eye(3)).all()  # asked for nothing


@pytest.mark.parametrize(
    "given, message",
    [
        ([[1, 0, 0]], "estimates must be combinations of the states by name"),
        ({"a": [1, 0]}, r"estimates\['a'\] must have shape \(3,\)"),
        ({"a": [1, 0, np.inf]}, r"estimates\['a'\] has entries that are not finite"),
        ({"": [1, 0, 0]}, "estimate names must be"),
        ({"a\nb": [1, 0, 0]}, "must be one line of text"),
    ],
)
def test_estimates_that_are_none_are_refused(given, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        shaft(estimates=given)


@pytest.mark.parametrize(
    "asked, message",
    [
        (
            "speed",
            r"no estimate or state 'speed'; there are \['motor', 'load', 'twist'",
        ),
        (["twist", "twist"], "2 different strings"),
        (["twist", 1], "no estimate or state 1"),
        ({"a": [1, 2]}, "must be 1 x 3, got 1 x 2"),
    ],
)
@pytest.mark.parametrize("name", DESIGNS)
def test_what_is_asked_for_is_checked(name, asked, message):
    with pytest.raises(ValueError, match=message):
        DESIGNS[name](asked)


def test_names_have_to_fit_the_rows():
    parts = [[0.5]], [[]], [[1]], [[1]], [[0]], [[1]], [[1]]
    with pytest.raises(ValueError, match="estimate names must be 1 different strings"):
        lb.Observer(*parts, estimates=["a", "b"])


METHODS = ["Kalman filter", "deadbeat observer"]


def test_a_comparison_asks_for_the_plants_estimates():
    named = shaft(estimates=ROWS)
    few = lb.candidates(named, methods=METHODS)
    table = lb.compare(named, few)
    assert table.rows.tolist() == [*ROWS.values()] and table.estimates == tuple(ROWS)
    said = " ".join(table.reasons(100))
    assert any(name in said for name in ROWS) and "row 1" not in said
    assert {one.observer.estimate_names for one in table.designs} == {tuple(ROWS)}
    other = lb.compare(named, few, L=np.eye(3)[:1])
    assert other.estimates == ("row 1 of L x",)
    whole = lb.compare(shaft(), few)
    assert whole.rows is None and whole.estimates == whole.plant.state_names


def call(capsys, *line):
    try:
        status = main([*line])
    except SystemExit as end:
        status = end.code
    return status or 0, *capsys.readouterr()


def test_estimates_on_the_command_line(tmp_path, capsys):
    import json

    shaft().to_json(tmp_path / "plain.json")
    shaft(estimates=ROWS).to_json(tmp_path / "named.json")
    plain, named = (str(tmp_path / f"{name}.json") for name in ("plain", "named"))
    line = "torque (Nm)=0,60,120; drift (rad/s)=1,-1,0"
    asked = ["--orders=3", "--json"]
    status, one, _ = call(capsys, "compare", plain, "--k", line, *asked)
    other = call(capsys, "compare", named, *asked)[1]
    assert status == 0 and json.loads(one)["designs"] == json.loads(other)["designs"]
    assert json.loads(one)["estimates"] == [*ROWS]
    rows = call(capsys, "compare", plain, "--k=0,60,120;1,-1,0", *asked)[1]
    assert json.loads(rows)["k"] == json.loads(one)["k"]
    twist = call(capsys, "compare", plain, "--k=twist", *asked)[1]
    assert json.loads(twist)["k"] == [[0, 0, 1]]
