"""What runs is what the pages prove: coordinates, rows, pairs and counts."""

import numpy as np
import pytest
import sympy as sp
from on_the_page import broken_relations
from pairs import with_stairs

import luenberger as lb
from luenberger.numeric.staircase_form import Staircase
from luenberger.papers.certified import state_observer
from luenberger.papers.van_dooren import design
from luenberger.papers.van_dooren.derivation import counts, pairs, theorem
from luenberger.papers.van_dooren.derivation.rows import Pattern
from luenberger.papers.van_dooren.rows_of_T import Order, minimum_norm, solve_rows
from tests.papers.van_dooren.test_rows_of_T import a_pair_after

METHODS = ("minimum-norm", "back-substitution")


# -- the theorem ----------------------------------------------------------------------


@pytest.mark.parametrize("units", ["given", "even"])
@pytest.mark.parametrize("complex_", [False, True])
@pytest.mark.parametrize("redundant", [0, 2])
def test_a_design_is_what_the_theorem_says(redundant, complex_, units):
    """(1)-(12), (24) on what was computed; with redundant outputs remark 2(c).

    In even units the coordinates of the page are the unitary ones, times the units.
    """
    rng = np.random.default_rng(3)
    A, C = with_stairs((1, 2, 2), rng, complex_)
    more = rng.standard_normal((2 + redundant, 2))
    more = more if redundant else np.eye(2)
    d = np.array([1, 4, 0.5, 2, 8])
    plant = lb.Plant(A / d[:, None] * d, rng.standard_normal((5, 3)), more @ C * d)
    poles = np.array([-1, -2, -3], complex)
    pair, form = design._stairs(plant, "minimum-norm", units, 3.0)
    order = Order(poles / pair.rate, np.zeros(3, bool))
    rows = solve_rows(form, order, minimum_norm)
    built = design._in_users_coordinates(pair, form, rows)
    o = state_observer(plant, built, pair.natural, "")
    assert (pair.states == 1).all() == (units == "given")
    stacked = np.vstack([rows.T, form.C[:2]])
    X = np.linalg.inv(stacked)
    values = {
        theorem.A: plant.A,
        theorem.U: pair.states[:, None] * form.U,
        theorem.Us: form.U.conj().T / pair.states,
        theorem.A_U: form.A * pair.rate,
        theorem.C_U: form.C[:2],
        theorem.T_U: rows.T,
        theorem.T: o.T,
        theorem.F: o.F,
        theorem.G: o.G,
        theorem.B: plant.B,
        theorem.X_1: X[:, :3],
        theorem.X_2: X[:, 3:],
        theorem.D: rows.D * pair.rate,
        theorem.D_all: o.D,
        theorem.C_all: plant.C,
        theorem.P: o.P,
    }
    Y, Ys = form.Y[:, :2] * pair.outputs[:, None], form.Y[:, :2].conj().T / pair.outputs
    values |= {
        theorem.C: Ys @ plant.C,
        theorem.V: o.V @ Y,
        theorem.Y_1: Y,
        theorem.Y_1s: Ys,
    }
    tried, failed = broken_relations(theorem.page.page, values)
    assert failed == [] and tried == 13


# -- rows -----------------------------------------------------------------------------

STAIRS = ((1, 1, 1), (1, 2), (1, 1, 2), (2, 2, 3), (1, 2, 3), (3, 3))


def at_numbers(p, seed, complex_=False):
    """A pattern of the page with numbers for its symbols, as the design takes it."""
    rng = np.random.default_rng(seed)
    symbols = sorted(p.A.free_symbols | p.C.free_symbols, key=str)
    numbers = rng.uniform(1, 2, len(symbols)) * rng.choice([-1, 1], len(symbols))
    if complex_:
        numbers = numbers * np.exp(1j * rng.uniform(0, 1, len(symbols)))
    found = dict(zip(symbols, numbers))
    A, C = (array(X, found) for X in (p.A, p.C))
    eye, leads = np.eye(p.n), np.array(p.leads)
    return Staircase(eye, A, C, p.stairs, np.eye(p.r), 0.0, leads), found


def array(matrix, numbers):
    """An explicit matrix with numbers for its symbols."""
    exact = {symbol: sp.sympify(number) for symbol, number in numbers.items()}
    found = np.array([complex(e.xreplace(exact)) for e in matrix], complex)
    found = found.reshape(matrix.shape)
    return found if found.imag.any() else found.real


def of_T(rows):
    """The symbols of the rows of T_U on the page, at what was computed."""
    named = np.ndindex(*rows.T.shape)
    values = {f"t_{k}_{c}": rows.T[k, c] for k, c in named}
    return values


