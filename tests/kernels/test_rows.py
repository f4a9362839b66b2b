"""Exported C in panels of rows: any size and vectors, and what it is said to cost."""

import ctypes
import re
import shutil
import subprocess

import numpy as np
import pytest
from exact_stages import kernel

from luenberger.kernels import cost
from luenberger.kernels.c import C, Module, rows
from luenberger.kernels.c.layouts import chosen
from luenberger.kernels.c.panels import runs
from luenberger.kernels.lowering import lower
from luenberger.kernels.program import Factor
from luenberger.papers.leondes_novak.derivation import (
    arrived,
    complete_sample,
    filter_step,
    predict,
    update,
)

STRICT = "-std=c99 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror".split()
FOUND = ["gcc", "g++"]
needs_compilers = pytest.mark.skipif(
    not all(map(shutil.which, FOUND)), reason="there is no gcc with g++"
)
DEFINITE = ("Q", "R", "Sigma", "Omega", "R_all", "Q_all", "Inverse")
LISTS = {
    "update": update,
    "predict": predict,
    "arrived": arrived,
    "filter step": filter_step,
}
SIZES = [(2, 2, 1), (5, 3, 4), (9, 1, 2), (13, 9, 8), (1, 6, 4)]


def inputs(derivation, sizes):
    rng, given = np.random.default_rng(3), {}
    for symbol in derivation.given:
        shape = [sizes[d.name] if d.is_Symbol else int(d) for d in symbol.shape]
        X = rng.normal(size=shape)
        if symbol.name in DEFINITE:
            X = X @ X.T + np.eye(len(X))
        given[symbol.name] = X
    for name in {"Seen", "Taken"} & set(given):
        seen = np.arange(sizes["p"]) % 3 != 1
        given[name] = np.diag(1.0 * (seen if name == "Seen" else seen & (seen < 0)))
    return given


def written(program, sizes, results, tables=()):
    """The text of a function of the matrices that are no tables, and its cost."""
    to, module = C("double"), Module("unit", "double")
    found = module.steps(program, sizes, to, tables or {}, {}, results)
    names = [k for k in program.given if k not in (tables or {})]
    given = [f"const double {k}[]" for k in names]
    given += [f"double {k}[]" for k, _ in results.values()]
    head = f"int unit({', '.join(given)})"
    text = [*module.table_lines(), f"{head};", head, "{"]
    text += [f"(void){k};" for k in names]
    return "\n".join([*text, *to.lines, "return 0;", "}", ""]), names, found


@pytest.fixture(autouse=True)
def never_scalars(monkeypatch):
    for limit in ("SHORT", "LONG"):
        monkeypatch.setattr(cost, limit, -1)


