"""The optimal projection equations: complete, and the page's misprints are wrong."""

import inspect
import re
from functools import cache
from importlib import import_module

import pytest
from worlds import symbols

from luenberger.papers.haddad_bernstein import derivation
from luenberger.papers.haddad_bernstein.derivation import errata
from luenberger.stage_list import stage_lists
from matrixproof import Solve
from matrixproof.derivation import vanishes

LISTS = {name: make() for name, make in stage_lists(derivation.__name__).items()}
MODULES = re.findall(
    r"`(\w+)`", inspect.getdoc(derivation).partition("order: ")[2].partition(".\n")[0]
)
MISPRINTS = errata.entries()


@cache
def parts():
    loaded = [import_module(f"{derivation.__name__}.{name}") for name in MODULES]
    return [module.page for module in loaded if hasattr(module, "page")]


def test_every_numbered_equation_is_on_a_page():
    shown = [
        getattr(item, "name", "") or f"({getattr(item, 'number', '')})"
        for part in parts()
        for item in part.page
    ]
    heads = [re.match(r"\([\d., ]+'?\)", name) for name in shown]
    found = {n for head in heads if head for n in re.findall(r"\d\.\d+", head[0])}
    wanted = [f"3.{k}" for k in range(1, 28)] + [f"4.{k}" for k in range(1, 17)]
    assert len(MODULES) > 15
    assert [number for number in wanted if number not in found] == []


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
