"""Types: what goes in is checked, frozen, and comes back from JSON bit for bit."""

import copy
import dataclasses
import json
import pickle

import numpy as np
import pytest

import luenberger as lb

A, C = [[1.0, 1.0], [0.0, 1.0]], [[1.0, 0.0]]


def make(**changes):
    parts = dict(A=A, B=[[0.5], [1.0]], C=C, dt=1.0, Q=np.eye(2), R=[[1.0]]) | changes
    return lb.Plant(parts.pop("A"), parts.pop("B"), parts.pop("C"), **parts)


def test_sizes_and_defaults():
    plant = make()
    assert (plant.n, plant.m, plant.p, plant.steps) == (2, 1, 1, None)
    assert plant.E.shape == (1, 1) and not plant.E.any()
    assert plant.state_names == ("x1", "x2")
    assert (plant.input_names, plant.output_names) == (("u1",), ("y1",))
    assert make(B=None).m == 0


def test_arrays_are_copies_and_read_only():
    mine = np.array(A)
    plant = make(A=mine)
    mine[0, 0] = 7
    assert plant.A[0, 0] == 1
    for name in ("A", "B", "C", "E", "Q", "R", "x0"):
        with pytest.raises(ValueError, match="read-only"):
            getattr(plant, name)[...] = 0


COPIES = {
    "copy": copy.copy,
    "deepcopy": copy.deepcopy,
    **{
        f"pickle {k}": lambda record, k=k: pickle.loads(pickle.dumps(record, k))
        for k in range(2, pickle.HIGHEST_PROTOCOL + 1)
    },
}


def arrays(value):
    """Every array within a record, at any depth."""
    if isinstance(value, np.ndarray):
        yield value
    elif dataclasses.is_dataclass(value):
        yield from arrays(vars(value))
    elif isinstance(value, dict):
        yield from arrays(list(value.values()))
    elif isinstance(value, list | tuple):
        for one in value:
            yield from arrays(one)


def records():
    exact = lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0)
    observer = lb.Observer(**OBSERVER, L=[[1.0]], T0=[[1.0]], G0=[[0.0]])
    noisy = make(multiplicative=[(ODD, C)], P0=np.eye(2), S=[[0.0], [0.0]])
    return noisy, exact, observer, lb.compare(exact, L=[1, 0])


@pytest.mark.parametrize("way", COPIES.values(), ids=COPIES)
def test_copies_are_read_only_too(way):
    for record in records():
        again = way(record)
        mine, theirs = list(arrays(record)), list(arrays(again))
        assert len(mine) == len(theirs) and len(mine) >= 7
        for one, other in zip(mine, theirs):
            assert one.shape == other.shape and (one == other).all()
            assert not other.flags.writeable or one.flags.writeable
        first = dataclasses.fields(again)[0].name
        with pytest.raises(dataclasses.FrozenInstanceError):
            setattr(again, first, None)


def test_a_pickle_from_before_descriptions_is_read_and_read_only():
    plant = full_plant()
    state = {k: X for k, X in vars(plant).items() if k != "description"}
    old = lb.Plant.__new__(lb.Plant)
    old.__dict__.update(state)  # as pickle did without __setstate__
    again = pickle.loads(pickle.dumps(old, 2))
    assert again.description is None and again.name == "odd"
    assert not any(X.flags.writeable for X in arrays(again))


def test_rounding_asymmetry_is_repaired():
    Q = np.eye(2)
    Q[0, 1] = 1e-14
    plant = make(Q=Q)
    assert (plant.Q == plant.Q.T).all()


def test_time_varying_rows_are_held_beyond_the_last():
    stack = np.stack([A, 2 * np.array(A), 3 * np.array(A)])
    plant = make(A=stack)
    assert plant.steps == 3
    assert plant.at(1).A[0, 0] == 2 and plant.at(9).A[0, 0] == 3
    assert plant.at(1).C is plant.C


