"""The ledger: complete, in the words of the pages, and no evidence survives damage."""

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
from bs4 import BeautifulSoup
from damage import broken, damaged_sides
from page_damage import cited_instead, definitions
from sympy import Matrix, symbols

import luenberger as lb
from luenberger import ledger
from luenberger.ledger import evidence
from luenberger.ledger import page as page_module
from luenberger.ledger.statements import (
    Statement,
    carried,
    ends,
    level,
    number_of,
    numbers,
)
from luenberger.papers.hsia.derivation import laws, loop
from luenberger.papers.hsia.derivation.loop import y_star
from matrixproof import (
    Chain,
    Derivation,
    Expect,
    Explicit,
    Line,
    MatrixSymbol,
    Relation,
    latex,
    text,
)
from matrixproof.derivation import holds, vanishes
from matrixproof.explicit import Counterexample
from matrixproof.lines import AtLeast, Equation, Iff
from matrixproof.operators import Transposed
from matrixproof.relations import Let, Moment
from tests.papers.hsia import test_loop

ROOT = Path(__file__).parents[2]
ENTRIES = ledger.entries()
TESTS = list(dict.fromkeys(test for entry in ENTRIES for test in entry.tests))
PAGES = list(dict.fromkeys(page for entry in ENTRIES for page in entry.pages))
SLIPS = [(e, slip) for e, slip in ledger.misprints() if slip.tried]
ERRATA = ("haddad_bernstein.errata", "moore.errata", "van_dooren.errata")


def name(entry):
    return f"{entry.paper} {entry.number}"


def spans(*spans):
    return [f"({k})" for first, last in spans for k in range(first, last + 1)]


WANTED = {
    "leondes_novak": [
        *(*spans((1, 44)), "after (44)", *spans((45, 53)), "after (53)"),
        *(*spans((54, 58)), "Fig. 3"),
    ],
    "moore": [*spans((1, 13)), "after (13): l", "after (13): signs"],
    "haddad_bernstein": [
        *(f"section 2: {x}" for x in ("tau_perp", "A~", "A~_i", "w~", "V~", "R~")),
        *(f"section 2: {x}" for x in ("pi_i", "V2s", "Qs")),
        *(f"section 2: {x}, n_e = n" for x in ("V2s", "Qs")),
        *(*(f"(3.{k})" for k in range(1, 6)), "lemma 3.1"),
        *(f"(3.{k})" for k in range(6, 10)),
        *("section 3: D(Q, P)", "theorem 3.1", "(3.10)", "(3.10)'"),
        *(f"(3.{k})" for k in range(11, 19)),
        *(f"remark 3.{k}" for k in range(2, 6)),
        *("(3.19)", "(3.20)", "after (3.20)", "corollary 3.1"),
        *(f"(3.{k})" for k in range(21, 28)),
        *("remark 3.6", "(4.1)", "(4.2)", "(4.3)", "lemma 4.1"),
        *("(4.4)", "(4.5)", "after (4.5)"),
        *(f"(4.{k})" for k in range(6, 12)),
        *("section 4: hats", *(f"(4.{k})" for k in range(12, 17))),
    ],
    "van_dooren": [
        *("(1)", "(2)", "(3)", "theorem 1", *spans((4, 12)), "remark 1"),
        *(*spans((13, 21)), "after (21)", *spans((22, 33)), "after (33)", "(34)"),
        *("remark 2(a)", "remark 2(b)", "remark 2(c)"),
    ],
    "kawazoe": spans((1, 26)),
    "hsia": ["(17)", "Table II periodic", *(f"Table II law {k}" for k in range(1, 5))],
}


# -- complete -----------------------------------------------------------------------


@pytest.mark.parametrize("paper", ledger.PAPERS)
def test_every_equation_has_one_entry_in_page_order(paper):
    assert [e.number for e in ledger.entries(paper)] == WANTED[paper]


def modules():
    """ "room.module" of every page in the library."""
    for room in evidence.ROOMS:
        folder = Path(importlib.import_module(evidence.package(room)).__file__).parent
        for path in sorted(folder.glob("*.py")):
            if "\npage = " in path.read_text("utf-8"):
                yield f"{room}.{path.stem}"


