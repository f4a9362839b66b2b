"""A displayed equation with a number is the one that the ledger has under that number.

The ledger has what the pages prove and define, so a sign or a letter that is changed in
a sentence of a notebook is noticed here, and its cell named.
An equation that the ledger does not have is compared with the list below.
"""

import json
import re
from collections import Counter
from pathlib import Path

import pytest

from luenberger import ledger
from matrixproof import Chain, latex

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
AS_HERE = {  # what the ledger writes, and the notebook's letters for it
    "02-trace-minimisation": {"1,2": {"+Eu": ""}},  # no feedthrough
    "03-limiting-cases": {
        "37, 38": {"K_1": "K", "R_11": "R"},
        "43, 44": {"V(": "K("},
        "46, 47": {"S_1y": "y_1"},
    },
    "05-staircase-observer": {"18, 20": {"xM": "[f'|t'|d']M", "a_f": "a'"}},
    "07-functional-observers": {"3–7": {"-DE": ""}},  # no feedthrough
    "09-optimal-projection": {
        "3.10–3.13": {"Q_sV_2s^⁻1": "K_q"},
        "3.20": {"K_q": "K"},
        "4.5, 4.7": {"A_1'PA_1": r"\sumA'PA"},
    },
}
# What the ledger does not have: an example's plant, a drawn matrix, the meaning of a
# letter, an equation by indices where the ledger has one letter for all.
ONLY_HERE = {
    "02-trace-minimisation": {
        "1,2": ["C=[1/4|1/4|1/4|1/4;0|0|0|1]"],
        "19, 21–23": ["M=[C_1;C_2;L]", "y_1=q_1+v_1", "y_2=H_2q_2+v_2"],
        "24": ["q=Pz+Vy"],
    },
    "03-limiting-cases": {"46, 47": [r"[T;C_1]^⁻1=[P|\Gamma_1]"]},
    "04-velocity-aided-tracking": {
        "54": ["[x;x;x]=[1|T|T^2/2;0|1|T;0|0|1][x;x;x]+[0;0;1]w"],
        "55": ["y=[1|0|0;0|1|0][x;x;x]+v"],
        "32": [
            r"K_1\mu+K_2H_2\Omega_21=\Omega_21",
            "K_1N_1+K_2(H_2N_2+R_22)=N_2",
        ],
    },
    "05-staircase-observer": {
        "1": ["q=v", r"v=4(q-2q+q)-1/2v+\delta_i1u", "q_0=q_4", "q_4=0"],
        "4": ["[T;C]"],
        "7": [
            r"U^*AU=[A_11|A_12|\cdots|A_1k;A_21|A_22||\vdots;|\ddots|\ddots|;||A_kk⁻1|A_kk]",
            r"CU=[0|\cdots|0|C]",
        ],
        "13, 14": [
            r"T_U=[1|\times|\cdots||\cdots|\times;|1|\times|||\vdots;||\ddots|||;|||1|\times\cdots|\times]",
            "iF:",
            r"[f'|f_ii|0\cdots0]",
        ],
        "16": [r"[0\cdots0|1|t']A_U-[f'|f_ii|0\cdots0]T_U=d'C_U"],
        "18, 20": ["M=[-T;(A_U-f_iiI)_i;-C_U]"],
    },
    "06-canonical-form-and-deadbeat": {
        "1, 2": [
            "x=[1|h|h^2/2;0|1|h;0|0|1]x+[h^2/2;h;0]u",
            "y=[1|0|0;0|0|1]x+[0;1]u",
        ],
        "5": [r"[C_1|C_1A|C_1A^2|\ldots;C_2|C_2A|C_2A^2|\ldots]"],
        "6–8": [
            r"P=[C_1';(C_1A)';\ldots;(C_1A^p_1⁻1)';C_2';\ldots]'",
            r"\sump=n",  # there block by block
        ],
        "21": [r"p_M=\maxp"],
        "15": [r"y_ik⁺l=h\Phi^lw+\sum_j⁼0^l⁻1h\Phi^l⁻1⁻jGu_k⁺j"],
        "22–26": [r"w_(i)=[y_ik⁺1;\vdots;y_ik⁺p⁻1]-\Delta_p[u;\vdots;u_k⁺p_M⁻2]"],
    },
    "07-functional-observers": {
        "1": ["x=[0|1|0;0|-1|10;0|-1|-5]x+[0;0;5]u", "y=[1|0|0]x"],
        "13": [
            r"\beta_0\kappa+\beta_1\kappa+\dots+\beta_r⁻1\kappa_i⁺r⁻1+\kappa_i⁺r=0",
            r"i=0\dotsn-r-1",
        ],
    },
    "08-adaptive-sampling": {"17": [r"E=\int_0^1.2|y^*(t)-y(t)|dt"]},
    "09-optimal-projection": {
        "3.3–3.5": [r"J=\limE(Lx-y_e)'R(Lx-y_e)"],
        "4.4": ["Q=Exx'", r"Q=AQA'+\sumAQA'+V"],
        "3.10–3.13": ["K_q=Q_sV_2s^⁻1"],
        "3.20": ["K=Q_sV_2s^⁻1"],
    },
}
DROPPED = re.compile(
    r"""\\tag\{[^}]*\} | _\{\\text\{[^}]*\}\} | \\text\{[^}]*\}
    | \\(?:hat|tilde|bar|d?dot|left|right|big|Big|mathrm|mathbf|operatorname)(?![a-z])
    | \\(?:begin|end)\{aligned\} | \\[,;!\ ] | &
    | _\{\s*(?:i|k|i\s?[+-]\s?1|,?\+)\s*\} | _[ik+]""",
    re.X,
)
MATRIX = re.compile(r"\\begin\{(bmatrix|array)\}(?:\{l+\})?(.*?)\\end\{\1\}", re.S)
NAMED = re.compile(r"\\underbrace\{(.*?)\}_\{(\w)\}", re.S)


