"""The gain of least error trace, step by step: the paper's section III, entire.

Coordinates in which the accurate outputs are states (`coordinates`), the quadratic
in the gain and its minimum there (`canonical_gain`, `uniqueness`), the coordinates
that are best for the user's error (`best_coordinates`), and the recursions that run
(`stages`).  This module collects them; each part is a `Derivation` of its own.

Source: Leondes and Novak (1974), section III, (16)-(36).
"""

import re
from functools import cache

from ....symbolic import Derivation
from . import best_coordinates, canonical_gain, coordinates, errata, uniqueness
from .stages import estimate_step, gain_step, steady_gradient, step_differential

NUMBERED = re.compile(r"\(\d")


def parts():
    """The parts by name, in page order."""
    return {
        "coordinates": coordinates.derive(),
        "canonical gain": canonical_gain.derive(),
        "uniqueness": uniqueness.derive(),
        "best coordinates": best_coordinates.derive(),
        "one step": gain_step(),
        "estimate": estimate_step(),
        "differential": step_differential(),
        "steady gain": steady_gradient(),
    }


def misprints():
    """List of (place, printed, why the algebra rejects it) for the paper."""
    return errata.misprints()


@cache
def derive():
    formulas, steps = {}, {}
    for name, part in parts().items():
        label = "" if name in ("coordinates", "canonical gain") else f"{name}: "
        for key, formula in part.formulas.items():
            formulas[key if NUMBERED.match(key) else label + key] = formula
        for key, step in part.steps.items():
            steps[label + key if key in steps or not NUMBERED.match(key) else key] = (
                step
            )
    return Derivation(
        given=gain_step().given,
        stages=gain_step().stages,
        formulas=formulas,
        steps=steps,
        source="Leondes and Novak (1974), section III",
    )
