"""What is public, or called from another room, says what it takes and gives.

mypy checks that what is said is true: `.ci/run` has it read [tool.mypy] of
lib/pyproject.toml, where the rooms stand in which every function is annotated.
"""

import ast
import inspect
import pathlib
import re
import tomllib
from functools import cache

import pytest
from house import DOOR, FILES, module, parts_of, relative, room_of_file, statements

import luenberger as lb

LIB = pathlib.Path(__file__).parents[1] / "lib"
PROJECT = tomllib.loads((LIB / "pyproject.toml").read_text(encoding="utf-8"))["tool"]
DOORS = ("__init__", "export", "plot", "sampling", "ledger", "matrixproof")


@cache
def tree(path):
    return ast.parse(path.read_text(encoding="utf-8"))


@cache
def imported(path):
    """{name: (parts of the module, name in it)} of what a file imports from here."""
    found, package = {}, parts_of(path)[:-1]
    for node, _ in statements(tree(path)):
        if isinstance(node, ast.ImportFrom):
            parts = tuple(node.module.split(".")) if node.module else ()
            if node.level:
                parts = package[: len(package) - (node.level - 1)] + parts
            elif parts[0] != "matrixproof":
                continue
            for alias in node.names:
                found[alias.asname or alias.name] = (parts, alias.name)
    return found


@cache
def definition(parts, name):
    """The file and node of a function or class, wherever it is imported from."""
    path = module(*parts)
    if path is None:
        return None
    for node in tree(path).body:
        if getattr(node, "name", None) == name:
            return path, node
    again = imported(path).get(name)
    return definition(*again) if again else None


@cache
def attributes(path):
    """{name: attributes that are taken of it} in a file."""
    found = {}
    for node in ast.walk(tree(path)):
        if isinstance(node, ast.Attribute) and isinstance(node.value, ast.Name):
            found.setdefault(node.value.id, []).append(node.attr)
    return found


def used(path):
    """What a file takes from other modules: names, and attributes of modules."""
    for name, (parts, original) in imported(path).items():
        if module(*parts, original) is None:
            yield definition(parts, original)
        else:
            for attribute in attributes(path).get(name, ()):
                yield definition((*parts, original), attribute)


def public():
    """What has a public name: of `lb`, and of the modules that it hands out."""
    for name in DOORS:
        path = module(name) or DOOR
        parts = () if path == DOOR else (name,)
        here = {node.name: None for node in tree(path).body if hasattr(node, "name")}
        for one, origin in (here | imported(path)).items():
            is_module = origin and module(*origin[0], origin[1])
            if not one.startswith("_") and not is_module:
                yield definition(parts, one)


def called_from_other_rooms():
    for path in FILES:
        if path != DOOR:
            room = room_of_file(path)
            yield from (
                found
                for found in used(path)
                if found and room_of_file(found[0]) != room
            )


def functions(node):
    """A function, or those methods of a class that others call; no `Text`."""
    texts = [one.id for one in node.decorator_list if isinstance(one, ast.Name)]
    if isinstance(node, ast.FunctionDef) and "Text" not in texts:
        yield node
    for one in getattr(node, "body", ()) if isinstance(node, ast.ClassDef) else ():
        if isinstance(one, ast.FunctionDef):
            if not one.name.startswith("_") or one.name in ("__init__", "__call__"):
                yield one


def is_typed(function):
    """Whether every parameter, but self, and the result have annotations."""
    given = function.args
    named = [*given.posonlyargs, *given.args, *given.kwonlyargs]
    named = [arg for arg in named if arg.arg not in ("self", "cls")]
    every = [*named, *filter(None, [given.vararg, given.kwarg])]
    return function.returns is not None and all(arg.annotation for arg in every)


def test_what_others_see_is_annotated():
    seen = {
        (relative(path), function.name, function.lineno): is_typed(function)
        for path, node in filter(None, [*public(), *called_from_other_rooms()])
        for function in functions(node)
    }
    assert len(seen) > 100
    assert not [place for place, typed in seen.items() if not typed]


@pytest.mark.parametrize(
    ("source", "typed"),
    [
        ("def f(x: int) -> int: ...", True),
        ("def f(x) -> int: ...", False),
        ("def f(*x, y: int) -> int: ...", False),
        ("def f(*, y) -> int: ...", False),
        ("def f(x: int): ...", False),
        ("class A:\n    def f(self) -> None: ...", True),
        ("class A:\n    def f(self): ...", False),
        ("class A:\n    def _f(self): ...", True),
        ("class A:\n    def __init__(self, x): ...", False),
    ],
)
def test_this_test_reads_annotations(source, typed):
    (node,) = ast.parse(source).body
    assert all(map(is_typed, functions(node))) is typed


def test_this_test_sees_what_is_public_or_shared():
    seen = {node.name for _, node in filter(None, public())}
    assert {"Plant", "simulate", "kalman_filter", "to_c", "gains", "prove"} <= seen
    names = [name for name in vars(lb) if callable(vars(lb)[name]) and name[0] != "_"]
    assert set(names) - {"import_module"} <= seen
    shared = {node.name for _, node in called_from_other_rooms()}
    assert {"solve_right", "short", "latex"} <= shared


@pytest.mark.parametrize("name", ["luenberger", "matrixproof"])
def test_a_package_is_installed_and_says_that_it_is_typed(name):
    marker, tools = LIB / name / "py.typed", PROJECT["setuptools"]
    assert f"{name}*" in tools["packages"]["find"]["include"]
    assert marker.is_file() and marker.name in tools["package-data"][name]


@pytest.mark.parametrize("name", [name for name in vars(lb) if name[0] != "_"])
def test_what_help_prints_is_readable(name):
    found = vars(lb)[name]
    if inspect.isfunction(found):  # NumPy's own ArrayLike takes 300 characters
        assert "numpy._typing" not in str(inspect.signature(found))


def test_a_property_is_described_without_a_colon():
    """The pages take what stands before a colon in the first line for the type."""
    properties = [
        (path, node)
        for path in FILES
        for node, _ in statements(tree(path))
        if isinstance(node, ast.FunctionDef) and not node.name.startswith("_")
        if re.search("property", " ".join(map(ast.unparse, node.decorator_list)))
    ]
    assert len(properties) > 100
    wrong = [
        (relative(path), node.name)
        for path, node in properties
        if ":" in (ast.get_docstring(node) or "").partition("\n")[0]
    ]
    assert not wrong
