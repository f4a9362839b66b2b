"""A plant's filter as a device has it: matrices, start and programs of a sample."""

from __future__ import annotations

from collections.abc import Sequence

from ...kernels import lowered
from ...kernels.c.numbers import representable
from ...kernels.program import Factor, Guard, Program
from ...numeric import Matrices, Matrix, Vector
from ...plant import Plant
from ...recursion.settings import Settings, require_start
from ...stage_list import StageList
from . import guard

FULL = {k: k for k in ("C", "R", "E", "Gamma", "A", "B", "J", "As")} | {"Q": "Qs"}


def matrices(settings: Settings) -> Matrices:
    """The matrices of a sample with every output, by the letters of its program."""
    now = settings.at(0)
    return {k: getattr(now, field) for k, field in FULL.items()}


def narrowed(matrices: Matrices, real: str) -> Matrices:
    """The same in the numbers of a device."""
    return {k: representable(k, X, real) for k, X in matrices.items()}


def start(plant: Plant, real: str) -> tuple[Vector, Matrix]:
    """Prediction and covariance at the first sample, in the numbers of a device."""
    here = plant.at_first_sample()
    given = here.x0, require_start(here)
    x, Omega = (representable("P0", X, real) for X in given)
    return x, Omega


def correlated(plant: Plant) -> bool:
    """Whether the two noises are."""
    return plant.S is not None and bool(plant.S.any())


def tested(settings: Settings) -> bool:
    """Whether definiteness is tested at every sample."""
    now, Omega = settings.at(0), require_start(settings.plant.at_first_sample())
    return bool(settings.accurate) or guard.undriven(now.As, now.Qs, Omega)


def sample_program(
    settings: Settings,
    stages: StageList,
    given: Matrices,
    guards: Sequence[Guard] = (),
) -> Program:
    """The program of a sample with every output, as it is exported."""
    return lowered(
        stages,
        ["x", "Sigma", "x_minus_next", "Omega_next"],
        zero=vanishing(given),
        symmetric=("Q", "R", "Omega"),
        definite=[Factor("Sigma", 0.0, "Omega", True)] if tested(settings) else (),
        same=() if correlated(settings.plant) else [("As", "A")],
        guards=guards,
    )


def vanishing(given: Matrices) -> list[str]:
    """Names of the matrices that are zero."""
    return [k for k, X in given.items() if not X.any()]
