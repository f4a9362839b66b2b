"""What the functions of one C file share."""

import re
from collections.abc import Iterable
from dataclasses import dataclass, field

from ...numeric import Matrices
from .writer import C


@dataclass
class File:
    """The name before all its names, its number type, and its tables of constants."""

    name: str
    real: str
    tables: Matrices = field(default_factory=dict)

    def table_lines(self) -> list[str]:
        """The tables as C declarations."""
        to = C(self.real, 0)
        for name, X in self.tables.items():
            to.table(name, X)
        return to.lines


def function(head: str, lines: list[str], arguments: Iterable[str] = ()) -> str:
    """A function of these lines; of its `arguments` those that they never read."""
    body = "\n".join(lines)
    unused = [k for k in arguments if not re.search(rf"\b{k}\b", body)]
    return "\n".join([head, "{", *(f"    (void){k};" for k in unused), body, "}", ""])
