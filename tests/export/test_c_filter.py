"""A plant's filter in C finds what Python finds: in few states bit for bit."""

import dataclasses
import re
import subprocess

import generators
import numpy as np
import pytest
from compiled_c import Compiled, gcc, needs_compiler

import luenberger as lb
from luenberger.export import to_c
from luenberger.filtering import passes
from luenberger.filtering.maps import Settings
from luenberger.filtering.pack import begin, packed
from luenberger.filtering.passes import State, Tape

pytestmark = needs_compiler
NAN = float("nan")
UNFUSED = ["-ffp-contract=off"]


@pytest.fixture
def compiled(tmp_path):
    return lambda source, **options: Compiled(tmp_path, source, **options)


def plant(n=4, p=3, *, cross=False, m=1, seed=3, correlated=True, **options):
    found = generators.plant(np.random.default_rng(seed), n, p, m=m, cross=cross)
    found = dataclasses.replace(found, **options)
    R = found.R if correlated else np.diag(found.R.diagonal())
    return dataclasses.replace(found, R=R)


def in_python(source, y, u, m1=0, weight=None):
    """`passes.forward`, every operation where it is written: x and variances."""
    settings = Settings(source, m1, weight)
    end = begin(settings, np.zeros(source.m))
    pack = packed(settings, end, y, u)
    state = State(*(X.copy() for X in end.state))
    n, p, N = source.n, source.p, len(state.z)
    tape = Tape(*(np.empty((0, *shape)) for shape in
                  ((n,), (N,), (N, N), (N,), (p, N), (p,), (p,))))  # fmt: skip
    x, variances = np.empty((len(y), n)), np.empty((len(y), n))
    given = *pack.part(), state, x, variances, tape
    assert passes.forward.exact(*given) == -1
    return x, variances


def a_record(source, steps=300, seed=6):
    y, u, _ = generators.record(np.random.default_rng(seed), source, steps)
    return generators.holes(np.random.default_rng(2), y), u


# n, options: statements, and loops; noises of outputs that nothing shares
ALONE = {
    "one state": (1, dict(p=1, m=0, correlated=False)),
    "few": (4, dict(correlated=False)),
    "few, x[1] is known": (4, dict(correlated=False, at_first=True)),
    "few, some outputs exact": (5, dict(correlated=False, R=np.diag([0, 0.5, 0]))),
    "six": (6, dict(correlated=False)),
    "many": (9, dict(correlated=False)),
}


@pytest.mark.parametrize("n, options", ALONE.values(), ids=ALONE)
@pytest.mark.parametrize("level", ["-O0", "-O3"])
def test_it_has_the_bits_of_python(n, options, level, compiled):
    source = plant(n, **options)
    y, u = a_record(source)
    unit = compiled(source, level=level, flags=UNFUSED)
    assert ("unit_predict" in unit.text) is (n > 6)
    found, code = unit.run(y, u)
    assert not code.any()
    x, variances = in_python(source, y, u)
    np.testing.assert_array_equal(found, x)
    np.testing.assert_array_equal(unit.variances, variances)


WEIGHT = np.diag([1.0, 4, 1, 2]) + 0.3
FILTERS = {
    "Kalman": (4, {}),
    "loops": (8, {}),
    "one accurate": (4, dict(m1=1)),
    "the last accurate, weighted": (4, dict(m1=[2], weight=WEIGHT)),
    "all accurate": (4, dict(m1=3)),
    "canonical": (4, dict(m1=2, weight="canonical")),
    "one accurate, loops": (8, dict(m1=1)),
}


