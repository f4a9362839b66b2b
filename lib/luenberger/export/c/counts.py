"""Counts and units: what a device's whole numbers are in the units of a plant, in C."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from ...kernels.c.file import File, function
from .formats import Formats, largest
from .identifiers import comment, quoted
from .observer import ROWS
from .selftest import program
from .source_and_header import Signals


def table(name: str, what: str, kind: str, values: Sequence[int]) -> str:
    """Whole numbers that never change, as C."""
    numbers = list(map(str, values))
    rows = [", ".join(numbers[i : i + 8]) for i in range(0, len(numbers), 8)]
    listed = ",\n    ".join(rows)
    size = len(values)
    return f"static const {kind} {name}_{what}[{size}] = {{\n    {listed}\n}};\n"


def units(name: str, made: Formats, signals: Signals) -> list[str]:
    """How many counts one unit is, a macro for each signal."""
    lines = ["", "/* Counts of one unit. */"]
    places = iter((*made.read, *made.shown))
    for letter, names in (("u", signals.u), ("y", signals.y), ("what", signals.what)):
        for i, (label, k) in enumerate(zip(names, places)):
            one = repr(float(np.ldexp(1.0, k)))
            said = comment([quoted(label)])[0]
            lines.append(f"#define {name}_{letter}{i}_ONE {one} {said} */")
    return lines


def declared(module: File) -> list[str]:
    """Declarations of what converts."""
    return [
        "",
        "/* The nearest count of a value, `one` being the counts of one unit; the",
        "   largest one beyond it; of NaN the least, which a step refuses. */",
        f"{module.real} {module.name}_counts(double value, double one);",
        f"double {module.name}_value({module.real} counts, double one);",
    ]


def conversions(module: File, bits: int) -> list[str]:
    """From units to counts and back."""
    most, kind, name = f"{largest(bits)}.0", module.real, module.name
    lines = [
        "    const double scaled = value * one;",
        "    const double half = (scaled < 0.0) ? -0.5 : 0.5;",
        "    const double moved = scaled + half;",
        f"    {kind} counts = -INT{bits}_MAX - 1;",
        f"    if (scaled >= {most}) {{",
        f"        counts = INT{bits}_MAX;",
        f"    }} else if (scaled <= -{most}) {{",
        f"        counts = -INT{bits}_MAX;",
        "    } else if (isnan(scaled) == 0) {",
        f"        counts = ({kind})moved;",
        "    } else {",
        "        /* no number */",
        "    }",
        "    return counts;",
    ]
    head = f"{kind} {name}_counts(double value, double one)"
    back = f"double {name}_value({kind} counts, double one)"
    return [function(head, lines), function(back, ["    return (double)counts / one;"])]


def selftest(module: File, made: Formats, m: int) -> str:
    """A main that compares counts with those that Python computed, exactly."""
    rng, name, q = np.random.default_rng(8), module.name, len(made.shown)
    read = [[int(rng.integers(-s, s + 1)) for s in made.most] for _ in range(ROWS)]
    rows = {
        "u": [row[:m] for row in read],
        "y": [row[m:] for row in read],
        "expected": made.run(read),
    }
    tables = [
        table(name, what, module.real, [x for row in some for x in row])
        for what, some in rows.items()
        if some[0]
    ]
    compared = [
        f"        for (int i = 0; i < {q}; i++) {{",
        f"            if (what[i] != {name}_expected[(k * {q}) + i]) {{",
        "                return 1;",
        "            }",
        "        }",
    ]
    sizes = ROWS, m, len(made.read) - m, q
    return program(module, sizes, tables, [], compared)
