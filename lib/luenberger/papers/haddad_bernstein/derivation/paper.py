"""The optimal projection equations: Haddad and Bernstein's paper, entire.

The plant and an estimator as one system (`augmented`), the cost (`cost`) and its
gradients (`gradients`, `sensitivity`), the way from there to the projection
(`stationarity`, `projection`) and to its equations (`equations`, `remarks`), full
order and the Kalman filter (`full_order`), mean-square stability (`mean_square`).
Our own: the equations with (3.17) as printed are equivalent to stationarity
(`converse`) and weaker readings are not (`counterexamples`), and when the estimator is
stable (`stability`); H2 model reduction is a case of it (`model_reduction`).  This
module collects them; each part is a `Derivation`.

Source: Haddad and Bernstein (1987), Systems and Control Letters 8, 381-388.
"""

from functools import cache

from ....stage_list import stage_lists
from ....symbolic import Derivation
from . import (
    augmented,
    converse,
    cost,
    counterexamples,
    equations,
    errata,
    full_order,
    gradients,
    mean_square,
    model_reduction,
    projection,
    projection_gains,
    remarks,
    sensitivity,
    stability,
    stationarity,
)


def sections():
    """The parts that follow the paper or add to it, in page order."""
    return {
        "augmented system": augmented.derive(),
        "cost": cost.derive(),
        "gradients": gradients.derive(),
        "mean-square stability": mean_square.derive(),
        "stationarity": stationarity.derive(),
        "projection": projection.derive(),
        "equations": equations.derive(),
        "remarks": remarks.derive(),
        "full order": full_order.derive(),
        "sensitivity": sensitivity.derive(),
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
