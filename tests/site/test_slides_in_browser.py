"""Slides of the lessons in Chromium."""

import re
import subprocess
import sys

import pytest
import site_build
from browsing import ROOT, visit, window

pytestmark = pytest.mark.browser

LESSON = ROOT / "notebooks" / "09-optimal-projection.ipynb"
FITS = """() => {
    const slide = Reveal.getCurrentSlide(), edge = slide.getBoundingClientRect().right;
    return [...slide.querySelectorAll("mjx-container > svg, img")]
        .every((shown) => shown.getBoundingClientRect().right <= edge + 2);
}"""


@pytest.fixture(scope="module")
def deck(tmp_path_factory):
    if reason := site_build.missing():
        pytest.skip(reason)
    folder = tmp_path_factory.mktemp("deck")
    page = (ROOT / "notebooks" / "coursework" / "README.md").read_text("utf-8")
    command = re.search(r"^python (-m nbconvert .*) deck notebooks/", page, re.M)[1]
    done = subprocess.run(
        [sys.executable, *command.split(), str(folder), str(LESSON)],
        cwd=ROOT,
        capture_output=True,
        text=True,
    )
    assert done.returncode == 0, done.stderr
    return folder


def test_a_deck_needs_no_network_and_fits_the_screen(browser, deck):
    """`window` refuses what is asked of another machine, and scripts that fail."""
    with window(browser, 1280, 720) as page:
        visit(page, (deck / f"{LESSON.stem}.slides.html").as_uri())
        count = page.evaluate("Reveal.getTotalSlides()")
        assert count > 30
        assert page.locator("mjx-container[display] svg").count() > 20
        for _ in range(count):
            page.wait_for_function(FITS)
            page.keyboard.press("ArrowRight")
        page.wait_for_function("Reveal.isLastSlide()")
        assert page.get_by_text("# Solution of exercise").count() == 0


def test_a_deck_is_carried_with_what_it_loads(browser, deck, tmp_path):
    """Without the folder beside it the deck is bare, so that is where it loads from."""
    name = f"{LESSON.stem}.slides.html"
    alone = tmp_path / name
    alone.write_text((deck / name).read_text(encoding="utf-8"), encoding="utf-8")
    with window(browser, pardoned="Reveal is not defined") as page:
        page.goto(alone.as_uri())
        assert page.locator("mjx-container").count() == 0
