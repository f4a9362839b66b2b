"""A filter of few states in C: a statement an entry, without what is zero."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence
from typing import Any

import numpy as np

from ...filtering import scalars
from ...kernels.c.file import File, function
from ...kernels.c.writer import C
from . import source_and_header
from .filter_functions import MET, Functions
from .filter_start import Start
from .observer import sum_of
from .printed import Printed
from .source_and_header import Cost, Members

SIGNS = re.compile(r" (?:[-+*/<>]|==|!=|[-+]=) ")
NUMBERS = re.compile(r"(?<![\w.])(?:\d+\.\d*(?:e[-+]?\d+)?|\d+e[-+]?\d+)")
MISSING = """\
    int missing = 0;
    for (int i = 0; i < $p; i++) {
        missing += (isnan(given[i]) != 0) ? 1 : 0;
    }
    if (missing != 0) {
        return ${name}_partial(state, given, what);
    }"""
PARTIAL = """\
    if (${name}_finite(&next) == 0) {
        return 1;
    }
    *state = next;
    for (int i = 0; i < $n; i++) {
        what[i] = next.x[i];
    }
    return 0;"""


class Few(Functions):
    """Statements.

    Where noises of readings are correlated, those of a sample with every output are
    combined as constants say; else what arrived is combined in loops.
    """

    def __init__(self, start: Start, file: File) -> None:
        super().__init__(start, file)
        maps, n = self.maps, self.n
        known = tuple((k, tuple(getattr(maps, k).ravel().tolist())) for k in "BGC")
        size = scalars.Sizes(n, self.p, maps.G.shape[1], known)
        self.row = scalars.Row(size, maps.r.tolist(), self.tiny)
        # whether a reading without noise contradicts is told by what it is made of
        self.exact = [j for j in range(self.p) if not maps.r[j] > 0]
        met = n if self.exact else 0
        self.sizes = {"x": n, "met": met, "D": n, "V": n * (n - 1) // 2}
        if start.correlated:
            every = dict(n=n, N=n, g=size.g, p=self.p, o=0, e=0, t=0, w=n + size.g)
            wanted = "clear", "over", "part", "whiten", "absorb", "read"
            self.printed = Printed(file.name, file.real, every, self.tiny, wanted)

    def members(self) -> Members:
        said = ["x^ of this sample, or of the next before it is used", MET,
                "D of its error covariance U D U'",
                "U above its diagonal of ones, column by column"]  # fmt: skip
        found = zip(self.sizes.items(), said, strict=True)
        return [(k, size, one) for (k, size), one in found if size]

    def place(self, name: str) -> str:
        """The member of the state that holds a number."""
        member, i, *k = name.split("_")
        if member == "V":
            return f"V[{int(i) * (int(i) - 1) // 2 + int(k[0])}]"
        return f"{'x' if member == 'z' else member}[{i}]"

    def functions(self) -> list[str]:
        V, n = self.start.state["V"], self.n
        below = np.array([V[j, i] for j in range(n) for i in range(j)])
        found = [self.init(below, "0.0")]
        if self.start.correlated:
            found += [*self.printed.texts, self.finite(), self.partial()]
        return [*found, self.estimate(), self.advance(), self.variances()]

    def partial(self) -> str:
        """An estimate where not all outputs arrived."""
        n, to = self.n, C(self.real)
        to.line(f"{self.name}_state next;")
        to.line("next = *state;")
        for k, size in dict(V=n * n, met=n, K=n, f=n, found=3).items():
            to.array(k, size)
        below = {f"V[{j * n + i}]": self.place(f"V_{j}_{i}")
                 for j in range(n) for i in range(j)}  # fmt: skip
        for i in range(n):
            to.set(f"met[{i}]", f"state->met[{i}]" if self.exact else "0.0")
        for k in range(n * n):
            other = "1.0" if k % (n + 1) == 0 else "0.0"
            place = below.get(f"V[{k}]")
            to.set(f"V[{k}]", f"state->{place}" if place else other)
        to.lines += self.read("next.x", "V", "next.D", "met", "K")
        for entry, place in below.items():
            to.set(f"next.{place}", entry)
        to.lines.append(self.text(PARTIAL))
        head = source_and_header.wrapped(
            f"static int {self.name}_partial({self.name}_state *state, "
            f"{self.real} given[], {self.real} what[])"
        )
        said = (
            "/* An estimate where not all outputs arrived: what did is combined. */\n"
        )
        return said + function(head, to.lines)

    def own(self) -> list[str]:
        """Names of the numbers that make up a state."""
        return [name for name, _ in scalars.names(*self.row.fresh())]

    def store(self, to: C, found: Mapping[str, str]) -> None:
        """The next state, if it is finite."""
        to.line("int wrong = 0;")
        for text in found.values():
            to.line(f"wrong += (isfinite({text}) != 0) ? 0 : 1;")
        to.need("wrong == 0")
        for name, text in found.items():
            to.set(f"state->{self.place(name)}", text)

    def statements(
        self, to: C, found: Sequence[tuple[str, Any]], prefix: str
    ) -> dict[str, str]:
        """Statements, and what then is what."""
        lines, shown = scalars.written([x for _, x in found], scalars.C99, prefix)
        for name, text in lines:
            to.constant(name, text)
        return {name: shown(x) for name, x in found}

    def estimate(self) -> str:
        to, whole = C(self.real), self.start.correlated
        to.lines += self.readings()
        if whole:
            to.lines += [*self.given(), self.text(MISSING)]
        for name in self.own():
            to.let(name, f"state->{self.place(name)}")
        for i in range(self.sizes["met"]):
            to.constant(f"met_{i}", f"state->met[{i}]")
        for j in range(self.p):
            if not whole:
                to.check(f"isnan(y[{j}]) == 0")
            mixed = sum_of(self.start.mix[j], "given") if whole else self.reading(j)
            to.constant(f"y_{j}", mixed)
            z, V, D, _, _, *tested = self.row.read(j)
            found = [one for one in scalars.names(z, V, D) if scalars.renamed(*one)]
            names = [name for name, _ in found]
            if j in self.exact:
                found += zip(("pivot", "nu", "made"), tested, strict=True)
            is_ = self.statements(to, found, f"r{j}_")
            if j in self.exact:
                clash = f"fabs({is_['nu']}) > {self.clash!r} * ({is_['made']})"
                to.when(f"({is_['pivot']} == 0.0) && ({clash})", "return 2;")
            for name in names:
                to.set(name, is_[name])
            if not whole:
                to.end()
        self.store(to, {name: name for name in self.own()})
        for i in range(self.n):
            to.set(f"what[{i}]", f"z_{i}")
        used = set(re.findall(r"\bmet_\d+\b(?! =)", "\n".join(to.lines)))
        unused = {f"met_{i}" for i in range(self.n)} - used
        to.lines = [x for x in to.lines if not unused & {*x.split()}]
        return self.written("estimate", *to.lines, "    return 0;")

    def advance(self) -> str:
        to = C(self.real)
        if self.plant.B.any():
            to.lines.append(self.wrong("u", self.plant.m, "isfinite({}) != 0"))
        for name in self.own():
            to.constant(name, f"state->{self.place(name)}")
        for i in range(self.sizes["met"]):
            to.constant(f"met_{i}", f"state->met[{i}]")
        for i in range(self.n):
            to.constant(f"drive_{i}", self.known(self.plant.B, i))
        z, V, D, met = self.row.predict()
        found = scalars.names(z, V, D)
        found += [(f"met_{i}", met[i]) for i in range(self.sizes["met"])]
        self.store(to, self.statements(to, found, "t"))
        return self.written("advance", *to.lines, "    return 0;")

    def variances(self) -> str:
        to = C(self.real)
        for name in self.own()[self.n :]:
            to.constant(name, f"state->{self.place(name)}")
        spread = [(f"variances[{i}]", v) for i, v in enumerate(self.row.spread())]
        for name, text in self.statements(to, spread, "t").items():
            to.set(name, text)
        return self.written("variances", *to.lines)

    def costs(self, functions: Sequence[str]) -> tuple[int, dict[str, Cost]]:
        found, constants = {}, set[str]()
        for use, text in zip(("estimate", "advance"), functions[-3:]):
            numbers = set(NUMBERS.findall(text))
            constants |= {x for x in numbers if float(x) not in (0.0, 1.0)}
            names = re.findall(rf"^ +(?:const )?{self.real} \w+ =", text, re.M)
            found[use] = Cost(None, len(SIGNS.findall(text)), len(names))
        tables = sum(X.size for X in self.file.tables.values())
        return len(constants) + tables, found
