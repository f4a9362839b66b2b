"""What students get, made of a course of two notebooks: whole, and never a solution."""

import ast
import importlib.util
import json
import pathlib
import re
import sys
import tomllib
import zipfile

import pytest

ROOT = pathlib.Path(__file__).parents[2]
COURSE = ROOT / "notebooks" / "coursework"
WHEEL = "luenberger-1.0-py3-none-any.whl"
NOTEBOOKS = ("one/one.ipynb", "two/two.ipynb")


@pytest.fixture
def program(monkeypatch, tmp_path):
    """hand_out.py in a course of its own, and the folder of that course."""
    where = importlib.util.spec_from_file_location("hand_out", COURSE / "hand_out.py")
    program = importlib.util.module_from_spec(where)
    where.loader.exec_module(program)
    assert program.HERE == COURSE
    monkeypatch.setattr(program, "HERE", tmp_path)
    for name in NOTEBOOKS:
        path = tmp_path / "release" / name
        path.parent.mkdir(parents=True)
        path.write_text(f"notebook {name}")
    add_wheel(tmp_path, WHEEL, {"luenberger/__init__.py": ""})
    write_environment(tmp_path, ROOT.joinpath("environment-pip.txt").read_text())
    return program


def add_wheel(folder, name, files):
    (folder / "wheel").mkdir(exist_ok=True)
    with zipfile.ZipFile(folder / "wheel" / name, "w") as archive:
        for path, text in files.items():
            archive.writestr(path, text)


def write_environment(folder, text):
    (folder / "environment-pip.txt").write_text(text)


def contents(folder):
    files = (path for path in folder.rglob("*") if path.is_file())
    return {path.relative_to(folder).as_posix(): path.read_bytes() for path in files}


def test_the_folder_holds_the_release_and_how_to_install_it(program, tmp_path):
    old = tmp_path / "hand-out" / "three" / "of-last-year.ipynb"
    old.parent.mkdir(parents=True)
    old.touch()
    program.main()
    found = contents(tmp_path / "hand-out")
    for name in NOTEBOOKS:
        assert found.pop(name) == (tmp_path / "release" / name).read_bytes()
    assert found.pop(WHEEL) == (tmp_path / "wheel" / WHEEL).read_bytes()
    assert set(found) == {"requirements.txt", "INSTALL.md"}
    *packages, library = found["requirements.txt"].decode().splitlines()
    assert library == f"./{WHEEL}"
    assert set(packages) < set((tmp_path / "environment-pip.txt").read_text().split())
    assert {one.partition("==")[0] for one in packages} == set(program.PACKAGES)


def imported(path):
    """What a notebook imports that comes neither with Python nor with the library."""
    own = {*sys.stdlib_module_names, "luenberger", "matrixproof"}
    for cell in json.loads(path.read_text(encoding="utf-8"))["cells"]:
        if cell["cell_type"] == "code":
            for node in ast.walk(ast.parse("".join(cell["source"]))):
                names = [one.name for one in getattr(node, "names", ())]
                if isinstance(node, ast.ImportFrom):
                    names = [node.module]
                if isinstance(node, ast.Import | ast.ImportFrom):
                    yield from {name.partition(".")[0] for name in names} - own


def test_the_packages_are_those_that_the_library_and_the_notebooks_need(program):
    project = tomllib.loads((ROOT / "lib" / "pyproject.toml").read_text())["project"]
    needed = {re.split("[<>=]", one)[0] for one in project["dependencies"]}
    needed = needed.union(*map(imported, COURSE.glob("source/*/*.ipynb")))
    needed -= {"IPython"}  # comes with ipykernel
    assert needed | {"jupyter", "ipykernel"} == set(program.PACKAGES)


def test_the_page_has_five_steps_with_what_is_in_the_folder(program, tmp_path):
    program.main()
    folder = tmp_path / "hand-out"
    page = (folder / "INSTALL.md").read_text(encoding="utf-8")
    assert re.findall(r"^(\d)\. ", page, re.M) == list("12345")
    workflow = (ROOT / ".github" / "workflows" / "tests.yml").read_text()
    pythons = re.findall(r'"(3\.\d+)"', workflow.partition("python: [")[2])
    assert re.findall(r"3\.\d+", page) == pythons
    make, install, start = re.findall(r"^[2-4]\. `(.*?)` ?\(", page, re.M) or [""] * 3
    assert make == "python3 -m venv .venv"
    python, *words = install.split()
    assert python == ".venv/bin/python" and words[:4] == ["-m", "pip", "install", "-r"]
    assert (folder / words[4]).is_file() and len(words) == 5
    assert start == ".venv/bin/jupyter lab"
    windows = re.findall(r"`\.venv\\Scripts\\(\w+)", page)
    assert windows == ["python", "jupyter"] and "`py -m venv .venv`" in page


HIDDEN = "### BEGIN HIDDEN TESTS\n"
ENVIRONMENT = "numpy==2\nscipy==1\nsympy==1\nmatplotlib==3\njupyter==1\nipykernel==6\n"


def released(folder):
    (folder / "release" / NOTEBOOKS[1]).write_text(HIDDEN)


def nothing_released(folder):
    (folder / "release").rename(folder / "elsewhere")


def in_the_wheel(folder):
    add_wheel(folder, WHEEL, {"luenberger/a.py": "", "luenberger/b/c.py": HIDDEN})


def two_wheels(folder):
    add_wheel(folder, "luenberger-0.9-py3-none-any.whl", {})


def no_wheel(folder):
    (folder / "wheel" / WHEEL).rename(folder / "wheel" / f"not-{WHEEL}")


def not_named(folder):
    write_environment(folder, ENVIRONMENT.replace("sympy==1\n", ""))


def not_exact(folder):
    loose = ENVIRONMENT.replace("scipy==1", "scipy>=1")
    write_environment(folder, loose.replace("numpy==2", "numpy"))


@pytest.mark.parametrize(
    ("fault", "says"),
    [
        (released, r"two\.ipynb holds a solution"),
        (nothing_released, r"release/ is empty: nbgrader generate_assignment"),
        (in_the_wheel, rf"{WHEEL} holds a solution, in luenberger/b/c\.py"),
        (two_wheels, r"wheel/ has 2 wheels"),
        (no_wheel, r"wheel/ has 0 wheels"),
        (not_named, r"environment-pip\.txt does not pin sympy$"),
        (not_exact, r"environment-pip\.txt does not pin numpy, scipy$"),
    ],
)
def test_what_is_not_whole_is_refused_and_what_was_made_stays(
    fault, says, program, tmp_path
):
    program.main()
    before = contents(tmp_path / "hand-out")
    fault(tmp_path)
    with pytest.raises(SystemExit, match=rf"^hand_out\.py: .*{says}"):
        program.main()
    assert contents(tmp_path / "hand-out") == before
