"""The pages: complete, without a request to anywhere, without a dead link."""

import collections
import html
import inspect
import json
import pathlib
import re
import tomllib
import urllib.parse
from html.parser import HTMLParser

import pytest
from site_build import COMMAND, ROOT

import luenberger as lb
from luenberger import ledger

NOTEBOOKS = sorted((ROOT / "notebooks").glob("[0-9]*.ipynb"))
ASSIGNMENTS = sorted((ROOT / "notebooks" / "coursework" / "source").glob("*/*.ipynb"))
MARK = re.compile(r"&& \(?\\(?:checkmark|times)\b")
REGION = re.compile(r"### BEGIN (\w+)[^\n]*\n(.*?)\n[^\n]*### END \1", re.S)
QUIET = {"code", "pre", "script", "style", "textarea", "title"}
VOID = {"area", "base", "br", "col", "embed", "hr", "img", "input", "link", "meta"}
LOADING = {("link", "href"), ("use", "href"), ("object", "data"), ("form", "action")}


class Page(HTMLParser):
    """What a page loads, links to, can be linked to, shows and says."""

    def __init__(self, text):
        super().__init__()
        self.loads, self.links, self.names, self.images = [], [], set(), []
        self.styles, self.words, self.mathematics, self.open = [], [], [], []
        self.feed(text)
        self.close()

    def handle_starttag(self, tag, attributes):
        given = dict(attributes)
        math = "math" in given.get("class", "").split()
        if tag not in VOID:
            self.open.append((tag, math))
        if math:
            self.mathematics.append([tag, ""])
        self.names |= {given.get("id"), given.get("name")} - {None}
        if tag == "a" and "href" in given:
            self.links.append(given["href"])
        if tag == "img":
            self.images.append((given.get("src", ""), given.get("alt", "")))
        for name, value in given.items():
            if name in ("src", "srcset", "poster") or (tag, name) in LOADING:
                self.loads.append(value or "")
            if name == "style":
                self.styles.append(value or "")

    def handle_endtag(self, tag):
        while self.open and self.open.pop()[0] != tag:
            pass

    def handle_data(self, data):
        tags = [tag for tag, _ in self.open]
        if "style" in tags:
            self.styles.append(data)
        if any(math for _, math in self.open):
            self.mathematics[-1][1] += data
        elif not QUIET.intersection(tags):
            self.words.append(data)


def outside(page):
    """What a page would fetch from elsewhere; a link that a reader follows is none."""
    styles = (url for style in page.styles for url in fetched_by(style))
    return [url for url in [*page.loads, *styles] if is_outside(url)]


def fetched_by(style):
    yield from re.findall(r"url\(\s*['\"]?([^'\")]+)", style)
    yield from re.findall(r"@import\s+['\"]([^'\"]+)", style)


def is_outside(url):
    parts = urllib.parse.urlsplit(url)
    return bool(parts.netloc) or parts.scheme not in ("", "data")


def dead(path, page, pages):
    """Links and files that a page of `pages` (path: Page) names and that are not."""
    for url in [*page.links, *page.loads]:
        parts = urllib.parse.urlsplit(url)
        if parts.scheme or parts.netloc:
            continue
        where = path.parent / urllib.parse.unquote(parts.path) if parts.path else path
        where = pathlib.Path(*where.parts).resolve()
        if not where.is_file():
            yield f"{url}: no such file"
        elif parts.fragment and where in pages:
            anchor = urllib.parse.unquote(parts.fragment)
            if anchor not in pages[where].names:
                yield f"{url}: no such place"


def unset(page):
    """Mathematics that MathJax would not find, or not understand."""
    for _, formula in page.mathematics:
        inline = formula.startswith(r"\(") and formula.endswith(r"\)")
        if not inline and not (r"\[" in formula and r"\]" in formula):
            yield formula
        if "$" in formula or formula.count("{") != formula.count("}"):
            yield formula
    for words in page.words:
        if re.search(r"\$|\\(?:[(\[]|begin|frac|operatorname|tag)", words):
            yield words.strip()


