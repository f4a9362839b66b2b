"""`lb.compile`: the same numbers in NumPy, for numba and in C."""

import shutil
import subprocess

import numpy as np
import pytest
import sympy as sp
from exact_stages import SIZES, exact_inputs, exact_step
from own_stages import own
from sympy import ZeroMatrix

import luenberger as lb
from luenberger.identification.derivation import weighed
from luenberger.kernels import compiling
from luenberger.papers.kawazoe.derivation import measured_gain, next_entries
from luenberger.papers.leondes_novak.derivation import (
    error_recursion,
    estimate_step,
    gain_step,
    observer_matrices,
    root_update,
    steady_gradient,
)
from luenberger.papers.moore.derivation import companion_row
from matrixproof import Derivation, MatrixSymbol, Solve, Stage

GCC = shutil.which("gcc") or shutil.which("cc")
STRICT = "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror".split()
LISTS = {
    "gain": gain_step,
    "estimate": estimate_step,
    "observer": observer_matrices,
    "error": error_recursion,
    "gradient": steady_gradient,
    "sizes k and q": root_update,  # which loops use themselves
    "matrix k": companion_row,
    "stair": next_entries,
    "below the stairs": measured_gain,
    "an inverse": weighed,  # a solve with the identity on its right
}


@pytest.fixture(autouse=True)
def more_sizes(monkeypatch):
    more = dict(k=6, q=3, p_i=2, r_h=1, r_c=3, r_n=4)
    for name, size in more.items():
        monkeypatch.setitem(SIZES, name, size)


def as_python(text):
    """The function of a text for numba."""
    space = {}
    exec(text, space)
    return space["run"]


@pytest.fixture(params=["numpy", "python", "numba", "c"])
def backend(request, monkeypatch):
    """Beside the three, the text that numba compiles as Python runs it."""
    if request.param == "numba":
        pytest.importorskip("numba", reason="numba is an optional extra")
    if request.param == "c" and GCC is None:
        pytest.skip("there is no C compiler")
    if request.param == "python":
        monkeypatch.setattr(compiling, "find_spec", lambda _: True)
        monkeypatch.setattr(compiling, "jitted", as_python)
    return {"python": "numba"}.get(request.param, request.param)


def numbers(exact):
    return {k: np.array(X.tolist(), float) for k, X in exact.items()}


def agree(stages, backend, *outputs):
    derivation = stages()
    exact = exact_inputs(derivation, np.random.default_rng(8))
    step, wanted = lb.compile(stages, *outputs, backend=backend), numbers(exact)
    found = step(**{name: wanted[name] for name in step.given})
    wanted = numbers(exact_step(derivation, exact))
    assert set(found) == set(outputs or wanted)
    for name, X in found.items():
        tol = 1e-12 * np.abs(wanted[name]).max()
        np.testing.assert_allclose(X, wanted[name], rtol=0, atol=tol, err_msg=name)


def test_backends_agree_with_exact_arithmetic(backend):
    agree(gain_step, backend, "K", "M")


@pytest.mark.parametrize("backend", ["numpy", "python", "c"], indirect=True)
@pytest.mark.parametrize("stages", LISTS.values(), ids=LISTS)
def test_all_results_agree_with_exact_arithmetic(stages, backend):
    agree(stages, backend)


