"""Exported C, compiled without a warning, computes what Python computes."""

import ctypes
import dataclasses
import re
import shutil
import subprocess

import generators
import numpy as np
import pytest
import sympy as sp
from exact_stages import kernel
from own_stages import own

import luenberger as lb
from luenberger.export import to_c
from luenberger.export.c import filter as filter_
from luenberger.export.c import guard
from luenberger.kernels import cost
from luenberger.kernels.c import C, Module
from luenberger.kernels.lowering import lower
from luenberger.numeric.factors import semidefinite
from luenberger.papers.leondes_novak.derivation import arrived, predict, update
from luenberger.symbolic import Solve, Stage

GCC = shutil.which("gcc") or shutil.which("cc")
needs_compiler = pytest.mark.skipif(GCC is None, reason="there is no C compiler")
STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror".split()
SANITIZED = ["-fsanitize=undefined,address", "-fno-sanitize-recover=all"]
NAN = float("nan")
STEPS = 5000

DRIVER = """
#include "NAME.h"
NAME_state state;
void start(void) { NAME_init(&state); }
int run(int N, const REAL *u, const REAL *y, REAL *what, int *code)
{
    for (int k = 0; k < N; k++)
        code[k] = NAME_step(&state, NAME_inputs ? u + k * NAME_inputs : 0,
                            y + k * NAME_outputs, what + k * NAME_estimates);
    return (int)(sizeof state / sizeof(REAL));
}
"""


def gcc(*arguments, check=True):
    command = [GCC, *STRICT, *map(str, arguments), "-lm"]
    done = subprocess.run(command, capture_output=True, text=True)
    assert not check or done.returncode == 0, done.stderr
    return done


class Compiled:
    """An export on its own: `run` returns estimates and the codes of the steps."""

    def __init__(self, folder, source, dtype="double", level="-O0", **options):
        self.type = np.float64 if dtype == "double" else np.float32
        code, self.header = to_c(source, folder, name="unit", dtype=dtype, **options)
        text = DRIVER.replace("NAME", "unit").replace("REAL", dtype)
        (folder / "driver.c").write_text(text)
        self.text = code.read_text()
        gcc(
            level,
            "-shared",
            "-fPIC",
            "-o",
            folder / "unit.so",
            code,
            folder / "driver.c",
        )
        self.library = ctypes.CDLL(str(folder / "unit.so"))
        self.library.start()

    def run(self, y, u, width):
        N = len(y)
        u, y = (np.ascontiguousarray(X, self.type) for X in (u, y))
        what, code = np.full((N, width), 7, self.type), np.zeros(N, np.int32)
        pointers = [X.ctypes.data_as(ctypes.c_void_p) for X in (u, y, what, code)]
        size = self.library.run(N, *pointers)
        kind = ctypes.c_double if self.type == np.float64 else ctypes.c_float
        self.state = np.array((kind * size).in_dll(self.library, "state"))
        return what, code

    def sigma(self, n):
        return self.state[n + n * n :].reshape(n, n)


@pytest.fixture
def compiled(tmp_path, without_a_bound):
    return lambda source, **options: Compiled(tmp_path, source, **options)


unbounded = pytest.mark.usefixtures("without_a_bound")


def tracker(**options):
    A = [[1, 0.5, 0.125], [0, 1, 0.5], [0, 0, 1]]
    given = dict(Q=np.diag([0, 0, 0.1]), R=np.diag([0.5, 2.0]), P0=np.eye(3), dt=0.5)
    given |= dict(B=[[0], [0], [1]], C=np.eye(2, 3))
    return lb.Plant(A, **(given | options))


def plant(n=4, p=3, *, cross=True, m=2, seed=3, **options):
    rng = np.random.default_rng(seed)
    return generators.plant(rng, n, p, m=m, cross=cross, **options)


TALL = np.arange(24.0).reshape(6, 4) % 5 - 2
OBSERVERS = {
    "Kalman": lambda: lb.kalman_filter(tracker()),
    "reduced order": lambda: lb.reduced_order_filter(plant(), 2),
    "chosen poles": lambda: lb.reduced_order_observer(plant(5, 2), [0.5, 0.3, -0.2]),
    "deadbeat": lambda: lb.deadbeat_observer(plant(5, 2)),
    "no states": lambda: lb.reduced_order_filter(plant(3, 3), 3),
    "no inputs": lambda: lb.kalman_filter(plant(m=0)),
    "loops": lambda: lb.kalman_filter(plant(14, 3)),
    "one estimate": lambda: lb.kalman_filter(plant(), L=[1, 0, -2, 0.5]),
    "one estimate, modal": lambda: lb.reduced_order_filter(
        plant(), 1, L=[1, 0, -2, 0.5]
    ).modal("companion"),
    "more estimates than states": lambda: lb.kalman_filter(plant(), L=TALL),
    "two estimates in loops": lambda: lb.kalman_filter(plant(14, 3), L=np.eye(2, 14)),
    "starts elsewhere": lambda: dataclasses.replace(
        lb.kalman_filter(tracker()), z0=[3, -2, 0.1]
    ),
}


