"""The letters of Haddad and Bernstein (1987), each with its size and what it means.

Theirs, with those of the library behind them: V_1, V_2, V_12 (Q, R, S of a plant),
A_e, B_e, C_e, D_e (F, D, P, V of an observer), the weight R (`weight`), the order n_e.
What G and P stand for here has no letter there.  A plus below is the next instant.
The paper writes Q and P with hats in theorem 3.1 and in script in section 4.

Each pair (A_i, C_i) is multiplied by a white noise of unit variance.  There may be any
number of them, and a letter with the index i stands for that of each.
"""

from sympy import symbols

from matrixproof import Derivation, Identity, Notation, Stage
from matrixproof.derivation import title
from matrixproof.symbols import Over

SOURCE = "Haddad and Bernstein (1987)"

n, l, r, q = symbols("n l n_e q", integer=True, nonnegative=True)
letters = Notation()
sum_i = Over("sum_i")
I = Identity(n)


def assign(letters, relation, equation="", also=()):
    """The stage that a definition in these letters is: it assigns the left side."""
    target = relation.left
    stored = target in letters.symmetric
    by = (relation, *also)
    return Stage(target, relation.right, equation, symmetric=stored, by=by)


def listed(letters, given, stages, says, *chains, source=SOURCE):
    """A stage list, and the chains that say what its letters are good for."""
    found = {"stages": tuple(stages), "steps": {title(c): c for c in chains}}
    return Derivation(given, **found, source=source, letters=letters, says=says)


def each(family):
    """What makes a letter that of each pair; programs know it by another name."""
    return {"index": "i", "family": family}


def square(name, size, meaning):
    """A symmetric letter."""
    return letters(name, size, size, meaning, symmetric=True)
