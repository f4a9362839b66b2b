"""Stage list -> callable.  The only place that turns symbols into code.

A stage list comes as its `StageList`, from a paper's front door.  It is compiled at
the first call, and the same callable is returned afterwards.  Deriving the text takes
a few tenths of a second, SymPy's import included, so it is `kept` for the next
process.

What writes code from a stage list enters here, nothing that knows a plant or a paper.
It uses `symbolic`, `stage_list` and `numeric`.
"""

import functools
from collections.abc import Callable, Sequence
from importlib.util import find_spec
from typing import Any

from ..numeric import Matrices
from ..stage_list import StageList
from .inputs import arguments
from .inputs import entries_known as entries_known
from .inputs import plain_array as plain_array
from .program import Program
from .recursion import Recursion as Recursion
from .step import Beside, Step

AUTO_ROWS = 20_000  # NumPy takes about as long for these as compiling the first time
# whose terms go if they are zero
OPTIONAL = ("B", "E", "B_s", "E_s", "Gamma", "J", "G", "S", "W")
UNROLLED = 1000  # operations of one row; more are faster and sooner compiled as loops


def runs_compiled(backend: str, rows: int) -> bool:
    """Whether a pass over so many rows is to run in code that numba compiles.

    "auto" asks for it where numba is installed, and there are enough rows to pay for
    the compiling.
    """
    if backend not in ("auto", "numpy", "numba"):
        raise ValueError(f"backend must be 'auto', 'numpy' or 'numba', got {backend!r}")
    if backend == "numpy" or (backend == "auto" and rows < AUTO_ROWS):
        return False
    there = find_spec("numba") is not None
    if backend == "numba" and not there:
        raise ImportError(
            "backend='numba' needs numba, which is not installed: "
            "pip install 'luenberger[fast]', or leave backend at 'auto'"
        )
    return there


def _vanishes(table: Any) -> bool:
    return all(value == 0 for row in table for value in row)


@functools.cache
def over_record(
    recursion: Recursion,
    sizes: tuple[tuple[str, int], ...],
    known: tuple[tuple[str, Any], ...],
    changing: frozenset[str],
) -> Callable[..., Any]:
    """A recursion with its loop over a record, compiled by numba.

    Parameters
    ----------
    recursion : Recursion
    sizes : tuple of (name, int)
    known : tuple of (name, table)
        Entries of the given matrices that are 0 or 1; see `entries_known`.
    changing : frozenset of str
        Matrices that change from row to row.

    Returns
    -------
    callable
        ``f(**arrays)``, the arguments of `numba.source`'s `run` by name; `f.names`
        lists them, `f.source` is the text.
    """
    from . import cache

    text, types = cache.derived(
        ("numba", recursion, sizes, known, sorted(changing), UNROLLED),
        lambda: _text(recursion, dict(sizes), dict(known), changing),
    )
    run = cache.compiled(text, tuple(types.values()))

    def over(**arrays: Any) -> int:
        return run(*(arrays[name] for name in types))

    found: Any = over
    found.names, found.source = tuple(types), text
    return found


def _text(
    recursion: Recursion,
    sizes: dict[str, int],
    known: dict[str, Any],
    changing: frozenset[str],
) -> tuple[str, dict[str, str]]:
    """The text that numba compiles, and the type of each argument by name."""
    from . import cost, numba, scalars

    zero = tuple(one for one in OPTIONAL if one in known and _vanishes(known[one]))
    loop = recursion.lowered(zero)
    straight = None
    if cost.loops(loop.program, sizes).operations <= 8 * UNROLLED:
        straight = scalars.unroll(loop.program, sizes, known)
        if straight.cost.operations > UNROLLED:
            straight = None
    text = numba.source(loop, sizes, changing, straight)
    return text, arguments(loop)


@functools.cache
def compiled(stages: StageList, *outputs: str, stacks: bool = False) -> Step:
    """A stage list as a NumPy function, pruned to `outputs`.

    Parameters
    ----------
    stages : StageList
    *outputs : str
        What is wanted of that which it computes; everything, if nothing is named.
    stacks : bool
        Leading axes broadcast.  Without it the matrices are matrices, which takes
        half the time.

    Returns
    -------
    callable
        ``step(**arrays) -> dict of arrays``; `step.given` are the names of the
        arrays, `step.source` is the text.
    """
    from . import kept
    from .step import assemble

    if missing := set(outputs) - set(stages.computes.split()):
        raise KeyError(f"{stages.where} computes no {sorted(missing)}")

    def make() -> tuple[str, list[str]]:
        from .text import numpy_source

        given, text = numpy_source(stages(), outputs, flat=not stacks)
        return text, list(given)

    return assemble(*kept.derived(("numpy", stages, outputs, stacks), make))


@functools.cache
def side_by_side(stages: StageList, *outputs: str) -> Beside:
    """The same function of `Columns`, many matrices side by side."""
    from .step import assemble_columns

    return assemble_columns(compiled(stages, *outputs))


def lowered(
    stages: StageList, outputs: Sequence[str], **options: Sequence[Any]
) -> Program:
    """A stage list as a `Program` for the printers; see `lowering.lower`."""
    given = tuple((name, tuple(options[name])) for name in sorted(options))
    return program_of(stages, tuple(outputs), given)


@functools.cache
def program_of(
    stages: StageList, outputs: tuple[str, ...], options: tuple[tuple[str, tuple], ...]
) -> Program:
    """The same, kept for the next process: its text is what makes it."""
    from . import kept, program

    def make() -> tuple[str, None]:
        from .lowering import lower

        return repr(lower(stages(), outputs, **dict(options))), None

    text, _ = kept.derived(("program", stages, outputs, options), make)
    found: Program = eval(text, dict(vars(program)))  # made by us, see `kept`
    return found


def run(
    stages: StageList, have: Matrices, *outputs: str, stacks: bool = False
) -> Matrices:
    """`compiled`, called with what it needs of the matrices in `have`, by name."""
    step = compiled(stages, *outputs, stacks=stacks)
    return step(**{name: have[name] for name in step.given})
