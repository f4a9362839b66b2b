"""What may be exported and under which name; files; python-control and scipy."""

import dataclasses
import os
import subprocess
import sys

import numpy as np
import pytest
import scipy.linalg
import scipy.signal

import luenberger as lb
from luenberger.__main__ import main
from luenberger.export import to_c, to_control, to_scipy
from luenberger.export.c.identifiers import HEADERS, KEYWORDS
from luenberger.formats import writing

NAMES = dict(
    state_names=("position", "speed"),
    input_names=("push",),
    output_names=("radar 1.5 GHz",),
)


def plant(**options):
    given = dict(dt=0.5, Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]], P0=np.eye(2), E=[[2]])
    matrices = dict(A=[[1, 1], [0, 1]], B=[[0], [1]], C=[[1, 0]])
    return lb.Plant(**(matrices | given | NAMES | options))


def observer(**options):
    made = lb.reduced_order_filter(plant(), 1)
    return dataclasses.replace(made, **options)


# -- python-control and scipy ---------------------------------------------------------


def continuous():
    source = lb.Plant([[0, 1], [0, 0]], [[0], [1]], [[1, 0]])
    return lb.reduced_order_observer(source, [-2])


def no_states():
    return lb.reduced_order_filter(plant(C=np.eye(2), R=np.eye(2), E=None,
                                         output_names=("s", "v")), 2)  # fmt: skip


KINDS = {"discrete": observer, "continuous": continuous, "no states": no_states}


@pytest.mark.parametrize("kind", KINDS.values(), ids=KINDS)
def test_state_space_has_the_matrices(kind):
    o = kind()
    for made in (to_control(o), to_scipy(o)):
        np.testing.assert_array_equal(made.A, o.F)
        np.testing.assert_array_equal(made.B, np.hstack([o.G, o.D]))
        np.testing.assert_array_equal(made.C, o.P)
        np.testing.assert_array_equal(made.D, np.hstack([o.W, o.V]))
    assert to_control(o).dt == o.dt
    assert to_scipy(o).dt == (o.dt or None)


def test_signals_have_names():
    made = to_control(observer(), plant=plant())
    assert made.input_labels == ["push", "radar 1_5 GHz"]  # a dot parts system.signal
    assert made.output_labels == ["position estimate", "speed estimate"]
    assert made.state_labels == ["z1"]
    assert to_control(observer()).input_labels == made.input_labels  # it knows them
    nameless = observer(state_names=None, input_names=None, output_names=None)
    assert to_control(nameless).input_labels == ["u1", "y1"]
    assert to_control(nameless).output_labels == ["x1 estimate", "x2 estimate"]
    shared = to_control(
        observer(), plant=plant(input_names=("y",), output_names=("y",))
    )
    assert shared.input_labels == ["u y", "y y"]
    part = to_control(dataclasses.replace(observer(), L=[[1, 1], [0, 2]]))
    assert part.output_labels == ["w1 estimate", "w2 estimate"]


def test_a_state_space_comes_back():
    made = to_control(observer(), plant=plant())
    back = lb.Plant.from_statespace(made)
    np.testing.assert_array_equal(back.A, made.A)
    np.testing.assert_array_equal(back.E, made.D)
    assert back.dt == 0.5 and back.input_names == ("push", "radar 1_5 GHz")


@pytest.mark.parametrize("to", [to_control, to_scipy])
def test_a_varying_observer_is_no_state_space(to):
    with pytest.raises(lb.DesignError, match="3 rows of gains, a StateSpace is const"):
        to(lb.kalman_filter(plant(), steps=3))


# -- refusals -------------------------------------------------------------------------

WRONG = [
    "",
    "1st",
    "a-b",
    "a b",
    "\u00e9t\u00e9",
    "_state",
    "a.b",
    "a/b",
    "a\n",
    7,
    None,
]


@pytest.mark.parametrize("name", WRONG, ids=repr)
def test_a_name_that_is_no_identifier(name, tmp_path):
    with pytest.raises(ValueError, match="must be a C identifier"):
        to_c(observer(), tmp_path, name=name)
    assert not list(tmp_path.iterdir())


RESERVED = "int restrict class main math float a__b stdio while".split()


