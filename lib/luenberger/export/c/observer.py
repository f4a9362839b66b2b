"""A constant observer in C."""

import warnings
from collections.abc import Mapping

import numpy as np

from ...analysis.step_cost import MATRICES, Counts, counts, narrowed
from ...errors import SAMPLE, DesignError
from ...kernels.c.file import File, function
from ...kernels.c.step import write_step
from ...kernels.c.writer import C
from ...numeric.linalg import modes
from ...observer import Observer
from ...papers.leondes_novak.derivation import observer_step
from ...plant import Plant
from ...run.estimate import estimate
from . import source_and_header
from .rounding_bound import floating_notes
from .selftest import selftest
from .source_and_header import Signals

ROWS = 24  # of the self-test
UNIT = 2.0**-24  # rounding of float
SLOW = 1e-3  # of z: what rounding may add up to without a warning


def texts(
    observer: Observer,
    name: str,
    real: str,
    signals: Signals,
    plant: Plant | None = None,
    ranges: Mapping[str, float] | None = None,
) -> dict[str, str]:
    """The two files of an observer, by name."""
    rounding = floating_notes(observer, real, signals, plant, ranges)
    observer, module = narrowed(observer, real), File(name, real)
    if real == "float":
        require_exportable(observer, " in float")
        _warn_of_slow_modes(observer)
    r, m, p = observer.order, observer.G.shape[1], observer.D.shape[1]
    step, cost = _step(module, observer)
    u, y = inputs(m, p)
    body = source_and_header.source(module, [_init(module, observer), step])
    body += "\n" + selftest(module, u, y, estimate(observer, y, u))
    head = source_and_header.header(
        module,
        f"An observer of order {r}.",
        EQUATIONS,
        observer.dt,
        signals,
        [("z", r, "z of the next sample; it follows T x")],
        [
            "A sample that is not finite is refused: one NaN would stay for good.  So",
            f"is one so large that a state or an estimate is no finite {real}.",
            *source_and_header.step_notes(module, r, cost),
            *rounding,
        ],
    )
    return source_and_header.stamped(name, head, body)


EQUATIONS = [
    "z[i+1] = F z[i] + G u[i] + D y[i]     (7)",
    "w^[i]  = P z[i] + V y[i] + W u[i]     estimates w = L x",
]


def _step(module: File, observer: Observer) -> tuple[str, Counts]:
    """The C function, and what it costs."""
    to, (q, r) = C(module.real), observer.P.shape
    sizes = dict(q=q, r=r, p=observer.D.shape[1], m=observer.G.shape[1])
    for array, length in (("y", sizes["p"]), ("u", sizes["m"])):
        if length:
            to.loop("i", 0, length)
            to.need(f"isfinite({array}[i]) != 0")
            to.end()
    for array, length in (("y", sizes["p"]), ("u", sizes["m"]), ("state", r)):
        if not length:
            to.line(f"(void){array};")
    to.array("shown", q)
    if r:
        to.array("moved", r)
    cost = counts(observer)
    write_step(
        observer_step(),
        sizes,
        {k: getattr(observer, k) for k in MATRICES},
        module,
        to,
        {"z": "state->z"},
        {"w_hat": "shown", "z_next": "moved"},
        scalars=cost.scalars,
    )
    found = [("shown", "what", q), ("moved", "state->z", r)]
    found = [one for one in found if one[-1]]
    for array, _, length in found:
        to.loop("i", 0, length)
        to.need(f"isfinite({array}[i]) != 0")
        to.end()
    for array, place, length in found:
        to.loop("i", 0, length)
        to.set(f"{place}[i]", f"{array}[i]")
        to.end()
    to.line("return 0;")
    return function(source_and_header.prototype(module), to.lines), cost


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


def _init(module: File, observer: Observer) -> str:
    to = C(module.real)
    for k, value in enumerate(observer.z0.tolist()):
        to.set(f"state->z[{k}]", repr(value))
    if not observer.order:
        to.set("state->z[0]", "0.0")
    return function(f"void {module.name}_init({module.name}_state *state)", to.lines)