def test_every_page_carries_numbers_or_is_an_entry_of_our_own():
    ours = [page for e in ledger.entries(ledger.OURS) for page in e.pages]
    papers = {p for key in ledger.PAPERS for e in ledger.entries(key) for p in e.pages}
    assert sorted([*ours, *papers]) == sorted(modules())


@pytest.mark.parametrize("paper", ledger.PAPERS)
def test_every_number_on_a_page_of_a_paper_has_an_entry(paper):
    """And the entry has all that stands under it, unless it is about one letter."""
    found = ledger.entries(paper)
    labels = {label for e in found for label in e.labels}
    whole = {e.labels[0]: e for e in found if not e.about and len(e.labels) == 1}
    for page in dict.fromkeys(page for entry in found for page in entry.pages):
        for item in evidence.derivation(page).page:
            for number in numbers(number_of(item)) if not words(item) else ():
                assert number in labels, (page, number)
                entry = whole.get(number)
                if entry and page in entry.pages:
                    assert str(Statement(page, item)) in map(str, entry.says)


def words(item):
    """Whether it is no statement."""
    return not isinstance(item, Relation) and not hasattr(item, "number")


def test_fields_are_filled():
    for e in ENTRIES:
        assert e.evidence and len(set(e.evidence)) == len(e.evidence), name(e)
        assert e.says or e.words and e.tests, name(e)
        assert bool(e.tests) == bool(e.reproduced), name(e)
        assert e.level and all(slip.kind in ledger.KINDS for slip in e.misprints)
        assert all(
            s.printed and s.correct and s.printed != s.correct for s in e.misprints
        )


# -- what is read off a page ----------------------------------------------------------

n = symbols("n", integer=True, positive=True)
A, B, X = (MatrixSymbol(letter, n, n) for letter in "ABX")
x, w = (MatrixSymbol(letter, n, 1) for letter in "xw")
means = Let("(2) X = A B", X, A * B)
MEAN = Moment("(1) E[w w'] = B", w * w.T, B)
PROVED = Chain("1–3, 7", "a product", A * X, [Line(A * A * B, by=[means])])
SWAP = {A: Matrix([[0, 1], [1, 0]])}
AT_TWO = Explicit("3", "a swap", A * A, A**2, {"n = 2": SWAP})
AT_ALL = Explicit("3", "a sum", n + n, 2 * n)
DENIED = Counterexample("3", "not so", A * B, B * A, {A: Matrix([[1]])})


@pytest.mark.parametrize(
    ("item", "shown"),
    [
        (means, "X = A B"),
        (MEAN, "E[w w'] = B"),
        (PROVED, "A X = A A B"),
        (Chain("", "", x * x.T, [Expect(A, moments=[MEAN])]), "E[x x'] = A"),
        (Chain("", "", B.T * A.T, [Transposed(A * B)]), "[B' A']' = A B"),
        (Chain("", "", A * A.T + B, [AtLeast(B, root=A)]), "A A' + B ≥ B"),
        (Chain("", "", Equation(A, B), [Iff(Equation(B, A))]), "A = B ⇔ B = A"),
        (AT_TWO, "A A = A²"),
        (DENIED, "A B ≠ B A"),
    ],
    ids=lambda value: type(value).__name__ if not isinstance(value, str) else value,
)
def test_a_statement_shows_both_ends(item, shown):
    assert " ".join(ends(item, text)) == shown
    assert shown in str(Statement("", item)) and ends(item, latex)


def test_a_page_is_asked_by_number():
    page = Derivation(page=("Words.", means, PROVED, AT_TWO), letters=None)
    assert [one.item for one in carried(page, "2")] == [means, PROVED]
    assert [one.item for one in carried(page, "7")] == [PROVED]
    assert [one.item for one in carried(page, "2", about="X")] == [means]
    assert carried(page, "4") == ()
    assert numbers("9, 14, 15") == {"9", "14", "15"} and numbers("") == set()
    assert numbers("remark 2(a), 41–43") == {"remark 2(a)", "41", "42", "43"}


