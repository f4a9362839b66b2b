"""Kawazoe's form and the state from p_M samples: proofs, cases, properties."""

from fractions import Fraction

import numpy as np
import pytest
import sympy as sp
from drawn import bounded
from hypothesis import given
from hypothesis import strategies as st
from pairs import AB01OD

import luenberger as lb
from luenberger.papers.kawazoe.derivation import errata
from luenberger.papers.kawazoe.derivation import form as canonical
from luenberger.papers.kawazoe.derivation.form import C_1, C_2
from luenberger.papers.kawazoe.derivation.form import A as A_
from luenberger.papers.kawazoe.form import observability_form
from luenberger.papers.kawazoe.reconstruction import reconstruct_state

PATTERNS = [*canonical.PATTERNS, (1,), (3,), (1, 2), (4, 1), (1, 3, 2)]
EPS = np.finfo(float).eps


def test_the_order_of_the_search_matters():
    """On the page's plant the library searches in the order that the page proves."""
    values = canonical.PLANT
    A = values[A_].subs(dict(zip(sp.symbols("a_1:4"), (2, 3, 4))))
    C = values[C_1].col_join(values[C_2])
    form = observability_form(lb.Plant(A.tolist(), None, C.tolist(), dt=1.0))
    assert form.indices == (1, 2) and form.samples == 2


def test_misprints_are_tried():
    places = [place for place, *_ in errata.misprints()]
    assert places == ["(5), (6)", "(17), (20)", "(25)"]
    assert "w_3" in errata.misprints()[2][2]


def fractions(rng, *shape):
    values = [Fraction(int(a), int(b)) for a, b in rng.integers(1, 9, (200, 2))]
    signs = rng.choice([-1, 1], np.prod(shape))
    picked = rng.choice(len(values), np.prod(shape))
    flat = [int(s) * values[k] for s, k in zip(signs, picked)]
    out = np.empty(len(flat), dtype=object)
    out[:] = flat
    return out.reshape(shape)


def exact_plant(indices, seed=0, inputs=2):
    """A plant with these indices, and the P, Phi it must be found to have."""
    rng = np.random.default_rng(seed)
    of = canonical.Pattern(indices)
    symbols, H, n, p = of.Phi, of.H, of.n, of.m
    values = fractions(rng, n, n)
    Phi = np.array(
        [
            [
                values[i, j]
                if symbols[i, j].is_Symbol
                else Fraction(int(symbols[i, j]))
                for j in range(n)
            ]
            for i in range(n)
        ],
        dtype=object,
    )
    lower = sp.Matrix(
        n, n, lambda i, j: int(rng.integers(-2, 3)) if i > j else int(i == j)
    )
    upper = sp.Matrix(
        n, n, lambda i, j: int(rng.integers(-2, 3)) if i < j else int(i == j)
    )
    P = lower * upper  # integers, determinant 1
    as_fractions = np.vectorize(lambda e: Fraction(int(e)), otypes=[object])
    inverse = as_fractions(np.array(P.inv().tolist(), dtype=object))
    P = as_fractions(np.array(P.tolist(), dtype=object))
    A = inverse @ Phi @ P
    C = as_fractions(np.array(H.tolist(), dtype=object)) @ P
    plant = lb.Plant(A, fractions(rng, n, inputs), C, fractions(rng, p, inputs), dt=1.0)
    return plant, P, Phi


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_exact_form(indices):
    plant, P, Phi = exact_plant(indices)
    form = observability_form(plant)
    assert form.indices == indices and form.exact
    assert (form.P == P).all() and (form.Phi == Phi).all()
    assert (form.H @ form.P == plant.exact["C"]).all()
    assert (form.G == P @ plant.exact["B"]).all()
    assert all(
        type(entry) is Fraction for X in (form.P, form.Phi, form.H) for entry in X.flat
    )
    rounded = form.as_float()
    assert rounded.P.dtype == float and rounded.as_float() is rounded


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_structural_zeros(indices):
    """The interleaved search leaves exactly the entries of (11) that are named."""
    symbols = canonical.Pattern(indices).Phi
    plant, _, _ = exact_plant(indices, seed=4)
    floats = lb.Plant(plant.A, plant.B, plant.C, plant.E, dt=1.0)
    form = observability_form(floats)
    zero = np.array(symbols.tolist()) == 0
    assert form.indices == indices
    bound = 1e3 * form.cond * EPS * np.abs(form.Phi).max()
    assert np.abs(form.Phi[zero]).max(initial=0) <= bound
    assert form.margin > form.tol > 0


