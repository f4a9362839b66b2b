"""The lines of a derivation: what each says of the line before it, and why.

Every kind of line has what follows the sign (`right`), what it cites (`by`), words
where nothing is cited (`why`), a sign, and `complaints(left, symmetric)`: [] when the
line follows from exactly what it cites and needs all of it.
"""

import re
from dataclasses import dataclass
from typing import Any, ClassVar

import sympy as sp
from sympy.matrices.expressions.matexpr import MatrixExpr

from .models import NoModel, denial, evaluate, instance
from .proofs import Unproved, attempted, prove
from .prose import FORMULA, as_latex, plain
from .relations import Reasons, Relation, equation, named, refuse_means
from .rewriting import Contradiction
from .symbols import MatrixProduct, MatrixSum, Over
from .typeset import WIDEST, Show, latex, pieces, text, width
from .words import Formula, ShapeError, Symbols, is_letter

WIDEST_REASON = 44  # characters; a longer relation is cited by its name alone
LATEX_SIGNS = {"≥": r"\ge", "≤": r"\le", "⇒": r"\Rightarrow", "⇔": r"\Leftrightarrow"}
ONE = r"\((?:[A-Za-z]+ )?\d[\d.]*[a-z]?'?(?:, \d[\d.]*'?|[–-]\d[\d.]*'?)*\)'?"
NUMBER = re.compile(rf"({ONE}(?:[–-]{ONE})?)(?: |$)")  # of equations


@dataclass(frozen=True)
class Gap:
    """Why an equation is not proved.

    What is left of the difference of the sides, explicit matrices at which they differ,
    or None, the sides; or words, where the reasons contradict each other.
    """

    left_over: object = None
    counterexample: dict | None = None
    sides: tuple = ()
    why: str = ""

    def __str__(self):
        said = self.why or f"what is left over is {text(self.left_over)}"
        if self.counterexample is None:
            return said
        values = ", ".join(
            f"{text(symbol)} = {shown(value)}"
            for symbol, value in self.counterexample.items()
        )
        left, right = (shown(evaluate(s, self.counterexample)) for s in self.sides)
        return f"{said}; with {values}, the sides are {left} and {right}"


def shown(value, show=text):
    """An explicit value on one line; a 1 x 1 matrix is shown as a number."""
    return show(value[0] if getattr(value, "shape", ()) == (1, 1) else value)


def gap(left, right, cited, symmetric):
    """None if `left = right` follows from what is cited, otherwise the `Gap`."""
    try:
        proof = prove(left, right, cited, symmetric)
    except Unproved as e:
        return Gap(e.left_over, e.counterexample, (left, right))
    except Contradiction as e:
        return Gap(why=str(e))
    return refuse_faulty(proof)


def refuse_faulty(proof):
    """Nothing, of a proof whose certificate holds; a model is sought once a line."""
    if proof.faults():
        sides = f"{proof.left} = {proof.right}"
        raise AssertionError(f"the certificate of {sides} does not hold")


def follows(left, right, cited, symmetric):
    """Whether `left = right` follows; what is false is seen to be so at once."""
    try:
        if denial(left, right, cited, symmetric) is not None:
            return False
    except NoModel:
        pass
    try:
        proof = attempted(left, right, cited, symmetric)[0]
    except Contradiction:
        return False
    return proof is not None and refuse_faulty(proof) is None


def idle(cited, holds):
    """The citations without which a line holds as well, by `holds(the others)`."""
    return [
        relation
        for relation in cited
        if holds(tuple(other for other in cited if other is not relation))
    ]


def vacuous(left, right, cited, symmetric):
    """A complaint if nothing satisfies what is cited, or a model denies the line."""
    found = instance(cited, symmetric, (left, right))
    if found is None:
        return ["no matrices were found that satisfy what is cited"]
    if not found.agree(left, right):
        values = found.matrices()
        raise AssertionError(f"{left} = {right} is proved, and false at {values}")
    return []


# -- how a citation is shown ----------------------------------------------------------


def cited_text(relation):
    """A citation in Unicode: its number, and what it says if that is short.

    >>> from matrixproof import Relation, letters
    >>> X, Y = letters("X_next:n*n Yhat:n*n")
    >>> cited_text(Relation("(3.8) X = Y", X, Y)), cited_text(Relation("(3.9)", X, Y))
    ('(3.8) X₊ = Ŷ', '(3.9)')
    """
    number, says = numbered(relation)
    if by_its_letter(relation):
        return f"{number} {text(relation.left)}".strip()
    if by_its_name(relation, says):
        return relation.name
    return f"{number} {equation(*relation)}".strip()


