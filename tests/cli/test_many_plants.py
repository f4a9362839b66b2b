"""Many plants and `--U` on the command line: the library's numbers, and refusals."""

import json

import numpy as np
import pytest

import luenberger as lb
from luenberger.cli import main

MOTOR = lb.Plant(
    [[1, 0.1], [0, 0.8]], [[0], [0.1]], [[1, 0]], dt=0.1,
    Q=np.diag([1e-6, 1e-2]), R=[[1e-3]],
)  # fmt: skip


@pytest.fixture
def here(tmp_path, monkeypatch):
    monkeypatch.chdir(tmp_path)
    MOTOR.to_json("motor.json")
    lb.kalman_filter(MOTOR).to_json("kalman.json")
    lb.deadbeat_observer(MOTOR).to_json("deadbeat.json")
    return tmp_path


@pytest.fixture
def call(capfd, here):
    def run(*arguments):
        try:
            status = main(["compare", "motor.json", *arguments])
        except SystemExit as end:
            status = end.code
        return status, *capfd.readouterr()

    return run


GIVEN = ("--observers", "kalman.json", "deadbeat.json")
OF_FILES = {
    "kalman.json": lb.kalman_filter(MOTOR),
    "deadbeat.json": lb.deadbeat_observer(MOTOR),
}


def test_the_command_gives_what_the_library_does(call, here):
    ranges = ("--ranges", "A[1,1]=10%", "B[1,0]=0.08:0.12", "--samples", "2")
    status, out, err = call(*ranges, *GIVEN, "--U", "12", "--json", "--seed", "3")
    assert (status, err) == (0, "")
    given = {"A[1,1]": "10 %", "B[1,0]": (0.08, 0.12)}
    plants = lb.vary(MOTOR, given, samples=2, seed=3)
    wanted = lb.compare(MOTOR.with_input([12.0]), OF_FILES, plants=plants)
    found = json.loads(out)
    assert found["cases"] == wanted.to_cases() and len(found["cases"]) == 2 * 7
    assert found["recommended"] == wanted.chosen.name
    assert found["reasons"] == wanted.reasons()
    status, out, _ = call(*ranges, *GIVEN, "--U", "12", "--seed", "3")
    assert status == 0 and f"Take the {wanted.chosen.name}." in out


@pytest.mark.parametrize(
    "held, U",
    [
        ({"U": [[144.0]]}, [[144.0]]),
        ({"U": [12], "description": "a step"}, [12]),
        (None, lb.Plant([[0.9]], None, [[1]], dt=0.1, Q=[[2.0]], R=[[0.0]])),
    ],
    ids=["covariance", "level", "plant"],
)
def test_a_file_says_what_the_input_is_like(call, here, held, U):
    if held is None:
        U.to_json("drives.json")
    else:
        (here / "drives.json").write_text(json.dumps(held))
    lb.Plant.to_json(lb.Plant.from_json("motor.json"), "other.json")
    line = ("--ranges", "B[1,0]=5%", "--samples", "0", *GIVEN, "--U", "drives.json")
    status, out, _ = call(*line, "--json")
    ranges = {"B[1,0]": "5 %"}
    plants = lb.vary(MOTOR, ranges, samples=0)
    wanted = lb.compare(MOTOR.with_input(U), OF_FILES, plants=plants)
    assert status == 0 and json.loads(out)["cases"] == wanted.to_cases()
    status, out, err = call("--plants", "other.json", *GIVEN, "--json")
    plants = {case["plant"] for case in json.loads(out)["cases"]}
    assert (status, plants) == (0, {"nominal", "other.json"})


REFUSED = {
    "no range": (["--ranges", "A[1,1]"], 'give "A'),
    "half a range": (["--ranges", "A[1,1]=0.5"], 'give "A'),
    "foreign digits": (["--ranges", "A[1,1]=1_0:2_0"], 'give "A'),
    "twice": (["--ranges", "A[1,1]=1%", "A[1,1]=2%"], "name one entry twice"),
    "a word": (["--ranges", "A[1,1]=1%", "--U", "twelve"], "give levels such as 12"),
}


@pytest.mark.parametrize("line, said", REFUSED.values(), ids=REFUSED)
def test_a_wrong_command_line_is_wrong_usage(call, line, said):
    status, out, err = call(*line, *GIVEN)
    assert status == 2 and not out and said in err


def test_what_the_library_refuses_is_refused_in_one_line(call, here):
    status, out, err = call("--ranges", "A[1,7]=1%:", *GIVEN)
    assert status == 2
    status, out, err = call("--ranges", "A[1,7]=0:1", *GIVEN)
    assert (status, out) == (1, "") and "there is no A[1,7]" in err
    (here / "u.json").write_text('{"U": [true]}')
    status, out, err = call("--ranges", "A[1,1]=1%", *GIVEN, "--U", "u.json")
    assert (status, out) == (1, "") and "u.json: U holds true" in err
    (here / "u.json").write_text('{"U": [1], "u": 2}')
    status, _, err = call("--ranges", "A[1,1]=1%", *GIVEN, "--U", "u.json")
    assert status == 1 and "beside 'U' there is 'u'" in err


def test_compare_takes_the_same(here, capfd):
    assert main(["compare", "motor.json", "--U", "12", "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["designs"] == lb.compare(MOTOR.with_input([12.0])).to_rows()


def test_estimates_are_named_on_the_command_line(call, here):
    speed = lb.kalman_filter(MOTOR).combined({"speed (rad/s)": [0, 1]})
    speed.to_json("speed.json")
    ranges = ("--ranges", "A[1,1]=10%", "--samples", "0")
    given = ("--observers", "kalman.json", "speed.json")
    status, out, _ = call(*ranges, *given, "--k", "speed (rad/s)=0,1", "--U=12")
    assert status == 0
    assert "standard deviation of speed (rad/s) is" in " ".join(out.split())
    status, out, _ = call(*ranges, *given, "--k=x2", "--U=12", "--json")
    found = json.loads(out)
    assert (status, found["estimates"]) == (0, ["x2"])
    status, _, err = call(*ranges, *given, "--k=x3")
    assert status == 1 and "no estimate or state 'x3'" in err


def test_a_continuous_model_is_sampled_as_the_plant_is(call, here, capfd):
    model = lb.Plant([[-2.0]], None, [[3.0]], Q=[[4.0]], R=[[0.0]])
    model.to_json("drives.json")
    line = ("--ranges", "B[1,0]=5%", "--samples", "0", *GIVEN, "--U", "drives.json")
    status, out, _ = call(*line, "--json")
    ranges, U = {"B[1,0]": "5 %"}, model.sampled(MOTOR.dt)
    plants = lb.vary(MOTOR, ranges, samples=0)
    wanted = lb.compare(MOTOR.with_input(U), OF_FILES, plants=plants)
    assert status == 0 and json.loads(out)["cases"] == wanted.to_cases()
    assert main(["compare", "motor.json", "--U", "drives.json", "--json"]) == 0
    found = json.loads(capfd.readouterr().out)
    assert found["designs"] == lb.compare(MOTOR.with_input(U)).to_rows()
