"""Stage lists of a test's own, in which every stage is a definition."""

from dataclasses import replace
from types import SimpleNamespace

from matrixproof import Derivation, Relation


def own(given, *stages, symmetric=()):
    """A derivation of stages that each cite the definition of their target."""
    defined = [
        replace(s, by=(Relation(f"{s.target}", s.target, s.expression),))
        for s in stages
    ]
    letters = SimpleNamespace(symmetric=tuple(symmetric))
    return Derivation(tuple(given), tuple(defined), letters=letters)
