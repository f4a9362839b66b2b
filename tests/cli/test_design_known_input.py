"""`design --U`: what is known of the known input, in designs, report and files."""

import csv
import json
import pathlib
import sys

import numpy as np
import pytest

import luenberger as lb
from luenberger.cli import main

OVEN = lb.Plant(
    [[0.9, 0.05], [0.1, 0.85]], [[0.1], [0.2]], [[1, 0]], dt=1.0,
    Q=np.eye(2) / 50, R=[[0.1]], P0=np.eye(2), input_names=["power (kW)"],
    state_names=["air (K)", "wall (K)"], output_names=["air (K)"],
)  # fmt: skip
MODEL = lb.Plant([[0.8]], None, [[1.0]], dt=1.0, Q=[[0.5]], R=[[0.01]])
GIVEN = {
    "zero": ("0", None, 0, "a known input that is always zero"),
    "level": (
        "2.5",
        None,
        [2.5],
        "for ever from before the start, at power (kW) = 2.5:",
    ),
    "covariance": (
        "u.json",
        {"U": [[4.0]]},
        [[4.0]],
        "white noise, of the standard deviation power (kW) = 2.",
    ),
    "plant": ("u.json", MODEL, MODEL, "input that a model of 1 state drives"),
}


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    OVEN.to_json("oven.json")
    return tmp_path


def prepared(held):
    """The file of --U, if it is one."""
    if isinstance(held, lb.Plant):
        held.to_json("u.json")
    elif held is not None:
        pathlib.Path("u.json").write_text(json.dumps(held))


@pytest.mark.parametrize("text, held, U, said", GIVEN.values(), ids=GIVEN)
def test_the_report_asks_what_the_command_was_asked(
    here, monkeypatch, text, held, U, said
):
    prepared(held)
    seen = {}

    def instead(plant, **asked):
        seen.update(asked, plant=plant)
        few = lb.candidates(plant, methods="Kalman filter")
        return lb.compare(plant, few, **asked)

    monkeypatch.setattr(sys.modules["luenberger.comparison"], "compare", instead)
    assert main(["design", "oven.json", "--U", text, "--out", "r"]) == 0
    plant = seen["plant"]
    assert plant == OVEN.with_input(U)
    assert said in " ".join((here / "r" / "report.html").read_text().split())
    assert lb.Plant.from_json(here / "r" / "plant.json") == plant


def test_a_report_under_a_model_of_the_input(here, capfd):
    """Error figures, transients and bounds of a design that the input disturbs."""
    MODEL.to_json("u.json")
    rng = np.random.default_rng(3)
    table = lb.compare(OVEN.with_input(MODEL), budget=dict(states=1))
    assert table.chosen.disturbed
    u = rng.normal(size=(60, 1))
    y = lb.simulate(OVEN, table.chosen.observer, 59, u=u, seed=1).y
    rows = ["air (K),power (kW)", *(f"{a},{b}" for (a,), (b,) in zip(y, u))]
    (here / "data.csv").write_text("\n".join(rows) + "\n")
    line = ["design", "oven.json", "--U", "u.json", "--budget", "states=1"]
    assert main([*line, "--data", "data.csv", "--out", "r"]) == 0
    made = here / "r"
    with open(made / "designs.csv", newline="") as file:
        (chosen,) = [row for row in csv.DictReader(file) if row["recommended"] == "yes"]
    sigma = [float(one) for one in chosen["sigma"].split()]
    assert sigma == pytest.approx(table.chosen.sigma.tolist(), rel=1e-6)
    observer = lb.Observer.from_json(made / "observer.json")
    bounds = np.loadtxt(made / "estimates.csv", delimiter=",", skiprows=1)[:, 2::2]
    steady = np.sqrt(lb.error_covariance(observer, OVEN.with_input(MODEL)).diagonal())
    np.testing.assert_allclose(bounds[-1], steady, rtol=1e-2)
    alone = np.sqrt(lb.error_covariance(observer, OVEN.with_input(0)).diagonal())
    assert (bounds[-1] > 1.02 * alone).any()
    page = (made / "report.html").read_text(encoding="utf-8")
    assert "Errors count a known input that a model of 1 state drives." in page
    assert "The known input begins at the first sample." in page
    assert "Not shown" not in page
    assert (
        "the most accurate design in the table within the budget of 1 observer state."
        in page
    )
    assert "Recommended: fixed-order filter, order 1." in page


