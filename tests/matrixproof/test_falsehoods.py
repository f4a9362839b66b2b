"""False and empty statements that are refused, each beside a true one that is not."""

import pytest
import sympy as sp
from sympy import Determinant, Dummy, Matrix, Rational, Symbol, Trace, sqrt, symbols

from matrixproof import (
    BlockMatrix,
    Derivation,
    Explicit,
    Identity,
    Line,
    MatrixSymbol,
    Notation,
    Relation,
    Stage,
    ZeroMatrix,
    prove,
)
from matrixproof.algebra import Algebra
from matrixproof.explicit import Claim, Counterexample, Positive
from matrixproof.lines import AtLeast, AtMost, cited_latex, cited_text, numbered, words
from matrixproof.operators import Differential, Gradient
from matrixproof.proofs import Unproved
from matrixproof.words import ShapeError

n, m, k = symbols("n m k", integer=True, positive=True)
A, B, C, X = (MatrixSymbol(name, n, n) for name in "ABCX")
I, O = Identity(n), ZeroMatrix(n, n)
t, positive_t = Symbol("t"), Symbol("t", positive=True)
c = Symbol("c")


def of(name, rows, cols):
    return MatrixSymbol(name, rows, cols)


# -- symbols that look alike ----------------------------------------------------------

one, two = Dummy("t"), Dummy("t")
G, H = (of(name, m, n) for name in "GH")
LOOK_ALIKE = {
    "assumptions": ((A + t * I).I, (A + positive_t * I).I),
    "dummies": ((A + one * I).I, (A + two * I).I),
    "integers": ((A - t * I).I, (A - Symbol("t", integer=True) * I).I),
    "scaled": ((t * A + B).I, (positive_t * A + B).I),
    "inner sizes": ((I + of("F", n, m) * G).I, (I + of("F", n, k) * of("G", k, n)).I),
    "inner sizes, turned": ((I + G.T * H).I, (I + of("G", k, n).T * of("H", k, n)).I),
    "called as a sum": (of("(A + B)", n, n).I, (A + B).I),
    "called as an inverse": (of("(A + B)^-1", n, n), (A + B).I),
    "called as the inverse of a letter": (of("A^-1", n, n), A.I),
    "called as with a shape": (
        of("A (n x n)", n, n) * of("A", n, m),
        A * of("A", n, m),
    ),
    "called as with a shape and a number": (
        of("A (n x n)", n, n) * of("A", n, m) * of("A (n x n) (2)", m, m),
        A * of("A", n, m) * of("A (n x n) (2)", m, m),
    ),
    "blocks": (
        BlockMatrix([[A, t * I], [O, B]]).I,
        BlockMatrix([[A, positive_t * I], [O, B]]).I,
    ),
    "blocks of blocks": (
        BlockMatrix([[A + t * I, O], [O, B]]).I,
        BlockMatrix([[A + one * I, O], [O, B]]).I,
    ),
    "in a trace": (Trace((A + t * I).I), Trace((A + positive_t * I).I)),
}


@pytest.mark.parametrize("sides", LOOK_ALIKE.values(), ids=LOOK_ALIKE)
def test_symbols_are_told_apart_by_what_they_are(sides):
    with pytest.raises(Unproved):
        prove(*sides)
    for side in sides:  # and each is what it is
        assert prove(side, side).check()


def test_letters_of_one_name_keep_their_meaning_in_a_true_statement():
    wide, long = of("F", n, m), of("F", m, n)
    left, right = wide * (Identity(m) + long * wide).I, (I + wide * long).I * wide
    assert prove(left, right).check()
    both = (A + t * I) * (A + t * I).I + (A + one * I) * (A + one * I).I
    assert prove(both, 2 * I).check()


def test_a_factor_that_hides_a_difference_from_small_models_proves_nothing():
    hides = t * (t - 1) * (t + 1) * (t - 2) * (t + 2) * (t - 3) * (t - 4)
    letters = Notation()
    a, s = letters("A", n, n, "a matrix"), letters.scalar("t", "a number")
    assert s == t
    wrong = letters.chain(
        "1",
        "resolvents",
        hides * (a + t * I).I,
        Line(hides * (a + positive_t * I).I),
    )
    assert "does not follow" in wrong.check()[0]
    assert any(
        "is printed for several letters" in fault
        for fault in Derivation(page=(wrong,), letters=letters).check()
    )


