"""Every printer computes what the stage list says: exactly, and as NumPy does.

Loops and scalars, in Python and in C, beside the generic NumPy kernel and rational
arithmetic.  Printed Python is run as it is, without numba; `test_backends` compiles.
"""

import ctypes
import itertools
import shutil
import subprocess

import numpy as np
import pytest
import sympy as sp
from every_pair import every_pair
from exact_stages import SIZES, exact_inputs, exact_step, kernel
from own_stages import own
from worlds import STAGE_LISTS

from luenberger.kernels import (
    cost,
    entries_known,
    loops,
    numba,
    products,
    scalars,
    solves,
    tiles,
)
from luenberger.kernels.c import C, Module, function
from luenberger.kernels.loops import arrays, write
from luenberger.kernels.lowering import lower
from luenberger.kernels.program import Assign, Factor, Substitute
from luenberger.papers.leondes_novak import derivation as recursions
from luenberger.recursion.filter_stacks import FILTER
from luenberger.symbolic import Derivation, Solve, Stage

LISTS = {
    name: getattr(recursions, name)
    for name in (*STAGE_LISTS, "filter_step", "observer_step")
}
ALL = SIZES | {"q": 3, "p_a": 2}
FORMS = ["loops", "scalars"]
STRICT = "-std=c99 -O2 -Wall -Wextra -Wpedantic -Wconversion -Wshadow -Werror".split()


def numbers(exact):
    return {k: np.array(v.tolist(), dtype=float) for k, v in exact.items()}


def by_loops(program, given, form=numba.Python):
    """The loops in plain Python."""
    to = form(1)
    for name, length in arrays(program, ALL, to).items():
        to.let(name, f"np.full({length}, np.nan)")
    to.let("ok", "True")
    write(program, ALL, to)
    to.line("return ok, locals()")
    text = "\n".join([f"def step({', '.join(program.given)}):", *to.lines])
    space = {"np": np, "product": products.in_python}
    exec(text, space)
    ok, found = space["step"](*(given[k].ravel() for k in program.given))
    assert ok
    return results(program, found)


def results(program, found):
    """Results by name from flat arrays."""
    out = {}
    for name, operand in program.results.items():
        value = found[operand.name].reshape(program.shape(operand.name, ALL))
        out[name] = value.T if operand.turned else value
    return out


def by_scalars(program, given, known=None):
    """The scalar statements in plain Python."""
    straight = scalars.unroll(program, ALL, known)
    space = {}
    for name, entries in straight.given.items():
        space |= {entry: given[name][i, j] for i, j, entry in entries}
    for one in straight.statements:
        if isinstance(one, scalars.Let):
            assert one.name not in space, f"{one.name} is assigned twice"
            space[one.name] = eval(one.text, {}, space)
        else:
            assert eval(one.text, {}, space)
    out = {}
    for name, operand in program.results.items():
        table = straight.entries[operand.name]
        value = np.array([[space.get(e, e) for e in row] for row in table], float)
        out[name] = value.T if operand.turned else value
    return out


@pytest.fixture(scope="session")
def compile_c(tmp_path_factory):
    """Compile a printed function without a single warning, and call it.

    What is returned are the code and the results of each of `forms`, one library.
    """
    compiler = shutil.which("gcc") or shutil.which("cc")
    if compiler is None:
        pytest.skip("there is no C compiler")
    folder, number = tmp_path_factory.mktemp("c"), itertools.count()

    def call(program, given, real="double", constants=(), forms=FORMS):
        fixed = {k: given[k] for k in constants}
        wanted = {k: op for k, op in program.results.items() if op is not None}
        shapes = {k: program.shape(op.name, ALL) for k, op in wanted.items()}
        shapes = {k: s[:: -1 if wanted[k].turned else 1] for k, s in shapes.items()}
        names = [k for k in program.given if k not in constants]
        head = [f"const {real} {k}[]" for k in names]
        head = ", ".join([*head, *(f"{real} {k}_out[]" for k in shapes)])
        results = {k: (f"{k}_out", np.prod(s)) for k, s in shapes.items()}
        text = []
        for form in forms:
            to, module = C(real), Module(form, real)
            with pytest.MonkeyPatch.context() as patch:
                for limit in ("SHORT", "LONG"):
                    patch.setattr(cost, limit, 10**6 * (form == "scalars"))
                module.steps(program, ALL, to, fixed, {}, results)
            to.line("return 0;")
            text += [*module.table_lines(), f"int {form}({head});"]
            text.append(function(f"int {form}({head})", to.lines, names))
        stem = folder / f"step{next(number)}"
        source, library = stem.with_suffix(".c"), stem.with_suffix(".so")
        source.write_text("\n".join(text))
        command = [compiler, *STRICT, "-shared", "-fPIC", "-o", library, source]
        subprocess.run(command, check=True, capture_output=True, text=True)
        kind, loaded = {"double": np.float64, "float": np.float32}[real], []
        ins = [np.ascontiguousarray(given[k], kind) for k in names]
        for form in forms:
            outs = {name: np.full(shape, 9, kind) for name, shape in shapes.items()}
            arrays = (X.ctypes.data_as(ctypes.c_void_p) for X in (*ins, *outs.values()))
            loaded.append((ctypes.CDLL(str(library))[form](*arrays), outs))
        return loaded

    return call


