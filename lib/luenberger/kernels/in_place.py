"""What a row hands on, written in the place of what it was handed.

That saves a copy, and memory that has to stay near the processor.  It can be done where
nothing reads what was handed on once its successor is written.
"""

from .program import Assign, reads
from .recursion import Loop


def in_place(loop: Loop) -> dict[str, str]:
    """Results of the steps, each with the given matrix whose place it can take."""
    steps, found = loop.program.steps, {}
    made = {one.target: k for k, one in enumerate(steps) if isinstance(one, Assign)}
    for result, name in loop.carried.items():
        operand = loop.program.results[result]
        if operand is None or operand.turned or name in behind(loop):
            continue
        last = max((k for k, one in enumerate(steps) if name in reads(one)), default=-1)
        if made.get(operand.name, -1) > last and operand.name not in found:
            found[operand.name] = name
    return found


def behind(loop: Loop) -> set[str]:
    """Matrices that are read behind the steps."""
    results, recursion = loop.program.results, loop.recursion
    found = {one.beside for one in loop.program.definite}
    found |= {beside for _, beside, *_ in recursion.bounds}
    written = [results[name] for _, name, _ in recursion.written]
    written += [results[name] for name in loop.carried]
    return found | {operand.name for operand in written if operand}
