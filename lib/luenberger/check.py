"""What a plant's file means: `luenberger check` prints what `examine` finds.

Noises in the units of the signals, what each output reads, modes as times in seconds,
what the outputs show of them, and what looks like a mistake.  Which methods apply to a
plant is the business of `compare`.
"""

import collections
import dataclasses
import itertools
import math
from collections.abc import Iterable, Iterator, Sequence
from typing import Any

import numpy as np

from .analysis import mean_square
from .errors import CertificateError, DesignError
from .numeric import Matrix
from .numeric.factors import square_root
from .numeric.linalg import RANK_TOL, UNIT_TOL, decaying, eigenvalues, null_directions
from .numeric.staircase_form import conjugate, unobservable
from .papers.leondes_novak.design import kalman_filter
from .plant import Plant
from .recursion.settings import setting
from .show import number, unit

REPEATED = 3  # times that a mode of the unit circle may be, as position to acceleration
SCATTER = 1e-12  # rounding, of which a mode repeated k times feels the k-th root
SHOWN = 4  # terms of what an output reads
Found = dict[str, Any]
Line = tuple[str, str]  # heading, text


@np.errstate(all="ignore")  # what overflows is refused by what it spoils
def examine(plant: Plant) -> Found:
    """Everything `check` says of a plant, as a dict of lists, numbers and strings.

    A value that cannot be had is None: modes of a plant that varies in time, noises
    of one without Q and R, a steady filter in continuous time.

    Examples
    --------
    >>> plant = Plant([[1, 1], [0, 1]], None, [[1, 0]], dt=1.0,
    ...               Q=[[0.25, 0.5], [0.5, 1]], R=[[0]])
    >>> examine(plant)["observability"]["indices"], examine(plant)["reads"]
    ([2], ['x1'])
    """
    varies = plant.steps is not None
    modes = None if varies else _modes(eigenvalues(plant.A), plant.dt)
    return {
        "name": plant.name,
        "time": {"discrete": plant.dt > 0, "dt": plant.dt, "instants": plant.steps},
        "signals": {
            "states": list(plant.state_names),
            "inputs": list(plant.input_names),
            "outputs": list(plant.output_names),
        },
        "sigma": {"states": _sigmas(plant.Q), "outputs": _sigmas(plant.R)},
        "reads": None if varies else list(_reads(plant)),
        "modes": modes,
        "stable": None if modes is None else all(mode["decays"] for mode in modes),
        "suspicions": [] if varies else list(_suspicions(plant)),
        "observability": None if varies else _observability(plant),
        "noise": _noise(plant),
        "multiplicative": _multiplicative(plant),
        "at_first": None if plant.P0 is None else plant.at_first,
        "steady_filter": _steady_filter(plant),
    }


def _sigmas(covariance: Matrix | None) -> list[float] | None:
    """One sigma of each signal; the largest, where it varies."""
    if covariance is None:
        return None
    return np.sqrt(_instants(covariance).max(axis=0).diagonal()).tolist()


def _reads(plant: Plant) -> Iterator[str]:
    """What each output reads, as a sum of states and inputs."""
    names = [*plant.state_names, *plant.input_names]
    for row in np.hstack([plant.C, plant.E]):
        terms = [(c, name) for c, name in zip(row, names) if c]
        text = ""
        for c, name in terms[:SHOWN]:
            size = abs(c) if np.isreal(c) else c
            sign = "-" if np.isreal(c) and c.real < 0 else "+"
            text += f" {sign} {'' if size == 1 else number(size) + ' '}{name}"
        text += f" and {len(terms) - SHOWN} more" if len(terms) > SHOWN else ""
        yield (
            text.removeprefix(" + ").replace(" - ", "-", text[:3] == " - ") or "nothing"
        )


def _suspicions(plant: Plant) -> Iterator[str]:
    """What is allowed and looks like a mistake."""
    modes = eigenvalues(plant.A)
    if not np.isfinite(modes).all():
        return
    if plant.dt > 0 and modes.real.max() <= 0:
        yield (
            "A looks continuous: no mode has a positive real part, and those of one "
            f"step of {plant.dt:g} s are near 1 where motions are slow. If A is of "
            "dx/dt, leave out dt and give --sample."
        )
    if plant.dt == 0 and modes.real.max() > 0 and np.abs(modes).max() <= 1 + UNIT_TOL:
        yield (
            "A looks discrete: without dt time is continuous, and the plant grows. If "
            "A leads from one sample to the next, give dt, the seconds between them."
        )


def _modes(values: Iterable[complex], dt: float) -> list[Found]:
    """The eigenvalues in order of speed, the slowest last, and whether each decays.

    One on the boundary does not, whichever side rounding puts it.  "seconds" is the
    time in which a motion falls to 37 %, or grows to 2.7 times; "period" is that of an
    oscillation.
    """
    values = np.asarray(values, dtype=complex)
    size, decays = np.abs(values) if dt else values.real, decaying(values, dt > 0)
    order = np.lexsort((values.imag, values.real, size))
    return [_mode(complex(values[k]), bool(decays[k]), dt) for k in order]


