"""With other programs and other versions: files, python-control, SciPy, pandas."""

import json

import pytest

import luenberger as lb

# -- files of any version -------------------------------------------------------------

FIRST_OBSERVER = """{
  "luenberger": "observer",
  "F": [
    [0.296327573225754]
  ],
  "G": [
    [0.9682022264963259]
  ],
  "D": [
    [-0.052079866039051854]
  ],
  "P": [
    [0.0],
    [1.0]
  ],
  "V": [
    [1.0],
    [0.07401152021515865]
  ],
  "T": [
    [-0.07401152021515865, 1.0]
  ],
  "L": [
    [1.0, 0.0],
    [0.0, 1.0]
  ],
  "W": [
    [-0.1],
    [-0.007401152021515866]
  ],
  "z0": [1.9259884797848414],
  "dt": 0.5,
  "T0": [
    [-0.07401152021515865, 1.0]
  ]
}
"""  # as the first version wrote it: no format, no names
FIRST_OVER_STEPS = """{
  "luenberger": "observer",
  "F": [[[0.25]], [[0.5]]],
  "G": {"shape": [2, 1, 0]},
  "D": [[[1.0]], [[1.0]]],
  "P": [[[1.0]], [[1.0]]],
  "V": {"real": [[[0.0]], [[0.0]]], "imag": [[[0.1]], [[0.2]]]},
  "T": [[[1.0]], [[1.0]]],
  "L": [[1.0]],
  "W": {"shape": [2, 1, 0]},
  "z0": [3.0],
  "dt": 1.0,
  "T0": [[1.0]],
  "G0": {"shape": [1, 0]}
}
"""


def saved(folder, text, name="file.json"):
    path = folder / name
    path.write_text(text, encoding="utf-8")
    return path


def test_a_file_of_the_first_version_is_read(tmp_path):
    observer = lb.Observer.from_json(saved(tmp_path, FIRST_OBSERVER))
    assert observer.F[0, 0] == 0.296327573225754
    assert observer.W[1, 0] == -0.007401152021515866
    assert observer.z0[0] == 1.9259884797848414 and observer.dt == 0.5
    assert observer.state_names is None and observer.estimate_names == ("x1", "x2")
    over_steps = lb.Observer.from_json(saved(tmp_path, FIRST_OVER_STEPS))
    assert over_steps.steps == 2 and over_steps.F[1, 0, 0] == 0.5
    assert over_steps.V[1, 0, 0] == 0.2j and over_steps.G0.shape == (1, 0)


def test_what_is_written_says_its_format(tmp_path):
    observer = lb.Observer.from_json(saved(tmp_path, FIRST_OBSERVER))
    observer.to_json(tmp_path / "again.json")
    text = (tmp_path / "again.json").read_text(encoding="utf-8")
    assert text == FIRST_OBSERVER.replace("{", '{\n  "format": 1,', 1).replace(
        '{\n  "format": 1,\n  "luenberger": "observer",',
        '{\n  "luenberger": "observer",\n  "format": 1,',
    )


PLANT = {"luenberger": "plant", "format": 1, "A": [[0.5]], "C": [[1]]}


@pytest.mark.parametrize(
    "changes, message",
    [
        ({"format": 2}, "has format 2, and this version of luenberger reads format 1"),
        ({"format": 2, "M": [[1]]}, "update luenberger"),  # not: unknown key
        ({"format": 0}, "format must be a whole number, got 0"),
        ({"format": True}, "format must be a whole number, got True"),
        ({"format": "1"}, "format must be a whole number, got '1'"),
        ({"format": 1.5}, "format must be a whole number"),
        ({"format": None}, "format must be a whole number"),
        ({"sate_names": ["x"]}, r"unknown keys \['sate_names'\]; a plant has"),
        ({"_exact": 1}, r"unknown keys \['_exact'\]"),
    ],
)
def test_a_file_that_may_mean_something_else_is_refused(tmp_path, changes, message):
    assert lb.Plant.from_json(saved(tmp_path, json.dumps(PLANT))).n == 1
    path = saved(tmp_path, json.dumps(PLANT | changes))
    with pytest.raises(ValueError, match=message):
        lb.Plant.from_json(path)


def test_names_of_an_observer_come_back(tmp_path):
    plant = lb.Plant(
        [[0.5, 0.1], [0, 0.7]], None, [[1, 0]], dt=0.1,
        state_names=["Druck (bar)", "\u03b8"], output_names=["a,b\"\n"],
    )  # fmt: skip
    lb.reduced_order_observer(plant, [0.3]).to_json(tmp_path / "o.json")
    again = lb.Observer.from_json(tmp_path / "o.json")
    assert again.state_names == ("Druck (bar)", "\u03b8")
    assert (again.input_names, again.output_names) == ((), ('a,b"\n',))