@pytest.mark.parametrize(
    ("items", "says"),
    [
        ([means], "a definition"),
        ([means, MEAN], "a supposition"),
        ([means, PROVED], "proved at symbolic sizes"),
        ([PROVED, AT_TWO], "proved at symbolic sizes, and at n = 2"),
        ([AT_TWO], "proved at n = 2"),
        ([AT_ALL], "proved for all values of the symbols"),
        ([DENIED], "proved by a counterexample"),
    ],
)
def test_a_level_says_where_something_is_proved(items, says):
    assert level([Statement("", item) for item in items]) == says


def test_many_cases_are_counted():
    cases = {f"n = {k}": SWAP for k in range(3)}
    many = dataclasses.replace(AT_TWO, cases=cases)
    assert level([Statement("", many)]) == "proved at 3 cases from n = 0 to n = 2"


def test_what_two_pages_say_is_said_once_and_a_definition_has_what_rests_on_it():
    (start,) = ledger.entries("leondes", number="(12)")
    assert [str(one) for one in start.says].count("let x̂ = P z + V y + W u") == 1
    (moves,) = ledger.entries("moore", number="(3)")
    assert moves.level == "a definition" and moves.proofs
    assert all(not one.proved for one in moves.says)
    (least,) = ledger.entries("leondes", number="(37)")
    assert str(least.says[0]) == "the gain of least order: K₁ = Ω₂₁ (Ω₁₁ + R₁₁)⁻¹"


def test_what_is_done_where_M_is_singular_has_an_entry():
    (entry,) = ledger.entries("ours", number="gain where M is singular")
    assert "the gain where the covariance is singular: K_mv M = N" in str(entry.says)


# -- damage ---------------------------------------------------------------------------


def instead(page, pairs):
    """A page with other items in place of some."""
    other = dict(pairs)
    items = (other.get(id(item), item) for item in page.page)
    return dataclasses.replace(page, page=tuple(items), steps={})


def damaged(page):
    """(what is damaged, its page) with one sign wrong, for each item with a number."""
    for item in page.page:
        if words(item) or isinstance(item, Relation):
            continue
        _, wrong = next(broken(item))
        yield item, instead(page, [(id(item), wrong)])
    for relation in definitions(page):
        _, right = next(damaged_sides(relation.right))
        wrong = dataclasses.replace(relation, right=right)
        says = relation.name.replace(relation.show(text), wrong.show(text))
        wrong = dataclasses.replace(wrong, name=says)
        changed = cited_instead(page, relation, wrong)
        pairs = [(id(found), other) for other, found in changed]
        yield relation, instead(page, [(id(relation), wrong), *pairs])


@pytest.mark.parametrize("where", PAGES)
def test_a_turned_sign_on_a_page_is_no_proof_in_the_ledger(where, monkeypatch):
    """One for each proof, and for each definition: what rests on it is not proved."""
    sound = evidence.derivation
    concerned = [entry for entry in ENTRIES if where in entry.pages]
    assert not any(entry.check() for entry in concerned)
    for item, wrong in damaged(sound(where)):
        asked = [e for e in concerned if any(one.item is item for one in e.says)]
        if isinstance(item, Relation):  # another one is no longer about a letter
            asked = [entry for entry in asked if not entry.about]
        pages = {where: wrong}
        other = lambda page, pages=pages: pages.get(page) or sound(page)  # noqa: E731
        monkeypatch.setattr(evidence, "derivation", other)
        for entry in asked[:1]:
            assert refused(dataclasses.replace(entry)), (name(entry), item)


def refused(entry):
    """Whether an entry is said not to be proved, or cannot even be read."""
    try:
        return entry.check() != []
    except (ValueError, TypeError):
        return True


# -- tests that are evidence ----------------------------------------------------------


@cache
def collected():
    """The tests of the files that are evidence, where a run leaves them out."""
    files = sorted({test.partition("::")[0] for test in TESTS})
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


