"""Sizes of entries in panels, and tests of them: how a pass judges its rounding."""

from ..guards import operations
from ..program import Guard, Magnitudes, Operand, Roots, Within
from ..writer import entry
from .store import Store


def write(step: Guard, store: Store) -> None:
    """Write a step on a matrix as it is kept."""
    whole = store.layouts.kept(step.matrix)
    rows, cols = store.layouts.shape(whole)
    store.count(operations(step, rows, cols))
    if isinstance(step, Roots):
        _roots(step, store, whole, rows)
    elif isinstance(step, Magnitudes):
        _magnitudes(step, store, whole, rows, cols)
    elif isinstance(step, Within):
        _within(step, store, whole, rows)
    else:
        raise TypeError(f"panels do not write {type(step).__name__}; loops do")


def _roots(step: Roots, store: Store, whole: Operand, size: int) -> None:
    """Roots, and a test of whole rows of the matrix, zeros behind them included."""
    to, w, row = store.to, step.target, store.row(size)
    for name in (w, "larger"):
        store.array(name, 1, size)
    to.fill(f"{w}[i]", step.root(store.at(whole, "i", "i")), size)
    to.loop("i", size, row)
    to.set(f"{w}[i]", "0.0")
    to.end()
    array, stride, _ = store.strides(whole)
    what = store.panels.larger(step, stride)
    to.call(what, [row, str(size), w, array, "larger"])
    to.loop("i", 0, size)
    to.need("larger[i] == 0.0")
    to.end()


def _magnitudes(
    step: Magnitudes, store: Store, whole: Operand, rows: int, cols: int
) -> None:
    to, target = store.to, Operand(step.target, whole.turned)
    place, along = store.declare(target), store.line(cols)
    to.loop("i", 0, rows)
    to.loop("j", 0, cols)
    value = step.of(store.at(whole, "i", "j"))
    to.set(entry(place, ("i", along), (int(cols > 1), "j")), value)
    to.end()
    to.end()


def _within(step: Within, store: Store, whole: Operand, size: int) -> None:
    to, by = store.to, store.strides(Operand(step.by))[0]
    to.loop("i", 0, size)
    to.need(step.condition(store.at(whole, "i", "i"), f"{by}[i]"))
    to.end()