@needs_compiler
@pytest.mark.parametrize("observer", OBSERVERS.values(), ids=OBSERVERS)
def test_observer_over_many_steps(observer, compiled):
    observer = observer()
    q, m, p = observer.L.shape[0], observer.G.shape[1], observer.D.shape[1]
    rng = np.random.default_rng(1)
    u, y = rng.normal(size=(STEPS, m)), rng.normal(size=(STEPS, p))
    unit = compiled(observer, level="-O3")
    assert (observer.order == 14) == ("for (int k" in unit.text.partition("#ifdef")[0])
    found, code = unit.run(y, u, q)
    assert not code.any()
    assert re.search(rf"unit_estimates = {q}\b", unit.header.read_text())
    wanted = lb.estimate(observer, y, u)
    assert generators.relative(found, wanted) < 1e-12


@needs_compiler
def test_filter_over_many_steps(compiled):
    rng = np.random.default_rng(1)
    u, y = rng.normal(size=(STEPS, 1)), rng.normal(size=(STEPS, 2))
    unit = compiled(tracker(), m1=1, level="-O3")
    assert "for (int j" not in unit.text.partition("unit_definite")[0]  # no loops
    found, code = unit.run(y, u, 3)
    wanted = lb.Filter(tracker(), 1).run(lb.Record(y, u))
    assert not code.any()
    assert generators.relative(found, wanted.x) < 1e-12
    assert generators.relative(unit.sigma(3), wanted.P) < 1e-12


def with_holes(y, seed=2):
    rng = np.random.default_rng(seed)
    y = np.where(rng.random(y.shape) < 0.3, NAN, y)
    y[[3, 4, 50]] = NAN
    return y


WEIGHT = np.diag([1.0, 4, 1, 2]) + 0.3
FILTERS = {
    "Kalman": dict(),
    "one accurate": dict(m1=1),
    "the last accurate, weighted": dict(m1=[2], weight=WEIGHT),
    "all accurate": dict(m1=3),
}


@needs_compiler
@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S"])
@pytest.mark.parametrize("options", FILTERS.values(), ids=FILTERS)
def test_filter_with_missing_outputs(options, cross, compiled):
    source = plant(cross=cross, at_first=bool(options))
    y, u, _ = generators.record(np.random.default_rng(6), source, 400)
    unit = compiled(source, level="-O0" if options else "-O1", **options)
    for part in (y, with_holes(y)):
        unit.library.start()
        wanted = lb.Filter(source, **options).run(lb.Record(part, u))
        found, code = unit.run(part, u, 4)
        assert not code.any()
        assert generators.relative(found, wanted.x) < 1e-12
        assert generators.relative(unit.sigma(4), wanted.P[-1]) < 1e-12
        np.testing.assert_array_equal(unit.sigma(4), unit.sigma(4).T)


@needs_compiler
@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S"])
def test_larger_filter_runs_in_loops(cross, compiled):
    source = plant(8, 3, cross=cross)
    y, u, _ = generators.record(np.random.default_rng(6), source, 200)
    unit = compiled(source, m1=1, level="-O1" if cross else "-O3")
    assert "for (int j" in unit.text.partition("unit_definite")[0]
    for part in (y, with_holes(y)):
        unit.library.start()
        wanted = lb.Filter(source, 1).run(lb.Record(part, u))
        found, _ = unit.run(part, u, 8)
        assert generators.relative(found, wanted.x) < 1e-12
        assert generators.relative(unit.sigma(8), wanted.P) < 1e-12


@needs_compiler
def test_single_precision(compiled):
    rng = np.random.default_rng(1)
    u, y = rng.normal(size=(2000, 1)), rng.normal(size=(2000, 2))
    observer = lb.kalman_filter(tracker())
    unit = compiled(observer, dtype="float")
    found, code = unit.run(y, u, 3)
    assert not code.any() and found.dtype == np.float32
    assert 1e-9 < generators.relative(found, lb.estimate(observer, y, u)) < 1e-4
    assert not re.search(r"double|\d\.\d+(?!\d*(f|e))", unit.text)  # no double in it


