"""A lesson has a course, chains beside code, and exercises with their answers."""

import copy
import json
import re
from pathlib import Path

import pytest

LESSONS = sorted((Path(__file__).parents[2] / "notebooks").glob("[0-9][0-9]-*.ipynb"))
CHAIN = re.compile(r"&& \\checkmark")
NAME_OF_A_STEP = re.compile(r"^\s*\(\d[\w', .–-]*\) [a-z]", re.M)


def lesson_complaints(notebook):
    """What is wrong with a lesson's course, its formulas, figures and exercises."""
    yield from course_complaints(notebook["cells"])
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            yield from formula_complaints("".join(cell["source"]))
    exercises = list(grouped_by_exercise(notebook["cells"]))
    if not 3 <= len(exercises) <= 5:
        yield f"{len(exercises)} exercises, not 3 to 5"
    for k, (statement, *answer) in enumerate(exercises, 1):
        for words in exercise_complaints(k, "".join(statement["source"]), answer):
            yield f"exercise {k}: {words}"


def course_complaints(cells):
    """A lesson begins with a picture, and has its derivation beside its code."""
    outputs = [cell.get("outputs", ()) for cell in cells]
    if not any("image/png" in o.get("data", {}) for some in outputs[:5] for o in some):
        yield "no picture among the first five cells"
    shown = [o.get("data", {}).get("text/latex", "") for some in outputs for o in some]
    if sum(bool(CHAIN.search("".join(formula))) for formula in shown) < 2:
        yield "fewer than two chains on the page"
    sources = ["".join(cell["source"]) for cell in cells if cell["cell_type"] == "code"]
    if not any(re.search(r"numpy_source|compile\(", source) for source in sources):
        yield "no code beside the stages that it is printed from"
    if any("getsource" in source for source in sources):
        yield "a source text is searched, where a value could be checked"
    for some in outputs:
        for output in some:
            if name := NAME_OF_A_STEP.search("".join(output.get("text", ""))):
                yield f"a step is named, not shown: {name[0]!r}"


def formula_complaints(prose):
    for formula in re.findall(r"\$\$(.*?)\$\$", prose, re.S):
        if formula.count(r"\tag") > 1:
            yield f"two numbers on one formula, which MathJax refuses:\n{formula}"


def grouped_by_exercise(cells):
    """Each exercise's cells: the statement, then what follows it."""
    found, inside = [], False
    for cell in cells:
        source = "".join(cell["source"])
        headings = re.findall(r"^## .*", source, re.M)
        if cell["cell_type"] == "markdown" and headings:
            inside = headings[-1].startswith("## Exercises")
        if inside and cell["cell_type"] == "markdown" and "**Exercise" in source:
            found.append([])
        if inside and found:
            found[-1].append(cell)
    return found


def exercise_complaints(k, statement, answer):
    """An exercise is a statement, a folded answer in prose, and cells that run it."""
    if not statement.partition("**Exercise")[2].startswith(f" {k}.**"):
        yield f"it does not begin with **Exercise {k}.**, in a cell of its own"
    if not re.search(
        r"<summary>Solution</summary>\n\n.+\n\n</details>", statement, re.S
    ):
        yield "no solution in prose, folded, in the same cell"
    sources = ["".join(cell["source"]) for cell in answer]
    if not answer or any(cell["cell_type"] != "code" for cell in answer):
        yield "no cells of code with the solution directly below, or others among them"
    if not any("assert " in source for source in sources):
        yield "its solution asserts nothing"
    for cell, source in zip(answer, sources):
        if not source.startswith(f"# Solution of exercise {k}"):
            yield f"a cell does not begin '# Solution of exercise {k}':\n{source}"
        if not {"solution", "hide-cell"} <= set(cell["metadata"].get("tags", [])):
            yield f"a cell without the tags solution and hide-cell:\n{source}"
        if not cell["metadata"].get("jupyter", {}).get("source_hidden"):
            yield f"a cell whose source is not folded:\n{source}"


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_lesson(path):
    found = list(lesson_complaints(json.loads(path.read_text(encoding="utf-8"))))
    assert not found, "\n".join(found)