@pytest.mark.parametrize(
    "changes, message",
    [
        (dict(A=[[1, 2, 3], [4, 5, 6]]), r"A must be square.*2 x 3"),
        (dict(A=[1, 2]), r"A must be a matrix.*shape \(2,\)"),
        (dict(A=[]), "A must be"),
        (dict(A=[[1, 2], [3]]), "A must be an array of real numbers"),
        (dict(A=[[1, "2"], [3, 4]]), "A must be an array of real numbers"),
        (dict(Q=[[1, 2j], [-2j, 4]]), "Q must be an array of real numbers: .*complex"),
        (dict(A=[[1, 10**400], [3, 4]]), "A must be an array of real numbers"),
        (dict(A=[[1, np.nan], [3, 4]]), r"A\[0, 1\] is nan"),
        (dict(B=[[1.0]]), r"B must be 2 x 1, got 1 x 1"),
        (dict(C=[[1, 0, 0]]), r"C must be 1 x 2, got 1 x 3"),
        (
            dict(B=[[0.002, 0]]),
            r"B must have 2 rows, got 1 x 2; write \[\[0.002\], \[0\]\]",
        ),
        (dict(C=[[0], [1]]), r"C must have 2 columns, got 2 x 1; write \[\[0, 1\]\]"),
        (dict(C=[0, 1]), r"it has shape \(2,\); write \[\[0, 1\]\]"),
        (dict(B=[0, 0.5]), r"it has shape \(2,\); write \[\[0\], \[0.5\]\]"),
        (dict(S=[[0, 0.25]]), r"S must be 2 x 1, got 1 x 2; write \[\[0\], \[0.25\]\]"),
        (dict(B=[[1, 2, 3]]), r"B must be 2 x 3, got 1 x 3$"),
        (dict(E=[[1, 0]]), r"E must be 1 x 1, got 1 x 2"),
        (dict(Q=np.eye(3)), r"Q must be 2 x 2, got 3 x 3"),
        (dict(Q=[[1, 0.1], [0.2, 1]]), r"Q must be symmetric: .* by 1\.0e-01 of sqrt"),
        (dict(Q=[[1, 2], [2, 1]]), r"Q must be positive semi-definite.*eigenvalue -1"),
        (dict(R=[[-1]]), "R must be positive semi-definite"),
        (dict(R=[[-1e-12]]), r"R\[0, 0\] on its diagonal is -1e-12"),
        (dict(P0=[[1, 2], [2, 1]]), "P0 must be positive semi-definite"),
        (dict(S=[[1], [1]]), r"\[\[Q, S\], \[S', R\]\] must be positive semi-definite"),
        (dict(S=[[1], [1]], Q=None), "S .* but Q or R is not"),
        (dict(Q=np.diag([0.0, 1.0]), S=[[0.1], [0]]), "positive semi-definite"),
        (dict(dt=-1), "dt must be 0 .* got -1"),
        (dict(dt=None), "dt must be 0"),
        (dict(dt=True), "dt must be 0"),
        (dict(dt=np.inf), "dt must be 0"),
        (dict(x0=[1, 2, 3]), r"x0 must have shape \(2,\), got \(3,\)"),
        (dict(at_first="initial"), "at_first must be True or False"),
        (dict(state_names=["a"]), "state names must be 2 different strings"),
        (dict(state_names=["a", "a"]), "state names must be 2 different strings"),
        (dict(state_names="ab"), "state names must be a list"),
        (dict(multiplicative=[(np.eye(2),)]), "pairs"),
        (dict(multiplicative=[(np.eye(3), C)]), r"multiplicative\[0\] A must be 2 x 2"),
        (dict(A=np.ones((3, 2, 2)), Q=np.ones((4, 2, 2))), "equally many rows"),
        (dict(A=np.ones((0, 2, 2))), "no rows"),
    ],
)
def test_refusal(changes, message):
    with pytest.raises(ValueError, match=message):
        make(**changes)


def test_small_indefinite_block_is_not_hidden_by_a_large_one():
    Q = np.zeros((4, 4))
    Q[:2, :2] = 1e9 * np.eye(2)
    Q[2:, 2:] = 1e-9 * np.array([[1, 2], [2, 1]])
    with pytest.raises(ValueError, match="eigenvalue -1"):
        lb.Plant(np.eye(4), None, np.eye(4), dt=1.0, Q=Q)


ODD = 0.1 + np.arange(4).reshape(2, 2) / 3


def full_plant():
    return lb.Plant(
        ODD,
        [[1e-300], [-0.0]],
        [[1 / 3, 5e-324]],
        [[0.7]],
        dt=0.1,
        Q=ODD @ ODD.T,
        R=[[1e300]],
        S=[[0.1], [0.2]],
        x0=[1, 2],
        P0=np.eye(2) / 7,
        multiplicative=[(ODD, [[1, 2]])],
        at_first=True,
        name="odd",
        description="Two lines\nof a remark.",
        state_names=["position (m)", "v"],
        input_names=["force"],
        output_names=["radar"],
    )


