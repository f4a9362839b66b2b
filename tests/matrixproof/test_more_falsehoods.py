"""Falsehoods thought of beside the checker's own text, each beside a true statement.

Each has the words of what is false.  A false statement is not taken, or is refused by
an exception; the true one beside it is taken.
"""

import dataclasses
import re
from types import SimpleNamespace

import numpy as np
import pytest
import sympy as sp
from sympy import Determinant, Matrix, Rational, Symbol, Trace, symbols

from matrixproof import (
    BlockMatrix,
    Chain,
    Derivation,
    Explicit,
    Identity,
    Line,
    MatrixSymbol,
    Notation,
    Relation,
    ZeroMatrix,
    prove,
    refute,
)
from matrixproof.checker import complaints
from matrixproof.explicit import Claim, Construction, Counterexample
from matrixproof.lines import (
    AtLeast,
    AtMost,
    Equation,
    Implies,
    cited_latex,
    cited_text,
)
from matrixproof.models import evaluate
from matrixproof.operators import Differential, Gradient
from matrixproof.proofs import Unproved
from matrixproof.relations import Moment
from matrixproof.statements import Statement
from matrixproof.symbols import Own
from matrixproof.words import ShapeError

n, m = symbols("n m", integer=True, positive=True)
A, B, C, Q, X, Y = (MatrixSymbol(name, n, n) for name in "ABCQXY")
F, w, v = MatrixSymbol("F", n, m), MatrixSymbol("w", n, 1), MatrixSymbol("v", n, 1)
G = MatrixSymbol("G", m, n)
I, O = Identity(n), ZeroMatrix(n, n)
t, p, q = Symbol("t"), Symbol("p", positive=True), Symbol("q", positive=True)
whole, one, two = Symbol("k", integer=True), sp.Integer(1), sp.Integer(2)


def holds(step):
    return step.check() == []


def proved(*sides, **more):
    return prove(*sides, **more).check()


def follows(line, left, symmetric=()):
    return line.complaints(left, symmetric) == []


def of(name, rows, cols):
    return MatrixSymbol(name, rows, cols)


def explicit(left, right, **values):
    return holds(Explicit("", "", left, right, {"": values.get("at", {})}))


def letters(symmetric=""):
    found = Notation()
    for name in "ABCQXY":
        found(name, n, n, f"what {name} is", symmetric=name in symmetric)
    return found


def page(notation, *items):
    return Derivation(page=("words", *items), letters=notation)


def chain(left, *lines, symmetric=(), number=""):
    return Chain(number, "a chain", left, lines, symmetric)


LIE, TRUTH = chain(A * B, Line(B * A)), chain(A * (B + C), Line(A * B + A * C))
SUM = prove(A * (B + C), A * B + A * C)
MEAN = Moment("E[w w'] = Q", w * w.T, Q)
INVERSE, DOUBLE = Relation("A Y = I", A * Y, I), Relation("A Y = 2 I", A * Y, 2 * I)


def left_over(expr):
    with pytest.raises(Unproved) as found:
        prove(expr, 0)
    return found.value.left_over.as_expr()


def shown_after(values, change):
    """Whether a statement that was checked shows numbers that were not."""
    statement = Explicit("", "", Trace(A), 3, {"": values})
    assert statement.check() == []
    change(values)
    return "7" in str(statement)


def inverted_beside(square, end):
    left = A * A * B + A.I * A * C
    return holds(chain(left, Line(A * A * B + C), Line(end, by=[square])))


def rests_on_two_pages(second):
    notation = letters()
    first = notation.chain("1", "first", B * A * Y, Line(B, by=[INVERSE]))
    last = notation.chain(
        "2",
        "second",
        B,
        Line(B * A * Y, by=[first]),
        Line(B * second.right, by=[second]),
    )
    return holds(page(notation, INVERSE, first)) and holds(page(notation, second, last))


def uses_symmetry(symmetric):
    notation = letters(symmetric)
    own = Chain("1", "a transpose", A.T * B, [Line(A * B)], symmetric=(A,))
    return holds(page(notation, own))


def takes_numbers(second):
    notation = letters()
    notation.scalar("t", "a number")
    return holds(
        page(
            notation,
            notation.chain("1", "one", t * (A + B), Line(t * A + t * B)),
            notation.chain("2", "two", second * (A + C), Line(second * A + second * C)),
        )
    )


class Nodding(Chain):
    check = lambda self: []  # noqa: E731


def shapes_of_F(other, limits=()):
    notation = letters()
    notation("F", n, m, "what F is")
    one = notation.chain("1", "one", F + F, Line(2 * F, why="add"))
    two = notation.chain("2", "two", other - other, Line(0 * other, why="subtract"))
    items = "words", one, two
    return holds(Derivation(page=items, letters=notation, limits=limits))