def wordless(page):
    """Images without words for who cannot see them."""
    return [source[:60] for source, words in page.images if len(words) < 30]


def answers(notebook):
    """The lines of an assignment that no student may read."""
    for cell in notebook["cells"]:
        for _, region in REGION.findall("".join(cell["source"])):
            yield from (line.strip() for line in region.splitlines())


def slug(entry):
    """The end of an entry's addresses."""
    number = entry.number.replace("'", " prime ")
    words = f"{entry.paper} {number}".lower()
    return re.sub("[^a-z0-9]+", "-", words).strip("-")


def leaked(text, secrets):
    return sorted(line for line in secrets if len(line) > 24 and line in text)


def displayed(notebook):
    """How many displayed formulas a notebook shows, in its prose and its outputs."""
    count = 0
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            prose = re.sub(r"```.*?```", "", "".join(cell["source"]), flags=re.S)
            count += prose.count("$$") // 2
        for output in cell.get("outputs", ()):
            data = output.get("data", {})
            formula = "text/latex" in data and "text/html" not in data
            count += formula and not marks(data)  # a chain is rows, see below
    return count


def marks(data):
    """How many lines with a mark an output of a cell holds."""
    return len(MARK.findall("".join(data.get("text/latex", ""))))


# -- the pages -------------------------------------------------------------------------


@pytest.fixture(scope="module")
def pages(site):
    files = [f for f in sorted(site.rglob("*.html")) if "_static" not in f.parts]
    return {path.resolve(): Page(path.read_text(encoding="utf-8")) for path in files}


@pytest.mark.site
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_is_a_page_with_all_its_formulas(path, site, pages):
    page = pages[(site / f"{path.stem}.html").resolve()]
    notebook = json.loads(path.read_text(encoding="utf-8"))
    blocks = [formula for tag, formula in page.mathematics if tag == "div"]
    assert len(blocks) == displayed(notebook)


@pytest.mark.site
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_every_line_of_a_chain_is_a_row_with_its_mark(path, site, pages):
    cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
    outputs = [output for cell in cells for output in cell.get("outputs", ())]
    text = (site / f"{path.stem}.html").read_text(encoding="utf-8")
    wanted = sum(marks(output.get("data", {})) for output in outputs)
    assert text.count('<p class="checked">') == wanted
    assert not MARK.search(html.unescape(text))


@pytest.mark.site
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_numbered_equations_have_addresses_and_are_linked(path, site, pages):
    page = pages[(site / f"{path.stem}.html").resolve()]
    tags = re.findall(r"\\\\tag\{([^}]*)\}", path.read_text(encoding="utf-8"))
    addresses = {name for name in page.names if name.startswith("equation-")}
    assert len(addresses) == len(tags)
    assert all(r"\tag" not in formula for _, formula in page.mathematics)
    if tags:
        assert any(link.removeprefix("#") in addresses for link in page.links)


@pytest.mark.site
def test_nothing_is_left_beside_the_pages(site):
    assert not (site.parent / "jupyter_execute").exists()


def test_nothing_is_fetched_from_elsewhere(site, pages):
    found = {path: outside(page) for path, page in pages.items()}
    assert not {path: urls for path, urls in found.items() if urls}
    for style in site.rglob("*.css"):
        urls = fetched_by(style.read_text(encoding="utf-8"))
        assert not [url for url in urls if is_outside(url)], style.name


@pytest.mark.site
def test_no_link_is_dead(pages):
    found = {path: list(dead(path, page, pages)) for path, page in pages.items()}
    assert not {path: urls for path, urls in found.items() if urls}


@pytest.mark.site
def test_all_mathematics_is_set(pages):
    found = {path: list(unset(page)) for path, page in pages.items()}
    assert not {path: texts for path, texts in found.items() if texts}
    formulas = [formula for page in pages.values() for _, formula in page.mathematics]
    assert len(formulas) > 1000
    assert not [f for f in formulas if f.count(r"\begin{") != f.count(r"\end{")]


