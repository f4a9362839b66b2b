"""What a reader sees and does in Chromium: pages, the ledger, the report."""

import contextlib
import functools
import subprocess
import sys

import browsing
import pytest
from browsing import ROOT, barriers, faults, settled, visit, window

from luenberger import ledger

pytestmark = pytest.mark.browser

LAPTOP, PHONE = (1280, 800), (390, 844)
NOTEBOOKS = sorted((ROOT / "notebooks").glob("[0-9]*.ipynb"))
KINDS_OF_PAGE = [
    "index",
    "search",
    "genindex",
    "coursework/README",
    "pages/coursework",
    "pages/benchmarks",
    "pages/ledger",
    "pages/misprints",
    "pages/api/index",
    "pages/api/designs",
    "pages/derivations/haddad-bernstein",
    "pages/derivations/leondes-novak",
    "_modules/luenberger/papers/leondes_novak/derivation/brammer",
]


@pytest.fixture(scope="module")
def served(browser, site):
    with browsing.served(site) as address:
        yield address


# -- the pages -------------------------------------------------------------------------


@contextlib.contextmanager
def at_both_widths(browser, address, look=faults):
    """A page as on a laptop, then as on a phone: what `look` finds at each."""
    found = {}
    with window(browser) as page:
        visit(page, address)
        for width, height in (LAPTOP, PHONE):
            page.set_viewport_size({"width": width, "height": height})
            settled(page)
            found[width] = look(page)
        yield page, found


SCROLLS = """() => [...document.querySelectorAll("main mjx-container")]
    .filter((math) => math.checkVisibility() && math.scrollWidth > math.clientWidth
        && /auto|scroll/.test(getComputedStyle(math).overflowX))
    .map((math) => math.textContent.slice(0, 60))"""
FOR_ALL_READERS = [
    "index",
    "00-start-here",
    "11-which-observer",
    "pages/ledger",
    "pages/misprints",
    "pages/derivations/van-dooren",
    "coursework/README",
]


@pytest.fixture(scope="module")
def found_on(browser, served):
    """What is wrong on a page at each width; it is set once for all tests of it."""

    @functools.cache
    def seen(name):
        def look(page):
            found = {"faults": faults(page), "scrolling": page.evaluate(SCROLLS)}
            if name in FOR_ALL_READERS:
                found["barriers"] = barriers(page)
            return found | {"mains": page.locator("main#main-content").count()}

        with at_both_widths(browser, f"{served}/{name}.html", look) as (_, found):
            return found

    return seen


@pytest.mark.parametrize("name", [*(p.stem for p in NOTEBOOKS), *KINDS_OF_PAGE])
def test_a_page_is_whole_on_a_laptop_and_on_a_phone(name, found_on):
    found = found_on(name)
    assert [one["mains"] for one in found.values()] == [1, 1]
    assert {width: one["faults"] for width, one in found.items()} == {
        LAPTOP[0]: [],
        PHONE[0]: [],
    }


@pytest.mark.parametrize("name", FOR_ALL_READERS)
def test_a_page_has_no_barriers(name, found_on):
    assert [one["barriers"] for one in found_on(name).values()] == [[], []]


@pytest.mark.parametrize(
    "name",
    [
        *(p.stem for p in NOTEBOOKS),
        "index",
        "pages/ledger",
        "pages/derivations/van-dooren",
    ],
)
def test_no_formula_scrolls_on_a_laptop(name, found_on):
    assert found_on(name)[LAPTOP[0]]["scrolling"] == []


def test_a_phone_shows_the_reasons_below_the_lines(browser, served):
    with window(browser, *PHONE) as page:
        visit(page, f"{served}/02-trace-minimisation.html")
        boxes = page.locator("div.chain").first
        line = boxes.locator("p.right").first.bounding_box()
        reason = boxes.locator("p.reason").first.bounding_box()
        assert reason["y"] >= line["y"] + line["height"] / 2
        assert reason["x"] + reason["width"] <= PHONE[0]


FOLDED = "document.querySelectorAll('main details:not([open])').length"


def test_solutions_are_unfolded_on_paper_only(browser, served):
    with window(browser) as page:
        visit(page, f"{served}/05-staircase-observer.html")
        folded = page.evaluate(FOLDED)
        assert folded >= 10
        count = f"addEventListener('beforeprint', () => {{ window.left = {FOLDED} }})"
        page.evaluate(count)
        page.pdf()
        assert page.evaluate("window.left") == 0
        assert page.evaluate(FOLDED) == folded


