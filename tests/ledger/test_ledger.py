"""The ledger: complete, no pointer dangles, and no evidence survives damage."""

import ast
import dataclasses
import importlib
import json
import math
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from functools import cache
from pathlib import Path

import pytest
import sympy as sp
from bs4 import BeautifulSoup
from damage import broken, unnoticed
from entries import complaints

import luenberger as lb
from luenberger import ledger
from luenberger.ledger import evidence
from luenberger.papers.hsia.derivation import laws, loop
from luenberger.papers.hsia.derivation.letters import y_star
from luenberger.papers.leondes_novak.derivation import huddle
from matrixproof import Claim, holds, vanishes
from tests.papers.hsia import test_loop
from tests.papers.test_pages import PAGES

ROOT = Path(__file__).parents[2]
ENTRIES = ledger.entries()
POINTERS = {  # each once, with the entries that rest on it
    pointer: [e for e in ENTRIES if pointer in e.evidence]
    for entry in ENTRIES
    for pointer in entry.evidence
}
STEPS = [pointer for pointer in POINTERS if not evidence.is_test(pointer)]
TESTS = [pointer for pointer in POINTERS if evidence.is_test(pointer)]
PAGE = {pointer: pointer.partition(": ")[0] for pointer in STEPS}  # where each leads
SLIPS = [(e, slip) for e, slip in ledger.misprints() if slip.tried]
ERRATA = ("haddad_bernstein.errata", "moore.errata", "van_dooren.errata")


def name(entry):
    return f"{entry.paper} {entry.number}"


def failing(found):
    """What is wrong with each of many, by its name, where there is anything."""
    return {key: wrong for key, wrong in found.items() if wrong}


def numbers(*spans):
    return [f"({k})" for first, last in spans for k in range(first, last + 1)]


WANTED = {
    "leondes_novak": [
        *(*numbers((1, 44)), "after (44)", *numbers((45, 53)), "after (53)"),
        *(*numbers((54, 58)), "Fig. 3"),
    ],
    "moore": [*numbers((1, 13)), "after (13): l", "after (13): signs"],
    "haddad_bernstein": [
        *(f"2: {letter}" for letter in ("tau_perp", "A~", "A~_i", "w~", "V~", "R~")),
        *("2: pi_i", "2: V2s", "2: Qs", "2: V2s, n_e = n", "2: Qs, n_e = n"),
        *(f"(3.{k})" for k in range(1, 10)),
        *("section 3: D(Q, P)", "theorem 3.1", "(3.10)", "(3.10)'"),
        *(f"(3.{k})" for k in range(11, 19)),
        *("remark 3.2", "remark 3.3", "remark 3.4"),
        *(f"(3.{k})" for k in range(19, 28)),
        *("remark 3.6", "(4.1)", "(4.2)", "(4.3)", "lemma 4.1"),
        *("(4.4)", "(4.5)", "after (4.5)"),
        *(f"(4.{k})" for k in range(6, 17)),
    ],
    "van_dooren": [
        *(*numbers((1, 12)), "remark 1", *numbers((13, 21)), "after (21)"),
        *(*numbers((22, 33)), "after (33)", "(34)"),
        *("remark 2(a)", "remark 2(b)", "remark 2(c)"),
    ],
    "kawazoe": numbers((1, 26)),
    "hsia": ["(17)", "Table II periodic", *(f"Table II law {k}" for k in range(1, 5))],
}


# -- complete -----------------------------------------------------------------------


@pytest.mark.parametrize("paper", ledger.PAPERS)
def test_every_equation_has_one_entry_in_page_order(paper):
    assert [e.number for e in ledger.entries(paper)] == WANTED[paper]


def test_every_theorem_of_ours_has_an_entry():
    """To add one, add an entry to ledger/entries/ours.toml: nothing is listed here."""
    names = [entry.number for entry in ledger.entries(ledger.OURS)]
    assert len(set(names)) == len(names)
    pages = {f"{room}.{path.stem}" for room in OUR_ROOMS for path in modules_of(room)}
    pages |= {"hsia.noise", "leondes_novak.settled_ratio"}
    entered = {
        ".".join(pointer.partition(": ")[0].split(".")[:2])
        for entry in ledger.entries(ledger.OURS)
        for pointer in entry.evidence
    }
    assert pages - entered == set()


OUR_ROOMS = [room for room in evidence.ROOMS if room not in ledger.PAPERS]


