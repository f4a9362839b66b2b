"""With other programs and other versions: files, python-control, SciPy, pandas."""

import dataclasses
import json
import subprocess
import sys

import control
import numpy as np
import pandas as pd
import pytest
import scipy.signal
from in_parts import in_parts

import luenberger as lb
from luenberger.export import from_statespace, to_control, to_scipy

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
        state_names=["Druck (bar)", "\u03b8"], output_names=["a,b\""],
    )  # fmt: skip
    lb.reduced_order_observer(plant, [0.3]).to_json(tmp_path / "o.json")
    again = lb.Observer.from_json(tmp_path / "o.json")
    assert again.state_names == ("Druck (bar)", "\u03b8")
    assert (again.input_names, again.output_names) == ((), ('a,b"',))


# -- python-control and scipy.signal --------------------------------------------------

NAMES = dict(
    state_names=("position", "speed"), input_names=("push",), output_names=("radar",)
)


def car(**options):
    given = dict(dt=0.5, Q=[[0.25, 0.5], [0.5, 1]], R=[[0.01]], E=[[0.2]]) | NAMES
    matrices = dict(A=[[1, 0.5], [0, 0.9]], B=[[0.1], [1]], C=[[1, 0]])
    return lb.Plant(**(matrices | given | options))


def record(count=60, m=1, p=1):
    rng = np.random.default_rng(3)
    return rng.normal(size=(count, p)), rng.normal(size=(count, m))


@pytest.mark.parametrize("dt", [0.5, 0.0], ids=["discrete", "continuous"])
def test_a_plant_goes_to_control_and_comes_back(dt):
    plant = car(dt=dt, name="Car")
    sys = to_control(plant)
    assert isinstance(sys, control.StateSpace) and sys.dt == dt
    assert sys.state_labels == ["position", "speed"]
    assert (sys.input_labels, sys.output_labels) == (["push"], ["radar"])
    back = lb.Plant.from_statespace(sys, Q=plant.Q, R=plant.R)
    for name in ("A", "B", "C", "E", "Q", "R"):
        np.testing.assert_array_equal(getattr(back, name), getattr(plant, name))
    for name in ("dt", *NAMES):
        assert getattr(back, name) == getattr(plant, name)


@pytest.mark.parametrize("dt", [0.5, 0.0], ids=["discrete", "continuous"])
def test_a_plant_goes_to_scipy_and_comes_back(dt):
    plant = car(dt=dt)
    sys = to_scipy(plant)
    assert isinstance(sys, scipy.signal.dlti if dt else scipy.signal.lti)
    back = lb.Plant.from_statespace(sys, **NAMES)
    for name in ("A", "B", "C", "E"):
        np.testing.assert_array_equal(getattr(back, name), getattr(plant, name))
    assert back.dt == dt and back.state_names == plant.state_names


@pytest.mark.parametrize(
    "sys, options, wanted",
    [
        (control.ss([[1]], [[1]], [[1]], [[0]], True), {"dt": 0.25}, 0.25),
        (control.ss([[1]], [[1]], [[1]], [[0]], None), {"dt": 0.25}, 0.25),
        (control.ss([[1]], [[1]], [[1]], [[0]], None), {"dt": 0}, 0.0),
        (control.ss([[1]], [[1]], [[1]], [[0]], 0.25), {"dt": 0.25}, 0.25),
        (control.ss([[1]], [[1]], [[1]], [[0]]), {}, 0.0),
        (scipy.signal.dlti([[1]], [[1]], [[1]], [[0]]), {"dt": 0.25}, 0.25),
        (scipy.signal.lti([[1]], [[1]], [[1]], [[0]]), {}, 0.0),
    ],
)
def test_what_a_dt_means(sys, options, wanted):
    assert lb.Plant.from_statespace(sys, **options).dt == wanted


@pytest.mark.parametrize(
    "sys, options, message",
    [
        (control.ss([[1]], [[1]], [[1]], [[0]], True), {}, "dt is True: it does"),
        (control.ss([[1]], [[1]], [[1]], [[0]], True), {"dt": 0}, "dt = 0 cannot be"),
        (control.ss([[1]], [[1]], [[1]], [[0]], None), {}, "dt is None.*dt=, 0 or in"),
        (scipy.signal.dlti([[1]], [[1]], [[1]], [[0]]), {}, "dt is True"),
        (control.ss([[1]], [[1]], [[1]], [[0]], 1), {"dt": 2}, "dt = 1, but dt = 2"),
        (control.tf([1], [1, 1]), {}, "a TransferFunction has no A.*control.ss"),
        (scipy.signal.lti([1], [1, 1]), {}, r"TransferFunction.* sys.to_ss\(\)"),
    ],
)  # fmt: skip
def test_systems_that_are_no_plant(sys, options, message):
    with pytest.raises(ValueError, match=message):
        lb.Plant.from_statespace(sys, **options)


