"""For the conftest.py beside notebooks: from notebook_tests.in_pytest import *"""

import json
import os

import pytest

from . import stored

__all__ = ["pytest_collect_file", "pytest_runtest_setup"]

# Kernels inherit these; outputs then do not depend on the terminal or the machine.
os.environ.update(
    COLUMNS="80",
    MPLBACKEND="module://matplotlib_inline.backend_inline",
    OMP_NUM_THREADS="1",
    OPENBLAS_NUM_THREADS="1",
    PYTHONHASHSEED="0",
)


def pytest_runtest_setup(item):
    """nbval runs a cell without stored outputs but compares nothing: refuse it."""
    cell = getattr(item, "cell", None)
    if cell is not None and cell.source.strip() and cell.execution_count is None:
        pytest.fail("this cell is stored without having been run", pytrace=False)


def pytest_collect_file(file_path, parent):
    """Beside nbval's cells each notebook has a test of how it is stored."""
    if file_path.suffix == ".ipynb" and ".ipynb_checkpoints" not in file_path.parts:
        return Notebook.from_parent(parent, path=file_path)
    return None


class Notebook(pytest.File):
    def collect(self):
        yield Stored.from_parent(self, name="as stored")


class Stored(pytest.Item):
    def runtest(self):
        notebook = json.loads(self.path.read_text(encoding="utf-8"))
        if found := list(stored.complaints(notebook)):
            pytest.fail("\n".join(found), pytrace=False)

    def reportinfo(self):
        return self.path, None, f"{self.path.name} as stored"