# Each is here run with its data or its subject damaged.


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
        if entry.shown:
            notebook, _, said = entry.shown.partition(": ")
            there = [k for k, cell in enumerate(cells(notebook)) if said in cell]
            assert said and len(there) == 1, f"{name(entry)} in cells {there}"


def test_levels_say_how_close_the_table_is_met():
    """What stands behind the proved part of a level."""
    levels = {e.number: e.reproduced for e in ledger.entries("hsia")}
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
    if slip.tried.startswith("tests/"):
        file, _, test = slip.tried.partition("::")
        tree = ast.parse((ROOT / file).read_text(encoding="utf-8"))
        assert test in {node.name for node in tree.body if hasattr(node, "name")}
        return
    module, _, place = slip.tried.partition(": ")
    if "errata" not in module:
        assert holds(evidence.derivation(module).steps[place])
    else:
        if pair := errata(module)[place]:
            printed, correct = pair
            assert vanishes(correct) and not vanishes(printed)


@pytest.mark.parametrize("module", [*ERRATA, "leondes_novak.errata", "kawazoe.errata"])
def test_every_misprint_that_is_tried_is_in_the_ledger(module):
    listed = {slip.tried.partition(": ")[2] for _, slip in SLIPS}
    assert errata(module).keys() - listed == set()


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
    for row, (paper, total, *levels) in zip(
        ledger.summary().rows, ledger.levels().rows
    ):
        assert [paper, total] == row[:2] and sum(map(int, levels)) == int(total)


def test_levels_are_counted():
    *_, explicit, by_numbers = ledger.levels().rows[-1]
    evaluated = [
        e
        for e in ENTRIES
        if "proved" in e.level and not e.level.startswith("proved at symbolic sizes")
    ]
    example = [e for e in evaluated if e.level == "proved by a counterexample"]
    assert int(explicit) == len(evaluated) - len(example) > 10
    assert int(by_numbers) == sum(not entry.says for entry in ENTRIES)


def test_tables_hold_every_entry():
    assert [row[1] for row in ledger.table().rows] == [e.number for e in ENTRIES]
    moore = ledger.table("moore")
    assert [row[0] for row in moore.rows] == WANTED["moore"]
    assert "TA" not in repr(moore) and "T A = F T + D C" in repr(moore)


def test_statements_are_set_wherever_they_are_shown():
    (gain,) = ledger.entries("leondes", number="(37)")
    assert str(gain.says) == repr(gain.says) == "; ".join(gain.as_dict()["says"])
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
        assert entry.number in text and entry.level in text
        assert all(str(one) in text for one in entry.says)
        assert entry.used_by in text
        assert all(slip.correct in text for slip in entry.misprints)
        assert all(pointer in text for pointer in entry.evidence)
        assert entry.paper in row.get("class").split()


def test_the_page_has_the_formulas(one_paper):
    rows = rows_of(one_paper)
    assert [len(rows), one_paper.count('type="radio"')] == [61, 2]
    for row, entry in zip(rows, ledger.entries("leondes")):
        proofs = [one for one in entry.says if one.proved]
        folded = [node for node in row.iter() if node.tag == "details"]
        assert len(folded) == len(proofs) + 1  # and the evidence
        assert any("math" in node.tag for node in row.iter())
    assert "✗" not in one_paper and "not proved" not in one_paper


def test_the_page_says_what_is_not_proved(monkeypatch, tmp_path):
    (entry,) = ledger.entries("hsia", number="(17)")
    item = entry.says[0].item
    wrong = dataclasses.replace(item, right=2 * item.right)
    pages = {page: evidence.derivation(page) for page in entry.pages}
    pages["hsia.loop"] = instead(pages["hsia.loop"], [(id(item), wrong)])
    monkeypatch.setattr(evidence, "derivation", pages.get)
    other = dataclasses.replace(entry)
    monkeypatch.setattr(page_module, "entries", lambda key: [other])
    ledger.write_page(tmp_path / "ledger.html", "hsia")
    text = (tmp_path / "ledger.html").read_text(encoding="utf-8")
    assert text.count("✗</summary>") == 1
    assert f"not proved: {entry.says[0].pointer}: the sides differ" in text


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