def test_json_round_trip_is_bit_for_bit(tmp_path):
    first = full_plant()
    first.to_json(tmp_path / "plant.json")
    again = lb.Plant.from_json(tmp_path / "plant.json")
    for name in ("A", "B", "C", "E", "Q", "R", "S", "x0", "P0"):
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes(), name
    assert again.multiplicative[0][0].tobytes() == first.multiplicative[0][0].tobytes()
    names = "dt at_first name description state_names input_names output_names"
    for name in names.split():
        assert getattr(first, name) == getattr(again, name)
    again.to_json(tmp_path / "again.json")
    texts = [(tmp_path / f"{name}.json").read_bytes() for name in ("plant", "again")]
    assert texts[0] == texts[1]


def test_json_keeps_empty_and_time_varying_matrices(tmp_path):
    plant = make(B=None, A=np.stack([A, A]))
    plant.to_json(tmp_path / "plant.json")
    again = lb.Plant.from_json(tmp_path / "plant.json")
    assert again.B.shape == (2, 0) and again.A.shape == (2, 2, 2)


def test_json_keeps_pairs_of_a_plant_without_outputs(tmp_path):
    pairs = [(ODD, np.zeros((0, 2))), (A, np.zeros((0, 2)))]
    plant = lb.Plant(A, None, np.zeros((0, 2)), multiplicative=pairs)
    plant.to_json(tmp_path / "p.json")
    again = lb.Plant.from_json(tmp_path / "p.json").multiplicative
    assert [pair[1].shape for pair in again] == [(0, 2), (0, 2)]
    assert again[0][0].tobytes() == ODD.tobytes()


@pytest.mark.parametrize(
    "text, message",
    [
        ("{", "not a JSON file"),
        ("[" * 100_000, "not a JSON file"),
        ("[1]", "a plant is a JSON object, got list"),
        ('{"A": [[NaN]], "C": [[1]]}', "A has entries that are not finite: NaN"),
        ('{"A": [[1e999]], "C": [[1]]}', "A has entries that are not finite"),
        ('{"A": "__import__(\'os\')", "C": [[1]]}', "A must be an array of real"),
        ('{"A": [["1+1"]], "C": [[1]]}', "A must be an array of real numbers"),
        ('{"A": {"shape": [9999999999, 0]}, "C": [[1]]}', "shape"),
        ('{"A": {"x": 1}, "C": [[1]]}', "A must be numbers or lists"),
        ('{"A": [[1]]}', "the plant has no 'C'"),
        ('{"A": [[1]], "C": [[1]], "D": [[1]]}', r"unknown keys \['D'\]"),
        ('{"luenberger": "observer", "A": [[1]]}', "does not hold a plant"),
        ('{"A": [[1]], "C": [[1]], "dt": "1"}', "dt must be 0"),
        ('{"A": [[1]], "C": [[1]], "name": 5}', "name must be a string"),
        ('{"A": [[1]], "C": [[1]], "multiplicative": [[1]]}', "multiplicative"),
        ('{"A": [[1]], "C": [[1]], "state_names": [1]}', "state names"),
        ('{"A": [[1]], "C": [[1]], "multiplicative": 3}', "multiplicative"),
    ],
)
def test_json_is_data_and_bad_data_is_refused(tmp_path, text, message):
    path = tmp_path / "plant.json"
    path.write_text(text)
    with pytest.raises(ValueError, match=message):
        lb.Plant.from_json(path)


def test_a_description_stays_with_its_plant(tmp_path):
    path = tmp_path / "plant.json"
    path.write_text(json.dumps(dict(A=A, C=C, description="a remark")))
    plant = lb.Plant.from_json(path)
    plant.to_json(path)
    others = [lb.Plant.from_json(path), dataclasses.replace(plant, dt=1.0)]
    for one in (plant, *others, *(make(plant) for make in COPIES.values())):
        assert one.description == "a remark"
    path.write_text(json.dumps(dict(A=A, C=C, description=None)))
    assert lb.Plant.from_json(path).description is make().description is None
    with pytest.raises(ValueError, match="description must be text, got 5"):
        make(description=5)


@pytest.mark.parametrize("about", [[1], {"text": "x"}, 3, True])
def test_a_description_is_text(tmp_path, about):
    path = tmp_path / "record.json"
    for cls, keys in ((lb.Plant, "AC"), (lb.Observer, "FGDPVTL")):
        matrices = {key: [[1]] for key in keys}
        path.write_text(json.dumps(matrices | dict(description=about)))
        with pytest.raises(ValueError, match=r"record.json: description must be text"):
            cls.from_json(path)


def test_writing_leaves_the_old_file_when_it_fails(tmp_path, monkeypatch):
    path = tmp_path / "plant.json"
    path.write_text("old")
    monkeypatch.setattr("os.replace", lambda *_: (_ for _ in ()).throw(OSError("full")))
    with pytest.raises(OSError, match="full"):
        make().to_json(path)
    assert path.read_text() == "old"
    assert list(tmp_path.iterdir()) == [path]