def modules_of(room):
    """The files of a room's derivations that have a page."""
    folder = Path(importlib.import_module(evidence.package(room)).__file__).parent
    return [p for p in folder.glob("*.py") if "\ndef derive(" in p.read_text("utf-8")]


def test_fields_are_filled():
    assert [name(entry) for entry in ENTRIES if not filled(entry)] == []


def filled(entry):
    return (
        entry.kind in ledger.KINDS
        and entry.says.source.endswith(".")
        and entry.used
        and 0 < len(entry.evidence) == len(set(entry.evidence))
        and re.match("proved|reproduced to|implemented by", entry.level)
        and all(
            slip.printed and slip.correct and slip.printed != slip.correct
            for slip in entry.misprints
        )
    )


@pytest.mark.parametrize(
    "wrong",
    [
        {"kind": "guess"},
        {"says": ledger.Words("No end")},
        {"evidence": ()},
        {"evidence": (STEPS[0], STEPS[0])},
        {"used": ""},
        {"level": "believed"},
    ],
    ids=lambda wrong: next(iter(wrong)),
)
def test_a_field_that_is_wrong_is_noticed(wrong):
    assert filled(ENTRIES[0])
    assert not filled(dataclasses.replace(ENTRIES[0], **wrong))


def test_a_misprint_that_prints_what_is_correct_is_noticed():
    entry, slip = SLIPS[0]
    same = dataclasses.replace(slip, printed=slip.correct)
    assert filled(entry)
    assert not filled(dataclasses.replace(entry, misprints=(same,)))


@pytest.mark.parametrize("paper", ledger.PARTS)
def test_an_entry_says_what_its_evidence_shows(paper):
    found = {name(entry): complaints(entry) for entry in ledger.entries(paper)}
    assert failing(found) == {}


def other_equations(entry):
    """Each equation of an entry's words with the sign of its right side turned."""
    for formula in re.findall("`([^`]+)`", entry.says.source):
        sides = re.split(r" (=|>=|<=|>|!=) ", formula)
        for k in range(2, len(sides), 2):
            wrong = "I" if sides[k] == "0" else f"-({sides[k]})"
            parts = [*sides[:k], wrong, *sides[k + 1 :]]
            source = entry.says.source.replace(formula, " ".join(parts), 1)
            yield formula, dataclasses.replace(entry, says=ledger.Words(source))


def other_fields(entry):
    """Another level; another pointer, one too many."""
    level = entry.level.replace("proved ", "proved also ", 1)
    yield entry.level, dataclasses.replace(entry, level=level)
    of_paper = [p for p in STEPS if any(e.paper == entry.paper for e in POINTERS[p])]
    foreign = [pointer for pointer in of_paper if pointer not in entry.evidence][-1]
    for k, pointer in enumerate(entry.evidence):
        before, after = entry.evidence[:k], entry.evidence[k + 1 :]
        found = (*before, foreign, *after)
        yield pointer, dataclasses.replace(entry, evidence=found)
    more = (*entry.evidence, foreign)
    yield "a pointer too many", dataclasses.replace(entry, evidence=more)


def unnoticed_fields(entry):
    """What of an entry can be wrong without a complaint."""
    wrong = [*other_equations(entry), *other_fields(entry)]
    return [what for what, damaged in wrong if complaints(damaged) == []]


@pytest.mark.parametrize("paper", ledger.PARTS)
def test_a_wrong_entry_is_noticed(paper):
    proved = [e for e in ledger.entries(paper) if "proved" in e.level]
    assert failing({name(entry): unnoticed_fields(entry) for entry in proved}) == {}


# Kinds in page order: c for a claim, d a definition, a an algorithm, n for numbers.
# A change of one is a decision, to be made here too.
KINDS = {
    "leondes_novak": "ddddddddcccdcaadddddddddccccdcdcaccdcccccccccdddcaccdccnnnacc",
    "moore": "dddccccaacddcac",
    "haddad_bernstein": "d" * 16 + "c" * 29 + "dd" + "c" * 16,
    "van_dooren": "dddcccdccccdccdccaadcannnanddcccdcdnnncc",
    "kawazoe": "ddcdadcdcccddcccacdacaddda",
    "hsia": "dnnnnn",
}


@pytest.mark.parametrize("paper", ledger.PAPERS)
def test_kinds_are_those_of_the_page(paper):
    letters = {"claim": "c", "definition": "d", "algorithm": "a", "data": "n"}
    found = {e.number: letters[e.kind] for e in ledger.entries(paper)}
    assert found == dict(zip(WANTED[paper], KINDS[paper], strict=True))


