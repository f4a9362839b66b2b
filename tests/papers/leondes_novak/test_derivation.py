"""The equations of the paper are all there, and its stage lists can be run.

That every page holds and notices damage is tested in `tests/papers/test_pages.py`.
"""

import importlib
import re

import numpy as np
import pytest
import sympy as sp
from sympy import MatrixSymbol
from worlds import STAGE_LISTS, Numbers, symbols

from luenberger.papers.leondes_novak import derivation as recursions
from luenberger.papers.leondes_novak.derivation import (
    errata,
    tracking,
)
from matrixproof import Derivation, Relation, Solve

RECURSIONS = {name: getattr(recursions, name)() for name in STAGE_LISTS}


# -- proved -------------------------------------------------------------------------


@pytest.mark.parametrize("name", RECURSIONS)
def test_proved(name):
    assert RECURSIONS[name].proved()
    assert RECURSIONS[name].source


def test_claims_are_proved():
    assert tracking.page.proved() and tracking.page.source


SECTIONS = {
    "stochastic_system": range(1, 7),
    "huddle": range(7, 16),
    "coordinates": range(16, 24),
    "canonical_gain": range(24, 34),
    "start": range(34, 37),
    "limiting_cases": range(37, 45),
    "brammer": range(45, 54),
    "tracking": range(54, 59),
}


def numbers_on(module):
    """Every equation number that is on a page."""
    room = "luenberger.papers.leondes_novak.derivation"
    derivation = importlib.import_module(f"{room}.{module}").page
    introduced = [r.name for r in derivation.page if isinstance(r, Relation)]
    found = set()
    for name in (*derivation.steps, *introduced):
        for number in re.findall(r"\(([\d, –]+)\)", name):
            for part in number.split(", "):
                first, _, last = part.partition("–")
                found |= set(range(int(first), int(last or first) + 1))
    return found


@pytest.mark.parametrize("module", SECTIONS)
def test_equations_are_found_where_the_paper_has_them(module):
    assert set(SECTIONS[module]) - numbers_on(module) == set()


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


SYMMETRIC = {"Q", "R", "Sigma", "X", "M", "Omega", "dOmega", "dSigma_0", "Lambda"}


def test_a_false_step_is_not_proved():
    X = MatrixSymbol("X", 2, 2)
    assert Derivation(steps={"false": sp.Matrix(X)}).unproved() == ["false"]
    assert not Derivation().proved()


def test_misprints_are_rejected_for_a_reason():
    places = [place for place, _, _ in errata.misprints()]
    assert {"(20)", "(24)", "(29)", "(30)", "(32) first", "(33)"} <= set(places)
    assert sum(place == "(32) second" for place in places) == 3


# -- numbers ------------------------------------------------------------------------

SIZES = dict(n=5, p=3, m_1=1, m1=1, m=2, r=2, g=2, p_a=2, p_m=1)


def definite(rng, k, rank=None):
    root = rng.normal(size=(k, k if rank is None else rank))
    return root @ root.T


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
