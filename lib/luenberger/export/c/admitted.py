"""Which plants a device can filter, in the numbers that it has."""

import dataclasses
from typing import Any

import numpy as np

from ...errors import DesignError
from ...kernels.c.numbers import representable
from ...plant import Plant
from ...recursion.settings import Settings, require_start


def settings_of(plant: Plant, m1: Any, weight: Any, real: str) -> Settings:
    """What the filter needs, in the numbers that the device has; or a refusal."""
    if plant.steps is not None:
        raise DesignError(
            "the plant varies with time, and a device has no room for its matrices at "
            "every instant; give a constant plant"
        )
    if plant.p == 0:
        raise DesignError("the plant has no outputs, so there is nothing to filter")
    if isinstance(weight, str):
        raise DesignError(
            "weight='canonical' depends on which outputs arrive; give the matrix"
        )
    narrow: dict[str, Any] = {
        k: representable(k, getattr(plant, k), real) for k in "ABCE"
    }
    settings = Settings(dataclasses.replace(plant, **narrow), m1, weight)
    require_start(plant)
    blind = settings.at(0).blind
    if blind.size:
        part = np.abs(blind).max(axis=1) > 1e-9
        which = [plant.output_names[k] for k in np.flatnonzero(part)]
        raise DesignError(
            f"the outputs {which} carry no noise, alone or combined, and what is then "
            "known exactly is a decision about rank that a device cannot take safely. "
            "Give them noise in R, or export reduced_order_filter(plant, m1), whose "
            "gain is constant."
        )
    return settings