@pytest.mark.parametrize("cross", [False, True], ids=["S = 0", "S"])
@pytest.mark.parametrize("n, options", FILTERS.values(), ids=FILTERS)
def test_it_filters_complete_records_and_gaps(n, options, cross, compiled):
    source = plant(n, cross=cross, m=2, at_first=bool(options))
    y, u, _ = generators.record(np.random.default_rng(6), source, 200)
    unit = compiled(source, **options)
    for part in (y, generators.holes(np.random.default_rng(2), y)):
        unit.start()
        found, code = unit.run(part, u)
        assert not code.any()
        x, variances = in_python(source, part, u, **options)
        assert generators.relative(found, x) < 1e-12
        assert generators.relative(unit.variances, variances) < 1e-12
    if not options:
        wanted, P, _ = generators.kalman(source, part, u, np.zeros(source.m))
        assert generators.relative(found, wanted) < 1e-9
        assert generators.relative(unit.variances, P.diagonal(0, 1, 2)) < 1e-9


@pytest.mark.parametrize("seed", range(60))
def test_singular_plants_of_small_integers_are_filtered_exactly(seed, compiled):
    """Beside the oracle in rational arithmetic: any rank of Q, R, P0 and of S."""
    source, y, u, u0 = generators.integer_plant(seed)
    y[np.random.default_rng(seed).random(y.shape) < 0.2] = NAN
    x, P = generators.exact(source, y, u, u0)
    unit = compiled(source, level="-O0")
    ahead = source.A @ source.x0 + source.B @ u0
    unit.start(ahead, None)
    found, code = unit.run(y, u)
    assert not code.any()
    size = np.abs(x).max() + np.sqrt(P.diagonal(0, 1, 2)).max() + 1
    np.testing.assert_allclose(found, x, rtol=0, atol=1e-9 * size)
    scale = np.abs(P).max() + 1
    np.testing.assert_allclose(
        unit.variances, P.diagonal(0, 1, 2), rtol=0, atol=1e-9 * scale
    )


@pytest.mark.parametrize("n", [3, 8])
@pytest.mark.parametrize("dtype", ["double", "float"])
def test_a_reading_that_contradicts_what_is_known_is_refused(n, dtype, compiled):
    """The last output repeats the first, which has no noise; two changes nothing."""
    C = np.eye(3, n)
    C[2] = C[0]
    source = lb.Plant(np.eye(n), None, C, dt=1.0, Q=np.eye(n), R=np.diag([0, 1.0, 0]),
                      P0=np.eye(n))  # fmt: skip
    unit = compiled(source, dtype=dtype)
    near = 3 + (1e-9 if dtype == "double" else 1e-5)  # the rounding of a sensor's text
    good, bad = [[1.0, 2.0, 1.0], [3.0, 1.0, near]], [3.0, 1.0, 3.5]
    found, code = unit.run([*good, bad])
    assert code[:, 0].tolist() == [0, 0, 2] and (found[2] == 7).all()
    np.testing.assert_allclose(found[:2, 0], [1, 3], rtol=1e-6)
    after, unsaid = unit.state, [NAN] * 3
    unit.start()
    unit.run([*good, unsaid])  # the state is what it was
    assert unit.state == after


SOME = [[0, 0, 0], [0, 1, 0.4], [0, 0.4, 2]]  # one is exact, two share noises
LAWS = {
    "few": (3, dict(correlated=False), {}),
    "some exact": (3, dict(R=np.diag([0, 1.0, 0.5])), {}),
    "correlated": (3, dict(R=np.diag([2, 1, 0.5]) + 0.3), {}),
    "correlated, one exact": (3, dict(R=np.array(SOME)), {}),
    "S": (3, dict(cross=True), {}),
    "accurate": (3, {}, dict(m1=1)),
    "loops": (7, {}, {}),
}


