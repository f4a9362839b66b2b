"""Imports point one way, the library stays light, and modules stay short."""

import ast
import pathlib
import subprocess
import sys

import pytest

ROOT = pathlib.Path(__file__).parents[1]
PACKAGE = ROOT / "lib" / "luenberger"

# A layer may import only itself and what is listed for it.
TYPES = {"arrays", "errors", "record"}
NUMERIC = TYPES | {
    *("arguments", "balance", "certificate", "detectability", "factors", "kernels"),
    *("linalg", "mean_square", "observer", "plant"),
}
QUESTIONS = {"analysis", "ensemble", "filtering", "recorded", "simulate"}
ALLOWED = {
    "errors": set(),
    "arrays": {"inputs"},
    "files": set(),
    "inputs": set(),
    "spreadsheets": {"inputs"},
    "tables": {"inputs"},
    "frames": set(),
    "statespace": set(),
    "record": {"files", "inputs"},
    "show": set(),
    "offline": set(),
    "symbolic": set(),
    "derivations": {"certificate", "symbolic"},
    "kernels": {"derivations", "factors", "linalg"},
    "ledger": {"derivations", "files", "show", "symbolic"},
    "arguments": {"observer", "plant"},
    "certificate": {"arguments", "balance", "errors"},
    "linalg": {"errors"},
    "covariance_maps": {"errors", "linalg"},
    "balance": set(),
    "detectability": {"errors", "linalg"},
    "factors": set(),
    "mean_square": {"covariance_maps", "errors", "factors", "kernels", "linalg"},
    "plant": TYPES | {"inputs", "statespace"},
    "observer": TYPES | {"linalg"},
    "stairs": {"arrays", "errors", "linalg"},
    "optimality": NUMERIC,
    "designs": NUMERIC | {"optimality", "stairs"},
    "recorded": NUMERIC | {"frames", "inputs"},
    "simulate": NUMERIC | {"recorded"},
    "parallel": set(),
    "claims": NUMERIC | {"analysis"},
    "batches": NUMERIC | {"claims", "recorded", "simulate"},
    "ensemble": NUMERIC | {"analysis", "batches", "claims", "parallel", "simulate"},
    "sweep": NUMERIC | {"analysis", "parallel", "show"},
    "analysis": NUMERIC,
    "filtering": NUMERIC | {"designs", "frames", "recorded"},
    "measurements": NUMERIC | QUESTIONS | {"inputs", "tables"},
    "streaming": NUMERIC
    | QUESTIONS
    | {"inputs", "measurements", "spreadsheets", "tables"},
    "sampling": NUMERIC | {"simulate"},
    "compare": NUMERIC
    | QUESTIONS
    | {"designs", "export", "measurements", "optimality", "show", "stairs"},
    "plot": {"arguments", "compare", "observer", "plant", "show"},
    "report": {"compare", "inputs", "show"},
    "results": {"measurements", "record"},
    "export": NUMERIC | {"designs", "files", "filtering", "recorded", "statespace"},
    "examination": NUMERIC | {"designs", "stairs"},
    "commands": NUMERIC
    | {"compare", "examination", "export", "files", "inputs", "ledger"}
    | {"measurements", "offline", "results", "show", "spreadsheets", "streaming"}
    | {"tables"},
    "__main__": {"commands"},
}
EVERYWHERE = {"numpy", "scipy"}
SPECIAL = {
    "symbolic": {"sympy"},
    "derivations": {"sympy"},
    "kernels": {"sympy", "numpy"},
    "ledger": {"sympy"},
    "plot": {"numpy", "matplotlib"},
    "report": {"numpy", "matplotlib"},
}
# Optional packages: only inside a function of these layers.
INSIDE_A_FUNCTION = {
    "export": {"control"},
    "parallel": {"tqdm"},
    "kernels": {"numba", "llvmlite"},
    "ledger": {"latex2mathml"},
    "offline": {"nbclient", "nbconvert", "nbformat", "latex2mathml"},
}
FILES = sorted(
    path for path in PACKAGE.rglob("*.py") if path.parent.name != "templates"
)


