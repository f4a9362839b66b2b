"""`matrixproof` needs SymPy alone, and its README does what it says."""

import pathlib
import shutil
import subprocess
import sys

import pytest

ENGINE = pathlib.Path(__file__).parents[2] / "lib" / "matrixproof"
README = (ENGINE / "README.md").read_text(encoding="utf-8")
# a Python that has nothing but SymPy, in a folder with this package
ALONE = """
import sys
from importlib.abc import MetaPathFinder

class Nothing(MetaPathFinder):
    def find_spec(self, name, path=None, target=None):
        top = name.partition(".")[0]
        if top not in {*sys.stdlib_module_names, "sympy", "mpmath", "matrixproof"}:
            raise ModuleNotFoundError(f"there is no {top} here", name=top)

sys.meta_path.insert(0, Nothing())
sys.path.insert(0, ".")
"""
EXAMPLES = """
import doctest, pathlib, matrixproof
assert pathlib.Path(matrixproof.__file__).parent.parent == pathlib.Path.cwd()
page = pathlib.Path("matrixproof/README.md").resolve()
print(doctest.testfile(str(page), module_relative=False, encoding="utf-8"))
"""


def alone(folder, code, readme=README):
    shutil.copytree(ENGINE, folder / "matrixproof")
    (folder / "matrixproof" / "README.md").write_text(readme, encoding="utf-8")
    return subprocess.run(
        [sys.executable, "-X", "utf8", "-c", ALONE + code],
        cwd=folder,
        capture_output=True,
        text=True,
        encoding="utf-8",
    )


def test_its_readme_holds_where_there_is_sympy_alone(tmp_path):
    run = alone(tmp_path, EXAMPLES)
    assert run.stdout == f"TestResults(failed=0, attempted={README.count('>>> ')})\n"
    assert README.count(">>> ") > 8


def test_an_example_that_is_wrong_is_noticed(tmp_path):
    wrong = README.replace("H' H x = H' y", "H' H x = y")
    assert wrong != README and "failed=1" in alone(tmp_path, EXAMPLES, wrong).stdout


@pytest.mark.parametrize("name", ["numpy", "luenberger"])
def test_this_test_has_nothing_but_sympy(name, tmp_path):
    run = alone(tmp_path, f"import {name}")
    assert run.stderr.endswith(f"ModuleNotFoundError: there is no {name} here\n")


def test_its_readme_is_one_screen():
    assert len(README.splitlines()) <= 70