@pytest.mark.site
def test_every_image_has_words(pages):
    found = {path: wordless(page) for path, page in pages.items()}
    assert not {path: images for path, images in found.items() if images}
    assert sum(len(page.images) for page in pages.values()) > 20


@pytest.mark.site
def test_search_finds_terms(site):
    text = (site / "searchindex.js").read_text(encoding="utf-8")
    index = json.loads(text.removeprefix("Search.setIndex(").removesuffix(")"))
    stems = {"staircas": "05-staircase-observer", "deadbeat": "06-canonical-form"}
    for stem, wanted in stems.items():
        hits = index["terms"].get(stem, []), index["titleterms"].get(stem, [])
        places = {k for hit in hits for k in (hit if isinstance(hit, list) else [hit])}
        assert any(index["docnames"][k].startswith(wanted) for k in places)
    assert {path.stem for path in NOTEBOOKS} <= set(index["docnames"])


@pytest.mark.site
def test_the_ledger_is_a_page(site):
    text = (site / "pages" / "ledger.html").read_text(encoding="utf-8")
    rows = re.findall(r'<tr class="[^"]*\bentry of-(\w+)', text)
    assert collections.Counter(rows) == {p: ledger.count(p) for p in ledger.PARTS}


@pytest.mark.site
def test_each_misprint_leads_to_its_evidence(site):
    text = (site / "pages" / "misprints.html").read_text(encoding="utf-8")
    cards = re.split(r'<div class="entry misprint', text)[1:]
    assert len(cards) == len(ledger.misprints())
    for card, (entry, slip) in zip(cards, ledger.misprints(), strict=True):
        assert bool(entry.shown) == ("#shown-" in card)
        assert "ledger.html#ledger-" in card
        tried = slip.tried and not slip.tried.startswith("tests/")
        assert bool(tried) == ("#tried-" in card or "#step-" in card)


@pytest.mark.site
@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_the_ledger_leads_to_the_very_equation(path, site):
    text = (site / f"{path.stem}.html").read_text(encoding="utf-8")
    for entry in ledger.entries():
        notebook, _, words = entry.shown.partition(": ")
        if notebook == path.stem and words.startswith(r"\tag"):
            before, after = text.split(f'id="shown-{slug(entry)}"')
            around = re.split("<p[ >]", before)[-1] + re.split("<p[ >]", after)[0]
            assert 'id="equation-' in around, entry.number


@pytest.mark.site
def test_every_public_name_has_its_reference(pages):
    public = [name for name in lb.__all__ if not inspect.ismodule(getattr(lb, name))]
    described = {name for page in pages.values() for name in page.names}
    assert "certify" in public
    assert {f"luenberger.{name}" for name in public} <= described


@pytest.mark.site
def test_docstrings_are_read_as_meant(site):
    """No half of a property's sentence is its type, no name that of another."""
    for path in (site / "pages" / "api").glob("*.html"):
        text = path.read_text(encoding="utf-8")
        assert "Type<span" not in text, path.name
        assert not re.findall(r"\(<em>\w+,[^<]*</em>\)", text), path.name


@pytest.mark.site
def test_derivations_say_what_is_defined_supposed_and_steady(site):
    folder = site / "pages" / "derivations"
    text = (folder / "haddad-bernstein.html").read_text(encoding="utf-8")
    for word in ("Let", "Suppose", "Steady:"):
        assert f"<span>{word} <span" in text
    assert "What follows does not rest on <span" in text


@pytest.mark.site
def test_derivations_lead_to_their_source(site):
    rooms = "luenberger/**/derivation/*"
    sources = {
        path.relative_to(site / "_modules").with_suffix("")
        for path in site.glob(f"_modules/{rooms}.html")
    }
    modules = (ROOT / "lib").glob(f"{rooms}.py")
    modules = {path.relative_to(ROOT / "lib").with_suffix("") for path in modules}
    left_out = {path.name for path in modules - sources}
    assert len(modules) > 60
    assert left_out <= {"__init__", "letters"}  # shown where they are used