def test_plants_that_control_does_not_have():
    with pytest.raises(lb.DesignError, match="no known inputs.*column of zeros"):
        to_control(car(B=None, E=None, input_names=None))
    with pytest.raises(lb.DesignError, match="plant has 2 rows, a StateSpace is const"):
        to_scipy(car(C=[[[1, 0]], [[1, 1]]], E=None))
    with pytest.raises(lb.DesignError, match="plant is complex"):
        to_control(lb.Plant([[0.5j]], [[1]], [[1]]))
    with pytest.raises(ValueError, match="plant= goes with an observer"):
        to_control(car(), plant=car())


WAYS = {
    "Kalman filter": lambda plant: lb.kalman_filter(plant),
    "reduced filter": lambda plant: lb.reduced_order_filter(plant, 1),
    "placed": lambda plant: lb.reduced_order_observer(plant, [0.3]),
    "deadbeat": lambda plant: lb.deadbeat_observer(plant),
    "functional": lambda plant: lb.functional_observer(plant, [[1, 3]]),
}


@pytest.mark.parametrize("to", [to_control, to_scipy])
@pytest.mark.parametrize("design", WAYS.values(), ids=WAYS)
def test_an_observer_comes_back_with_what_it_tracks(design, to):
    plant = car(x0=[1, 2], **(dict(E=None) if design is WAYS["functional"] else {}))
    observer = design(plant)
    back = from_statespace(to(observer), plant)
    for name in ("F", "G", "D", "P", "V", "W"):
        np.testing.assert_array_equal(getattr(back, name), getattr(observer, name))
    np.testing.assert_allclose(back.T, observer.T, rtol=1e-12, atol=1e-12)
    np.testing.assert_array_equal(back.L, observer.L)
    np.testing.assert_allclose(back.z0, observer.z0, atol=1e-12)
    assert back.estimate_names == observer.estimate_names
    y, u = record()
    same = lb.estimate(back, lb.Record(y, u), z0=observer.z0)
    np.testing.assert_array_equal(same, lb.estimate(observer, lb.Record(y, u)))


@pytest.mark.parametrize("design", WAYS.values(), ids=WAYS)
def test_real_libraries_run_it_to_the_same_estimates(design):
    plant = car(E=None, x0=[1, 2])
    observer = design(plant)
    y, u = record()
    mine = lb.estimate(observer, lb.Record(y, u))
    both = np.hstack([u, y])
    run = control.forced_response(
        to_control(observer), inputs=both.T, initial_state=observer.z0
    )
    np.testing.assert_allclose(np.atleast_2d(run.outputs).T, mine, rtol=1e-12)
    _, found, _ = scipy.signal.dlsim(to_scipy(observer), both, x0=observer.z0)
    np.testing.assert_allclose(found, mine, rtol=1e-12)


def test_real_libraries_simulate_the_plant_that_the_estimate_follows():
    plant, (_, u) = car(), record()
    sys = to_control(plant)
    run = control.forced_response(sys, inputs=u.T, initial_state=[3, -1])
    _, y, x = scipy.signal.dlsim(to_scipy(plant), u, x0=[3, -1])
    np.testing.assert_allclose(run.outputs, y[:, 0], rtol=1e-12)
    found = lb.estimate(lb.deadbeat_observer(plant), lb.Record(y, u))
    np.testing.assert_allclose(found[1:], x[1:], atol=1e-12)
    np.testing.assert_allclose(found[1:], run.states.T[1:], atol=1e-12)


def test_a_filter_that_python_control_designed_is_certified():
    plant = car()
    gain, *_ = control.dlqe(plant.A, np.eye(2), plant.C, plant.Q, plant.R)
    F = plant.A - gain @ plant.C
    B = np.hstack([plant.B - gain @ plant.E, gain])
    predictor = control.ss(F, B, np.eye(2), np.zeros((2, 2)), plant.dt)
    observer = from_statespace(predictor, plant)
    np.testing.assert_allclose(observer.T, np.eye(2), atol=1e-12)
    assert observer.estimate_names == ("position", "speed")
    assert lb.certify(observer, plant).worst < 1e-12


