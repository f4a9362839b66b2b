"""The stage lists of compiled loops, exported C and factors notice damage."""

import dataclasses

import pytest
from sympy.matrices.expressions import MatAdd

from luenberger.papers.leondes_novak.derivation import on_target, one_pass, square_root
from luenberger.symbolic import ShapeError, Solve

PROOFS = {
    "filter_step": one_pass._same_step,
    "padded": one_pass._same_with_fewer_outputs,
    "observer_step": one_pass._error_is_free,
    "predict": on_target._is_the_error_ahead,
    "update": on_target._is_the_filter,
    "arrived": on_target._is_padded,
    "root_gain": square_root._is_the_gain,
    "root_update": square_root._is_the_covariance,
    "root_error": square_root._is_the_error,
    "root_decorrelation": square_root._is_the_noise,
}
FACTORS = {"kept", "drawn", "moved", "shown"}
HOMES = one_pass, on_target, square_root
FOUND = {
    name: next(getattr(home, name) for home in HOMES if hasattr(home, name))()
    for name in PROOFS
}


@pytest.mark.parametrize("name", FOUND)
def test_proved(name):
    assert FOUND[name].proved()


def damaged():
    """Every stage with the sign of one of its terms turned."""
    for name, derivation in FOUND.items():
        for i, stage in enumerate(derivation.stages):
            solve = isinstance(stage.formula, Solve)
            whole = stage.formula.N if solve else stage.formula
            terms = list(MatAdd.make_args(whole))
            for k in range(len(terms)):
                # a factor of a covariance may have either sign, but no other size
                turned = 2 if stage.target.name in FACTORS else -1
                wrong = sum(
                    (t for j, t in enumerate(terms) if j != k), turned * terms[k]
                )
                wrong = Solve(wrong, stage.formula.M) if solve else wrong
                label = f"{name}-{stage.target.name}-{k}"
                yield pytest.param(name, i, wrong, id=label)


@pytest.mark.parametrize("name, index, formula", list(damaged()))
def test_one_wrong_sign_in_a_stage_is_noticed(name, index, formula):
    sound = FOUND[name]
    stages = list(sound.stages)
    stages[index] = dataclasses.replace(stages[index], formula=formula)
    broken = dataclasses.replace(sound, stages=tuple(stages))
    try:
        steps = PROOFS[name](broken)
    except ShapeError:
        return
    assert dataclasses.replace(broken, steps=steps).unproved()
