"""Which functions a test enters, noted by the functions themselves.

While tests are collected, every function of the package notes its name when it starts,
in subprocesses too.  What a cached function, a fixture or the head of a test file did
once counts for every test that has the use of it.
"""

import ast
import functools
import os
import sys
import uuid
from importlib.abc import MetaPathFinder
from importlib.machinery import PathFinder, SourceFileLoader
from pathlib import Path

entered = set()


def noting(tree, path):
    """The tree with a first statement in each function that notes ``path::name``."""

    def visit(node, where):
        for child in ast.iter_child_nodes(node):
            inner = where
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                inner = f"{where}.{child.name}".strip(".")
            visit(child, inner)
        if isinstance(node, ast.FunctionDef):
            note = ast.parse(f"__entered__({f'{path}::{where}'!r})").body[0]
            start = 1 if ast.get_docstring(node, clean=False) is not None else 0
            place = node.body[min(start, len(node.body) - 1)]
            for part in ast.walk(note):
                ast.copy_location(part, place)
            node.body.insert(start, note)

    visit(tree, "")
    return tree


class Noting(MetaPathFinder):
    """Imports the package below `root` with functions that note their names."""

    def __init__(self, root, package):
        self.root, self.package = Path(root), package

    def find_spec(self, name, path=None, target=None):
        if name.partition(".")[0] != self.package:
            return None
        spec = PathFinder.find_spec(name, path)
        if spec is not None and type(spec.loader) is SourceFileLoader:
            spec.loader = _Loader(spec.loader.name, spec.loader.path)
            spec.loader.root = self.root
        return spec

    def install(self):
        import builtins

        builtins.__entered__ = entered.add
        functools.cache = cache
        functools.lru_cache = lru_cache
        sys.meta_path.insert(0, self)


class _Loader(SourceFileLoader):
    def get_code(self, fullname):
        path = Path(self.path)
        tree = ast.parse(path.read_bytes())
        name = path.relative_to(self.root).as_posix()
        return compile(noting(tree, name), self.path, "exec", dont_inherit=True)


def lru_cache(maxsize=128, typed=False, real=functools.lru_cache):
    """functools.lru_cache whose results bring along what was entered to make them."""

    def decorate(function):
        made = {}

        @real(maxsize=maxsize, typed=typed)
        def remembered(*args, **options):
            before = entered.copy()
            entered.clear()
            try:
                return function(*args, **options)
            finally:
                made[args, tuple(options.items())] = entered.copy()
                entered.update(before)

        @functools.wraps(function)
        def outer(*args, **options):
            result = remembered(*args, **options)
            entered.update(made.get((args, tuple(options.items())), ()))
            return result

        outer.cache_clear, outer.cache_info = (
            remembered.cache_clear,
            remembered.cache_info,
        )
        return outer

    if callable(maxsize):
        function, maxsize = maxsize, 128
        return decorate(function)
    return decorate


def cache(function):
    return lru_cache(None)(function)


def in_subprocesses(folder, root, package):
    """Environment variables with which Python processes below this one note as well."""
    return dict(REACH_FOLDER=str(folder), REACH_ROOT=str(root), REACH_PACKAGE=package)


def install_from_environment():
    """For sitecustomize: note, and leave a file at exit."""
    import atexit

    Noting(os.environ["REACH_ROOT"], os.environ["REACH_PACKAGE"]).install()

    def leave():
        path = Path(os.environ["REACH_FOLDER"]) / f"{uuid.uuid4().hex}"
        path.write_text("\n".join(entered), encoding="utf-8")
        path.rename(path.with_suffix(".txt"))

    atexit.register(leave)
