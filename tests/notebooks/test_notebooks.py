"""What `pytest --nbval` cannot see of a notebook, its stored outputs above all."""

import copy
import importlib.util
import json
import pathlib
import re
import types

import pytest

ROOT = pathlib.Path(__file__).parents[2]
NOTEBOOKS = sorted(
    path
    for folder in (
        ROOT / "notebooks",
        ROOT / "lib" / "luenberger" / "report" / "templates",
    )
    for path in folder.rglob("*.ipynb")
    if ".ipynb_checkpoints" not in path.parts
)
FOREIGN = {
    "an address in memory": r"0x[0-9a-fA-F]{6,}",
    "a path of one machine": r"(?<![\w.])/(home|root|tmp|usr|var|work|Users|opt)/",
    "a temporary file": r"ipykernel_\d|\\Users\\",
    "a time that was measured": r"\d ?(ns|µs|us|ms)\b|\d it/s|Wall time",
}
LESSONS = [path for path in NOTEBOOKS if re.match(r"\d\d-", path.name)]
CHAIN = re.compile(r"&& \\checkmark")
NAME_OF_A_STEP = re.compile(r"^\s*\(\d[\w', .–-]*\) [a-z]", re.M)
LONG_NUMBER = re.compile(r"(?<![\w.])\d*\.\d+")


def complaints(notebook):
    """Everything that is wrong with a notebook (parsed JSON), in words."""
    cells = [cell for cell in notebook["cells"] if cell["cell_type"] == "code"]
    sources = ["".join(cell["source"]) for cell in cells]
    if [cell["execution_count"] for cell in cells] != list(range(1, len(cells) + 1)):
        yield "not saved after running every cell once, from top to bottom"
    if sum("assert " in source for source in sources) < 3:
        yield "fewer than three cells assert anything"
    for cell, source in zip(cells, sources):
        tags = set(cell["metadata"].get("tags", []))
        lines = source.splitlines()  # "### ..." marks what nbgrader cuts out
        most = 25 if "hide-input" in tags else 15  # what draws a diagram is folded
        if sum(not line.startswith(("###", "show(fig")) for line in lines) > most:
            yield f"a cell of more than {most} lines:\n{source}"
        if any(line.rstrip().endswith(";") for line in lines):
            yield f"a semicolon at the end of a line, which nbval ignores:\n{source}"
        if "NBVAL_" in source or any(tag.startswith("nbval-") for tag in tags):
            yield f"a cell that is exempt from comparison:\n{source}"
        for output in cell["outputs"]:
            yield from output_complaints(output, "raises-exception" in tags)
    if "language_info" in notebook["metadata"] or "widgets" in notebook["metadata"]:
        yield "saved with the interpreter's version or widget state; use .ci/refresh"


def output_complaints(output, may_raise):
    if output["output_type"] == "stream" and output["name"] == "stderr":
        yield f"a warning is stored: {output['text']}"
    if output["output_type"] == "error" and not may_raise:
        yield f"a cell raised {output['ename']} without the tag raises-exception"
    for text in output_texts(output):
        for what, pattern in FOREIGN.items():
            if found := re.search(pattern, text):
                yield f"{what} in an output: {found[0]!r} in {text[:200]}"
        for number in LONG_NUMBER.findall(text):
            if len(number.replace(".", "").strip("0")) > 6:
                yield f"{number} has more than six digits: print it with `show`"


def output_texts(output):
    """The texts of an output that nbval compares."""
    if "text" in output:
        yield "".join(output["text"])
    for kind, value in output.get("data", {}).items():
        if not kind.startswith("image/") and isinstance(value, str | list):
            yield "".join(value)


def lesson_complaints(notebook):
    """What is wrong with a lesson's course, its formulas, figures and exercises."""
    yield from course_complaints(notebook["cells"])
    for cell in notebook["cells"]:
        if cell["cell_type"] == "markdown":
            yield from formula_complaints("".join(cell["source"]))
        for output in cell.get("outputs", ()):
            if "image/png" in output.get("data", {}):
                yield from figure_complaints(cell["metadata"], output)
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


def figure_complaints(of_cell, output):
    """A figure has a caption, and its words are those that `show` read off it."""
    data, look = output["data"], output["metadata"].get("image/png", {})
    words = "".join(data.get("text/plain", ""))
    caption, *read = words.splitlines() or [""]
    if len(caption) < 30 or re.search(r"[$\\]", caption):
        yield f"a figure without a sentence for who cannot see it: {caption!r}"
    if not any(line.startswith(("x: ", "text ", "Panel")) for line in read):
        yield f"end the cell with `show(fig, caption)`: {words!r}"
    of_pages = of_cell.get("mystnb", {}).get("image", {}).get("alt")
    if not words == look.get("alt") == of_pages:
        yield f"the figure has other words; run .ci/refresh_notebooks.py: {words!r}"


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


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path):
    found = list(complaints(json.loads(path.read_text(encoding="utf-8"))))
    assert not found, "\n".join(found)