def cited_latex(relation):
    """The same in LaTeX."""
    number, says = numbered(relation)
    if by_its_letter(relation):
        formula = latex(relation.left)
    elif by_its_name(relation, says):
        return words(relation.name)
    else:
        formula = equation(*relation, latex)
    return rf"{words(number)}\; {formula}" if number else formula


def numbered(relation):
    """A relation's name as its equation number and the rest.

    A bracket that its formula begins with is no number.

    >>> from matrixproof import Relation, letters
    >>> X, Y = letters("X:n*n Y:n*n")
    >>> numbered(Relation("(3.8) X = Y", X, Y))
    ('(3.8)', 'X = Y')
    >>> numbered(Relation("(X + Y) X = Y", (X + Y) * X, Y))
    ('', '(X + Y) X = Y')
    """
    name, says = relation.name, relation.show(text)
    if name == says:
        return "", name
    if name.endswith(f") {says}"):
        return name.removesuffix(says).strip(), says
    found = NUMBER.match(name)
    return (found[1], name[found.end() :].strip()) if found else ("", name)


def bare_number(relation: Any) -> str:
    """The equation number of a relation, without brackets; or ""."""
    return numbered(relation)[0].removeprefix("(").removesuffix(")")


def by_its_name(relation, says):
    """Whether a citation is its name: words, or its own formula where that is wide."""
    same = "".join(says.split()) == "".join(relation.show(text).split())
    return "=" not in says or (same and too_wide(relation))


def by_its_letter(relation):
    """Whether a letter is cited by itself alone: what defines it would be too wide."""
    if not isinstance(relation.left, sp.MatrixSymbol):
        return False
    long = "=" in relation.name and too_wide(relation)
    return long or isinstance(relation.right, sp.BlockMatrix)


def too_wide(relation):
    return width(relation.left) + width(relation.right) > WIDEST_REASON


def cited(relation, show):
    """A citation, set by `latex` or `text`."""
    return (cited_latex if show is latex else cited_text)(relation)


def worded(string, show):
    """Words beside a formula."""
    return (words if show is latex else plain)(string)


def listed(said, show):
    """Formulas and words with commas between them."""
    return (r",\; " if show is latex else ", ").join(said)


def words(string):
    r"""Text inside a formula; what stands between backquotes is a formula.

    >>> print(words("a sum"), words("`M_1` has an inverse"))
    \text{a sum} M_{1}\text{ has an inverse}
    """
    parts = FORMULA.split(string)
    said = [r"\text{" + re.sub(r"([_#%&$])", r"\\\1", x) + "}" for x in parts[::2]]
    formulas = [*map(as_latex, parts[1::2]), ""]
    return "".join(
        (one if part else "") + formula
        for part, one, formula in zip(parts[::2], said, formulas, strict=True)
    )


@dataclass(frozen=True, eq=False)
class Line:
    r"""The next line of a chain of equations.

    Parameters
    ----------
    right : expression
        What the line before it is equal to.
    by : tuple of Relation
        The relations that the step needs, all of them and no others.
    why : str
        Words for the reason; where nothing is cited, say what was done.

    Examples
    --------
    >>> from matrixproof import Relation, letters
    >>> A, B, C = letters("A:n*n B:n*n C:n*n")
    >>> meant, idle = Relation("A B = C", A * B, C), Relation("B A = C", B * A, C)
    >>> Line(C * B, by=(meant,)).complaints(A * B * B, ())
    []
    >>> print(*Line(C * B, by=(meant, idle)).complaints(A * B * B, ()))
    does not need B A = C

    Notes
    -----
    A relation that says what is in the blocks of a letter is used by putting them in.
    """

    right: Formula
    by: tuple = ()
    why: str = ""

    sign: ClassVar[str] = "="

    def __post_init__(self):
        object.__setattr__(self, "by", named(self.by))
        refuse_means(self.by)

    @property
    def cites(self) -> Reasons:
        """Every relation that the line rests on."""
        return self.by

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        """What is wrong with the step from `left` to this line, in plain language."""
        missing = self.gap(left, self.by, symmetric)
        if missing is not None:
            return [f"does not follow{self._sources()}: {missing}"]
        spare = idle(self.by, lambda others: self.follows(left, others, symmetric))
        return [f"does not need {cited_text(r)}" for r in spare] + self.vacuous(
            left, symmetric
        )

    def gap(self, left: Formula, cited: Reasons, symmetric: Symbols) -> Gap | None:
        return gap(*in_blocks(*self.equation(left), cited), symmetric)

    def follows(self, left: Formula, cited: Reasons, symmetric: Symbols) -> bool:
        try:
            return follows(*in_blocks(*self.equation(left), cited), symmetric)
        except ShapeError:  # blocks beside a letter whose blocks are not put in
            return False

    def vacuous(self, left: Formula, symmetric: Symbols) -> list[str]:
        return vacuous(*self.equation(left), self.by, symmetric)

    def equation(self, left: Formula) -> tuple[Formula, Formula]:
        """The two expressions that must be equal."""
        return left, self.right

    def too_wide(self) -> list[str]:
        """A complaint if the line does not fit on a page."""
        wide = width(self.right)
        if wide <= WIDEST:
            return []
        return [f"is {wide} characters wide; {WIDEST} fit, so it needs a letter"]

    def _sources(self):
        return " from " + " and ".join(map(cited_text, self.by)) if self.by else ""

    # -- shown ------------------------------------------------------------------------

    @property
    def latex_sign(self) -> str:
        return LATEX_SIGNS.get(self.sign, self.sign)

    def head(self, show: Show) -> str:
        """What stands to the left of the sign: nothing, or what is done to the left."""
        return ""

    def body(self, show: Show) -> str:
        """What stands to the right of the sign."""
        return show(self.right)

    def pieces(self, show: Show) -> list[str]:
        """The body, in pieces between which a page may break it."""
        return pieces(self.right, show)

    def reason(self, show: Show) -> str:
        """Why the line follows, in words or formulas."""
        return listed(self.reasons(show), show)

    def reasons(self, show: Show) -> list[str]:
        """Each reason: what is cited, and words."""
        why = [worded(self.why, show)] if self.why else []
        return [*(cited(r, show) for r in self.by), *why]

    def __str__(self):
        return f"{self.head(text)} {self.sign} {self.body(text)}".strip()