@pytest.mark.parametrize("name", RESERVED)
def test_a_name_that_is_taken(name, tmp_path):
    message = "a word of C|reserved in C|name of a standard header"
    with pytest.raises(ValueError, match=message):
        to_c(observer(), tmp_path, name=name)
    assert {"inline", "_Bool"} - KEYWORDS == {"_Bool"} and "string" in HEADERS


def test_a_name_that_is_too_long_for_compilers(tmp_path):
    to_c(observer(), tmp_path, name="a" * 24)
    with pytest.raises(ValueError, match="has 25 characters"):
        to_c(observer(), tmp_path, name="a" * 25)


def varying_plant():
    return lb.Plant(np.ones((3, 1, 1)), None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])


REFUSED = {
    "varying observer": (lambda: lb.kalman_filter(plant(), steps=3), {}, "Give to_c"),
    "continuous": (continuous, {}, "in continuous time"),
    "unstable": (lambda: observer(F=[[1.5]]), {}, "not stable: it has poles at 1.5"),
    "on the circle": (lambda: observer(F=[[-1.0]]), {}, "poles at -1"),
    "complex": (lambda: observer(F=[[0.5j]]), {}, "is for real matrices"),
    "other sizes": (observer, {"plant": varying_plant()}, "has dt=0.5 but"),
    "m1 with observer": (observer, {"m1": 0}, "m1 and weight go with a plant"),
    "plant with plant": (plant, {"plant": plant()}, "plant= goes with an observer"),
    "dtype": (observer, {"dtype": "int"}, "dtype must be 'double' or 'float'"),
    "varying plant": (varying_plant, {}, "the plant varies with time"),
    "continuous plant": (lambda: plant(dt=0), {}, "the plant has dt = 0"),
    "no Q": (lambda: plant(Q=None), {}, "the plant has no Q"),
    "no P0": (lambda: plant(P0=None), {}, "starts from the covariance P0"),
    "no outputs": (
        lambda: plant(C=np.zeros((0, 2)), R=np.zeros((0, 0)), E=None, output_names=()),
        {}, "has no outputs"
    ),
    "m1": (plant, {"m1": 2}, "m1 must be between 0 and p = 1"),
    "weight": (plant, {"m1": 1, "weight": -np.eye(2)}, "weight"),
    "too large": (
        lambda: observer(D=[[1e39]]), {"dtype": "float"}, r"D\[0, 0\] is 1e\+39, beyond"
    ),
    "too large P0": (
        lambda: plant(P0=np.eye(2) * 1e39), {"dtype": "float"}, "P0.*beyond"
    ),
}  # fmt: skip


@pytest.mark.parametrize(("source", "options", "why"), REFUSED.values(), ids=REFUSED)
def test_refused_with_the_reason_and_nothing_written(source, options, why, tmp_path):
    with pytest.raises(ValueError, match=why):
        to_c(source(), tmp_path / "new", **options)
    assert not (tmp_path / "new").exists()


# -- files ----------------------------------------------------------------------------


def contents(folder):
    return {path.name: path.read_bytes() for path in folder.iterdir()}


def test_two_files_and_nothing_else(tmp_path):
    to_c(plant(), tmp_path / "a" / "b", name="unit")  # is replaced
    made = to_c(observer(), tmp_path / "a" / "b", name="unit")
    assert [path.name for path in made] == ["unit.c", "unit.h"]
    assert set(contents(tmp_path / "a" / "b")) == {"unit.c", "unit.h"}
    to_c(observer(), tmp_path / "fresh", name="unit")
    assert contents(tmp_path / "fresh") == contents(tmp_path / "a" / "b")
    for path in made:
        assert path.read_bytes().endswith(b"\n") and b"\r" not in path.read_bytes()


@pytest.mark.parametrize("name", ["observer.c", "observer.h"])
def test_files_of_others_are_left_alone(name, tmp_path):
    (tmp_path / name).write_text("int mine;")
    with pytest.raises(ValueError, match="was not written by this library"):
        to_c(observer(), tmp_path)
    assert contents(tmp_path) == {name: b"int mine;"}