def cases(derivation, seed=8):
    exact = exact_inputs(derivation, np.random.default_rng(seed))
    return exact, numbers(exact)


def close(found, wanted, tol=1e-12):
    for name, value in wanted.items():
        value = np.array(value.tolist(), dtype=float)
        scale = np.abs(value).max()
        np.testing.assert_allclose(
            found[name], value, rtol=0, atol=tol * scale, err_msg=name
        )


@pytest.fixture(params=LISTS)
def stage_list(request, monkeypatch):
    monkeypatch.setitem(SIZES, "q", 3)
    derivation = LISTS[request.param]()
    symmetric = [k for k in ("Q", "R", "Sigma", "X") if k in str(derivation.given)]
    exact, given = cases(derivation)
    wanted = exact_step(derivation, exact)
    return derivation, lower(derivation, symmetric=symmetric), given, wanted


def test_loops_agree_with_exact_arithmetic(stage_list):
    derivation, program, given, wanted = stage_list
    close(by_loops(program, given), wanted)


@every_pair(
    stage_list=list(LISTS),
    high=[1, 2, 3, 6],
    widths=[(8, 4, 1), (3, 2, 1), (2, 1, 1)],
    indirect=["stage_list"],
)
def test_tiles_agree_with_exact_arithmetic(high, widths, stage_list, monkeypatch):
    """Tiles that end with the matrix or before, and factors of one block or more."""
    derivation, program, given, wanted = stage_list
    monkeypatch.setattr(tiles, "HEIGHT", high)
    monkeypatch.setattr(tiles, "WIDTHS", widths)
    close(by_loops(program, given, numba.Tiled), wanted)
    monkeypatch.setattr(solves, "TILED_SOLVE", 0)
    for alone, block in ((8, 4), (1, 1), (1, 2), (1, 3)):
        monkeypatch.setattr(tiles, "ALONE", alone)
        monkeypatch.setattr(tiles, "BLOCK", block)
        close(by_loops(program, given, numba.Tiled), wanted)


def test_scalars_agree_with_exact_arithmetic(stage_list):
    derivation, program, given, wanted = stage_list
    close(by_scalars(program, given), wanted)


def test_printers_agree_with_the_generic_kernel(stage_list):
    derivation, program, given, _ = stage_list
    step = kernel(derivation)
    wanted = step(**{k: given[k] for k in step.given})
    close(by_loops(program, given), wanted)
    close(by_scalars(program, given), wanted)


def test_c_agrees_with_exact_arithmetic(stage_list, compile_c):
    derivation, program, given, wanted = stage_list
    for failed, found in compile_c(program, given):
        assert failed == 0
        close(found, wanted)


def test_loops_as_large_matrices_get_them(stage_list, compile_c, monkeypatch):
    """No inner loop is written out."""
    derivation, program, given, wanted = stage_list
    monkeypatch.setattr(loops, "SHORT", 0)
    monkeypatch.setattr(solves, "SHORT_SOLVE", 0)
    close(by_loops(program, given), wanted)
    ((failed, found),) = compile_c(program, given, forms=["loops"])
    assert failed == 0
    close(found, wanted)


def test_c_in_single_precision(compile_c):
    derivation = recursions.filter_step()
    exact, given = cases(derivation)
    wanted = exact_step(derivation, exact)
    for failed, found in compile_c(lower(derivation), given, real="float"):
        assert failed == 0 and found["K"].dtype == np.float32
        close(found, wanted, tol=2e-4)