OBSERVER = dict(F=[[0.5]], G=[[1.0]], D=[[2.0]], P=[[1.0]], V=[[1.0]], T=[[1.0]])


def test_observer_round_trip_constant_and_over_steps(tmp_path):
    plant = make(P0=np.eye(2), E=[[0.3]], x0=[1, 2])
    for steps in (None, 4):
        first = lb.reduced_order_filter(plant, 1, steps=steps)
        first.to_json(tmp_path / "observer.json")
        again = lb.Observer.from_json(tmp_path / "observer.json")
        for name in ("F", "G", "D", "P", "V", "T", "L", "W", "z0", "T0", "G0"):
            mine, theirs = getattr(first, name), getattr(again, name)
            assert (mine is None) == (theirs is None), name
            assert mine is None or mine.tobytes() == theirs.tobytes(), name
        for kind in ("state", "input", "output"):
            assert getattr(first, f"{kind}_names") == getattr(again, f"{kind}_names")
        assert (again.dt, again.order, again.steps) == (1.0, 1, steps)


DESIGNS = {
    "Kalman": lambda plant: lb.kalman_filter(plant),
    "Leondes-Novak": lambda plant: lb.reduced_order_filter(plant, 1),
    "over steps": lambda plant: lb.reduced_order_filter(plant, 1, steps=3),
    "fixed order": lambda plant: lb.fixed_order_filter(plant, 1, starts=2),
    "reduced order": lambda plant: lb.reduced_order_observer(plant, [0.5]),
    "deadbeat": lambda plant: lb.deadbeat_observer(plant),
    "functional": lambda plant: lb.functional_observer(plant, [[1, 0], [0, 1]]),
}


@pytest.mark.parametrize("design", DESIGNS.values(), ids=DESIGNS)
def test_observers_are_named_after_their_plant(design):
    plant = make(
        A=[[0.9, 1], [0, 0.8]], P0=np.eye(2),
        state_names=("s", "v"), input_names=("push",), output_names=("radar",),
    )  # fmt: skip
    observer = design(plant)
    assert observer.state_names == observer.estimate_names == ("s", "v")
    assert (observer.input_names, observer.output_names) == (("push",), ("radar",))
    assert observer.named(make()).estimate_names == ("x1", "x2")
    assert observer.estimate_names == ("s", "v")  # the first one stays as it was


@pytest.mark.parametrize(
    "states, L, wanted",
    [
        (("s", "v"), [[0, 1], [1, 0]], ("v", "s")),
        (("s", "v"), [[0, 1], [2, 0], [1, 1]], ("v", "w2", "w3")),
        (("s", "v"), [[0, 1], [0, 1]], ("w1", "w2")),  # not the same name twice
        (("s", "w2"), [[0, 1], [1, 1]], ("w1", "w2")),
        (None, [[0, 1j], [0, 1]], ("w1", "x2")),
        (None, np.zeros((0, 2)), ()),
    ],
)
def test_what_estimates_are_called(states, L, wanted):
    q = len(L)
    observer = lb.Observer(
        [[0.5]], [[]], [[1]], np.ones((q, 1)), np.ones((q, 1)), [[1, 0]], L,
        state_names=states,
    )  # fmt: skip
    assert observer.estimate_names == wanted
    assert observer.input_names == () and observer.output_names is None


@pytest.mark.parametrize("kind", ["state", "input", "output"])
def test_names_of_an_observer_are_checked(kind):
    parts = OBSERVER | dict(L=[[1.0]]) | {f"{kind}_names": ("a", "b")}
    with pytest.raises(ValueError, match=f"{kind} names must be 1 different strings"):
        lb.Observer(**parts)


@pytest.mark.parametrize(
    "changes, message",
    [
        (dict(F=[[1, 2]]), "F must be 1 x 1, got 1 x 2"),
        (dict(D=[[1], [2]]), "D must have 1 row, got 2 x 1; write .*1, 2"),
        (dict(F=[[[1.0]]]), "constant or time-varying in all its matrices"),
        (dict(T=[[1.0, 2.0]]), "T must have 1 column, got 1 x 2"),
        (dict(z0=[1, 2]), "z0 must have shape"),
        (dict(dt=None), "dt must be 0"),
    ],
)
def test_observer_refusal(changes, message):
    with pytest.raises(ValueError, match=message):
        lb.Observer(**(OBSERVER | dict(L=[[1.0]]) | changes))