def layer_of(path):
    return path.relative_to(PACKAGE).parts[0].removesuffix(".py")


def relative(path):
    return str(path.relative_to(PACKAGE))


def imports(source, package):
    """Layers, outside names at module level, and outside names inside functions.

    `package` is the path of the module's package below luenberger, as a tuple.
    """
    tree = ast.parse(source)
    lazy = {
        id(node)
        for outer in ast.walk(tree)
        if isinstance(outer, ast.FunctionDef | ast.AsyncFunctionDef)
        for node in ast.walk(outer)
    }
    layers, outside, inside = set(), set(), set()
    for node in ast.walk(tree):
        names = inside if id(node) in lazy else outside
        if isinstance(node, ast.Import):
            names |= {alias.name.partition(".")[0] for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.level == 0:
            names.add(node.module.partition(".")[0])
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - (node.level - 1)]
            target = base + tuple((node.module or "").split("."))
            first = next((part for part in target if part), None)
            layers |= {first} if first else {alias.name for alias in node.names}
    standard = sys.stdlib_module_names
    return layers, outside - standard, inside - standard


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_imports_point_one_way(path):
    layer = layer_of(path)
    package = path.relative_to(PACKAGE).parent.parts
    layers, outside, inside = imports(path.read_text(encoding="utf-8"), package)
    if layer == "__init__":  # the public names come from everywhere
        layers = set()
    else:
        assert layer in ALLOWED, f"say in this file what {layer} may import"
        assert layers <= ALLOWED[layer] | {layer}, f"{layer} imports {layers}"
    assert outside <= SPECIAL.get(layer, EVERYWHERE)
    assert inside <= SPECIAL.get(layer, EVERYWHERE) | INSIDE_A_FUNCTION.get(
        layer, set()
    )


@pytest.mark.parametrize(
    ("source", "found"),
    [
        ("import sympy as sp", (set(), {"sympy"}, set())),
        ("from ..plant import Plant", ({"plant"}, set(), set())),
        ("from .. import kernels", ({"kernels"}, set(), set())),
        ("from .steady import gain", ({"designs"}, set(), set())),
        ("def f():\n    import control", (set(), set(), {"control"})),
        ("import json", (set(), set(), set())),
    ],
)
def test_this_test_reads_imports(source, found):
    assert imports(source, ("designs",)) == found


def test_importing_the_library_is_light():
    heavy = ("sympy", "matplotlib", "numba", "control", "nbformat", "IPython")
    heavy += ("concurrent.futures.process", "dask", "tqdm")
    code = (
        "import sys, luenberger\n"
        f"heavy = {heavy!r}\n"
        "print(*[name for name in heavy if name in sys.modules])"
    )
    run = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, check=True
    )
    assert run.stdout.split() == []


@pytest.mark.parametrize("path", FILES, ids=relative)
def test_no_module_is_long(path):
    assert len(path.read_text(encoding="utf-8").splitlines()) <= 300


@pytest.mark.parametrize(
    "path",
    # a derivation is a list of formulas and claims in page order, not a procedure
    [path for path in FILES if layer_of(path) != "derivations"],
    ids=relative,
)
def test_no_function_is_long(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            start = node.lineno + len((ast.get_docstring(node) or "").splitlines())
            assert node.end_lineno - start < 40, f"{node.name} is long"


def test_top_level_of_the_repository():
    listed = subprocess.run(
        ["git", "ls-files", "-z"], cwd=ROOT, capture_output=True, text=True
    )
    if listed.returncode:
        pytest.skip("not a git checkout")
    top = {name.partition("/")[0] for name in listed.stdout.split("\0") if name}
    fixed = {"README.md", "environment-pip.txt"}
    fixed |= {"notebooks", "lib", "tests", "benchmarks"}
    assert {name for name in top if not name.startswith(".")} <= fixed
