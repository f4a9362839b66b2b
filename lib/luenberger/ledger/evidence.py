"""From the name of a page to the derivation.  A dangling name is an error."""

from importlib import import_module
from types import ModuleType

from matrixproof.derivation import Derivation

from .records import PAPERS

ROOMS = (*PAPERS, "identification", "smoothing", "forms")  # that have derivations
COMMON = "theory"  # what papers and rooms share


def package(room: str) -> str:
    """Where the derivations of a room are: of a paper, or of our own."""
    if room == COMMON:
        return "luenberger.theory"
    return f"luenberger.{'papers.' if room in PAPERS else ''}{room}.derivation"


def module(name: str) -> ModuleType:
    """The module of "room.module"."""
    room, _, rest = name.partition(".")
    try:
        return import_module(f"{package(room)}.{rest}")
    except ImportError:
        raise LookupError(f"there is no derivation {name!r}") from None


def derivation(name: str) -> Derivation:
    """The page of "room.module"."""
    found = module(name)
    if not hasattr(found, "page"):
        raise LookupError(f"{name} has no page of a derivation")
    return found.page
