"""The optimal projection equations: Haddad and Bernstein's paper, entire.

The augmented system and the gradients of its Lagrangian (`augmented`), the way from
there to the projection and its equations (`projection`, `projection_remarks`), full
order and the Kalman filter (`full_order`), mean-square stability (`mean_square`).
Our own: multiplicative noise needs no more than an equivalent plant
(`equivalent_plant`), the equations with (3.17) as printed are equivalent to
stationarity (`projection_converse`) and weaker readings are not
(`projection_counterexamples`), and when the estimator is stable
(`projection_stability`).  The stage lists that run are in `projection_recursions` and
`projection_equations`.  This module collects them; each part is a `Derivation`.

Source: Haddad and Bernstein (1987), Systems and Control Letters 8, 381-388.
"""

from functools import cache

from . import Derivation, projection_equations, projection_recursions

STAGE_LISTS = {
    name: getattr(module, name)
    for module, names in (
        (
            projection_recursions,
            "equivalent_noise output_moments estimator_moments adjoint_moments "
            "projection_cost projection_gradient best_output "
            "best_output_differential projection_differential",
        ),
        (
            projection_equations,
            "projection_innovation projection_factors feedthrough_gain "
            "projection_gains projection_scripts projection_equations "
            "projection_trace innovations_plant",
        ),
    )
    for name in names.split()
}


def sections():
    """The parts that follow the paper or add to it, in page order."""
    # imported here, because kernels need the stage lists only
    from . import (
        augmented,
        equivalent_plant,
        full_order,
        mean_square,
        projection,
        projection_converse,
        projection_counterexamples,
        projection_remarks,
        projection_stability,
    )

    return {
        "augmented system": augmented.derive(),
        "mean-square stability": mean_square.derive(),
        "projection": projection.derive(),
        "remarks": projection_remarks.derive(),
        "full order": full_order.derive(),
        "equivalent plant": equivalent_plant.derive(),
        "converse": projection_converse.derive(),
        "counterexamples": projection_counterexamples.derive(),
        "stability": projection_stability.derive(),
    }


def parts():
    """All parts by name, the stage lists last."""
    return sections() | {name: make() for name, make in STAGE_LISTS.items()}


def misprints():
    """{place and what is printed: (printed claim, correct claim)}."""
    from . import projection_errata

    return projection_errata.entries()


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
    gains = STAGE_LISTS["projection_gains"]()
    return Derivation(
        given=gains.given,
        stages=gains.stages,
        formulas=formulas,
        steps=steps,
        source="Haddad and Bernstein (1987)",
    )
