"""What can be read off a figure, in words taken from the figure itself.

Notebook tests do not look at pictures.  These words change with a curve, its colour,
its label, an axis, a scale or the order of curves, so that a test sees the change.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator
from typing import Any

import numpy as np

from .numbers import number

ROUNDING = "rounding"  # the gid of a curve that differs between machines
NUDGE = 1 + 1e-9  # a number that ends in 5 is rounded up, whatever its last bits are
DASHES = {"-": "solid", "--": "dashed", ":": "dotted", "-.": "dash-dotted"}
MARKS = {
    ".": "points", "o": "circles", "s": "squares", "^": "triangles", "v": "triangles"
    " down", "D": "diamonds", "P": "filled pluses", "*": "stars", "x": "crosses",
    "+": "pluses", "|": "ticks",
}  # fmt: skip
COLOURS = {
    "#000000": "black", "#ffffff": "white", "#ff0000": "red", "#0072b2": "blue",
    "#d55e00": "vermilion", "#009e73": "green", "#cc79a7": "purple",
    "#e69f00": "orange", "#56b4e9": "sky blue",
}  # fmt: skip


def describe(figure: Any, digits: int = 3) -> str:
    r"""What can be read off a figure of matplotlib, in words.

    For each panel its axes with label, scale and range; each curve with label, colour,
    style, number of points, and its first, last, least, greatest and mean value;
    areas, bars, shapes, texts and the legend.

    Parameters
    ----------
    figure : matplotlib.figure.Figure
    digits : int, default 3
        Significant digits.  What is 1e-12 of the largest value of its curve is 0.  Of
        a curve with `set_gid("rounding")`, which shows how rounding grows and differs
        between machines, only the look is described.

    Examples
    --------
    >>> from matplotlib.figure import Figure
    >>> figure = Figure()
    >>> ax = figure.subplots()
    >>> _ = ax.plot([0, 1, 2], [4, 2, 1], "s--", color="#D55E00", label="error")
    >>> _ = ax.set(xlabel="time (s)", yscale="log", ylim=(0.5, 5), xlim=(0, 2))
    >>> for line in describe(figure).splitlines():
    ...     print(line.replace("; ", "\n    "))
    x: time (s), 0 to 2
        y: no label, logarithmic, 0.5 to 5
    curve "error": vermilion, dashed, squares
        3 points, x 0 to 2, y 4 to 1, least 1, greatest 4, mean 2.33
    """
    axes = list(figure.axes)
    axes += [
        child for ax in figure.axes for child in ax.child_axes if child not in axes
    ]
    say = _Figures(digits)
    lines = list(filter(None, [_plain(figure.get_suptitle())]))
    for k, ax in enumerate(axes, 1):
        lines += [f"Panel {k} of {len(axes)}"] if len(axes) > 1 else []
        lines += say.panel(ax)
    lines += [_names(one) for one in figure.legends]
    return "\n".join(lines)


class _Figures:
    """Words for what stands on one figure, with numbers of so many digits."""

    def __init__(self, digits: int) -> None:
        self.digits = digits

    def panel(self, ax: Any) -> Iterator[str]:
        if ax.get_title():
            yield f"title: {_plain(ax.get_title())}"
        if ax.axison:
            yield f"x: {self.axis(ax.xaxis)}; y: {self.axis(ax.yaxis)}"
        bars = [one for group in ax.containers for one in getattr(group, "patches", ())]
        yield from map(
            self.bars, [one for one in ax.containers if hasattr(one, "patches")]
        )
        for kind, artists in (
            (self.line, ax.lines),
            (self.collection, ax.collections),
            (self.image, ax.images),
            (self.shape, [one for one in ax.patches if one not in bars]),
            (self.text, [one for one in ax.texts if one.get_text() or _arrow(one)]),
        ):
            yield from self.each(kind, artists)
        if ax.get_legend():
            yield _names(ax.get_legend())

    def each(self, kind: Callable[[Any], str], artists: Iterable[Any]) -> Iterator[str]:
        yield from (kind(one) for one in artists if one.get_visible())

    def places(self, axis: Any, values: Any) -> list[str]:
        """Numbers along an axis; on an axis of dates, dates."""
        if "Date" not in type(axis.get_major_formatter()).__name__:
            return self.numbers(values)
        from matplotlib.dates import num2date

        return [num2date(one).strftime("%Y-%m-%d %H:%M:%S") for one in values]

    def numbers(self, values: Any) -> list[str]:
        values = np.ravel(np.ma.filled(np.ma.asarray(values, float), np.nan))
        scale = np.abs(values[np.isfinite(values)]).max(initial=0.0)
        return [number(float(one) * NUDGE, self.digits, scale) for one in values]

    def axis(self, axis: Any) -> str:
        scale = {"linear": "", "log": "logarithmic, "}.get(
            axis.get_scale(), f"{axis.get_scale()}, "
        )
        low, high = (self.places(axis, [one])[0] for one in axis.get_view_interval())
        ends = f"{low} to {high}" if _same_everywhere(axis) else "as far as curves go"
        fixed = type(axis.get_major_locator()).__name__ == "FixedLocator"
        names = [one.get_text() for one in axis.get_ticklabels()] if fixed else []
        ticks = f" with ticks {', '.join(map(_plain, names))}" if any(names) else ""
        label = _plain(axis.get_label_text()) or "no label"
        return f"{label}, {scale}{ends}{ticks}"

    def line(self, line: Any) -> str:
        x, y = map(_numbers, line.get_data(orig=False))
        name = f"{_label(line)}: {_style(line)}; "
        place = _across(line.get_transform(), line.axes)
        if line.get_gid() == ROUNDING:
            return f"curve {name}its points depend on rounding"
        if place == "y":
            return f"level {name}y {self.numbers(y)[0]}"
        if place == "x":
            return f"upright {name}x {self.numbers(x)[0]}"
        axis, where = line.axes.xaxis, line.get_transform()
        if line.get_linestyle() not in DASHES:  # the order of points is not seen
            return f"points {name}{self.within(axis, x, y)}"
        beside = "" if where == line.axes.transData else " beside the data"
        return f"curve{beside} {name}{self.run(axis, x, y)}"

    def run(self, axis: Any, x: Any, y: Any) -> str:
        """Where a curve goes: both ends, its extremes and its mean."""
        y = np.ma.masked_invalid(y)
        if not y.count():
            return "empty"
        ends = self.places(axis, [x[0], x[-1], x.min(), x.max()])
        rising = bool(np.all(np.diff(x) >= 0))
        inner = "" if rising else f", between {ends[2]} and {ends[3]}"
        first, last = y.compressed()[[0, -1]]
        v = self.numbers([first, last, y.min(), y.max(), y.mean()])
        return (
            f"{_count(y)}, x {ends[0]} to {ends[1]}{inner}, y {v[0]} to {v[1]}, "
            f"least {v[2]}, greatest {v[3]}, mean {v[4]}"
        )

    def bars(self, bars: Any) -> str:
        heights = ", ".join(self.numbers([one.get_height() for one in bars.patches]))
        look = "".join(_colour(one.get_facecolor()) for one in bars.patches[:1])
        return f"bars {_label(bars)}: {look}; {heights}"

    def collection(self, found: Any) -> str:
        kinds = {"PathCollection": "points", "LineCollection": "segments"}
        name = kinds.get(type(found).__name__, "area")
        colours = found.get_edgecolor() if name == "segments" else found.get_facecolor()
        corners = [path.vertices for path in found.get_paths()]
        if name == "points":
            corners = [found.get_offsets()]
        x, y = np.ma.concatenate([np.empty((0, 2)), *corners]).T
        where = self.within(found.axes.xaxis, x, y)
        look = "".join(_colour(one, found.get_alpha()) for one in colours[:1])
        shades = found.get_array()
        where += "" if shades is None else f"; {self.shades(shades)}"
        return f"{name} {_label(found)}: {look or 'shaded'}; {where}"

    def within(self, axis: Any, x: Any, y: Any) -> str:
        """Where points or corners lie, in whatever order they come."""
        y = np.ma.masked_invalid(y)
        if not y.count():
            return "empty"
        v = self.numbers([y.min(), y.max(), y.mean()])
        low, high, middle = self.places(axis, [x.min(), x.max(), x.mean()])
        return (
            f"{_count(y)}, x {low} to {high}, mean {middle}, "
            f"y {v[0]} to {v[1]}, mean {v[2]}"
        )

    def image(self, image: Any) -> str:
        return f"image: {self.shades(image.get_array())}"

    def shades(self, values: Any) -> str:
        v = self.numbers([np.min(values), np.max(values), np.mean(values)])
        return f"{np.size(values)} shades, least {v[0]}, greatest {v[1]}, mean {v[2]}"

    def shape(self, shape: Any) -> str:
        colour = shape.get_facecolor() if shape.get_fill() else shape.get_edgecolor()
        kind = type(shape).__name__.lower().removeprefix("fancy").removesuffix("patch")
        kind = {"bbox": "box"}.get(kind, kind)
        name = f"{kind} {_label(shape)}: {_colour(colour)}; "
        path = getattr(shape, "_path_original", None)
        ends = getattr(shape, "_posA_posB", None) if path is None else path.vertices
        if ends is not None:  # an arrow
            corners = map(self.numbers, ends)
            return name + " to ".join(f"({x}, {y})" for x, y in corners)
        corners = shape.get_path().get_extents(shape.get_patch_transform())
        x, y, u, v = self.numbers(corners.get_points())
        place = _across(shape.get_data_transform(), shape.axes)
        sides = {"x": f"x {x} to {u}", "y": f"y {y} to {v}"}
        return name + (sides.get(place) or ", ".join(sides.values()))

    def text(self, text: Any) -> str:
        arrow, spot = _arrow(text), text.get_position()
        x, y = self.numbers(getattr(text, "xy", spot) if arrow is None else spot)
        to = "" if arrow is None else f", arrow to ({', '.join(self.numbers(text.xy))})"
        return f'text "{_plain(text.get_text())}" at ({x}, {y}){to}'


def _same_everywhere(axis: Any) -> bool:
    """Whether the range of an axis is no matter of rounding."""
    ax = axis.axes
    free = ax.get_autoscalex_on() if axis is ax.xaxis else ax.get_autoscaley_on()
    return not free or all(line.get_gid() != ROUNDING for line in ax.lines)


def _across(transform: Any, ax: Any) -> str:
    """The one coordinate that is data, of what runs across a panel; else nothing."""
    if transform == ax.get_yaxis_transform(which="grid"):
        return "y"
    return "x" if transform == ax.get_xaxis_transform(which="grid") else ""


def _count(y: Any) -> str:
    missing = f" ({len(y) - y.count()} missing)" if y.count() < len(y) else ""
    return f"{len(y)} point{'s' if len(y) > 1 else ''}{missing}"


def _numbers(values: Any) -> Any:
    return np.ma.asarray(values, float)


def _arrow(text: Any) -> Any:
    return getattr(text, "arrow_patch", None)


def _label(artist: Any) -> str:
    name = str(artist.get_label() or "")
    return "without label" if name.startswith("_") or not name else f'"{_plain(name)}"'


def _names(legend: Any) -> str:
    return f"legend: {', '.join(_plain(one.get_text()) for one in legend.get_texts())}"


def _plain(text: str) -> str:
    """A text of a figure without the marks of its mathematics."""
    if r"\$" in text:  # a dollar sign, not mathematics
        return text.replace(r"\$", "$")
    return text.replace("$", "").replace("\\", "").replace("\n", " ")


def _style(line: Any) -> str:
    """Colour, dashes and markers of a curve."""
    mark, dashes = line.get_marker(), DASHES.get(line.get_linestyle(), "")
    named = "" if mark in (None, "", "None") else MARKS.get(mark, f"markers {mark}")
    hollow = (
        "open "
        if named and str(line.get_markerfacecolor()) in ("none", "w", "white")
        else ""
    )
    parts = [_colour(line.get_color(), line.get_alpha()), dashes, hollow + named]
    return ", ".join(filter(None, parts))


def _colour(colour: Any, alpha: float | None = None) -> str:
    from matplotlib.colors import to_hex, to_rgba

    code, clear = to_hex(colour), to_rgba(colour, alpha)[3]
    red, green, blue = code[1:3], code[3:5], code[5:]
    grey = f"grey {int(red, 16) / 2.55:.0f} %" if red == green == blue else code
    name = COLOURS.get(code, grey)
    return name if clear == 1 else f"{name} at {clear:.0%}"
