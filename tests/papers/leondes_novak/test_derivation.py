"""Every derivation is proved, says what it should, and notices damage."""

import dataclasses
import re

import numpy as np
import pytest
import sympy as sp
from sympy import MatAdd, MatrixSymbol, Trace
from worlds import STAGE_LISTS, Numbers, close, damages, expr, one_wrong_sign, symbols

from luenberger.papers.leondes_novak.derivation import (
    brammer,
    huddle,
    limiting_cases,
    missing_outputs,
    tracking,
)
from luenberger.papers.leondes_novak.derivation import claims as recursion_proofs
from luenberger.papers.leondes_novak.derivation import paper as trace_minimisation
from luenberger.papers.leondes_novak.derivation import stages as recursions
from luenberger.symbolic import Derivation, ShapeError, Solve

RECURSIONS = {name: getattr(recursions, name)() for name in STAGE_LISTS}
ENTRY_POINTS = {
    "huddle": huddle.derive(),
    "trace_minimisation": trace_minimisation.derive(),
    "limiting_cases": limiting_cases.derive(),
    "tracking": tracking.derive(),
}
PARTS = {
    **RECURSIONS,
    **trace_minimisation.parts(),
    "huddle": huddle.derive(),
    "limiting cases": limiting_cases.derive(),
    "brammer": brammer.derive(),
    "tracking": tracking.derive(),
    "missing outputs": missing_outputs.derive(),
}
CLAIMS = {
    f"{part}: {name}": (part, claim)
    for part, derivation in PARTS.items()
    for name, claim in derivation.steps.items()
}
SYMBOLIC = {
    name: found
    for name, found in CLAIMS.items()
    if getattr(found[1], "algebra", None) is not None
}


# -- proved -------------------------------------------------------------------------


@pytest.mark.parametrize("name", [*ENTRY_POINTS, *RECURSIONS])
def test_proved(name):
    derivation = {**ENTRY_POINTS, **RECURSIONS}[name]
    assert derivation.steps
    assert derivation.unproved() == []
    assert derivation.source


def test_the_entry_point_holds_every_step_of_its_parts():
    whole = trace_minimisation.derive()
    parts = trace_minimisation.parts().values()
    assert len(whole.steps) == sum(len(part.steps) for part in parts)


def test_every_numbered_equation_has_an_entry():
    found = set()
    for derivation in ENTRY_POINTS.values():
        for key in (*derivation.formulas, *derivation.steps):
            head = re.match(r"(?:\(\d+\)[,-]?)*", key).group()
            numbers = [int(k) for k in re.findall(r"\d+", head)]
            found |= set(numbers)
            if ")-(" in head:
                found |= set(range(min(numbers), max(numbers) + 1))
    assert set(range(7, 59)) - found == set()


@pytest.mark.parametrize(
    "numbers, where",
    [
        (range(7, 16), "huddle"),
        (range(16, 37), "trace_minimisation"),
        (range(37, 54), "limiting_cases"),
        (range(54, 59), "tracking"),
    ],
    ids=lambda x: x if isinstance(x, str) else f"({x[0]})-({x[-1]})",
)
def test_equations_are_found_where_the_paper_has_them(numbers, where):
    derivation = ENTRY_POINTS[where]
    keys = " ".join((*derivation.formulas, *derivation.steps))
    assert [k for k in numbers if f"({k})" not in keys and k != 42] == []


def test_formulas_have_latex():
    for derivation in ENTRY_POINTS.values():
        for name, formula in derivation.formulas.items():
            assert sp.latex(formula), name


# -- stage lists --------------------------------------------------------------------


@pytest.mark.parametrize("name", STAGE_LISTS)
def test_stages_use_only_what_is_known(name):
    derivation = RECURSIONS[name]
    known = set(derivation.given)
    assert len({s.name for s in known}) == len(known)
    for stage in derivation.stages:
        parts = stage.formula
        parts = (parts.N, parts.M) if isinstance(parts, Solve) else (parts,)
        used = set().union(*(symbols(part) for part in parts))
        assert used <= known
        assert stage.target.shape == stage.formula.shape
        known.add(stage.target)


def damaged_stages():
    for name in STAGE_LISTS:
        for i, what, formula in one_wrong_sign(RECURSIONS[name].stages):
            yield pytest.param(name, i, formula, id=f"{name}-{what}")