# -- letters of a notation ------------------------------------------------------------

TAKEN = {
    "a number twice": lambda L: L.scalar("t", "another", positive=True),
    "a matrix as a number": lambda L: L("t", n, n, "a matrix"),
    "a number as a matrix": lambda L: L.scalar("A", "a number"),
    "a matrix of another shape": lambda L: L("A", n, m, "another"),
    "printed alike": lambda L: L("Lam", n, n, "another"),
    "printed alike, with an index": lambda L: L("B1", n, n, "another"),
    "a number printed alike": lambda L: L.scalar("B1", "a number"),
}


@pytest.mark.parametrize("declare", TAKEN.values(), ids=TAKEN)
def test_a_letter_is_not_taken_twice(declare):
    letters = Notation()
    letters.scalar("t", "a number")
    for name in ("A", "Lambda", "B_1"):
        letters(name, n, n, f"what {name} is")
    with pytest.raises(ValueError, match="is taken: the .* stands for '.*'; rename"):
        declare(letters)
    declare(letters.here())  # a page of its own may


def test_a_page_may_take_a_letter_over_once():
    letters = Notation()
    letters.scalar("t", "a number")
    page = letters.here()
    page("t", n, n, "a matrix")
    with pytest.raises(ValueError, match="the n x n matrix t stands for 'a matrix'"):
        page.scalar("t", "a number")
    assert t in letters.meaning and t not in page.meaning


def test_letters_that_look_alike_are_not_compiled():
    stages = (Stage(B, of("A", n, m) * of("A", m, n)),)
    faults = Derivation((of("A", n, m), of("A", m, n)), stages).unproved()
    assert any("A is printed for several letters" in fault for fault in faults)
    square = of("A", n, m) * of("A", n, m).T
    stage = Stage(B, square, by=(Relation("B = A A'", B, square),))
    assert Derivation((of("A", n, m),), (stage,)).unproved() == []


# -- numbers that are not exact -------------------------------------------------------

NOT_EXACT = {
    "a large float": lambda: prove(1e16 * A + A, 1e16 * A),
    "a tenth": lambda: prove(sp.Float(0.1) * A, Rational(1, 10) * A),
    "a float that is whole": lambda: prove(2.0 * A, 2 * A),
    "in what is given": lambda: prove(A, 2 * B, [(A / 2, 1.0 * B)]),
    "in an inverse": lambda: prove((A + 0.5 * I).I, (A + I / 2).I),
    "in blocks": lambda: prove(BlockMatrix([[0.5 * A, O], [O, A]]), 0 * I),
    "beside a trace": lambda: prove(0.1 * Trace(A), Trace(A) / 10),
    "of numbers": lambda: Claim(0.1 + 0.2, sp.Float(0.3)).is_zero,
    "of an algebra": lambda: Algebra().normal(0.5 * A),
    "as a value": lambda: Counterexample(
        "", "", A, 2 * A, {A: Matrix([[0.1]])}
    ).check(),
    "not a number": lambda: prove(sp.nan * A, sp.nan * A),
    "infinite": lambda: prove(sp.oo * A, 2 * sp.oo * A),
    "imaginary": lambda: prove(sp.I * A, sp.I * A),
    "an imaginary letter": lambda: prove(Symbol("z", imaginary=True) * A, A),
}


@pytest.mark.parametrize("state", NOT_EXACT.values(), ids=NOT_EXACT)
def test_numbers_are_exact_and_real(state):
    with pytest.raises(TypeError, match="is a float|is not a number|is not real"):
        state()


def test_a_float_is_told_what_to_write():
    with pytest.raises(TypeError, match=r"0\.1 is a float.*; write Rational\(1, 10\)$"):
        prove(0.1 * A, A)
    with pytest.raises(TypeError, match=r"2\.0 is a float.*; write 2$"):
        prove(2.0 * A, A)
    assert prove(Rational(1, 10) * A, A / 10).check()
    [fault] = Explicit("", "", t, sp.Float(0.1), {"": {t: Rational(1, 10)}}).check()
    assert "0.1 is a float" in fault


