"""Exported observers in C compute what Python computes, and say what they are."""

import dataclasses
import re
import shutil
import subprocess

import generators
import numpy as np
import pytest
from compiled_c import SANITIZED, Compiled, gcc, needs_compiler, taken

import luenberger as lb
from luenberger.analysis.step_cost import step_cost
from luenberger.export import to_c

NAN = float("nan")
STEPS = 2000


@pytest.fixture
def compiled(tmp_path):
    return lambda source, **options: Compiled(tmp_path, source, **options)


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
    found, code = unit.run(y, u)
    assert not code.any() and unit.width == q
    wanted = lb.estimate(observer, lb.Record(y, u))
    assert generators.relative(found, wanted) < 1e-12


@needs_compiler
def test_it_starts_where_the_plant_is_known_to_be(compiled):
    """z = T x0: then an observer of a plant without noise is right from the start."""
    source = plant(5, 2, m=0)
    observer = lb.reduced_order_observer(source, [0.5, 0.3, -0.2])
    x = np.arange(1.0, 6)
    unit = compiled(observer)
    for k, right in ((None, False), (x, True)):
        unit.start(k)
        states = [x]
        for _ in range(5):
            states.append(source.A @ states[-1])
        found, _ = unit.run(np.array(states) @ source.C.T)
        assert np.allclose(found, states, atol=1e-9) is right


@needs_compiler
def test_single_precision(compiled):
    rng = np.random.default_rng(1)
    u, y = rng.normal(size=(2000, 1)), rng.normal(size=(2000, 2))
    observer = lb.kalman_filter(tracker())
    unit = compiled(observer, dtype="float")
    found, code = unit.run(y, u)
    assert not code.any() and found.dtype == np.float32
    assert (
        1e-9 < generators.relative(found, lb.estimate(observer, lb.Record(y, u))) < 1e-4
    )
    assert not re.search(r"double|\d\.\d+(?!\d*(f|e))", unit.text)  # no double in it


@needs_compiler
@pytest.mark.parametrize("dtype", ["double", "float"])
@pytest.mark.parametrize("kind", ["Kalman", "no states", "loops", "one estimate"])
def test_a_refused_sample_leaves_no_trace(kind, dtype, compiled):
    """What is no number, or makes none: what follows is as if it had not been."""
    source = OBSERVERS[kind]()
    p, m = source.D.shape[1], source.G.shape[1]
    enlarged = dict(D=8 * source.D, V=8 * source.V)  # no sum of its parts cancels
    unit = compiled(dataclasses.replace(source, **enlarged), dtype=dtype)
    rng, most = np.random.default_rng(3), float(np.finfo(unit.type).max)
    y, u = rng.normal(size=(9, p)), rng.normal(size=(9, m))
    good = np.array([0, 2, 5, 8])
    for k, one in ((1, most), (4, -most), (7, most)):
        y[k] = one * np.resize([1, 0.9, -0.8], p)
    y[3, -1], y[6, 0] = NAN, np.inf
    expected, code = unit.run(y[good], u[good])
    end = unit.state
    assert not code.any()
    u_lost = unit.run(y[:1], u[:1] * NAN)[1][0]
    assert u_lost.tolist() == ["u" in unit.taken[k] for k in ("estimate", "advance")]
    unit.start()
    what, code = unit.run(y, u)
    assert np.flatnonzero(code[:, 0]).tolist() == [1, 3, 4, 6, 7]
    assert (what[code[:, 0] == 1] == 7).all()
    np.testing.assert_array_equal(what[good], expected)
    assert unit.state == end


@needs_compiler
def test_a_reading_that_nothing_uses_is_refused_as_well(compiled):
    D, V = [[1, 0]], [[1, 0]]
    observer = lb.Observer([[0.5]], [[]], D, [[1]], V, T=[[1]], L=[[1]], dt=1)
    assert compiled(observer).run([[1, NAN], [NAN, 1]])[1].all()


@needs_compiler
@pytest.mark.parametrize("part", ["state", "estimate"])
def test_a_state_or_an_estimate_alone_may_overflow(part, compiled):
    D, V = (4, 0) if part == "state" else (0, 4)
    observer = lb.Observer([[0.5]], [[]], [[D]], [[1]], [[V]], T=[[1]], L=[[1]], dt=1)
    unit = compiled(observer, dtype="float")
    what, code = unit.run([[1], [3e38], [2]])
    where = 1 if part == "state" else 0
    assert code[:, where].tolist() == [0, 1, 0] and not code[:, 1 - where].any()
    assert what.ravel().tolist() == ([0, 4, 4] if part == "state" else [4, 7, 8])


FLOAT = dict(dtype="float")
MODULES = {  # source, options, and behind what text a number is damaged
    "observer": (lambda: lb.kalman_filter(tracker()), {}, "_estimate(unit_state"),
    "observer, advance": (lambda: lb.kalman_filter(plant()), {}, "_advance(unit_state"),
    "starts elsewhere": (OBSERVERS["starts elsewhere"], {}, "_init(unit_state"),
    "no inputs": (
        lambda: lb.reduced_order_filter(plant(2, 2, m=0), 2),
        {},
        "_estimate(",
    ),
    "float observer": (lambda: lb.kalman_filter(tracker()), FLOAT, ""),
    "loops": (OBSERVERS["loops"], {}, "unit_F_T["),
    "few": (lambda: plant(3, 2, cross=False), {}, "_advance(unit_state"),
    "few, start": (lambda: plant(3, 2, cross=False), {}, "double D["),
    "S": (lambda: plant(3, 2), {}, "unit_M["),
    "accurate": (lambda: plant(3, 2, cross=False), dict(m1=1), "unit_M["),
    "loops of a filter": (lambda: plant(8, 2, cross=False), {}, "unit_M["),
    "no inputs of a filter": (lambda: plant(2, 2, m=0), {}, "unit_M["),
    "float": (lambda: plant(3, 2, cross=False), FLOAT, ""),
}


