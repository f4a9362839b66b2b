"""Diagrams of structure: blocks with signals between them."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import matplotlib.pyplot as plt
import numpy as np
from matplotlib.axes import Axes
from matplotlib.patches import Ellipse, FancyArrowPatch, Rectangle
from matplotlib.path import Path

Point = tuple[float, float]
SUM = "+"  # of a block with this text: a circle where signals are added
HIGH = 0.5  # of a block
LETTER = 0.13  # of its width, for each letter of its text


def block_diagram(
    blocks: Mapping[str, Sequence[Any]],
    arrows: Sequence[Sequence[Any]],
    ax: Axes | None = None,
    *,
    apart: Sequence[str] = (),
) -> Axes:
    r"""Blocks at the places given, and signals that go from one to the next.

    Parameters
    ----------
    blocks : dict of str to (x, y) or (x, y, text)
        Where the middle of each block is, and what stands in it; its name, unless a
        text is given.  A text "+" is a circle where signals are added.  A text "" is
        a point, from which a signal branches.
    arrows : list of (start, end) or (start, ..., end, label)
        Names of blocks or points (x, y): a signal leaves the first, goes by those
        between and enters the last, in straight lines.  A string at the end that names
        no block is the signal's label.
    apart : list of str
        Names of blocks that are drawn grey: given, not designed.

    Examples
    --------
    >>> import luenberger as lb, matplotlib.pyplot as plt
    >>> ax = lb.plot.block_diagram(
    ...     {"plant": (0, 0), "observer": (2, 0)},
    ...     [((-1, 0), "plant", "u"), ("plant", "observer", "y")],
    ...     ax=plt.figure().gca(),
    ... )
    >>> [text.get_text() for text in ax.texts]
    ['plant', 'observer', 'u', 'y']
    """
    ax = ax or plt.gca()
    for name, (x, y, *text) in blocks.items():
        _draw(ax, (x, y), text[0] if text else name, name in apart)
    for way in arrows:
        label = way[-1] if isinstance(way[-1], str) and way[-1] not in blocks else ""
        _signal(ax, blocks, list(way[:-1] if label else way), label)
    ax.set_aspect("equal")
    ax.axis("off")
    ax.autoscale_view()
    return ax


def _draw(ax: Axes, centre: Point, text: str, given: bool) -> None:
    wide, high = _size(text)
    colour = "0.9" if given else "white"
    look: dict[str, Any] = dict(fc=colour, ec="black", zorder=2, label=text)
    if text == SUM:
        ax.add_patch(Ellipse(centre, wide, high, **look))
    elif text:
        corner = centre[0] - wide / 2, centre[1] - high / 2
        ax.add_patch(Rectangle(corner, wide, high, **look))
    else:
        ax.plot(*centre, "k.", zorder=2, label="branch")
    if text:
        ax.text(*centre, text, ha="center", va="center", zorder=3)


def _size(text: str) -> Point:
    if text in ("", SUM):
        return (0.3, 0.3) if text else (0.0, 0.0)
    plain = re.sub(r"[${}_^]|\\(hat|bar|tilde) *", "", text)
    plain = re.sub(r"\\[A-Za-z]+", "x", plain)  # a Greek letter is one
    longest = max(map(len, plain.split("\n")))
    return max(0.6, LETTER * longest + 0.2), HIGH * (1 + 0.5 * plain.count("\n"))


def _signal(
    ax: Axes, blocks: Mapping[str, Sequence[Any]], way: list[Any], label: str
) -> None:
    """A line by the points of `way`, with an arrow where it ends and a label."""
    points = [tuple(blocks[one][:2]) if isinstance(one, str) else one for one in way]
    ends = (way[0], points[1]), (way[-1], points[-2])
    points[0], points[-1] = (_edge(blocks, one, towards) for one, towards in ends)
    branch = isinstance(way[-1], str) and _text(blocks, way[-1]) == ""
    look: dict[str, Any] = dict(arrowstyle="-" if branch else "-|>", shrinkB=0)
    look |= dict(mutation_scale=10, color="black", lw=1, shrinkA=0, zorder=1)
    names = [one for one in (way[0], way[-1]) if isinstance(one, str)]
    look["label"] = " to ".join(names) + (f", {label}" if label else "")
    ax.add_patch(FancyArrowPatch(path=Path(points), **look))
    if label:
        (x, y), (u, v) = points[:2]
        upright = abs(v - y) > abs(u - x)
        place = ((x + u) / 2 + 0.08 * upright, (y + v) / 2 + 0.08 * (not upright))
        ax.text(*place, label, ha="left" if upright else "center", va="bottom")


def _text(blocks: Mapping[str, Sequence[Any]], name: str) -> str:
    return blocks[name][2] if len(blocks[name]) > 2 else name


def _edge(blocks: Mapping[str, Sequence[Any]], end: Any, towards: Any) -> Point:
    """Where a straight line from the middle of a block leaves it."""
    if not isinstance(end, str):
        return end
    x, y = blocks[end][:2]
    wide, high = _size(_text(blocks, end))
    along, up = towards[0] - x, towards[1] - y
    if _text(blocks, end) == SUM:
        reach = wide / 2 / np.hypot(along, up)
    else:
        sides = [wide / 2 / abs(along)] if along else []
        sides += [high / 2 / abs(up)] if up else []
        reach = min(sides)
    return x + reach * along, y + reach * up
