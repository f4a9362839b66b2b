"""A plant's filter in C: the estimate, its gain and its covariance at every sample."""

from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np
from numpy.typing import ArrayLike

from ...kernels import lowered
from ...kernels.c import C, Module, function
from ...kernels.c.repair import by_columns, operations, repair, settle, settling
from ...kernels.program import Cost, Guard, Program
from ...numeric import Matrices
from ...numeric.linalg import symmetrise
from ...papers.leondes_novak.derivation import (
    complete_sample,
    partial_sample,
    predict,
    short_sample,
)
from ...plant import Plant
from ...recursion.settings import Settings
from ...run.filter import Filter
from ...run.record import Record
from ...stage_list import StageList
from . import guard, source_and_header
from .admitted import settings_of
from .filter_plant import (
    correlated,
    matrices,
    narrowed,
    sample_program,
    start,
    vanishing,
)
from .filter_words import filter_notes
from .identifiers import quoted
from .observer import inputs
from .selftest import selftest

MOVES = ["J", "As", "Q"]  # what S makes of the outputs that arrived
RESULTS = {"x_minus_next": "state->x_minus", "Omega_next": "state->Omega"}
OUT = {"x": "what", "Sigma": "state->Sigma"}
PLANT = {"A": "A", "Q_all": "Q", "C_all": "C", "E_all": "E", "R_all": "R"}


def texts(
    plant: Plant,
    m1: int | Sequence[int | str],
    weight: ArrayLike | str | None,
    name: str,
    real: str,
    update: str,
    ranges: Mapping[str, float] | None,
) -> dict[str, str]:
    """The two files of a plant's filter, by name."""
    rounding = filter_notes(plant, m1, real, update, ranges)
    settings = settings_of(plant, m1, weight, real)
    filter_ = _Filter(settings, Module(name, real), update == "guarded")
    module, plant, n = filter_.module, settings.plant, settings.plant.n
    said = guard.notes(n, plant.p, real) if filter_.guarded else []
    u, y = map(np.array, inputs(plant.m, plant.p))
    y[4::5, 0], y[7::9] = np.nan, np.nan  # one missing, all missing
    wanted = Filter(plant, settings.accurate, weight).run(Record(y, u))
    body = source_and_header.source(module, filter_.functions)
    body += "\n" + selftest(module, u, y, wanted.x)
    accurate = ", ".join(quoted(plant.output_names[k]) for k in settings.accurate)
    head = source_and_header.header(
        module,
        f"The filter of {n} states"
        + (f", {accurate} treated as exact." if accurate else " (Kalman)."),
        EQUATIONS,
        plant.dt,
        source_and_header.Signals(
            plant.input_names, plant.output_names, plant.state_names
        ),
        [
            ("x_minus", n, "x^ of the next sample before it is used"),
            ("Omega", n * n, "its error covariance, row by row"),
            ("Sigma", n * n, "error covariance of what, for reading"),
        ],
        [
            *NOTES,
            *said,
            *source_and_header.cost_notes(module, n + 2 * n * n, filter_.costs),
            *rounding,
        ],
    )
    return source_and_header.stamped(name, head, body)


EQUATIONS = [
    "M = C Omega C' + R,  Kmv = Omega C' M^-1            (33)",
    "K = Kmv + Gamma - Gamma C Kmv                       (33)",
    "Sigma = (I - K C) Omega (I - K C)' + K R K'         (27)",
    "x^ = x_minus + K (y - E u - C x_minus)              (43)",
    "Omega[i+1] = As Sigma As' + Q                       (44)",
    "x_minus[i+1] = A x^ + B u + J (y - E u - C x^)      (43)",
]
NOTES = [
    "NaN in y: not measured; the others are used.  A number that is infinite is",
    "refused, and so is a sample whose M is singular to working precision.  Before",
    "the first step the state is its prediction, with no input before, Sigma is Omega.",
]