def structured():
    """The filter step on matrices with zeros and ones, and what is known of them."""
    derivation = recursions.filter_step()
    exact, _ = cases(derivation)
    exact["A"] = sp.Matrix(4, 4, lambda i, j: int(i == j) + sp.Rational(j == i + 1, 2))
    exact["As"] = exact["A"]
    exact["C"] = sp.Matrix(2, 4, lambda i, j: int(i == j))
    exact["Q"] = sp.diag(0, 0, 0, sp.Rational(1, 3))
    exact["R"] = sp.diag(2, 3)
    zero = ("B", "J", "E", "Gamma")
    exact |= {name: exact[name] * 0 for name in zero}
    given = numbers(exact)
    known = {
        k: entries_known(given[k] == 0, given[k] == 1) for k in ("A", "C", "Q", "R")
    }
    program = lower(
        derivation,
        ["Sigma_next", "x_next", "rho_next", "K"],
        zero=zero,
        symmetric=("Q", "R", "Sigma"),
        definite=[Factor("Sigma_next", 0.0)],
        same=[("As", "A")],
    )
    return program, known, given, exact_step(derivation, exact)


def test_structure_is_used_and_changes_nothing(compile_c):
    program, known, given, wanted = structured()
    wanted = {k: wanted[k] for k in program.results}
    close(by_loops(program, given), wanted)
    close(by_scalars(program, given), wanted)
    close(by_scalars(program, given, known), wanted)
    for failed, found in compile_c(program, given, constants=known):
        assert failed == 0
        close(found, wanted)
    plain, lean = (
        scalars.unroll(program, ALL, k).cost.operations for k in (None, known)
    )
    assert lean < plain / 2


def test_what_vanishes_is_left_out():
    program, known, _, _ = structured()
    assert set(program.given).isdisjoint({"B", "J", "E", "Gamma", "rho", "u", "As"})
    assert program.results["K"].name == "Kmv"  # K = Kmv, under another name
    loop = FILTER.lowered(("B", "E", "Gamma", "J"))
    text = numba.source(loop, ALL, frozenset(), None)
    assert "Gamma[" not in text and "rho" not in text
    read = {
        e for v in scalars.unroll(program, ALL, known).given.values() for *_, e in v
    }
    assert "A_0_1" in read and "A_0_0" not in read and "A_1_0" not in read


def test_a_result_that_is_zero_is_said_to_be():
    program = lower(recursions.estimate_step(), zero=("K", "J", "B"))
    assert program.results["x_next"].name == "x_minus"
    gone = lower(recursions.decorrelation(), zero=("A", "J"), symmetric=("Q",))
    assert gone.results["As"] is None and gone.results["Qs"].name == "Q"


def test_products_have_two_factors_and_the_cheaper_is_taken_first():
    program = lower(recursions.gain_step())
    sums = [step for step in program.steps if isinstance(step, Assign)]
    assert max(len(t.factors) for step in sums for t in step.terms) == 2
    n = sp.Symbol("n", integer=True)
    A, B, x, y = (sp.MatrixSymbol(k, n, d) for k, d in zip("ABxy", (n, n, 1, 1)))
    vector = own((A, B, x), Stage(y, A * B * x))
    first, second = lower(vector).steps
    assert [op.name for op in first.terms[0].factors] == ["B", "x"]
    assert [op.name for op in second.terms[0].factors] == ["A", first.target]


def test_two_solves_share_one_factor():
    n = sp.Symbol("n", integer=True)
    M, N, X, Y = (sp.MatrixSymbol(k, n, n) for k in "MNXY")
    stages = Stage(X, Solve(N, M)), Stage(Y, Solve(X, M))
    program = lower(own((M, N), *stages, symmetric=(M,)))
    assert sum(isinstance(step, Factor) for step in program.steps) == 1


def test_a_solve_whose_solution_is_seen_is_none():
    """X I = N, and X M = A M; but not X M = A M', nor X M = 2 A M."""
    n = sp.Symbol("n", integer=True)
    A, M, Z, D, N, X, Y, V, W = (sp.MatrixSymbol(k, n, n) for k in "AMZDNXYVW")
    stages = (
        Stage(D, sp.Identity(n) + Z + Z.T, symmetric=True),
        Stage(X, Solve(A, D)),
        Stage(N, A * M),
        Stage(Y, Solve(N, M)),
        Stage(V, Solve(A * M.T, M)),
        Stage(W, Solve(2 * A * M, M)),
    )
    derivation = own((A, M, Z), *stages, symmetric=(M,))
    program = lower(derivation, zero=("Z",))
    assert {program.results[k].name for k in "XY"} == {"A"}
    solved = {step.target for step in program.steps if isinstance(step, Substitute)}
    assert solved == {"V", "W"}
    whole = lower(derivation)
    assert whole.results["X"].name == "X" and whole.results["Y"].name == "A"


def test_a_sum_is_added_up_once():
    n = sp.Symbol("n", integer=True)
    A, B, X, Y, Z = (sp.MatrixSymbol(k, n, n) for k in "ABXYZ")
    stages = Stage(X, A * B), Stage(Y, A * B), Stage(Z, A * B.T)
    program = lower(own((A, B), *stages))
    assert [step.target for step in program.steps] == ["X", "Z"]
    assert program.results["Y"].name == "X"