def reasons(name, factor):
    """What is printed of a relation too wide to be cited as a formula."""
    left, right = A * B * C * Q * X * Y, factor * Y * X * Q * C * B * A
    wide = Relation(name, left + left.T, right + right.T)
    return cited_text(wide) + cited_latex(wide)


class Symmetric(MatrixSymbol):
    T = property(lambda self: self)


FALSE = {
    # sizes
    "there is an n with 2 n = 3": (
        lambda: explicit(2 * n, 3, at={of("F", 2 * n, 1): Matrix([1, 2, 3])}),
        lambda: explicit(2 * n, 4, at={of("F", 2 * n, 1): Matrix([1, 2, 3, 4])}),
    ),
    "2 n = 3 denies F = 2 F": (
        lambda: holds(
            Counterexample(
                "", "", of("F", 2 * n, 1), 0, {of("F", 2 * n, 1): Matrix([1, 2, 3])}
            )
        ),
        lambda: holds(
            Counterexample(
                "", "", of("F", 2 * n, 1), 0, {of("F", 2 * n, 1): Matrix([1, 2])}
            )
        ),
    ),
    "a positive size is 0": (
        lambda: explicit(n, sp.S.Zero, at={of("F", n, 1): sp.zeros(0, 1)}),
        lambda: explicit(2 * n, two, at={of("F", n, 1): sp.zeros(1, 1)}),
    ),
    "a matrix that is not square has a determinant": (
        lambda: proved(Determinant(F), Determinant(F)),
        lambda: proved(Determinant(A), Determinant(A)),
    ),
    # powers
    "A^(1/2) A^(1/2) is not A": (
        lambda: holds(
            Counterexample(
                "",
                "",
                A ** Rational(1, 2) * A ** Rational(1, 2),
                A,
                {A: Matrix([[4]])},
            )
        ),
        lambda: holds(Counterexample("", "", A**2, A, {A: Matrix([[4]])})),
    ),
    "the root of 4 is 1": (
        lambda: evaluate(A ** Rational(1, 2), {A: Matrix([[4]])})[0] == 1,
        lambda: evaluate(A**-2, {A: Matrix([[4]])})[0] == Rational(1, 16),
    ),
    # what is assumed of numbers
    "1 = 2, since two positive numbers have the sum 0": (
        lambda: proved(one, two, given=[(p, -q)]),
        lambda: proved(Trace(A), Trace(B), given=[(p * Trace(A), p * Trace(B))]),
    ),
    "1 = 2, since twice a whole number is 1": (
        lambda: proved(one, two, given=[(2 * whole, 1)]),
        lambda: proved(
            Trace(A), Trace(B), given=[(Trace(A), whole), (Trace(B), whole)]
        ),
    ),
    "p A = -A denies A = 0, for a positive p": (
        lambda: refute(A, O, [(p * A, -A)]) is not None,
        lambda: refute(A, O, [(t * A, -A)]) is not None,
    ),
    "the square of a complex number is not negative": (
        lambda: follows(
            AtLeast(A, root=Symbol("z", complex=True) * B),
            A + Symbol("z", complex=True) ** 2 * B * B.T,
        ),
        lambda: follows(
            AtLeast(A, root=Symbol("z", real=True) * B),
            A + Symbol("z", real=True) ** 2 * B * B.T,
        ),
    ),
    "t is divided by, and is 0": (
        lambda: proved(Trace(A) / t, Trace(A) / t, given=[(t * A, O), (A * B, I)]),
        lambda: proved(Trace(A) / t, Trace(A) / t, given=[(t * A, I), (A * B, I)]),
    ),
    "G (F G)^-1 F = I, of F that is not square": (
        lambda: proved(G * (F * G).I * F, Identity(m)),
        lambda: proved(B * (A * B).I * A, I),
    ),
    # means that are taken for equations
    "w w' = Q, since E[w w'] = Q": (
        lambda: proved(w * w.T, Q, given=[MEAN]),
        lambda: proved(w * w.T, Q, given=[(w * w.T, Q)]),
    ),
    "w w' is a matrix X with X = Q, since E[w w'] = Q": (
        lambda: holds(
            Construction("", "", {X: w * w.T}, [Relation("", X, Q)], by=[MEAN])
        ),
        lambda: holds(
            Construction(
                "",
                "",
                {X: w * w.T},
                [Relation("", X, Q)],
                by=[Relation("", w * w.T, Q)],
            )
        ),
    ),
    "v = w has E[v v'] = w w'": (
        lambda: holds(Construction("", "", {v: w}, [Moment("", v * v.T, w * w.T)])),
        lambda: holds(Construction("", "", {v: w}, [Relation("", v * v.T, w * w.T)])),
    ),
    "w w' is not E[w w']": (
        lambda: holds(
            Counterexample(
                "", "", w, 2 * w, {w: Matrix([1]), Q: Matrix([[1]])}, given=[MEAN]
            )
        ),
        lambda: holds(Counterexample("", "", w, 2 * w, {w: Matrix([1])})),
    ),
    # what exists
    "A has an inverse, and nothing is constructed": (
        lambda: holds(Construction("", "", {}, [Relation("", A * A.I, I)])),
        lambda: holds(Construction("", "", {X: A.I}, [Relation("", A * X, I)])),
    ),
    # what rests on what is false
    "A B = B A, by a false chain, in prove": (
        lambda: proved(A * B, B * A, given=[LIE]),
        lambda: proved(A * (B + C), A * B + A * C, given=[TRUTH]),
    ),
    "2 B = B, since A Y = I in one line and A Y = 2 I in the next": (
        lambda: holds(
            chain(B, Line(B * A * Y, by=[INVERSE]), Line(2 * B, by=[DOUBLE]))
        ),
        lambda: holds(
            chain(2 * B, Line(B * A * Y, by=[DOUBLE]), Line(2 * B, by=[DOUBLE]))
        ),
    ),
    "A is inverted in one line, and A A = 0 is cited in the next": (
        lambda: inverted_beside(Relation("A A = 0", A * A, O), C),
        lambda: inverted_beside(Relation("A A = A", A * A, A), A * B + C),
    ),
    "C = 2 B follows from C = B, by the same two": (
        lambda: holds(
            chain(
                Equation(C, B),
                Implies(Equation(C, B * A * Y), by=[INVERSE]),
                Implies(Equation(C, 2 * B), by=[DOUBLE]),
            )
        ),
        lambda: holds(
            chain(
                Equation(C, 2 * B),
                Implies(Equation(C, B * A * Y), by=[DOUBLE]),
                Implies(Equation(C, 2 * B), by=[DOUBLE]),
            )
        ),
    ),
    "2 B = B, by a chain of another page that supposes A Y = I": (
        lambda: rests_on_two_pages(DOUBLE),
        lambda: rests_on_two_pages(Relation("A Y = A A^-1", A * Y, A * A.I)),
    ),
    # proofs that are not of what they say
    "A (B + C) = B A": (
        lambda: dataclasses.replace(SUM, right=B * A).check(),
        lambda: dataclasses.replace(SUM, right=A * B + A * C).check(),
    ),
    "A = B, and nothing is given": (
        lambda: dataclasses.replace(prove(A, B, [(A, B)]), given=()).check(),
        lambda: prove(A, B, [(A, B)]).check(),
    ),
    "A' = A, and nothing is symmetric": (
        lambda: dataclasses.replace(prove(A.T, A, [], [A]), symmetric=()).check(),
        lambda: prove(A.T, A, [], [A]).check(),
    ),
    # letters that are not what they look like
    "a letter of an algebra is A + B": (
        lambda: proved(Own("(A + B)", n, n).I, (A + B).I),
        lambda: proved((A + B).I, (B + A).I),
    ),
    "what is left over of one proof is another inverse": (
        lambda: proved(left_over((A + t * I).I), (A + Symbol("t", real=True) * I).I),
        lambda: proved(left_over((A + t * I).I), left_over((A + t * I).I)),
    ),
    "a letter of an algebra moves with X": (
        lambda: follows(
            Gradient(2 * Own("dX", n, n), of=X), Trace(Own("dX", n, n).T * X)
        ),
        lambda: follows(Gradient(Own("dX", n, n), of=X), Trace(Own("dX", n, n).T * X)),
    ),
    "A' B = A B, of letters of a class that transposes them so": (
        lambda: proved(Symmetric("A", n, n).T * B, Symmetric("A", n, n) * B),
        lambda: proved(A.T * B, A * B, symmetric=[A]),
    ),
    "d/dX tr(A X) = 0, of SymPy's own X": (
        lambda: follows(Gradient(O, of=sp.MatrixSymbol("X", n, n)), Trace(A * X)),
        lambda: follows(Gradient(A.T, of=X), Trace(A * X)),
    ),
    "d/dX tr(A X) = 0, of X in another shape": (
        lambda: follows(Gradient(0 * F, of=of("X", n, m)), Trace(A * X)),
        lambda: follows(Gradient(0 * F, of=F), Trace(A * X)),
    ),
    "d(A X) = 0, of X in another shape": (
        lambda: follows(Differential(O, of={of("X", n, m): F}), A * X),
        lambda: follows(Differential(A * B, of={X: B}), Q + A * X),
    ),
    "a Cyrillic A is another letter than A": (
        lambda: letters()("\u0410", n, n, "another") != A,
        lambda: letters()("Omega", n, n, "another") != A,
    ),
    "a bold A is another letter than A": (
        lambda: letters()("\U0001d400", n, n, "another") != A,
        lambda: letters()("A_1", n, n, "another") != A,
    ),
    "A with a space of no width is another letter than A": (
        lambda: letters()("A\u200b", n, n, "another") != A,
        lambda: letters()("Ahat", n, n, "another") != A,
    ),
    "A B is a letter": (
        lambda: letters()("A B", n, n, "another") != A,
        lambda: letters()("AB", n, n, "another") != A,
    ),
    "t is positive in one chain of a page, and not in another": (
        lambda: takes_numbers(Symbol("t", positive=True)),
        lambda: takes_numbers(t),
    ),
    "A is symmetric on a page that does not say so": (
        lambda: uses_symmetry(""),
        lambda: uses_symmetry("A"),
    ),
    # derivatives
    "d(X X) = 2 X X": (
        lambda: follows(Differential(2 * X * X, of={X: X}), X * X),
        lambda: follows(Differential(A * X + X * A, of={X: A}), X * X),
    ),
    "X and Y move alike": (
        lambda: follows(Differential(X * A + A * Y, of={X: A, Y: A}), X * Y),
        lambda: follows(Differential(X * B + A * Y, of={X: A, Y: B}), X * Y),
    ),
    "a whole number moves": (
        lambda: follows(Gradient(2 * whole, of=whole), whole**2),
        lambda: follows(Gradient(2 * t, of=t), t**2),
    ),
    "d/dX tr(X X') = 0, since tr(X X') >= 0": (
        lambda: holds(
            chain(
                Trace(X * X.T),
                AtLeast(sp.S.Zero, root=X),
                Gradient(O, of=X),
            )
        ),
        lambda: holds(
            chain(
                Trace(A * X),
                Gradient(A.T, of=X),
                AtMost(A.T + B * B.T, root=B),
            )
        ),
    ),
    # what is on a page
    "A B = B A, says a check of one's own": (
        lambda: Derivation(steps={"": SimpleNamespace(check=lambda: [])}).proved(),
        lambda: Derivation(steps={"": TRUTH}).proved(),
    ),
    "A B = B A, says a chain of a class of one's own": (
        lambda: Derivation(steps={"": Nodding("", "", A * B, [Line(B * A)])}).proved(),
        lambda: Derivation(steps={"": chain(A * B, Line(A * B))}).proved(),
    ),
    "A (B + C) = B A, by a proof whose check is False": (
        lambda: Derivation(steps={"": dataclasses.replace(SUM, right=B * A)}).proved(),
        lambda: Derivation(steps={"": chain(SUM.left, Line(SUM.right))}).proved(),
    ),
    "F of n x m is F of n x n on the next line": (
        lambda: shapes_of_F(of("F", n, n)),
        lambda: shapes_of_F(of("F", n, n), limits=({m: n},)),
    ),
    "F of n x m is F of m x m where m is n": (
        lambda: shapes_of_F(of("F", m, m), limits=({m: n},)),
        lambda: shapes_of_F(F),
    ),
    "a relation called A = B has that for a reason, whatever it says": (
        lambda: "A = B" in reasons("(3) A = B", 2),
        lambda: "the blocks" in reasons("(3) the blocks", 2),
    ),
    # residuals and comparisons
    "a NumPy comparison that fails is a proof": (
        lambda: Derivation(steps={"A = B": np.bool_(False)}).proved(),
        lambda: Derivation(steps={"A = A": Claim(t, t)}).proved(),
    ),
    "0.0 is a proof": (
        lambda: Derivation(steps={"": 0.0}).proved(),
        lambda: Derivation(steps={"": (t + 1) ** 2 - t**2 - 2 * t - 1}).proved(),
    ),
    "a residual without entries is a proof": (
        lambda: Derivation(steps={"": sp.zeros(0, 3)}).proved(),
        lambda: Derivation(steps={"": sp.zeros(1, 3)}).proved(),
    ),
    "A A - A A is the outcome of a comparison": (
        lambda: proved(A * A - A * A, A == B),
        lambda: proved(A * A - A * A, 0),
    ),
    "t - t is one, in a claim": (
        lambda: Claim(t - t, A == B).is_zero,
        lambda: Claim(t - t, 0).is_zero,
    ),
    # what changes after it was checked
    "tr A = 3 at a value that was put in later": (
        lambda: shown_after({A: Matrix([[3]])}, lambda at: at.update({A: Matrix([7])})),
        lambda: holds(Explicit("", "", Trace(A), 7, {"": {A: Matrix([7])}})),
    ),
    "tr A = 3 at a matrix that was changed later": (
        lambda: shown_after({A: Matrix([[3]])}, lambda at: at[A].fill(7)),
        lambda: holds(Explicit("", "", Trace(A), 7, {"": {A: Matrix([7])}})),
    ),
}