def test_what_a_kind_obliges_to():
    """Claims and algorithms are proved, numbers alone never enough; data may be."""
    for entry in ENTRIES:
        proved = not any(evidence.is_test(pointer) for pointer in entry.evidence)
        if entry.kind in ("claim", "algorithm"):
            assert proved and entry.level.startswith("proved"), name(entry)
        if "reproduced" in entry.level:
            assert entry.kind in ("data", "definition"), name(entry)


# -- evidence -----------------------------------------------------------------------


def steps_of(page):
    """{name: Claim} of all steps of a page that are evidence."""
    pointers = [pointer for pointer in STEPS if PAGE[pointer] == page]
    return {k: c for pointer in pointers for k, c in evidence.steps(pointer).items()}


@pytest.mark.parametrize("where", sorted(set(PAGE.values()) - set(PAGES)))
def test_evidence_is_proved(where):
    """On a page it is: test_everything_on_a_page_holds_and_is_used proves all of it."""
    assert [key for key, claim in steps_of(where).items() if not holds(claim)] == []


@pytest.mark.parametrize("where", sorted(set(PAGE.values())))
def test_damaged_evidence_is_not_proved(where):
    found = {key: unnoticed(claim) for key, claim in steps_of(where).items()}
    assert failing(found) == {}


# Steps that find the same expression in two places, which is what they claim.
COMPARED = re.compile(r"is (that of|\(3\.\d+\))|m1 = p: P$|P\^ = P$|, r = 1$")


def test_the_sides_are_not_the_same_to_begin_with():
    """Else SymPy has done the step before the algebra could: N M^-1 M is N to it."""
    steps = [pair for pointer in STEPS for pair in evidence.steps(pointer).items()]
    for key, claim in steps:
        if hasattr(claim, "check"):  # a chain: no line is the line before
            continue
        sides = claim.left, claim.right
        computed = any(hasattr(side, "algebra") for side in sides)
        if claim.algebra is not None and not computed and not COMPARED.search(key):
            assert claim.left != claim.right, key


@pytest.mark.parametrize("paper", ["haddad_bernstein", "moore"])
def test_claims_can_be_shown(paper):
    """Those of blocks too, which are no SymPy expressions before they are asked."""
    for entry in ledger.entries(paper)[:12]:
        for claim in evidence.steps(entry.evidence[0]).values():
            assert claim._repr_latex_().startswith("$") and " = " in repr(claim)


# Derivations that are there for the ledger; the others have tests of their own.
OURS = ("leondes_novak.stochastic_system",)


@pytest.mark.parametrize("module", OURS)
def test_every_step_is_proved_and_sensitive(module):
    found = evidence.derivation(module)
    assert found.proved() and found.source
    assert [key for key, claim in found.steps.items() if unnoticed(claim)] == []


@cache
def collected():
    """The tests of the files that are evidence, where a run leaves them out."""
    files = sorted({pointer.partition("::")[0] for pointer in TESTS})
    command = [sys.executable, "-m", "pytest", "--collect-only", "-q"]
    command += ["-o", "addopts=--import-mode=importlib"]
    run = subprocess.run(
        [*command, *files], cwd=ROOT, capture_output=True, text=True, check=True
    )
    return set(run.stdout.splitlines())


@pytest.mark.parametrize("pointer", TESTS)
def test_evidence_is_collected(pointer, request):
    here = {item.nodeid for item in request.session.items}
    assert pointer in here or pointer in collected()


# Every test that is evidence is here run with its data or its subject damaged.


def wrong_table(law, value):
    (row,) = (r.values for r in test_loop.ROWS if r.values[:2] == (law, value))
    _, _, E, samples = row
    miss = 1e-3 if law == "periodic" else 0.2
    test_loop.test_table_ii(law, value, E, samples)
    for wrong in (E * (1 - miss), E * (1 + miss)):
        with pytest.raises(AssertionError):
            test_loop.test_table_ii(law, value, wrong, samples)
    with pytest.raises(AssertionError):
        test_loop.test_table_ii(law, value, E, samples + 3)


def wrong_response(monkeypatch):
    test_loop.test_the_continuous_response_of_the_paper_in_closed_form()
    monkeypatch.setitem(loop.VALUES, y_star, -loop.VALUES[y_star])
    with pytest.raises(AssertionError):
        test_loop.test_the_continuous_response_of_the_paper_in_closed_form()


