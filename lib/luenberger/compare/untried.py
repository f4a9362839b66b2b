"""What is said of designs that were not tried: what is best is so among the others."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from .table import Comparison


def among(table: Comparison, words: str) -> str:
    """The words where some designs were not tried, nothing where all were."""
    return words if any(one.untried for one in table.attempts) else ""


def untried(table: Comparison) -> Iterator[str]:
    """Which designs were not tried, and what they may be."""
    left = [one for one in table.attempts if one.untried]
    orders = sorted({one.order for one in left if one.order is not None})
    parts = [f"fixed-order filters of {_span(orders)}"] if orders else []
    parts += [f"{one.method}s, {one.label}" for one in left if one.order is None]
    if parts:
        yield (
            f"Not tried, as it takes a while: {'; '.join(parts)}. One of them may be "
            "lighter, or more accurate."
        )


def _span(orders: Sequence[int]) -> str:
    """ "order 3", "orders 4 to 39", "orders 4, 7 and 9"."""
    first, *_, last = orders[0], orders[-1]
    if first == last:
        return f"order {first}"
    if last - first + 1 == len(orders):
        return f"orders {first} to {last}"
    return f"orders {', '.join(map(str, orders[:-1]))} and {last}"