@pytest.mark.parametrize("false", [pair[0] for pair in FALSE.values()], ids=FALSE)
def test_what_is_false_is_not_taken(false):
    try:
        taken = false()
    except (TypeError, ValueError, Unproved):
        return
    assert not taken


@pytest.mark.parametrize("true", [pair[1] for pair in FALSE.values()], ids=FALSE)
def test_what_is_true_beside_it_is_taken(true):
    assert true()


def test_values_are_kept_as_they_were_checked():
    """A construction and a differential do not follow the dict they were made from."""
    values, moves = {X: A.I * B}, {X: A}
    made = Construction("", "", values, [Relation("A X = B", A * X, B)])
    moved = Differential(A, of=moves)
    values[X], moves[X] = B * A, B
    assert made.check() == [] and "B A" not in str(made)
    assert moved.complaints(X, ()) == []
    with pytest.raises(TypeError):
        made.values[X] = B * A


# -- certificates that prove nothing --------------------------------------------------

a, b, f, g = (((name, False),) for name in "ABFG")
turned = {name: ((name, True),) for name in "AF"}
SIZES = {"A": (n, n), "B": (n, n), "F": (n, m), "G": (m, n)}
SQUARE, WIDE = (n, n), (n, m)


def told(left, right, given=None, lemma=None):
    lemmas = {"lemma 1": lemma} if lemma else {}
    given = {"g": given} if given else {}
    return Statement({"claim": (left, right)}, given, {}, frozenset(), SIZES, lemmas)