REFUSED = {
    "a level too many": (["--U", "1,2"], None, "U must have shape"),
    "a model of two": (
        ["--U", "u.json"],
        lb.Plant([[0.5]], None, [[1], [1]], dt=1.0, Q=[[1]], R=np.eye(2)),
        "must have no input and 1 outputs",
    ),
    "a model that grows": (
        ["--U", "u.json"],
        lb.Plant([[1.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[0]]),
        "has the mode 1.5 outside the unit circle",
    ),
    "no covariance": (["--U", "u.json"], {"U": [[-1.0]]}, "U"),
}


@pytest.mark.parametrize("more, held, said", REFUSED.values(), ids=REFUSED)
def test_what_is_no_input_is_refused_before_designs(here, capfd, more, held, said):
    prepared(held)
    assert main(["design", "oven.json", *more, "--out", "r", "--dry-run"]) == 1
    out, err = capfd.readouterr()
    assert said in err and not out and "Traceback" not in err


RECORDS = {  # of the input, with how U is stated, and what is said of it
    "a switch is no level": ("2.5", [0.0, 2.5], "constant for ever at 2.5, but in the"),
    "another level": ("2.5", [2.0], "Give its level, 2."),
    "not zero": ("0", [0.0, 1e-3], "constant for ever at 0, but in the record"),
    "too small": ([[4.0]], [1.0, -1.0], "mean square 2, but in the record it has 1:"),
    "a mean": ([[4.0]], [0.0, 4.0], "has 2.8: the mean 1.96 and the standard dev"),
}


def recorded(values, hold=7, rows=200):
    u = np.resize(np.repeat(values, hold), rows)
    y = lb.simulate(OVEN, lb.kalman_filter(OVEN), rows - 1, u=u[:, None], seed=2).y
    lines = ["air (K),power (kW)", *(f"{a},{b}" for (a,), b in zip(y, u))]
    pathlib.Path("data.csv").write_text("\n".join(lines) + "\n")


def asked(U):
    if not isinstance(U, str):
        prepared({"U": U} if isinstance(U, list) else U)
        U = "u.json"
    line = ["design", "oven.json", "--data", "data.csv", "--U", U, "--out", "r"]
    return main([*line, "--dry-run"])


@pytest.mark.parametrize("U, values, said", RECORDS.values(), ids=RECORDS)
def test_a_record_that_contradicts_U_is_refused(here, capfd, U, values, said):
    recorded(values)
    assert asked(U) == 1
    err = " ".join(capfd.readouterr().err.split())
    assert "the known input 'power (kW)'" in err and said in err


def test_what_the_refusal_proposes_is_taken(here, capfd):
    recorded([0.0, 2.5], hold=20)
    assert asked("2.5") == 1
    err = " ".join(capfd.readouterr().err.split())
    model = json.JSONDecoder().raw_decode(err, err.index('{"dt"'))[0]
    pathlib.Path("u.json").write_text(json.dumps(model))
    assert asked(lb.Plant.from_json("u.json")) == 0
    white = json.JSONDecoder().raw_decode(err, err.index('{"U"'))[0]
    assert asked(white["U"]) == 0
    a, q = model["A"][0][0], model["Q"][0][0]
    assert q / (1 - a**2) == pytest.approx(2.5**2 / 2, rel=0.05)


STATED = {  # what a record does agree with
    "the level": ("2.5", [2.5]),
    "the level in few digits": ("2.5", [2.5, 2.5 * (1 + 1e-7)]),
    "zero": ("0", [0.0]),
    "as much": ([[4.0]], [2.0, -2.0]),
    "about as much": ([[4.0]], [1.9, -1.9]),
    "any model that varies": (MODEL, [0.0, 50.0]),
    "a model of a level": (
        lb.Plant([[1]], None, [[2]], dt=1.0, x0=[1], P0=[[0]]),
        [2.0],
    ),
}


@pytest.mark.parametrize("U, values", STATED.values(), ids=STATED)
def test_a_record_that_agrees_with_U_is_taken(here, U, values):
    recorded(values)
    assert asked(U) == 0


def test_a_model_that_stays_is_a_level(here, capfd):
    recorded([0.0, 2.0])
    assert asked(STATED["a model of a level"][0]) == 1
    assert "constant for ever at 2," in " ".join(capfd.readouterr().err.split())
