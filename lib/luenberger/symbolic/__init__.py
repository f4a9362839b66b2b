"""Matrix algebra that proves: normal forms of non-commutative polynomials.

An expression in matrix symbols is written as a sum of words (products of symbols,
transposes, inverses) with coefficients; traces likewise, with words taken up to
cyclic shift and transposition.  Relations such as ``P T = I - V C`` rewrite words,
so that a claim is proved when the difference of its sides has no words left.
SymPy goes in and comes out; sizes are symbols, and a product whose sizes are not
provably equal is refused, which SymPy does not do.

`prove` proves an equation from others, `refute` finds matrices that deny it, and
`model` matrices that satisfy relations.  A `Chain` is a derivation that reads: every
line is checked against exactly the reasons it cites.

Source: our own.  SymPy 1.14 alone differentiates a sum of traces to zero (#26561),
collapses partitioned matrices wrongly (#22034) and cannot reduce modulo relations.
"""

from .blocks import Blocks
from .chains import Chain
from .claims import Claim, claims
from .completion import Limit
from .constructions import Construction, Counterexample
from .core import Algebra
from .equivalences import Equation, Iff, Implies
from .lines import AtLeast, AtMost, Cases, Cyclic, Line, Substitute
from .models import NoModel, evaluate, model, refute
from .operators import Differential, Expect, Gradient, Transposed
from .polynomials import Polynomial, Traces
from .proofs import Proof, Unproved, prove
from .relations import Relation
from .symbols import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix
from .typeset import latex, text
from .words import Letter, ShapeError

__all__ = [
    "Algebra",
    "AtLeast",
    "AtMost",
    "BlockMatrix",
    "Blocks",
    "Cases",
    "Chain",
    "Claim",
    "Construction",
    "Counterexample",
    "Cyclic",
    "Differential",
    "Equation",
    "Expect",
    "Gradient",
    "Identity",
    "Iff",
    "Implies",
    "Letter",
    "Limit",
    "Line",
    "MatrixSymbol",
    "NoModel",
    "Polynomial",
    "Proof",
    "Relation",
    "ShapeError",
    "Substitute",
    "Traces",
    "Transposed",
    "Unproved",
    "ZeroMatrix",
    "claims",
    "evaluate",
    "latex",
    "model",
    "prove",
    "refute",
    "text",
]