@pytest.mark.parametrize("before", [True, False], ids=["over an old pair", "afresh"])
def test_never_half_a_pair(before, tmp_path, monkeypatch):
    """Both are written before one is replaced."""
    if before:
        to_c(plant(), tmp_path)
    there, calls, usual = contents(tmp_path), [], open

    def full(path, *arguments, **options):
        calls.append(path)
        if len(calls) == 2:
            raise OSError(28, "the disk is full")
        return usual(path, *arguments, **options)

    monkeypatch.setattr(writing, "open", full, raising=False)
    with pytest.raises(OSError, match="the disk is full"):
        to_c(observer(), tmp_path)
    assert contents(tmp_path) == there and len(calls) == 2


# -- command line ---------------------------------------------------------------------


@pytest.fixture
def command(monkeypatch, capfd, tmp_path):
    def run(*arguments):
        monkeypatch.chdir(tmp_path)
        return main(["export", *map(str, arguments)]), *capfd.readouterr()

    observer().to_json(tmp_path / "o.json")
    plant().to_json(tmp_path / "p.json")
    return run


def test_command_writes_what_the_function_writes(command, tmp_path):
    status, out, err = command("o.json", "--c", "c", "--plant", "p.json")
    assert (status, err) == (0, "")
    assert out.split() == [os.path.join("c", f"observer.{k}") for k in "ch"]
    to_c(observer(), tmp_path / "same", plant=plant())
    assert contents(tmp_path / "c") == contents(tmp_path / "same")
    status, out, _ = command("o.json", "--c", "c", "--name", "unit", "--dtype=float")
    assert status == 0 and "float z[1];" in (tmp_path / "c" / "unit.h").read_text()


def test_command_refuses_in_one_line(command, tmp_path):
    for arguments, why in (
        (("o.json", "--c", "c", "--name", "int"), "a word of C"),
        (("p.json", "--c", "c", "--plant", "p.json"), "the source is a plant"),
        (("o.json", "--c", "c", "--m1", "1"), "the source is an observer"),
        (("absent.json", "--c", "c"), "absent.json: No such file"),
        (("o.json", "--c", "o.json"), "o.json is a file"),
    ):
        status, out, err = command(*arguments)
        assert status == 1 and out == "" and why in err and err.count("\n") == 1
    assert not (tmp_path / "c").exists()


def test_command_in_a_process_of_its_own(command, tmp_path):
    """Light, too: neither matplotlib nor numba is imported for it."""
    code = (
        "import sys; from luenberger.__main__ import main; main(sys.argv[1:]); "
        "print(*{'matplotlib', 'numba', 'control'} & set(sys.modules))"
    )
    run = subprocess.run(
        [sys.executable, "-c", code, "export", "o.json", "--c", "c"],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert len(run.stdout.split()) == 2


def test_export_is_an_attribute_of_the_library():
    assert lb.export.to_c is to_c


@pytest.mark.parametrize(
    ("dt", "theirs", "said"),
    [
        (0.0, dict(RN=[[1.0]]), r"R = RN / dt for readings every dt seconds"),
        (0.5, dict(RN=[[1.0]]), r"RN is not a covariance of Plant; give R = RN$"),
        (0.0, dict(QN=[[1.0]]), r"give Q = G QN G'"),
        (0.5, dict(Q=np.eye(2), NN=[[0]]), r"give S = G NN"),
    ],
)
def test_noises_of_python_control_are_told_from_those_of_a_plant(dt, theirs, said):
    sys = to_scipy(plant(dt=dt))
    with pytest.raises(TypeError, match=said):
        lb.Plant.from_statespace(sys, **theirs)


def test_readings_of_an_intensity_have_it_over_the_period():
    """Ever faster sampling then tends to the continuous filter, which has RN."""
    ball = scipy.signal.lti([[0, 1], [0, 0]], [[0], [1]], [[1, 0]], [[0]])
    QN, RN, dt = np.diag([0, 1.0]), np.array([[1e-4]]), 1e-3
    P = scipy.linalg.solve_continuous_are(ball.A.T, ball.C.T, QN, RN)
    sampled = lb.Plant.from_statespace(ball, Q=QN, R=RN / dt).sampled(dt)
    Sigma = lb.error_covariance(lb.kalman_filter(sampled), sampled)
    np.testing.assert_allclose(np.sqrt(Sigma.diagonal()), np.sqrt(P.diagonal()), 0.01)
