"""What every notebook's kernel starts from, and a guard that strict nbval lacks."""

import os

import pytest

# these run inside nbgrader and Sphinx only
collect_ignore = ["coursework/nbgrader_config.py", "conf.py", "pages/extensions"]

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
