"""Print a recursion as loops over lanes, where every lane is a record of its own.

The scalars of `scalars` that hang on a record get an index, that of its lane; the
others are the same for all.  A lane does what it would do beside any others, and the
text says which products are joined with sums: so the bits of a record do not hang on
the records beside it.
"""

from collections.abc import Collection
from dataclasses import dataclass
from functools import cache
from typing import Any

from .program import Known
from .recursion import Loop, Recursion
from .scalars import unroll

MOST = 4000  # operations of a row; more take too long to compile


@dataclass(frozen=True)
class Panels:
    """A recursion whose records are run in lanes.

    Attributes
    ----------
    recursion : Recursion
    marks : (str, str) or None
        A given diagonal matrix with ones for the entries of a vector that arrived.
    watched : str
        A covariance: the least and the largest variances are kept, and the last of it.
    stays : tuple of str
        Arrays that one recursion writes and another reads, which stay in lanes.
    """

    recursion: Recursion
    marks: tuple[str, str] | None = None
    watched: str = ""
    stays: tuple[str, ...] = ()

    @property
    def tests(self) -> bool:
        """Whether a lane can fail."""
        return bool(self.recursion.definite or self.recursion.bounds)

    def lowered(self, zero: Collection[str] = ()) -> Loop:
        """The `Loop` where the matrices named in `zero` vanish."""
        return self.recursion.lowered(zero)


def arguments(panels: Panels, loop: Loop) -> dict[str, str]:
    """Names of the arguments of `run`, in order, and the numba type of each."""
    marks = panels.marks[0] if panels.marks else ""
    types = {"who": "i8[::1]", "rows": "i8"}
    for array, _ in loop.rows.values():
        types |= {array: "f8[:,::1]"}
        types |= {} if array in panels.stays else {f"which_{array}": "i8[::1]"}
    types |= {name: "f8[:,::1]" for name in loop.matrices if name != marks}
    types |= {name: "f8[::1]" for name in loop.carried.values()}
    types |= {array: "f8[:,::1]" for array, *_ in loop.recursion.written}
    if panels.tests:
        types |= {"failed": "b1[::1]"}
    if panels.watched:
        types |= dict.fromkeys(("least", "most", "last"), "f8[:,::1]")
    return types


@cache
def fits(panels: Panels, sizes: tuple[tuple[str, int], ...]) -> bool:
    """Whether a row is short enough to be written as scalars."""
    from . import cache, cost

    def make() -> tuple[str, int]:
        return "", cost.loops(panels.lowered().program, dict(sizes)).operations

    return cache.derived(("operations", panels, sizes), make)[1] <= MOST


@cache
def in_panels(
    panels: Panels,
    sizes: tuple[tuple[str, int], ...],
    known: tuple[tuple[str, Any], ...],
    changing: frozenset[str],
) -> Any:
    """``run(**arrays)``, compiled by numba; see `panel_rows.source`."""
    from . import OPTIONAL, _vanishes, cache

    def make() -> tuple[str, dict[str, str]]:
        from .panel_rows import source

        tables: Known = dict(known)
        optional = [k for k in tables if k.removesuffix("_all") in OPTIONAL]
        loop = panels.lowered([k for k in optional if _vanishes(tables[k])])
        straight, types = (
            unroll(loop.program, dict(sizes), tables),
            arguments(panels, loop),
        )
        return source(panels, loop, dict(sizes), changing, straight, list(types)), types

    question = "panels", panels, sizes, known, sorted(changing)
    text, types = cache.derived(question, make)
    run = cache.compiled(text, tuple(types.values()), exact=True)

    def over(**arrays: Any) -> None:
        run(*(arrays[name] for name in types))

    found: Any = over
    found.names, found.types, found.source = tuple(types), tuple(types.values()), text
    return found
