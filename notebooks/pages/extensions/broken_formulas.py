"""Formulas as they are written, in pieces between which a page may break a line."""

import itertools
import re

from docutils import nodes

WIDE = 40  # columns of a line that has its reason below
SIGNS = {"=", "+", "-", r"\ge", r"\le"}
OPENING, CLOSING = {*"{[(", r"\begin"}, {*"}])", r"\end"}
MATRIX = re.compile(r"(.*?)\\begin\{bmatrix\}(.*)\\end\{bmatrix\}(.*)", re.DOTALL)
MATRICES = re.compile(r"(?<=\\end\{bmatrix\})(?=.*\\begin\{bmatrix\})", re.DOTALL)
SPELLED = re.compile(
    r"\\(?:left|right|text|operatorname|mathrm|bar|tilde|hat)\b|\\[,;!]|[{}_^\s]"
)


def spaced(formulas, listed=None):
    """Formulas between which a line may end; in a list there are commas."""
    joint = "\u200b" if listed is None else ", "
    found = [nodes.Text(listed)] if listed else []
    for k, one in enumerate(formulas):
        found += [nodes.Text(joint)] * bool(k) + [nodes.math("", one)]
    return found


def in_lines(source):
    """A formula, with breaks between matrices that stand in no brackets.

    A matrix that is too wide for a line is written as its entries in brackets.
    """
    first, *found = MATRICES.split(source)
    if found and r"\left(\begin" in source:
        return [source]
    found = [first, *("{}" + part.lstrip() for part in found)]
    return [piece for part in found for piece in entries(part)]


def entries(source):
    """A formula with one matrix at most: its entries, if it is wide."""
    wide = MATRIX.fullmatch(source)
    if not wide or about(wide[2]) < WIDE:
        return [source]
    before, inner, after = wide.groups()
    rows = [split(row, "&") for row in split(inner, r"\\")]
    found = [f"{entry}," for row in rows for entry in row]
    ends = itertools.accumulate(map(len, rows))
    for end in ends:
        found[end - 1] = found[end - 1][:-1] + ";"
    found[-1] = found[-1][:-1]
    pieces = [piece for entry in found for piece in apart(entry)]
    pieces[0] = f"{before}[{pieces[0]}"
    pieces[-1] = f"{pieces[-1]}]{after}"
    return pieces


def apart(source, within=0):
    """A formula in pieces, each with its sign; it stands in no more brackets."""
    found, depth = [""], 0
    for token in re.findall(r"\\[A-Za-z]+|\\.|.", source):
        depth += (token in OPENING) - (token in CLOSING)
        if depth <= within and token in SIGNS and found[-1].strip(" ={}"):
            found.append("{}")
        found[-1] += token
    return found


def about(source):
    r"""About how wide a formula is: its letters, and the longest row of a matrix.

    >>> about(r"\left(\bar M + K_{q}\right)")
    6
    """
    plain = re.sub(r"\\[A-Za-z]+", "x", SPELLED.sub("", source))
    return max(len(row) for row in plain.split(r"\\"))


def split(source, mark):
    """The parts of a formula between marks that are in no bracket or matrix.

    >>> split(r"a &= {b & c} && d", "&")
    ['a', '= {b & c}', '', 'd']
    """
    found, depth, k = [""], 0, 0
    while k < len(source):
        token = re.match(r"\\begin\b|\\end\b|\\.|.", source[k:], re.DOTALL)[0]
        depth += (token in {"{", r"\begin"}) - (token in {"}", r"\end"})
        if not depth and source.startswith(mark, k):
            found.append("")
            token = mark
        else:
            found[-1] += token
        k += len(token)
    return [part.strip() for part in found]
