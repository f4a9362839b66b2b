"""What numba makes a function of: a text as a whole, or the sooner way.

See `machine` for that way.
"""

import sys
from dataclasses import dataclass
from pathlib import Path
from types import ModuleType
from typing import Any

from . import arrays, expressions, fused, machine, products, scopes, stack

Unknown = expressions.Unknown
FASTMATH = ("contract", "reassoc")  # sums may be taken in another order, NaNs count
OPTIONS: dict[str, Any] = dict(error_model="numpy", nogil=True)  # nogil: for threads
OPTIONS["fastmath"] = set(FASTMATH)
# what writes machine code
WRITING = stack, fused, products, machine, arrays, expressions, scopes


@dataclass(frozen=True)
class Way:
    """A text that numba compiles, and what it calls, by name."""

    text: str
    called: dict[str, Any]


def soon(text: str) -> Way:
    """A text with the same arguments that calls what does all, in instructions.

    Raises `Unknown`, now or when it is compiled, if the text has what they have not.
    """
    found = machine.read(text)
    names = ", ".join(found.names)
    short = f"def run({names}):\n    return body({names})\n"
    return Way(short, dict(body=machine.body(found)))


def function(way: Way, path: str) -> Any:
    """`run` of a module made of a text, as if it came from `path`.

    The module is entered by its name, because numba asks for it by name when it reads
    its files.
    """
    module: Any = ModuleType(Path(path).stem)
    sys.modules[module.__name__] = module
    module.__dict__.update(way.called)
    exec(compile(way.text, path, "exec"), module.__dict__)  # made by us
    return module.run


def jit(function: Any, exact: bool, **options: Any) -> Any:
    """A numba function that is not compiled yet."""
    import numba

    options |= OPTIONS | (dict(fastmath=False) if exact else {})
    return numba.njit(**options)(function)
