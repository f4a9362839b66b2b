"""Words with formulas in them, for a notebook, a page of the site or a terminal.

A formula stands between backquotes and is written as code: letters by their names, a
prime for the transpose.
"""

import re

from .letters import latex_name, text_name
from .typeset import word_spaced

FORMULA = re.compile(r"`([^`]+)`")
TOKEN = re.compile(r"E(?=\[)|[A-Za-z]\w*(?:_\+)?(?:\^-?\w+|\*)?|>=|<=|!=|->|=>|\S|\s+")
SIGNS = {">=": "≥", "<=": "≤", "!=": "≠", "->": "→", "=>": "⇒"}
LATEX_SIGNS = {
    **{">=": r"\ge", "<=": r"\le", "!=": r"\ne", "->": r"\to", "=>": r"\Rightarrow"},
    **{"tr": r"\operatorname{tr}", "rank": r"\operatorname{rank}"},
    **{"det": r"\det", "cov": r"\operatorname{cov}", "{": r"\{", "}": r"\}"},
}
WORDS = {"tr", "rank", "det", "cov", "for", "and", "or"}


def as_latex(formula):
    r"""A formula that is written as code, in LaTeX.

    >>> print(as_latex("K_mv M = Omega C'"), as_latex("R_11 >= 0"))
    K_{\mathrm{mv}} M = \Omega C' R_{11} \ge 0
    """
    found, depth = [], 0
    for token in tokens(formula):
        depth += (token == "[") - (token == "]")
        blank = r"\; " if depth and token.isspace() else token
        found.append(LATEX_SIGNS.get(token) or set_by(latex_name, blank))
    return word_spaced("".join(found))


def as_text(formula):
    """A formula that is written as code, in Unicode.

    >>> print(as_text("x_hat_next = x_minus + K y"), as_text("R_11 >= 0"))
    x̂₊ = x₋ + K y R₁₁ ≥ 0
    """
    return "".join(SIGNS.get(t) or set_by(text_name, t) for t in tokens(formula))


def tokens(formula):
    return TOKEN.findall(formula)


def set_by(name, token):
    """A token that is a letter, by `name`; any other as it stands."""
    letter = token[0].isalpha() and token not in WORDS
    return name(token) if letter else token


def markdown(words):
    """Words with their formulas between dollar signs."""
    return FORMULA.sub(lambda found: f"${as_latex(found[1])}$", words)


def plain(words):
    """Words with their formulas in Unicode."""
    return FORMULA.sub(lambda found: as_text(found[1]), words)


def pieces(words):
    """(is it a formula, its source) of each piece in turn."""
    for k, piece in enumerate(FORMULA.split(words)):
        if piece:
            yield k % 2 == 1, piece
