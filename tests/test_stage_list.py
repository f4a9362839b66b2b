"""Each stage list has one name in its paper's front door and computes what it says."""

from importlib import import_module
from inspect import signature
from pkgutil import walk_packages

import pytest

from luenberger import export, forms, identification, kernels, papers
from luenberger.papers.leondes_novak.derivation import gain_step
from luenberger.stage_list import stage_lists
from matrixproof import Derivation

MODULES = [
    one.name
    for room in (papers, identification, forms, export)
    for one in walk_packages(room.__path__, f"{room.__name__}.")
    if ".derivation." in one.name
]
DOORS = sorted({name.rpartition(".")[0] for name in MODULES})
FOUND = {
    f"{door.split('.')[-2]}.{name}": one
    for door in DOORS
    for name, one in stage_lists(door).items()
}


def written():
    """Where the derivations have or return stages, as "package.module.name"."""
    for module in map(import_module, MODULES):
        for name, function in vars(module).items():
            page = getattr(module, "page", Derivation()).page
            if type(function) is Derivation and any(function is x for x in page):
                yield f"{module.__name__}.{name}"
            ours = getattr(function, "__module__", "") == module.__name__
            if not (ours and hasattr(function, "cache_clear")):
                continue
            if name[0] == "_" or signature(function).parameters:
                continue
            made = function()
            if isinstance(made, Derivation) and made.stages:
                yield f"{module.__name__}.{name}"


def test_every_stage_list_has_one_name():
    named = [f"{one.package}.{one.where}" for one in FOUND.values()]
    assert len(named) == len(set(named)) > 40
    assert set(named) == set(written())


def test_two_stage_lists_of_one_name_are_refused(tmp_path, monkeypatch):
    lines = [
        "from luenberger.stage_list import StageList",
        'step = StageList(__name__, "one.step")',
        'other = StageList(__name__, "one.other")',
        'step = StageList(__name__, "two.step")',
    ]
    (tmp_path / "front_door.py").write_text("\n".join(lines))
    monkeypatch.syspath_prepend(tmp_path)
    with pytest.raises(ValueError, match="line 4 of front_door .* the name 'step'"):
        stage_lists("front_door")


@pytest.mark.parametrize("stages", FOUND.values(), ids=FOUND)
def test_a_stage_list_computes_what_it_says(stages):
    derivation = stages()
    targets = [stage.target.name for stage in derivation.stages]
    step = kernels.compiled(stages)
    assert list(step.given) == [symbol.name for symbol in derivation.given]
    returned = ", ".join(f"{name}={name}" for name in targets)
    assert step.source.endswith(f"return dict({returned})\n")


def test_what_a_stage_list_does_not_compute_is_refused():
    with pytest.raises(KeyError, match=r"no stage assigns \['Psi'\]"):
        kernels.compiled(gain_step, "M", "Psi")


@pytest.mark.parametrize("door", DOORS)
def test_a_name_in_a_front_door_is_not_that_of_a_module(door):
    """Python would put the module there as soon as it is imported."""
    modules = {name.rpartition(".")[2] for name in MODULES if name.startswith(door)}
    assert modules.isdisjoint(stage_lists(door))