def ahead(source, y, u, m1=0):
    """The members of a state ahead of the row behind a record, by `passes`."""
    settings = Settings(source, m1)
    end, unsaid = begin(settings, np.zeros(source.m)), [[NAN] * source.p]
    pack = packed(settings, end, np.vstack([y, unsaid]), np.vstack([u, 0 * end.u]))
    maps, at, (z, V, D, E, e) = pack.maps, pack.at, (X.copy() for X in end.state)
    n, N, g = source.n, len(z), maps.G.shape[2]
    wide, met = N + g + maps.O.shape[2] * source.p, np.abs(z)
    for t, row in enumerate(pack.part()[0]):
        if (s := at[t]) >= 0:
            given = maps.M[s], maps.B[s], maps.G[s], maps.X[s], maps.d[s]
            passes.predict.on()(
                *given, pack.drive[t], z, V, D, E, e, np.zeros((n, wide)),
                np.zeros(wide), np.zeros(n), met, np.zeros((0, n)), np.zeros(wide),
            )  # fmt: skip
        C, r = maps.C[at[t + 1]], maps.r[at[t + 1]]
        for j in range(source.p):
            e[j] = 0
            if not np.isnan(row[j]):
                pivot, *_ = passes.read.on()(
                    row[j], V, D, C[j], r[j], z, met, E[j], np.zeros(N)
                )
                e[j] = passes.over.on()(1, pivot)
    return dict(x=z, met=met, D=D, V=V)


@pytest.mark.parametrize("n, changes, more", LAWS.values(), ids=LAWS)
def test_its_state_is_that_of_python(n, changes, more, compiled):
    """After each start, complete rows and partial ones: all that is kept of them."""
    source = plant(n, 3, at_first=True, **changes)
    y, u, _ = generators.record(np.random.default_rng(6), source, 5)
    x0, sigma0 = np.arange(1.0, n + 1), np.arange(n) / 2
    unit = compiled(source, **more)
    starts = (None, None), (x0, None), (None, sigma0), (x0, sigma0), (x0, sigma0)
    gaps = [], [[3, 1]], [[4, 0]], [[1, 0], [4, 2]], [[4, 0], [4, 1]]
    for start, missing in zip(starts, gaps):
        P0 = None if start[1] is None else np.diag(sigma0**2)
        given = {k: X for k, X in zip(("x0", "P0"), (start[0], P0)) if X is not None}
        for t, j in missing:
            y[t, j] = NAN
        for rows in range(len(y) + 1):
            unit.start(*start)
            assert not unit.run(y[:rows], u[:rows])[1].any()
            found = unit.numbers()[1]
            begun = dataclasses.replace(source, **given)
            wanted = ahead(begun, y[:rows], u[:rows], **more)
            if len(found["V"]) < n * n:  # what is above the diagonal of U
                wanted["V"] = wanted["V"][np.tril_indices(n, -1)]
            for k in {*found} - {"E", "e"}:
                exact = np.ravel(wanted[k])
                np.testing.assert_allclose(found[k][: exact.size], exact, 1e-9, 1e-9)


@pytest.mark.parametrize("n, changes, more", LAWS.values(), ids=LAWS)
def test_what_is_refused_leaves_no_trace(n, changes, more, compiled):
    """Whatever a state is: behind a call it is finite, or all is as it was."""
    source = plant(n, 3, E=np.ones((3, 1)), **changes)
    unit = compiled(source, **more)
    y, u, _ = generators.record(np.random.default_rng(6), source, 3)
    unit.run(y[:2], u[:2])
    good, (start, found) = unit.state, unit.numbers()
    kept = len(start) - len(found.get("e", ()))  # an estimate begins with new weights
    most, inf, last = np.finfo(float).max, np.inf, np.full(3, NAN)
    rows = [y[2], [y[2, 0], NAN, NAN], [NAN, y[2, 1], NAN], last]
    calls = [(start, y_, u[2]) for y_ in rows]
    for y_ in ([inf, 0, 0], [0, NAN, -inf], [most, -most, most], [most, NAN, NAN]):
        calls += [(start, y_, u_) for u_ in (u[2], [-most])]
    calls += [(start, y_, [u_]) for y_ in rows for u_ in (NAN, inf)]
    for where in (*range(len(start)), slice(0, n), slice(None)):
        for bad in (inf, -inf, NAN, most, -most):
            state = start.copy()
            state[where] = bad
            calls += [(state, y_, u[2]) for y_ in rows]
    for bad in (most, -most):  # the estimate alone may be infinite, or no number is
        state, found = unit.numbers()
        found["x"][:], found["D"][:] = bad, 0
        calls += [(state, y_, u[2]) for y_ in [*rows, [0, 0, inf], [-inf, 0, 0]]]
    done = 0
    for state, y_, u_ in calls:
        given = state.tobytes() + good[state.nbytes :]
        for function in ("estimate", "advance"):
            what = np.full(n, 7.0)
            code, after = unit.call(function, given, y=y_, u=u_, what=what)
            numbers = np.frombuffer(after, count=len(state))
            if code:
                assert after == given and (what == 7).all()
            else:
                assert np.isfinite(numbers).all() and np.isfinite(what).all()
            done += not code
            if function == "estimate":
                wrong = np.isinf(y_).any() or not np.isfinite(u_).all()
                lost = y_ is last and not np.isfinite(state[:kept]).all()
                assert code == 1 or not (wrong or lost)
            elif not np.isfinite(u_).all():
                assert code == 1
    assert done > len(calls) / 4


