"""Every claim of the library with the relations it rests on."""

import functools
import importlib
import inspect
import pkgutil

from luenberger import papers
from luenberger.symbolic import Derivation


def cached_functions():
    """Functions of the derivations that take no arguments and keep what they make."""
    for found in pkgutil.walk_packages(papers.__path__, f"{papers.__name__}."):
        if ".derivation." not in found.name:
            continue
        module = importlib.import_module(found.name)
        for function in vars(module).values():
            if (
                isinstance(function, functools._lru_cache_wrapper)
                and function.__module__ == module.__name__
                and not inspect.signature(function).parameters
            ):
                yield function


@functools.cache
def derivations():
    """Every `Derivation` of the library."""
    made = (function() for function in cached_functions())
    return [d for d in made if isinstance(d, Derivation)]


@functools.cache
def algebras():
    """{algebra: {name: claim}} of the claims about matrices of symbolic sizes."""
    found = {}
    for derivation in derivations():
        for name, claim in derivation.steps.items():
            if getattr(claim, "algebra", None) is not None:
                found.setdefault(claim.algebra, {})[name] = claim
    return found