# -- what may be zero -----------------------------------------------------------------

DIVIDED = {
    "by a size less another": lambda: prove(
        Trace(Identity(n - m)) / (n - m), sp.Integer(1)
    ),
    "by a size less one": lambda: prove(Trace(A) * (n - 1) / (n - 1) ** 2, Trace(A)),
    "by a number less a size": lambda: prove(A / (t - n), A / (t - n)),
    "in what is given": lambda: prove(A, B, [(A / (n - m), B / (n - m))]),
    "root of sizes": lambda: prove(sqrt(n - m) * A, sqrt(n - m) * A),
}


@pytest.mark.parametrize("state", DIVIDED.values(), ids=DIVIDED)
def test_nothing_is_divided_by_what_may_be_zero(state):
    with pytest.raises(ValueError, match="may be (zero|negative)"):
        state()


def test_what_is_not_zero_is_divided_by():
    assert prove(Trace(I) / n, sp.Integer(1)).check()
    assert prove(A / (n + m) * (n + m), A).check()
    assert prove(A / t * t, A).check()
    for number in (positive_t, Symbol("s", nonzero=True), n, sp.Integer(3)):
        assert prove(A, O, [(number * A, O)]).check()


# -- what nothing satisfies -----------------------------------------------------------

F = of("F", 2, 1)
VACUOUS = {
    "inverse of what squares to zero": (A * A * A.I, O, [(A * A, O)]),
    "inverse of what cubes to zero": (A.I * A, I, [(A * A * A, O)]),
    "inverse of a product with zero": (B.I * B * A, A, [(A * B, O), (A, I)]),
    "inverse of a thin product": (
        Trace(of("G", 1, 2) * (F * of("G", 1, 2)).I * F),
        sp.Integer(2),
        [],
    ),
    "inverse of a thin square": ((F * F.T).I * F * F.T, Identity(2), []),
    "inverse of a thinner product": (
        (of("F", 3, 2) * of("G", 2, 3)).I * of("F", 3, 2) * of("G", 2, 3),
        Identity(3),
        [],
    ),
    "inverse of a difference that is zero": ((A - B).I * (A - B), I, [(A, B)]),
    "inverse of what is skew and 1 x 1": (
        Trace(of("s", 1, 1).I * of("s", 1, 1)),
        sp.Integer(1),
        [(2 * of("s", 1, 1), ZeroMatrix(1, 1))],
    ),
}


@pytest.mark.parametrize("sides", VACUOUS.values(), ids=VACUOUS)
def test_what_nothing_satisfies_is_not_proved(sides):
    left, right, given = sides
    try:
        proof = prove(left, right, given)
    except ValueError:  # a contradiction that the search saw
        return
    assert proof.faults() == []
    assert not proof.check() and "no matrices" in proof.complaints()[0]


@pytest.mark.parametrize(
    "sides",
    [
        (A.I, I, [(A * A, A)]),  # a projection that has an inverse
        (A.I * A, I, [(A * A * A, A)]),
        ((of("F", n, m) * G).I * of("F", n, m) * G, I, []),
        (
            (of("F", 1, 2) * of("G", 2, 1)).I * of("F", 1, 2) * of("G", 2, 1),
            I.subs(n, 1),
        ),
    ],
)
def test_what_something_satisfies_is_proved(sides):
    assert prove(*sides).check()


# -- bounds ---------------------------------------------------------------------------

d = Symbol("d", nonnegative=True)
BOUNDS = {
    "a root of any number": AtLeast(A, root=sqrt(c) * B),
    "a root of a difference": AtLeast(A, root=sqrt(d - 1) * B),
    "a root of a product": AtLeast(A, root=sqrt(c * d) * B),
    "a root of a size less another": AtLeast(A, root=sqrt(n - m) * B),
    "a root of a trace": AtLeast(A, root=sqrt(Trace(B)) * B),
    "imaginary": AtLeast(A, root=sp.I * B),
    "imaginary in a sum": AtLeast(A, root=B + sp.I * C),
    "an imaginary letter": AtLeast(A, root=Symbol("z", imaginary=True) * B),
    "a logarithm": AtLeast(A, root=sp.log(c) * B),
    "transposed": AtLeast(A, root=(sqrt(c) * B).T),
    "upwards": AtMost(A - c * B * B.T, root=sqrt(c) * B),
}