def test_sympy_rationals_are_exact():
    half = sp.Rational(1, 2)
    form = observability_form(
        lb.Plant([[half, 1], [0, sp.Rational(1, 3)]], None, [[sp.Integer(1), 0]])
    )
    assert form.Phi.tolist() == [[0, 1], [Fraction(-1, 6), Fraction(5, 6)]]


def test_published_observable_form_of_python_control():
    """python-control, control/tests/canonical_test.py: T is recovered to 1e-6."""
    T = np.array(
        [
            [-0.27144004, -0.39933167, 0.75634684, 0.44135471],
            [-0.74855725, -0.39136285, -0.18142339, -0.50356997],
            [-0.40688007, 0.81416369, 0.38002113, -0.16483334],
            [-0.44769516, 0.15654653, -0.50060858, 0.72419146],
        ]
    )
    A_true = np.eye(4, k=1)
    A_true[:, 0] = [-4, -3, -2, -1]  # s^4 + 4 s^3 + 3 s^2 + 2 s + 1
    C_true = np.eye(4)[:1]
    plant = lb.Plant(
        np.linalg.solve(T, A_true @ T),
        np.linalg.solve(T, np.ones((4, 1))),
        C_true @ T,
        [[42]],
    )
    form = observability_form(plant)
    expected = np.eye(4, k=1)
    expected[3] = [-1, -2, -3, -4]
    assert np.allclose(form.Phi, expected, rtol=0, atol=1e-6)
    assert (form.H == C_true).all() and form.indices == (4,)
    chain = np.vstack([C_true @ np.linalg.matrix_power(A_true, k) for k in range(4)])
    assert np.allclose(np.linalg.solve(chain, form.P), T, rtol=0, atol=1e-6)
    assert np.allclose(form.G, chain @ np.ones((4, 1)), rtol=0, atol=1e-6)


def test_published_stairs_of_slicot():
    """SLICOT AB01OD, dual: stairs 2, 2, 1, so the indices are 3 and 2."""
    A, C = AB01OD
    form = observability_form(lb.Plant(A, None, C, dt=1.0))
    assert form.indices == (3, 2) and form.exact
    exact = lb.Plant(A, None, C).exact["A"]
    assert (form.P @ exact == form.Phi @ form.P).all()


def test_published_decomposition_of_harold():
    """harold, tests/test_kalman_ops.py: rank 2, and -3 is not observable."""
    plant = lb.Plant([[2, 1, 1], [5, 3, 6], [-5, -1, -4]], [[1], [0], [0]], [[1, 0, 0]])
    for given_ in (plant, lb.Plant(plant.A, plant.B, plant.C)):
        with pytest.raises(lb.DesignError, match="only 2 of the 3.*mode.* -3 do"):
            observability_form(given_)


def test_largest_is_better_conditioned():
    """Two outputs that nearly agree: which one is continued makes the difference."""
    tiny = 1e-5
    A = np.array([[0.5, 1, 0], [0, 0.4, 1], [0, 0, 0.3]])
    C = np.array([[0, 1, tiny], [1, 0, 0]])
    plain = observability_form(lb.Plant(A, None, C, dt=1.0))
    largest = observability_form(lb.Plant(A, None, C, dt=1.0), selection="largest")
    assert sorted(plain.indices) == sorted(largest.indices) == [1, 2]
    assert largest.cond <= plain.cond
    C = np.array([[1, 0, 0], [0, 1, 0]])
    A = np.array([[0, 0, tiny], [0.2, 0, 1], [0.5, 0.1, 0]])
    plant = lb.Plant(A, None, C, dt=1.0)
    plain = observability_form(plant)
    largest = observability_form(plant, selection="largest")
    assert plain.indices == (2, 1) and largest.indices == (1, 2)
    assert plain.cond > 1e4 * largest.cond and largest.margin > 0.1
    twice = lb.Plant(A, None, [[1e9, 0, 0], [0, 1, 0]], dt=1.0)  # units of y1
    assert observability_form(twice, selection="largest").indices == (1, 2)