def rebuilt(observer, **changes):
    return to_scipy(dataclasses.replace(observer, **changes))


@pytest.mark.parametrize("to", [to_control, to_scipy])
def test_an_observer_without_states_comes_back(to):
    plant = car(C=np.eye(2), E=None, R=np.eye(2), output_names=("radar", "wheel"))
    observer = lb.deadbeat_observer(plant)
    again = from_statespace(to(observer), plant)
    assert observer.order == again.order == 0
    np.testing.assert_array_equal(again.V, observer.V)
    assert again.estimate_names == ("position", "speed")


def test_names_that_differ_by_a_dot_stay_different():
    plant = car(state_names=("a.x", "a_x"))
    assert to_control(plant).state_labels == ["a_x_", "a_x"]


def test_systems_that_are_no_observer():
    plant = car()
    good = lb.reduced_order_observer(plant, [0.3])
    for changes, message in [
        (dict(G=good.G + 0.1), "the input residual is"),
        (dict(W=good.W + 0.1), "the feedthrough residual is"),
    ]:
        with pytest.raises(lb.CertificateError, match=message):
            from_statespace(rebuilt(good, **changes), plant)
    with pytest.raises(lb.CertificateError, match="the output residual is"):
        from_statespace(to_scipy(good), plant, L=[[1, 0], [0, 2]])
    F, D, V = [[1.3]], [[1.0]], np.array([[1.0], [0]])
    T = np.linalg.solve((plant.A - 1.3 * np.eye(2)).T, plant.C[0])[None]  # (4)
    growing = dict(F=F, D=D, P=[[0], [0]], V=V, W=-V @ plant.E)
    growing["G"] = T @ plant.B - D @ plant.E
    with pytest.raises(lb.CertificateError, match="not stable: poles"):
        from_statespace(rebuilt(good, **growing), plant)
    with pytest.raises(lb.DesignError, match=r"1 inputs; \[u; y\] .* are 1 \+ 1"):
        from_statespace(to_scipy(plant), plant)
    with pytest.raises(lb.DesignError, match="plant varies with time"):
        from_statespace(to_scipy(good), car(A=[plant.A, plant.A]))
    with pytest.raises(ValueError, match="dt = 0.5, but dt = 0.25"):
        from_statespace(to_scipy(good), car(dt=0.25))


def test_a_pole_shared_with_the_plant_leaves_open_what_is_tracked():
    plant, T = car(), [[0, 1.0]]
    for pole in (0.9, 0.9 + 1e-14):
        copy = lb.Observer(
            [[pole]], [[0]], [[1]], [[1]], [[0]], T=[[0, 0]], L=[[0, 0]], dt=0.5
        )
        with pytest.raises(lb.DesignError, match="pole at 0.9 is one of the plant's"):
            from_statespace(to_scipy(copy), plant)
    model = lb.Observer([[0.9]], [[1]], [[0]], [[1]], [[0]], T=T, L=T, dt=0.5)
    with pytest.raises(lb.DesignError, match="pole at 0.9 is one of the plant's"):
        from_statespace(to_scipy(model), plant)
    assert from_statespace(to_scipy(model), plant, T=T).estimate_names == ("speed",)


NEAR = (0.51, 0.5001)  # |T| is 2e5 and 2e11, rounding takes 3e-11 and 2e-5 of it


def test_poles_near_a_triple_pole_of_the_plant_cost_the_digits_of_what_is_tracked():
    turn = np.linalg.qr(np.random.default_rng(1).normal(size=(3, 3)))[0]
    A = turn @ (0.5 * np.eye(3) + np.eye(3, k=1)) @ turn.T
    plant = lb.Plant(A, None, [[1, 0, 0]], dt=1.0)
    one = {p: scipy.signal.dlti([[p]], [[1]], [[1]], [[0]], dt=1.0) for p in NEAR}
    assert lb.certify(from_statespace(one[0.51], plant), plant).worst < 1e-9
    with pytest.raises(lb.DesignError, match=r"0\.5001 is .* or too close to one"):
        from_statespace(one[0.5001], plant)


