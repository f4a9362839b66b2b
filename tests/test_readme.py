"""The README: its example runs, its numbers are right, its links and commands exist."""

import ast
import pathlib
import re

import numpy as np

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


def test_every_notebook_is_listed():
    for path in (ROOT / "notebooks").glob("*.ipynb"):
        assert f"(notebooks/{path.name})" in README


def test_the_two_commands_and_no_third_way():
    commands = [line for line in README.splitlines() if line.startswith("python3 ")]
    design = "-m luenberger design notebooks/plants/reactor.json --out report"
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