def in_blocks(
    left: Formula, right: Formula, cited: Reasons
) -> tuple[Formula, Formula, Reasons]:
    """Two sides and what is cited, with blocks in the place of letters for them.

    So are sums over an index: where one is put in twice, each has an index of its own.
    """
    meant: dict[Any, Any] = {}

    def put(expr):
        for _ in meant:
            expr = expr.xreplace(meant)
        return expr

    for r in cited * len(cited):  # one letter may stand in the blocks of another
        made = put(sp.sympify(r.right))
        parted = made.has(sp.BlockMatrix, Over) and not made.has(r.left)
        if is_letter(r.left) and parted:
            meant[r.left] = r.right
    if not meant:
        return left, right, cited
    rest = [r for r in cited if r.left not in meant]
    others = tuple(Relation(r.name, put(r.left), put(r.right)) for r in rest)
    return put(sp.sympify(left)), put(sp.sympify(right)), others


@dataclass(frozen=True, eq=False)
class Equation:
    """An equation as a statement, which a chain of equivalences leads on."""

    left: Formula
    right: Formula

    def relation(self, name: str = "the line before") -> Relation:
        return Relation(name, self.left, self.right)

    @property
    def expressions(self) -> tuple[Formula, Formula]:
        return self.left, self.right

    def show(self, show: Show) -> str:
        return equation(self.left, self.right, show)

    def __str__(self):
        return self.show(text)


class Implies(Line):
    """An equation that follows from the one before it.

    >>> from matrixproof import letters
    >>> A, B, C = letters("A:n*n B:n*n C:n*n")
    >>> Implies(Equation(A * C, B * C)).complaints(Equation(A, B), ())
    []
    >>> said = Implies(Equation(A, B)).complaints(Equation(A * C, B * C), ())
    >>> print(said[0].partition(":")[0])
    does not follow from the line before
    """

    sign: ClassVar[str] = "⇒"

    def complaints(self, left: Equation, symmetric: Symbols) -> list[str]:
        found = self._one_way(left, self.right, "the line before", symmetric)
        if found:
            return found
        holds = lambda others: self._holds(left, others, symmetric)  # noqa: E731
        found = [f"does not need {cited_text(r)}" for r in idle(self.by, holds)]
        if follows(self.right.left, self.right.right, self.by, symmetric):
            found.append("does not need the line before")
        given = (*self.by, left.relation())
        return found + vacuous(self.right.left, self.right.right, given, symmetric)

    def _one_way(self, given, wanted, name, symmetric):
        cited = (*self.by, given.relation(name))
        missing = gap(wanted.left, wanted.right, cited, symmetric)
        if missing is None:
            return []
        sources = " and ".join(map(cited_text, cited))
        return [f"does not follow from {sources}: {missing}"]

    def _holds(self, left, cited, symmetric):
        given = (*cited, left.relation())
        return follows(self.right.left, self.right.right, given, symmetric)

    def too_wide(self) -> list[str]:
        halves = (Line(self.right.left), Line(self.right.right))
        return [complaint for half in halves for complaint in half.too_wide()]

    def body(self, show: Show) -> str:
        return self.right.show(show)

    def pieces(self, show: Show) -> list[str]:
        left, right = (pieces(side, show) for side in self.right.expressions)
        return [*left, f"= {right[0]}", *right[1:]]


