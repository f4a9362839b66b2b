"""Moore's derivation: proved, complete, and sensitive to damage."""

import dataclasses
import re
from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from sympy import MatAdd
from worlds import Numbers, symbols

from luenberger import kernels
from luenberger.papers.moore.derivation import (
    companion_row,
    condition,
    errata,
    observer,
    observer_input,
    recurrence,
    signs,
)
from luenberger.symbolic import ShapeError, vanishes

DERIVATIONS = {
    "general": observer.derive(),
    "recurrence": recurrence.derive(),
    "signs": signs.derive(),
}
STAGE_LISTS = {
    "companion_row": (observer.companion_row(), condition.row_steps),
    "observer": (observer.observer(), observer.prove_observer),
}
CLAIMS = {
    name: claim
    for derivation in DERIVATIONS.values()
    for name, claim in derivation.steps.items()
}
SYMBOLIC = [name for name, claim in CLAIMS.items() if claim.algebra is not None]


# -- proved -------------------------------------------------------------------------


@pytest.mark.parametrize("name", DERIVATIONS)
def test_proved(name):
    assert DERIVATIONS[name].unproved() == []
    assert DERIVATIONS[name].source.startswith("Moore (1973)")


def test_no_two_steps_share_a_name():
    assert len(CLAIMS) == sum(len(d.steps) for d in DERIVATIONS.values())


def test_every_numbered_equation_has_an_entry():
    keys = [key for d in DERIVATIONS.values() for key in (*d.formulas, *d.steps)]
    heads = " ".join(re.match(r"(?:\(\d+\),?)*", key).group() for key in keys)
    assert [k for k in range(1, 14) if f"({k})" not in heads] == []


@pytest.mark.parametrize("name", ["general", "recurrence"])
def test_formulas_have_latex(name):
    for key, formula in DERIVATIONS[name].formulas.items():
        assert sp.latex(formula), key


def test_no_recurrence_is_violated_at_full_order():
    """r = n: S_n has no rows, so every characteristic polynomial is admissible."""
    assert recurrence.S([1, 2, 3, 1], 3).shape == (0, 3)


@pytest.mark.parametrize("place", errata.entries())
def test_errata_are_tried(place):
    printed, ours = errata.entries()[place]
    assert not vanishes(printed) and vanishes(ours)


# -- damage -------------------------------------------------------------------------


def damaged_stages():
    for name, (derivation, _) in STAGE_LISTS.items():
        for stage in derivation.stages:
            for k, term in enumerate(stage.formula.args):
                rest = [t for t in stage.formula.args if t is not term]
                for what, new in (("minus", -term), ("twice", 2 * term)):
                    damaged = dataclasses.replace(stage, formula=MatAdd(*rest, new))
                    yield pytest.param(name, damaged, id=f"{name}-{what}-{k}")


@pytest.mark.parametrize("name, stage", list(damaged_stages()))
def test_a_wrong_term_in_a_stage_is_noticed(name, stage):
    sound, prove = STAGE_LISTS[name]
    broken = dataclasses.replace(sound, stages=(stage,))
    assert any(not step.is_zero for step in prove(broken).values())


# Claims that something is zero, where a factor may be doubled at no loss.
HOMOGENEOUS = re.compile(r" = 0( |$)|do not see|vanishes|difference Delta|is the ")


@pytest.mark.parametrize("name", SYMBOLIC)
def test_a_wrong_factor_in_a_claim_is_noticed(name):
    claim = CLAIMS[name]
    left = claim.left.as_expr() if hasattr(claim.left, "algebra") else claim.left
    if not symbols(left):  # already zero before any relation is used
        assert claim.is_zero
        return
    noticed = set()
    for s in symbols(left):
        for what, new in (("twice", 2 * s), ("transposed", s.T)):
            try:
                broken = dataclasses.replace(claim, left=left.xreplace({s: new}))
                sound = broken.is_zero
            except (ShapeError, sp.ShapeError, ValueError, TypeError):
                sound = False
            if not sound:
                noticed.add(what)
    assert "transposed" in noticed
    assert "twice" in noticed or HOMOGENEOUS.search(name)


