"""A constant observer in C."""

import dataclasses
from typing import NamedTuple

import numpy as np

from ...errors import DesignError
from ...kernels import lowered
from ...numeric.linalg import modes
from ...papers.leondes_novak.derivation import observer_step
from ...run.estimate import estimate
from . import source_and_header
from .function_body import Module
from .identifiers import representable

ROWS = 24  # of the self-test
MATRICES = "FGDPVW"


def texts(observer, name, real, signals):
    """The two files of an observer, by name."""
    observer, module = _rounded(observer, real), Module(name, real)
    r, m, p = observer.order, observer.G.shape[1], observer.D.shape[1]
    step, cost = _step(module, observer)
    u, y = inputs(m, p)
    body = source_and_header.source(module, [_init(module, observer), step])
    body += "\n" + source_and_header.selftest(module, u, y, estimate(observer, y, u))
    head = source_and_header.header(
        module,
        f"An observer of order {r}.",
        EQUATIONS,
        observer.dt,
        signals,
        [("z", r, "z of the next sample; it follows T x")],
        [
            "A sample that is not finite is refused: one NaN would stay for good.",
            *source_and_header.cost_notes(module, r, {"a sample": cost}),
        ],
    )
    return source_and_header.stamped(name, head, body)


class StepCost(NamedTuple):
    """What one observer costs on a device, in doubles."""

    multiply_adds: int  # of a step
    bytes: int  # of its state and constants


def step_cost(observer):
    """Count the C that `to_c` would write for a constant, real observer.

    Short observers are written as scalars, where zeros and copies cost nothing and
    equal expressions are computed once; long and dense ones as loops, which multiply
    by zeros too.

    Examples
    --------
    >>> import luenberger as lb
    >>> step_cost(lb.Observer([[0.5]], [[1]], [[2]], [[0], [1]], [[1], [2]],
    ...                       T=[[-2, 1]], L=[[1, 0], [0, 1]]))
    StepCost(multiply_adds=5, bytes=32)
    """
    _, cost = _step(Module("observer", "double"), observer)
    size = source_and_header.BYTES["double"]
    return StepCost(cost.terms, (observer.order + cost.constants) * size)


EQUATIONS = [
    "z[i+1] = F z[i] + G u[i] + D y[i]     (9)",
    "w^[i]  = P z[i] + V y[i] + W u[i]     estimates w = L x",
]


def _step(module, observer):
    """The C function, and what it costs."""
    from ...kernels.c import C

    to, (program, sizes) = C(module.real), _program(observer)
    for array, length in (("y", sizes["p"]), ("u", sizes["m"])):
        if length:
            to.loop("i", 0, length)
            to.need(f"isfinite({array}[i])")
            to.end()
    for array, length in (("y", sizes["p"]), ("u", sizes["m"]), ("state", sizes["r"])):
        if not length:
            to.line(f"(void){array};")
    cost = module.steps(
        program,
        sizes,
        to,
        {k: getattr(observer, k) for k in MATRICES},
        {"z": "state->z"},
        {"w_hat": ("what", sizes["q"]), "z_next": ("state->z", sizes["r"])},
    )
    cost.operations += sizes["p"] + sizes["m"]
    to.line("return 0;")
    return "\n".join(
        [source_and_header.prototype(module), "{", *to.lines, "}", ""]
    ), cost


def require_exportable(observer):
    """Raise DesignError for an observer that a device could not run for long."""
    if observer.steps is not None:
        raise DesignError(
            f"the observer has {observer.steps} rows of gains. Give to_c the plant, "
            "with m1, and the gains are computed on the device; or a constant design."
        )
    if observer.dt == 0:
        raise DesignError(
            "the observer is in continuous time (dt = 0); a device takes samples. "
            "Discretise the plant and design the observer for that."
        )
    unstable = observer.poles[np.abs(observer.poles) >= 1]
    if unstable.size:
        raise DesignError(
            f"the observer is not stable: it has poles at {modes(unstable)}, so its "
            "error would grow on the device"
        )


def inputs(m, p):
    """Inputs and measurements for a self-test: short numbers, the same every time."""
    rng = np.random.default_rng(8)
    values = rng.integers(-16, 17, size=(ROWS, m + p)) / 8
    return values[:, :m], values[:, m:]


def _program(observer):
    zero = [k for k in MATRICES if not getattr(observer, k).any()]
    program = lowered(observer_step, ["w_hat", "z_next"], zero=zero)
    (q, r), p, m = observer.P.shape, observer.D.shape[1], observer.G.shape[1]
    return program, {"q": q, "r": r, "p": p, "m": m}


def _rounded(observer, real):
    """The observer in the numbers that the device has."""
    names = (*MATRICES, "z0")
    return dataclasses.replace(
        observer, **{k: representable(k, getattr(observer, k), real) for k in names}
    )


def _init(module, observer):
    lines = [f"void {module.name}_init({module.name}_state *state)", "{"]
    lines += [
        f"    state->z[{k}] = {module.number(v)};" for k, v in enumerate(observer.z0)
    ]
    if not observer.order:
        lines += ["    state->z[0] = 0;"]
    return "\n".join([*lines, "}", ""])
