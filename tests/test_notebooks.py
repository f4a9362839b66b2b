"""What `pytest --nbval` cannot see of a notebook, its stored outputs above all."""

import copy
import importlib.util
import json
import pathlib
import re
import types

import pytest

ROOT = pathlib.Path(__file__).parents[1]
NOTEBOOKS = sorted(
    path
    for folder in (ROOT / "notebooks", ROOT / "lib" / "luenberger" / "templates")
    for path in folder.rglob("*.ipynb")
    if ".ipynb_checkpoints" not in path.parts
)
FOREIGN = {
    "an address in memory": r"0x[0-9a-fA-F]{6,}",
    "a path of one machine": r"(?<![\w.])/(home|root|tmp|usr|var|work|Users|opt)/",
    "a temporary file": r"ipykernel_\d|\\Users\\",
    "a time that was measured": r"\d ?(ns|µs|us|ms)\b|\d it/s|Wall time",
}
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
        if len(source.splitlines()) > 15:
            yield f"a cell of more than 15 lines:\n{source}"
        if any(line.rstrip().endswith(";") for line in source.splitlines()):
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


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_notebook(path):
    found = list(complaints(json.loads(path.read_text(encoding="utf-8"))))
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
