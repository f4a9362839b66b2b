"""A constant observer in C."""

import warnings
from collections.abc import Sequence

import numpy as np

from ...analysis.step_cost import counts, narrowed
from ...errors import SAMPLE, DesignError
from ...kernels.c.file import File, function
from ...kernels.c.numbers import representable
from ...kernels.c.step import write_step
from ...kernels.c.writer import C
from ...numeric import Matrix
from ...numeric.linalg import modes
from ...observer import Observer
from ...papers.leondes_novak.derivation import observer_step
from ...run.estimate import estimated
from .source_and_header import Cost, Module, Signals, Use, prototype
from .source_and_header import texts as both

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
        poles = observer.poles  # what each step rounds decays with the modes
        slow = poles[UNIT > SLOW * (1 - np.abs(poles))]
        if slow.size:
            lost = UNIT / (1 - np.abs(slow).max())
            warnings.warn(
                f"in float each step rounds z by up to {UNIT:.0e} of it, and the modes "
                f"at {modes(slow)} add that up to {lost:.1e}; export double, or see "
                "with export.rounding_error what it does to the estimates",
                RuntimeWarning,
                stacklevel=3,
            )
    (q, r), m, p = observer.P.shape, observer.G.shape[1], observer.D.shape[1]
    used, found, functions = uses(observer), counts(observer), []
    to = C(real)
    for k, value in enumerate(observer.z0.tolist() or [0.0]):
        to.set(f"state->z[{k}]", repr(value))
    if r:
        to.check("x0 != NULL")
        for k, row in enumerate(representable("T", observer.T, real).tolist()):
            to.set(f"state->z[{k}]", sum_of(row, "x0"))
        to.end()
    functions.append(function(prototype(file, used[0]), to.lines, ["x0"]))
    for use in used[1:]:
        to, read = C(real), [k for k in use.arguments if k != "what"]
        for k in read:
            to.each(k, m if k == "u" else p, "isfinite({}) != 0")
        result, place, length = (
            ("w_hat", "what", q)
            if use.name == "estimate"
            else ("z_next", "state->z", r)
        )
        if length:
            to.array("found", length)
            write_step(
                observer_step(),
                dict(q=q, r=r, p=p, m=m),
                {k: getattr(observer, k) for k in "FGDPVW"},
                file,
                to,
                {"z": "state->z"},
                {result: "found"},
                scalars=found[use.name].scalars,
            )
            to.each("found", length, "isfinite({}) != 0")
            to.loop("i", 0, length)
            to.set(f"{place}[i]", "found[i]")
            to.end()
        to.line("return 0;")
        functions.append(function(prototype(file, use), to.lines, ("state", *read)))
    u, y = inputs(m, p)
    return both(
        Module(
            file,
            f"An observer of order {r}.",
            EQUATIONS,
            NOTES,
            observer.dt,
            signals,
            [("z", r, "z of this sample, or of the next; it follows T x")],
            used,
            functions,
            sum(one.constants for one in found.values()),
            {k: Cost(x.terms, x.operations, x.stack) for k, x in found.items()},
            (u, y, estimated(observer, (0, observer.z0), y, u)[1]),
        )
    )


def uses(observer: Observer) -> list[Use]:
    """The functions, each with the arguments that it reads."""
    there = {k: bool(getattr(observer, k).any()) for k in "GDVW"}
    return [
        Use("init", ("x0",), ["Before the first sample."]),
        Use("estimate", (*"u" * there["W"], *"y" * there["V"], "what"), CODES),
        Use("advance", (*"u" * there["G"], *"y" * there["D"]), CODES),
    ]


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


def inputs(m: int, p: int) -> tuple[Matrix, Matrix]:
    """Inputs and measurements for a self-test: short numbers, the same every time."""
    rng = np.random.default_rng(8)
    values = rng.integers(-16, 17, size=(ROWS, m + p)) / 8
    return values[:, :m], values[:, m:]


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