@pytest.mark.parametrize("name, index, formula", list(damaged_stages()))
def test_one_wrong_sign_in_a_stage_is_noticed(name, index, formula):
    sound = RECURSIONS[name]
    stages = list(sound.stages)
    stages[index] = dataclasses.replace(stages[index], formula=formula)
    broken = dataclasses.replace(sound, stages=tuple(stages))
    extra = (RECURSIONS["gain_step"],) if name == "step_differential" else ()
    if any(stage.by for stage in stages):  # each has the chain that justifies it
        assert broken.unproved()
        return
    try:
        steps = getattr(recursion_proofs, name)(broken, *extra)
    except ShapeError:
        return
    assert dataclasses.replace(broken, steps=steps).unproved()


@pytest.mark.parametrize("name", STAGE_LISTS)
def test_symmetric_stages_are_symmetric(name):
    derivation = RECURSIONS[name]
    given = Numbers({**SIZES, "r": 4}, 7)
    for s in derivation.given:
        if s.name in SYMMETRIC:
            value = given.rng.normal(size=given.shape(s))
            given.known[s] = value @ value.T
    if name == "decorrelation":  # S = J R with R symmetric
        noise = given.rng.normal(size=(given.sizes["p"],) * 2)
        S, J = derivation.given[3:]
        given.known[S] = given.symbol(J) @ (noise @ noise.T)
    for stage in derivation.stages:
        given.defined.pop(stage.target, None)
        formula = stage.formula
        formula = formula.as_inverse() if isinstance(formula, Solve) else formula
        value = given.known[stage.target] = given.value(formula)
        if stage.symmetric:
            np.testing.assert_allclose(value, value.T, atol=1e-9)


SYMMETRIC = {"Q", "R", "Sigma", "X", "M", "Omega", "dOmega", "Lambda"}

# -- damage -------------------------------------------------------------------------

# Claims that something is zero, where a factor may be doubled at no loss.
HOMOGENEOUS = re.compile(
    r"forces? |it vanishes|matched|uncorrelated|N' Gradient|= 0$|= 0:"
    r"|M(\^-1)? M(\^-1)? = I by blocks|Gamma' W N = 0 for the same Gamma"
)


@pytest.mark.parametrize("name", list(SYMBOLIC))
def test_damage_is_noticed(name):
    _, claim = SYMBOLIC[name]
    left = expr(claim.left)
    noticed = []
    for what, broken in damages(left):
        try:
            sound = dataclasses.replace(claim, left=broken).is_zero
        except (ShapeError, sp.ShapeError, ValueError, TypeError):
            sound = False
        if not sound:
            noticed.append(what)
    if not symbols(left):
        assert not dataclasses.replace(claim, left=2 * left).is_zero
        return
    kinds = {what.split()[0] for what in noticed}
    assert "transposed" in kinds
    if not HOMOGENEOUS.search(name):
        terms = left.args if isinstance(left, (sp.Add, MatAdd)) else ()
        terms = [t for t in terms if not claim.algebra.normal(t).is_zero]
        assert sum(what.startswith("sign") for what in noticed) == len(terms)
        assert "twice" in kinds or terms  # K1 may be doubled in T and V together


def test_a_false_step_is_not_proved():
    X = MatrixSymbol("X", 2, 2)
    assert Derivation(steps={"false": sp.Matrix(X)}).unproved() == ["false"]
    assert not Derivation().proved()


def test_misprints_are_rejected_for_a_reason():
    places = [place for place, _, _ in trace_minimisation.misprints()]
    assert {"(20)", "(24)", "(29)", "(30)", "(32) first", "(33)"} <= set(places)
    assert sum(place == "(32) second" for place in places) == 3


# -- numbers ------------------------------------------------------------------------

SIZES = dict(n=5, p=3, m_1=1, m1=1, m=2, r=2, g=2, p_a=2, p_m=1)


def definite(rng, k, rank=None):
    root = rng.normal(size=(k, k if rank is None else rank))
    return root @ root.T


def null(C):
    """Basis of the null space of a full-rank C."""
    return np.linalg.svd(C)[2][len(C) :].T


