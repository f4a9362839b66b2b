"""README and guide: examples run, numbers are right, links and commands exist."""

import ast
import importlib.util
import pathlib
import re

import matplotlib
import numpy as np
import pytest
from PIL import Image

ROOT = pathlib.Path(__file__).parents[1]
README = (ROOT / "README.md").read_text(encoding="utf-8")
PAGES = [ROOT / "README.md", ROOT / ".github" / "CONTRIBUTING.md"]
PAGES += sorted((ROOT / "notebooks" / "pages" / "guide").glob("*.md"))
PYTHON = re.compile(r"```python\n(.+?)```", re.S)
EXAMPLE = PYTHON.search(README)[1]
SETUP = "python3 -m venv .venv && .venv/bin/python -m pip install -q "
SETUP += "-r environment-pip.txt && "


def test_example_gives_the_numbers_in_its_comments():
    names, compared = {}, 0
    lines = EXAMPLE.splitlines()
    for statement in ast.parse(EXAMPLE).body:
        source = ast.get_source_segment(EXAMPLE, statement)
        comment = lines[statement.end_lineno - 1].partition("#")[2]
        if not isinstance(statement, ast.Expr):
            exec(source, names)
            continue
        value = eval(source, names)
        said = [float(text) for text in re.findall(r"-?\d+\.?\d*", comment)]
        parts = value if isinstance(value, tuple) else (value,)
        if "Kalman" in comment:
            lb, plant = names["lb"], names["plant"]
            parts += (lb.error_covariance(lb.kalman_filter(plant), plant).trace(),)
        if said:
            found = np.concatenate([np.ravel(part) for part in parts])
            np.testing.assert_allclose(found, said, atol=5.1e-5)
            compared += 1
    assert compared == 2


def name_of(path):
    return path.relative_to(ROOT).as_posix()


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_the_examples_of_a_page_run(path, tmp_path, monkeypatch):
    blocks = PYTHON.findall(path.read_text(encoding="utf-8"))
    if not blocks:
        return
    (tmp_path / "notebooks").symlink_to(ROOT / "notebooks")
    monkeypatch.chdir(tmp_path)
    names = {}
    for block in blocks:
        exec(block, names)
        for line in block.splitlines():
            if said := re.fullmatch(r"(.+?)  # '(.+)'", line):
                assert eval(said[1], names) == said[2]


@pytest.mark.parametrize("path", PAGES, ids=name_of)
def test_links_exist(path):
    text = path.read_text(encoding="utf-8")
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", text) if "//" not in link]
    assert [link for link in links if not (path.parent / link).exists()] == []


@pytest.fixture(scope="module")
def pictures():
    """The script that draws the README's pictures."""
    path = ROOT / ".ci" / "readme_pictures.py"
    spec = importlib.util.spec_from_file_location(path.stem, path)
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


@pytest.mark.parametrize("name", ["ball-on-a-beam", "chain-and-code"])
def test_pictures_are_those_that_the_library_draws(name, pictures):
    path = pictures.FOLDER / f"{name}.png"
    assert f"]({path.relative_to(ROOT).as_posix()})" in README
    figure = pictures.PICTURES[name]()
    stored, words = Image.open(path), pictures.words(figure)
    figure.canvas.draw()
    drawn = Image.fromarray(np.asarray(figure.canvas.buffer_rgba()))
    pictures.plt.close(figure)
    assert stored.text["Description"] == words
    small = [
        np.asarray(image.convert("L").resize((64, 16))) for image in (drawn, stored)
    ]
    most = 4 if matplotlib.__version_info__ >= (3, 11) else 6  # lines lay closer there
    assert np.abs(small[0].astype(int) - small[1]).mean() < most


def test_every_notebook_is_listed():
    listed = (ROOT / "notebooks" / "index.md").read_text(encoding="utf-8")
    for path in (ROOT / "notebooks").glob("*.ipynb"):
        assert f"({path.name})" in listed


def test_the_two_commands():
    commands = [line for line in README.splitlines() if line.startswith("python3 ")]
    design = (
        "-m luenberger design notebooks/plants/ball-and-beam.json "
        "--data notebooks/plants/ball-and-beam.csv --out report"
    )
    assert commands == [
        f"{SETUP}.venv/bin/python {design}",
        f"{SETUP}.venv/bin/python -m pytest",
    ]
    assert commands[1] in (ROOT / ".ci" / "run").read_text(encoding="utf-8")


def test_direct_dependencies_are_pinned_exactly():
    lines = (ROOT / "environment-pip.txt").read_text(encoding="utf-8").splitlines()
    given = [line for line in lines if line and not line.startswith("#")]
    assert given[-1] == "-e ./lib"
    assert all(re.fullmatch(r"[\w-]+==[\d.]+", line) for line in given[:-1])
