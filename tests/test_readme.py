"""The README: its example runs, its numbers are right, its links and commands exist."""

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
EXAMPLE = re.search(r"```python\n(.+?)```", README, re.S)[1]
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


def test_links_exist():
    links = [link for link in re.findall(r"\]\(([^)#]+)\)", README) if "//" not in link]
    assert links and all((ROOT / link).exists() for link in links)


def test_tables_have_a_head_and_rows_of_one_width():
    prose = re.sub(r"```.*?```", "", README, flags=re.S)
    tables = re.findall(r"(?:^\|.*\n)+", prose, re.M)
    assert len(tables) > 5
    for table in tables:
        rows = [line.count("|") - line.count(r"\|") for line in table.splitlines()]
        assert re.match(r".*\n\|( *-+ *\|)+\n", table), f"no head above {table[:60]}"
        assert len(set(rows)) == 1, f"rows of different widths under {table[:60]}"


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


def test_what_comes_before_the_designs_is_two_screens():
    before = README.partition("## Design")[0]
    assert before.count("](notebooks/pages/pictures/") == 2
    assert len(before.splitlines()) < 45


def test_every_notebook_is_listed():
    for path in (ROOT / "notebooks").glob("*.ipynb"):
        assert f"(notebooks/{path.name})" in README


def test_the_two_commands_and_no_third_way():
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


def test_the_example_of_compare_recommends_what_it_says():
    names = {}
    exec(EXAMPLE, names)
    second = re.findall(r"```python\n(.+?)```", README, re.S)[1]
    exec(second, names)
    said = re.search(r"recommended\(\).name  # '(.+)'", second)[1]
    assert names["table"].recommended().name == said
    for call in re.findall(r"`lb\.(plot\.\w+)\(", README):
        assert hasattr(names["lb"].plot, call.partition(".")[2])