@pytest.fixture
def lesson():
    """A lesson without fault: a figure and three exercises."""
    words = "Two curves against time; the lower one is the filter of full order.\nx: t"
    data = {"image/png": "iVBORw0KGgo=", "text/plain": words}
    figure = {"output_type": "display_data", "data": data}
    formula = {"text/latex": [r"$$x &= y && \text{(1)} && \checkmark$$"]}
    chain = {"output_type": "display_data", "data": formula}
    cells = [
        {
            "cell_type": "code",
            "metadata": {"mystnb": {"image": {"alt": words}}},
            "outputs": [
                figure | {"metadata": {"image/png": {"alt": words}}},
                *[copy.deepcopy(chain) for _ in range(2)],
            ],
            "source": ["print(compile(stages).source)"],
        },
        {"cell_type": "markdown", "metadata": {}, "source": ["## Exercises"]},
    ]
    for k in (1, 2, 3):
        folded = "<details><summary>Solution</summary>\n\nTwo.\n\n</details>"
        statement = [f"**Exercise {k}.** How many?\n", "\n", folded]
        folding = {"source_hidden": True, "outputs_hidden": True}
        tags = {"jupyter": folding, "tags": ["solution", "hide-cell"]}
        answer = [f"# Solution of exercise {k}\n", "assert 1 + 1 == 2"]
        cells += [
            {"cell_type": "markdown", "metadata": {}, "source": statement},
            {"cell_type": "code", "metadata": tags, "outputs": [], "source": answer},
        ]
    cells.append({"cell_type": "markdown", "metadata": {}, "source": ["## Sources"]})
    return {"cells": cells, "metadata": {}}


def test_a_sound_lesson_passes(lesson):
    assert list(lesson_complaints(lesson)) == []


def spoil_first_picture(cells):
    cells[0:0] = [{"cell_type": "markdown", "source": ["Words."]} for _ in range(5)]


def spoil_chain(cells):
    cells[0]["outputs"][1]["data"]["text/latex"] = ["$$x = y$$"]


def spoil_code(cells):
    cells[0]["source"] = ["x = 1"]


def spoil_check(cells):
    cells[0]["source"] += ["\n", "assert 'n' in inspect.getsource(f)"]


def spoil_steps(cells):
    names = {"output_type": "stream", "text": ["(33) the gain that runs\n"]}
    cells[0]["outputs"].append(names)


def spoil_formula(cells):
    cells[1]["source"] = ["$$ x = 1 \\tag{1} $$ $$ y = 2 \\tag{2}, z = 3 \\tag{3} $$"]


def spoil_number_of_exercises(cells):
    del cells[-3:-1]


def spoil_number_of_exercises_upwards(cells):
    more = [cells[-3:-1] for _ in range(3)]
    for k, pair in enumerate(copy.deepcopy(more), 4):
        for cell in pair:
            cell["source"][0] = cell["source"][0].replace("ercise 3", f"ercise {k}")
        cells[-1:-1] = pair


def spoil_order(cells):
    cells[2:4], cells[4:6] = cells[4:6], cells[2:4]


def spoil_prose(cells):
    cells[4]["source"][-1] = "Solution: two."


def spoil_answer(cells):
    del cells[5]


def spoil_place_of_answer(cells):
    cells[5:5] = [{"cell_type": "markdown", "metadata": {}, "source": ["Now:"]}]


def spoil_assert(cells):
    cells[5]["source"][1] = "1 + 1"


def spoil_first_line(cells):
    del cells[5]["source"][0]


def spoil_tags(cells):
    cells[5]["metadata"]["tags"] = ["solution"]


def spoil_folding(cells):
    del cells[5]["metadata"]["jupyter"]


SPOILED = [f for name, f in sorted(globals().items()) if name.startswith("spoil_")]


@pytest.mark.parametrize("spoil", SPOILED, ids=lambda f: f.__name__)
def test_a_spoiled_lesson_is_refused(lesson, spoil):
    spoil(lesson["cells"])
    assert list(lesson_complaints(lesson))
