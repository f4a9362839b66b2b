"""The main of an exported source: a run compared with what Python computed."""

from collections.abc import Sequence

import numpy as np

from ...kernels.c.file import File
from ...kernels.c.writer import listed, typed
from .source_and_header import Use

TOLERANCE = {"double": 1e-9, "float": 1e-3}  # of the self-test, beside the largest


def selftest(
    file: File, uses: Sequence[Use], u: np.ndarray, y: np.ndarray, expected: np.ndarray
) -> str:
    """A main that compares a run with what Python computed."""
    name, real = file.name, file.real
    N, q = expected.shape
    bound = TOLERANCE[real] * float(np.abs(expected).max(initial=1e-300))
    init, estimate, advance = uses[:3]
    tables = {"u": u[:N], "y": y[:N], "expected": expected}
    taken = {one for use in uses for one in use.arguments}
    tables = {
        k: X for k, X in tables.items() if k == "expected" or f"const {k}" in taken
    }
    null = ", NULL" * len(init.arguments)
    wanted = f"{name}_expected[{'k' if q == 1 else f'(k * {q}) + i'}]"
    lines = [
        f"#ifdef {name}_SELFTEST",
        "/* Ends with 0 if every estimate is what Python computed, else with 1. */",
        *(
            f"static const {real} {name}_{k}[] = {typed(listed(X), real)};"
            for k, X in tables.items()
        ),
        "",
        "int main(void)",
        "{",
        f"    {name}_state state;",
        f"    {real} what[{max(q, 1)}];",
        f"    const {real} bound = {typed(repr(bound), real)};",
        f"    {name}_init(&state{null});",
        f"    for (int k = 0; k < {N}; k++) {{",
        *_called(name, estimate, tables),
        f"        for (int i = 0; i < {q}; i++) {{",
        f"            const {real} gap = what[i] - {wanted};",
        "            if (!((gap <= bound) && (-gap <= bound))) {",  # nor is a NaN
        "                return 1;",
        "            }",
        "        }",
        *_called(name, advance, tables),
        "    }",
        "    return 0;",
        "}",
        "#endif",
        "",
    ]
    return "\n".join(lines)


def driver(name: str, real: str, uses: Sequence[Use]) -> str:
    """A function over N samples; it returns the number of one that is refused."""
    _, estimate, advance = uses[:3]
    tables = dict(u="inputs", y="outputs", what="estimates")

    def called(use: Use) -> str:
        given = [one.rpartition(" ")[2] for one in use.arguments]
        rows = [f"{k} + k * {name}_{tables[k]}" for k in given]
        call = f"{name}_{use.name}({', '.join(['&state', *rows])})"
        return f"        if ({call} != 0) return k + 1;"

    return "\n".join(
        [
            f'#include "{name}.h"',
            "#include <stddef.h>",
            f"int run(int N, const {real} *u, const {real} *y, {real} *what)",
            "{",
            f"    {name}_state state;",
            f"    {name}_init(&state{', NULL' * len(uses[0].arguments)});",
            "    for (int k = 0; k < N; k++) {",
            called(estimate),
            called(advance),
            "    }",
            "    return 0;",
            "}",
            "",
        ]
    )


def _called(name: str, use: Use, tables: dict[str, np.ndarray]) -> list[str]:
    """A call of row k that has to succeed."""
    given = ["&state"]
    for one in use.arguments:
        k = one.rpartition(" ")[2]
        wide = tables[k].shape[1] if k in tables else 0
        row = "k" if wide == 1 else f"k * {wide}"
        given.append(f"&{name}_{k}[{row}]" if wide else k)
    return [
        f"        if ({name}_{use.name}({', '.join(given)}) != 0) {{",
        "            return 1;",
        "        }",
    ]
