"""A displayed equation with a number is the one that the ledger has under that number.

The equations in the ledger's words are those that its evidence proves, so a sign or a
letter that is changed in a sentence of a notebook is noticed here.
"""

import json
import re
from pathlib import Path

import pytest

from luenberger import ledger

HERE = Path(__file__).parents[2] / "notebooks"
LESSONS = {
    "01-one-structure": "leondes_novak",
    "02-trace-minimisation": "leondes_novak",
    "03-limiting-cases": "leondes_novak",
    "04-velocity-aided-tracking": "leondes_novak",
    "05-staircase-observer": "van_dooren",
    "06-canonical-form-and-deadbeat": "kawazoe",
    "07-functional-observers": "moore",
    "08-adaptive-sampling": "hsia",
    "09-optimal-projection": "haddad_bernstein",
}
PLANT = "the plant of an example: its numbers are in the code"
BLOCKS = "rows and blocks are drawn, where the ledger has letters"
INDICES = "written with indices or sums, where the ledger has one letter for all"
RENAMED = "one letter is the notebook's, as the text beside it says"
MEANING = "says what a letter means"
OTHERWISE = {  # displayed otherwise than in the ledger, and why
    "02-trace-minimisation": {"1,2": PLANT, "19, 21–23": BLOCKS, "24": BLOCKS},
    "03-limiting-cases": {"37, 38": RENAMED, "43, 44": RENAMED, "46, 47": BLOCKS},
    "04-velocity-aided-tracking": {"32": BLOCKS, "54": PLANT, "55": PLANT},
    "05-staircase-observer": {
        "1": PLANT,
        "7": BLOCKS,
        "13, 14": BLOCKS,
        "16": BLOCKS,
        "18, 20": BLOCKS,
    },
    "06-canonical-form-and-deadbeat": {
        "1, 2": PLANT,
        "6–8": INDICES,
        "15": INDICES,
        "21": MEANING,
        "22–26": INDICES,
    },
    "07-functional-observers": {"1": PLANT, "3–7": RENAMED, "13": INDICES},
    "08-adaptive-sampling": {"17": MEANING},
    "09-optimal-projection": {
        "3.3–3.5": MEANING,
        "3.10–3.13": RENAMED,
        "3.20": RENAMED,
        "4.4": INDICES,
        "4.5, 4.7": INDICES,
    },
}
DROPPED = re.compile(
    r"""\\tag\{[^}]*\} | _?\{?\\text\{[^}]*\}\}? | \\underbrace
    | \\(?:hat|tilde|bar|dot|left|right|big|Big|quad|qquad|mathrm|mathbf|operatorname)\b
    | \\begin\{aligned\} | \\end\{aligned\} | \\[,;!\ ] | &
    | _\{?(?:i\ ?[+-]\ ?1|i|k|,?\+)\}?""",
    re.X,
)


def displayed(name):
    """Tag and formula of each displayed equation with a number, in Markdown."""
    cells = json.loads((HERE / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    for cell in cells:
        if cell["cell_type"] == "markdown":
            for formula in re.findall(r"\$\$(.*?)\$\$", "".join(cell["source"]), re.S):
                if tag := re.search(r"\\tag\{(\d[^}]*)\}", formula):
                    yield tag[1], formula


def equations(formula):
    parts = re.split(r"\\qquad|\\quad|\\\\", formula)
    return [bare(part) for part in parts if "=" in part]


def bare(formula):
    """Letters and signs without hats, instants and spaces."""
    return re.sub(r"[{}\s,.]", "", DROPPED.sub("", formula)).replace("^'", "'")


def in_ledger(paper, tag):
    """What the ledger says under a number, or under those of a range."""
    ends = re.findall(r"\d+(?:\.\d+)?", tag)
    low, high = (tuple(map(int, one.split("."))) for one in (ends[0], ends[-1]))
    says = ""
    for entry in ledger.entries():
        found = re.findall(r"\d+(?:\.\d+)?", entry.number)
        numbers = [tuple(map(int, one.split("."))) for one in found]
        if entry.paper == paper and any(low <= one <= high for one in numbers):
            says += entry.says._repr_markdown_()
    return [bare(formula) for formula in re.findall(r"\$(.*?)\$", says)]


def agrees(name, tag, formula):
    known = in_ledger(LESSONS[name], tag)
    return all(any(equation in one for one in known) for equation in equations(formula))


@pytest.mark.parametrize("name", LESSONS)
def test_a_displayed_equation_is_the_ledgers(name):
    others = {tag for tag, formula in displayed(name) if not agrees(name, tag, formula)}
    assert others == OTHERWISE.get(name, {}).keys()


@pytest.mark.parametrize(
    "name, tag, old, new",
    [
        ("01-one-structure", "14", "T_+ A P", "T_+ A V"),
        ("01-one-structure", "13", "+ VC", "- VC"),
        ("01-one-structure", "11", "- T_+ w", "+ T_+ w"),
        ("05-staircase-observer", "4", "FT", "TF"),
    ],
)
def test_a_changed_equation_is_noticed(name, tag, old, new):
    formula = dict(displayed(name))[tag]
    assert old in formula and agrees(name, tag, formula)
    assert not agrees(name, tag, formula.replace(old, new))
    assert not agrees(name, "999", formula)
