"""The guards of stored notebooks notice what `pytest --nbval` cannot see."""

import base64
import copy
import io
import json
import types
from pathlib import Path

import pytest
from notebook_tests import as_run, in_pytest, prose, stored
from PIL import Image
from PIL.PngImagePlugin import PngInfo

ROOT = Path(__file__).parents[2]
WORDS = "Two curves against time; the lower one is the filter of full order.\nx: t"


def picture(description, colour=0):
    """A picture of one pixel that says what it shows, as a notebook stores it."""
    file, says = io.BytesIO(), PngInfo()
    if description:
        says.add_itxt("Description", description)
    Image.new("L", (1, 1), colour).save(file, "png", pnginfo=says)
    return base64.b64encode(file.getvalue()).decode()


@pytest.fixture
def sound():
    """A notebook without fault, small enough to damage."""
    printed = {"output_type": "stream", "name": "stdout", "text": ["0.333333\n"]}
    code = {"cell_type": "code", "metadata": {}, "source": ["x = 1 / 3\n", "assert x"]}
    cells = [
        copy.deepcopy(code) | {"execution_count": k, "outputs": [dict(printed)]}
        for k in (1, 2, 3)
    ]
    data = {"image/png": picture(WORDS), "text/plain": WORDS}
    look = {"image/png": {"alt": WORDS}}
    shown = {"output_type": "display_data", "data": data, "metadata": look}
    cells[2] |= {"outputs": [shown], "metadata": {"mystnb": {"image": {"alt": WORDS}}}}
    says = (
        "A third is about $0.333$, $3.3\\cdot10^{-1}$ or 33.3 %; section 2.10, (3.25)."
    )
    cells.insert(1, {"cell_type": "markdown", "metadata": {}, "source": [says]})
    cells.insert(2, {"cell_type": "markdown", "metadata": {}, "source": ["So."]})
    cells = [cell | {"id": f"cell-{k}"} for k, cell in enumerate(cells)]
    notebook = {"cells": cells, "metadata": {}}
    prose.tie(notebook)
    return as_it_was_run(notebook)


def as_it_was_run(notebook):
    notebook["metadata"][as_run.KEY] = as_run.fingerprint(notebook)
    return notebook


def test_a_sound_notebook_passes(sound):
    assert list(stored.complaints(sound)) == []


def test_the_hook_names_the_notebook_at_fault(sound, tmp_path, capsys):
    path = tmp_path / "lesson.ipynb"
    path.write_text(json.dumps(sound), encoding="utf-8")
    assert stored.main([path]) == 0
    sound["cells"][0]["source"] = ["x = 1 / 4\n", "assert x"]
    path.write_text(json.dumps(sound), encoding="utf-8")
    assert stored.main([path]) == 1
    assert capsys.readouterr().out.startswith(f"{path}: cell cell-0: moved or changed")


# -- damage to the first cell of code, which is run again ------------------------------


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
def test_a_damaged_cell_is_refused(sound, damage):
    damage(sound["cells"][0])
    assert list(stored.complaints(as_it_was_run(sound)))


# -- damage to the picture -------------------------------------------------------------


def look_replaced_picture(cell):
    cell["outputs"][0]["data"]["image/png"] = picture("Another figure.\nx: t")


def look_picture_of_nobody(cell):
    cell["outputs"][0]["data"]["image/png"] = picture("", colour=255)


def look_words_of_another(cell):
    say(cell, WORDS.replace("lower", "upper"), picture(WORDS))


def look_mathematics_in_the_caption(cell):
    say(cell, "The curves of $x_1$ and $x_2$ against time.\nx: time (s)")


def look_unread(cell):
    say(cell, "Two curves against time; the lower one is the filter of full order.")


def look_without_words(cell):
    say(cell, "<Figure size 600x300 with 1 Axes>")


def look_other_text(cell):
    cell["outputs"][0]["data"]["text/plain"] += "\nlegend: one, two"


def look_without_alt(cell):
    cell["outputs"][0]["metadata"] = {}


def look_without_words_for_pages(cell):
    del cell["metadata"]["mystnb"]