class Iff(Implies):
    """An equation that says the same as the one before it."""

    sign: ClassVar[str] = "⇔"

    def complaints(self, left: Equation, symmetric: Symbols) -> list[str]:
        back = self._one_way(self.right, left, "this line, back,", symmetric)
        return back or super().complaints(left, symmetric)

    def _holds(self, left, cited, symmetric):
        back = (*cited, self.right.relation())
        return super()._holds(left, cited, symmetric) and follows(
            left.left, left.right, back, symmetric
        )


def squared(root: Formula) -> Formula:
    """A root times its transpose, numbers in front; of a row of roots, block by block.

    So the sign of a sum in a root stands before the square, as its root is a number.
    """
    if isinstance(root, sp.BlockMatrix) and root.has(Over):
        return MatrixSum(*map(squared, root.blocks))
    number, factors = sp.S.One, [root]
    if isinstance(root, sp.MatMul):
        number, factors = root.as_coeff_matrices()
    half = MatrixProduct(*factors)
    return MatrixProduct(number**2, half, half.T)


@dataclass(frozen=True, eq=False)
class AtLeast(Line):
    """An inequality: a square is dropped.

    Parameters
    ----------
    root : MatrixExpr
        What is dropped is X X' with this X; between scalars, the trace of X X'.  The
        numbers in it must be real: sqrt(c) B needs a c that is not negative.

    >>> from matrixproof import letters
    >>> A, B = letters("A:n*n B:n*n")
    >>> AtLeast(A, root=B).complaints(A + B * B.T, ())
    []
    """

    root: Formula = None

    sign: ClassVar[str] = "≥"
    side: ClassVar[int] = 1

    def complaints(self, left: Formula, symmetric: Symbols) -> list[str]:
        return self.unreal() or super().complaints(left, symmetric)

    def gap(self, left: Formula, cited: Reasons, symmetric: Symbols) -> Gap | None:
        faults = self.unreal()
        return Gap(why=faults[0]) if faults else super().gap(left, cited, symmetric)

    def unreal(self) -> list[str]:
        """A complaint about each number in the root that may not be real."""
        return [
            f"drops no square: {text(c)} may not be real"
            + (
                "; say of its letters that they are nonnegative"
                if c.free_symbols
                else ""
            )
            for c in numbers(self.root)
            if not real(c)
        ]

    def equation(self, left: Formula) -> tuple[Formula, Formula]:
        square = squared(self.root)
        if not isinstance(left, MatrixExpr) and not hasattr(left, "shape"):
            square = sp.Trace(square)
        return left, self.right + self.side * square

    def reasons(self, show: Show) -> list[str]:
        turned = isinstance(self.root, sp.Transpose)
        other = self.root.arg if turned else sp.Transpose(self.root)
        square = sp.MatMul(self.root, other, evaluate=False)
        square = squared(self.root) if self.root.has(Over) else square
        positive = r" \ge 0" if show is latex else " ≥ 0"
        return [show(square) + positive, *super().reasons(show)]


class AtMost(AtLeast):
    """The reverse inequality: a square is added."""

    sign: ClassVar[str] = "≤"
    side: ClassVar[int] = -1


def numbers(expr):
    """The numbers in a matrix expression: its coefficients, the entries of tables."""
    if isinstance(expr, sp.MatrixBase):
        return [x for entry in expr for x in numbers(entry)]
    if not isinstance(expr, MatrixExpr):
        return [expr]
    if isinstance(expr, sp.BlockMatrix):
        return numbers(expr.blocks)
    if isinstance(expr, sp.MatrixSymbol | sp.Identity | sp.ZeroMatrix):
        return []
    return [x for arg in expr.args for x in numbers(arg)]


def real(number):
    """Whether a number is real for all its letters; a plain letter is a real number."""
    letters = {
        s: sp.Dummy(s.name, **{**s.assumptions0, "extended_real": True})
        for s in number.free_symbols
        if isinstance(s, sp.Symbol) and s.is_extended_real is None
    }
    traces = {t: sp.Dummy("trace", real=True) for t in number.atoms(sp.Trace)}
    return number.xreplace(traces).xreplace(letters).is_extended_real is True
