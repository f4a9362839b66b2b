"""The marks that make slides of the lessons."""

import copy
import json
from pathlib import Path

import pytest
from notebook_tests import slides

LESSONS = sorted((Path(__file__).parents[2] / "notebooks").glob("[0-9][0-9]-*.ipynb"))


def read(path):
    return json.loads(path.read_text(encoding="utf-8"))


@pytest.fixture
def lesson():
    return read(LESSONS[5])


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_every_lesson_is_marked(path):
    marks = [slides.slide_type(cell) for cell in read(path)["cells"]]
    assert marks[0] == "slide" and marks.count("slide") >= 4
    assert marks.count("subslide") > marks.count("slide")


def test_no_solution_is_on_a_slide(lesson):
    solutions = [
        slides.slide_type(cell)
        for cell in lesson["cells"]
        if "solution" in cell["metadata"].get("tags", [])
    ]
    assert solutions == ["skip"] * 5


def test_a_slide_holds_what_fits(lesson):
    """Only a single cell may be higher than a slide, which then scrolls."""
    used = []
    for cell in lesson["cells"]:
        kind, height = slides.slide_type(cell), slides.height(cell)
        if kind == "":
            used[-1].append(height)
        elif kind != "skip":
            used.append([height])
    assert any(len(cells) > 2 for cells in used)
    assert all(len(cells) == 1 or sum(cells) <= slides.LINES for cells in used)


@pytest.mark.parametrize(
    "other", [{}, {"slide_type": "subslide"}, {"slide_type": "skip"}], ids=str
)
def test_a_mark_that_was_lost_or_changed_is_noticed(lesson, other):
    assert not list(slides.complaints(lesson))
    for k, cell in enumerate(lesson["cells"]):
        damaged = copy.deepcopy(lesson)
        damaged["cells"][k]["metadata"]["slideshow"] = other
        same = slides.slide_type(cell) == other.get("slide_type", "")
        assert bool(list(slides.complaints(damaged))) == (not same)


def test_a_cell_that_grew_moves_what_follows(lesson):
    assert slides.slide_type(lesson["cells"][5]) == "slide"
    lesson["cells"][5]["source"] += ["\nOne more line."] * slides.LINES
    slides.mark(lesson)
    marks = [slides.slide_type(cell) for cell in lesson["cells"][5:7]]
    assert marks == ["slide", "subslide"]


def test_the_marks_of_an_author_stay(lesson):
    lesson["cells"][6]["metadata"]["slideshow"] = {"slide_type": "fragment"}
    slides.mark(lesson)
    assert slides.slide_type(lesson["cells"][6]) == "fragment"
    assert not list(slides.complaints(lesson))