@needs_compiler
def test_filter_in_single_precision(compiled):
    source = tracker()
    y, u, _ = generators.record(np.random.default_rng(6), source, 300)
    unit = compiled(source, dtype="float", m1=1)
    y = with_holes(y)
    found, code = unit.run(y, u, 3)
    assert not code.any()
    wanted = lb.Filter(source, 1).run(lb.Record(y, u))
    assert generators.relative(found, wanted.x) < 1e-4
    assert generators.relative(unit.sigma(3), wanted.P) < 1e-4


def undriven():
    """An unstable mode of no variance: rounding decides where it goes."""
    rng = np.random.default_rng(4)
    V = rng.normal(size=(3, 3))
    A = V @ np.diag([1.3, 0.5, 0.9]) @ np.linalg.inv(V)
    driven = V[:, 1:] @ V[:, 1:].T
    return lb.Plant(A, None, rng.normal(size=(2, 3)), dt=1.0, Q=driven,
                    R=np.eye(2), P0=driven)  # fmt: skip


@needs_compiler
def test_rounding_does_not_make_a_variance_negative(compiled):
    source = undriven()
    y = np.random.default_rng(5).normal(size=(400, 2))
    unit = compiled(source)
    found, code = unit.run(y, np.zeros((400, 0)), 3)
    wanted = lb.Filter(source).run(y)
    assert not code.any()
    assert np.linalg.eigvalsh(unit.sigma(3)).min() > -1e-12
    assert generators.relative(unit.sigma(3), wanted.P) < 1e-6
    # rounding grows until the mode has the variance that settles it; then it is gone
    for part in (slice(10), slice(-100, None)):
        assert generators.relative(found[part], wanted.x[part]) < 1e-9


@unbounded
def test_definiteness_is_tested_where_rounding_could_run_away(tmp_path):
    def tested(source, **options):
        text = to_c(source, tmp_path, **options)[0].read_text()
        fast = text.partition("observer_definite")[0]
        return "Sigma_0_0 > 0.0" in fast or "Sigma_least" in fast

    assert tested(undriven()) and tested(tracker(), m1=1)
    assert not tested(tracker())
    constant = generators.known("a constant")
    assert tested(dataclasses.replace(constant, P0=np.eye(4)))
    for kind in generators.KNOWN:
        for first in (False, True):
            assert not tested(generators.known(kind, first=first))


def test_what_is_known_for_good():
    """A constant is not that was uncertain, has noise, or is moved by another state."""
    constant = generators.known("a constant")

    def known(source):
        now = guard.known_for_good(source.A, source.Q, source.at_first_sample().P0)
        return now.tolist()

    assert known(constant) == [False, False, False, True]
    for name, where in {"P0": (3, 3), "Q": (3, 3), "A": (3, 0)}.items():
        changed = getattr(constant, name).copy()
        changed[where] = 0.5
        for when in (False, True):
            other = dataclasses.replace(constant, at_first=when, **{name: changed})
            assert not any(known(other))
    # one known state moves the next, and an uncertain one the last
    chain = np.diag([0.0, 1, 1], -1) + np.diag([1.0, 1, 1, 1])
    zero = np.zeros((4, 4))
    source = lb.Plant(chain, None, np.eye(1, 4), dt=1.0, Q=zero, P0=zero, R=[[1.0]])
    assert all(known(source))
    moved = dataclasses.replace(source, Q=np.diag([0.0, 1, 0, 0]))
    assert known(moved) == [True, False, False, False]


@unbounded
@needs_compiler
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_repair_is_that_of_the_library(dtype, tmp_path):
    to_c(plant(5, 2), tmp_path, name="unit", dtype=dtype)
    text = f"void repair({dtype} *, const {dtype} *);\n"
    text += (
        f"void repair({dtype} *S, const {dtype} *O) {{ unit_semidefinite(S, O); }}\n"
    )
    (tmp_path / "whole.c").write_text('#include "unit.c"\n' + text)
    gcc("-shared", "-fPIC", "-o", tmp_path / "unit.so", tmp_path / "whole.c")
    repair, rng = (
        ctypes.CDLL(str(tmp_path / "unit.so")).repair,
        np.random.default_rng(7),
    )
    kind, tol = (np.float64, 1e-13) if dtype == "double" else (np.float32, 1e-5)
    for least in (0.5, 0.0, -1e-3, -0.2):
        V, _ = np.linalg.qr(rng.normal(size=(5, 5)))
        units = np.diag([1e3, 1, 1e-3, 1, 50])
        X = units @ (V @ np.diag([least, 0.1, 0.3, 0.3, 0.9]) @ V.T) @ units
        X, Omega = np.array((X + X.T) / 2, kind), np.array(units @ units, kind)
        size = (X + Omega).diagonal().astype(float)
        wanted = semidefinite(X.astype(float), size)
        repair(*(M.ctypes.data_as(ctypes.c_void_p) for M in (X, Omega)))
        inverse = np.linalg.inv(units)
        np.testing.assert_allclose(
            inverse @ X @ inverse, inverse @ wanted @ inverse, rtol=0, atol=tol
        )
        np.testing.assert_array_equal(X, X.T)


