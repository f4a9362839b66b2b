"""The notebook tests serve a repository that is not this one, made on the spot."""

import json
import os
import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).parents[2]
CONFTEST = """from notebook_tests import forked
from notebook_tests.in_pytest import *
forked.use("matplotlib.figure")
"""
SETTINGS = """[pytest]
pythonpath = .ci
addopts = -p no:cacheprovider --nbval --nbval-current-env
"""
FIGURE = """fig = Figure(figsize=(3, 2))
ax = fig.subplots()
ax.plot([0, 1, 2], [1, 2, 4], "o-", color="#0072b2", label="height")
ax.set(xlabel="time (s)", ylabel="height (m)", ylim=(0, 5))
show(fig, "The height doubles each second; the curve has three points.")
assert len(ax.lines) == 1"""
FALL = [
    ("markdown", "# A fall\nIn a second a stone falls by 4.905 m."),
    ("code", "g = 9.81\nheight = g / 2\nassert height > 4"),
    ("code", "from show import show\nshow([height, 1e-20], 'h')\nassert height < 5"),
    ("code", "show([height / 4], 'in half a second')\nassert height / 4 < 2"),
]
DRAWN = [
    ("code", "from matplotlib.figure import Figure\nfrom show import show"),
    *[("code", FIGURE)] * 5,
]
DAMAGE = {  # of the code of each figure, and what nbval then tells apart
    "data": ("[1, 2, 4]", "[1, 2, 3]"),
    "colour": ("#0072b2", "#d55e00"),
    "label": ('label="height"', 'label="depth"'),
    "limits": ("(0, 5)", "(0, 6)"),
    "empty": ("[0, 1, 2], [1, 2, 4]", "[], []"),
}


def notebook(cells):
    made = [
        {"cell_type": kind, "id": f"cell-{k}", "metadata": {}, "source": text}
        | ({"outputs": [], "execution_count": None} if kind == "code" else {})
        for k, (kind, text) in enumerate(cells)
    ]
    return {"cells": made, "metadata": {}, "nbformat": 4, "nbformat_minor": 5}


def python(folder, *arguments):
    kept = {k: v for k, v in os.environ.items() if not k.startswith("PYTEST")}
    return subprocess.run(
        [sys.executable, "-m", *arguments],
        cwd=folder,
        env=kept | {"PYTHONPATH": ".ci"},
        capture_output=True,
        text=True,
    )


@pytest.fixture(scope="module")
def verdict(tmp_path_factory):
    """What pytest says of a sound notebook and of one that was damaged."""
    from notebook_tests import as_run

    folder = tmp_path_factory.mktemp("repository")
    shutil.copytree(ROOT / ".ci" / "notebook_tests", folder / ".ci" / "notebook_tests")
    shutil.copy(ROOT / "tests" / "support" / "rfc3987_syntax.py", folder / ".ci")
    here = folder / "notebooks"
    shutil.copytree(ROOT / "lib" / "luenberger" / "show", here / "show")
    (here / "conftest.py").write_text(CONFTEST)
    (folder / "pytest.ini").write_text(SETTINGS)
    sound = here / "sound.ipynb"
    sound.write_text(json.dumps(notebook(FALL + DRAWN)))
    done = python(folder, "notebook_tests.refresh", "notebooks/sound.ipynb")
    assert done.returncode == 0, done.stderr

    damaged = json.loads(sound.read_text())
    cells = damaged["cells"]
    for cell, (old, new) in zip(cells[len(FALL) + 1 :], DAMAGE.values()):
        source = "".join(cell["source"])
        assert old in source
        cell["source"] = source.replace(old, new)
    damaged["metadata"][as_run.KEY] = as_run.fingerprint(damaged)

    cells[2]["outputs"], cells[3]["outputs"] = cells[3]["outputs"], cells[2]["outputs"]
    cells[0]["source"] = "# A fall\nIn a second a stone falls by 4.915 m."
    cells[0], cells[1] = cells[1], cells[0]
    (here / "damaged.ipynb").write_text(json.dumps(damaged))
    return python(folder, "pytest", "-q", "-rA").stdout


def outcomes(verdict, name):
    found = re.findall(rf"^(PASSED|FAILED) notebooks/{name}.ipynb::(.*)", verdict, re.M)
    return {cell.partition(" - ")[0]: outcome for outcome, cell in found}


def test_a_sound_notebook_passes(verdict):
    found = outcomes(verdict, "sound")
    assert len(found) == 10 and set(found.values()) == {"PASSED"}, verdict


@pytest.mark.parametrize("cell", range(4, 9), ids=DAMAGE.keys())
def test_a_changed_figure_fails_its_cell(verdict, cell):
    found = outcomes(verdict, "damaged")
    assert found["Cell 3"] == "PASSED" and found[f"Cell {cell}"] == "FAILED"


def test_moved_cells_another_number_and_other_outputs_fail(verdict):
    found = outcomes(verdict, "damaged")
    assert found["as stored"] == "FAILED"
    wanted = ["PASSED", "FAILED", "FAILED"]
    assert [found[f"Cell {k}"] for k in range(3)] == wanted
    assert "cell-0: no cell is named for 4.915" in verdict
    assert "cell-1: moved or changed since the notebook was run" in verdict
