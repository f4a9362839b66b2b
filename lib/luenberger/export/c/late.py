"""A plant's filter in C that takes readings late: static memory, a fixed horizon.

The device keeps one vector: the state, the p readings of this sample, and a ring with
the readings of late outputs of as many earlier samples as the horizon says.  What has
arrived has no variance.  A reading that arrives is used alone, so nothing is solved.
A step works on a copy, which takes the place of the state when nothing was refused.
"""

from typing import Any

import numpy as np

from ...errors import DesignError
from ...kernels.c import C, Module, function
from ...kernels.c.numbers import representable
from ...kernels.program import Cost
from ...kernels.writer import entry
from ...plant import Plant
from ...recursion.settings import accurate_outputs, require_start
from ...run.filter_data import filter_data
from . import source_and_header
from .admitted import settings_of
from .identifiers import quoted
from .late_kernels import Kernels
from .observer import inputs
from .selftest import selftest


def texts(
    plant: Plant, late: Any, horizon: Any, name: str, real: str
) -> dict[str, str]:
    """The two files of a filter that takes the outputs `late` late, by name."""
    whole = isinstance(horizon, (int, np.integer)) and not isinstance(horizon, bool)
    if not whole or horizon < 1:
        raise ValueError(
            f"late outputs need horizon=, the samples that a device waits for at most; "
            f"got {horizon!r}"
        )
    settings = settings_of(plant, 0, None, real)
    which = accurate_outputs(plant, late)
    if not which:
        raise DesignError("late names no output; leave it out")
    filter_ = _Late(settings, which, int(horizon), Module(name, real))
    module, functions = filter_.module, filter_.functions()
    body = source_and_header.source(module, functions)
    body += "\n" + filter_.selftest()
    head = source_and_header.header(
        module,
        f"The Kalman filter of {plant.n} states; "
        f"{', '.join(quoted(plant.output_names[j]) for j in which)} may arrive up to "
        f"{horizon} samples late.",
        EQUATIONS,
        plant.dt,
        source_and_header.Signals(
            plant.input_names, plant.output_names, plant.state_names
        ),
        filter_.members(),
        [
            *_notes(name),
            *source_and_header.cost_notes(module, filter_.size(), filter_.costs),
            "",
            "No bound on rounding is proved for readings that arrive late.",
        ],
        [
            "",
            "/* A reading that was taken `age` samples ago; the same. */",
            f"{filter_.arrived_prototype()};",
        ],
    )
    return source_and_header.stamped(name, head, body)


EQUATIONS = [
    "xi = [x^; what is expected of readings], P its covariance",
    "Omega = As Sigma As' + As X J' + J X' As' + J Z J' + Q       (44)",
    "xi + P_t (y - xi_t) / P_tt, P - P_t P_t' / P_tt: a reading arrived",
]


def _notes(name: str) -> list[str]:
    return [
        "NaN in y: not here yet, or not measured.  A reading of an output that may be",
        f"late is given to {name}_arrived once it comes, after the step of its sample:",
        "age 0 is the sample of the last step.  It is refused where it is infinite or",
        "NaN, has been used before, or is older than the horizon; and so is what would",
        "leave a negative variance.",
    ]


