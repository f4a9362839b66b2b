"""A solve is given up where its matrix is singular to working precision, only there.

M = [[1, 1], [1, 1 + d]], at the end of a larger identity, has the last pivot d.  Beside
its diagonal entry that is the part of an output that the others do not tell.  Every
printer draws the line where `solve_right` does: there NumPy takes a pseudo-inverse.
"""

import ctypes
import shutil
import subprocess

import numpy as np
import pytest
import sympy as sp
from own_stages import own

from luenberger.kernels import numba, scalars, solves
from luenberger.kernels.c import C, Module
from luenberger.kernels.loops import arrays, write, write_definite
from luenberger.kernels.lowering import lower
from luenberger.kernels.program import Factor
from luenberger.numeric.linalg import solve_right
from luenberger.symbolic import Solve, Stage

n = sp.Symbol("n", integer=True)
N, M, X = (sp.MatrixSymbol(k, n, n) for k in "NMX")
SIZES = [2, 4, solves.SHORT_SOLVE, solves.SHORT_SOLVE + 1, 11]


def program(**options):
    derivation = own((M, N), Stage(X, Solve(N, M)), symmetric=(M, N))
    return lower(derivation, symmetric=("M", "N"), **options)


def matrix(size, d):
    out = np.eye(size)
    out[-2, -1] = out[-1, -2] = 1.0
    out[-1, -1] = 1.0 + d
    return out


def defined(head, lines):
    """The function that the printed lines are."""
    space = {"np": np}
    exec("\n".join([f"def {head}:", *lines]), space)

    def quiet(*args):
        with np.errstate(all="ignore"):  # printed code goes on where a pivot is 0
            return space[head.partition("(")[0]](*args)

    return quiet


def python_loops(M, N, **options):
    """Whether the loops, run as Python, solve X M = N; and X."""
    size = len(M)
    sizes, to, steps = {"n": size}, numba.Python(1), program(**options)
    for name, length in arrays(steps, sizes, to).items():
        to.let(name, f"np.full({length}, np.nan)")
    to.let("ok", "True")
    write(steps, sizes, to)
    write_definite(steps, sizes, to)
    to.line("return ok, X")
    ok, found = defined("step(M, N)", to.lines)(M.ravel(), N.ravel())
    return ok, found.reshape(size, size)


def python_scalars(M, N, **options):
    straight = scalars.unroll(program(**options), {"n": len(M)}, None)
    values = dict(M=M, N=N)
    space = {e: values[k][i, j] for k, one in straight.given.items() for i, j, e in one}
    for one in straight.statements:
        value = eval(one.text, {}, space)
        if isinstance(one, scalars.Let):
            space[one.name] = value
        elif not value:
            return False, None
    table = straight.entries["X"]
    return True, np.array([[space.get(e, e) for e in row] for row in table], float)


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("run", [python_loops, python_scalars])
def test_the_line_is_that_of_the_numpy_kernel(run, size):
    above, below = matrix(size, 1.5e-13), matrix(size, 0.6e-13)
    ok, found = run(above, above)
    assert ok
    np.testing.assert_allclose(found, np.eye(size), atol=1e-2)  # 1 % of the pivot
    assert not run(below, below)[0]
    assert not run(matrix(size, 0.0), matrix(size, 0.0))[0]
    assert np.abs(solve_right(np.eye(size), above)).max() > 1e12
    assert np.abs(solve_right(np.eye(size), below)).max() < 2


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("run", [python_loops, python_scalars])
def test_units_of_an_output_do_not_move_the_line(run, size):
    for unit in (2.0**-40, 2.0**40):
        units = np.ones(size)
        units[-1] = unit
        for d, solved in ((1.5e-13, True), (0.6e-13, False)):
            M = matrix(size, d) * units * units[:, None]
            assert run(M, M)[0] == solved


LEAST = 2.0**-52


DEFINITE = [
    (Factor("X", 0.0), [(LEAST, True), (0.0, False), (-LEAST, False)]),
    (Factor("X", 1e-3), [(1.1e-3, True), (0.9e-3, False)]),
    (Factor("X", 1e-3, "M"), [(2.1e-3, True), (1.9e-3, False)]),  # beside X and M
]


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("run", [python_loops, python_scalars])
@pytest.mark.parametrize(("factor", "cases"), DEFINITE, ids=["any", "part", "beside"])
def test_what_must_be_definite_has_pivots_above_the_asked_part(
    factor, cases, run, size
):
    for d, definite in cases:
        assert run(np.eye(size), matrix(size, d), definite=[factor])[0] == definite


C_CASES = [(real, size) for real in ("double", "float") for size in (2, 11)]


@pytest.fixture(scope="module")
def in_c(tmp_path_factory):
    """The functions of C_CASES, compiled together; each says whether it solved."""
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    pieces = []
    for real, size in C_CASES:
        for name, definite in [("solve", ()), *enumerate(DEFINITE)]:
            options = dict(definite=[definite[0]]) if definite else {}
            to = C(real)
            known = dict(constants={}, places={}, results={"X": ("out", size * size)})
            module = Module(f"unit_{name}_{real}_{size}", real)
            module.steps(program(**options), {"n": size}, to, **known)
            head = f"int solve_{name}_{real}_{size}"
            head += f"(const {real} *M, const {real} *N, {real} *out)"
            lines = [*module.table_lines(), head, "{", *to.lines, "return 0;", "}"]
            pieces.append("\n".join(lines))
    folder = tmp_path_factory.mktemp("pivots")
    (folder / "solve.c").write_text("\n".join(pieces))
    command = [compiler, "-O1", "-shared", "-fPIC", "-o", "solve.so", "solve.c"]
    subprocess.run(command, cwd=folder, check=True)
    library = ctypes.CDLL(str(folder / "solve.so"))

    def solves(name, real, M, N):
        kind = np.float64 if real == "double" else np.float32
        matrices = [X.astype(kind) for X in (M, N, 0 * M)]
        pointers = [X.ctypes.data_as(ctypes.c_void_p) for X in matrices]
        return library[f"solve_{name}_{real}_{len(M)}"](*pointers) == 0

    return solves


@pytest.mark.parametrize("real, size", C_CASES)
def test_exported_c_draws_the_line_of_its_number_type(real, size, in_c):
    """Of float, which has a relative 1.2e-7, at 1e-6."""
    tol = 1e-13 if real == "double" else 1e-6
    for d, solved in ((1.5 * tol, True), (0.6 * tol, False)):
        assert in_c("solve", real, matrix(size, d), matrix(size, d)) == solved
    for k, (_, cases) in enumerate(DEFINITE):
        for d, definite in cases:
            d = d if real == "double" or abs(d) != LEAST else np.sign(d) * 2.0**-23
            assert in_c(k, real, np.eye(size), matrix(size, d)) == definite
