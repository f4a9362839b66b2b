"""What float costs: measured in compiled C, and refused or warned of by name."""

import re
import warnings

import numpy as np
import pytest

import luenberger as lb
from luenberger.cli import main
from luenberger.export import rounding_error, to_c
from luenberger.kernels.c import library

needs_compiler = pytest.mark.skipif(
    library.compiler() is None, reason="there is no C compiler"
)


def tracker(A=((1, 0.5), (0, 1)), B=((0,), (1,)), **changes):
    given = dict(Q=np.diag([0, 0.1]), R=[[0.5]], P0=np.eye(2), dt=0.5,
                 state_names=["position (m)", "speed (m/s)"])  # fmt: skip
    return lb.Plant(A, B, [[1, 0]], **given | changes)


@needs_compiler
def test_a_copy_in_float_is_off_by_what_float_does_to_it():
    """x = y / 3, without a state: the rounding of y, of 1/3 and of their product."""
    plant = lb.Plant([[0.5]], None, [[3]], dt=1.0, Q=[[1]], R=[[0]])
    observer = lb.reduced_order_filter(plant, 1)
    found = rounding_error(observer, plant, steps=500, seed=3)
    y = lb.simulate(plant, observer, 499, seed=3).y
    gap = (np.float32(observer.V[0, 0]) * y.astype(np.float32)).astype(float)
    gap -= observer.V[0, 0] * y[:, 0:1].reshape(gap.shape)
    assert found.largest[0] == np.abs(gap).max() > 0
    assert found.rms[0] == pytest.approx(np.sqrt(np.mean(gap**2)), rel=1e-12)


@needs_compiler
def test_a_filter_in_float_is_off_as_one_of_numpy_in_float_is():
    plant, steps = tracker(), 2000
    observer = lb.kalman_filter(plant)
    u = np.sin(np.arange(steps))[:, None]
    found = rounding_error(observer, plant, steps=steps, seed=5, u=u)
    run = lb.simulate(plant, observer, steps - 1, u=u, seed=5)
    o = {k: getattr(observer, k).astype(np.float32) for k in "FGDPVW"}
    z, off = observer.z0.astype(np.float32), []
    for y, u_i, exact in zip(run.y.astype(np.float32), u.astype(np.float32), run.w_hat):
        off.append(o["P"] @ z + o["V"] @ y + o["W"] @ u_i - exact)
        z = o["F"] @ z + o["G"] @ u_i + o["D"] @ y
    wanted = np.sqrt(np.mean(np.square(off), axis=0))
    assert np.all(found.rms < 3 * wanted) and np.all(wanted < 3 * found.rms)
    sigma = np.sqrt(lb.error_covariance(observer, plant).diagonal())
    assert found.worst == pytest.approx(max(found.largest / sigma), rel=1e-12)
    said = repr(found)
    assert "in float" in said and "2000 samples, seed 5, the u that was given" in said
    assert "position (m): off by at most" in said
    assert "% of its standard deviation" in said


@needs_compiler
def test_double_is_off_by_rounding_only():
    found = rounding_error(lb.kalman_filter(tracker()), tracker(), dtype="double")
    assert found.worst < 1e-8 and "u drawn" in found.record
    narrow = rounding_error(lb.kalman_filter(tracker()), tracker())
    assert 1e3 * found.worst < narrow.worst


@needs_compiler
def test_it_is_measured_with_an_input_of_a_stated_size():
    """A motor at rest is rounded less than one that runs."""
    plant = tracker(A=[[1, 0.5], [0, 0.8]], input_names=["voltage (V)"])
    observer = lb.kalman_filter(plant)
    found = {size: rounding_error(observer, plant, within=size) for size in (0, 1, 600)}
    still = rounding_error(observer, plant, u=np.zeros((10_000, 1)))
    assert (found[0].largest == still.largest).all()
    assert (found[600].reached > 20 * found[1].reached).all()
    assert (found[600].largest > 5 * found[1].largest).all()
    again = rounding_error(observer, plant)
    assert (again.largest == found[1].largest).all()
    for size, one in found.items():
        said = re.search(
            r"\|voltage \(V\)\| <= ([\d.]+), \|y1\| <= ([\d.e+]+)\)", repr(one)
        )
        assert 0.9 * size <= float(said[1]) <= size
        assert float(said[2]) == pytest.approx(one.reached[0], rel=0.05)
    assert "u drawn" in repr(again) and "u that was given" in repr(still)
    without = tracker(B=None)
    record = rounding_error(lb.kalman_filter(without), without, steps=200).record
    assert "u drawn" not in record and record.count("<=") == 1