@pytest.mark.site
def test_no_solution_of_the_coursework_is_among_them(site):
    secrets = {
        line
        for path in ASSIGNMENTS
        for line in answers(json.loads(path.read_text(encoding="utf-8")))
    }
    assert secrets
    kept = [path for path in site.rglob("*.ipynb") if "coursework" in path.parts]
    assert not kept
    for path in [site / "pages" / "coursework.html", *site.glob("coursework/*.html")]:
        assert not leaked(html.unescape(path.read_text("utf-8")), secrets)
    index = (site / "searchindex.js").read_text(encoding="utf-8")
    assert "coursework/source" not in index


def test_contributors_build_them_so():
    said = (ROOT / ".github" / "CONTRIBUTING.md").read_text(encoding="utf-8")
    assert f".venv/bin/python {' '.join(COMMAND)} notebooks site\n" in said


# -- the checks themselves -------------------------------------------------------------

SOUND = """<html><body id="top"><h1>Title</h1><a href="#top">up</a>
<a href="https://doi.org/10.1109/">cited</a><script src="a.js"></script>
<div class="math">\\[x = 1 \\]</div><p>so <span class="math">\\(x\\)</span></p>
<pre>$ ls</pre><img src="a.js" alt="Two curves against time, both of which decay.">
"""


def checked(folder, text):
    """All that the checks say of a page."""
    (folder / "a.js").write_text("")
    path = (folder / "page.html").resolve()
    path.write_text(text)
    page = Page(text)
    return [
        *outside(page),
        *dead(path, page, {path: page}),
        *unset(page),
        *wordless(page),
    ]


def test_a_sound_page_passes(tmp_path):
    assert checked(tmp_path, SOUND) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ('src="a.js"', 'src="https://cdn.example.org/a.js"'),
        ('src="a.js"', 'src="//cdn.example.org/a.js"'),
        ("<h1>", '<h1 style="background: url(https://example.org/a.png)">'),
        ("<h1>", '<link rel="stylesheet" href="https://fonts.example.org/">'),
        ("<h1>", "<style>@import 'https://fonts.example.org/css';</style><h1>"),
        ('href="#top"', 'href="#bottom"'),
        ('href="#top"', 'href="elsewhere.html"'),
        ("<p>so", "<p>so $y = 2$"),
        ("<p>so", "<p>so \\begin{bmatrix} 1 \\end{bmatrix}"),
        ("\\[x = 1 \\]", "x = 1"),
        ("\\[x = 1 \\]", "\\[x = {1 \\]"),
        ('alt="Two curves against time, both of which decay."', ""),
        ('alt="Two curves against time, both of which decay."', 'alt="figure"'),
    ],
)
def test_a_damaged_page_is_refused(tmp_path, old, new):
    assert old in SOUND
    assert checked(tmp_path, SOUND.replace(old, new))


def test_a_leaked_solution_is_noticed():
    source = ["### BEGIN SOLUTION\n", "gain = N @ np.linalg.inv(M)  # (33)\n"]
    cell = {"source": [*source, "### END SOLUTION"]}
    secrets = set(answers({"cells": [cell]}))
    assert leaked("<pre>gain = N @ np.linalg.inv(M)  # (33)</pre>", secrets)
    assert not leaked("<pre>raise NotImplementedError()</pre>", secrets)


def test_every_misprint_has_its_row_and_no_other_has():
    text = (ROOT / "notebooks/pages/misprints.toml").read_text(encoding="utf-8")
    rows = tomllib.loads(text)
    keys = [
        (paper, row["number"], row["printed"]) for paper in rows for row in rows[paper]
    ]
    known = [(e.paper, e.number, slip.printed) for e, slip in ledger.misprints()]
    assert collections.Counter(keys) == collections.Counter(known)
    for row in (row for paper in rows.values() for row in paper):
        assert row["correct"] and row["seen"].endswith((".", "!"))
        assert (row["correct"] + row["seen"]).count("$") % 2 == 0
