"""From an entry's pointer to what it points at.  A dangling pointer is an error."""

from functools import cache
from importlib import import_module
from typing import Any

from matrixproof import Claim
from matrixproof.derivation import Derivation

from .records import PAPERS

ROOMS = (
    *PAPERS,
    "identification",
    "smoothing",
    "forms",
)  # that have derivations
SIZES = (", ", " [", " (")  # how the sizes at the end of a step's name begin


def is_test(pointer: str) -> bool:
    """Whether the evidence is a test, "tests/room/test_file.py::test"."""
    return pointer.startswith("tests/")


def package(room: str) -> str:
    """Where the derivations of a room are: of a paper, or of our own."""
    return f"luenberger.{'papers.' if room in PAPERS else ''}{room}.derivation"


@cache
def derivation(name: str) -> Derivation:
    """The page of "room.module", or what "room.module.function" returns."""
    room, _, rest = name.partition(".")
    module, _, function = rest.partition(".")
    try:
        found = import_module(f"{package(room)}.{module}")
        return getattr(found, function)() if function else found.page
    except (ImportError, AttributeError):
        raise LookupError(f"there is no derivation {name!r}") from None


def steps(pointer: str) -> dict[str, Any]:
    """{name: Claim} of every step that "room.module: step" points at.

    Raises
    ------
    LookupError
        If there is none.
    TypeError
        If a step is a bare residual: it has no sides, so nothing in it could be
        damaged without the proof being another one.
    """
    name, _, step = pointer.partition(": ")
    known = derivation(name).steps
    found = {
        key: claim
        for key, claim in known.items()
        if key == step or key.startswith(tuple(step + sizes for sizes in SIZES))
    }
    if step in found:
        found = {step: found[step]}
    if not found:
        raise LookupError(f"{name} has no step {step!r}")
    for key, claim in found.items():
        if not isinstance(claim, Claim) and not hasattr(claim, "check"):
            raise TypeError(f"{name}: {key!r} is not a Claim with two sides")
    return found