def displayed(name):
    """Cell, tag and formula of each displayed equation with a number, in Markdown."""
    cells = json.loads((HERE / f"{name}.ipynb").read_text(encoding="utf-8"))["cells"]
    for cell in cells:
        if cell["cell_type"] == "markdown":
            for formula in re.findall(r"\$\$(.*?)\$\$", "".join(cell["source"]), re.S):
                if tag := re.search(r"\\tag\{(\d[^}]*)\}", formula):
                    yield cell["id"], tag[1], formula


def equations(formula):
    """Each equation of a display, or what it shows without one; matrices [a|b;c|d]."""
    formula = MATRIX.sub(drawn, formula)
    formula = re.sub(r"\[\\,(.*?)\\,\]", in_line, formula, flags=re.S)
    named = [f"{letter}={bare(matrix)}" for matrix, letter in NAMED.findall(formula)]
    formula = NAMED.sub(r"\2", formula)
    for part in re.split(r"\\q?quad|\\\\|,\s*&|\\;\s*\\;", formula):
        sides = bare(part).split("=")
        named += (
            map("=".join, zip(sides, sides[1:])) if sides[1:] else filter(None, sides)
        )
    return named


def drawn(matrix):
    return f" [{matrix[2].replace('&', '|').replace(chr(92) * 2, ';')}] "


def in_line(row):
    return "[" + re.sub(r"\\;\s*\\;", "|", row[1]) + "]"


def bare(formula):
    """Letters and signs without hats, instants, spaces and braces."""
    formula = re.sub(r"\\[tdc]?frac(\d)(\d)", r"\1/\2", DROPPED.sub("", formula))
    formula, more = re.sub(r"[\s,]|\.(?!\d)", "", formula), True
    while more:
        formula, more = re.subn(r"\{([^{}]*)\}", within, formula)
    return formula.replace("^'", "'")


def within(braces):
    """A sign in an index or a power separates no terms."""
    return braces[1].translate(str.maketrans("+-=", "⁺⁻⁼"))


def terms(equation):
    """What an equation says: its terms on one side, whatever the sign of the whole."""
    left, _, right = equation.partition("=")
    left, right = signed(left), signed(right)
    right = Counter({(-sign, term): count for (sign, term), count in right.items()})
    there = left + right
    turned = Counter({(-sign, term): count for (sign, term), count in there.items()})
    return frozenset({frozenset(there.items()), frozenset(turned.items())})