@pytest.mark.parametrize("path", LESSONS, ids=lambda path: path.stem)
def test_lesson(path):
    found = list(lesson_complaints(json.loads(path.read_text(encoding="utf-8"))))
    assert not found, "\n".join(found)


def test_the_template_is_among_them():
    assert "design" in {path.stem for path in NOTEBOOKS}


@pytest.fixture
def sound():
    """A notebook without fault, small enough to damage."""
    output = {"output_type": "stream", "name": "stdout", "text": ["0.333333\n"]}
    cell = {
        "cell_type": "code",
        "execution_count": 1,
        "metadata": {},
        "outputs": [output],
        "source": ["x = 1 / 3\n", "assert 3 * x == 1"],
    }
    cells = [copy.deepcopy(cell) | {"execution_count": k} for k in (1, 2, 3)]
    return {"cells": cells, "metadata": {}}


def test_a_sound_notebook_passes(sound):
    assert list(complaints(sound)) == []


def damage_unrun(cell):
    cell["execution_count"] = None


def damage_order(cell):
    cell["execution_count"] = 7


def damage_length(cell):
    cell["source"] = ["x = 1\n"] * 16


def damage_asserts(cell):
    cell["source"] = ["x = 1"]


def damage_semicolon(cell):
    cell["source"] = ["assert x\n", "5;"]


def damage_tag(cell):
    cell["metadata"] = {"tags": ["nbval-skip"]}


def damage_warning(cell):
    cell["outputs"][0]["name"] = "stderr"


def damage_address(cell):
    cell["outputs"][0]["text"] = ["<Line at 0x7f01a2b3c4d5>"]


def damage_path(cell):
    cell["outputs"][0]["text"] = ["read /home/someone/plant.json"]


def damage_time(cell):
    cell["outputs"][0]["text"] = ["took 12 ms"]


def damage_digits(cell):
    cell["outputs"][0]["text"] = ["0.3333333333333333"]


def damage_error(cell):
    cell["outputs"][0] = {"output_type": "error", "ename": "ValueError"}


DAMAGES = [f for name, f in sorted(globals().items()) if name.startswith("damage_")]


@pytest.mark.parametrize("damage", DAMAGES, ids=lambda f: f.__name__)
def test_a_damaged_notebook_is_refused(sound, damage):
    damage(sound["cells"][1])
    assert list(complaints(sound))


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


def spoil_figure(cells):
    del cells[0]["metadata"]["mystnb"]


def say(cells, words):
    cells[0]["metadata"]["mystnb"]["image"]["alt"] = words
    cells[0]["outputs"][0]["metadata"]["image/png"]["alt"] = words
    cells[0]["outputs"][0]["data"]["text/plain"] = words


def spoil_figure_with_mathematics(cells):
    say(cells, "The curves of $x_1$ and $x_2$ against time.\nx: time (s)")


def spoil_figure_that_nobody_read(cells):
    say(cells, "Two curves against time; the lower one is the filter of full order.")


def spoil_figure_without_words(cells):
    say(cells, "<Figure size 600x300 with 1 Axes>")


def spoil_text_of_a_figure(cells):
    cells[0]["outputs"][0]["data"]["text/plain"] += "\nlegend: one, two"


def spoil_stored_figure(cells):
    cells[0]["outputs"][0]["metadata"] = {}


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


def test_refreshing_gives_a_cell_the_words_of_its_figure(lesson):
    spec = importlib.util.spec_from_file_location(
        "refresh_notebooks", ROOT / ".ci" / "refresh_notebooks.py"
    )
    refresh = importlib.util.module_from_spec(spec)
    with pytest.MonkeyPatch.context() as patch:
        patch.syspath_prepend(str(ROOT / "notebooks"))
        spec.loader.exec_module(refresh)
    spoil_figure(lesson["cells"])
    notebook = refresh.nbformat.from_dict(lesson)
    refresh.describe_figures(notebook)
    assert not list(lesson_complaints(notebook))


def test_nbval_is_kept_from_passing_a_cell_that_was_never_run():
    spec = importlib.util.spec_from_file_location(
        "notebooks_conftest", ROOT / "notebooks" / "conftest.py"
    )
    guard = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(guard)
    cell = types.SimpleNamespace(source="1 + 1", execution_count=None)
    with pytest.raises(pytest.fail.Exception, match="without having been run"):
        guard.pytest_runtest_setup(types.SimpleNamespace(cell=cell))
    cell.execution_count = 1
    guard.pytest_runtest_setup(types.SimpleNamespace(cell=cell))
