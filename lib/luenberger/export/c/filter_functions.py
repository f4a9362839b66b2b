"""What both ways of writing a filter in C share."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from string import Template
from typing import Any

import numpy as np

from ...filtering.passes import CLASH, TINY
from ...kernels.c.file import File, function
from ...kernels.c.writer import C, listed, typed
from ...numeric import Matrix
from . import source_and_header
from .filter_start import Start
from .observer import sum_of
from .printed import Printed
from .source_and_header import Cost, Members, Use

ROUGH = {"double": (TINY, CLASH), "float": (1e-6, 1e-3)}  # in place of TINY and CLASH
CODES = (
    "0: done; 1: a number is not finite; 2: a reading contradicts what is known",
    "exactly.  After 1 and 2 state and what are as they were.",
)
BEGIN = ("Before the first sample.",)
SPREAD = ("How uncertain the state is, after an estimate or an advance.",)
MET = "what the prediction is a sum of, in size"

FINITE = """\
    for (int i = 0; i < $size; i++) {
        wrong += (isfinite(state->$member[i]) != 0) ? 0 : 1;
    }"""
SET = """\
    for (int i = 0; i < $size; i++) {
        state->$member[i] = $value;
    }"""
STARTED = """\
    if (x0 != NULL) {
        for (int i = 0; i < $n; i++) {
            state->$z[i] = x0[i];$met
        }
    }
    if (sigma0 != NULL) {$unit
        for (int i = 0; i < $N; i++) {
            state->D[i] = $own;
        }
    }$more"""
READ = """\
    for (int j = 0; j < $p; j++) {
        if (isnan(given[j]) == 0) {
            $call;
            if ((found[0] == 0.0) && (fabs(found[1]) > $clash * found[2])) {
                return 2;
            }$more
        }
    }"""
WHITEN = """\
    $real C[$size];
    $real R[$square];
    $real r[$p];
    for (int i = 0; i < $size; i++) {
        C[i] = ${name}_C[i];
    }
    for (int i = 0; i < $square; i++) {
        R[i] = ${name}_R[i];
    }
    $call;"""


class Functions:
    """The functions of a filter.

    Attributes
    ----------
    uses : list of Use
    sizes : dict of str to int
        Members of the state, and their lengths; the estimate is the first.
    """

    sizes: dict[str, int]
    printed: Printed

    def __init__(self, start: Start, file: File) -> None:
        self.start, self.plant, self.file = start, start.plant, file
        self.maps, self.name, self.real = start.maps, file.name, file.real
        self.n, self.p = self.plant.n, self.plant.p
        self.tiny, self.clash = ROUGH[self.real]
        early, moved = (
            ("const u",) * bool(X.any()) for X in (self.plant.E, self.plant.B)
        )
        self.uses = [
            Use("init", ("const x0", "const sigma0"), BEGIN, "void"),
            Use("estimate", (*early, "const y", "what"), CODES),
            Use("advance", moved, CODES),
            Use("variances", ("variances",), SPREAD, "void"),
        ]

    def functions(self) -> list[str]:
        """Tables and functions; the last three are estimate, advance, variances."""
        raise NotImplementedError

    def members(self) -> Members:
        """Of the state, with what they mean."""
        raise NotImplementedError

    def costs(self, functions: Sequence[str]) -> tuple[int, dict[str, Cost]]:
        """Numbers that are constant, and what functions cost."""
        raise NotImplementedError

    def notes(self, functions: Sequence[str]) -> list[str]:
        """Lines of the header."""
        state = sum(size for _, size, _ in self.members())
        return source_and_header.cost_notes(self.file, state, *self.costs(functions))

    def text(self, template: str, **words: Any) -> str:
        """Lines of C."""
        known = dict(n=self.n, p=self.p, name=self.name, real=self.real)
        known |= dict(clash=repr(self.clash))
        return typed(Template(template).substitute(known, **words), self.real)

    def written(self, use: str, *lines: str) -> str:
        """A function of the header."""
        head = next(one for one in self.uses if one.name == use)
        return function(source_and_header.prototype(self.file, head), [*lines])

    def wrong(self, array: str, size: int, test: str) -> str:
        """Refuse a number of an array."""
        to = C(self.real)
        to.loop("i", 0, size)
        to.need(f"{test.format(f'{array}[i]')}")
        to.end()
        return "\n".join(to.lines)

    def readings(self) -> list[str]:
        """Refuse what is infinite."""
        inputs = self.wrong("u", self.plant.m, "isfinite({}) != 0")
        return [inputs] * bool(self.plant.E.any()) + [
            self.wrong("y", self.p, "isinf({}) == 0")
        ]

    def reading(self, j: int) -> str:
        """y less E u."""
        known = self.known(self.plant.E, j)
        return f"y[{j}]" if known == "0.0" else f"y[{j}] - ({known})"

    def known(self, X: Matrix, i: int) -> str:
        """What a row of a matrix makes of the inputs."""
        return sum_of(self.start.narrow("B", X)[i].tolist(), "u")

    def given(self) -> list[str]:
        """Readings less E u, in an array."""
        lines = [f"    {self.real} given[{self.p}];"]
        lines += [f"    given[{j}] = {self.reading(j)};" for j in range(self.p)]
        return [typed(line, self.real) for line in lines]

    def read(
        self, z: str, V: str, D: str, met: str, K: str, more: str = ""
    ) -> list[str]:
        """Take in the readings that arrived, in the order of outputs."""
        N, lines = len(self.start.state["z"]), []
        C_, r = f"{self.name}_C", f"{self.name}_r[j]"
        if self.start.correlated:
            C_, r = "C", "r[j]"
            for k, X in dict(C=self.plant.C, R=self.plant.R).items():
                self.file.tables[f"{self.name}_{k}"] = self.start.narrow(k, X)
            call = self.printed.call("whiten", R="R", C="C", y="given", r="r")
            sizes = dict(size=self.p * N, square=self.p**2)
            lines.append(self.text(WHITEN, call=call, **sizes))
        call = self.printed.call(
            "read", y="given[j]", V=V, D=D, c=f"&{C_}[j * {N}]", r=r, z=z, met=met, K=K,
            f="f", found="found",
        )  # fmt: skip
        return [*lines, self.text(READ, call=call, more=more)]

    def finite(self) -> str:
        """Whether all numbers of a state are."""
        found = [
            self.text(FINITE, size=size, member=k)
            for k, size in self.sizes.items()
            if size
        ]
        head = f"static int {self.name}_finite(const {self.name}_state *state)"
        lines = ["    int wrong = 0;", *found, "    return wrong == 0;"]
        return "/* Whether all numbers of a state are finite. */\n" + function(
            head, lines
        )

    def init(self, V: Matrix, unit: str, more: str = "") -> str:
        """The start; V is that of the plant's data, `unit` of what is independent."""
        z, *_ = self.sizes
        tables = {**self.start.state, z: self.start.state["z"], "V": V}
        lines = []
        for member, size in self.sizes.items():
            X = tables.get(member, np.zeros(size))
            if size:
                some = bool(np.any(X))
                if some:
                    table = f"    static const {self.real} {member}[{size}] = "
                    lines.append(typed(f"{table}{listed(X)};", self.real))
                value = f"{member}[i]" if some else "0.0"
                lines.append(self.text(SET, size=size, member=member, value=value))
        lines = [x for x in lines if "static" in x] + [
            x for x in lines if "static" not in x
        ]
        N = self.sizes["D"]
        own = "sigma0[i] * sigma0[i]"
        set_V = self.text(SET, size=self.sizes["V"], member="V", value=unit)
        words: Mapping[str, Any] = dict(
            z=z,
            N=N,
            own=own
            if self.n == N
            else f"(i < {self.n}) ? (sigma0[i] * sigma0[i]) : 1.0",
            met="\n            state->met[i] = fabs(x0[i]);" * bool(self.sizes["met"]),
            unit="\n" + set_V.replace("    ", "        ", 1).replace("\n", "\n    ")
            if self.sizes["V"]
            else "",
            more=f"\n    {more}" if more else "",
        )
        return self.written("init", *lines, self.text(STARTED, **words))