def test_largest_of_an_exact_plant_is_exact():
    plant = lb.Plant(
        [
            [0, 0, Fraction(1, 10**5)],
            [Fraction(1, 5), 0, 1],
            [Fraction(1, 2), Fraction(1, 10), 0],
        ],
        None,
        [[1, 0, 0], [0, 1, 0]],
        dt=1.0,
    )
    form = observability_form(plant, selection="largest")
    assert form.indices == (1, 2) and form.exact
    assert (form.P @ plant.exact["A"] == form.Phi @ form.P).all()


def record(plant, N, seed=1):
    """A record run in the plant's own arithmetic."""
    rng = np.random.default_rng(seed)
    if plant.exact is not None:
        A, B, C, E = (plant.exact[k] for k in "ABCE")
        u, x = fractions(rng, N, plant.m), [fractions(rng, plant.n)]
    else:
        A, B, C, E = plant.A, plant.B, plant.C, plant.E
        u, x = rng.normal(size=(N, plant.m)), [rng.normal(size=plant.n)]
    for k in range(N - 1):
        x.append(A @ x[k] + B @ u[k])
    x = np.array(x)
    return x, x @ C.T + u @ E.T, u


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_exact_states(indices):
    plant, _, _ = exact_plant(indices, seed=2)
    x, y, u = record(plant, max(indices) + 3)
    start = reconstruct_state(plant, y, u)
    assert start.dtype == object and (start == x[:4]).all() and len(start) == 4
    end = reconstruct_state(plant, y, u, at="end")
    assert (end == x[max(indices) - 1 :]).all()
    floats = reconstruct_state(plant, y.astype(float), u.astype(float))
    assert floats.dtype == float


def random_plant(seed, n, p, m=1, singular=False):
    rng = np.random.default_rng(seed)
    A = rng.normal(size=(n, n)) / np.sqrt(n)
    if singular:
        A = A @ np.diag([0, *np.ones(n - 1)])
    return lb.Plant(
        A,
        rng.normal(size=(n, m)),
        rng.normal(size=(p, n)),
        rng.normal(size=(p, m)),
        dt=1.0,
    )


@pytest.mark.parametrize("selection", ["interleaved", "largest"])
@pytest.mark.parametrize("singular", [False, True])
@pytest.mark.parametrize("n, p", [(1, 1), (4, 1), (6, 2), (7, 3), (9, 4), (5, 5)])
def test_states_from_every_window(n, p, singular, selection):
    plant = random_plant(n + p, n, p, singular=singular and n > 1)
    form = observability_form(plant, selection=selection)
    x, y, u = record(plant, 25)
    found = reconstruct_state(plant, y, u, selection=selection)
    assert found.shape == (25 - form.samples + 1, n)
    scale = 100 * form.cond * EPS * np.abs(x).max()
    assert np.abs(found - x[: len(found)]).max() < scale
    end = reconstruct_state(plant, y, u, at="end", selection=selection)
    assert np.abs(end - x[form.samples - 1 :]).max() < scale


def test_redundant_outputs_are_accepted_in_a_record():
    plant = lb.Plant(
        [[1, 0.5], [0, 1]], [[0.1], [1]], [[1, 0], [2, 0]], [[1], [0]], dt=1.0
    )
    x, y, u = record(plant, 6)
    assert np.allclose(reconstruct_state(plant, y, u), x[:5])


