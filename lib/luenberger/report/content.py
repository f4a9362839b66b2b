"""What the design report says: tables, sentences and pictures of a comparison."""

import numpy as np

from ..compare import percent, sigma
from ..show import Picture, Prose, Table, number


def title(plant):
    """The plant's name as a heading, and its description."""
    about = [plant.description] if plant.description else []
    return Prose(*about, heading=plant.name or "Unnamed plant")


def sizes(plant):
    """How large the plant is, in a sentence."""
    clock = f"one sample every {number(plant.dt)} s" if plant.dt else "continuous time"
    return Prose(
        f"{_count(plant.n, 'state')}, {_count(plant.m, 'known input')}, "
        f"{_count(plant.p, 'output')}; {clock}."
    )


def signals(plant):
    """States, inputs and outputs by name, with the noise that acts on each."""
    rows = [
        *_noises("state", plant.state_names, plant.Q),
        *(["input", name, "known"] for name in plant.input_names),
        *_noises("output", plant.output_names, plant.R),
    ]
    return Table(["", "name", "noise per step (one sigma)"], rows)


def _noises(kind, names, covariance):
    if covariance is None:
        return [[kind, name, "not given"] for name in names]
    sizes = np.sqrt(np.diagonal(covariance))
    return [[kind, name, number(size, 4)] for name, size in zip(names, sizes)]


def plant_poles(plant):
    """The poles of the plant, in a sentence."""
    poles = np.linalg.eigvals(plant.A)
    if plant.dt:
        margin, what, shown = 1 - np.abs(poles).max(), "Magnitudes", np.abs(poles)
    else:
        margin, what, shown = -poles.real.max(), "Real parts", poles.real
    kind = "stable" if margin > 1e-6 else "unstable" if margin < -1e-6 else "neutral"
    scale = np.abs(shown).max()
    listed = ", ".join(number(size, 3, scale) for size in np.sort(shown)[::-1])
    return Prose(f"The plant is {kind}. {what} of its poles: {listed}.")


def refusals(table):
    """Why some designs do not exist, or that all of them do."""
    return table.refusals if table.refused else Prose("None was refused.")


def recommendation(table):
    """Which design to take, by which rule, and what it costs; in sentences."""
    named = [] if table.chosen is None else [f"Recommended: {table.chosen.title}."]
    return Prose(*named, *table.reasons())


def state_errors(table):
    """One-sigma steady error of each state, recommended design against the best."""
    chosen, best = table.chosen, table.yardstick
    if chosen is None:
        known = table.yardstick is not None
        return Prose(
            "No design is within the budget." if known else "No error is known."
        )
    rows = [
        [name, number(a, 4), number(b, 4), percent(b / a - 1 if a > 0 else 0.0)]
        for name, a, b in zip(table.estimates, sigma(best), sigma(chosen))
    ]
    return Table(["", best.method, "recommended", "more"], rows)


def matrices(design, plant):
    """The observer's matrices, each a table with names; zero ones are left out."""
    if design is None:
        return [Prose("No observer is recommended, and observer.json is not written.")]
    o = design.observer
    z, w = [f"z{k + 1}" for k in range(o.order)], o.estimate_names
    sides = dict(
        F=(z, z, "next z from z"),
        G=(z, plant.input_names, "next z from u"),
        D=(z, plant.output_names, "next z from y"),
        P=(w, z, "estimate from z"),
        V=(w, plant.output_names, "estimate from y"),
        W=(w, plant.input_names, "estimate from u"),
    )
    return [
        Table([f"{name}: {meaning}", *columns], _named(rows, getattr(o, name)))
        for name, (rows, columns, meaning) in sides.items()
        if getattr(o, name).size and np.any(getattr(o, name))
    ]


def _named(names, matrix):
    scale = np.abs(matrix).max(initial=0.0)
    return [
        [name, *(number(entry, 5, scale) for entry in row)]
        for name, row in zip(names, matrix)
    ]


def about(data, estimates):
    """How many measurements there were and what was done with them."""
    if data is None:
        return Prose("No measurements were given.")
    if estimates is None:
        return Prose(
            f"{_count(len(data.y), 'sample')}. No estimates, as no observer is "
            "recommended."
        )
    return Prose(f"{_count(len(data.y), 'sample')}. {estimates.how}")


