"""What a device has of a filter, and what both ways of writing it in C share."""

from __future__ import annotations

import re
from collections.abc import Callable, Sequence

import numpy as np

from ...filtering import passes
from ...filtering.maps import Settings
from ...filtering.pack import begin
from ...filtering.passes import CLASH, TINY, Maps
from ...kernels.c.file import File, function
from ...kernels.c.numbers import representable
from ...kernels.c.writer import C
from ...numeric import Vector
from .observer import sum_of
from .printed import Printed
from .source_and_header import Cost, Use, prototype

ROUGH = {"double": (TINY, CLASH), "float": (1e-6, 1e-3)}  # in place of TINY and CLASH
NAMES = dict(M="A", B="A", G="Q", r="R")  # of maps, as a user knows them
CODES = (
    "0: done; 1: a number is not finite; 2: a reading contradicts what is known",
    "exactly.  After 1 and 2 state and what are as they were.",
)


class Functions:
    """The functions of a filter, in the numbers of a device."""

    sizes: dict[str, int]  # of the members of a state; 0: there is none
    printed: Printed  # the texts of `passes` that are called
    estimate: Callable[[], C]
    advance: Callable[[], C]
    variances: Callable[[], C]
    # of an estimate and an advance, apart from what both test of the state
    operations: Callable[[Sequence[str]], Sequence[int]]
    unit: str  # entry i of V where sigma0 is given
    also: Sequence[str] = ()  # at the start

    def __init__(self, settings: Settings, file: File) -> None:
        self.settings, self.file, plant = settings, file, settings.plant
        self.plant, self.name, self.real = plant, file.name, file.real
        self.n, self.p = plant.n, plant.p
        self.tiny, self.clash = ROUGH[self.real]
        R = plant.at(0).covariances()[1]
        alone = settings.way == "nothing"
        # readings are combined, so that their noises are not correlated
        self.correlated = alone and bool((R - np.diag(R.diagonal())).any())
        # those of a sample with every output, and the state ahead of the first one
        self.maps = self.at(np.ones(self.p, dtype=bool))
        end = begin(settings, np.zeros(plant.m))
        z, V, D, E, e = (X.copy() for X in end.state)
        met = np.abs(z)
        if not plant.at_first:
            M, B, G, X, _, _, _, d = settings.at(0, end.seen)[0]
            wide = B.shape[1] + G.shape[1] + (len(e) if X.shape[1] else 0)
            room = np.zeros
            passes.predict.on()(
                M, B, G, X, d, room(self.n), z, V, D, E, e, room((self.n, wide)),
                room(wide), room(self.n), met, room((0, self.n)), room(wide),
            )  # fmt: skip
        first = dict(x=z, met=met, D=D, V=V)
        self.first = {k: representable("P0", X, self.real) for k, X in first.items()}
        early, moved = ("u" * bool(X.any()) for X in (plant.E, plant.B))
        self.uses = [
            Use("init", ("x0", "sigma0"), ["Before the first sample."]),
            Use("estimate", (*early, "y", "what"), CODES),
            Use("advance", (*moved,), CODES),
            Use("variances", ("variances",),
                ["How uncertain the state is, after an estimate or an advance."]),
        ]  # fmt: skip

    def at(self, seen: Vector) -> Maps:
        """The maps of a sample, by what arrives."""
        found = self.settings.at(1, seen)[0]._asdict()
        return Maps(
            **{
                k: representable(NAMES.get(k, k), X, self.real)
                for k, X in found.items()
            }
        )

    def functions(self) -> list[str]:
        """All of them, and the tables that they alone read."""
        return [
            *self.printed.texts,
            self.finite(),
            *(
                function(prototype(self.file, use), getattr(self, use.name)().lines)
                for use in self.uses
            ),
        ]

    def costs(self, functions: Sequence[str]) -> dict[str, Cost]:
        found, state = {}, sum(self.sizes.values())
        local = re.compile(
            rf"^ +(?:const )?{self.real} \w+(?:\[(\d+)\])?(?: =|;)", re.M
        )
        for k, (use, done) in enumerate(
            zip(("estimate", "advance"), self.operations(functions))
        ):
            room = sum(int(size or 1) for size in local.findall(functions[k - 3]))
            found[use] = Cost(None, done + state, room + state)
        return found

    def init(self) -> C:
        to = C(self.real)
        sizes = {k: size for k, size in self.sizes.items() if size}
        first = {k: self.first.get(k, np.zeros(size)) for k, size in sizes.items()}
        for k, X in first.items():
            if X.any():
                to.table(k, X)

        def fill(k: str, value: str) -> None:
            to.loop("i", 0, sizes[k])
            to.set(f"state->{k}[i]", value)
            to.end()

        for k, X in first.items():
            fill(k, f"{k}[i]" if X.any() else "0.0")
        to.check("x0 != NULL")
        to.loop("i", 0, self.n)
        to.set("state->x[i]", "x0[i]")
        if "met" in sizes:
            to.set("state->met[i]", "fabs(x0[i])")
        to.end()
        to.end()
        to.check("sigma0 != NULL")
        own, N = "sigma0[i] * sigma0[i]", sizes["D"]
        if "V" in sizes:
            fill("V", self.unit)
        fill("D", own if N == self.n else f"(i < {self.n}) ? ({own}) : 1.0")
        to.end()
        to.lines += self.also
        return to

    def finite(self) -> str:
        to = C(self.real)
        to.line("int wrong = 0;")
        for k, size in self.sizes.items():
            if size:
                to.loop("i", 0, size)
                to.line(f"wrong += (isfinite(state->{k}[i]) != 0) ? 0 : 1;")
                to.end()
        to.line("return wrong == 0;")
        head = f"static int {self.name}_finite(const {self.name}_state *state)"
        return "/* Whether all numbers of a state are finite. */\n" + function(
            head, to.lines
        )

    def begun(self, use: str) -> C:
        """The next state, which is this one; an estimate has what was given to it."""
        to, plant = C(self.real), self.plant
        X, array = (plant.E, "given") if use == "estimate" else (plant.B, "drive")
        if X.any():
            to.each("u", plant.m, "isfinite({}) != 0")
        if use == "estimate":
            to.each("y", self.p, "isinf({}) == 0")
        to.line(f"{self.name}_state next;")
        to.line("next = *state;")
        to.array(array, len(X))
        for i, row in enumerate(representable("B", X, self.real).tolist()):
            known = sum_of(row, "u")
            if use == "estimate":
                known = f"y[{i}]" if known == "0.0" else f"y[{i}] - ({known})"
            to.set(f"{array}[{i}]", known)
        if use == "estimate" and self.correlated:
            for k, Y in zip("CR", (plant.C, plant.at(0).covariances()[1])):
                self.file.tables[f"{self.name}_{k}"] = representable(k, Y, self.real)
                to.array(k, Y.size)
                to.loop("i", 0, Y.size)
                to.set(f"{k}[i]", f"{self.name}_{k}[i]")
                to.end()
            to.array("r", self.p)
            to.line(f"{self.printed.call('whiten', R='R', C='C', y='given', r='r')};")
        return to

    def ended(self, to: C, what: str = "") -> C:
        """The state is the next one if that is finite, and the estimate is `what`."""
        to.when(f"{self.name}_finite(&next) == 0", "return 1;")
        if what == "shown":
            to.each(what, self.n, "isfinite({}) != 0")
        to.line("*state = next;")
        if what:
            to.loop("i", 0, self.n)
            to.set("what[i]", f"{what}[i]")
            to.end()
        to.line("return 0;")
        return to