@pytest.mark.parametrize("n, more", [(3, {}), (3, dict(m1=1)), (8, {})])
def test_samples_that_measure_nothing_need_no_estimate(n, more, tmp_path):
    """`advance` twice is a sample without a reading."""
    source = plant(n, 2, m=0, cross=bool(more))
    code, _ = to_c(source, tmp_path, name="unit", **more)
    (tmp_path / "main.c").write_text("""
#include <math.h>
#include <string.h>
#include "unit.h"
int main(void)
{
    static unit_state a, b;
    double y[2] = {1.5, -2.0}, none[2] = {NAN, NAN}, one[N], two[N];
    unit_init(&a, 0, 0); unit_init(&b, 0, 0);
    unit_advance(&a);
    unit_estimate(&b, none, two); unit_advance(&b);
    unit_estimate(&a, y, one); unit_advance(&a); unit_advance(&a);
    unit_estimate(&b, y, two); unit_advance(&b);
    unit_estimate(&b, none, two); unit_advance(&b);
    unit_estimate(&a, y, one); unit_estimate(&b, y, two);
    return memcmp(one, two, sizeof one) != 0;
}
""")
    gcc(f"-DN={n}", "-o", tmp_path / "main", code, tmp_path / "main.c")
    assert subprocess.run([tmp_path / "main"]).returncode == 0


@pytest.mark.parametrize("n", [3, 8])
@pytest.mark.parametrize("options", [{}, dict(m1=1)], ids=["Kalman", "accurate"])
def test_single_precision(n, options, compiled):
    source = plant(n, 2, seed=4)
    y, u = a_record(source)
    unit = compiled(source, dtype="float", **options)
    found, code = unit.run(y, u)
    assert not code.any() and found.dtype == np.float32
    x, variances = in_python(source, y, u, **options)
    assert 1e-9 < generators.relative(found, x) < 1e-4
    assert generators.relative(unit.variances, variances) < 1e-4
    assert not re.search(r"double|\d\.\d+(?!\d*(f|e))", unit.text)  # no double in it


def undriven():
    """An unstable mode of no variance: rounding decides where it goes."""
    rng = np.random.default_rng(4)
    V = rng.normal(size=(3, 3))
    A = V @ np.diag([1.3, 0.5, 0.9]) @ np.linalg.inv(V)
    driven = V[:, 1:] @ V[:, 1:].T
    return lb.Plant(A, None, rng.normal(size=(2, 3)), dt=1.0, Q=driven,
                    R=np.eye(2), P0=driven)  # fmt: skip


