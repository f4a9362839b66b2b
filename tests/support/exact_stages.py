"""Stage lists in exact arithmetic, inverses and all."""

import sympy as sp

from luenberger.kernels.step import assemble
from luenberger.kernels.text import numpy_source
from matrixproof import Solve

SIZES = dict(n=4, p=2, m=2, r=3)
SYMMETRIC = ("Q", "R", "Sigma", "M", "Omega", "dOmega", "dSigma_0", "Lambda", "X")


def number(size):
    """A symbolic size as an int."""
    size = sp.sympify(size)
    return int(size.subs({s: SIZES[s.name] for s in size.free_symbols}))


def exact_inputs(derivation, rng):
    """Rational matrices for what a stage list is given; covariances definite."""
    values = {}
    for symbol in derivation.given:
        shape = [number(size) for size in symbol.shape]
        value = sp.Matrix(*shape, lambda i, j: sp.Rational(int(rng.integers(-9, 9)), 7))
        if symbol.name in SYMMETRIC:
            value = value * value.T + sp.eye(shape[0])
        values[symbol.name] = value
    if {"J", "S"} <= set(values):  # S = J R, or Q - J S' is no covariance
        values["S"] = values["J"] * sp.diag(2, 3)
    return values


def exact_step(derivation, values):
    """The stages in exact arithmetic, inverses and all."""
    known = dict(values)
    for stage in derivation.stages:
        known[stage.target.name] = evaluate(stage.formula, known)
    return {stage.target.name: known[stage.target.name] for stage in derivation.stages}


def evaluate(e, known):
    if isinstance(e, Solve):
        return evaluate(e.N, known) * evaluate(e.M, known).inv()
    if isinstance(e, sp.MatrixSymbol):
        return known[e.name]
    if isinstance(e, sp.Identity):
        return sp.eye(number(e.shape[0]))
    if isinstance(e, sp.Transpose):
        return evaluate(e.arg, known).T
    parts = [evaluate(a, known) if a.is_Matrix else a for a in e.args]
    total = parts[0]
    for part in parts[1:]:
        total = total + part if e.is_MatAdd else total * part
    return total


def kernel(derivation, *outputs, flat=False):
    """A derivation as a function of arrays."""
    given, text = numpy_source(derivation, outputs, flat)
    return assemble(text, given)
