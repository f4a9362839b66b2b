"""Matrix algebra that proves: normal forms of non-commutative polynomials.

An expression in matrix symbols is written as a sum of words (products of symbols,
transposes, inverses) with coefficients; traces likewise, with words taken up to
cyclic shift and transposition.  Relations such as ``P T = I - V C`` rewrite words,
so that a claim is proved when the difference of its sides has no words left.
SymPy goes in and comes out; sizes are symbols, and a product whose sizes are not
provably equal is refused, which SymPy does not do.

`prove` proves an equation from others, `refute` finds matrices that deny it, and
`model` matrices that satisfy relations.

Source: our own.  SymPy 1.14 alone differentiates a sum of traces to zero (#26561),
collapses partitioned matrices wrongly (#22034) and cannot reduce modulo relations.
"""

from .blocks import Blocks
from .claims import Claim, claims
from .completion import Limit
from .core import Algebra
from .models import NoModel, evaluate, model, refute
from .polynomials import Polynomial, Traces
from .proofs import Proof, Unproved, prove
from .relations import Relation
from .words import Letter, ShapeError

__all__ = [
    "Algebra",
    "Blocks",
    "Claim",
    "Letter",
    "Limit",
    "NoModel",
    "Polynomial",
    "Proof",
    "Relation",
    "ShapeError",
    "Traces",
    "Unproved",
    "claims",
    "evaluate",
    "model",
    "prove",
    "refute",
]