@unbounded
@needs_compiler
def test_a_variance_that_is_rounding_moves_no_other(tmp_path):
    """A row of A annihilates what is uncertain: settled beside what it was made of.

    Omega is one that rounding can leave of [[49, 0], [0, 0]]: at unit diagonal its
    second row looks like a variance, whose correlation would move the first.
    """
    h = np.array([2.0, -3])
    source = lb.Plant(
        [[-0.5, 2], [-0.3, -0.2]], None, [[1, 0]], dt=1.0, Q=np.zeros((2, 2)),
        R=[[1.0]], P0=np.outer(h, h),
    )  # fmt: skip
    to_c(source, tmp_path, name="unit")
    text = "void whole(double O[], double S[]);\nvoid whole(double O[], double S[])\n"
    text += "{ unit_settle(O, S, unit_settle_As_T, unit_settle_Q);"
    text += " for (int i = 0; i < 4; i++) S[i] = O[i]; unit_semidefinite(S, O); }\n"
    (tmp_path / "whole.c").write_text('#include "unit.c"\n' + text)
    gcc("-shared", "-fPIC", "-o", tmp_path / "unit.so", tmp_path / "whole.c")
    Omega, Sigma = np.array([[49, 5e-16], [5e-16, 4e-33]]), np.outer(h, h)
    whole = ctypes.CDLL(str(tmp_path / "unit.so")).whole
    whole(*(X.ctypes.data_as(ctypes.c_void_p) for X in (Omega, Sigma)))
    np.testing.assert_allclose(Sigma, [[49, 0], [0, 0]], rtol=1e-15, atol=0)


@unbounded
@needs_compiler
def test_a_small_variance_is_judged_by_its_own_row_of_A(tmp_path):
    """The second state takes all of the first, and gives it next to nothing."""
    source = lb.Plant(
        [[1e-6, 0], [1, 1e-6]], None, [[1, 0]], dt=1.0, Q=np.zeros((2, 2)),
        R=[[1.0]], P0=np.eye(2),
    )  # fmt: skip
    to_c(source, tmp_path, name="unit")
    text = "void whole(double O[], double S[]);\nvoid whole(double O[], double S[])\n"
    text += "{ unit_settle(O, S, unit_settle_As_T, unit_settle_Q); }\n"
    (tmp_path / "whole.c").write_text('#include "unit.c"\n' + text)
    gcc("-shared", "-fPIC", "-o", tmp_path / "unit.so", tmp_path / "whole.c")
    whole = ctypes.CDLL(str(tmp_path / "unit.so")).whole
    for kept, variances in ((True, [1e-16, 1.0]), (False, [1e-28, 1.0])):
        Omega, Sigma = np.diag(variances), np.eye(2)
        whole(*(X.ctypes.data_as(ctypes.c_void_p) for X in (Omega, Sigma)))
        assert (Omega[0, 0] > 0) == kept and Omega[1, 1] == 1


@unbounded
@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S"])
def test_every_way_to_the_next_sample_settles_omega(cross, tmp_path):
    """With every output, and by `predict` where one did not arrive: it comes last."""
    code, _ = to_c(plant(2, 2, cross=cross), tmp_path, name="unit")
    bodies = re.findall(
        r"^static \w+ unit_(\w+)\([^{]*\n{(.*?)^}", code.read_text(), re.M | re.S
    )
    makes = {name: body for name, body in bodies if "state->Omega[0] =" in body}
    assert {"complete", "predict"} <= set(makes)
    for name in ("complete", "predict"):
        text = makes[name]
        assert text.index("unit_settle(") > text.rindex("state->Omega["), name


@needs_compiler
@pytest.mark.parametrize("m1", [0, 1], ids=["Kalman", "treated as exact"])
@pytest.mark.parametrize("unit", [1e-5, 1e-7])
def test_outputs_in_small_units_that_did_not_arrive(unit, m1, compiled):
    """The variance of one in their place took the digits of the others' R."""
    metre = tracker(B=None, R=np.diag([1.0, 4.0]))
    small = dataclasses.replace(metre, C=metre.C * unit, R=metre.R * unit**2)
    y = np.random.default_rng(5).normal(size=(20, 2))
    y[1::3, 0] = y[::3, 1] = NAN
    device = compiled(small, m1=m1)
    found, code = device.run(y * unit, np.zeros((20, 0)), 3)
    assert not code.any()
    wanted = lb.Filter(metre, m1).run(y)
    np.testing.assert_allclose(found, wanted.x, rtol=1e-10, atol=1e-12)
    np.testing.assert_allclose(device.sigma(3), wanted.P, rtol=1e-10, atol=1e-12)


