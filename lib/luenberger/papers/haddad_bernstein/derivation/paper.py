"""The optimal projection equations: Haddad and Bernstein's paper, entire.

The augmented system and the gradients of its Lagrangian (`augmented`), the way from
there to the projection and its equations (`stationarity`, `remarks`), full
order and the Kalman filter (`full_order`), mean-square stability (`mean_square`).
Our own: multiplicative noise needs no more than an equivalent plant
(`equivalent_plant`), the equations with (3.17) as printed are equivalent to
stationarity (`converse`) and weaker readings are not
(`counterexamples`), and when the estimator is stable
(`stability`); H2 model reduction is a case of it (`model_reduction`).  The
stage lists that run are in `moment_stages` and `theorem_stages`.  This
module collects them; each part is a `Derivation`.

Source: Haddad and Bernstein (1987), Systems and Control Letters 8, 381-388.
"""

from functools import cache

from ....stage_list import stage_lists
from ....symbolic import Derivation
from . import (
    augmented,
    converse,
    counterexamples,
    equivalent_plant,
    errata,
    full_order,
    mean_square,
    model_reduction,
    projection_gains,
    remarks,
    stability,
    stationarity,
)


def sections():
    """The parts that follow the paper or add to it, in page order."""
    return {
        "augmented system": augmented.derive(),
        "mean-square stability": mean_square.derive(),
        "projection": stationarity.derive(),
        "remarks": remarks.derive(),
        "full order": full_order.derive(),
        "equivalent plant": equivalent_plant.derive(),
        "converse": converse.derive(),
        "counterexamples": counterexamples.derive(),
        "stability": stability.derive(),
        "model reduction": model_reduction.derive(),
    }


def parts():
    """All parts by name, the stage lists last."""
    lists = stage_lists(__package__).items()
    return sections() | {name: stages() for name, stages in lists}


def misprints():
    """{place and what is printed: (printed claim, correct claim)}."""
    return errata.entries()


@cache
def derive():
    formulas, steps = {}, {}
    for name, part in parts().items():
        formulas |= {
            k if k[0] == "(" else f"{name}: {k}": f for k, f in part.formulas.items()
        }
        for key, step in part.steps.items():
            new = key[0] == "(" and key not in steps
            steps[key if new else f"{name}: {key}"] = step
    gains = projection_gains()
    return Derivation(
        given=gains.given,
        stages=gains.stages,
        formulas=formulas,
        steps=steps,
        source="Haddad and Bernstein (1987)",
    )
