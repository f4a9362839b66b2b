"""The header and the source around the functions: comments, types, self-test."""

import hashlib
from dataclasses import dataclass

import numpy as np

from ..arrays import names
from ..certificate import require_match
from .files import MARK
from .words import comment, quoted

BYTES = {"double": 8, "float": 4}
TOLERANCE = {"double": 1e-9, "float": 1e-3}  # of the self-test, beside the largest


@dataclass
class Signals:
    """What a caller passes: names, row by row."""

    u: tuple
    y: tuple
    what: tuple


def signals(observer, plant=None):
    """Names of u, y and w^: the plant's, the observer's own, or by number."""
    if plant is not None:
        require_match(observer, plant)
        observer = observer.named(plant)
    u = names("u input", observer.input_names, observer.G.shape[-1])
    y = names("y output", observer.output_names, observer.D.shape[-1])
    return Signals(u, y, observer.estimate_names)


def header(module, title, equations, dt, signals, members, notes):
    """The text of NAME.h, without its fingerprint.

    Parameters
    ----------
    module : code.Module
    title : str
    equations, notes : list of str
        Lines of the comment.
    dt : float
    signals : Signals
    members : list of (name, length, meaning)
        Of the state's struct.
    """
    name, guard = module.name, f"LUENBERGER_{module.name}_H"
    lines = [
        f"{MARK}: do not edit.",
        "",
        title,
        "",
        *(f"    {line}" for line in equations),
        "",
        "Equation numbers are those of Leondes and Novak (1974).",
        f"Call {name}_init once, then {name}_step for each sample, every {dt!r} s.",
        "",
        f"    state  {name}_state, the caller's, one for each copy that runs:",
        *(f"           {k}[{n}]  {meaning}" for k, n, meaning in members),
        *_argument("u", signals.u, "known inputs of this sample"),
        *_argument("y", signals.y, "measurements of this sample"),
        *_argument("what", signals.what, "the estimate, written by a step"),
        "",
        "Every number is in the unit that the plant's data have there.",
        *notes,
    ]
    lines = [*comment(lines), f"#ifndef {guard}", f"#define {guard}"]
    lines += [f"#define {name}_EXPORT @", *_declarations(module, signals, members)]
    return "\n".join([*lines, "", "#endif", ""])


def _declarations(module, signals, members):
    name, real = module.name, module.real
    sizes = {"inputs": signals.u, "outputs": signals.y, "estimates": signals.what}
    return [
        "",
        "#ifdef __cplusplus",
        'extern "C" {',
        "#endif",
        "",
        "enum {",
        *(f"    {name}_{what} = {len(of)}," for what, of in sizes.items()),
        "};",
        "",
        "typedef struct {",
        *(f"    {real} {k}[{max(n, 1)}];" for k, n, _ in members),
        f"}} {name}_state;",
        "",
        f"void {name}_init({name}_state *state);",
        "",
        "/* 0: done; 1: refused, and state and what are as they were. */",
        f"{prototype(module)};",
        "",
        "#ifdef __cplusplus",
        "}",
        "#endif",
    ]


def _argument(name, labels, meaning):
    if not labels:
        return [f"    {name:5}  not read, may be null: there are none"]
    lines = [f"    {name:5}  {meaning}:"]
    width = len(str(len(labels) - 1))
    return lines + [
        f"           [{k:{width}}]  {quoted(label)}" for k, label in enumerate(labels)
    ]


def prototype(module):
    return (
        f"int {module.name}_step({module.name}_state *state, const {module.real} u[], "
        f"const {module.real} y[],\n    {module.real} what[])"
    )


def cost_notes(module, state, costs):
    """Lines about operations and bytes; `costs` by what they are the cost of."""
    size = BYTES[module.real]
    lines = ["", f"Cost in {module.real}s, operations being + - * / and comparisons:"]
    lines += [
        f"    {what}: {cost.operations} operations, at most {cost.stack * size} bytes "
        "of locals"
        for what, cost in costs.items()
    ]
    constants = sum(cost.constants for cost in costs.values()) * size
    return [*lines, f"    state {state * size} bytes, constants {constants} bytes"]


def source(module, functions):
    """The text of NAME.c, without its fingerprint and self-test."""
    name = module.name
    lines = [
        f"/* {MARK}: do not edit.  What it does is said in {name}.h.",
        " * Do not compile with -ffast-math: tests of numbers would be dropped.",
        " */",
        "#include <math.h>",
        "",
        f'#include "{name}.h"',
        "",
        f"#if {name}_EXPORT != @",
        f'#error "{name}.c and {name}.h are not of one export"',
        "#endif",
        "",
        *module.table_lines(),
        "",
        *functions,
    ]
    return "\n".join(lines)


def selftest(module, u, y, expected):
    """A main that compares a run with what Python computed."""
    name, real = module.name, module.real
    N, q = expected.shape
    m, p = u.shape[1], y.shape[1]
    bound = TOLERANCE[real] * float(np.abs(expected).max(initial=1e-300))
    arrays = [("y", y), ("expected", expected)]
    arrays += [("u", u)] if m else []
    given = f"{name}_u + k * {m}" if m else "0"
    measured = f"{name}_y + k * {p}" if p else "0"
    return "\n".join(
        [
            f"#ifdef {name}_SELFTEST",
            "/* Ends with 0 if every estimate is what Python computed, else with 1. */",
            *(
                f"static const {real} {name}_{k}[] = {module.numbers(X)};"
                for k, X in arrays
                if X.size
            ),
            "",
            "int main(void)",
            "{",
            f"    {name}_state state;",
            f"    {real} what[{max(q, 1)}];",
            f"    const {real} bound = {module.number(bound)};",
            f"    {name}_init(&state);",
            f"    for (int k = 0; k < {N}; k++) {{",
            f"        if ({name}_step(&state, {given}, {measured}, what)) return 1;",
            f"        for (int i = 0; i < {q}; i++) {{",
            f"            const {real} gap = what[i] - {name}_expected[k * {q} + i];",
            "            if (!(gap <= bound && -gap <= bound)) return 1;",
            "        }",
            "    }",
            "    return 0;",
            "}",
            "#endif",
            "",
        ]
    )


def stamped(name, head, body):
    """Both texts with a fingerprint, so that halves of two exports do not compile."""
    digest = hashlib.sha256((head + body).encode()).hexdigest()[:8]
    mark = f"0x{digest}UL"
    head = head.replace(f"{name}_EXPORT @", f"{name}_EXPORT {mark}")
    body = body.replace(f"{name}_EXPORT != @", f"{name}_EXPORT != {mark}")
    return {f"{name}.c": body, f"{name}.h": head}