@pytest.mark.parametrize("seed", range(3))
def test_awkward_formulas(seed, compile_c):
    """Transposed sums, identities with factors, nested products, fractions, aliases."""
    n = sp.Symbol("n", integer=True)
    A, B, S = (sp.MatrixSymbol(k, n, n) for k in "ABS")
    X, Y, U, V, W = (sp.MatrixSymbol(k, n, n) for k in "XYUVW")
    c, d, z, w = (sp.MatrixSymbol(k, n, 1) for k in "cdzw")
    stages = (
        Stage(X, A * (B - 3 * sp.Identity(n)) * A.T / 7),
        Stage(Y, X.T),
        Stage(U, (A + B).T * Y + 2 * sp.Identity(n) - B.T),
        Stage(V, -U),
        Stage(W, A.T * S * A + A * S * A.T, symmetric=True),
        Stage(z, c / 2 - S * d + S.T * c),
        Stage(w, A * c - S * d),
    )
    derivation = own((A, B, S, c, d), *stages, symmetric=(S,))
    exact, _ = cases(derivation, seed)
    exact["S"] = exact["S"] + exact["S"].T
    given, wanted = numbers(exact), {}
    A, B, S, c, d = (given[k] for k in "ABScd")
    wanted["X"] = A @ (B - 3 * np.eye(4)) @ A.T / 7
    wanted["Y"] = wanted["X"].T
    wanted["U"] = (A + B).T @ wanted["Y"] + 2 * np.eye(4) - B.T
    wanted["V"], wanted["W"] = -wanted["U"], A.T @ S @ A + A @ S @ A.T
    wanted["z"], wanted["w"] = c / 2 - S @ d + S @ c, A @ c - S @ d
    program = lower(derivation, symmetric=("S",))
    close(by_loops(program, given), wanted)
    close(by_loops(program, given, numba.Tiled), wanted)
    close(by_scalars(program, given), wanted)
    for failed, found in compile_c(program, given):
        assert failed == 0
        close(found, wanted)


@pytest.mark.parametrize("printer", [by_loops, by_scalars])
def test_symmetric_targets_are_symmetric_to_the_last_bit(printer, stage_list):
    derivation, program, given, _ = stage_list
    found = printer(program, given)
    for stage in derivation.stages:
        if stage.symmetric:
            value = found[stage.target.name]
            np.testing.assert_array_equal(value, value.T, err_msg=stage.target.name)


@pytest.mark.parametrize("fault", ["singular M", "indefinite Sigma", "NaN"])
def test_c_gives_up_where_a_matrix_is_not_definite(fault, compile_c):
    derivation = recursions.filter_step()
    _, given = cases(derivation)
    program = lower(derivation, definite=[Factor("Sigma_next", 0.0)])
    if fault == "singular M":
        given["C"][1], given["R"][:] = given["C"][0], 0
    elif fault == "indefinite Sigma":
        given["Sigma"], given["Q"] = -np.eye(4), np.diag([5.0, 5, 5, -1e-3])
        given["As"], given["C"] = np.eye(4), np.eye(2, 4)
        given["Gamma"] *= 0
    else:
        given["Sigma"][0, 0] = np.nan
    assert [failed for failed, _ in compile_c(program, given)] == [1, 1]


def test_only_what_is_asked_for_is_printed_and_only_what_is_proved():
    program = lower(recursions.gain_step(), ["M"])
    assert "Kmv" not in program.shapes and "Gamma" not in program.given
    with pytest.raises(KeyError, match="no stage assigns"):
        lower(recursions.gain_step(), ["Psi"])
    X, Y = sp.MatrixSymbol("X", 2, 2), sp.MatrixSymbol("Y", 2, 2)
    with pytest.raises(AssertionError, match="unproved derivation"):
        lower(Derivation((X,), (Stage(Y, 2 * X),), source="nowhere"))
    with pytest.raises(TypeError, match="write an inverse as Solve"):
        lower(own((X,), Stage(Y, X.I)))


def test_sources_are_the_same_text_every_time():
    """The cache is found by the text, so nothing in it may depend on the run."""
    known = {"A": entries_known(np.eye(4) == 0, np.eye(4) == 1)}
    texts = set()
    for _ in range(2):
        found = FILTER.lowered(("B", "E", "J"))
        straight = scalars.unroll(found.program, ALL, known)
        texts.add(numba.source(found, ALL, frozenset(), straight))
    assert len(texts) == 1