@pytest.mark.parametrize(
    "call, error, message",
    [
        (
            lambda: observability_form(
                lb.Plant(np.eye(2), None, [[1, 0], [2, 0]], output_names=["a", "b"])
            ),
            lb.DesignError,
            r"not observable: only 1 of the 2.*modes 1 do not reach",
        ),
        (
            lambda: observability_form(
                lb.Plant(
                    [[1, 1], [0, 1]], None, [[1, 0], [2, 0]], output_names=["a", "b"]
                )
            ),
            lb.DesignError,
            r"outputs \['b'\] are linear combinations.*Leave them out",
        ),
        (
            lambda: observability_form(
                lb.Plant(np.stack([np.eye(2)] * 3), None, np.eye(2), dt=1.0)
            ),
            lb.DesignError,
            "time-varying plant has no observability form",
        ),
        (
            lambda: observability_form(lb.Plant([[1]], None, [[1]]), selection="first"),
            ValueError,
            "selection must be 'interleaved' or 'largest', got 'first'",
        ),
        (
            lambda: reconstruct_state(lb.Plant([[1]], None, [[1]]), [1, 2]),
            lb.DesignError,
            "continuous.*plant.sampled\\(0.1\\) makes the discrete",
        ),
        (
            lambda: reconstruct_state(PAIR, [[1]]),
            ValueError,
            r"needs 2 consecutive samples \(.*index\), y has 1",
        ),
        (
            lambda: reconstruct_state(PAIR, [1, np.nan, 2]),
            ValueError,
            r"y has entries that are not finite: y\[1, 0\]",
        ),
        (
            lambda: reconstruct_state(PAIR, [[1, 2]]),
            ValueError,
            r"y must be \(N, 1\), got \(1, 2\)",
        ),
        (
            lambda: reconstruct_state(PAIR, [1, 2, 3], [1, 2]),
            ValueError,
            "y has 3 rows but u has 2",
        ),
        (
            lambda: reconstruct_state(PAIR, [1, 2, 3], at="middle"),
            ValueError,
            "at must be 'start' or 'end'",
        ),
        (
            lambda: reconstruct_state(
                lb.Plant([[0, 1], [0, 0]], None, [[0, 1]], dt=1.0), [1, 0, 0]
            ),
            lb.DesignError,
            "modes 0 do not reach them. They die out.*deadbeat_observer accepts",
        ),
    ],
)
def test_refusals(call, error, message):
    with pytest.raises(error, match=message):
        call()


PAIR = lb.Plant([[1, 1], [0, 1]], [[0], [1]], [[1, 0]], dt=1.0)


def test_lost_digits_are_announced():
    modes = np.diag(np.arange(1, 17) / 16)
    plant = lb.Plant(modes, None, np.ones((1, 16)), dt=1.0)
    with pytest.warns(RuntimeWarning, match=r"cond\(P\) = .*digits of the state"):
        reconstruct_state(plant, np.zeros(16))


@bounded(25)
@given(
    st.integers(1, 7).flatmap(
        lambda n: st.tuples(st.just(n), st.integers(1, n), st.integers(0, 10**6))
    )
)
def test_units_decide_nothing(case):
    """Indices and states are the same in units from 1e-8 to 1e8."""
    n, p, seed = case
    rng = np.random.default_rng(seed)
    plain = random_plant(seed, n, p)
    d, s = 10 ** rng.uniform(-8, 8, n), 10 ** rng.uniform(-8, 8, p)
    plant = lb.Plant(
        plain.A / d[:, None] * d,
        plain.B / d[:, None],
        plain.C * d / s[:, None],
        plain.E / s[:, None],
        dt=1.0,
    )
    for selection in ("interleaved", "largest"):
        first = observability_form(plain, selection=selection)
        form = observability_form(plant, selection=selection)
        assert form.samples == first.samples == -(-n // p)
        x, y, u = record(plain, 12)
        found = reconstruct_state(plant, y / s, u, selection=selection) * d
        # what y holds beside the state, E u above all, is rounded too
        beside = np.linalg.norm(np.linalg.inv(first.P)) * np.abs(y).max()
        bound = 1e3 * EPS * (first.cond * np.abs(x).max() + beside)
        assert np.abs(found - x[: len(found)]).max() < bound


@bounded(60)
@given(
    n=st.integers(1, 8),
    p=st.integers(1, 4),
    seed=st.integers(0, 10**6),
    small=st.sampled_from([0, 1e-6, 1e-12, 1e-17]),
)
def test_a_form_or_a_refusal(n, p, seed, small):
    """Repeated modes, weak links and dependent outputs: never a silent NaN."""
    rng = np.random.default_rng(seed)
    A = np.eye(n) * rng.choice([0, 0.5]) + np.diag(rng.choice([1, small], n - 1), 1)
    C = rng.normal(size=(p, n)) * (rng.random((p, n)) < 0.4)
    plant = lb.Plant(A, None, C, dt=1.0)
    for selection in ("interleaved", "largest"):
        try:
            form = observability_form(plant, selection=selection)
        except lb.DesignError:
            continue
        assert sum(form.indices) == n and min(form.indices) >= 1
        assert all(np.isfinite(X).all() for X in (form.P, form.Phi, form.H))
        residual = np.abs(form.P @ A - form.Phi @ form.P).max()
        assert residual < 1e-9 * max(1, np.abs(form.Phi).max()) or form.cond > 1e12