def _mode(value: complex, decays: bool, dt: float) -> Found:
    rate, turn = value.real, abs(value.imag)
    if dt:
        rate = math.log(abs(value)) / dt if value else -math.inf
        turn = abs(np.angle(value)) / dt
    boundary = not decays and abs(rate) * (dt or 1.0) <= UNIT_TOL
    known = math.isfinite(rate) and rate and not boundary
    return {
        "real": value.real,
        "imag": value.imag,
        "decays": decays,
        "seconds": 1 / abs(rate) if known else None,
        "period": 2 * math.pi / turn if turn else None,
    }


def _observability(plant: Plant) -> Found:
    hidden, sizes = unobservable(plant.A, plant.C, plant.dt)
    hidden = _modes(hidden, plant.dt)
    return {
        "indices": list(conjugate(sizes)),
        "unobservable": hidden,
        "detectable": all(mode["decays"] for mode in hidden),
        "redundant_outputs": plant.p - max(sizes, default=0),
    }


def _noise(plant: Plant) -> Found | None:
    """Ranks of the covariances.  Where they vary in time, the least one is given."""
    if plant.Q is None or plant.R is None:
        return None
    perfect = _instants(plant.R).max(axis=0).diagonal() == 0
    return {
        "rank_Q": _rank(plant.Q),
        "rank_R": _rank(plant.R),
        "rank_joint": _rank(_joint(plant)),
        "perfect_outputs": [
            name for name, is_so in zip(plant.output_names, perfect) if is_so
        ],
        "undriven_on_unit_circle": _undriven(plant),
    }


def _instants(X: Any) -> Matrix:
    found: Matrix = X if X.ndim == 3 else X[None]
    return found


def _joint(plant: Plant) -> Matrix:
    Q, R = _instants(plant.Q), _instants(plant.R)
    S = np.zeros((1, plant.n, plant.p)) if plant.S is None else _instants(plant.S)
    N = max(map(len, (Q, R, S)))
    Q, R, S = (np.broadcast_to(X, (N, *X.shape[1:])) for X in (Q, R, S))
    return np.block([[Q, S], [S.mT, R]])


def _rank(X: Matrix) -> int:
    return min(len(one) - null_directions(one).shape[1] for one in _instants(X))


def _undriven(plant: Plant) -> list[Found] | None:
    """Modes on the unit circle that no noise moves, or None in continuous time.

    They are those of A - S R^-1 C, which is what is left once w is predicted from v.
    """
    if plant.steps is not None or not plant.dt or plant.is_complex:
        return None
    now = setting(plant)
    still, _ = unobservable(now.As.T, square_root(now.Qs).T, 1.0, RANK_TOL)
    return _modes(_on_circle(list(still)), plant.dt)


def _on_circle(modes: list[complex]) -> list[complex]:
    """Those on the unit circle, each once; the mean, of what is scattered about one."""
    if not modes:
        return []
    nearest = sorted(modes, key=lambda mode: abs(mode - modes[0]))
    for k in range(min(REPEATED, len(modes)), 0, -1):
        mean = sum(nearest[:k]) / k
        if max(abs(mode - mean) for mode in nearest[:k]) <= SCATTER ** (1 / k):
            break
    found = (z for z in (mean, *nearest[:k]) if abs(abs(z) - 1) <= UNIT_TOL)
    return [*itertools.islice(found, 1), *_on_circle(nearest[k:])]


def _multiplicative(plant: Plant) -> Found | None:
    """Of noises that multiply the state: how strong they are beside what is stable."""
    pairs = plant.multiplicative
    if not pairs:
        return None
    known = plant.steps is None and plant.dt > 0
    scaling = mean_square.largest_scaling(plant.A, pairs) if known else None
    return {
        "pairs": len(pairs),
        "radius": mean_square.radius(plant.A, pairs) if known else None,
        "largest_scaling": None if scaling is None or np.isinf(scaling) else scaling,
        "mean_square_stable": None if scaling is None else scaling > 1,
    }


def _steady_filter(plant: Plant) -> Found:
    """Whether there is a steady Kalman filter, and if not why."""
    try:
        if plant.multiplicative:
            same = mean_square.equivalent_noise(plant)
            plant = dataclasses.replace(
                plant, Q=same.Q, R=same.R, S=same.S, multiplicative=()
            )
        kalman_filter(plant)
    except (DesignError, CertificateError) as error:
        return {"exists": False, "reason": str(error)}
    return {"exists": True, "reason": None}