def wrong_integral(monkeypatch):
    test_loop.test_absolute_integral("series")
    sound = test_loop.absolute_integral
    wrong = lambda *args: 1.001 * sound(*args)  # noqa: E731
    monkeypatch.setattr(test_loop, "absolute_integral", wrong)
    with pytest.raises(AssertionError):
        test_loop.test_absolute_integral("series")


SPOILT = {
    "test_the_continuous_response_of_the_paper_in_closed_form": wrong_response,
    "test_absolute_integral[series]": wrong_integral,
}


@pytest.mark.parametrize("pointer", TESTS)
def test_evidence_by_test_fails_on_damaged_data(pointer, monkeypatch):
    test = pointer.partition("::")[2]
    if row := re.fullmatch(r"test_table_ii\[(\w+) ([\d.]+)\]", test):
        wrong_table(row[1], float(row[2]))
    else:
        SPOILT[test](monkeypatch)


def test_every_row_of_table_ii_is_evidence():
    rows = {
        f"tests/papers/hsia/test_loop.py::test_table_ii[{law} {value}]"
        for law, row in laws.TABLE_II.items()
        for value, _ in row
    }
    assert len(rows) == 15 and rows <= set(TESTS)


# -- what uses it, and where it is shown ----------------------------------------------


def public(used):
    """Whether a name leads to something callable that has a docstring."""
    package, *path = used.split(".")
    found = lb if package == "luenberger" else None
    for part in path:
        if part.startswith("_") or not hasattr(found, part):
            return False
        found = getattr(found, part)
    return callable(found) and bool(found.__doc__)


def test_what_uses_it_is_public():
    assert {e.used for e in ENTRIES if not public(e.used)} == set()
    assert not public("luenberger.run.nothing") and not public("luenberger.papers")


@cache
def cells(notebook):
    path = ROOT / "notebooks" / f"{notebook}.ipynb"
    found = json.loads(path.read_text(encoding="utf-8"))["cells"]
    return ["".join(cell["source"]) for cell in found]


def test_the_notebook_shows_it():
    for entry in ENTRIES:
        notebook, _, words = entry.shown.partition(": ")
        there = [k for k, cell in enumerate(cells(notebook)) if words in cell]
        assert words and len(there) == 1, f"{name(entry)} in cells {there}"


def test_levels_say_how_close_the_table_is_met():
    """What stands behind the proved part of a level."""
    levels = {e.number: e.level.partition("; ")[2] for e in ledger.entries("hsia")}
    misses = test_loop.misses()
    mean = 100 * sum(misses) / len(misses)
    close = f"{math.ceil(100 * max(misses))} per cent, {mean:.1f}"
    for law in range(1, 5):
        assert levels[f"Table II law {law}"] == f"reproduced to {close} on average"
    assert levels["(17)"] == "implemented by sampling.simulate"
    (periodic,) = ledger.entries("hsia", number="Table II periodic")
    assert periodic.level == "reproduced to 2e-5"  # as test_table_ii asks


# -- misprints ------------------------------------------------------------------------


@cache
def errata(module):
    """{place: (printed, correct)}, or of a list of (place, printed, why) the keys.

    Such a list raises by itself where a misprint is none.
    """
    found = importlib.import_module(
        "luenberger.papers.{}.derivation.{}".format(*module.split("."))
    )
    if hasattr(found, "entries"):
        return found.entries()
    return {f"{place} {printed}": None for place, printed, _ in found.misprints()}


@pytest.mark.parametrize(
    "slip", [s for _, s in SLIPS], ids=[f"{name(e)}: {s.printed}" for e, s in SLIPS]
)
def test_misprints_are_tried(slip):
    if evidence.is_test(slip.tried):
        file, _, test = slip.tried.partition("::")
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        assert test in {node.name for node in tree.body if hasattr(node, "name")}
    elif slip.tried.startswith("van_dooren.pairs: "):
        assert all(map(holds, evidence.steps(slip.tried).values()))
    else:
        module, _, place = slip.tried.partition(": ")
        if pair := errata(module)[place]:
            printed, correct = pair
            assert vanishes(correct) and not vanishes(printed)


