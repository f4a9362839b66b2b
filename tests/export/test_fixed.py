"""An observer in whole numbers: exact counts, no overflow, ranges, and refusals."""

import ctypes
import shutil
import subprocess
from fractions import Fraction

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.commands import main
from luenberger.export import rounding_bound, to_c
from luenberger.export.c import fixed
from luenberger.export.c.fit import fitted
from luenberger.export.c.formats import SUM, Row, largest, places
from luenberger.export.c.source_and_header import signals
from luenberger.kernels.c.library import library

GCC = shutil.which("gcc") or shutil.which("cc")
needs_compiler = pytest.mark.skipif(GCC is None, reason="there is no C compiler")
STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror".split()
SANITIZED = ["-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
RANGES = {"u1": 1.0, "y1": 10.0}


def tracker(drive=0.1, B=((0,), (1,)), C=((1, 0),), R=((0.5,),), **changes):
    given = dict(Q=np.diag([0, drive]), R=R, P0=np.eye(2), dt=0.5)
    return lb.Plant([[1, 0.5], [0, 1]], B, C, **given | changes)


def wide(n=5, p=2):
    plant = generators.plant(np.random.default_rng(3), n, p, m=2)
    return lb.kalman_filter(plant), {f"u{i}": 1.1 for i in (1, 2)} | {
        f"y{i + 1}": 9.7 for i in range(p)
    }


OBSERVERS = {
    "tracker": lambda: (lb.kalman_filter(tracker()), RANGES),
    "not at zero first": lambda: (lb.kalman_filter(tracker(x0=[2, 1 / 3])), RANGES),
    "no states": lambda: (lb.reduced_order_filter(tracker(C=np.eye(2), R=np.eye(2)), 2),
                          {"u1": 1.0, "y1": 3.3, "y2": 7.0}),
    "no inputs": lambda: (lb.kalman_filter(tracker(B=None)), {"y1": 1e-6}),
    "wide": wide,
    "far units": lambda: (lb.kalman_filter(tracker(
        Q=np.diag([0, 0.1e24]), R=[[0.5e24]], P0=np.eye(2) * 1e24)),
        {"u1": 1e12, "y1": 1e13}),
}  # fmt: skip


def fit(observer, ranges, bits):
    return fitted(observer, bits, signals(observer), None, ranges)


# -- in fractions ----------------------------------------------------------------------


@pytest.mark.parametrize("bits", SUM)
@pytest.mark.parametrize("made", OBSERVERS.values(), ids=OBSERVERS)
def test_counts_are_within_the_bound_of_exact_estimates(made, bits):
    observer, ranges = made()
    found, bound = fit(observer, ranges, bits)
    rng, size = np.random.default_rng(1), np.array(list(ranges.values()))
    readings = rng.uniform(-1, 1, (80, len(size))) * size
    readings[::7] = size * np.sign(readings[::7])
    counts = [
        [round(Fraction(x) * Fraction(2) ** k) for x, k in zip(row, found.read)]
        for row in readings.tolist()
    ]
    assert all(abs(c) <= m for row in counts for c, m in zip(row, found.most))
    z = [Fraction(one) for one in observer.z0.tolist()]
    o = observer
    rows = np.vstack([np.hstack([o.F, o.G, o.D]), np.hstack([o.P, o.W, o.V])]).tolist()
    for shown, reading in zip(found.run(counts), readings.tolist(), strict=True):
        s = [*z, *map(Fraction, reading)]
        dot = [
            sum(Fraction(a) * b for a, b in zip(row, s, strict=True)) for row in rows
        ]
        z, exact = dot[: o.order], dot[o.order :]
        for c, k, w, most in zip(shown, found.shown, exact, bound.largest.tolist()):
            assert abs(c) <= largest(bits)
            assert abs(Fraction(c) / Fraction(2) ** k - w) <= Fraction(most)


@pytest.mark.parametrize("bits", SUM)
@pytest.mark.parametrize("made", OBSERVERS.values(), ids=OBSERVERS)
def test_no_sum_can_leave_its_whole_number(made, bits):
    observer, ranges = made()
    found, _ = fit(observer, ranges, bits)
    most = [*[largest(bits)] * len(found.state), *found.most]
    for row in (*found.moves, *found.shows):
        assert max(map(abs, row.weights)) <= largest(bits)
        total = sum(abs(w) * m for w, m in zip(row.weights, most, strict=True))
        assert total + 2 ** (row.shift - 1) <= largest(SUM[bits])
        assert 1 <= row.shift <= SUM[bits] - 2
    sizes = found.limits.state + found.limits.state_error
    room = [float(Fraction(largest(bits)) / Fraction(2) ** k) for k in found.state]
    assert (sizes[:, 0] <= room).all()
    assert all(m < largest(bits) for m in found.most)


def test_a_row_is_rounded_to_nearest_halves_away_from_zero():
    row = Row((3, -5), 2)
    for a in range(-9, 10):
        for b in range(-9, 10):
            exact = Fraction(3 * a - 5 * b, 4)
            gap = row([a, b]) - exact
            assert abs(gap) <= Fraction(1, 2)
            assert abs(gap) < Fraction(1, 2) or gap * exact > 0
    assert row.rounds and not Row((4, -8), 2).rounds


@pytest.mark.parametrize("size", [1.0, 0.1, 3.3, 127.0, 1e-30, 1e30, 254.0, 255.0])
def test_places_are_the_most_that_fit(size):
    k = places(size, 127)
    assert Fraction(size) * Fraction(2) ** k <= 127
    assert Fraction(size) * Fraction(2) ** (k + 1) > 127


def test_a_copy_in_its_own_places_is_not_rounded_again():
    """y1 itself, where both have the same places: only its reading is rounded."""
    plant = lb.Plant(np.eye(1), None, np.eye(1), dt=1.0, Q=[[1.0]], R=[[0.0]])
    observer = lb.reduced_order_filter(plant, 1)
    found, bound = fit(observer, {"y1": 100.0}, 16)
    assert found.read == found.shown == (8,)
    assert bound.largest[0] == pytest.approx(2.0**-9, rel=1e-6)


def one_state(F, z0=0.0):
    """z_next = F z + y, of which z is shown."""
    return lb.Observer(
        [[F]], np.zeros((1, 0)), [[1.0]], [[1.0]], [[0.0]],
        T=[[1.0]], L=[[1.0]], z0=[z0], dt=1.0,
    )  # fmt: skip


def test_a_state_that_its_error_takes_beyond_has_one_place_less():
    """By hand: 32766 counts are reached, and 1.5 more by rounding of y and of z."""
    found, _ = fit(one_state(0.5), {"y1": 32766 / 2**15}, 16)
    assert found.most == (32766,) and found.read == (15,)
    assert places(found.limits.state[0, 0], largest(16)) == 14
    assert found.state == (13,)


@pytest.mark.parametrize("dtype, bits", [("float", None), ("fixed", 16)])
def test_what_the_first_state_lacks_is_an_error(dtype, bits):
    """1/3 as it is in float, or in counts; nothing else is rounded but y."""
    given = dict(dtype=dtype, bits=bits, ranges={"y1": 2.0**-14})
    first = rounding_bound(one_state(0.0, 1 / 3), **given).largest[0]
    none = rounding_bound(one_state(0.0, 0.25), **given).largest[0]
    k = fit(one_state(0.0, 1 / 3), {"y1": 2.0**-14}, 16)[0].state[0]
    near = float(np.float32(1 / 3)) if bits is None else round(2**k / 3) / 2**k
    assert first - none == pytest.approx(abs(near - 1 / 3), rel=0.02)


# -- in C ------------------------------------------------------------------------------


def program(folder, code, *options):
    made = folder / "selftest"
    command = [GCC, *STRICT, *options, "-Dunit_SELFTEST", code, "-o", made, "-lm"]
    done = subprocess.run(list(map(str, command)), capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return subprocess.run([str(made)]).returncode


@needs_compiler
@pytest.mark.parametrize("bits", SUM)
@pytest.mark.parametrize("made", OBSERVERS.values(), ids=OBSERVERS)
def test_c_counts_as_python_does(made, bits, tmp_path, monkeypatch):
    observer, ranges = made()
    for most in (1000, 0):  # products one by one, and loops
        monkeypatch.setattr(fixed, "UNROLLED", most)
        given = dict(dtype="fixed", bits=bits, ranges=ranges)
        code, _ = to_c(observer, tmp_path, name="unit", **given)
        assert ("unit_row" in code.read_text()) is (most == 0)
        assert program(tmp_path, code, *SANITIZED) == 0
    assert program(tmp_path, code, "-O3") == 0


@needs_compiler
def test_the_selftest_notices_a_wrong_weight(tmp_path):
    observer, ranges = OBSERVERS["tracker"]()
    code, _ = to_c(
        observer, tmp_path, name="unit", dtype="fixed", bits=16, ranges=ranges
    )
    text = code.read_text()
    made, _ = fit(observer, ranges, 16)
    weight = f"({made.moves[0].weights[0]} * z0)"
    assert weight in text
    code.write_text(text.replace(weight, f"({made.moves[0].weights[0] + 9} * z0)", 1))
    assert program(tmp_path, code, "-O1") == 1


class Compiled:
    """The library of one export, with a state of its own."""

    def __init__(self, observer, ranges, bits, folder):
        code, head = to_c(
            observer, folder, name="unit", dtype="fixed", bits=bits, ranges=ranges
        )
        keep = '#include "unit.h"\nunit_state kept;\n'
        texts = {p.name: p.read_text() for p in (code, head)} | {"kept.c": keep}
        self.library = library(texts, "no")
        self.kind = ctypes.c_int16 if bits == 16 else ctypes.c_int32
        self.r, self.q = observer.order, len(observer.P)
        self.state = (self.kind * max(self.r, 1)).in_dll(self.library, "kept")
        self.library.unit_counts.argtypes = [ctypes.c_double] * 2
        self.library.unit_counts.restype = self.kind
        self.library.unit_value.argtypes = [self.kind, ctypes.c_double]
        self.library.unit_value.restype = ctypes.c_double
        self.library.unit_init(ctypes.byref(self.state))

    def step(self, u, y):
        what = (self.kind * self.q)(*[7] * self.q)
        given = [(self.kind * max(len(x), 1))(*x) for x in (u, y)]
        code = self.library.unit_step(ctypes.byref(self.state), *given, what)
        return code, list(what)


@needs_compiler
@pytest.mark.parametrize("bits", SUM)
def test_what_is_beyond_its_range_is_cut_and_reported(bits, tmp_path):
    observer, ranges = OBSERVERS["tracker"]()
    unit = Compiled(observer, ranges, bits, tmp_path)
    made, _ = fit(observer, ranges, bits)
    u, y = made.most
    full = largest(bits)
    for given, code, cut in (
        ((u, y), 0, (u, y)),
        ((u + 1, y), 1, (u, y)),
        ((-full, -full), 1, (-u, -y)),
        ((-u, -y), 0, (-u, -y)),
        ((0, full), 1, (0, y)),
    ):
        before = list(unit.state)
        wanted = [row([*before, *cut]) for row in made.shows]
        assert unit.step([given[0]], [given[1]]) == (code, wanted)
        assert list(unit.state) == [row([*before, *cut]) for row in made.moves]


@needs_compiler
@pytest.mark.parametrize("bits", SUM)
@pytest.mark.parametrize("where", ["u", "y"])
def test_no_number_is_refused_and_nothing_is_touched(where, bits, tmp_path):
    unit = Compiled(*OBSERVERS["tracker"](), bits, tmp_path)
    unit.step([3], [5])
    before, none = list(unit.state), -largest(bits) - 1
    given = {"u": ([none], [5]), "y": ([3], [none])}[where]
    assert unit.step(*given) == (2, [7, 7])
    assert list(unit.state) == before and any(before)


@needs_compiler
@pytest.mark.parametrize("bits", SUM)
def test_values_become_the_nearest_counts(bits, tmp_path):
    unit = Compiled(*OBSERVERS["tracker"](), bits, tmp_path).library
    full = largest(bits)
    for value, counts in (
        (0.0, 0), (1.0, 4), (0.1, 0), (0.125, 1), (-0.125, -1), (0.13, 1), (-0.3, -1),
        (full / 4, full), (full, full), (-full, -full), (np.inf, full), (1e300, full),
        (-np.inf, -full), (np.nan, -full - 1), (full / 4 - 0.2, full - 1),
    ):  # fmt: skip
        assert unit.unit_counts(value, 4.0) == counts, value
    assert unit.unit_value(-3, 4.0) == -0.75


@needs_compiler
def test_the_worst_signs_do_not_overflow(tmp_path):
    """Undefined behaviour would end the program; every reading is beyond its range."""
    observer, ranges = wide(14, 3)
    code, _ = to_c(
        observer, tmp_path, name="unit", dtype="fixed", bits=16, ranges=ranges
    )
    made, _ = fit(observer, ranges, 16)
    main = """
#include "unit.h"
int main(void)
{
    unit_state state; int16_t u[unit_inputs], y[unit_outputs], what[unit_estimates];
    uint64_t drawn = 1;
    unit_init(&state);
    for (int k = 0; k < 100000; k++) {
        drawn ^= drawn << 13; drawn ^= drawn >> 7; drawn ^= drawn << 17;
        for (int i = 0; i < unit_inputs; i++)
            u[i] = (int16_t)((drawn >> i) & 1U ? 32767 : -32767);
        for (int i = 0; i < unit_outputs; i++)
            y[i] = (int16_t)((drawn >> (i + 9)) & 1U ? 32767 : -32767);
        if (unit_step(&state, u, y, what) != 1) return 1;
    }
    return 0;
}
"""
    (tmp_path / "main.c").write_text(main)
    made = tmp_path / "main"
    command = [
        GCC,
        "-std=c99",
        *SANITIZED,
        tmp_path / "main.c",
        code,
        "-o",
        made,
        "-lm",
    ]
    subprocess.run(list(map(str, command)), check=True)
    assert subprocess.run([str(made)]).returncode == 0


# -- refusals --------------------------------------------------------------------------


def test_too_few_bits_are_refused_and_it_says_how_many_would_do():
    """An estimate in 16 bits has no digit that is sure."""
    slow, ranges = lb.kalman_filter(tracker(drive=1e-14, B=None)), {"y1": 10.0}
    message = (
        "16 bits do not suffice: the estimate 'x.' may be off by .*, and is itself"
    )
    with pytest.raises(lb.DesignError, match=f"{message}.*32 bits would do: give bits"):
        rounding_bound(slow, dtype="fixed", bits=16, ranges=ranges)
    wide = rounding_bound(slow, dtype="fixed", bits=32, ranges=ranges)
    assert (wide.largest < 1e-4).all()


@pytest.mark.parametrize(
    "F, P, message",
    [
        (
            [[0.99999, 0], [0, 0.5]],
            [[1, 1]],
            "rounding the weights makes the error grow",
        ),
        ([[0.5, 0], [0, 0.5]], [[1e6, -1e6]], "'x1' is a sum of parts that are much"),
    ],
)
def test_what_does_not_fit_says_why(F, P, message):
    observer = lb.Observer(
        F, np.zeros((2, 0)), [[1.0], [1.0]], P, [[1.0]],
        T=np.zeros((2, 1)), L=[[1.0]], dt=1.0,
    )  # fmt: skip
    with pytest.raises(lb.DesignError, match=message):
        rounding_bound(observer, dtype="fixed", bits=16, ranges={"y1": 1.0})


def test_ranges_and_bits_are_needed():
    observer = lb.kalman_filter(tracker())
    with pytest.raises(
        ValueError, match="bits must be 16 or 32 with dtype='fixed', got 8"
    ):
        rounding_bound(observer, dtype="fixed", bits=8, ranges=RANGES)
    with pytest.raises(ValueError, match="range of 'u1', 'y1' is not known"):
        rounding_bound(observer, dtype="fixed", bits=16)


@pytest.mark.parametrize(
    "given, message",
    [
        (dict(dtype="fixed", bits=16), "dtype='fixed' goes with an observer"),
        (dict(bits=16), "bits goes with dtype='fixed'"),
    ],
)
def test_a_filter_is_not_written_in_whole_numbers(given, message, tmp_path):
    with pytest.raises(ValueError, match=message):
        to_c(tracker(), tmp_path, **given)


def test_the_header_says_what_a_count_is(tmp_path):
    names = dict(input_names=["push */"], output_names=['the "speed"'])
    observer = lb.kalman_filter(tracker(**names))
    ranges = {"push */": 1.0, 'the "speed"': 10.0}
    given = dict(dtype="fixed", bits=16, ranges=ranges)
    _, header = to_c(observer, tmp_path, name="unit", **given)
    text, found = header.read_text(), fit(observer, ranges, 16)[0]
    assert f"#define unit_u0_ONE {2.0 ** found.read[0]}" in text
    assert f"#define unit_y0_ONE {2.0 ** found.read[1]}" in text
    assert f"#define unit_what1_ONE {2.0 ** found.shown[1]}" in text
    assert '"push * /" is at most 1.0 in size,' in text
    assert "of order 2 in whole numbers of 16 bits" in text
    assert "summed in 32 bits" in text


# -- on the command line ---------------------------------------------------------------


@pytest.fixture
def command(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    observer = lb.kalman_filter(tracker())
    observer.to_json("observer.json")

    def call(*options):
        status = main(["export", "observer.json", "--c", "here", *options])
        return status, "".join(capsys.readouterr())

    return call


def test_the_command_writes_what_the_function_does(command, tmp_path):
    given = ["--dtype", "fixed", "--bits", "16", "--range", "u1=1", "--range", "y1=10"]
    assert command(*given)[0] == 0
    to_c(lb.kalman_filter(tracker()), "there", dtype="fixed", bits=16, ranges=RANGES)
    for name in ("observer.c", "observer.h"):
        made = (tmp_path / "here" / name).read_bytes()
        assert made == (tmp_path / "there" / name).read_bytes()


@pytest.mark.parametrize(
    "options, status, message",
    [
        (
            ["--dtype", "fixed", "--range", "u1=1", "--range", "y1=10"],
            1,
            "must be 16 or",
        ),
        (["--dtype", "fixed", "--bits", "16"], 1, "range of 'u1', 'y1' is not known"),
        (["--dtype", "fixed", "--float"], 2, "--float and --dtype fixed exclude"),
        (["--range", "y1"], 2, "'y1' must be SIGNAL=SIZE"),
        (["--range", "y1=1", "--range", "y1=2"], 2, "names a signal twice"),
        (["--bits", "16"], 1, "bits goes with dtype='fixed'"),
    ],
)
def test_the_command_says_what_is_wrong(command, options, status, message, capsys):
    try:
        found, said = command(*options)
    except SystemExit as stop:
        found, said = stop.code, capsys.readouterr().err
    assert found == status and message in said