def lines(found: Found) -> Iterator[Line]:
    """(heading, text) of everything that was found."""
    signals, time = found["signals"], found["time"]
    yield "plant", found["name"] or "without a name"
    varies = f", varies over {time['instants']} instants" if time["instants"] else ""
    told = f"discrete, dt = {time['dt']:.6g} s" if time["discrete"] else ""
    yield "time", (told or "continuous (dt = 0)") + varies
    yield from _signals(found)
    modes = found["modes"]
    if modes is None:
        yield "modes", "of one instant say nothing of a plant that varies in time"
    else:
        yield "modes", _listed(modes)
        if times := _times(modes):
            yield "times", times
        slow = [mode for mode in modes if not mode["decays"]]
        yield "stability", f"not stable: {_listed(slow)}" if slow else "stable"
        yield from _shown(found["observability"])
    yield from _noises(found["noise"], len(signals["states"]), len(signals["outputs"]))
    yield from _multiplied(found["multiplicative"])
    first = found["at_first"]
    told = f"x0, P0 are {'of x[1], before y[1]' if first else 'of x[0]'}"
    yield "start", told if first is not None else "no P0: the start is unknown"
    steady = found["steady_filter"]
    yield "steady filter", "exists" if steady["exists"] else f"none: {steady['reason']}"
    for said in found["suspicions"]:
        yield "look again", said


def _signals(found: Found) -> Iterator[Line]:
    """Each state and output with its noise in its unit, and what an output reads."""
    step = "a step" if found["time"]["discrete"] else "in a root of a second"
    reads = found["reads"] or []
    for kind, names in found["signals"].items():
        yield kind, f"{len(names)}: {', '.join(names)}" if names else "none"
        sigmas = found["sigma"].get(kind)
        for k, name in enumerate(names if kind != "inputs" else ()):
            said = [f"reads {reads[k]}"] if kind == "outputs" and reads else []
            if sigmas is not None:
                size = f"{number(sigmas[k], 4)} {unit(name)}".rstrip()
                what = "one sigma" if kind == "outputs" else f"pushed {step} by"
                said += [f"{what} {size}" if sigmas[k] else "no noise"]
            if said:
                yield "", f"{name}: {'; '.join(said)}"


def _times(modes: Sequence[Found]) -> str:
    """Time constants and periods, each once."""
    told = []
    for mode in modes:
        parts = []
        if mode["seconds"] is not None:
            falls = "falls" if mode["decays"] else "grows"
            parts.append(f"{falls} in {number(mode['seconds'], 3)} s")
        if mode["period"] is not None:
            parts.append(f"period {number(mode['period'], 3)} s")
        told += [", ".join(parts)] if parts else []
    return "; ".join(dict.fromkeys(told))


def _listed(modes: Sequence[Found]) -> str:
    """Each mode once, with its conjugate, and how often it occurs."""
    values = [complex(mode["real"], mode["imag"]) for mode in modes]
    times = collections.Counter[str]()
    for value in values:
        text, other = number(value), value.conjugate()
        paired = "j" in text and values.count(value) == values.count(other)
        if paired:  # those of a complex plant need not be
            real = number(value.real, scale=abs(value))
            text = f"{real} +- {number(abs(value.imag))}j"
        times[text] += not paired or value.imag > 0
    all_of = times.items()
    return ", ".join(f"{mode} ({k} times)" if k > 1 else mode for mode, k in all_of)


def _shown(seen: Found) -> Iterator[Line]:
    indices = ", ".join(map(str, seen["indices"])) or "none"
    hidden = seen["unobservable"]
    yield "observability", f"{'not ' if hidden else ''}observable; indices {indices}"
    for decays, kind in ((True, "which decay"), (False, "which do not decay")):
        some = [mode for mode in hidden if mode["decays"] is decays]
        if some:
            yield "hidden modes", f"{_listed(some)}, {kind}"
    if seen["redundant_outputs"]:
        yield "redundant", f"{seen['redundant_outputs']} of the outputs"


def _noises(noise: Found | None, n: int, p: int) -> Iterator[Line]:
    if noise is None:
        yield "noise", "Q or R is not given; `luenberger fit` finds them from a record"
        return
    yield (
        "noise",
        f"rank of Q {noise['rank_Q']} of {n}, of R {noise['rank_R']} of {p}, of "
        f"[Q S; S' R] {noise['rank_joint']} of {n + p}",
    )
    yield "noise-free", ", ".join(noise["perfect_outputs"]) or "no output alone"
    undriven = noise["undriven_on_unit_circle"]
    if undriven is not None:
        yield "undriven", _listed(undriven) or "no mode on the unit circle"


def _multiplied(noise: Found | None) -> Iterator[Line]:
    if noise is None:
        return
    pairs, scaling = noise["pairs"], noise["largest_scaling"]
    text = "1 pair" if pairs == 1 else f"{pairs} pairs"
    if noise["mean_square_stable"] is not None:
        stable = "" if noise["mean_square_stable"] else "not "
        text += f"; {stable}mean-square stable, spectral radius {noise['radius']:.6g}, "
        limit = "any factor" if scaling is None else f"{scaling:.6g} times as strong"
        text += f"stable up to {limit}" if scaling != 0 else "as A alone is not stable"
    yield "multiplicative", text