# -- pandas ---------------------------------------------------------------------------

TIMES = pd.date_range("2024-01-01", periods=60, freq="500ms")


def two_sensors(**options):
    given = dict(C=[[1, 0], [0, 1]], R=np.diag([0.01, 0.2]), E=None, P0=np.eye(2))
    names = dict(output_names=("radar", "wheel"))
    return car(**(given | names | options))


def table(columns=("wheel", "push", "radar")):
    y, u = record(p=2)
    values = dict(radar=y[:, 0], wheel=y[:, 1], push=u[:, 0], note=np.arange(60))
    return pd.DataFrame({name: values[name] for name in columns}, index=TIMES)


def test_columns_are_found_by_name_and_the_index_is_kept():
    observer = lb.reduced_order_filter(two_sensors(), 1)
    y, u = record(p=2)
    wanted = lb.estimate(observer, lb.Record(y, u))
    one = table(("note", "wheel", "push", "radar"))
    for given in [(one,), (one[["wheel", "radar"]], one[["push"]]), (one, one),
                  (one, u), (one, one["push"])]:  # fmt: skip
        found = lb.estimate(observer, lb.Record(*given))
        assert type(found) is pd.DataFrame and found.index.equals(TIMES)
        assert list(found.columns) == ["position", "speed"]
        np.testing.assert_array_equal(found.to_numpy(), wanted)
    assert type(lb.estimate(observer, lb.Record(y, one))) is np.ndarray
    without = lb.estimate(observer, lb.Record(one[["radar", "wheel"]], 0))
    np.testing.assert_array_equal(without, lb.estimate(observer, y))
    with pytest.raises(ValueError, match="y has no column 'push'.*u=0 says that no"):
        lb.estimate(observer, one[["radar", "wheel"]])


def test_one_channel_may_be_a_series():
    observer = lb.deadbeat_observer(car())
    y, u = record()
    series = pd.Series(y[:, 0], index=TIMES, name="whatever")
    found = lb.estimate(observer, lb.Record(series, u))
    assert list(found.columns) == ["position", "speed"] and found.index.equals(TIMES)
    np.testing.assert_array_equal(
        found.to_numpy(), lb.estimate(observer, lb.Record(y, u))
    )
    with pytest.raises(ValueError, match=r"y must be \(N, 2\), got \(60,\)"):
        lb.estimate(lb.kalman_filter(two_sensors()), series)


def test_an_observer_without_names_takes_columns_by_position():
    observer = lb.Observer(
        [[0.5]], [[]], [[1, 2]], [[1]], [[0, 0]], T=[[1]], L=[[2]], dt=0.5
    )
    found = lb.estimate(observer, table(["radar", "wheel"]))
    wanted = lb.estimate(observer, record(p=2)[0])
    assert list(found.columns) == ["w1"]
    np.testing.assert_array_equal(found, wanted)
    with pytest.raises(ValueError, match=r"y must be \(N, 2\), got \(60, 3\)"):
        lb.estimate(observer, table())


def test_chunks_of_a_table_stream():
    plant, one = two_sensors(), table()
    parts = [one.iloc[:7], one.iloc[7:7], one.iloc[7:40], one.iloc[40:]]
    states = pd.concat(part.x for part in in_parts(lb.Filter(plant), parts))
    pd.testing.assert_frame_equal(states, lb.Filter(plant).run(one).x, rtol=1e-12)


@pytest.mark.parametrize("dtype", ["float64", "Float64", "float32"])
def test_a_missing_value_is_nan_however_the_table_says_it(dtype):
    plant = two_sensors()
    one = table().astype({"radar": dtype})
    one.loc[TIMES[4], "radar"] = None
    y, u = (one[list(k)].to_numpy(float) for k in (plant.output_names, ("push",)))
    y[4, 0] = np.nan
    found = lb.Filter(plant, 1).run(one)
    wanted = lb.Filter(plant, 1).run(lb.Record(y, u))
    np.testing.assert_array_equal(found.x.to_numpy(), wanted.x)
    np.testing.assert_array_equal(found.std.to_numpy(), wanted.std)
    assert found.x.index.equals(TIMES) and found.std.index.equals(TIMES)
    assert list(found.std.columns) == ["position", "speed"]
    with pytest.raises(ValueError, match="first in row 4; a Filter takes NaN"):
        lb.estimate(lb.kalman_filter(plant), one)


