"""Matrix algebra that proves, refutes and shows: a tool for derivations.

A *word* is a product of letters: symbols, transposes, inverses.  Multiplied out, a
matrix expression is a sum of words with coefficients, and two expressions are equal
for all matrices exactly when these sums are.  Sizes are symbols; a sum or a product
whose shapes are not provably equal is refused when it is written.

A *relation* is an equation that one may use.  An inverse brings two of its own,
X X^-1 = I and X^-1 X = I, also where X is a sum; every relation holds transposed as
well.  This is the push-through identity, for matrices of any sizes:

>>> from matrixproof import Identity, Relation, letters, prove, refute
>>> A, B = letters("A:n*m B:m*n")
>>> I, J = map(Identity, A.shape)
>>> proof = prove((I + A * B).I * A, A * (J + B * A).I)
>>> print(proof)  # doctest: +NORMALIZE_WHITESPACE
(I + A*B)**(-1)*A - (A*(I + B*A)**(-1)) =
  -1 * (I + A*B)^-1 A [(I + B*A)^-1 is an inverse, on the right]
  1 * [(I + A*B)^-1 is an inverse, on the left] A (I + B*A)^-1

A *proof* is that sum: the left side less the right side, written as terms
c u (l - r) v, each with a relation l = r in its middle.  Multiply it out, and nothing
is left; `proof.check()` does so with code of its own that knows no rewriting, and
finds matrices for which something is said: with the inverses that are written.  It is
found by rewriting words with the relations and by *completing* these: where two
overlap, a word can be rewritten in two ways, and that both are equal is a new relation.

Relations that are given have names, and a proof says which it used:

>>> M, K, N = letters("M:m*m K:n*m N:n*m")
>>> prove(K, N * M.I, [Relation("K M = N", K * M, N)]).cited
('K M = N',)

What is false is refuted by explicit matrices where the search finds some, and what
relations could never be satisfied is found out by asking for a `models.model` of them.

>>> refute(A * B, B.T * A.T) is None
False

A `Chain` is a derivation that reads: every line is checked against exactly the reasons
it cites.  `derive` finds the lines of one.  Chains, definitions and the words between
them make a `Page`; its stages are the assignments that a program is to carry out.

Two things are used that equations between words do not say: square matrices with
A B = I have B A = I, and a 1 x 1 matrix is a number.  What rests on signs, as that
A'A = 0 only if A = 0, is not used.

Source: our own; Bergman (1978) for the method, Hofstadler, Raab and Regensburger
(2019) for its use on matrices of unequal sizes.  SymPy 1.14 alone differentiates a sum
of traces to zero (#26561), collapses partitioned matrices wrongly (#22034), cancels
what has no inverse, and cannot reduce modulo relations.  It needs SymPy alone.
"""

from .chains import Chain
from .derivation import Derivation, Page
from .deriving import derive
from .explicit import Explicit
from .lines import Line
from .models import refute
from .notation import Notation, letters
from .operators import Expect
from .proofs import prove
from .relations import Relation
from .stages import Solve, Stage
from .symbols import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix
from .typeset import latex, text

__all__ = [
    "BlockMatrix",
    "Chain",
    "Derivation",
    "Expect",
    "Explicit",
    "Identity",
    "Line",
    "MatrixSymbol",
    "Notation",
    "Page",
    "Relation",
    "Solve",
    "Stage",
    "ZeroMatrix",
    "derive",
    "latex",
    "letters",
    "prove",
    "refute",
    "text",
]
