"""Every derivation of the library."""

import functools
import importlib
import inspect
import pkgutil

from luenberger import papers
from matrixproof import Derivation


@functools.cache
def derivations():
    """Every page of the papers, and every stage list that a function returns."""
    found = []
    for name in pkgutil.walk_packages(papers.__path__, f"{papers.__name__}."):
        if ".derivation." not in name.name:
            continue
        module = importlib.import_module(name.name)
        for made in vars(module).values():
            if (
                isinstance(made, functools._lru_cache_wrapper)
                and made.__module__ == module.__name__
                and not inspect.signature(made).parameters
            ):
                made = made()
            if isinstance(made, Derivation):
                found.append(made)
    return found