@needs_compiler
def test_outputs_that_see_nothing(compiled):
    """Sigma is then Omega, and its test is made of that; it was a KeyError."""
    blind = tracker(B=None, C=np.zeros((2, 3)))  # A has a mode of 1 without noise
    y = np.ones((3, 2))
    device = compiled(blind)
    found, code = device.run(y, np.zeros((3, 0)), 3)
    assert not code.any()
    wanted = lb.Filter(blind).run(y)
    np.testing.assert_array_equal(found, wanted.x)
    np.testing.assert_allclose(device.sigma(3), wanted.P, rtol=1e-14)


@needs_compiler
@pytest.mark.parametrize("m1", [0, 1], ids=["Kalman", "treated as exact"])
def test_filter_of_one_state(m1, compiled):
    source = lb.Plant(
        [[0.9]], None, [[2.0]], dt=1.0, Q=[[0.5]], R=[[0.25]], P0=[[1.0]], x0=[3.0]
    )
    y = np.random.default_rng(5).normal(size=(40, 1))
    y[::3] = NAN
    unit = compiled(source, m1=m1)
    found, code = unit.run(y, np.zeros((40, 0)), 1)
    wanted = lb.Filter(source, m1).run(y)
    assert not code.any()
    assert generators.relative(found, wanted.x) < 1e-12
    assert generators.relative(unit.sigma(1), wanted.P) < 1e-12


@needs_compiler
def test_known_states_are_filtered_as_in_python(compiled):
    source = tracker(P0=np.zeros((3, 3)))
    y = np.random.default_rng(5).normal(size=(60, 2))
    unit = compiled(source)
    found, code = unit.run(y[:2], np.ones((2, 1)), 3)
    wanted = lb.Filter(source).run(lb.Record(y[:2], np.ones((2, 1))))
    assert not code.any()
    np.testing.assert_allclose(found, wanted.x, rtol=1e-12, atol=1e-14)
    np.testing.assert_allclose(unit.sigma(3), wanted.P, rtol=1e-12, atol=1e-15)


# each kind as scalars and in loops; the known states are first in one of them
KNOWN = [
    (kind, n, (k + (n > 3)) % 2 == 0)
    for k, kind in enumerate(generators.KNOWN)
    for n in (3, 13)
]


@needs_compiler
@pytest.mark.parametrize("kind, n, first", KNOWN)
def test_states_that_are_known_exactly_take_the_fast_way(
    kind, n, first, compiled, monkeypatch
):
    """Where every output arrived, what is for missing ones is not called."""
    if kind == "an oscillator" and n == 3:
        n = 5
    source = generators.known(kind, n, 2, first=first)
    rng = np.random.default_rng(5)
    u, y = rng.normal(size=(60, 1)), rng.normal(size=(60, 2))
    begins = lb.Filter(source).run(lb.Record(y, u))
    write = filter_.source_and_header.source
    missing = "unit_partial(state, u, y, what)"

    def without(module, functions):
        never = f"(refused > 1) ? {missing} : 1"
        return write(module, [text.replace(missing, never) for text in functions])

    monkeypatch.setattr(filter_.source_and_header, "source", without)
    unit = compiled(source)
    found, code = unit.run(y, u, n)
    assert not code.any() and f"(refused > 1) ? {missing}" in unit.text
    np.testing.assert_allclose(found, begins.x, rtol=1e-11, atol=1e-11)
    np.testing.assert_allclose(unit.sigma(n), begins.P, rtol=1e-11, atol=1e-11)
    assert (unit.sigma(n).diagonal()[begins.P.diagonal() == 0] == 0).all()


@needs_compiler
@pytest.mark.parametrize("kind", ["observer", "filter"])
def test_a_refused_sample_changes_nothing(kind, compiled):
    unit = compiled(lb.kalman_filter(tracker()) if kind == "observer" else tracker())
    bad = [[[np.inf, 0], [0]], [[0, 0], [NAN]], [[0, 0], [-np.inf]]]
    bad += [[[0, NAN], [0]]] if kind == "observer" else []
    unit.run([[1.0, 2.0]], [[3.0]], 3)
    before = unit.state
    for y, u in bad:
        what, code = unit.run([y], [u], 3)
        assert code == [1] and (what == 7).all()
        np.testing.assert_array_equal(unit.state, before)