def say(cell, words, png=None):
    cell["metadata"]["mystnb"]["image"]["alt"] = words
    cell["outputs"][0]["metadata"]["image/png"]["alt"] = words
    cell["outputs"][0]["data"]["text/plain"] = words
    cell["outputs"][0]["data"]["image/png"] = png or picture(words)


LOOKS = [f for name, f in sorted(globals().items()) if name.startswith("look_")]


@pytest.mark.parametrize("damage", LOOKS, ids=lambda f: f.__name__)
def test_a_damaged_picture_is_refused_and_its_cell_named(sound, damage):
    damage(sound["cells"][4])
    (complaint,) = {words[:7] for words in stored.complaints(as_it_was_run(sound))}
    assert complaint == "cell ce"
    assert all("cell-4" in words for words in stored.complaints(sound))


# -- damage to sentences and to the order, with execution counts put right -------------


@pytest.mark.parametrize(
    "old, new", [("0.333", "0.334"), ("33.3", "33.4"), ("3.3\\cdot", "3.4\\cdot")]
)
def test_another_number_in_a_sentence_is_refused(sound, old, new):
    says = sound["cells"][1]["source"]
    says[0] = says[0].replace(old, new)
    (complaint,) = stored.complaints(sound)
    assert f"cell cell-1: no cell is named for {new.split(chr(92))[0]}" in complaint


def test_a_number_that_no_cell_gives_is_tied_by_hand_or_refused(sound):
    says = sound["cells"][2]
    says["source"] = ["Half of 1.5 is 0.75."]
    prose.tie(sound)
    assert len(list(stored.complaints(sound))) == 2
    says["metadata"] = {"quotes": {"1.5": "by hand", "0.75": "by hand"}}
    prose.tie(sound)
    assert not list(stored.complaints(sound))


def test_another_result_is_refused_by_its_sentence(sound):
    for cell in sound["cells"]:
        if cell["cell_type"] == "code" and "text" in cell["outputs"][0]:
            cell["outputs"][0]["text"] = ["0.444444\n"]
    assert len(list(stored.complaints(sound))) == 3


def test_a_model_answer_tells_nothing_in_its_metadata(sound):
    says = sound["cells"][1]
    says["metadata"] = {"nbgrader": {"solution": True}}
    prose.tie(sound)
    assert says["metadata"] == {"nbgrader": {"solution": True}}
    assert not list(stored.complaints(sound))


@pytest.mark.parametrize("one, other", [(0, 3), (1, 2), (2, 3)])
def test_cells_in_another_order_are_refused(sound, one, other):
    cells = sound["cells"]
    cells[one], cells[other] = cells[other], cells[one]
    codes = (cell for cell in cells if cell["cell_type"] == "code")
    for k, cell in enumerate(codes, 1):
        cell["execution_count"] = k
    (complaint,) = stored.complaints(sound)
    first = cells[one]["id"]
    assert f"cell {first}: moved or changed since the notebook was run" in complaint


@pytest.mark.parametrize("gone, named", [(1, "cell cell-2"), (4, "the last cell")])
def test_a_cell_that_is_gone_is_missed(sound, gone, named):
    del sound["cells"][gone]
    found = list(stored.complaints(sound))
    assert any(words.startswith(f"{named}: moved or changed") for words in found)


def test_code_that_was_not_run_since_is_refused(sound):
    sound["cells"][0]["source"] = ["x = 2 / 6\n", "assert x"]
    (complaint,) = stored.complaints(sound)
    assert complaint.startswith("cell cell-0: moved or changed")


def test_cells_with_one_id_are_refused(sound):
    sound["cells"][1]["id"] = sound["cells"][2]["id"]
    (complaint,) = stored.complaints(as_it_was_run(sound))
    assert "without an id of its own" in complaint


def test_nbval_is_kept_from_passing_a_cell_that_was_never_run():
    cell = types.SimpleNamespace(source="1 + 1", execution_count=None)
    with pytest.raises(pytest.fail.Exception, match="without having been run"):
        in_pytest.pytest_runtest_setup(types.SimpleNamespace(cell=cell))
    cell.execution_count = 1
    in_pytest.pytest_runtest_setup(types.SimpleNamespace(cell=cell))