@pytest.mark.parametrize("line", BOUNDS.values(), ids=BOUNDS)
def test_a_root_is_real(line):
    square = line.root * line.root.T
    left = line.right + square * line.side
    [fault] = line.complaints(left, ())
    assert "may not be real" in fault or "is not real" in fault
    assert "real" in str(line.gap(left, (), ()))


def test_a_root_in_blocks_is_real():
    low = BlockMatrix([[O, O], [O, O]])
    high = BlockMatrix([[c * I, O], [O, I]])
    root = BlockMatrix([[sqrt(c) * I, O], [O, I]])
    assert "may not be real" in AtLeast(low, root=root).complaints(high, ())[0]


@pytest.mark.parametrize(
    "number",
    [c, sqrt(d), sqrt(d + 1), c**2 - 3, sqrt(c**2 + 1), sqrt(n), 1 / positive_t],
)
def test_roots_that_are_real_are_taken(number):
    line = AtLeast(A, root=number * B)
    assert line.complaints(A + sp.expand(number**2) * B * B.T, ()) == []


# -- statements at explicit values ----------------------------------------------------

s, a, b = symbols("s a b")
table = {A: Matrix([[a, b], [0, 1]])}
EXPLICIT = {
    "a size without a value": Explicit(
        "", "", Trace(Identity(m)), 1, {"": {of("F", k + m, n): Matrix([1, 2, 3])}}
    ),
    "one of two sizes": Explicit(
        "", "", Trace(Identity(k)) + k, 2, {"": {of("F", k - m, n): Matrix([1, 2])}}
    ),
    "a size without a value, as a number": Explicit(
        "", "", m + 0 * k, 1, {"": {of("F", k + m, 1): Matrix([1, 2])}}
    ),
    "a characteristic polynomial": Explicit(
        "", "", Determinant(s * I - A), (s - a) * (s - 2), {"": table}
    ),
    "a determinant of a sum": Explicit(
        "", "", Determinant(I + A), 1 + Determinant(A), {"": table}
    ),
    "a value against its letter": Explicit(
        "", "", sqrt(d**2), -d, {"": {d: sp.Integer(-1)}}
    ),
    "no entries": Positive("", "", sp.zeros(0, 0), 0),
    "no entries in a row": Positive("", "", sp.zeros(1, 0), 0),
    "an indefinite matrix": Positive("", "", Matrix([[1, 2], [2, 1]]), 0),
    "a matrix of letters": Positive(
        "", "", A * A, 0, {"": {A: Matrix([[1, 2], [2, 1]])}}
    ),
    "a matrix above another": Positive("", "", sp.ones(2, 2), sp.zeros(2, 2)),
    "sides of two shapes": Counterexample(
        "",
        "",
        of("F", n, m) * G,
        G * of("F", n, m),
        {of("F", n, m): Matrix([[1, 2]]), G: Matrix([[3], [4]])},
    ),
    "a number and a matrix": Counterexample("", "", A, Trace(A), {A: Matrix([[2]])}),
    "a row and a column": Counterexample(
        "", "", of("v", n, 1), of("v", n, 1).T, {of("v", n, 1): Matrix([1, 2])}
    ),
    "a counterexample that its letter denies": Counterexample(
        "", "", positive_t * A, A, {positive_t: -1, A: Matrix([[1]])}
    ),
}


@pytest.mark.parametrize("step", EXPLICIT.values(), ids=EXPLICIT)
def test_what_says_nothing_of_explicit_matrices_is_refused(step):
    assert step.check() != []


