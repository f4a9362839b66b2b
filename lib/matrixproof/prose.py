"""Words with formulas in them, for a notebook, a page of the site or a terminal.

A formula stands between backquotes and is written as code: letters by their names, a
prime for the transpose.
"""

import re
from collections.abc import Iterator

from .typeset import LATEX, TEXT, word_spaced

FORMULA = re.compile(r"`([^`]+)`")
MATRIX = r"\[[^\[\]]*[;,][^\[\]]*\]"
NAME = r"[A-Za-z](?:\w*[^\W_])?(?:_\+)?(?:\^-?\w+|\*)?"
RAISED = r"\^-?\w+|[_^]\([^()]*\)"
SERIES = r"sum\[(\w+) = (.+?) \.\. (.+?)\]"
SIGN = r">=|<=|!=|->|=>|\.{3}"
ROOT = r"sqrt\((\w+)\)"
ANY = (SERIES, ROOT, MATRIX, r"E\[", NAME, RAISED, SIGN, r"\S", r"\s+")
TOKEN = re.compile("|".join(ANY))
SIGNS = {">=": "≥", "<=": "≤", "!=": "≠", "->": "→", "=>": "⇒", "...": "…"}
LATEX_SIGNS = {
    **{">=": r"\ge", "<=": r"\le", "!=": r"\ne", "->": r"\to", "=>": r"\Rightarrow"},
    **{"tr": r"\operatorname{tr}", "rank": r"\operatorname{rank}", "...": r"\ldots"},
    **{"det": r"\det", "cov": r"\operatorname{cov}", "{": r"\{", "}": r"\}"},
    "E[": r"\mathrm{E}[",
}
MARKS = (".", ",", ";", ":")  # of a sentence
LONG, SHORT = 20, 8  # characters: a formula to be broken, a part to be left alone
BREAK = re.compile(r" (?=[=+<>!-]+ |(?<=\] )\[)")
WORDS = {"tr", "rank", "det", "cov", "for", "and", "or"}


def as_latex(formula: str) -> str:
    r"""A formula that is written as code, in LaTeX.

    >>> print(as_latex("K_mv M = Omega C'"), as_latex("R_11 >= 0"))
    K_{\mathrm{mv}} M = \Omega C' R_{11} \ge 0
    >>> print(as_latex("[T; C]^-1"))
    \begin{bmatrix}T \\ C\end{bmatrix}^{-1}
    """
    return word_spaced(setting(formula, LATEX, LATEX_SIGNS))


def as_text(formula: str) -> str:
    """A formula that is written as code, in Unicode.

    >>> print(as_text("x_hat_next = x_minus + K y"), as_text("R_11 >= 0"))
    x̂₊ = x₋ + K y R₁₁ ≥ 0
    >>> print(as_text("[-K_1, I - K_2 H_2]"))
    [-K₁  I - K₂ H₂]
    """
    return setting(formula, TEXT, SIGNS)


def setting(formula, style, signs):
    """A formula in one style; in a matrix commas part entries, semicolons rows."""
    found = []
    for token in (match.group() for match in TOKEN.finditer(formula)):
        if series := re.fullmatch(SERIES, token):
            limits = (setting(x, style, signs) for x in series.groups())
            found.append(style.series(*limits, "").strip())
        elif root := re.fullmatch(ROOT, token):
            found.append(style.root(setting(root[1], style, signs)))
        elif token[0] == "[" and len(token) > 1:
            rows = [row.split(",") for row in token[1:-1].split(";")]
            entries = [[setting(x.strip(), style, signs) for x in row] for row in rows]
            found.append(style.rows(entries))
        elif token[0] == "^" and len(token) > 1:
            found = in_braces(found, style)
            found.append(style.power("", token[1:].strip("()")))
        elif token[0] == "_" and len(token) > 1:
            found.append(f"_{{{token[2:-1]}}}" if style is LATEX else token)
        elif token[0].isalpha() and token[-1] != "[" and token not in WORDS:
            found.append(style.name(token))
        else:
            found = in_braces(found, style) if token == "'" else found
            found.append(signs.get(token, token))
    return "".join(found)


def in_braces(found, style):
    """What a second mark can be set on: LaTeX refuses two on one letter."""
    *before, last = found
    return [*before, f"{{{last}}}"] if style is LATEX and "^" in last else found


def markdown(words: str) -> str:
    """Words with their formulas between dollar signs."""
    return FORMULA.sub(lambda found: f"${as_latex(found[1])}$", words)


def plain(words: str) -> str:
    """Words with their formulas in Unicode."""
    return FORMULA.sub(lambda found: as_text(found[1]), words)


def typeset(words: str) -> Iterator[tuple[bool, str]]:
    """(is it LaTeX, it) of each piece in turn, of words with formulas.

    A line may end between the parts of a formula; a mark of the sentence stays with
    the formula before it.
    """
    first, *rest = FORMULA.split(words)
    yield from [(False, first)] if first else []
    for formula, after in zip(rest[::2], rest[1::2], strict=True):
        mark = after[:1] if after[:1] in MARKS else ""
        *parts, last = map(as_latex, broken(formula))
        parts.append(last + (rf"\text{{{mark}}}" if mark else ""))
        yield True, parts[0]
        for part in parts[1:]:
            yield from ((False, "\u200b"), (True, f"{{}}{part}"))
        if after != mark:
            yield False, after.removeprefix(mark)


def broken(formula: str) -> list[str]:
    """A long formula in parts between which a line may end: at a sign, at a matrix.

    >>> broken("x_next = A (x + w) - [B, C] [u; v]")
    ['x_next = A (x + w)', '- [B, C] [u; v]']
    >>> broken("x_next = A x + w")
    ['x_next = A x + w']
    """
    depth, found, long = 0, [""], len(as_text(formula)) > LONG
    for k, c in enumerate(formula):
        depth += (c in "([") - (c in ")]")
        if c != " " or depth or not BREAK.match(formula, k):
            found[-1] += c
        elif long and len(as_text(found[-1])) > SHORT:
            found.append("")
        else:
            found[-1] += c
    return found