def accurate(rng, perfect=False):
    """C1, N, T^, Gamma and the noise covariances of a plant with accurate rows."""
    n, p, m1 = SIZES["n"], SIZES["p"], SIZES["m_1"]
    C, W, Omega = rng.normal(size=(p, n)), definite(rng, n), definite(rng, n)
    select = np.eye(p)[:m1]
    R = definite(rng, p)
    if perfect:
        R[:m1] = R[:, :m1] = 0
    That = rng.normal(size=(n - m1, n))
    columns = np.linalg.inv(np.vstack([That, select @ C]))
    N, Gamma = columns[:, : n - m1], columns[:, n - m1 :]
    C1, M = select @ C, C @ Omega @ C.T + R
    Wi = np.linalg.inv(W)
    Kmv = Omega @ C.T @ np.linalg.inv(M)
    free, x = rng.normal(size=(n, p)), rng.normal(size=(n, 1))
    return dict(
        x=x,
        y=C @ x,
        C=C, C_1=C1, S_1=select, W=W, Omega=Omega, M=M, That=That, Phat=N, N=N,
        Gamma=Gamma, Vhat_1=Gamma, Gamma_W=Wi @ C1.T @ np.linalg.inv(C1 @ Wi @ C1.T),
        K=free + Gamma @ (select - C1 @ free), k=That @ Kmv,
        Psi=select @ R @ np.linalg.inv(M) @ R @ select.T,
        G=C1 @ Wi @ C1.T, **{"Khat_+": free + Gamma @ (select - C1 @ free)},
        Sigma_p=Omega,
    )  # fmt: skip


def square_w(rng):
    """W and Psi given by their factors."""
    world = accurate(rng)
    m1 = SIZES["m_1"]
    L_W, L_Psi = np.linalg.cholesky(world["W"]), np.eye(m1) * 1.7
    return {**world, "L_W": L_W, "L_Psi": L_Psi}


def step(rng):
    """Gamma (n, p) with C Gamma C = C1 rows and N' W Gamma = 0."""
    world = accurate(rng)
    Gamma = world["Gamma_W"] @ world["S_1"]
    N = null(world["C_1"])[:, : SIZES["g"]]
    common = dict(C=world["C"], Omega=world["Omega"], M=world["M"], N=N, Gamma=Gamma)
    Kmv = world["Omega"] @ world["C"].T @ np.linalg.inv(world["M"])
    weights = {"W": world["W"], "Lambda": world["W"]}
    return {**common, **weights, "Select": world["S_1"], "Kmv": Kmv}


def observing(rng):
    """Phat That = I - Gamma C with r = n - m1; needs r of that size."""
    world = accurate(rng)
    Gamma = world["Gamma"] @ world["S_1"]
    return {**{k: world[k] for k in ("C", "Phat", "That")}, "Gamma": Gamma}


def unbiased(rng):
    """[P V] inverse to [T; C], r + p = n, and the observer of Huddle."""
    n, p, m, r = (SIZES[k] for k in "npmr")
    A, B, C, E = (rng.normal(size=d) for d in ((n, n), (n, m), (p, n), (p, m)))
    T, Tn = rng.normal(size=(r, n)), rng.normal(size=(r, n))
    inverse = np.linalg.inv(np.vstack([T, C]))
    P, V = inverse[:, :r], inverse[:, r:]
    D = Tn @ A @ V
    null_R = rng.normal(size=(p, p - 1))
    a = null(null_R.T)
    world = dict(A=A, B=B, C=C, E=E, T=T, P=P, V=V, F=Tn @ A @ P, D=D, G=Tn @ B - D @ E)
    return {**world, "T_+": Tn, "R": null_R @ null_R.T, "a": a, "S": np.zeros((n, p))}


def unseen(rng):
    return {**unbiased(rng), "a": np.zeros((SIZES["n"], 1))}


def inverse_rows(rng):
    n, p, m1 = SIZES["n"], SIZES["p"], SIZES["m_1"]
    Mbar = rng.normal(size=(n, n))
    rows, cols = np.split(Mbar, [m1, p]), np.split(np.linalg.inv(Mbar), [m1, p], axis=1)
    return dict(zip(("C_1", "C_2", "L", "X_1", "X_2", "X_3"), (*rows, *cols)))


def optimum(rng):
    """K* of (33) for random blocks."""
    n, p, m1 = SIZES["n"], SIZES["p"], SIZES["m_1"]
    Omega, R = definite(rng, n), definite(rng, p)
    H = np.zeros((p, n))
    H[:m1, :m1], H[m1:, m1:] = np.eye(m1), rng.normal(size=(p - m1, n - m1))
    K = np.linalg.solve(H @ Omega @ H.T + R, H @ Omega)[:, m1:].T
    return {
        "Omega_11": Omega[:m1, :m1], "Omega_21": Omega[m1:, :m1],
        "Omega_22": Omega[m1:, m1:], "R_11": R[:m1, :m1], "R_21": R[m1:, :m1],
        "R_22": R[m1:, m1:], "H_2": H[m1:, m1:], "K_1": K[:, :m1], "K_2": K[:, m1:],
        "K_1*": K[:, :m1], "K_2*": K[:, m1:],
    }  # fmt: skip


