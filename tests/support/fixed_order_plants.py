"""Plants for the tests of the fixed-order filter."""

from dataclasses import replace

import generators
import numpy as np

import luenberger as lb
from luenberger.analysis.mean_square import largest_scaling

STABLE = dict(A=[[0.5, 0.1], [0, -0.4]], C=[[1, 0]], Q=np.eye(2), R=[[1]])


def made(A, C, **options):
    return lb.Plant(A, None, C, dt=1.0, **options)


def noisy(seed, n, p, *, m=0, noises=1, radius=0.9, **options):
    """A random plant with multiplicative noise at half of what it may be."""
    rng = np.random.default_rng(seed)
    plant = generators.plant(rng, n, p, m=m, radius=radius, **options)
    pairs = [(rng.normal(size=(n, n)), rng.normal(size=(p, n))) for _ in range(noises)]
    most = min(largest_scaling(plant.A, pairs), 1e3)
    pairs = [(0.5 * most * A1, 0.3 * C1) for A1, C1 in pairs]
    return replace(plant, multiplicative=pairs)