def test_without_a_compiler_it_says_so(monkeypatch):
    monkeypatch.setattr(library, "compiler", lambda: None)
    with pytest.raises(RuntimeError, match="C compiler, and there is neither"):
        rounding_error(lb.kalman_filter(tracker()), tracker())


@pytest.mark.parametrize(
    ("changes", "options", "message"),
    [
        (dict(Q=None), {}, "the plant lacks Q or R"),
        ({}, dict(dtype="half"), "'double' or 'float'"),
        ({}, dict(steps=1), "steps must be a whole number above 1"),
        ({}, dict(steps=True), "steps must be a whole number"),
        ({}, dict(within=[1, 2]), "within must be a number or 1 of them"),
        ({}, dict(within=-1), "within must be a number or 1 of them, none negative"),
    ],
)
def test_what_cannot_be_measured(changes, options, message):
    observer = lb.kalman_filter(tracker())
    with pytest.raises(ValueError, match=message):
        rounding_error(observer, tracker(**changes), **options)


# -- refused and warned of ----------------------------------------------------------


def slow(pole, gain=1e-3):
    return lb.Observer([[pole]], [[]], [[gain]], [[1]], [[0]], [[1]], [[1]], dt=1.0)


def test_a_mode_that_float_takes_for_one_is_refused(tmp_path):
    observer = slow(1 - 1e-8)
    to_c(observer, tmp_path)
    with pytest.raises(lb.DesignError, match="in float.*not stable.*poles at 1"):
        to_c(observer, tmp_path, dtype="float")


@pytest.mark.parametrize(("off", "warned"), [(5e-5, True), (7e-5, False)])
def test_a_slow_mode_is_warned_of_by_name(off, warned, tmp_path):
    observer = slow(1 - off)
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        to_c(observer, tmp_path)
        assert not caught
        to_c(observer, tmp_path, dtype="float")
    assert bool(caught) is warned
    if warned:
        assert "0.99995" in str(caught[0].message)
        assert "rounding_error" in str(caught[0].message)


@pytest.mark.parametrize(
    ("gain", "message"),
    [(1e-42, r"D\[0, 0\] is 1e-42, too small for float"), (1e39, "beyond the range")],
)
def test_numbers_that_float_has_not_are_refused_by_name(gain, message, tmp_path):
    observer = slow(0.5, gain)
    to_c(observer, tmp_path)
    with pytest.raises(ValueError, match=message):
        to_c(observer, tmp_path, dtype="float")
    with pytest.raises(ValueError, match=message):
        lb.export.multiply_adds(observer, dtype="float")


def test_what_is_rounding_beside_its_row_may_vanish(tmp_path):
    observer = lb.Observer([[0.5]], [[]], [[1, 1e-42]], [[1]], [[0, 0]],
                           T=[[1]], L=[[1]], dt=1.0)  # fmt: skip
    to_c(observer, tmp_path, dtype="float")
    assert lb.export.multiply_adds(observer, dtype="float") == 2
    assert lb.export.multiply_adds(observer) == 3


@needs_compiler
def test_the_command_measures_where_it_is_asked_to(tmp_path, capsys):
    plant = tracker()
    plant.to_json(tmp_path / "plant.json")
    lb.kalman_filter(plant).to_json(tmp_path / "observer.json")
    given = ["export", str(tmp_path / "observer.json"), "--c", str(tmp_path)]
    given.append("--dtype=float")
    beside = ["--plant", str(tmp_path / "plant.json")]
    assert main([*given, *beside]) == 0 and "measured" not in capsys.readouterr().err
    assert main([*given, *beside, "--measure"]) == 0
    out, err = capsys.readouterr()
    assert len(out.splitlines()) == 2
    assert "measured in compiled C on a simulated record of 10000 samples" in err
    assert "speed (m/s): off by at most" in err
    for wrong in (given, ["export", str(tmp_path / "plant.json"), *given[2:]]):
        with pytest.raises(SystemExit) as ended:
            main([*wrong, "--measure"])
        assert ended.value.code == 2 and "--plant" in capsys.readouterr().err
