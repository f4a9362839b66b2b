"""What runs is what the pages prove: run on symbols, entry by entry."""

import numpy as np
import pytest
import sympy as sp
from on_the_page import broken_relations

import luenberger as lb
from luenberger.papers.kawazoe import deadbeat as design
from luenberger.papers.kawazoe import form as running
from luenberger.papers.kawazoe.derivation import deadbeat, form, reconstruction
from luenberger.papers.kawazoe.form import observability_form
from luenberger.papers.kawazoe.reconstruction import known_part, reconstruct_state

PATTERNS = [*form.PATTERNS, (1, 2), (4, 1), (1, 3, 2)]
UNUSED = sp.Symbol("unused")


def objects(matrix):
    return np.array(matrix.tolist(), dtype=object).reshape(matrix.shape)


def same(found, wanted):
    return (sp.Matrix(found.tolist()) - wanted).expand() == 0 * wanted


def form_of(of, G):
    rows = of.Phi.extract([end - 1 for end in of.ends], range(of.n))
    Phi, H = running.structure(of.indices, objects(rows))
    return running.ObservabilityForm(np.eye(of.n), Phi, G, H, of.indices)


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_the_structure_is_that_of_the_page(indices):
    """(11), (14): ones, the rows that are given, and the heads."""
    of = form.Pattern(indices)
    found = form_of(of, None)
    assert same(found.Phi, of.Phi) and same(found.H, of.H)
    assert found.samples == of.samples


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_the_rows_are_those_of_the_page(indices):
    """(6): each row of a block is the one before it times A; the last powers follow."""
    n, m = sum(indices), len(indices)
    A, C = form.named("a", n, n), form.named("c", m, n)
    in_them = np.vectorize(sp.ring([*A, *C], sp.ZZ)[0], [object])  # multiplied out
    A, C = in_them(objects(A)), in_them(objects(C))
    powers = [in_them(objects(sp.eye(n)))]
    for _ in range(max(indices)):
        powers.append(powers[-1] @ A)
    P, last = running.rows(A, C, indices)
    wanted = [C[i] @ powers[k] for i, size in enumerate(indices) for k in range(size)]
    assert (P == np.array(wanted)).all()
    after = [C[i] @ powers[size] for i, size in enumerate(indices)]
    assert (last == np.array(after)).all()


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_the_known_part_is_that_of_the_page(indices):
    """(15)-(25): from outputs that are run symbol by symbol back to w."""
    of = form.Pattern(indices)
    values = reconstruction.window(of)
    G = objects(form.named("g", of.n, reconstruction.INPUTS))
    y = np.full((of.samples, of.m), UNUSED)
    read = iter(values[reconstruction.y_s])
    for i, size in enumerate(indices):
        y[:size, i] = [next(read) for _ in range(size)]
    u = objects(values[reconstruction.u_p]).reshape(of.samples - 1, -1)
    u = np.vstack([u, np.full((1, reconstruction.INPUTS), UNUSED)])
    w = known_part(form_of(of, G), y, u, 1)
    assert same(w.T, values[reconstruction.w])


@pytest.mark.parametrize("indices", PATTERNS, ids=str)
def test_the_recursion_is_that_of_the_page(indices):
    """T, F and D of the block recursion, with left inverses that pick rows."""
    of = form.Pattern(indices)
    wanted = deadbeat.observer(of)
    sizes = [len(own) for own in deadbeat.levels(indices)]
    one = lambda k: objects(sp.eye(k))  # noqa: E731
    inverses = [objects(X) for X in deadbeat.units(of)]
    found = design.rows_of_T(objects(wanted[deadbeat.A_U]), sizes, inverses, one)
    for X, letter in zip(found, (deadbeat.F, deadbeat.D, deadbeat.T_U)):
        assert same(X, wanted[letter])


@pytest.mark.parametrize("sizes", [(2, 2, 2), (1, 2, 3), (1, 1, 2)], ids=str)
def test_the_recursion_is_proved_for_any_stairs(sizes):
    """Symbols for every entry of a staircase, and for left inverses of its stairs."""
    at = np.cumsum([0, *sizes])
    A, last = objects(form.named("a", at[-1], at[-1])), len(sizes) - 1
    for c in range(last):
        me, below = slice(at[c], at[c + 1]), slice(at[c + 1], at[c + 2])
        A[at[c + 2] :, me] = 0
        A[below, me] = np.eye(sizes[c + 1], sizes[c], dtype=int)  # a stair of ones
    one = lambda k: np.eye(k, dtype=int)  # noqa: E731
    inverses = [np.eye(*pair, dtype=int) for pair in zip(sizes, sizes[1:])]
    F, D, T = design.rows_of_T(A, sizes, inverses, one)
    C = np.hstack([np.zeros((sizes[-1], at[-2]), int), np.eye(sizes[-1], dtype=int)])
    assert same(T @ A - F @ T - D @ C, sp.zeros(*T.shape))
    assert same(np.linalg.matrix_power(F, last), sp.zeros(*F.shape))


@pytest.mark.parametrize("seed", [1, 2, 3])
def test_a_form_is_what_the_page_says(seed):
    """(8)-(14) and the two ends of a window, on numbers."""
    rng = np.random.default_rng(seed)
    plant = lb.Plant(
        rng.normal(size=(5, 5)) / 2,
        rng.normal(size=(5, 3)),
        rng.normal(size=(2, 5)),
        rng.normal(size=(2, 3)),
        dt=1.0,
    )
    found = observability_form(plant)
    x, u = rng.normal(size=(5, 1)), rng.normal(size=(4, 3))
    states = [x]
    for now in u:
        states.append(plant.A @ states[-1] + plant.B @ now[:, None])
    values = {
        form.A: plant.A,
        form.B: plant.B,
        form.C: plant.C,
        form.P: found.P,
        form.Phi: found.Phi,
        form.G: found.G,
        form.H: found.H,
        form.x: x,
        form.x_next: states[1],
        form.u: u[:1].T,
        form.w: found.P @ x,
        form.w_next: found.P @ states[1],
        form.y: plant.C @ x,
    }
    last = [end - 1 for end in form.Pattern(found.indices).ends]
    within, every = [k for k in range(5) if k not in last], np.eye(5)
    values |= {form.E_0: every[within], form.E_n: every[[k + 1 for k in within]]}
    values |= {form.Z: values[form.E_0].T @ values[form.E_n], form.E_p: every[last]}
    values[form.phi] = found.Phi[last]
    tried, failed = broken_relations(form.page.page, values)
    assert failed == [] and tried == 13
    y = np.hstack(states[:4]).T @ plant.C.T + u @ plant.E.T
    k = found.samples - 1
    for at, wanted in (("start", states), ("end", states[k:])):
        state = reconstruct_state(plant, y, u, at=at)
        np.testing.assert_allclose(state, np.hstack(wanted[: 4 - k]).T, atol=1e-9)
