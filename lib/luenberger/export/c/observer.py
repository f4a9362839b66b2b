"""A constant observer in C."""

import warnings
from collections.abc import Sequence

import numpy as np

from ...analysis.step_cost import Counts, counts, narrowed
from ...errors import SAMPLE, DesignError
from ...kernels.c.file import File, function
from ...kernels.c.numbers import representable
from ...kernels.c.step import write_step
from ...kernels.c.writer import C
from ...numeric.linalg import modes
from ...observer import Observer
from ...papers.leondes_novak.derivation import observer_step
from ...run.estimate import plain
from . import source_and_header
from .selftest import selftest
from .source_and_header import Cost, Signals, Use

ROWS = 24  # of the self-test
UNIT = 2.0**-24  # rounding of float
SLOW = 1e-3  # of z: what rounding may add up to without a warning
EQUATIONS = [
    "z[i+1] = F z[i] + G u[i] + D y[i]     (7)",
    "w^[i]  = P z[i] + V y[i] + W u[i]     estimates w = L x",
]
CODES = ("0: done; 1: refused, as a number is not finite, and state and what are as",
         "they were.")  # fmt: skip
NOTES = [
    "",
    "A number that is not finite is refused: one NaN would stay for good.  So is what",
    "would make a state or an estimate infinite.",
]


def texts(observer: Observer, name: str, real: str, signals: Signals) -> dict[str, str]:
    """The two files of an observer, by name."""
    observer, file = narrowed(observer, real), File(name, real)
    if real == "float":
        require_exportable(observer, " in float")
        _warn_of_slow_modes(observer)
    r, m, p = observer.order, observer.G.shape[1], observer.D.shape[1]
    used, costs = uses(observer), counts(observer)
    functions = [_init(file, observer, used[0])]
    functions += [_step(file, observer, use, costs[use.name]) for use in used[1:]]
    u, y = inputs(m, p)
    body = source_and_header.source(file, functions)
    body += "\n" + selftest(file, used, u, y, plain(observer, y, u))
    constants = sum(one.constants for one in costs.values())
    spent = {k: Cost(x.terms, x.operations, x.stack) for k, x in costs.items()}
    head = source_and_header.header(
        file,
        f"An observer of order {r}.",
        EQUATIONS,
        observer.dt,
        signals,
        [("z", r, "z of this sample, or of the next; it follows T x")],
        used,
        _arguments(observer),
        NOTES + source_and_header.cost_notes(file, r, constants, spent),
    )
    return source_and_header.stamped(name, head, body)


def uses(observer: Observer) -> list[Use]:
    """The functions, each with the arguments that it reads."""
    there = {k: bool(getattr(observer, k).any()) for k in "GDVW"}
    seen = ("const u",) * there["W"] + ("const y",) * there["V"]
    moved = ("const u",) * there["G"] + ("const y",) * there["D"]
    return [
        Use("init", ("const x0",), ["Before the first sample."], "void"),
        Use("estimate", (*seen, "what"), CODES),
        Use("advance", moved, CODES),
    ]


def _arguments(observer: Observer) -> dict[str, list[str]]:
    early = ["and, as W is not 0, in the estimate of its own instant"]
    return {
        "x0": ["the plant's state at the first sample, as it is known; NULL: z begins",
               "as the observer does"],
        "u": ["known inputs, which act from this sample to the next",
              *early * bool(observer.W.any())],
        "y": ["measurements of this sample"],
        "what": ["the estimate, written by an estimate"],
    }  # fmt: skip


def _step(file: File, observer: Observer, use: Use, cost: Counts) -> str:
    """The estimate, or what leads to the next sample."""
    to, (q, r) = C(file.real), observer.P.shape
    sizes = dict(q=q, r=r, p=observer.D.shape[1], m=observer.G.shape[1])
    read = [one[-1] for one in use.arguments if one.startswith("const ")]
    for array in read:
        to.loop("i", 0, sizes["m" if array == "u" else "p"])
        to.need(f"isfinite({array}[i]) != 0")
        to.end()
    result, place, length = (
        ("w_hat", "what", q) if use.name == "estimate" else ("z_next", "state->z", r)
    )
    if length:
        to.array("found", length)
        write_step(
            observer_step(),
            sizes,
            {k: getattr(observer, k) for k in "FGDPVW"},
            file,
            to,
            {"z": "state->z"},
            {result: "found"},
            scalars=cost.scalars,
        )
        to.loop("i", 0, length)
        to.need("isfinite(found[i]) != 0")
        to.end()
        to.loop("i", 0, length)
        to.set(f"{place}[i]", "found[i]")
        to.end()
    to.line("return 0;")
    head = source_and_header.prototype(file, use)
    return function(head, to.lines, ("state", *read))


def _warn_of_slow_modes(observer: Observer) -> None:
    """In float; what rounding does at each step decays with the modes."""
    poles = observer.poles
    slow = poles[UNIT > SLOW * (1 - np.abs(poles))]
    if slow.size:
        lost = UNIT / (1 - np.abs(slow).max())
        warnings.warn(
            f"in float each step rounds z by up to {UNIT:.0e} of it, and the modes at "
            f"{modes(slow)} add that up to {lost:.1e}; export double, or see with "
            "export.rounding_error what it does to the estimates",
            RuntimeWarning,
            stacklevel=4,
        )


def require_exportable(observer: Observer, where: str = "") -> None:
    """Raise DesignError for an observer that a device could not run for long."""
    if observer.steps is not None:
        raise DesignError(
            f"the observer has {observer.steps} rows of gains. Give to_c the plant, "
            "with m1, and the gains are computed on the device; or a constant design."
        )
    if observer.dt == 0:
        raise DesignError(
            "the observer is in continuous time (dt = 0); a device takes samples. "
            f"Design it for the sampled plant: {SAMPLE}."
        )
    unstable = observer.poles[np.abs(observer.poles) >= 1]
    if unstable.size:
        raise DesignError(
            f"the observer{where} is not stable: it has poles at {modes(unstable)}, "
            "so its error would grow on the device"
        )


def inputs(m: int, p: int) -> tuple[np.ndarray, np.ndarray]:
    """Inputs and measurements for a self-test: short numbers, the same every time."""
    rng = np.random.default_rng(8)
    values = rng.integers(-16, 17, size=(ROWS, m + p)) / 8
    return values[:, :m], values[:, m:]


def _init(file: File, observer: Observer, use: Use) -> str:
    to, T = C(file.real), representable("T", observer.T, file.real)
    for k, value in enumerate(observer.z0.tolist()):
        to.set(f"state->z[{k}]", repr(value))
    if not observer.order:
        to.set("state->z[0]", "0.0")
        return function(source_and_header.prototype(file, use), to.lines, ["x0"])
    to.check("x0 != NULL")
    for k, row in enumerate(T.tolist()):
        to.set(f"state->z[{k}]", sum_of(row, "x0"))
    to.end()
    return function(source_and_header.prototype(file, use), to.lines)


def sum_of(row: Sequence[float], array: str) -> str:
    """What a row makes of an array.

    >>> sum_of([1.0, 0.0, -2.5], "u")
    'u[0] + (-2.5 * u[2])'
    """
    terms = [
        f"{array}[{k}]" if x == 1 else f"({x!r} * {array}[{k}])"
        for k, x in enumerate(row)
        if x
    ]
    return " + ".join(terms) or "0.0"