@pytest.mark.skipif(GCC is None, reason="there is no C compiler")
def test_c_compiles_without_a_warning(tmp_path):
    texts = [lb.compile(stages, backend="c").source for stages in LISTS.values()]
    named = [text.replace("int run(", f"int run{k}(") for k, text in enumerate(texts)]
    heads = [text[: text.index("{")].rstrip() + ";" for text in named]
    source = tmp_path / "all.c"
    source.write_text("\n".join([*heads, *named]))
    command = [GCC, *STRICT, "-c", "-o", tmp_path / "all.o", source]
    done = subprocess.run(command, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr


@pytest.mark.skipif(GCC is None, reason="there is no C compiler")
def test_names_that_loops_use_are_kept_apart():
    agree(root_update, "c")
    agree(companion_row, "c")
    text = lb.compile(root_update, backend="c").source
    assert "int k_" in text and "int q_" in text
    assert (
        "const double *k_ /* 1 x n */" in lb.compile(companion_row, backend="c").source
    )


def test_numpy_takes_stacks():
    step = lb.compile(steady_gradient)
    rng = np.random.default_rng(2)
    shapes = dict(K=(4, 2), M=(2, 2), Omega=(4, 4), C=(2, 4), Lambda=(4, 4))
    many = {name: rng.normal(size=(3, *shape)) for name, shape in shapes.items()}
    for name in ("M", "Omega", "Lambda"):
        many[name] = many[name] + many[name].mT
    found = step(**many)["Gradient"]
    for k in range(3):
        alone = step(**{name: X[k] for name, X in many.items()})["Gradient"]
        np.testing.assert_allclose(found[k], alone, rtol=1e-12)


def test_no_input_at_all(backend):
    given = dict(A=[[1.0]], B=np.zeros((1, 0)), C=[[1.0]], E=np.zeros((1, 0)))
    given |= dict(J=[[0.0]], K=[[0.5]], x=[[1.0]], u=np.zeros((0, 1)), rho=[[0.0]])
    step = lb.compile(estimate_step, "x_next", backend=backend)
    found = step(**given, y=[[3.0]], u_next=np.zeros((0, 1)))
    assert found["x_next"].tolist() == [[2.0]]


def test_a_derivation_of_ones_own(backend):
    n, m = sp.symbols("n m", integer=True, positive=True)
    X, N = MatrixSymbol("X", n, n), MatrixSymbol("N", m, n)
    Y, Z = MatrixSymbol("Y", m, n), MatrixSymbol("Z", n, m)
    stages = Stage(Y, Solve(N, X)), Stage(Z, Y.T)
    derivation = own((X, N), *stages, symmetric=(X,))
    step = lb.compile(derivation, "Z", backend=backend)
    found = step(X=[[2, 1], [1, 2]], N=[[3, 0], [0, 3], [3, 3]])["Z"]
    np.testing.assert_allclose(found, [[2, -1, 1], [-1, 2, 1]], atol=1e-14)
    if backend == "c":
        not_definite = pytest.raises(np.linalg.LinAlgError, match="not positive")
        with np.errstate(all="ignore"), not_definite:
            step(X=[[1, 1], [1, 1]], N=[[1, 1]])
    stages = (Stage(Y, N * X),)
    with pytest.raises(AssertionError, match="unproved derivation"):
        lb.compile(Derivation((X, N), stages), backend=backend)


@pytest.mark.parametrize(
    ("given", "error", "message"),
    [
        (dict(M=np.eye(3)), ValueError, r"M must be p x p, got shape \(3, 3\); p = 2"),
        (dict(C=[1.0]), ValueError, r"C must be p x n, got shape \(1,\)"),
        (dict(Omega=np.eye(2)), ValueError, "n = 4, as in K"),
        (dict(Q=np.eye(4)), TypeError, "K, M, Omega, C, Lambda, got .*Q"),
    ],
)
def test_matrices_that_do_not_fit(given, error, message):
    step = lb.compile(steady_gradient, backend="c")
    fit = dict(K=np.ones((4, 2)), M=np.eye(2), Omega=np.eye(4), C=np.ones((2, 4)))
    with pytest.raises(error, match=message):
        step(**(fit | {"Lambda": np.eye(4)} | given))


@pytest.mark.parametrize("name", ["numpy", "numba", "c"])
def test_an_output_that_is_not_computed(name):
    with pytest.raises(ValueError, match="no stage computes Psi; there are Omega, M"):
        lb.compile(gain_step, "M", "Psi", backend=name)


@pytest.mark.parametrize(
    ("what", "options", "error", "message"),
    [
        (gain_step, dict(backend="C"), ValueError, "'numpy', 'numba' or 'c', got 'C'"),
        ("gain_step", {}, TypeError, "a function that returns one, got str"),
        (lambda: 3, {}, TypeError, "a Derivation, or a function"),
        (Derivation(source="nowhere"), {}, ValueError, "nowhere has no stages"),
    ],
)
def test_questions_that_make_no_sense(what, options, error, message):
    with pytest.raises(error, match=message):
        lb.compile(what, **options)


def test_without_a_compiler_there_is_still_the_text(monkeypatch):
    step = lb.compile(root_update, "kept", backend="c")
    monkeypatch.setattr(shutil, "which", lambda name: None)
    assert step.source.startswith("int run(int k_, int n, int p,")
    with pytest.raises(RuntimeError, match="takes a C compiler.*`source`"):
        step(C=[[1.0]], Gamma=[[1.0]], Kmv=[[1.0]], H_minus=[[1.0]])


def test_a_size_without_a_letter_is_refused_by_loops():
    n = sp.Symbol("n", integer=True, positive=True)
    X, Y = (MatrixSymbol(name, n + 1, n + 1) for name in "XY")
    derivation = own((X,), Stage(Y, 2 * X))
    assert lb.compile(derivation)(X=[[1]])["Y"].tolist() == [[2]]
    with pytest.raises(TypeError, match="size n \\+ 1 of X; give it a letter"):
        lb.compile(derivation, backend="c")


# -- what cannot be named, and what is not as it was supposed -------------------------


def double(*names):
    """A derivation with two given matrices, and a target, of these names."""
    n = sp.Symbol("n", integer=True, positive=True)
    first, other, target = (MatrixSymbol(name, n, n) for name in names)
    return own((first, other), Stage(target, first * other))


CLASHES = {
    ("A", "X_out", "X"): "two things would be called X_out",
    ("A", "B+", "Y"): "is no name that code can have",
    ("A", "B", "x\N{COMBINING CIRCUMFLEX ACCENT}"): "is no name that code can have",
}


@pytest.mark.parametrize("names", CLASHES, ids="-".join)
def test_two_things_of_one_name_are_refused_in_c(names):
    with pytest.raises(ValueError, match=CLASHES[names]):
        lb.compile(double(*names), backend="c")


@pytest.mark.parametrize(
    "names", [("k", "k_", "Y"), ("f0", "f0_", "Y"), ("A", "B", "A")]
)
@pytest.mark.parametrize("name", ["numpy", "numba", "c"])
def test_letters_that_look_alike_and_targets_that_are_given_are_refused(names, name):
    said = "is printed for several letters|is there before"
    with pytest.raises(AssertionError, match=said):
        lb.compile(double(*names), backend=name)


@pytest.mark.parametrize("name", ["np", "eye", "solve_right", "lambda", "None", "A B"])
@pytest.mark.parametrize("kind", ["numpy", "numba"])
def test_a_name_that_numpy_code_cannot_have(name, kind):
    with pytest.raises(ValueError, match="name"):
        lb.compile(double("A", name, "Y"), backend=kind)
    with pytest.raises(ValueError, match="name"):
        lb.compile(double("A", "B", name), backend=kind)


@pytest.mark.parametrize(
    "names",
    [
        ("t0", "t1", "t2"),
        ("A", "B", "t0"),
        ("f0", "g1", "a0_0"),
        ("range", "min", "abs"),
        ("double", "int", "fabs"),
        ("K", "K_1", "K_m"),
    ],
    ids="-".join,
)
def test_names_of_the_text_itself_are_kept_apart(backend, names):
    """Products of three make matrices of the text's own, t0, t1 and so on."""
    n = sp.Symbol("n", integer=True, positive=True)
    first, other, target = (MatrixSymbol(name, n, n) for name in names)
    Z, W = MatrixSymbol("Z", n, n), MatrixSymbol("W", n, n)
    stages = (
        Stage(Z, first * other * first * other),
        Stage(target, other * first * other * first),
        Stage(W, Solve(Z + target, target)),
    )
    given = {names[0]: np.diag([1.0, 2]), names[1]: np.diag([3.0, 5])}
    derivation = own((first, other), *stages[:2])
    found = lb.compile(derivation, backend=backend)(**given)
    np.testing.assert_allclose(found["Z"], np.diag([9.0, 100]))
    np.testing.assert_allclose(found[names[2]], np.diag([9.0, 100]))
    with pytest.raises(AssertionError, match="by one triangle"):
        lb.compile(own((first, other), *stages), backend=backend)


def solving(symmetric=True):
    n, m = sp.symbols("n m", integer=True, positive=True)
    M, N = MatrixSymbol("M", n, n), MatrixSymbol("N", m, n)
    X = MatrixSymbol("X", m, n)
    known = (M,) if symmetric else ()
    return own((M, N), Stage(X, Solve(N, M)), symmetric=known)


@pytest.mark.parametrize(
    "M",
    [
        [[3, 1], [0, 4]],
        [[3, 1], [1 + 1e-6, 4]],
        [[1e12, 1, 0], [1, 1, 1e-3], [0, 0, 1e-12]],
    ],
    ids=["a triangle", "nearly", "in other units"],
)
def test_a_matrix_that_is_not_symmetric_is_refused_at_a_call(backend, M):
    step = lb.compile(solving(), backend=backend)
    with pytest.raises(ValueError, match="M must be symmetric, as the derivation"):
        step(M=M, N=np.ones((1, len(M))))


@pytest.mark.parametrize("M", [[[3, 1], [1 + 1e-15, 4]], [[1e6, 0.3], [0.3, 1e-6]]])
def test_rounding_is_no_asymmetry(backend, M):
    found = lb.compile(solving(), backend=backend)(M=M, N=M[:1])
    np.testing.assert_allclose(found["X"], [[1, 0]], atol=1e-7)


@pytest.mark.parametrize(
    ("M", "N"),
    [
        ([[1, 2], [2, 1]], [[1, 2]]),
        ([[-1, 0], [0, -1]], [[1, 2]]),
        ([[1, 1], [1, 1]], [[1, 2]]),
        ([[0, 1], [1, 0]], [[1, 2]]),
    ],
    ids=["indefinite", "negative", "singular", "of zero diagonal"],
)
def test_a_solve_that_has_no_solution_here_says_so(backend, M, N):
    step = lb.compile(solving(), backend=backend)
    with np.errstate(all="ignore"), pytest.raises(np.linalg.LinAlgError, match="not"):
        step(M=M, N=N)


def test_numpy_solves_stacks_with_semidefinite_matrices():
    step = lb.compile(solving())
    stack = np.array([[[2.0, 1], [1, 2]], [[1, 1], [1, 1]]])
    found = step(M=stack, N=np.array([[3.0, 3]]))["X"]
    np.testing.assert_allclose(found, [[[1, 1]], [[1.5, 1.5]]])


# -- singular matrices, blocks, sizes of zero ------------------------------------------


@pytest.mark.parametrize("backend", ["numpy", "python", "numba"], indirect=True)
def test_a_singular_matrix_has_a_solution_of_least_norm(backend):
    """X M = N for N in the range of M, whatever the units: X = N M^+."""
    step = lb.compile(solving(), backend=backend)
    H = np.array([[1.0, 2], [3, -1], [0, 0], [4, 1]])
    for scale in (1.0, 1e8):
        units = np.diag([1, scale, 1, 1])
        singular = units @ H @ H.T @ units
        wanted = H.T @ units
        found = step(M=singular, N=wanted @ singular)["X"]
        residual = found @ singular - wanted @ singular
        assert np.abs(residual / (1 + np.abs(wanted @ singular))).max() < 1e-11
    assert not step(M=np.zeros((2, 2)), N=np.zeros((1, 2)))["X"].any()


def test_blocks_are_joined_for_numba_as_in_numpy(monkeypatch):
    n, m = sp.symbols("n m", integer=True, positive=True)
    A, B = MatrixSymbol("A", n, n), MatrixSymbol("B", n, m)
    blocks = {
        "both ways": [[A, B], [B.T, ZeroMatrix(m, m)]],
        "a row": [[A.T, B]],
        "a column": [[A], [2 * B.T]],
    }
    rng = np.random.default_rng(4)
    have = dict(A=rng.normal(size=(3, 3)), B=rng.normal(size=(3, 2)))
    monkeypatch.setattr(compiling, "jitted", as_python)
    for name, rows in blocks.items():
        whole = sp.BlockMatrix(rows)
        joined = own((A, B), Stage(MatrixSymbol("Y", *whole.shape), whole))
        one, two = (lb.compile(joined, backend=k)(**have) for k in ("numpy", "numba"))
        np.testing.assert_array_equal(one["Y"], two["Y"], err_msg=name)
    with pytest.raises(TypeError, match="no code for BlockMatrix"):
        lb.compile(joined, backend="c")


@pytest.mark.parametrize("unit", [2.0**-40, 1.0, 2.0**40])
@pytest.mark.parametrize(("d", "firm"), [(1.5e-13, True), (0.6e-13, False)])
def test_the_line_of_a_singular_matrix_is_the_same(backend, d, firm, unit):
    """The last pivot of [[1, 1], [1, 1 + d]] is d, the part that the first leaves.

    Below 1e-13 of its diagonal entry, C gives up and the others leave it out.
    """
    units = np.diag([1.0, unit])
    M = units @ [[1, 1], [1, 1 + d]] @ units
    step = lb.compile(solving(), backend=backend)
    if backend == "c" and not firm:
        with pytest.raises(np.linalg.LinAlgError, match="not positive definite"):
            step(M=M, N=M)
        return
    found = np.linalg.inv(units) @ step(M=M, N=M)["X"] @ units
    wanted = np.eye(2) if firm else np.full((2, 2), 0.5)
    np.testing.assert_allclose(found, wanted, atol=1e-2)  # 1 % of the pivot


@pytest.mark.parametrize("size", [1, 3, 6])
def test_a_solve_of_any_size(backend, size):
    """X M = N for whole numbers, so that N is exact."""
    rng = np.random.default_rng(size)
    H, X = rng.integers(-4, 5, size=(size, size)), rng.integers(-9, 9, size=(2, size))
    M = H @ H.T + 60 * np.eye(size)
    found = lb.compile(solving(), backend=backend)(M=M, N=X @ M)["X"]
    np.testing.assert_allclose(found, X, rtol=0, atol=1e-11)


def test_a_vector_is_added_up_by_columns_of_a_transpose(backend):
    n = sp.Symbol("n", integer=True, positive=True)
    A, x, y = MatrixSymbol("A", n, n), MatrixSymbol("x", n, 1), MatrixSymbol("y", n, 1)
    step = lb.compile(own((A, x), Stage(y, x - 2 * A.T * x + A * x)), backend=backend)
    found = step(A=[[1, 2], [3, 4]], x=[[5], [7]])["y"]
    assert found.tolist() == [[-28], [-26]]


def test_the_factor_of_a_matrix_has_a_name_of_its_own(backend):
    n = sp.Symbol("n", integer=True, positive=True)
    M, N, X = (MatrixSymbol(name, n, n) for name in ("M", "M_l", "X"))
    step = lb.compile(
        own((M, N), Stage(X, Solve(N, M)), symmetric=(M,)), backend=backend
    )
    found = step(M=[[2, 1], [1, 2]], M_l=[[3, 3], [0, 3]])["X"]
    np.testing.assert_allclose(found, [[1, 1], [-1, 2]], atol=1e-14)


@pytest.mark.skipif(GCC is None, reason="there is no C compiler")
def test_c_reads_and_writes_nothing_else(tmp_path):
    """No size, or one of 0, takes it out of an array, as sanitizers would see."""
    text = lb.compile(gain_step, backend="c").source
    for n, p in ((3, 2), (2, 0), (0, 0), (1, 3)):
        lengths = [n * n, n * n, p * n, p * p, n * p, n * n]  # A Q C R Gamma Sigma
        lengths += [n * n, p * p, n * p, n * p, n * n, n * n]  # what is computed
        makes = [f"double *a{k} = calloc({size}, 8);" for k, size in enumerate(lengths)]
        ones = [f"for (int i = 0; i < {p}; i++) a3[i * {p} + i] = 1;"]
        call = f"run({n}, {p}, {', '.join(f'a{k}' for k in range(12))})"
        frees = [f"free(a{k});" for k in range(12)]
        main = ["int main(void) {", *makes, *ones, f"int failed = {call};", *frees]
        source = tmp_path / "all.c"
        whole = ["#include <stdlib.h>", text, *main, "return failed;", "}"]
        source.write_text("\n".join(whole))
        options = "-std=c99 -fsanitize=undefined,address -fno-sanitize-recover=all"
        command = [GCC, *options.split(), "-o", tmp_path / "all", source]
        subprocess.run(command, check=True, capture_output=True)
        done = subprocess.run([tmp_path / "all"], capture_output=True, text=True)
        assert done.returncode == 0, done.stderr


@pytest.mark.parametrize("backend", ["numpy", "python", "c"], indirect=True)
def test_symmetric_targets_are_symmetric_to_the_last_bit(backend):
    derivation = gain_step()
    given = numbers(exact_inputs(derivation, np.random.default_rng(5)))
    step = lb.compile(derivation, backend=backend)
    found = step(**{name: given[name] for name in step.given})
    for stage in derivation.stages:
        X = found[stage.target.name]
        assert not stage.symmetric or (X == X.T).all(), stage.target.name