@needs_compiler
@pytest.mark.parametrize("dtype", ["double", "float"])
@pytest.mark.parametrize("kind", ["Kalman", "no states", "loops", "one estimate"])
def test_a_sample_that_overflows_is_refused(kind, dtype, compiled):
    """Neither NaN nor infinity is left: what follows is as if it had not been."""
    source = OBSERVERS[kind]()
    p, m, q = source.D.shape[1], source.G.shape[1], len(source.L)
    enlarged = dict(D=8 * source.D, V=8 * source.V)  # no sum of its parts cancels
    unit = compiled(dataclasses.replace(source, **enlarged), dtype=dtype)
    rng, most = np.random.default_rng(3), float(np.finfo(unit.type).max)
    y, u = rng.normal(size=(9, p)), rng.normal(size=(9, m))
    good = np.array([0, 2, 3, 5, 6, 8])
    for k, one in ((1, most), (4, -most), (7, most)):
        y[k] = one * np.resize([1, 0.9, -0.8], p)
    expected, code = unit.run(y[good], u[good], q)
    end = unit.state
    assert not code.any()
    unit.library.start()
    what, code = unit.run(y, u, q)
    assert np.flatnonzero(code).tolist() == [1, 4, 7] and (what[code == 1] == 7).all()
    np.testing.assert_array_equal(what[good], expected)
    np.testing.assert_array_equal(unit.state, end)


@needs_compiler
@pytest.mark.parametrize("part", ["state", "estimate"])
def test_a_state_or_an_estimate_alone_may_overflow(part, compiled):
    D, V = (4, 0) if part == "state" else (0, 4)
    observer = lb.Observer([[0.5]], [[]], [[D]], [[1]], [[V]], T=[[1]], L=[[1]], dt=1)
    unit = compiled(observer, dtype="float")
    what, code = unit.run([[1], [3e38], [2]], np.zeros((3, 0)), 1)
    assert code.tolist() == [0, 1, 0] and np.isfinite(unit.state).all()
    assert what.ravel().tolist() == ([0, 7, 4] if part == "state" else [4, 7, 8])


@needs_compiler
def test_a_singular_innovation_is_refused(compiled):
    """Two sensors that agree to 1e-20 of what they measure."""
    source = tracker(C=[[1, 0, 0], [1, 0, 0]], P0=np.eye(3) * 1e20)
    unit = compiled(source)
    before = np.array(unit.run(np.zeros((0, 2)), np.zeros((0, 1)), 3)[0])
    what, code = unit.run([[1.0, 2.0]], [[3.0]], 3)
    assert code == [1] and (what == 7).all() and before.size == 0
    assert unit.state[3] > 1e19


MODULES = {
    "observer": lambda: (lb.kalman_filter(tracker()), {}),
    "no inputs, no states": lambda: (lb.reduced_order_filter(plant(2, 2, m=0), 2), {}),
    "filter": lambda: (tracker(), dict(m1=1)),
    "filter without inputs": lambda: (plant(2, 1, m=0), {}),
    "float filter": lambda: (tracker(), dict(dtype="float")),
    "float observer": lambda: (lb.kalman_filter(tracker()), dict(dtype="float")),
}


@unbounded
@needs_compiler
@pytest.mark.parametrize("module", MODULES.values(), ids=MODULES)
def test_self_test_agrees_under_sanitizers(module, tmp_path):
    source, options = module()
    code, _ = to_c(source, tmp_path, name="unit", **options)
    gcc(*SANITIZED, "-Dunit_SELFTEST", "-o", tmp_path / "unit", code)
    run = subprocess.run([tmp_path / "unit"], capture_output=True, text=True)
    assert run.returncode == 0 and run.stderr == ""


@needs_compiler
@pytest.mark.parametrize("number", ["z0", "gain"])
def test_self_test_notices_damage(number, tmp_path):
    observer = lb.kalman_filter(tracker())
    code, _ = to_c(observer, tmp_path, name="unit")
    text = code.read_text()
    if number == "z0":
        broken = text.replace("state->z[0] = 0.0;", "state->z[0] = 1e-3;")
    else:
        value = repr(float(observer.V[0, 0]))
        broken = text.replace(value, repr(float(observer.V[0, 0]) * (1 + 1e-6)), 1)
    assert broken != text
    for source, ends in ((text, 0), (broken, 1)):
        code.write_text(source)
        gcc("-Dunit_SELFTEST", "-o", tmp_path / "unit", code)
        assert subprocess.run([tmp_path / "unit"]).returncode == ends


@needs_compiler
def test_halves_of_two_exports_do_not_compile(tmp_path):
    code, header = to_c(lb.kalman_filter(tracker()), tmp_path)
    old = header.read_text()
    to_c(lb.kalman_filter(tracker(R=np.eye(2))), tmp_path)
    header.write_text(old)
    done = gcc("-c", "-o", tmp_path / "x.o", code, check=False)
    assert done.returncode and "are not of one export" in done.stderr


