"""What the design report says: tables and sentences about a survey."""

import json
from pathlib import Path

import numpy as np

from .analysis import error_covariance
from .designs.trace_minimisation import reduced_order_filter
from .measurements import covariance_from_start
from .show import Prose, Table, number
from .survey import TOLERANCE

SETTLED = 1e-3  # the time axis of the variances ends when transients are this small


def title(plant, path):
    """The plant's name as a heading, and what its file says about it."""
    about = json.loads(Path(path).read_text(encoding="utf-8")).get("description", "")
    return Prose(*([about] if about else []), heading=plant.name or "Unnamed plant")


def sizes(plant):
    """How large the plant is, in a sentence."""
    return Prose(
        f"{_count(plant.n, 'state')}, {_count(plant.m, 'known input')}, "
        f"{_count(plant.p, 'output')}; one sample every {number(plant.dt)} s."
    )


def signals(plant):
    """States, inputs and outputs by name, with the noise that acts on each."""
    rows = [
        ["state", name, number(np.sqrt(q), 4)]
        for name, q in zip(plant.state_names, np.diagonal(plant.Q))
    ]
    rows += [["input", name, "known"] for name in plant.input_names]
    rows += [
        ["output", name, number(np.sqrt(r), 4)]
        for name, r in zip(plant.output_names, np.diagonal(plant.R))
    ]
    return Table(["", "name", "noise per step (one sigma)"], rows)


def plant_poles(plant):
    """The poles of the plant, in a sentence."""
    poles = np.linalg.eigvals(plant.A)
    size = np.abs(poles).max()
    kind = "stable" if size < 1 - 1e-6 else "unstable" if size > 1 + 1e-6 else "neutral"
    return Prose(f"The plant is {kind}. Magnitudes of its poles: {_magnitudes(poles)}.")


def label(design, plant):
    """A design in a few words."""
    if not design.accurate:
        return "Kalman filter"
    names = ", ".join(plant.output_names[k] for k in design.accurate)
    return f"{names} taken as accurate"


def designs(survey):
    """The table of all designs; the recommended one is set in bold."""
    chosen = survey.recommended()
    header = [
        "outputs taken as accurate",
        "gain",
        "order",
        "error trace",
        "above the best",
        "largest |pole|",
        "multiply-adds per step",
        "certificate",
    ]
    rows = [_design_row(survey, one) for one in survey.attempts]
    return Table(header, rows, marked=[survey.attempts.index(chosen)])


def _design_row(survey, one):
    names = ", ".join(survey.plant.output_names[k] for k in one.accurate)
    start = [names or "none (Kalman filter)", _gain(one), str(one.order)]
    if one.refusal:
        return [*start, "", "", "", "", "refused"]
    return [
        *start,
        number(one.trace, 5),
        _percent(survey.excess(one)),
        number(one.radius, 4),
        str(one.work),
        "holds" if one.certificate.worst < 1e-9 else "fails",
    ]


def refusals(survey):
    """Why some designs do not exist, or that all of them do."""
    if not survey.refused:
        return Prose("Every design exists; none was refused.")
    return Table(
        ["outputs taken as accurate", "gain", "why there is no such filter"],
        [_design_row(survey, one)[:2] + [one.refusal] for one in survey.refused],
    )


def recommendation(survey):
    """Which design to take, by which rule, and what it costs; in sentences."""
    plant, best = survey.plant, survey.yardstick
    chosen = survey.recommended()
    rule = (
        "The rule: the fewest multiply-adds per step among the designs whose error "
        f"trace is at most {number(100 * TOLERANCE)} % above the smallest one."
    )
    what = f"{label(chosen, plant)}, order {chosen.order}, {_gain(chosen)} gain"
    price, further = _price(survey, chosen, best), _next_smaller(survey, chosen)
    return Prose(f"Recommended: {what}.", rule, price, further)


def _price(survey, chosen, best):
    if chosen is best:
        return (
            f"It is the most accurate design of all, with the error trace "
            f"{number(best.trace, 5)}, and no lighter one comes near enough."
        )
    saved = 1 - chosen.work / best.work if best.work else 0.0
    size = (
        f"It runs with {_count(chosen.order, 'observer state')} instead of "
        f"{best.order} and {chosen.work} multiply-adds a step instead of {best.work}, "
        f"{100 * saved:.0f} % less."
    )
    excess, name = survey.excess(chosen), label(best, survey.plant)
    if excess == 0:
        return f"Nothing is lost: its error trace is that of the {name}. {size}"
    k, ratio = _worst_state(chosen, best)
    return (
        f"Its error trace is {number(chosen.trace, 5)}, {_above(excess)} the "
        f"{number(best.trace, 5)} of the most accurate design ({name}). {size} The "
        f"state that loses most is {survey.plant.state_names[k]}: its standard "
        f"deviation grows by {_percent(ratio - 1)}."
    )