def signed(side):
    """How often each term comes with a sign; a sign within brackets is the term's."""
    found, depth, sign, term = Counter(), 0, 1, ""
    for letter in f"{side}+":
        depth += (letter in "([") - (letter in ")]")
        if letter in "+-" and not depth:
            found[sign, term] += bool(term)
            sign, term = 1 if letter == "+" else -1, ""
        else:
            term += letter
    return +found


def in_ledger(name, tag):
    """What the ledger says under a number, or under those of a range."""
    low, high = (numbers(tag)[k] for k in (0, -1))
    for entry in ledger.entries(LESSONS[name]):
        if any(low <= one <= high for one in numbers(entry.number)):
            for formula in (x for one in entry.says for x in formulas(one)):
                for equation in equations(formula):
                    for old, new in AS_HERE.get(name, {}).get(tag, {}).items():
                        equation = equation.replace(old, new)
                    yield equation
                    yield from equation.split("=")


def formulas(one):
    """What is stated, line by line, and what its proof rests on, or is evaluated at."""
    item = one.item
    yield " ".join(one.pieces(latex))
    yield from (relation.show(latex) for relation in getattr(item, "relations", ()))
    if isinstance(item, Chain):
        start = item.start(latex)
        yield from (f"{start} = {line.body(latex)}" for line in item.lines[:-1])
    for letter, value in next(iter(getattr(item, "cases", {}).values()), {}).items():
        yield f"{latex(letter)} = {latex(value)}"


def numbers(tag):
    return [
        tuple(map(int, one.split("."))) for one in re.findall(r"\d+(?:\.\d+)?", tag)
    ]


def complaints(name, lesson):
    """What is displayed otherwise than in the ledger and in the list, with its cell."""
    for cell, tag, formula in lesson:
        known = set(map(terms, in_ledger(name, tag)))
        only_here = ONLY_HERE.get(name, {}).get(tag, ())
        for equation in equations(formula):
            if equation not in only_here and terms(equation) not in known:
                yield f"{name}, cell {cell}, ({tag}): {equation}"


@pytest.mark.parametrize("name", LESSONS)
def test_a_displayed_equation_is_the_ledgers(name):
    assert not list(complaints(name, displayed(name)))


@pytest.mark.parametrize("name", LESSONS)
def test_what_is_only_in_a_notebook_is_there_and_not_in_the_ledger(name):
    """The list is no longer than it has to be."""
    shown = {}
    for _, tag, formula in displayed(name):
        known = set(map(terms, in_ledger(name, tag)))
        new = [one for one in equations(formula) if terms(one) not in known]
        shown |= {tag: shown.get(tag, []) + new} if new else {}
    assert shown == ONLY_HERE.get(name, {})


@pytest.mark.parametrize("name", LESSONS)
def test_every_changed_letter_and_sign_is_noticed_and_its_cell_named(name):
    for cell, tag, formula in displayed(name):
        damaged = list(changed(formula))
        assert damaged
        for other in damaged:
            found = list(complaints(name, [(cell, tag, other)]))
            assert found and all(
                f"{name}, cell {cell}, ({tag})" in one for one in found
            )


def changed(formula):
    """With one sign turned, one prime gone, one matrix another; no word, no instant."""
    words = r"\\(?:tag|text|begin|end)\{[^}]*\}|\\[A-Za-z]+|_\{[^}]*\}|([-+'A-Z])"
    for one in re.finditer(words, formula):
        if one[1]:
            other = {"-": "+", "+": "-", "'": "", "Y": "X"}.get(one[1], "Y")
            yield formula[: one.start()] + other + formula[one.end() :]


def test_an_equation_of_another_number_is_noticed():
    cell, tag, formula = next(displayed("01-one-structure"))
    assert not list(complaints("01-one-structure", [(cell, tag, formula)]))
    assert list(complaints("01-one-structure", [(cell, "999", formula)]))
