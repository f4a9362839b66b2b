"""What a line of a derivation rests on: whether it follows, and needs what it cites."""

import re
from dataclasses import dataclass

import sympy as sp

from .models import NoModel, denial, evaluate, instance
from .proofs import Unproved, attempted, prove
from .prose import FORMULA, as_latex
from .rewriting import Contradiction
from .typeset import latex, text, width

WIDEST_REASON = 44  # characters; a longer relation is cited by its name alone
ONE = r"\((?:[A-Za-z]+ )?\d[\d.]*[a-z]?'?(?:, \d[\d.]*'?|[–-]\d[\d.]*'?)*\)'?"
NUMBER = re.compile(rf"({ONE}(?:[–-]{ONE})?)(?: |$)")  # of equations


@dataclass(frozen=True)
class Gap:
    """Why an equation is not proved.

    Attributes
    ----------
    left_over : expression
        What is left of the difference of the sides.
    counterexample : dict or None
        {symbol: explicit Matrix} at which the sides differ.
    sides : tuple of expression
    why : str
        Said instead, where the reasons contradict each other.
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

    >>> from sympy import symbols
    >>> from matrixproof import MatrixSymbol, Relation
    >>> n = symbols("n", integer=True, positive=True)
    >>> X, Y = MatrixSymbol("X_next", n, n), MatrixSymbol("Yhat", n, n)
    >>> cited_text(Relation("(3.8) X = Y", X, Y)), cited_text(Relation("(3.9)", X, Y))
    ('(3.8) X₊ = Ŷ', '(3.9)')
    """
    number, says = numbered(relation)
    if by_its_letter(relation):
        return f"{number} {text(relation.left)}".strip()
    if by_its_name(relation, says):
        return relation.name
    return f"{number} {text(relation.left)} = {text(relation.right)}".strip()


def cited_latex(relation):
    """The same in LaTeX."""
    number, says = numbered(relation)
    if by_its_letter(relation):
        formula = latex(relation.left)
    elif by_its_name(relation, says):
        return words(relation.name)
    else:
        formula = f"{latex(relation.left)} = {latex(relation.right)}"
    return rf"{words(number)}\; {formula}" if number else formula


def numbered(relation):
    """A relation's name as its equation number and the rest.

    A bracket that its formula begins with is no number.

    >>> from sympy import symbols
    >>> from matrixproof import MatrixSymbol, Relation
    >>> n = symbols("n", integer=True, positive=True)
    >>> X, Y = MatrixSymbol("X", n, n), MatrixSymbol("Y", n, n)
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