class _Filter:
    """The functions of one filter, and what a sample costs."""

    def __init__(self, settings: Settings, module: Module, guarded: bool) -> None:
        self.settings, self.plant, self.module = settings, settings.plant, module
        plant = self.plant
        self.sizes = {"n": plant.n, "p": plant.p, "m": plant.m}
        self.cross = correlated(plant)
        weight: Any = np.eye(plant.n) if settings.weight is None else settings.weight
        whole = {k: getattr(plant, field) for k, field in PLANT.items()}
        whole["S_all"] = plant.S if self.cross else np.zeros((plant.n, plant.p))
        whole["Inverse"] = symmetrise(np.linalg.inv(weight))
        self.full, self.whole = (
            narrowed(X, module.real) for X in (matrices(settings), whole)
        )
        subtracts = bool(settings.at(0).C.any())
        self.guarded = guarded and subtracts
        complete, self.costs = self.complete()
        predict, after = self.predict()
        partial, before = self.partial()
        n = plant.n
        settled = settle(module, self.full["As"], self.full["Q"])
        self.functions = [self.init(), settled, *complete, repair(module, n)]
        self.functions += [predict, partial, self.step()]
        some = before + after
        rare = Cost(some.operations + operations(n), 0, some.stack + n * (2 * n + 1))
        self.costs["one with outputs missing"] = some
        self.costs["one after which rounding left Sigma indefinite"] = rare

    def complete(self) -> tuple[list[str], dict[str, Cost]]:
        """Every output arrived: the fast ways, which give up where they must."""
        text, cost = self.sample("complete", complete_sample, self.full)
        if not self.guarded:
            return [text], {"a sample with every output": cost}
        n, p, real = self.plant.n, self.plant.p, self.module.real
        given = self.full | guard.sizes(self.plant, self.full, real)
        tests = guard.guards(n, p, real)
        quick, some = self.sample("short", short_sample, given, tests)
        return [text, quick], {
            "a sample with every output, in the short form": some,
            "one in the other form": Cost(
                some.operations + cost.operations,
                cost.constants,
                max(some.stack, cost.stack),
            ),
        }

    def sample(
        self,
        what: str,
        stages: StageList,
        given: Matrices,
        guards: Sequence[Guard] = (),
    ) -> tuple[str, Cost]:
        """The function of a sample with every output, and its cost."""
        program = sample_program(self.settings, stages, given, guards)
        places = {k: f"state->{k}" for k in ("x_minus", "Omega")}
        to = C(self.module.real)
        cost = self.body(to, program, given, places, RESULTS | OUT)
        self.settled(to)
        return self.function(what, to), cost

    def settled(self, to: C, given: bool = False) -> None:
        """Call what clears Omega of rounding; are As and Q the function's own?"""
        prefix = f"{self.module.name}_settle"
        own = by_columns(to, self.plant.n) if given else f"{prefix}_As_T, {prefix}_Q"
        to.line(f"{prefix}(state->Omega, state->Sigma, {own});")

    def partial(self) -> tuple[str, Cost]:
        """Some did not: matrices for those that did, update, repair, predict."""
        n, p, name = self.plant.n, self.plant.p, self.module.name
        outputs = ["x", "Sigma"] + (["rho", *MOVES] if self.cross else [])
        accurate = self.settings.accurate
        program = lowered(
            partial_sample,
            outputs,
            zero=vanishing(self.whole) + ([] if accurate else ["Taken"]),
            symmetric=("Q_all", "R_all", "Inverse", "Omega"),
        )
        local = {k: {"rho": p, "J": n * p}.get(k, n * n) for k in outputs[2:]}
        to = C(self.module.real)
        for table in ("Seen", "Taken"):
            to.array(table, p * p, " = {0}")
        to.array("came", p)
        for k, size in local.items():
            to.array(f"{k}_now", size)
        to.loop("i", 0, p)
        to.set(f"Seen[i * {p + 1}]", "(isnan(y[i]) != 0) ? 0.0 : 1.0")
        to.set("came[i]", "(isnan(y[i]) != 0) ? 0.0 : y[i]")
        to.end()
        for k in accurate:
            to.set(f"Taken[{k * (p + 1)}]", f"Seen[{k * (p + 1)}]")
        for matrix, array in {"Seen": "Seen", "Taken": "Taken", "y": "came"}.items():
            if matrix not in program.given:
                to.line(f"(void){array};")
        rest = "".join(f", {k}_now" for k in local)
        results = {k: f"{k}_now" for k in local} | OUT
        places = {"y": "came"} | {k: f"state->{k}" for k in ("x_minus", "Omega")}
        cost = self.body(to, program, self.whole, places, results)
        cost += Cost(stack=2 * p * p + p + sum(local.values()))
        to.line(f"{name}_semidefinite(state->Sigma, state->Omega);")
        to.line(f"{name}_predict(state, u, what{rest});")
        return self.function("partial", to), cost

    def predict(self) -> tuple[str, Cost]:
        """From Sigma and x of this sample to the next."""
        moves = [] if not self.cross else MOVES
        constants = {k: X for k, X in self.full.items() if k not in moves}
        program = lowered(
            predict,
            list(RESULTS),
            zero=[k for k in vanishing(constants) if k in "A As B J Q".split()],
            symmetric=("Q", "Sigma"),
            same=() if self.cross else [("As", "A")],
        )
        given = ["u", "x", *(["rho", *moves] if moves else [])]
        to, places = C(self.module.real), {"Sigma": "state->Sigma"}
        cost = self.body(to, program, constants, places, RESULTS)
        self.settled(to, given=self.cross)
        return self.function("predict", to, given), cost

    def body(
        self,
        to: C,
        program: Program,
        constants: Matrices,
        places: dict[str, str],
        results: dict[str, str],
    ) -> Cost:
        """Write one pass of a program, and return its cost: see `Module.steps`."""
        n, p = self.plant.n, self.plant.p
        lengths = {"x": n, "x_minus_next": n, "rho": p, "J": n * p}
        results = {k: (results[k], lengths.get(k, n * n)) for k in program.results}
        cost = self.module.steps(program, self.sizes, to, constants, places, results)
        return cost + (settling(n) if "Omega_next" in results else Cost())

    def function(self, what: str, to: C, given: Sequence[str] | None = None) -> str:
        """A static C function of the state and the arrays `given`.

        Without `given` it is a step: it reads u and y, writes x^ into `what` and
        returns whether it gave up.
        """
        name, real, read = self.module.name, self.module.real, given or ("u", "y")
        arguments = [f"{name}_state *state", *(f"const {real} {k}[]" for k in read)]
        if given is None:
            arguments += [f"{real} what[]"]
            to.line("return 0;")
        kind = "int" if given is None else "void"
        head = f"static {kind} {name}_{what}({', '.join(arguments)})"
        return function(head, to.lines, read)

    def init(self) -> str:
        name, to = self.module.name, C(self.module.real)
        x, Omega = start(self.plant, self.module.real)
        to.table("Omega", Omega)
        for k, value in enumerate(x.tolist()):
            to.set(f"state->x_minus[{k}]", repr(value))
        to.loop("i", 0, Omega.size)
        to.set("state->Omega[i]", "Omega[i]")
        to.set("state->Sigma[i]", "Omega[i]")
        to.end()
        return function(f"void {name}_init({name}_state *state)", to.lines)

    def step(self) -> str:
        name, to = self.module.name, C(self.module.real)
        to.line("int refused = 0;")
        if self.plant.m:
            to.loop("i", 0, self.plant.m)
            to.need("isfinite(u[i]) != 0")
            to.end()
        to.loop("i", 0, self.plant.p)
        to.need("isinf(y[i]) == 0")
        to.when("isnan(y[i]) != 0", "refused = 1;")
        to.end()
        to.check("refused == 0")
        if self.guarded:
            to.line(f"refused = {name}_short(state, u, y, what);")
            to.check("refused != 0")
        to.line(f"refused = {name}_complete(state, u, y, what);")
        if self.guarded:
            to.end()
        to.end()
        to.line(f"return (refused == 0) ? 0 : {name}_partial(state, u, y, what);")
        return function(source_and_header.prototype(self.module), to.lines)