def test_integers_and_switches_are_numbers():
    observer = lb.kalman_filter(two_sensors())
    one = table().assign(push=lambda t: t.push > 0, wheel=lambda t: t.wheel.astype(int))
    found = lb.estimate(observer, one)
    wanted = lb.estimate(observer, one.astype(float))
    pd.testing.assert_frame_equal(found, wanted)


def late(one):
    return one.set_axis(TIMES + pd.Timedelta("1s"))


@pytest.mark.parametrize(
    "given, message",
    [
        (lambda t: (t[["radar", "push"]],), r"y has no column 'wheel'; it has \['rad"),
        (lambda t: (t.rename(columns={"push": "u"}), t.rename(columns={"push": "u"})),
         "u has no column 'push'"),
        (lambda t: (t.rename(columns=str.upper),), "rename them, name the plant's, or"),
        (lambda t: (t, late(t)[["push"]]), "give both the same index"),
        (lambda t: (pd.concat({"radar": t, "wheel": t}, axis=1),), "several levels"),
        (lambda t: (t.assign(wheel="7"),), "column 'wheel' of y holds str"),
        (lambda t: (t.assign(wheel=1j),), "column 'wheel' of y holds complex128"),
        (lambda t: (t.assign(wheel=TIMES),), "column 'wheel' of y holds datetime64"),
        (lambda t: (t, t.push.astype(object)), "column 'push' of u holds object"),
        (lambda t: (t.set_axis(["wheel", "radar", "radar"], axis=1),),
         "y has more than one column 'radar'"),
        (lambda t: (t.iloc[:0].assign(**{f"c{k}": [] for k in range(20)})
                    .drop(columns="radar"),), "and 14 more"),
    ],
)  # fmt: skip
def test_tables_that_do_not_fit(given, message):
    observer = lb.kalman_filter(two_sensors())
    with pytest.raises(ValueError, match=message):
        lb.estimate(observer, lb.Record(*given(table())))


def test_inputs_are_not_left_out_by_a_missing_column():
    two = dict(B=np.eye(2), input_names=("push", "slope"))
    with pytest.raises(ValueError, match="y has no column 'slope'"):
        lb.estimate(lb.kalman_filter(two_sensors(**two)), table())


def test_a_name_that_is_input_and_output_needs_two_tables():
    observer = lb.kalman_filter(two_sensors(input_names=("radar",)))
    one = table()
    with pytest.raises(ValueError, match="both called 'radar'"):
        lb.estimate(observer, one)
    lb.estimate(observer, lb.Record(one, one.push))
    with pytest.raises(ValueError, match="both called 'radar'"):
        lb.Filter(two_sensors(input_names=("radar",))).run(one)


def test_a_start_is_found_by_label():
    observer = lb.reduced_order_filter(two_sensors(), 1)
    wanted = lb.estimate(observer, table(), x0=[1, 2])
    for x0 in (pd.Series({"speed": 2, "position": 1.0}), pd.Series([1, 2])):
        found = lb.estimate(observer, table(), x0=x0)
        pd.testing.assert_frame_equal(found, wanted)
    with pytest.raises(ValueError, match=r"labels \['speed', 'place'\], not \['pos"):
        lb.estimate(observer, table(), x0=pd.Series({"speed": 2, "place": 1}))
    nameless = dataclasses.replace(observer, state_names=None)
    with pytest.raises(ValueError, match="x0 is a Series .* nothing has names here"):
        lb.estimate(nameless, table(), x0=pd.Series({"speed": 2, "position": 1}))
    plant = two_sensors()
    first = lb.Filter(plant).run(lb.Record(table(), u0=pd.Series({"push": 3.0}))).x
    pd.testing.assert_frame_equal(
        first, lb.Filter(plant).run(lb.Record(table(), u0=[3.0])).x
    )


def test_pandas_is_never_imported_for_a_caller():
    code = (
        "import sys, luenberger as lb\n"
        "o = lb.Observer([[0.5]], [[]], [[1]], [[1]], [[0]], [[1]], [[1]], dt=1.0)\n"
        "lb.estimate(o, [[1.0], [2.0]])\n"
        "print('pandas' in sys.modules)"
    )
    run = subprocess.run([sys.executable, "-c", code], capture_output=True, text=True)
    assert run.stdout == "False\n", run.stderr