def _count(size, noun):
    return f"{size or 'no'} {noun}{'' if size == 1 else 's'}"


def pareto(table, axes):
    """The picture of `plot.pareto`."""
    front = table.pareto()
    if not axes:
        return Prose("No figure: neither errors nor noise gains are known.")
    first, last = front[0], front[-1]
    if table.yardstick is None:
        return Picture(
            axes[0].figure,
            f"Noise gain against settling time, {_count(len(table.judged), 'design')}. "
            f"The front runs from {number(first.noise_gain, 4)} at "
            f"{number(first.settling, 4)} s ({first.method}) to "
            f"{number(last.noise_gain, 4)} at {number(last.settling, 4)} s "
            f"({last.method}). No star: nothing is recommended.",
        )
    return Picture(
        axes[0].figure,
        f"{table.judged_as.capitalize()}, against multiply-adds per step, "
        f"{len(table.ranked)} designs. "
        f"The front runs from {number(first.error, 4)} at {first.work} multiply-adds "
        f"({first.method}) to {number(last.error, 4)} at {last.work} ({last.method})."
        + _star(table),
    )


def _star(table):
    """What the picture says of the recommended design and of the budget."""
    chosen, budget = table.chosen, table.budget
    pale = "" if budget is None else f" Paler designs are beyond the budget, {budget}."
    if chosen is None:
        return f" No star: nothing is within the budget.{pale}"
    at = f"{number(chosen.error, 4)} at {chosen.work}"
    return f" A star marks the recommended {chosen.method}, {at}.{pale}"


def variances(curves, plant, axes, names=None):
    """The picture of `plot.error_variance`, a panel for each estimate by name."""
    if not curves:
        return Prose("No figure: there are no curves.")
    last = np.array([np.diagonal(one[-1]) for one in curves.values()])
    ratio = np.divide(last[-1], last[0], where=last[0] > 0, out=np.ones(last.shape[1]))
    k = int(np.argmax(np.round(ratio, 6)))
    name = (names or plant.state_names)[k]
    return Picture(
        axes[0].figure,
        f"Error variance against time, a panel for each of {_many(names, plant)}, from "
        f"P0 to the steady state: {', '.join(curves)}. The curves end farthest apart "
        f"for {name}, the last {number(ratio[k], 3)} times the first.",
    )


def _many(names, plant):
    """How many numbers are estimated, and whether they are the states."""
    if names in (None, plant.state_names):
        return f"{plant.n} states"
    return _count(len(names), "estimate")


def gains_and_poles(table, axes):
    """The picture of `plot.gains` beside that of `plot.poles`."""
    chosen, plant = table.chosen, table.plant
    if chosen is None:
        return Prose("No figure: no observer is recommended.")
    V, names = chosen.observer.V, chosen.observer.estimate_names
    i, j = np.unravel_index(np.argmax(np.abs(V)), V.shape) if V.any() else (0, 0)
    largest = (
        f"the largest gain is {number(V[i, j], 3)}, {names[i]} from "
        f"{plant.output_names[j]}"
        if V.any()
        else "all of them are zero"
    )
    what = "largest magnitude" if plant.dt else "largest real part"
    return Picture(
        axes[-1].figure,
        f"Above, bars of the gains V: {largest}. Below, poles of the plant and of the "
        f"observer in the complex plane: the observer's {what} is "
        f"{number(chosen.worst_pole, 3)}.",
    )


def estimates(found, plant, axes):
    """The picture of `plot.estimates`, a panel for each estimate."""
    if not found:
        return Prose("No figure: there are no estimates.")
    spans = (
        f"{name} from {number(x.min(), 3)} to {number(x.max(), 3)}"
        for name, x in zip(found.names, found.x.T)
    )
    return Picture(
        axes[0].figure,
        f"Estimates of {_many(found.names, plant)} at {len(found.x)} samples, each "
        f"with its one-sigma band where it is known: {'; '.join(spans)}.",
    )