class _Late(Kernels):
    """The functions of one filter, and what they cost."""

    def functions(self) -> list[str]:
        use, predict, take = self.use(), self.predict(), self.take()
        one, rest = self.costs.pop("use"), self.costs.pop("predict")
        sample = rest + self.costs.pop("take")
        for _ in range(self.p):
            sample = Cost(sample.operations + one.operations, sample.constants, 0)
        stack = self.size() + one.stack + rest.stack
        self.costs["a sample with every output"] = Cost(
            sample.operations, sample.constants, stack
        )
        self.costs["a reading that arrives late"] = Cost(one.operations, 0, stack)
        return [self.init(), use, predict, take, self.step(), self.arrived()]

    def init(self) -> str:
        name, to, here = (
            self.module.name,
            C(self.module.real),
            self.plant.at_first_sample(),
        )
        Omega = representable("P0", require_start(here), self.module.real)
        to.table("Omega", Omega)
        for member, length, _ in self.members():
            to.fill(f"state->{member}[i]", "0.0", max(length, 1))
        start = representable("x0", here.x0, self.module.real)
        for k, value in enumerate(start.tolist()):
            to.set(f"state->xi[{k}]", repr(value))
        to.loop("i", 0, self.n**2)
        to.set(self.entry(0, 0, self.n), "Omega[i]")
        to.end()
        return function(f"void {name}_init({name}_state *state)", to.lines)

    def step(self) -> str:
        name, to = self.module.name, C(self.module.real)
        to.line(f"{name}_state next;")
        to.set("next", "*state")
        for given, length, test in (
            ("u", self.m, "isfinite({}[i]) != 0"),
            ("y", self.p, "isinf({}[i]) == 0"),
        ):
            if length:
                to.loop("i", 0, length)
                to.need(test.format(given))
                to.end()
        to.when("next.at[1] > 0.0", f"{name}_predict(&next);")
        to.line(f"{name}_take(&next, u);")
        to.loop("i", 0, self.p)
        to.when("isnan(y[i]) != 0", "continue;")
        to.need(f"{name}_use(&next, {self.n} + i, y[i]) == 0")
        to.set("next.awaited[i]", "0.0")
        to.end()
        self.done(to)
        return function(source_and_header.prototype(self.module), to.lines, ["u", "y"])

    def done(self, to: C) -> None:
        """The state and the estimate, once nothing can be refused any more."""
        to.line("*state = next;")
        to.fill("what[i]", "state->xi[i]", self.n)
        to.line("return 0;")

    def arrived_prototype(self) -> str:
        name, real = self.module.name, self.module.real
        return (
            f"int {name}_arrived({name}_state *state, int output, int age, {real} y,\n"
            f"    {real} what[])"
        )

    def arrived(self) -> str:
        name, to, H = self.module.name, C(self.module.real), self.horizon
        to.line(f"{name}_state next;")
        to.line("int late = -1, k;")
        to.set("next", "*state")
        for k, j in enumerate(self.late):
            to.when(f"output == {j}", f"late = {k};")
        to.need(f"(late >= 0) && (age >= 0) && (age <= {H}) && (isfinite(y) != 0)")
        ring = entry("", (f"(((int)next.at[0] - age + {H}) % {H})", len(self.late)))
        to.line(f"k = (age == 0) ? output : ({self.p} + {ring[1:-1]} + late);")
        to.need("next.awaited[k] > 0.0")
        to.need(f"{name}_use(&next, {self.n} + k, y) == 0")
        to.set("next.awaited[k]", "0.0")
        self.done(to)
        return function(self.arrived_prototype(), to.lines)

    def selftest(self) -> str:
        """A main that compares a run, readings in any order, with Python's."""
        plant, (u, y) = self.settings.plant, inputs(self.m, self.p)
        y = np.array(y)
        y[4::5, 0] = np.nan
        rows = np.arange(len(y))
        arrival = np.repeat(rows[:, None].astype(float), self.p, axis=1)
        arrival[:, self.late] += (rows * 3 % (self.horizon + 1))[:, None]
        wanted = filter_data(plant, y, u, arrival=arrival).x
        late = (arrival > rows[:, None]) & ~np.isnan(y)
        events = np.array(
            [
                (arrival[k, j], j, arrival[k, j] - k, y[k, j])
                for k, j in np.argwhere(late).tolist()
            ]
        ).reshape(-1, 4)
        name = self.module.name
        lines = [
            f"for (int e = 0; e < {len(events)}; e++) {{",
            f"    const {self.module.real} *one = {name}_late + 4 * e;",
            "    if ((int)one[0] != k) {",
            "        continue;",
            "    }",
            f"    if ({name}_arrived(&state, (int)one[1], (int)one[2], one[3], what)"
            " != 0) {",
            "        return 1;",
            "    }",
            "}",
        ]
        y = np.where(late, np.nan, y)
        return selftest(
            self.module, u, y, wanted, {"late": events} if len(events) else {},
            lines if len(events) else (),
        )  # fmt: skip
