"""`check`: whether a plant's file is right, and what the plant is like."""

import collections
import textwrap
from argparse import Namespace
from collections.abc import Iterator
from typing import Any

from .registration import as_json, file, plant_of, register, sample
from .terminal import tell, tell_json, visible

WIDE, FIRST = 79, 15
Line = tuple[str, str]  # heading, text


def add(commands: Any) -> None:
    one = register(
        commands,
        "check",
        run,
        help="validate a plant's file, and say what the plant is like",
        description="Validate a plant's file and print sizes, modes, observability "
        "indices, modes that no output shows, the structure of the noise, and whether "
        "there is a steady filter. A file that is not a plant is refused; a plant that "
        "no observer can be had for is not. Writes nothing.",
        examples=["check tracker.json", "check reactor.json --json"],
    )
    one.add_argument("plant", type=file, metavar="PLANT.json")
    sample(one)
    as_json(one)


def run(options: Namespace) -> None:
    from ..report.plant_facts import examine

    found = examine(plant_of(options.plant, options))
    if options.json:
        tell_json(found)
        return
    for head, text in _lines(found):
        told = textwrap.fill(
            visible(text),
            WIDE,
            initial_indent=f"{head:<{FIRST}}",
            subsequent_indent=" " * FIRST,
            break_on_hyphens=False,
        )
        tell(told)


def _lines(found: dict[str, Any]) -> Iterator[Line]:
    """(heading, text) of everything that was found."""
    signals = found["signals"]
    yield "plant", found["name"] or "without a name"
    yield "time", _time(found["time"])
    for kind, names in signals.items():
        yield kind, f"{len(names)}: {', '.join(names)}" if names else "none"
    if found["modes"] is None:
        yield "modes", "of one instant say nothing of a plant that varies in time"
    else:
        yield "modes", _modes(found["modes"])
        slow = [mode for mode in found["modes"] if not mode["decays"]]
        yield "stability", f"not stable: {_modes(slow)}" if slow else "stable"
        yield from _observability(found["observability"])
    yield from _noise(found["noise"], len(signals["states"]), len(signals["outputs"]))
    yield from _multiplicative(found["multiplicative"])
    yield "start", _start(found["at_first"])
    steady = found["steady_filter"]
    yield "steady filter", "exists" if steady["exists"] else f"none: {steady['reason']}"


def _time(time: dict[str, Any]) -> str:
    if not time["discrete"]:
        return "continuous (dt = 0)"
    varies = "" if time["instants"] is None else f", varies over {time['instants']}"
    return f"discrete, dt = {time['dt']:.6g}{varies and varies + ' instants'}"


def _modes(modes: list[dict[str, Any]]) -> str:
    """List each mode once, with its conjugate, and say how often it occurs."""
    from ..show import number

    values = [complex(mode["real"], mode["imag"]) for mode in modes]
    times = collections.Counter[str]()
    for value in values:
        text, other = number(value), value.conjugate()
        paired = "j" in text and values.count(value) == values.count(other)
        if paired:  # those of a complex plant need not be
            real = number(value.real, scale=abs(value))
            text = f"{real} +- {number(abs(value.imag))}j"
        times[text] += not paired or value.imag > 0
    times = times.items()
    return ", ".join(f"{mode} ({k} times)" if k > 1 else mode for mode, k in times)


def _observability(seen: dict[str, Any]) -> Iterator[Line]:
    indices = ", ".join(map(str, seen["indices"])) or "none"
    hidden = seen["unobservable"]
    yield "observability", f"{'not ' if hidden else ''}observable; indices {indices}"
    for decays, kind in ((True, "which decay"), (False, "which do not decay")):
        some = [mode for mode in hidden if mode["decays"] is decays]
        if some:
            yield "hidden modes", f"{_modes(some)}, {kind}"
    if seen["redundant_outputs"]:
        yield "redundant", f"{seen['redundant_outputs']} of the outputs"


def _noise(noise: dict[str, Any] | None, n: int, p: int) -> Iterator[Line]:
    if noise is None:
        yield "noise", "Q or R is not given"
        return
    yield (
        "noise",
        f"rank of Q {noise['rank_Q']} of {n}, of R {noise['rank_R']} of {p}, of "
        f"[Q S; S' R] {noise['rank_joint']} of {n + p}",
    )
    yield "noise-free", ", ".join(noise["perfect_outputs"]) or "no output alone"
    undriven = noise["undriven_on_unit_circle"]
    if undriven is not None:
        yield "undriven", _modes(undriven) or "no mode on the unit circle"


def _multiplicative(noise: dict[str, Any] | None) -> Iterator[Line]:
    if noise is None:
        return
    pairs = noise["pairs"]
    text = "1 pair" if pairs == 1 else f"{pairs} pairs"
    if noise["mean_square_stable"] is not None:
        stable = "" if noise["mean_square_stable"] else "not "
        text += f"; {stable}mean-square stable, spectral radius {noise['radius']:.6g}, "
        text += _strongest(noise["largest_scaling"])
    yield "multiplicative", text


def _strongest(scaling: float | None) -> str:
    if scaling == 0:
        return "as A alone is not stable"
    limit = "any factor" if scaling is None else f"{scaling:.6g} times as strong"
    return f"stable up to {limit}"


def _start(at_first: bool | None) -> str:
    if at_first is None:
        return "no P0: filters from a start, and their bounds, need it"
    return f"x0, P0 are {'of x[1], before y[1]' if at_first else 'of x[0]'}"
