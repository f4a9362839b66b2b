"""Generated code as plain Python, each way of writing it, and the rows it leaves."""

import pytest
from as_python import as_python
from in_numpy import rows_by_hand

from luenberger import kernels
from luenberger.kernels import cache, loops, solves, tiles
from luenberger.kernels import numba as printer


@pytest.fixture
def plain(monkeypatch):
    """The generated code as Python, without numba; nothing of it is kept."""
    monkeypatch.setattr(cache, "usable_folder", lambda: None)
    with as_python():
        yield


@pytest.fixture(params=["scalars", "loops", "large"])
def form(request, monkeypatch, plain):
    """Each way of writing a kernel; "large" is what large plants get."""
    monkeypatch.setattr(kernels, "UNROLLED", 10**6 * (request.param == "scalars"))
    if request.param == "large":
        monkeypatch.setattr(loops, "SHORT", 0)
        monkeypatch.setattr(solves, "TILED_SOLVE", 0)
        monkeypatch.setattr(tiles, "ALONE", 1)
        monkeypatch.setattr(tiles, "BLOCK", 2)
        monkeypatch.setattr(printer, "ON_STACK", 0)
    return request.param


@pytest.fixture
def by_hand(monkeypatch):
    """The instants before rows that NumPy does, from the beginning."""
    return rows_by_hand(monkeypatch)
