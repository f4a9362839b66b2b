r"""Chains that notebooks show, set like those of the chapters.

A notebook stores a chain as one wide formula, which JupyterLab shows as it stands.  On
a page each line is a row of a grid instead, so that formulas and reasons can wrap.
"""

import re

from broken_formulas import WIDE, about, apart, in_lines, spaced, split
from chapters import DISPLAYED, SEPARATOR, marked
from docutils import nodes
from sphinx.transforms import SphinxTransform

WHOLE = re.compile(r"\\begin\{aligned\}(.*)\\end\{aligned\}", re.DOTALL)
NEXT_ROW = r"\\[2pt]"
MARKS = {r"\checkmark": "✓", r"(\checkmark)": "(✓)", r"\times": "✗"}
WORDS = re.compile(r"\\text\{([^{}]*)\}")
START = 7  # columns of what a line begins with, to stand before its sign
BESIDE = 28  # columns of a line that has its reason beside it
LONG_REASON = 28  # columns of a citation that stands below its line


class SetChains(SphinxTransform):
    """Replaces the formula of a chain by the grid of its lines."""

    default_priority = 310  # after the numbers

    def apply(self):
        for block in list(self.document.findall(nodes.math_block)):
            whole = WHOLE.fullmatch(block.astext().strip())
            rows = [cells(row) for row in split(whole[1], NEXT_ROW)] if whole else []
            if any(row[-1] in MARKS for row in rows):
                box = nodes.container(classes=["chain"], ids=block["ids"])
                if block.get("number"):
                    here = nodes.reference("", f"({block['number']})", internal=True)
                    here["refid"] = block["ids"][0]
                    number = nodes.inline("", "", here, classes=["number"])
                    box += nodes.paragraph("", "", number, classes=["says", "alone"])
                box += grid(rows)
                block.replace_self(box)


def grid(rows):
    """The rows as cells: what stands before the sign, the rest, mark and reason."""
    found = nodes.container(classes=["lines"])
    for left, right, *rest in rows:
        if rest and rest[-1] in MARKS:
            if about(left) > START:
                found += nodes.paragraph("", "", *said(left), classes=["start"])
                left = ""
            cell = [nodes.math("", left)] if left else []
            found += nodes.paragraph("", "", *cell, classes=["left"])
            because = rest[0] if len(rest) > 1 else ""
            cited = max(about(part) for part in because.split(SEPARATOR))
            wide = about(left) + about(right) > BESIDE or cited > LONG_REASON
            classes = ["right", "wide"][: 1 + wide]
            found += nodes.paragraph("", "", *said(right), classes=classes)
            marked(found, MARKS[rest[-1]], because, wide)
        else:
            found += nodes.paragraph(
                "", "", *said(f"{left} {right}"), classes=["start"]
            )
    return found


def said(source):
    """Words as words, formulas in pieces between which a line may end."""
    words = WORDS.fullmatch(source)
    if words:
        return [nodes.Text(words[1])]
    found = [part for whole in apart(source) for part in pieces(whole)]
    return spaced([DISPLAYED * (r"\begin" in part) + part for part in found])


def pieces(source):
    """A term, and where it is too long for a line, what stands in its brackets."""
    if r"\begin" in source:
        return in_lines(source)
    if about(source) < WIDE:
        return [source]
    return apart(re.sub(r"\\(left|right)\b", "", source), within=1)


def cells(row):
    """What stands before the sign, what follows it, and the rest of the columns."""
    first, *rest = split(row, "&&")
    left, right = (split(first, "&") + [""])[:2]
    return [left, right, *rest]


def setup(app):
    app.add_transform(SetChains)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