@needs_compiler
@pytest.mark.parametrize("made, options, behind", MODULES.values(), ids=MODULES)
def test_a_self_test_agrees_and_notices_damage(made, options, behind, tmp_path):
    code, _ = to_c(made(), tmp_path, name="unit", **options)
    gcc(*SANITIZED, "-Dunit_SELFTEST", "-o", tmp_path / "unit", code)
    run = subprocess.run([tmp_path / "unit"], capture_output=True, text=True)
    assert run.returncode == 0 and run.stderr == ""
    if behind:
        text = code.read_text()
        at = text.index(behind)
        number = re.search(r"\b[1-9]\.\d+|\b0\.\d*[1-9]\d*", text[at:])
        damaged = repr(float(number[0]) * (1 + 1e-4))
        start, end = (at + k for k in number.span())
        code.write_text(text[:start] + damaged + text[end:])
        gcc("-Dunit_SELFTEST", "-o", tmp_path / "unit", code)
        assert subprocess.run([tmp_path / "unit"]).returncode == 1


def test_a_function_takes_what_it_reads(tmp_path):
    def heads(source):
        text = to_c(source, tmp_path, name="unit")[1].read_text()
        early = "in an estimate, at its own instant" in text
        assert early == ("u" in taken(text, "estimate"))
        assert ("act from this sample to the next" in text) == ("u      known" in text)
        return " ".join(taken(text, "estimate")), " ".join(taken(text, "advance"))

    one = lb.kalman_filter(tracker())
    assert heads(one) == ("y what", "u y")
    assert heads(dataclasses.replace(one, W=np.ones((3, 1)))) == ("u y what", "u y")
    assert heads(dataclasses.replace(one, V=0 * one.V, G=0 * one.G)) == ("what", "y")
    assert heads(plant(3, 2)) == ("u y what", "u")
    assert heads(dataclasses.replace(plant(3, 2), E=None)) == ("y what", "u")
    assert heads(plant(3, 2, m=0)) == ("y what", "")


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


@needs_compiler
def test_header_is_for_cplusplus_too(tmp_path):
    compiler = shutil.which("g++")
    if compiler is None:
        pytest.skip("there is no C++ compiler")
    _, header = to_c(tracker(), tmp_path, name="unit")
    command = [compiler, "-Wall", "-Werror", "-fsyntax-only", "-x", "c++", header]
    subprocess.run(command, check=True)


def of_a_step(header, what):
    """What the header gives of a sample."""
    return int(re.search(rf"(\d+) {what}\b", header.read_text())[1])


def test_header_counts_operations(tmp_path):
    """Scalars are counted from the text; loops from their sizes."""
    code, header = to_c(lb.kalman_filter(plant(4, 3)), tmp_path)
    step = code.read_text().partition("int observer_estimate")[2].partition("#ifdef")[0]
    signs = len(re.findall(r" [-+*/] ", step))
    # all are tested: y and, as W is not 0, u twice; what and z
    assert of_a_step(header, "operations") == signs + 2 * (3 + 2) + 4 + 4
    r, p, m = 20, 3, 2
    observer = lb.kalman_filter(plant(r, p))
    _, header = to_c(observer, tmp_path)
    total = of_a_step(header, "operations")
    assert step_cost(observer).operations == total
    advance = int(re.search(r"advance: (\d+) operations", header.read_text())[1])
    assert advance == 2 * r * (r + p + m) + p + m + r < total


def test_zeros_and_ones_cost_nothing(tmp_path):
    shift = np.eye(5, k=-1)
    column = np.eye(5, 1)
    observer = lb.Observer(
        shift, np.zeros((5, 1)), column, np.eye(5), np.zeros((5, 1)), T=np.eye(5),
        L=np.eye(5), dt=1.0,
    )  # fmt: skip
    code, header = to_c(observer, tmp_path)
    assert of_a_step(header, "operations") == 11  # whether y, z and w^ are finite
    assert of_a_step(header, "bytes of state and constants") == 40
    step = code.read_text().partition("int observer_estimate")[2].partition("#ifdef")[0]
    assert " * " not in step and " + " not in step
    dense = to_c(plant(3, 2, m=0, cross=False), tmp_path)[1]
    sparse = to_c(tracker(B=None), tmp_path / "sparse")[1]
    assert of_a_step(sparse, "operations") < 0.6 * of_a_step(dense, "operations")


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
        assert "every 0.5 s" in text and ("(7)" in text or "(33)" in text)
        assert "act from this sample to the next" in text


@pytest.mark.filterwarnings("ignore:overflow", "ignore:invalid value")
def test_a_covariance_that_overflows_at_the_first_sample_is_refused(tmp_path):
    A, one = np.full((3, 3), 1e308), np.eye(3)
    plant = lb.Plant(A, None, one, dt=1.0, Q=one, R=one, P0=one)
    with pytest.raises(ValueError, match="P0 overflows on the way to the first"):
        lb.export.to_c(plant, tmp_path)
