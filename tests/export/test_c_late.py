"""Exported C that takes readings late is `filter_data` with arrivals."""

import ctypes
import shutil
import subprocess

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.export import to_c

GCC = shutil.which("gcc") or shutil.which("cc")
pytestmark = pytest.mark.skipif(GCC is None, reason="there is no C compiler")
STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror".split()
SANITIZED = ["-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
SIZE = """
#include "unit.h"
int size(void);
int size(void) { return (int)sizeof(unit_state); }
"""


def gcc(*arguments):
    command = [GCC, *STRICT, *map(str, arguments), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


class Device:
    """An export, driven sample by sample; `state` is all that it keeps."""

    def __init__(self, folder, plant, **options):
        code, self.header = to_c(plant, folder, name="unit", **options)
        (folder / "size.c").write_text(SIZE)
        library = folder / "unit.so"
        gcc("-shared", "-fPIC", "-o", library, code, folder / "size.c")
        self.unit = ctypes.CDLL(str(library))
        self.unit.unit_arrived.argtypes = [
            ctypes.c_void_p, ctypes.c_int, ctypes.c_int, ctypes.c_double,
            ctypes.c_void_p,
        ]  # fmt: skip
        self.state = ctypes.create_string_buffer(self.unit.size())
        self.what = np.full(plant.n, 7.0)
        self.unit.unit_init(self.state)

    def step(self, u, y):
        u, y = (np.ascontiguousarray(X, float) for X in (u, y))
        pointers = [X.ctypes.data_as(ctypes.c_void_p) for X in (u, y, self.what)]
        return self.unit.unit_step(self.state, *pointers)

    def arrived(self, output, age, y):
        what = self.what.ctypes.data_as(ctypes.c_void_p)
        return self.unit.unit_arrived(self.state, output, age, y, what)


CASES = {
    "one late": dict(n=3, p=2, m=1, cross=False, late=[0], horizon=4),
    "all late, S": dict(n=3, p=2, m=0, cross=True, late=2, horizon=7),
    "loops, S": dict(n=4, p=3, m=2, cross=True, late=[2], horizon=20),
    "one sample": dict(n=2, p=1, m=0, cross=False, late=["y1"], horizon=1),
}


def made(n, p, m, cross, **options):
    rng = np.random.default_rng(n + p)
    names = [f"y{j + 1}" for j in range(p)]
    plant = generators.plant(rng, n, p, m=m, cross=cross, output_names=names)
    y, u, _ = generators.record(rng, plant, 60)
    return plant, generators.holes(rng, y), u, options


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
def test_readings_in_any_order(case, tmp_path):
    plant, y, u, options = made(**case)
    late = options["late"]
    late = range(late) if isinstance(late, int) else [0] if late == ["y1"] else late
    rng, rows = np.random.default_rng(1), np.arange(len(y))
    arrival = np.repeat(rows[:, None].astype(float), plant.p, axis=1)
    for j in late:
        arrival[:, j] += rng.integers(0, options["horizon"] + 1, size=len(y))
    wanted = lb.filter_data(plant, y, u, arrival=arrival)
    device, found = Device(tmp_path, plant, **options), []
    for i in rows:
        assert device.step(u[i], np.where(arrival[i] == i, y[i], np.nan)) == 0
        for k, j in np.argwhere((arrival == i) & (rows[:, None] < i)).tolist():
            if not np.isnan(y[k, j]):
                assert device.arrived(j, i - k, y[k, j]) == 0
        found.append(device.what.copy())
    assert generators.relative(np.array(found), wanted.x) < 1e-11
    N = plant.n + plant.p + options["horizon"] * len(list(late))
    P = np.frombuffer(device.state)[N : N + N * N].reshape(N, N)[: plant.n, : plant.n]
    assert generators.relative(P, wanted.P) < 1e-11


@pytest.mark.parametrize("case", CASES.values(), ids=CASES)
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_the_selftest_passes(case, dtype, tmp_path):
    plant, _, _, options = made(**case)
    code, _ = to_c(plant, tmp_path, name="unit", dtype=dtype, **options)
    program = tmp_path / "unit"
    gcc(*SANITIZED, "-Dunit_SELFTEST", "-o", program, code)
    assert subprocess.run([program]).returncode == 0


def test_what_is_refused_leaves_the_state_as_it_was(tmp_path):
    plant, y, u, options = made(**CASES["one late"])
    y = np.nan_to_num(y)
    device = Device(tmp_path, plant, **options)

    def refused(done, *arguments):
        before, what = bytes(device.state), device.what.copy()
        assert done(*arguments) == 1
        assert bytes(device.state) == before
        np.testing.assert_array_equal(device.what, what)

    refused(device.arrived, 0, 0, 1.0)  # before any sample
    for k in range(8):
        assert device.step(u[k], [np.nan, y[k, 1]]) == 0
    for output, age in ((0, 5), (0, -1), (1, 1), (2, 1), (-1, 1)):
        refused(device.arrived, output, age, 1.0)
    for value in (np.nan, np.inf):
        refused(device.arrived, 0, 2, value)
    refused(device.step, u[0], [np.inf, 0])
    refused(device.step, [np.nan], [0, 0])
    assert device.arrived(0, 4, y[3, 0]) == 0
    refused(device.arrived, 0, 4, y[3, 0])  # twice
    assert device.arrived(0, 0, y[7, 0]) == 0
    refused(device.arrived, 0, 0, y[7, 0])


def test_the_header_says_what_it_is(tmp_path):
    plant, _, _, options = made(**CASES["one late"])
    text = to_c(plant, tmp_path, name="unit", **options)[1].read_text()
    for words in ("may arrive up to 4 samples late", "int unit_arrived(", "y1"):
        assert words in text


REFUSED = {
    "no horizon": (dict(late=[0]), "need horizon="),
    "no outputs": (dict(horizon=3), "names no output"),
    "half": (dict(late=[0], horizon=2.5), "got 2.5"),
    "none": (dict(late=[0], horizon=0), "got 0"),
    "m1": (dict(late=[0], horizon=2, m1=1), "leave out m1"),
    "unknown": (dict(late=["gps"], horizon=2), "'gps' is not an output"),
}


@pytest.mark.parametrize("options, words", REFUSED.values(), ids=REFUSED)
def test_what_makes_no_sense_is_refused(options, words, tmp_path):
    plant = made(**CASES["one late"])[0]
    with pytest.raises(ValueError, match=words):
        to_c(plant, tmp_path, **options)
    assert not list(tmp_path.iterdir())


def test_late_goes_with_a_plant(tmp_path):
    observer = lb.kalman_filter(made(**CASES["one late"])[0])
    with pytest.raises(ValueError, match="late goes with a plant"):
        to_c(observer, tmp_path, late=[0], horizon=2)