def with_T(matrix, rows):
    """The symbols of the rows above, as the page has them, at what was computed."""
    known = of_T(rows)
    return {s: known[s.name] for s in matrix.free_symbols if s.name in known}


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("complex_", [False, True])
@pytest.mark.parametrize("stairs", STAIRS, ids=str)
def test_a_row_solves_the_system_of_the_page(stairs, complex_, method):
    """(18), (20): the entries of each row, times M of the page, are minus its a_f."""
    p = Pattern(stairs)
    form, found = at_numbers(p, 5, complex_)
    poles = -np.arange(1.0, p.n - p.r + 1) * (np.exp(0.3j) if complex_ else 1)
    order = Order(poles.astype(complex), np.zeros(len(poles), bool))
    rows = solve_rows(form, order, design.METHODS[method])
    for i, f in enumerate(poles):
        M, a_f = p.M(i, f)
        M, a_f = (array(X, found | with_T(X, rows)) for X in (M, a_f))
        x = np.concatenate([rows.F[i, :i], rows.T[i, i + 1 :], rows.D[i]])
        np.testing.assert_allclose(x @ M, -a_f[0], rtol=0, atol=1e-9)
        assert rows.F[i, i] == f and rows.T[i, i] == 1
        assert not rows.F[i, i + 1 :].any() and not rows.T[i, :i].any()
        if method == "minimum-norm":  # (21): in the span of the conjugate columns
            least = -a_f[0] @ np.linalg.pinv(M)
            np.testing.assert_allclose(x, least, rtol=0, atol=1e-9)


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("stairs", pairs.PAIRS, ids=str)
def test_a_pair_solves_the_system_of_the_page(stairs, method):
    """(30)-(33) with tau unknown, and tau itself where the stair is one wide."""
    p = Pattern(stairs)
    form, found = at_numbers(p, 6)
    a, b = pairs.PART
    found |= {a: -0.7, b: 1.3}
    for i in range(p.n - p.r - 1):
        rows = a_pair_after(i, form, -0.7 + 1.3j, design.METHODS[method])
        system = pairs.system_of_a_pair(p, i)
        f, t, d = rows.F[i : i + 2, :i], rows.T[i : i + 2, i + 1 :], rows.D[i : i + 2]
        values = found | with_T(system[pairs.M_b], rows)
        for k, c in np.ndindex(2, p.n):
            for letter, X in (("f", f), ("tau", t), ("d", d)):
                if c < X.shape[1]:
                    values[sp.Symbol(f"{letter}_{k}_{c}")] = X[k, c]
        asked = pairs.x_b, pairs.M_b, pairs.a_b
        x, M, known = (array(system[s], values) for s in asked)
        np.testing.assert_allclose(x @ M, -known, rtol=0, atol=1e-9)
        block = array(pairs.block()[pairs.Lam], found)
        np.testing.assert_array_equal(rows.F[i : i + 2, i : i + 2], block)
        tau = 1.0
        if p.one_wide(i):
            tau = array(pairs.forced(p, i)[pairs.tau], found)[0, 0]
        assert rows.T[i + 1, i + 1] == pytest.approx(tau, rel=1e-9)


# -- counts ---------------------------------------------------------------------------


def statement(says, **sizes):
    """The loops of a count on the page, run through at given sizes."""
    (item,) = (x for x in counts.page.page if getattr(x, "says", "") == says)
    return item.left.subs({getattr(counts, k): v for k, v in sizes.items()}).doit()


class Watched(np.ndarray):
    """An array that keeps the shapes of the products in which it takes part."""

    products: list

    def __array_ufunc__(self, ufunc, method, *inputs, **options):
        plain = [np.asarray(x) for x in inputs]
        if ufunc is np.matmul:
            Watched.products.append(tuple(x.shape for x in plain))
        found = getattr(ufunc, method)(*plain, **options)
        return found.view(Watched) if isinstance(found, np.ndarray) else found


def test_counts_of_the_gains_as_run(monkeypatch):
    """(25): T_U U* and T B for G, and one triangle for each row of P, V."""
    n, m, r = 6, 4, 2
    rng = np.random.default_rng(2)
    A, C = with_stairs((2, 2, 2), rng)
    plant = lb.Plant(A, rng.normal(size=(n, m)), C)
    pair, form = design._stairs(plant, "minimum-norm", "given", 1.0)
    none = np.zeros(n - r, bool)
    rows = solve_rows(form, Order(none - 1.0, none), minimum_norm)
    rows.T, Watched.products, solved = rows.T.view(Watched), [], []
    original = design.get_lapack_funcs

    def watched(names, arrays):
        (trtrs,) = original(names, arrays)
        assert names == ("trtrs",)

        def solve(S, right, **options):
            solved.append((S.shape, right.shape))
            return trtrs(S, right, **options)

        return (solve,)

    monkeypatch.setattr(design, "get_lapack_funcs", watched)
    built = design._in_users_coordinates(pair, form, rows)
    state_observer(plant, built, pair.natural, "")
    of_G = [p for p in Watched.products if p[0] == (n - r, n) and len(p[1]) == 2]
    square, gain = ((n - r, n), (n, n)), ((n - r, n), (n, m))
    assert of_G == [square, square, gain]  # the second is T A, of the residuals
    multiplied = sum(a * b * c for (a, b), (_, c) in (square, gain))
    assert multiplied == statement("the gain of the input by way of T", n=n, m=m, r=r)
    assert solved == [((n, n), (n, n))]
    triangles = sum(range(1, n + 1)) * n  # one for each right-hand side
    assert triangles == statement("the gains of the estimate", n=n, m=m, r=r)