def invisible(rng):
    """Noises that leave a combination a of the outputs alone."""
    n, p = SIZES["n"], SIZES["p"]
    H, a = rng.normal(size=(p, n)), rng.normal(size=(p, 1))
    seen = H.T @ a
    clean = lambda x: np.eye(len(x)) - x @ np.linalg.pinv(x)  # noqa: E731
    return dict(H=H, a=a, G=clean(seen) @ rng.normal(size=(n, n)),
                G_R=clean(a) @ rng.normal(size=(p, p)))  # fmt: skip


def innovation(rng):
    """P+ T+ = I - V+ C, and whole-state filters with identities."""
    n, p = SIZES["n"], SIZES["p"]
    world, K = accurate(rng), rng.normal(size=(n, p))
    K = K + world["Gamma"] @ (world["S_1"] - world["C_1"] @ K)
    T = world["That"] @ (np.eye(n) - K @ world["C"])
    return {**world, "P_+": world["Phat"], "T_+": T, "V_+": K}


def perfect(rng):
    return accurate(rng, perfect=True)


def one_row_less(rng):
    """C1 and one accurate row c more, the null space of both, and g that c shows."""
    n, m1 = SIZES["n"], SIZES["m_1"]
    rows = rng.normal(size=(m1 + 1, n))
    values = {"C_1": rows[:m1], "c": rows[m1:], "g_c": np.linalg.pinv(rows)[:, m1:]}
    return {**values, "N": np.linalg.svd(rows)[2][m1 + 1 :].T}


WORLDS = (dict, step, observing, accurate, perfect, square_w, unbiased, unseen,
          inverse_rows, optimum, invisible, innovation, one_row_less)  # fmt: skip


def numbers_for(part, claim):
    """Values that satisfy the relations of a claim, from the first world that does."""
    sizes = {**SIZES, "r": SIZES["n"] - SIZES["m_1"]} if part == "observer" else SIZES
    for make in WORLDS:
        values = make() if make is dict else make(np.random.default_rng(5))
        given = Numbers(
            sizes, 7, claim.algebra.symmetric, claim.relations, values=values
        )
        try:
            if all(close(given, *relation) for relation in claim.relations):
                return given
        except RecursionError:
            continue
    raise AssertionError("no world satisfies the relations")


@pytest.mark.parametrize("name", list(SYMBOLIC))
def test_numbers_agree(name):
    part, claim = SYMBOLIC[name]
    given = numbers_for(part, claim)
    left = given.value(expr(claim.left))
    right = 0 if isinstance(claim.right, int) else given.value(expr(claim.right))
    scale = 1 + np.abs(left).max(initial=0)
    np.testing.assert_allclose(left, right + 0 * left, atol=1e-7 * scale)


def test_numbers_would_notice():
    claim = RECURSIONS["estimate_step"].steps["(43) x_minus = A x + B u + J rho"]
    given = numbers_for("estimate_step", claim)
    assert not close(given, claim.left, 2 * claim.right)


def test_best_coordinates_minimise_the_trace():
    """The theorem, measured: no other Gamma does better; the gain is (33)'s."""
    rng = np.random.default_rng(11)
    w = accurate(rng)
    C, Om, M, W = w["C"], w["Omega"], w["M"], w["W"]
    R, Kmv = M - C @ Om @ C.T, Om @ C.T @ np.linalg.inv(M)

    def cost(Gamma):
        K = Kmv + Gamma @ (w["S_1"] - w["C_1"] @ Kmv)
        Y = np.eye(len(Om)) - K @ C
        return np.trace(W @ (Y @ Om @ Y.T + K @ R @ K.T))

    best = cost(w["Gamma_W"])
    for _ in range(20):
        moved = w["Gamma_W"] + w["N"] @ rng.normal(size=(4, 1))
        assert cost(moved) > best


def test_trace_names_are_scalars():
    assert isinstance(trace_minimisation.derive().formulas["(30) J"].args[0], sp.Basic)
    assert trace_minimisation.derive().formulas["(30) J"].has(Trace)