CERTIFICATES = {
    "a lemma about a number that may be zero": (
        told(
            (SQUARE, {b + a: 1}),
            (SQUARE, {(): t}),
            lemma=((SQUARE, {a: 1}), (SQUARE, {b: 1}), t),
        ),
        (1, (), ("exchanged", "lemma 1", False), ()),
        "t may be zero",
    ),
    "a lemma about matrices that are not square": (
        told(
            ((m, m), {g + f: 1}),
            ((m, m), {(): 1}),
            lemma=((WIDE, {f: 1}), ((m, n), {g: 1}), 1),
        ),
        (1, (), ("exchanged", "lemma 1", False), ()),
        "do not fit",
    ),
    "a square matrix as a number": (
        told((SQUARE, {a: 1}), (SQUARE, {turned["A"]: 1})),
        (1, (), ("number", (a, ()), False), ()),
        r"shapes \(1, 1\)",
    ),
    "the trace of what is not square": (
        told((None, {f: 1}), (None, {f: 1})),
        None,
        "do not fit",
    ),
    "half of a trace, transposed": (
        told((None, {a: 1}), (None, {turned["A"]: 1})),
        (1, a, ("turned", "", False), b),
        "transposed as a whole",
    ),
    "a given relation between two shapes": (
        told(
            (SQUARE, {a: 1}),
            (SQUARE, {f: 1}),
            given=((SQUARE, {a: 1}), (SQUARE, {f: 1})),
        ),
        (1, (), ("given", "g", False), ()),
        "do not fit",
    ),
}


@pytest.mark.parametrize("name", CERTIFICATES)
def test_a_certificate_is_refused(name):
    statement, term, why = CERTIFICATES[name]
    [fault] = complaints(statement, "claim", [term] if term else [])
    assert re.search(why, fault)


def test_a_given_relation_is_turned_with_its_shape():
    sides = ((m, n), {turned["F"]: 1}), ((m, n), {g: 1})
    statement = told(*sides, given=((WIDE, {f: 1}), (WIDE, {(("G", True),): 1})))
    assert complaints(statement, "claim", [(1, (), ("given", "g", True), ())]) == []


def test_blocks_whose_sizes_differ_from_row_to_column_have_no_inverse():
    crossed = BlockMatrix([[of("H", n, m), A], [of("K", m, m), of("G", m, n)]])
    with pytest.raises(ShapeError, match="no inverse of blocks"):
        prove(crossed.I * crossed, Identity(n + m))