def _worst_state(chosen, best):
    """Index of the state whose standard deviation grows most, and the ratio."""
    new, old = _sigma(chosen), _sigma(best)
    ratio = np.where(old > 1e-12 * old.max(), new / np.where(old > 0, old, 1), 1.0)
    return int(np.argmax(np.round(ratio, 9))), float(ratio.max())


def _next_smaller(survey, chosen):
    smaller = [one for one in survey.designs if one.order < chosen.order]
    if not smaller:
        return "No design has fewer observer states."
    least = min(smaller, key=lambda one: one.trace)
    return (
        f"With fewer observer states the best is {label(least, survey.plant)}, order "
        f"{least.order}: its error trace is {number(least.trace, 5)}, "
        f"{_above(survey.excess(least))} the smallest."
    )


def state_errors(survey):
    """One-sigma steady error of each state, recommended design against the best."""
    chosen, best = survey.recommended(), survey.yardstick
    new, old = _sigma(chosen), _sigma(best)
    rows = [
        [name, number(a, 4), number(b, 4), _percent(b / a - 1 if a > 0 else 0.0)]
        for name, a, b in zip(survey.plant.state_names, old, new)
    ]
    header = ["state", label(best, survey.plant), "recommended", "more"]
    return Table(["" if h == "state" else h for h in header], rows)


def _sigma(design):
    return np.sqrt(np.maximum(np.diagonal(design.covariance), 0.0))


def matrices(design, plant):
    """The observer's matrices, each a table with names; zero ones are left out."""
    o = design.observer
    z = [f"z{k + 1}" for k in range(o.order)]
    sides = dict(
        F=(z, z, "next z from z"),
        G=(z, plant.input_names, "next z from u"),
        D=(z, plant.output_names, "next z from y"),
        P=(plant.state_names, z, "estimate from z"),
        V=(plant.state_names, plant.output_names, "estimate from y"),
        W=(plant.state_names, plant.input_names, "estimate from u"),
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


def transients(survey):
    """Error covariances from the start on, by label, and remarks on them.

    The Kalman filter and the recommended structure with the gains of each instant,
    from P0; and the recommended observer with its constant gain.
    """
    plant, chosen = survey.plant, survey.recommended()
    if plant.P0 is None:
        return {}, Prose("The plant gives no P0, so there is no start to show.")
    steps = settling_steps(survey)
    attempts = {
        "Kalman filter": lambda: _varying(plant, (), steps),
        "recommended, gains of each instant": lambda: _varying(
            plant, chosen.accurate, steps
        ),
        "recommended, constant gain": lambda: _constant(plant, chosen, steps),
    }
    if not chosen.accurate:
        attempts.pop("recommended, gains of each instant")
    curves, remarks = {}, []
    for name, attempt in attempts.items():
        try:
            curves[name] = attempt()
        except ValueError as error:
            remarks.append(f"Not shown: {name}. {error}")
    return curves, Prose(f"{steps} steps from P0.", *remarks)


def _varying(plant, accurate, steps):
    observer = reduced_order_filter(plant, accurate, steps=steps)
    return error_covariance(observer, plant, steps=steps)


def _constant(plant, design, steps):
    later = covariance_from_start(design.observer, plant, steps)
    return np.concatenate([plant.P0[None], later])


def settling_steps(survey):
    """How many steps show the start: until the slowest error has died away."""
    slowest = max(one.radius for one in (survey.yardstick, survey.recommended()))
    if not 0 < slowest < 1:
        return 10
    return int(np.clip(np.ceil(np.log(SETTLED) / np.log(slowest) / 2), 10, 400))


def about(data, estimates):
    """How many measurements there were and what was done with them."""
    if data is None:
        return Prose("No measurements were given.")
    return Prose(f"{_count(len(data.y), 'sample')}. {estimates.how}")


def _count(size, noun):
    return f"{size or 'no'} {noun}{'' if size == 1 else 's'}"


def _gain(design):
    if not design.accurate:
        return "optimal"
    return "step-wise" if design.horizon == "step" else "best constant"


def _percent(excess):
    if not np.isfinite(excess):
        return "unbounded"
    return f"{100 * excess:.2f} %" if excess < 10 else f"{number(1 + excess, 4)} times"


def _above(excess):
    return _percent(excess) + (" above" if excess < 10 else "")


def _magnitudes(poles):
    sizes = np.sort(np.abs(poles))[::-1]
    return ", ".join(number(size, 3, scale=sizes[0]) for size in sizes)