@pytest.mark.parametrize(
    "step",
    [
        Explicit("", "", Determinant(s * I - A), (s - a) * (s - 1), {"": table}),
        Explicit(
            "",
            "",
            Determinant((s * I - A) * (I - A)),
            Determinant(s * I - A) * Determinant(I - A),
            {"": table},
        ),
        Explicit(
            "",
            "",
            Determinant(BlockMatrix([[s * I - A, O], [O, A]])),
            Determinant(s * I - A) * Determinant(A),
            {"": table},
        ),
        Explicit("", "", Trace(Identity(m)), 2, {"": {of("F", m, n): Matrix([1, 2])}}),
        Positive("", "", Matrix([[1, 2]]), 0),
        Positive("", "", of("v", n, 1), 0, {"": {of("v", n, 1): Matrix([1, 2])}}),
        Counterexample("", "", positive_t * A, A, {positive_t: 2, A: Matrix([[1]])}),
        Counterexample("", "", A, 0, {A: Matrix([[1]])}),
    ],
)
def test_what_is_so_of_explicit_matrices_is_taken(step):
    assert step.check() == []


def test_a_sign_between_rows_is_said_to_be_of_every_entry():
    row = Positive("", "a row", Matrix([[1, 2]]), 0)
    assert "every entry, evaluated" in str(row) and "every entry" in row._repr_latex_()
    assert "every entry" not in str(Positive("", "a number", sp.Integer(2), 0))


@pytest.mark.parametrize("shape", [(m, n), (n, k), (k, k)])
def test_an_increment_has_the_shape_of_what_moves(shape):
    moving, moved = of("F", n, m), of("dF", *shape)
    [fault] = Differential(moved, of={moving: moved}).complaints(moving, ())
    assert "is no increment of F" in fault
    with pytest.raises(ShapeError):
        Algebra().differential(moving, {moving: moved})
    assert (
        Differential(of("dF", n, m), of={moving: of("dF", n, m)}).complaints(moving, ())
        == []
    )


def test_a_letter_called_as_the_increment_is_no_increment():
    dX = of("dX", n, n)
    assert Gradient(dX, of=X).complaints(Trace(dX.T * X), ()) == []
    assert Gradient(2 * dX, of=X).complaints(Trace(dX.T * X), ()) != []


# -- what is printed ------------------------------------------------------------------


@pytest.mark.parametrize(
    "number",
    ["(33)", "(3.8)", "(27)-(30)", "(27–29)", "(4.9')", "(3.10)'", "(13, 26)"]
    + ["(section 2)", "(remark 3.4)", "(VD 10)"],
)
def test_a_bracket_with_a_number_is_a_number(number):
    assert numbered(Relation(f"{number} A = B", A, B)) == (number, "A = B")
    assert numbered(Relation(f"{number} the first", A, B)) == (number, "the first")


@pytest.mark.parametrize(
    "left",
    [
        (I + A * B) * C,
        (A + B) * C,
        (1 + t) * A,
        (A - 2 * I) * B,
        (of("A_1", n, n) + B).I,
    ],
)
def test_a_bracket_of_a_formula_is_no_number(left):
    supposed = Notation().suppose(left, X)
    assert numbered(supposed) == ("", supposed.name)
    assert cited_text(supposed) == supposed.name
    assert not cited_latex(supposed).startswith(r"\text")
    assert numbered(Notation().suppose(left, X, "7")) == ("(7)", supposed.name)


def test_a_chain_that_is_too_wide_is_cited_by_what_it_shows():
    wide = sum((A * B * C * X for _ in range(5)), O)
    chain = Notation().chain(
        "12", "the error of an estimate", wide, Line(5 * A * B * C * X)
    )
    assert chain.check() == []
    assert cited_text(chain.relation) == "(12) the error of an estimate"
    own = Notation().chain(
        "", "the error of an estimate", wide, Line(5 * A * B * C * X)
    )
    assert cited_text(own.relation) == "the error of an estimate"


def test_formulas_in_reasons_are_set():
    line = Line(A * B, why="`M_all` has an inverse")
    chain = Notation().chain("", "a product", A * B, line)
    assert "`" not in str(chain) + chain._repr_latex_()
    shown = Explicit("", "", s, s, {"": {}}, why="`x_1` is `s`")
    assert "`" not in str(shown) + shown._repr_latex_()
    assert words("100 % of `A`") == r"\text{100 \% of }A"
