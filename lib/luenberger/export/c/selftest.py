"""The main of an exported source: a run compared with what Python computed."""

from collections.abc import Mapping, Sequence

import numpy as np

from ...kernels.c.file import File
from ...kernels.c.writer import listed, typed

TOLERANCE = {"double": 1e-9, "float": 1e-3}  # of the self-test, beside the largest


def selftest(
    module: File,
    u: np.ndarray,
    y: np.ndarray,
    expected: np.ndarray,
    more: Mapping[str, np.ndarray] | None = None,
    after: Sequence[str] = (),
) -> str:
    """A main that compares a run with what Python computed.

    `more` are tables for the lines `after` each step.
    """
    name, real = module.name, module.real
    N, q = expected.shape
    m, p = u.shape[1], y.shape[1]
    bound = TOLERANCE[real] * float(np.abs(expected).max(initial=1e-300))
    arrays = [("y", y), ("expected", expected)]
    arrays += [("u", u)] if m else []
    arrays += list((more or {}).items())
    tables = (
        f"static const {real} {name}_{k}[] = {typed(listed(X), real)};"
        for k, X in arrays
        if X.size
    )
    start = [f"    const {real} bound = {typed(repr(bound), real)};"]
    wanted = f"{name}_expected[{'k' if q == 1 else f'k * {q}'} + i]"
    compared = [*(f"        {line}" for line in after), *_compared(real, q, wanted)]
    return program(module, (N, m, p, q), [*tables], start, compared)


def program(
    module: File,
    sizes: tuple[int, int, int, int],
    tables: Sequence[str],
    start: Sequence[str],
    compared: Sequence[str],
) -> str:
    """The main: rows, inputs, measurements, estimates; lines before and in the loop."""
    name, (N, m, p, q) = module.name, sizes
    given, measured = _row(f"{name}_u", m), _row(f"{name}_y", p)
    lines = [
        f"#ifdef {name}_SELFTEST",
        "/* Ends with 0 if every estimate is what Python computed, else with 1. */",
        *tables,
        "",
        "int main(void)",
        "{",
        f"    {name}_state state;",
        f"    {module.real} what[{max(q, 1)}];",
        *start,
        f"    {name}_init(&state);",
        f"    for (int k = 0; k < {N}; k++) {{",
        f"        if ({name}_step(&state, {given}, {measured}, what) != 0) {{",
        "            return 1;",
        "        }",
        *compared,
        "    }",
        "    return 0;",
        "}",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def _compared(real: str, q: int, wanted: str) -> list[str]:
    """The estimates of a sample beside the table; a NaN is not within the bound."""
    return [
        f"        for (int i = 0; i < {q}; i++) {{",
        f"            const {real} gap = what[i] - {wanted};",
        "            if (!((gap <= bound) && (-gap <= bound))) {",
        "                return 1;",
        "            }",
        "        }",
    ]


def _row(array: str, length: int) -> str:
    """A pointer to row k of a table; null where there are none."""
    if length < 2:
        return f"{array} + k" if length else "NULL"
    return f"{array} + k * {length}"