NASTY = ("*/ int x; /*", "end\\", "??/", "// int y;", "\u00e9//", "/*" * 3)


@needs_compiler
def test_names_stay_inside_comments(tmp_path):
    source = lb.Plant(
        np.eye(6) / 2, np.eye(6), np.eye(6), dt=1.0, Q=np.eye(6), R=np.eye(6),
        P0=np.eye(6), state_names=NASTY, input_names=NASTY, output_names=NASTY,
        name="*/",
    )  # fmt: skip
    observer = lb.kalman_filter(source)
    for one, options in ((observer, {"plant": source}), (source, {"m1": 6})):
        code, header = to_c(one, tmp_path, name="unit", **options)
        assert header.read_text().isascii() and code.read_text().isascii()
        gcc("-trigraphs", "-Wcomment", "-fsyntax-only", code)
        comment = header.read_text().partition("*/")[0]
        assert comment.count('"??') == 0 and comment.count("end\\\\") >= 3


@unbounded
@needs_compiler
def test_header_is_for_cplusplus_too(tmp_path):
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    _, header = to_c(tracker(), tmp_path, name="unit")
    command = [compiler, "-Wall", "-Werror", "-fsyntax-only", "-x", "c++", header]
    subprocess.run(command, check=True)


def said(header, what):
    """The number of operations that the header gives."""
    return int(re.search(rf"{what}: (\d+) operations", header.read_text())[1])


def of_a_step(header, what):
    """What the header of an observer gives of its step."""
    return int(re.search(rf"(\d+) {what}\b", header.read_text())[1])


def test_header_counts_operations(tmp_path):
    """Scalars are counted from the text; loops from their sizes."""
    code, header = to_c(lb.kalman_filter(plant(4, 3)), tmp_path)
    step = code.read_text().partition("int observer_step")[2].partition("#ifdef")[0]
    signs = len(re.findall(r" [-+*/] ", step))
    assert of_a_step(header, "operations") == signs + 3 + 2 + 4 + 4  # all are tested
    r, p, m = 20, 3, 2
    observer = lb.kalman_filter(plant(r, p))
    _, header = to_c(observer, tmp_path)
    assert of_a_step(header, "operations") == 2 * 2 * r * (r + p + m) + p + m + 2 * r


@unbounded
def test_zeros_and_ones_cost_nothing(tmp_path):
    shift = np.eye(5, k=-1)
    column = np.eye(5, 1)
    observer = lb.Observer(
        shift, np.zeros((5, 1)), column, np.eye(5), np.zeros((5, 1)), T=np.eye(5),
        L=np.eye(5), dt=1.0,
    )  # fmt: skip
    code, header = to_c(observer, tmp_path)
    assert of_a_step(header, "operations") == 12  # whether y, u, z and w^ are finite
    assert of_a_step(header, "bytes of state and constants") == 40
    step = code.read_text().partition("int observer_step")[2].partition("#ifdef")[0]
    assert " * " not in step and " + " not in step
    dense = to_c(plant(3, 2, m=0), tmp_path)[1]
    sparse = to_c(tracker(B=None), tmp_path / "sparse")[1]
    what = "a sample with every output"
    assert said(sparse, what) < 0.6 * said(dense, what)


def awkward():
    """Fractions, identities, transposes of sums and of products, a copy, a zero."""
    n, m = sp.symbols("n m", integer=True)
    A, B, S = (sp.MatrixSymbol(k, n, n) for k in "ABS")
    H, x = sp.MatrixSymbol("H", m, n), sp.MatrixSymbol("x", n, 1)
    one = sp.Identity(n)
    X, Y, U, V, W = (sp.MatrixSymbol(k, n, n) for k in "XYUVW")
    y, G = sp.MatrixSymbol("y", m, 1), sp.MatrixSymbol("G", n, m)
    stages = (
        Stage(X, A * (B - 3 * one) * A.T / 7),
        Stage(Y, X.T),
        Stage(U, (A + B).T * Y + 2 * one - B.T - A / 3),
        Stage(V, Solve(U, S)),
        Stage(W, A.T * S * A + A * S * A.T, symmetric=True),
        Stage(y, H * x - H * A.T * x),
        Stage(G, (H * W).T),
    )
    return own((A, B, S, H, x), *stages, symmetric=(S,))


LISTS = {
    "update": update,
    "predict": predict,
    "arrived": arrived,
    "awkward": awkward,
}


