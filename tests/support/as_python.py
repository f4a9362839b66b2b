"""Generated code as plain Python: what a text computes, without compiling it.

Numba takes a second or two for each text.  So tests of many plants run their texts as
Python, and compile one of each kind.
"""

import functools
from contextlib import contextmanager, nullcontext

import numpy as np
import pytest

from luenberger import kernels
from luenberger.kernels import cache

ASKED = [(kernels, "over_record"), (cache, "compiled")]


@contextmanager
def as_python():
    """Within it numba compiles nothing, and what it compiled before is not used."""
    numba = pytest.importorskip("numba", reason="numba is an optional extra")
    asked = [getattr(module, name) for module, name in ASKED]
    before = [one.cache_info().misses for one in asked]
    with pytest.MonkeyPatch.context() as patch, np.errstate(all="ignore"):
        patch.setattr(numba.config, "DISABLE_JIT", True)
        for module, name in ASKED:  # which keep what they are asked for
            anew = functools.cache(getattr(module, name).__wrapped__)
            patch.setattr(module, name, anew)
        yield
    after = [one.cache_info().misses for one in asked]
    assert after == before, "code is kept as Python: a module asks in a way of its own"


@pytest.fixture(params=["numpy", "python", "numba"])
def backend(request):
    """NumPy, or generated code: its text as Python, or what numba makes of it."""
    if request.param == "numba":
        pytest.importorskip("numba", reason="numba is an optional extra")
    with as_python() if request.param == "python" else nullcontext():
        yield "numpy" if request.param == "numpy" else "numba"