def test_time_varying_observer_must_say_how_it_starts():
    stacked = {name: [value, value] for name, value in OBSERVER.items()}
    with pytest.raises(ValueError, match="needs T0 and G0"):
        lb.Observer(**stacked, L=[[1.0]], dt=1.0)


def test_observer_json_with_missing_matrices_is_refused(tmp_path):
    path = tmp_path / "observer.json"
    path.write_text('{"F": [[1]]}')
    with pytest.raises(ValueError, match=r"the observer has no 'G', 'D'"):
        lb.Observer.from_json(path)


@pytest.mark.parametrize("key", ["posterior", "prior"])
def test_files_say_when_P0_is(tmp_path, key):
    plant = make(P0=np.eye(2), Q=np.eye(2))
    path = tmp_path / "plant.json"
    plant.to_json(path)
    text = path.read_text()
    assert "P0_is" not in text and "at_first" not in text
    path.write_text(text.replace('"dt"', f'"P0_is": "{key}",\n  "dt"', 1))
    assert lb.Plant.from_json(path).at_first == (key == "prior")


def test_a_start_is_carried_to_the_first_sample():
    plant = make(P0=np.diag([1, 2]), Q=np.eye(2), R=np.eye(1), x0=[1, 2])
    ahead = plant.at_first_sample()
    assert np.allclose(ahead.P0, plant.A @ plant.P0 @ plant.A.T + plant.Q)
    assert np.allclose(ahead.x0, plant.A @ plant.x0) and ahead.at_first
    assert ahead.at_first_sample().P0.tobytes() == ahead.P0.tobytes()
    y = [[1.0], [2.0], [0.0]]
    one, other = (lb.Filter(p).run(y) for p in (plant, ahead))
    assert np.allclose(one.x, other.x) and np.allclose(one.P, other.P)


LEVEL = dict(A=[[0.5]], B=[[1]], C=[[1]], dt=1.0, Q=[[1]], R=[[1]])


def test_what_is_known_of_the_input_is_part_of_the_plant(tmp_path):
    model = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[2]], R=[[0]])
    for U in (None, [3.0], [[4.0]], model):
        plant = lb.Plant(**LEVEL, U=U)
        plant.to_json(tmp_path / "plant.json")
        again = lb.Plant.from_json(tmp_path / "plant.json")
        assert again == plant == lb.Plant(**LEVEL).with_input(U)
        assert type(again.U) is type(plant.U)
    np.testing.assert_array_equal(lb.Plant(**LEVEL, U=0).U, [0.0])
    with pytest.raises(ValueError, match="no input and 1 outputs"):
        lb.Plant(**LEVEL, U=lb.Plant(**LEVEL))


def test_an_input_is_sampled_with_its_plant():
    plant = lb.Plant([[-1]], [[1]], [[1]], Q=[[1]], R=[[1]])
    model = lb.Plant([[-2]], None, [[1]], Q=[[1]], R=[[0]])
    assert plant.with_input(model).sampled(0.1).U == model.sampled(0.1)
    kept = plant.with_input(model.sampled(0.1))
    assert kept.sampled(0.1).U == kept.U
    with pytest.raises(ValueError, match="the model U has dt=0.1 but the plant dt=0.2"):
        kept.sampled(0.2)
    np.testing.assert_array_equal(plant.with_input([[4]]).sampled(0.1).U, [[4.0]])
    with pytest.raises(lb.DesignError, match="at even periods only"):
        lb.sampling.discretise(plant.with_input(model), [0.1, 0.2])


def test_equal_plants_and_observers_are_equal_and_hash_alike():
    import copy
    import pickle

    plant = lb.Plant(**LEVEL, estimates={"twice": [2]}, multiplicative=[([[0]], [[1]])])
    for one in (plant, lb.kalman_filter(lb.Plant(**LEVEL))):
        for same in (copy.deepcopy(one), pickle.loads(pickle.dumps(one))):
            assert same == one and hash(same) == hash(one) and same is not one
        assert one != 1 and {one: 2}[copy.copy(one)] == 2
    for change in (dict(Q=[[2]]), dict(estimates=None), dict(name="a"), dict(U=[1])):
        assert dataclasses.replace(plant, **change) != plant
    assert lb.Plant([[-0.0]], None, [[1]]) == lb.Plant([[0.0]], None, [[1]])
    assert lb.Plant([[[0.5]]], None, [[1]]) != lb.Plant([[0.5]], None, [[1]])
    assert lb.Plant([[0.5]], None, [[1]]) != lb.Observer(*[[[0.5]]] * 7)
