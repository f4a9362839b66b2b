"""Collection in half the time: each worker of xdist collects every test by itself."""

import gc

import pytest

EXAMPLE = b">>>"


@pytest.hookimpl(wrapper=True)
def pytest_collection():
    """What is collected stays: the garbage collector never looks through it."""
    gc.disable()
    try:
        return (yield)
    finally:
        gc.freeze()
        gc.enable()


@pytest.hookimpl(wrapper=True)
def pytest_collect_file(file_path):
    """Doctest imports each file and looks through it; one without example is spared."""
    found = yield
    if file_path.suffix == ".py" and EXAMPLE not in file_path.read_bytes():
        return [one for one in found if type(one).__name__ != "DoctestModule"]
    return found