@needs_compilers
@pytest.mark.parametrize(
    ("stages", "n", "p", "lanes"),
    [
        *((LISTS["filter step"], *sizes) for sizes in SIZES),
        *((LISTS["arrived"], *sizes) for sizes in SIZES[2:4]),
        (LISTS["update"], *SIZES[1]),
        (LISTS["predict"], *SIZES[4]),
    ],
)
def test_panels_of_any_height_and_padding(stages, n, p, lanes, tmp_path):
    """What is given is in tables where n is odd."""
    derivation, sizes = stages(), {"n": n, "p": p, "m": 2}
    given = inputs(derivation, sizes)
    step = kernel(derivation)
    wanted = step(**{k: given[k] for k in step.given})
    program = lower(derivation, symmetric=[k for k in DEFINITE if k in given])
    results = {k: (f"out_{k}", X.size) for k, X in wanted.items()}
    text, names, _ = written(program, sizes, results, given if n % 2 else {})
    (tmp_path / "unit.c").write_text(text)
    command = ["gcc", *STRICT, f"-Dunit_LANES={lanes}", "-shared", "-fPIC"]
    command += ["-O2"] if lanes == 4 else ["-fsanitize=undefined"]  # warnings of both
    command += ["-fno-sanitize-recover", "-o", "unit.so", "unit.c"]
    done = subprocess.run(command, cwd=tmp_path, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    arrays = [np.array(given[k], order="C") for k in names]
    found = {k: np.full(X.shape, np.nan) for k, X in wanted.items()}
    pointers = [X.ctypes.data_as(ctypes.c_void_p) for X in (*arrays, *found.values())]
    assert ctypes.CDLL(str(tmp_path / "unit.so")).unit(*pointers) == 0
    for name, X in wanted.items():
        np.testing.assert_allclose(found[name], X, rtol=0, atol=1e-11 * np.abs(X).max())
    for stage in derivation.stages:
        if stage.symmetric:
            X = found[stage.target.name]
            np.testing.assert_array_equal(X, X.T)


COUNTED = """
#include <cstdio>
static long done = 0;
struct Counted {
    double v;
    Counted(double x = 0) : v(x) {}
    Counted &operator+=(const Counted &o) { done++; v += o.v; return *this; }
    Counted &operator-=(const Counted &o) { done++; v -= o.v; return *this; }
};
#define BINARY(op) static inline Counted operator op(const Counted &a, \
    const Counted &b) { done++; return Counted(a.v op b.v); }
BINARY(+) BINARY(-) BINARY(*) BINARY(/)
static inline Counted operator-(const Counted &a) { return Counted(-a.v); }
static inline bool operator>(const Counted &a, const Counted &b)
{ done++; return a.v > b.v; }
#define restrict
#define unit_LANES 1
"""
CASES = {
    "filter step": (filter_step, {}),
    "definite": (filter_step, dict(definite=[Factor("Sigma_next", 0.0)])),
    "beside": (filter_step, dict(definite=[Factor("Sigma_next", 1e-9, "Omega")])),
    "arrived": (arrived, {}),
    "update": (update, {}),
}


@needs_compilers
@pytest.mark.parametrize(("n", "p"), [(13, 7), (6, 1)])
@pytest.mark.parametrize(("stages", "options"), CASES.values(), ids=CASES)
def test_operations_are_those_that_are_done(stages, options, n, p, tmp_path):
    """The text, compiled with numbers that count what is done with them."""
    derivation, sizes = stages(), {"n": n, "p": p, "m": 2}
    given = inputs(derivation, sizes)
    known = [k for k in DEFINITE if k in given]
    program = lower(derivation, symmetric=known, **options)
    results = {}
    for name, operand in program.results.items():
        size = np.prod(program.shape(operand.name, sizes))
        results[name] = f"out_{name}", int(size)
    tables = {k: X for k, X in given.items() if k in program.given}
    text, _, found = written(program, sizes, results, tables)
    text = re.sub(r"^ +\[\d+ \* \w+\] =", "", text, flags=re.M)
    text = text.replace("double", "Counted")
    outs = "".join(f"static Counted o_{k}[{size}];" for k, size in results.values())
    arguments = ", ".join(f"o_{k}" for k, _ in results.values())
    main = f"int main() {{ int code = unit({arguments});"
    main += ' std::printf("%d %ld", code, done); return 0; }'
    (tmp_path / "unit.cpp").write_text(COUNTED + text + outs + main)
    command = ["g++", "-O0", "-w", "-o", "unit", "unit.cpp"]
    subprocess.run(command, cwd=tmp_path, check=True)
    ran = subprocess.run([tmp_path / "unit"], capture_output=True, text=True)
    code, done = map(int, ran.stdout.split())
    assert code == 0 and found.operations == done
    stored = found.constants  # C and its transpose, and no table twice
    assert sum(X.size for X in tables.values()) <= stored
    assert stored <= 2 * sum(X.size for X in tables.values())


def test_a_matrix_of_one_entry_has_no_rows_to_step_over():
    """`i * 1` and `1 - j` are code without effect, which MISRA's rule 2.2 forbids."""
    program = lower(update(), symmetric=["Omega", "R"])
    results = {k: (f"out_{k}", 1) for k in program.results}
    text, _, _ = written(program, {"n": 6, "p": 1, "m": 2}, results)
    assert "unit_pivots1(" in text and "unit_forward1(" in text
    assert not re.search(r"\b1 [*-]|[*] 1\b|[(]0 [*]", text)


def test_panels_cover_every_row_once():
    for rows_, most in [(1, 4), (4, 4), (5, 4), (13, 6), (14, 6), (52, 6), (100, 6)]:
        covered = [
            i + r
            for first, last, height in runs(rows_, most)
            for i in range(first, last, height)
            for r in range(height)
        ]
        assert covered == list(range(rows_))
        assert max(height for *_, height in runs(rows_, most)) <= most


def test_nothing_is_copied_to_be_read_by_rows():
    """A whole sample: N, Z and the gain are kept so that every product is by rows."""
    program = lower(
        complete_sample(),
        ["x", "Sigma", "x_minus_next", "Omega_next"],
        zero=("E", "Gamma", "B", "J"),
        symmetric=("Q", "R", "Omega"),
        same=[("As", "A")],
    )
    sizes = {"n": 20, "p": 12}
    tables = ("A", "C", "Q", "R")
    assert rows.fits(program, sizes)
    assert chosen(program, sizes, tables).copied() == 2  # A' and C' as tables
    assert chosen(program, sizes, ()).copied() == 20 * 20 + 20 * 12