@pytest.mark.parametrize("place", ["as a file", "from a server"])
@pytest.mark.parametrize(
    ("term", "leads_to"),
    [("deadbeat", "06-canonical-form"), ("projection", "09-optimal-projection")],
)
def test_search_finds_a_term_and_leads_there(
    place, term, leads_to, browser, site, served
):
    start = served if place == "from a server" else site.as_uri()
    # a file may not read another: there the results lack their excerpts
    pardoned = "Failed to fetch" if place == "as a file" else None
    with window(browser, pardoned=pardoned) as page:
        visit(page, f"{start}/index.html")
        page.keyboard.press("Control+k")
        page.locator("input[type=search]:focus").wait_for()
        page.keyboard.type(term)
        page.keyboard.press("Enter")
        link = page.locator(f'#search-results a[href*="{leads_to}"]').first
        link.click()
        page.wait_for_url(f"**/{leads_to}*")
        assert term in page.locator("article").inner_text().lower()


def test_search_says_when_it_finds_nothing(browser, served):
    with window(browser) as page:
        visit(page, f"{served}/search.html?q=nosuchwordanywhere")
        page.get_by_text("did not match any documents").wait_for()
        assert page.locator("#search-results li").count() == 0


def test_the_contents_open_on_a_phone(browser, served):
    with window(browser, *PHONE) as page:
        visit(page, f"{served}/index.html")
        entry = page.locator('.bd-sidebar-primary a[href^="09"]')
        assert not entry.is_visible() or entry.bounding_box()["x"] < 0
        page.locator(".primary-toggle:visible").first.click()
        entry.click()
        page.wait_for_url("**/09-optimal-projection.html")


# -- the filters -----------------------------------------------------------------------


def shown(page):
    return page.locator("article .entry:visible").count()


def said(page):
    return page.locator("form.filter output").inner_text()


def test_the_ledger_is_filtered_by_paper_misprint_and_words(browser, served):
    total = ledger.count()
    with window(browser) as page:
        visit(page, f"{served}/pages/ledger.html")
        for paper in ("", *ledger.PARTS):
            count = ledger.count(paper) if paper else total
            page.get_by_label("Paper").select_option(paper)
            assert (shown(page), said(page)) == (count, f"{count} of {total}")
        page.get_by_label("Paper").select_option("moore")
        page.get_by_label("misprinted only").check()
        count = sum(bool(entry.misprints) for entry in ledger.entries("moore"))
        assert (shown(page), said(page)) == (count, f"{count} of {total}")
        page.get_by_label("misprinted only").uncheck()
        page.get_by_label("Words").fill("z MOVES as")
        first = page.locator("article .entry:visible").all_inner_texts()
        assert 0 < len(first) < ledger.count("moore")
        assert all("moves" in row for row in first)
        page.get_by_label("Words").fill("nosuchword")
        assert (shown(page), said(page)) == (0, f"0 of {total}")


def test_the_misprints_are_filtered_by_paper_and_kind(browser, served):
    total = len(ledger.misprints())
    with window(browser) as page:
        visit(page, f"{served}/pages/misprints.html")
        assert (shown(page), said(page)) == (total, f"{total} of {total}")
        kinds = page.locator("select[name=kind] option").all_inner_texts()[1:]
        counts = []
        for kind in kinds:
            page.get_by_label("Kind").select_option(kind)
            titles = page.locator("article .entry:visible .rubric").all_inner_texts()
            assert all(title.endswith(f" {kind}") for title in titles)
            assert said(page) == f"{len(titles)} of {total}"
            counts.append(len(titles))
        assert len(counts) == 3 and min(counts) > 0 and sum(counts) == total
        page.get_by_label("Kind").select_option("")
        for paper in ledger.PAPERS:
            page.locator("select[name=paper]").select_option(paper)
            assert shown(page) == len(ledger.misprints(paper))
            sections = page.locator("article section section:visible")
            assert (
                sections.locator("h2")
                .all_inner_texts()[0]
                .startswith(ledger.title(paper))
            )
            assert sections.count() == 1


def test_a_misprint_leads_to_its_evidence(browser, served):
    with window(browser) as page:
        visit(page, f"{served}/pages/misprints.html")
        page.locator(".misprint a", has_text="the ledger's entry").first.click()
        page.wait_for_url("**/ledger.html#ledger-*")
        settled(page)
        row = page.locator("tr.entry:has(:target)")
        assert row.count() == 1 and row.locator("a", has_text="wrong in").count()