@needs_compiler
@pytest.mark.parametrize("constant", [False, True], ids=["given", "tables"])
@pytest.mark.parametrize("stages", LISTS.values(), ids=LISTS)
def test_loops_agree_with_the_generic_kernel(stages, constant, tmp_path):
    derivation, sizes = stages(), {"n": 4, "p": 3, "m": 2}
    rng, given = np.random.default_rng(3), {}
    for symbol in derivation.given:
        shape = [sizes[d.name] if d.is_Symbol else int(d) for d in symbol.shape]
        given[symbol.name] = rng.normal(size=shape)
        if symbol.name in (
            "R",
            "S",
            "Q",
            "Sigma",
            "Omega",
            "R_all",
            "Q_all",
            "Inverse",
        ):
            if shape[0] == shape[1]:
                given[symbol.name] = given[symbol.name] @ given[symbol.name].T
    for name in {"Seen", "Taken"} & set(given):
        given[name] = np.diag([1.0, 0, 1] if name == "Seen" else [0.0, 0, 1])
    step = kernel(derivation)
    wanted = step(**{k: given[k] for k in step.given})
    program = lower(derivation)
    to, module = C("double"), Module("unit", "double")
    tables = given if constant else {}
    results = {k: (f"out_{k}", X.size) for k, X in wanted.items()}
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(cost, "SHORT", -1)  # never scalars
        module.steps(program, sizes, to, tables, {}, results)
    places = [] if constant else [f"const double {k}[]" for k in program.given]
    head = ", ".join(places + [f"double out_{k}[]" for k in results])
    prototype = f"int unit({head})"
    text = [*module.table_lines(), f"{prototype};", prototype, "{", *to.lines]
    (tmp_path / "unit.c").write_text("\n".join([*text, "return 0;", "}", ""]))
    gcc("-shared", "-fPIC", "-o", tmp_path / "unit.so", tmp_path / "unit.c")
    found = {k: np.full(X.shape, np.nan) for k, X in wanted.items()}
    arrays = [] if constant else [np.array(given[k], order="C") for k in program.given]
    pointers = [X.ctypes.data_as(ctypes.c_void_p) for X in (*arrays, *found.values())]
    assert ctypes.CDLL(str(tmp_path / "unit.so")).unit(*pointers) == 0
    for name, X in wanted.items():
        np.testing.assert_allclose(found[name], X, rtol=0, atol=1e-12 * np.abs(X).max())


def test_text_is_the_same_every_time(tmp_path):
    for source, options in ((lb.kalman_filter(tracker()), {}), (plant(), {"m1": 1})):
        texts = set()
        for folder in ("a", "b"):
            pair = to_c(source, tmp_path / folder, **options)
            texts.add(tuple(path.read_bytes() for path in pair))
        assert len(texts) == 1


def test_header_says_what_every_argument_is(tmp_path):
    names = dict(output_names=("position (m)", "speed (m/s)"), input_names=("jerk",))
    source = tracker(**names, state_names=("s (m)", "v (m/s)", "a (m/s2)"))
    observer = lb.reduced_order_filter(source, 1)
    for one, options in ((observer, {"plant": source}), (source, {"m1": 1})):
        text = to_c(one, tmp_path, **options)[1].read_text()
        for label in ('[0]  "jerk"', '[1]  "speed (m/s)"', '[2]  "a (m/s2)"'):
            assert label in text
        assert "every 0.5 s" in text and ("(7)" in text or "(27)" in text)
    kept = re.search(r"state and constants, in doubles: (\d+) and", text)[1]
    assert kept == "168"  # x_minus, Omega, Sigma


@needs_compiler
@pytest.mark.parametrize("m1", [0, 1])
def test_before_the_first_sample_sigma_is_the_covariance_of_the_prediction(
    m1, compiled
):
    """x- = A x0 with no input, and Omega = A P0 A' + Q for both covariances."""
    start = dict(x0=[1.0, -2.0, 0.5], P0=np.diag([1.0, 0.5, 2.0]))
    source = tracker(**start)
    unit = compiled(source, m1=m1)
    unit.run(np.zeros((0, 2)), np.zeros((0, 1)), 3)  # no step
    Omega = source.A @ source.P0 @ source.A.T + source.Q
    np.testing.assert_array_equal(unit.state[:3], source.A @ source.x0)
    np.testing.assert_allclose(unit.state[3:12].reshape(3, 3), Omega, rtol=1e-15)
    np.testing.assert_array_equal(unit.sigma(3), unit.state[3:12].reshape(3, 3))


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")
def test_a_covariance_that_overflows_at_the_first_sample_is_refused(tmp_path):
    """By what overflows: the P0 that was given is finite."""
    A, one = np.full((3, 3), 1e308), np.eye(3)
    plant = lb.Plant(A, None, one, dt=1.0, Q=one, R=one, P0=one)
    with pytest.raises(ValueError, match="P0 overflows on the way to the first"):
        lb.export.to_c(plant, tmp_path)