@pytest.mark.parametrize("dtype, rows", [("double", 400), ("float", 300)])
def test_rounding_does_not_make_a_variance_negative(dtype, rows, compiled):
    """In float the rounding of x, times 1.3 in each row, has no number at 400."""
    unit = compiled(undriven(), dtype=dtype)
    _, code = unit.run(np.random.default_rng(5).normal(size=(rows, 2)))
    assert not code.any() and (unit.variances > 0).all()


@pytest.mark.parametrize("kind", generators.KNOWN)
def test_what_is_known_for_good_has_no_variance(kind, compiled):
    source = generators.known(kind, n=5)
    y, u = a_record(source, 60)
    unit = compiled(source)
    found, code = unit.run(y, u)
    wanted, P, _ = generators.kalman(source, y, u, np.zeros(1))
    assert not code.any() and generators.relative(found, wanted) < 1e-9
    known = np.abs(P.diagonal(0, 1, 2)) < 1e-12
    assert (unit.variances[known] == 0).all() and known.any()


@pytest.mark.parametrize("growth, rows", [(10, 6), (1e3, 3)])
def test_a_self_test_is_as_long_as_there_are_digits(growth, rows, tmp_path):
    """A mode that grows and that no output shows: a shorter record, but never none."""

    def exported(growth):
        source = lb.Plant(np.diag([0.5, growth]), None, [[1, 0]], dt=1.0, Q=np.eye(2),
                          R=[[1]], P0=np.eye(2))  # fmt: skip
        return to_c(source, tmp_path, name="unit")[0]

    code = exported(growth)
    text = code.read_text()
    assert f"k < {rows}; k++" in text
    damaged = text.replace("z_0 * 0.5", "z_0 * 0.4999999")
    assert damaged != text
    for written, ends in ((text, 0), (damaged, 1)):
        code.write_text(written)
        gcc("-Dunit_SELFTEST", "-o", tmp_path / "unit", code)
        assert subprocess.run([tmp_path / "unit"]).returncode == ends
    with pytest.raises(lb.DesignError, match="digits"):
        exported(1e6)


def test_header_says_what_a_sample_costs(tmp_path):
    """Scalars as they stand there; loops as they run."""

    def said(source, **options):
        code, header = to_c(source, tmp_path, name="unit", **options)
        head = header.read_text()
        found = [int(x) for x in re.findall(r"(?:estimate|advance): (\d+) op", head)]
        assert int(re.search(r"a sample: (\d+) operations", head)[1]) == sum(found)
        return code.read_text(), found, head

    text, found, head = said(plant(3, 2, correlated=False))
    for name, count in zip(("estimate", "advance"), found):
        body = text.partition(f"int unit_{name}(")[2].partition("\n}\n")[0]
        signs = r" (?:[-+*/<>]|[-+=!]=) "
        assert count == len(re.findall(signs, body)) + 9  # whether they are finite
    assert "120 bytes of state" not in head and "state: 72 and" in head.replace(
        "in doubles", "state"
    )
    for n in (8, 16):
        _, found, _ = said(plant(n, 2, correlated=False))
        assert 0.5 < found[1] / (3 * n**3) < 4  # 2 n columns of n rows


@pytest.mark.parametrize("cross, m1", [(True, 1), (False, 7)])
def test_too_many_choices_of_outputs_are_refused(cross, m1, tmp_path):
    """Those that are treated as exact; where noises are shared, all of them."""
    many = plant(8, 7, cross=cross)
    with pytest.raises(lb.DesignError, match="on which of 7 outputs arrive"):
        to_c(many, tmp_path, m1=m1)


@pytest.mark.parametrize("m1", [[5], [2, 7]])
def test_outputs_that_change_no_matrix_may_be_many(m1, compiled):
    source = plant(4, 9)
    y, u = a_record(source, 100)
    unit = compiled(source, m1=m1)
    found, code = unit.run(y, u)
    assert not code.any()
    x, variances = in_python(source, y, u, m1)
    assert generators.relative(found, x) < 1e-12
    assert generators.relative(unit.variances, variances) < 1e-12