def test_the_ledger_in_one_file_is_filtered_without_a_script(browser, tmp_path):
    ledger.write_page(tmp_path / "ledger.html", formulas=False)
    rows = "tr.entry:visible"
    with at_both_widths(browser, (tmp_path / "ledger.html").as_uri()) as (page, found):
        assert found == {LAPTOP[0]: [], PHONE[0]: []}
        for paper in ledger.PARTS:
            page.get_by_label(ledger.title(paper)).check()
            assert page.locator(rows).count() == ledger.count(paper)
            said = page.locator(".count:visible").inner_text()
            assert said.startswith(f"{ledger.count(paper)} entries")
        page.get_by_label("all").check()
        assert page.locator(rows).count() == ledger.count()
        page.get_by_label("misprinted only").check()
        wrong = sum(bool(entry.misprints) for entry in ledger.entries())
        assert page.locator(rows).count() == wrong < ledger.count()


# -- the report ------------------------------------------------------------------------


def test_the_report_fits_a_telephone(browser, tmp_path):
    plants = ROOT / "notebooks" / "plants"
    command = [sys.executable, "-m", "luenberger", "design", plants / "tracker.json"]
    command += ["--data", plants / "tracker.csv", "--out", tmp_path / "report"]
    subprocess.run(command, check=True, capture_output=True)
    address = (tmp_path / "report" / "report.html").as_uri()
    with at_both_widths(browser, address) as (page, found):
        assert found == {LAPTOP[0]: [], PHONE[0]: []}
        assert page.locator("img").count() == 9
        assert barriers(page) == []


# -- the checks themselves -------------------------------------------------------------

SOUND = """<!doctype html><html lang="en"><body style="margin: 1em">
<div style="overflow-x: auto"><table><tr><td style="min-width: 2000px">1</table></div>
<p>so <math><mi>x</mi></math></p>
<svg width="9" height="9"><rect width="9" height="9"/></svg>
<img alt="a dot" width="9" src="data:image/gif;base64,R0lGODlhAQABAAAAACwAAAAAAQABAAA=">
<nav style="position: fixed; left: -300px; width: 300px">contents</nav>
</body></html>"""


def seen(browser, folder, text):
    (folder / "page.html").write_text(text)
    with at_both_widths(browser, (folder / "page.html").as_uri()) as (_, found):
        return sum(found.values(), [])


@pytest.mark.parametrize(
    "text, barrier",
    [
        ('<img src="data:image/gif;base64,">', "image-alt"),
        ("<details><summary></summary>x</details>", "summary-name"),
        ('<p style="color: #bbb">pale</p>', "color-contrast"),
        ('<p style="width: 9em; overflow: auto">', "scrollable-region-focusable"),
    ],
)
def test_a_barrier_is_noticed(browser, tmp_path, text, barrier):
    path = tmp_path / "page.html"
    path.write_text(
        f"<!doctype html><html lang='en'><title>x</title><main>{text}<mjx-container>"
        '<svg width="999" height="9"><path d="M0 0H9"/></svg></mjx-container>'
    )
    with window(browser) as page:
        visit(page, path.as_uri())
        assert any(one.startswith(barrier) for one in barriers(page))
        assert page.locator("mjx-container path").count() == 1  # it is put back


def test_a_sound_page_passes(browser, tmp_path):
    assert seen(browser, tmp_path, SOUND) == []


@pytest.mark.parametrize(
    ("old", "new"),
    [
        ("overflow-x: auto", ""),
        ("overflow-x: auto", "overflow-x: hidden"),
        ("position: fixed", "position: absolute; left: 0; margin-left"),
        ('alt="a dot"', ""),
        ("R0lGODlh", "AAAA"),
        ("<math><mi>x</mi></math>", "<math></math>"),
        ("<math><mi>x</mi></math>", "<math><merror>x</merror></math>"),
        ("<math><mi>x</mi></math>", '<span class="math">\\(x\\)</span>'),
    ],
)
def test_a_damaged_page_is_refused(browser, tmp_path, old, new):
    assert old in SOUND
    assert seen(browser, tmp_path, SOUND.replace(old, new))


@pytest.mark.parametrize(
    ("added", "pattern"),
    [
        ('<img alt="far" src="https://example.org/a.png">', "another machine"),
        ('<script>new WebSocket("wss://example.org/")</script>', "another machine"),
        ("<script>missing()</script>", "faults of scripts"),
    ],
)
def test_a_page_that_asks_elsewhere_or_breaks_is_refused(
    browser, tmp_path, added, pattern
):
    (tmp_path / "page.html").write_text(SOUND + added)
    with pytest.raises(AssertionError, match=pattern), window(browser) as page:
        visit(page, (tmp_path / "page.html").as_uri())
