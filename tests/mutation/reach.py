"""Which functions a test enters and which branches, noted by the functions themselves.

While tests are collected, every function of the package notes its name when it starts,
in subprocesses too; and where statements that may not be reached begin, its name and
how many lines below its head they are, ``path::name+3``.  What a cached function, a
fixture or the head of a test file did once counts for every test that can use it.
"""

import ast
import functools
import os
import sys
import uuid
from importlib.abc import MetaPathFinder
from importlib.machinery import PathFinder, SourceFileLoader
from pathlib import Path

BLOCKS = "body", "orelse", "finalbody"
INNER = ast.FunctionDef | ast.AsyncFunctionDef | ast.ClassDef
entered = set()


def runs(node):
    """(block, statement) wherever statements begin that are reached or not, as one."""
    for block in (getattr(node, name, ()) for name in BLOCKS):
        begins = True
        for statement in block:
            if begins:
                yield block, statement
            begins = hasattr(statement, "body") and not isinstance(statement, INNER)
    for child in ast.iter_child_nodes(node):
        statements = isinstance(child, ast.stmt | ast.ExceptHandler | ast.match_case)
        if statements and not isinstance(child, INNER):
            yield from runs(child)


def named(name, function, statement):
    below = statement.lineno - function.lineno
    return name if statement is function.body[0] else f"{name}+{below}"


def noting(tree, path):
    """The tree with statements that note ``path::name`` and ``path::name+3``."""

    def visit(node, where):
        for child in ast.iter_child_nodes(node):
            inner = where
            if isinstance(child, ast.FunctionDef | ast.ClassDef):
                inner = f"{where}.{child.name}".strip(".")
            visit(child, inner)
        if isinstance(node, ast.FunctionDef):
            notes = [
                (block, first, named(f"{path}::{where}", node, first))
                for block, first in runs(node)
            ]
            documented = ast.get_docstring(node, clean=False) is not None
            for block, first, name in notes:
                note = ast.parse(f"__entered__({name!r})").body[0]
                for part in ast.walk(note):
                    ast.copy_location(part, first)
                after = documented and first is node.body[0]
                block.insert(block.index(first) + after, note)

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
