"""Fit what a plant does not say of its noise, in the widest form that is determined."""

from __future__ import annotations

from typing import Any

import numpy as np

from ..plant import Plant
from ..run.executor import Progress
from . import records as recorded
from .fit import fit_noise
from .identifiability import identifiability
from .noise_fit import NoiseFit

FORMS = (("full", "full"), ("diagonal", "full"), ("diagonal", "diagonal"))


def lacking(plant: Plant) -> list[str]:
    """Which of Q and R the plant does not give."""
    return [name for name in "QR" if getattr(plant, name) is None]


def fit_missing(
    plant: Plant, y: Any, u: Any = None, progress: Progress = False
) -> tuple[NoiseFit, list[str]]:
    """Fit Q and R where the plant has none, and say what was fitted, in sentences.

    Every entry is sought if a record can determine that, else the diagonal.

    Parameters
    ----------
    plant : Plant
    y, u, progress
        As in `fit_noise`.

    Raises
    ------
    DesignError
        As in `fit_noise`; also if not even diagonals can be determined.
    """
    missing = lacking(plant)
    seen = np.concatenate([~np.isnan(one) for one, _ in recorded.read(plant, y, u)])
    tried: list[dict[str, Any]] = []
    why: tuple[str, ...] = ()
    for Q, R in FORMS:
        forms: dict[str, Any] = {
            "Q": Q if "Q" in missing else None,
            "R": R if "R" in missing else None,
        }
        if forms in tried:
            continue
        tried.append(forms)
        told = identifiability(plant, **forms, seen=seen)
        if not told.sentences:
            break
        why = why or told.sentences
    else:
        told.require()
    fit = fit_noise(plant, y, u, **forms, progress=progress)
    return fit, _said(missing, forms, tried[0], why)


def _said(
    missing: list[str], forms: dict[str, Any], first: dict[str, Any], why: Any
) -> list[str]:
    verb = "was" if len(missing) == 1 else "were"
    said = [
        f"{' and '.join(missing)} {verb} missing and {verb} fitted to the record by "
        "maximum likelihood."
    ]
    narrow = [name for name in missing if forms[name] != first[name]]
    if narrow:
        said.append(
            f"{' and '.join(narrow)} was sought as a diagonal matrix, because no "
            f"record of this plant determines {why[0]}"
        )
    return said
