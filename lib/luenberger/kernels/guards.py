"""Steps by which a pass judges its own rounding: sizes of entries, and tests of them.

A pass gives up where a test fails.  Roots, magnitudes and tests within them are C's.
"""

from collections.abc import Callable

from .program import Cost, Guard, Magnitudes, Roots, Squares, Variances
from .statements import Entries, Entry, Let, Need
from .writer import Writer


def unrolled(
    step: Guard, rows: int, cols: int, entries: Entries, name: Callable[[Let], Entry]
) -> list[Need]:
    """A step as scalars: its target's entries, by `name`, and its tests."""
    M = entries[step.matrix]
    if isinstance(step, Magnitudes | Squares):
        entries[step.target] = [
            [_entry(step, f"{step.target}_{i}_{j}", M[i][j], name) for j in range(cols)]
            for i in range(rows)
        ]
        return []
    if isinstance(step, Variances):
        entries[step.target] = [[row[i]] for i, row in enumerate(M)]
        return []
    if isinstance(step, Roots):
        roots = [
            name(_let(f"{step.target}_{i}_0", step.root(M[i][i]), M[i][i], 2))
            for i in range(rows)
        ]
        entries[step.target] = [[one] for one in roots]
        return [
            _need(
                step.condition(M[i][j], roots[i], roots[j]),
                3,
                M[i][j],
                roots[i],
                roots[j],
            )
            for i in range(rows)
            for j in range(i)
        ]
    sizes = [one for (one,) in entries[step.by]]
    return [
        _need(step.condition(M[i][i], sizes[i]), 5, M[i][i], sizes[i])
        for i in range(rows)
    ]


def _entry(
    step: Magnitudes | Squares, target: str, one: Entry, name: Callable[[Let], Entry]
) -> Entry:
    """Size or square of an entry."""
    if isinstance(one, float):
        return abs(one) if isinstance(step, Magnitudes) else one * one
    return name(_let(target, step.of(one), one, 1))


def write(step: Guard, rows: int, cols: int, to: Writer) -> None:
    """Squares and variances as loops."""
    M = step.matrix
    if isinstance(step, Squares):
        to.fill(f"{step.target}[i]", step.of(f"{M}[i]"), rows * cols)
    elif isinstance(step, Variances):
        to.fill(f"{step.target}[i]", f"{M}[i * {cols + 1}]", rows)
    else:
        raise TypeError(f"loops do not write {type(step).__name__}; panels do")


def _let(name: str, text: str, entry: Entry, operations: int) -> Let:
    return Let(name, text, frozenset([entry]), Cost(operations, 0, 1, 1))


def _need(text: str, operations: int, *entries: Entry) -> Need:
    reads = frozenset(one for one in entries if isinstance(one, str))
    return Need(text, reads, Cost(operations))


def operations(step: Guard, rows: int, cols: int) -> int:
    """Roots, sizes, multiplications and comparisons."""
    if isinstance(step, Variances):
        return 0
    if isinstance(step, Magnitudes | Squares):
        return rows * cols
    if isinstance(step, Roots):
        return 2 * rows + 3 * rows * (rows - 1) // 2
    return 5 * rows
