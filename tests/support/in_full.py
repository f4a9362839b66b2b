"""A record as `Filter` takes it, with covariances and gains."""

import numpy as np

import luenberger as lb


def in_full(plant, y, u=None, u0=None, m1=0, weight=None):
    """x, std, P and K of each row."""
    record = lb.Record(np.array(y, dtype=float), u, u0=u0)
    return lb.Filter(plant, m1, weight).run(record)