@pytest.mark.parametrize("module", [*ERRATA, "leondes_novak.errata", "kawazoe.errata"])
def test_every_misprint_that_is_tried_is_in_the_ledger(module):
    listed = {slip.tried.partition(": ")[2] for _, slip in SLIPS}
    assert errata(module).keys() - listed == set()


# -- the checks themselves ------------------------------------------------------------

X = sp.Matrix(2, 2, sp.symbols("x:4"))


@pytest.mark.parametrize(
    "pointer",
    [
        "nowhere: (13) P T + V C = I",
        "leondes_novak.huddle: (13) P T",
        "leondes_novak.huddle.nothing: (13) P T + V C = I",
        "leondes_novak.huddle",
    ],
)
def test_a_dangling_pointer_is_an_error(pointer):
    with pytest.raises(LookupError):
        evidence.steps(pointer)


def test_a_bare_residual_is_no_evidence(monkeypatch):
    bare = dataclasses.replace(huddle.page, steps={"(0) bare": sp.zeros(2)})
    monkeypatch.setattr(evidence, "derivation", lambda name: bare)
    with pytest.raises(TypeError, match="not a Claim"):
        evidence.steps("leondes_novak.huddle: (0) bare")


@pytest.mark.parametrize(
    "claim",
    [Claim(sp.zeros(2), sp.zeros(2)), Claim(sp.S.Zero, sp.S.Zero)],
    ids=["zero matrices", "zero"],
)
def test_a_claim_that_nothing_can_damage_is_noticed(claim):
    assert claim.is_zero and unnoticed(claim)


@pytest.mark.parametrize("claim", [Claim(X, X), Claim(X[0] + X[1], X[1] + X[0])])
def test_a_claim_with_something_in_it_is_sensitive(claim):
    assert claim.is_zero and unnoticed(claim) == []
    assert all(not wrong.is_zero for _, wrong in broken(claim))


def test_a_step_is_named_in_full_or_up_to_its_sizes(monkeypatch):
    names = ("(12) zero", "(12) zero, r = 2", "(12) zero, r = 3", "(12) zeros")
    steps = {name: Claim(X, X) for name in names[1:]}
    sized = dataclasses.replace(huddle.page, page=(), steps=steps)
    monkeypatch.setattr(evidence, "derivation", lambda name: sized)
    assert list(evidence.steps("huddle: (12) zero")) == list(names[1:3])
    assert list(evidence.steps("huddle: (12) zero, r = 2")) == [names[1]]


# -- rendering ------------------------------------------------------------------------


def test_papers_are_found_by_part_of_their_name():
    assert ledger.find_paper("Haddad") == "haddad_bernstein"
    assert ledger.find_paper("van-dooren") == "van_dooren"
    for wrong in ("luenberger", "", "19"):
        with pytest.raises(ValueError, match="give one of 'leondes_novak'"):
            ledger.entries(wrong)


def test_counts_agree():
    assert ledger.count() == len(ENTRIES) == sum(map(ledger.count, ledger.PARTS))
    *papers, total = ledger.summary().rows
    assert [row[0] for row in papers] == [ledger.title(p) for p in ledger.PARTS]
    for column in range(1, len(total)):
        assert sum(int(row[column]) for row in papers) == int(total[column])
    assert len(ledger.misprint_table().rows) == len(ledger.misprints())


def test_tables_hold_every_entry():
    assert [row[1] for row in ledger.table().rows] == [e.number for e in ENTRIES]
    moore = ledger.table("moore")
    assert [row[0] for row in moore.rows] == WANTED["moore"]
    assert "TA" not in repr(moore) and "T A = F T + D C" in repr(moore)


def test_words_are_set_wherever_they_are_shown():
    (gain,) = ledger.entries("leondes", number="(37)")
    assert str(gain.says) == repr(gain.says) == gain.as_dict()["says"]
    assert str(gain.says).endswith("K₁ = Ω₂₁ (Ω₁₁ + R₁₁)⁻¹.")
    assert r"$K_{1} = \Omega_{21}" in gain.says._repr_markdown_()
    row = ledger.table("leondes").markup[36]
    assert row[1] == gain.says._repr_html_() and r'<span class="math">\(K_{1}' in row[1]


def test_tables_are_folded_by_paper():
    folded = ledger.by_paper()
    assert repr(folded).splitlines()[1] == "Moore (1973): 15 entries"
    markup = folded._repr_html_()
    assert markup.count("<details>") == len(ledger.PARTS)
    assert markup.count("<tr><td>") == ledger.count()