def unproved(steps):
    return [name for name, step in steps.items() if not vanishes(step)]


def wrong_top(beta, size, sound=recurrence.S):
    return sound([*beta[:-1], 2], size)


def wrong_order(beta, size, sound=recurrence.S):
    return sound(beta[::-1], size)


def unshifted(beta, size, sound=recurrence.S):
    found = sound(beta, size).as_mutable()
    found[-1, :] = found[0, :]
    return found


def wrong_krylov(F, t, size, sound=recurrence.krylov):
    return sound(F.T, t, size)


def wrong_companion(size, sound=recurrence.observable_form):
    A, C, alpha = sound(size)
    return A, C, [-a for a in alpha]


def wrong_output(size, sound=recurrence.observable_form):
    A, C, alpha = sound(size)
    return A, C[:, ::-1], alpha


def wrong_polynomial(F, sound=recurrence.characteristic):
    return sound(-F)


FAULTS = {
    "beta_r = 2": ("S", wrong_top, "(10)"),
    "beta in falling order": ("S", wrong_order, "(11)"),
    "last row of S_r not shifted": ("S", unshifted, "(11)"),
    "powers of F'": ("krylov", wrong_krylov, "(8)"),
    "sign of alpha in (8)": ("observable_form", wrong_companion, "(8)"),
    "C = [1 0 .. 0]": ("observable_form", wrong_output, "(8)"),
    "beta of -F": ("characteristic", wrong_polynomial, "(10)"),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_in_the_recurrence_is_noticed(fault, monkeypatch):
    name, wrong, equation = FAULTS[fault]
    assert unproved(recurrence.construction_steps(4, 2)) == []
    monkeypatch.setattr(recurrence, name, wrong)
    failed = unproved(recurrence.construction_steps(4, 2))
    assert any(step.startswith(equation) for step in failed)


@pytest.mark.parametrize("fault", [wrong_top, wrong_order, unshifted])
def test_the_row_space_notices_a_wrong_recurrence(fault, monkeypatch):
    monkeypatch.setattr(recurrence, "S", fault)
    assert unproved(recurrence.row_space_steps(4, 2))


def test_the_time_scale_notices_a_wrong_power(monkeypatch):
    monkeypatch.setattr(recurrence, "S", wrong_order)
    assert unproved(recurrence.scale_step(4, 2))


def test_signs_are_counted_only_when_they_are_known():
    x, y = sp.Symbol("x"), sp.Symbol("y", positive=True)
    assert signs.not_positive([x, y, 0, -y, y + 1]) == 3


# -- numbers ------------------------------------------------------------------------


def order_of(name):
    found = re.search(r"r = (\d)", name)
    return int(found[1]) if found else 3


def size_of(name):
    found = re.search(r"n = (\d)", name)
    return int(found[1]) if found else 7


def with_polynomial(rng, size):
    """A matrix whose polynomial has the coefficients that `Numbers` gives: 0.7."""
    turn = rng.normal(size=(size, size))
    return turn @ scipy.linalg.companion([1.0] + [0.7] * size) @ np.linalg.inv(turn)


def world(name):
    """Sizes, and matrices that satisfy what the claims take for granted."""
    rng, n, r = np.random.default_rng(4), size_of(name), order_of(name)
    if "Delta" in name:
        return two_solutions(rng)
    A = (
        with_polynomial(rng, n)
        if name[:3] in ("(1)", "(2)")
        else rng.normal(size=(n, n))
    )
    F, C, D = with_polynomial(rng, r), rng.normal(size=(1, n)), rng.normal(size=(r, 1))
    T = scipy.linalg.solve_sylvester(-F, A, D @ C)  # T A - F T = D C
    seen = np.vstack([C @ np.linalg.matrix_power(A, j) for j in range(n)])
    P = rng.normal(size=(2, r))
    values = dict(A=A, C=C, D=D, F=F, T=T, P=P, k=P @ T, M=T @ T.T)
    values["g"] = np.linalg.inv(seen)[:, -1:]
    values["N"] = np.linalg.svd(seen[:r])[2][r:].T[:, :2]
    return dict(n=n, p=1, m=2, r=r, q=2), values


def two_solutions(rng):
    """F Delta = Delta A and P Delta = 0 with a Delta that is not zero."""
    A, rest = rng.normal(size=(3, 3)), rng.normal(size=(5, 2))
    F = np.hstack([np.vstack([A, np.zeros((2, 3))]), rest])
    P = np.hstack([np.zeros((2, 3)), rng.normal(size=(2, 2))])
    return dict(n=3, p=1, m=2, r=5, q=2), dict(A=A, F=F, P=P, Delta=np.eye(5, 3))


def value(given, side):
    side = side.as_expr() if hasattr(side, "algebra") else side
    return 0.0 if isinstance(side, int) else given.value(side)


@pytest.mark.parametrize("name", SYMBOLIC)
def test_numbers_agree(name):
    claim = CLAIMS[name]
    sizes, values = world(name)
    given = Numbers(sizes, 7, claim.algebra.symmetric, claim.relations, values)
    for left, right in claim.relations:
        a, b = value(given, left), value(given, right)
        np.testing.assert_allclose(a, b + 0 * a, atol=1e-7 * (1 + np.abs(a).max()))
    left, right = value(given, claim.left), value(given, claim.right)
    scale = 1 + np.abs(left).max(initial=0)
    np.testing.assert_allclose(left, right + 0 * left, atol=1e-7 * scale)


def exact(rows):
    return np.array([[Fraction(x) for x in row] for row in rows], dtype=object)


def rational_case():
    """A plant, beta, D and k with k beta(A) = sum D_i C A^(r-i), all in Fractions."""
    A = exact([[0, 1, 0, 2], ["1/2", 0, 1, 0], [0, -1, 0, 1], [1, 0, "1/3", -2]])
    C = exact([[1, 0, 2, 0], [0, 1, 0, 0]])
    beta = [Fraction(3, 4), Fraction(2), Fraction(1, 5)]
    D = exact([[1, -2], ["1/3", 0], [2, "1/7"]])
    power, total, shown = exact(np.eye(4, dtype=int).tolist()), 0, 0
    for j, b in enumerate([*beta, Fraction(1)]):
        total = total + b * power
        shown = shown + (D[2 - j : 3 - j] @ C @ power if j < 3 else 0)
        power = power @ A
    k = sp.Matrix(shown.tolist()) * sp.Matrix(total.tolist()).inv()
    return A, C, beta, D, exact([[Fraction(int(x.p), int(x.q)) for x in k]])


def test_the_kernel_builds_an_exact_observer_row_by_row():
    A, C, beta, D, k = rational_case()
    step = kernels.compiled(companion_row)
    rows = [k]
    for i, b in enumerate(reversed(beta)):
        given = dict(t=rows[-1], A=A, b=exact([[b]]), k=k, d=D[i : i + 1], C=C)
        rows.append(step(**given)["t_next"])
    *rows, after = rows
    T = np.vstack(rows)
    F = exact([[-beta[2], 1, 0], [-beta[1], 0, 1], [-beta[0], 0, 0]])
    assert not after.any() and not (T @ A - F @ T - D @ C).any()
    B, E = exact([[1], [0], [2], [1]]), exact([["1/2"], [3]])
    G = kernels.compiled(observer_input)(T=T, B=B, D=D, E=E)["G"]
    assert (G == T @ B - D @ E).all()
    # run it, by hand: the error is P F^j (z - T x) whatever the input does
    x, z = exact([[1], [-2], [3], [1]]), exact([[5], [0], ["-1/3"]])
    error = z - T @ x
    for j in range(6):
        assert (z[:1] - k @ x == error[:1]).all()
        u = exact([[j * j - 2]])
        y = C @ x + E @ u
        x, z, error = A @ x + B @ u, F @ z + G @ u + D @ y, F @ error
