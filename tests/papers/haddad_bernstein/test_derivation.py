"""The optimal projection equations: proved, complete, and sensitive to damage."""

import dataclasses
import re

import numpy as np
import pytest
import sympy as sp
from projection_worlds import WORLDS
from worlds import Numbers, close, damages, expr, symbols

from luenberger.papers.haddad_bernstein.derivation import paper
from luenberger.stage_list import stage_lists
from luenberger.symbolic import Relation, Solve, vanishes

DOOR = paper.__package__
LISTS = {name: make() for name, make in stage_lists(DOOR).items()}
PARTS = paper.parts()
MISPRINTS = paper.misprints()
CLAIMS = {
    f"{part}: {name}": claim
    for part, derivation in PARTS.items()
    for name, claim in derivation.steps.items()
}
SYMBOLIC = {  # chains are tried on models by themselves
    name: claim for name, claim in CLAIMS.items() if getattr(claim, "algebra", None)
}

# -- proved -------------------------------------------------------------------------


@pytest.mark.parametrize("name", PARTS)
def test_proved(name):
    assert PARTS[name].steps
    assert PARTS[name].unproved() == []
    assert PARTS[name].source


def test_the_entry_point_holds_every_step_of_its_parts():
    whole = paper.derive()
    assert len(whole.steps) == sum(len(part.steps) for part in PARTS.values())
    assert set(map(id, whole.steps.values())) >= set(map(id, CLAIMS.values()))
    assert whole.source


def test_every_numbered_equation_has_an_entry():
    whole = paper.derive()
    found = set()
    pages = [item for part in PARTS.values() for item in part.page]
    shown = [item.name for item in pages if isinstance(item, Relation)]
    for key in (*whole.formulas, *whole.steps, *shown):
        head = re.match(r"(?:\([\d., ]+'?\)'?[,-]?)*", key).group()
        found |= set(re.findall(r"\d\.\d+", head))
    wanted = [f"3.{k}" for k in range(1, 28)] + [f"4.{k}" for k in range(1, 17)]
    assert [number for number in wanted if number not in found] == []


def test_formulas_have_latex():
    for name, formula in paper.derive().formulas.items():
        assert sp.latex(formula), name


@pytest.mark.parametrize("place", MISPRINTS)
def test_errata_are_tried(place):
    printed, ours = MISPRINTS[place]
    assert not vanishes(printed) and vanishes(ours)


def test_errata_cover_the_page():
    places = " ".join(MISPRINTS)
    for number in ("R~", "3.14", "3.15", "3.16", "4.7", "4.8", "4.9", "4.11", "4.13",
                   "4.14", "4.15", "4.16", "lemma 4.1", "3.20"):  # fmt: skip
        assert number in places


# -- stage lists --------------------------------------------------------------------


@pytest.mark.parametrize("name", LISTS)
def test_stages_use_only_what_is_known(name):
    known = set(LISTS[name].given)
    assert len({s.name for s in known}) == len(known)
    for stage in LISTS[name].stages:
        parts = stage.formula
        parts = (parts.N, parts.M) if isinstance(parts, Solve) else (parts,)
        assert set().union(*(symbols(part) for part in parts)) <= known
        assert stage.target.shape == tuple(stage.formula.shape)
        known.add(stage.target)
    assert set(LISTS[name].given) <= set().union(
        *(part_symbols(stage.formula) for stage in LISTS[name].stages)
    )


def part_symbols(formula):
    if isinstance(formula, Solve):
        return symbols(formula.N) | symbols(formula.M)
    return symbols(formula)


# -- numbers ------------------------------------------------------------------------


def numbers_for(claim):
    """Values that satisfy the relations of a claim, from the first world that does."""
    for make in WORLDS:
        sizes, values = make(np.random.default_rng(5))
        symmetric = claim.algebra.symmetric
        given = Numbers(sizes, 7, symmetric, claim.relations, values=values)
        try:
            if all(close(given, *relation) for relation in claim.relations):
                return given
        except RecursionError:
            continue
    raise AssertionError("no world satisfies the relations")


@pytest.mark.parametrize("name", SYMBOLIC)
def test_numbers_agree(name):
    claim = SYMBOLIC[name]
    given = numbers_for(claim)
    left = given.value(expr(claim.left))
    right = 0 if isinstance(claim.right, int) else given.value(expr(claim.right))
    scale = 1 + np.abs(left).max(initial=0)
    np.testing.assert_allclose(left, right + 0 * left, atol=1e-7 * scale)


# -- damage -------------------------------------------------------------------------

# Claims that something is zero, where a factor may be doubled at no loss.
ZERO = re.compile(r"vanishes|stationary:|holds if|without feedthrough: J|with feedthr")


def noticed(claim, broken):
    """Whether the claim fails, or cannot be written, with another left side."""
    try:
        return not dataclasses.replace(claim, left=broken).is_zero
    except (ValueError, TypeError):  # ShapeError, ours or SymPy's
        return True


def zero_term(claim, term):
    return claim.algebra.normal(term).is_zero


@pytest.mark.parametrize("name", SYMBOLIC)
def test_damage_is_noticed(name):
    claim = SYMBOLIC[name]
    left = expr(claim.left)
    tried = {"sign": [], "twice": [], "transposed": []}
    for what, broken in damages(left, most=4):
        tried[what.split()[0]].append(broken)
    if "tau^2 = tau" not in name:  # as true of tau'
        assert any(noticed(claim, broken) for broken in tried["transposed"])
    if ZERO.search(name):
        return
    assert any(noticed(claim, broken) for broken in tried["twice"])
    for broken in tried["sign"]:
        assert noticed(claim, broken) or zero_term(claim, left - broken)