def test_entries_are_plain_data():
    text = json.dumps([entry.as_dict() for entry in ENTRIES])
    assert json.loads(text)[32]["misprints"][0]["printed"] == "[Omega21 | Omega22 H2]"


@pytest.fixture(scope="module")
def page(tmp_path_factory):
    """The page of all papers, without the formulas."""
    path = tmp_path_factory.mktemp("page") / "ledger.html"
    path.write_text("old", encoding="utf-8")
    ledger.write_page(path, formulas=False)
    assert [file.name for file in path.parent.iterdir()] == ["ledger.html"]
    return path.read_text(encoding="utf-8")


@pytest.fixture(scope="module")
def one_paper(tmp_path_factory):
    """The page of one paper, with its formulas."""
    path = tmp_path_factory.mktemp("page") / "leondes.html"
    ledger.write_page(path, "leondes")
    return path.read_text(encoding="utf-8")


@pytest.mark.parametrize("which", ["page", "one_paper"])
def test_the_page_asks_for_nothing(which, request):
    text = request.getfixturevalue(which)
    assert "default-src 'none'; style-src 'unsafe-inline'" in text
    plain = text.replace("http://www.w3.org/1998/Math/MathML", "")  # a name, no link
    assert not re.search(r"<script|<link|\bsrc=|\bhref=|https?:|@import|url\(", plain)


def rows_of(text):
    """The rows of the table; the page must be well formed for that."""
    body = re.sub(r"<(meta|input|br)\b([^>]*)>", "", text.partition("<body>")[2])
    tree = ET.fromstring(f"<body>{body.partition('</body>')[0]}</body>")
    return [row for row in tree.iter("tr") if row.get("class")]


def test_the_page_holds_every_entry(page):
    rows = rows_of(page)
    assert len(rows) == len(ENTRIES)
    for row, entry in zip(rows, ENTRIES):
        text = " ".join(row.itertext())
        assert entry.number in text and str(entry.says) in text
        assert entry.used.removeprefix("luenberger.") in text
        assert all(slip.correct in text for slip in entry.misprints)
        assert all(pointer in text for pointer in entry.evidence)
        assert entry.paper in row.get("class").split()


def test_the_page_has_the_formulas(one_paper):
    rows = rows_of(one_paper)
    assert [len(rows), one_paper.count('type="radio"')] == [61, 2]
    drawn = sum(any("math" in node.tag for node in row.iter()) for row in rows)
    assert drawn > 40


@pytest.fixture(scope="module")
def shown(page):
    """What the page's style sheet leaves visible for a choice: rows, and counts."""
    bare = re.sub(r"(?s)<td>.*?(?=</tr>)", "", page)  # no rule is about what is in rows
    tree = BeautifulSoup(bare, "html.parser")
    rules = re.findall(r"^(.+) \{ display: (none|block); \}$", page, re.M)
    rows, counts = tree.select("tr.entry"), tree.select(".count")

    def visible(paper, slips=False):
        for box in tree.find_all("input"):
            box.attrs.pop("checked", None)
        for chosen in [paper, "slips"] if slips else [paper]:
            tree.find(id=chosen)["checked"] = ""
        hidden = set()
        for selector, display in rules:
            found = {id(x) for x in tree.select(selector)}
            hidden = hidden | found if display == "none" else hidden - found
        return [
            [x.get_text() for x in some if id(x) not in hidden]
            for some in (rows, counts)
        ]

    return visible


@pytest.mark.parametrize("paper", ["all", *ledger.PARTS])
def test_the_page_is_filtered_without_a_script(shown, paper):
    chosen = None if paper == "all" else paper
    rows, counts = shown(paper)
    assert len(rows) == ledger.count(chosen)
    (said,) = counts
    assert said.startswith(f"{len(rows)} entries, {len(ledger.misprints(chosen))} ")
    rows, _ = shown(paper, slips=True)
    assert len(rows) == sum(bool(e.misprints) for e in ledger.entries(chosen))


def test_an_interrupted_page_leaves_the_old_one(tmp_path, monkeypatch):
    path = tmp_path / "ledger.html"
    path.write_text("old", encoding="utf-8")

    def full(*_):
        raise OSError("no space left on device")

    monkeypatch.setattr("os.replace", full)
    with pytest.raises(OSError, match="no space"):
        ledger.write_page(path, "hsia", formulas=False)
    assert [file.read_text() for file in tmp_path.iterdir()] == ["old"]
