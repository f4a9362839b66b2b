"""A filter in C as the loops of `filtering.passes`, at the sizes of a plant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...filtering import passes
from ...kernels.c.file import File
from ...kernels.c.writer import listed
from .filter_functions import MET, Functions
from .filter_start import MOVING, Start
from .printed import ORDER, Printed
from .source_and_header import Cost, Members, wrapped

ROOM = """\
    ${name}_state next;
    $real f[$N];
    $real found[3];
    $real shown[$n];
    next = *state;"""
PUSHED = """\
    $real spare[$n];
    int seen = 0;
    for (int j = 0; j < $p; j++) {
        next.e[j] = 0.0;
    }"""
TOLD = """
            next.e[j] = ${name}_over(1.0, found[0]);
            seen += ${name}_bit[j];"""
ESTIMATED = """\
    if (${name}_finite(&next) == 0) {
        return 1;
    }
    for (int i = 0; i < $n; i++) {
        shown[i] = next.z[i];$spare
    }$push
    for (int i = 0; i < $n; i++) {
        if (isfinite(shown[i]) == 0) {
            return 1;
        }
    }
    for (int i = 0; i < $n; i++) {
        what[i] = shown[i];
    }
    *state = next;
    return 0;"""
ADVANCED = """\
    $call;$forget
    if (${name}_finite(&next) == 0) {
        return 1;
    }
    *state = next;
    return 0;"""
FORGET = """
    for (int j = 0; j < $p; j++) {
        next.e[j] = 0.0;
    }
    next.seen[0] = $none;"""


class Loops(Functions):
    """Loops; of noisy outputs that are treated as exact also what the sample told."""

    def __init__(self, start: Start, file: File) -> None:
        super().__init__(start, file)
        (n, N), g = self.maps.B.shape, self.maps.G.shape[1]
        self.pushed = self.maps.O.shape[1]
        t = self.p if self.pushed else 0
        sizes = dict(n=n, N=N, g=g, p=self.p, o=self.pushed, e=N - n, t=t, w=N + g + t)
        self.N, self.wide = N, N + g + t
        left_out = {"push": not self.pushed, "whiten": not start.correlated}
        wanted = [k for k in ORDER if not left_out.get(k)]
        self.printed = Printed(self.name, self.real, sizes, self.tiny, wanted)
        self.bits, self.at, self.found = [0], [0], [self.maps]
        if self.pushed:
            self.bits, self.at, self.found = start.patterns()
        self.alike = all(np.array_equal(one.M, one.B) for one in self.found)
        self.sizes = {"z": N, "met": n, "D": N, "V": N * N, "E": t * N, "e": t}
        whitened = "Cr" if start.correlated else ""
        for k in self.maps._fields:
            X = getattr(self.maps, k)
            if k in MOVING:
                X = np.array([getattr(one, k) for one in self.found])
            if X.size and k not in whitened and not (k == "B" and self.alike):
                file.tables[f"{self.name}_{k}"] = X

    def members(self) -> Members:
        more = ", and noises that its outputs share" if self.N > self.n else ""
        said = [f"x^ of this sample, or of the next before it is used{more}", MET,
                "D of its error covariance U D U'", "U', row by row",
                "columns of gains of the sample", "their weights"]  # fmt: skip
        found = zip(self.sizes.items(), said, strict=True)
        members = [(k, size, x) for (k, size), x in found if size]
        return members + [("int seen", 1, "which outputs arrived")] * bool(self.pushed)

    def functions(self) -> list[str]:
        tables, more = [], ""
        if self.pushed:
            more = f"state->seen[0] = {self.at[0]};"
            for k, values in dict(at=self.at, bit=self.bits).items():
                listed = ", ".join(map(str, values))
                size = len(values)
                tables.append(
                    f"static const int {self.name}_{k}[{size}] = {{{listed}}};\n"
                )
        unit = f"((i % {self.N + 1}) == 0) ? 1.0 : 0.0"
        init = self.init(self.start.state["V"].ravel(), unit, more)
        return [*tables, *self.printed.texts, self.finite(), init, self.estimate(),
                self.advance(), self.variances()]  # fmt: skip

    def matrix(self, k: str, state: str) -> str:
        """The table of a map: that of what arrived, where there are several."""
        table = f"{self.name}_{'M' if k == 'B' and self.alike else k}"
        if k in MOVING and len(self.found) > 1:
            return f"&{table}[{state}seen[0] * {getattr(self.maps, k).size}]"
        return table

    def estimate(self) -> str:
        lines = [*self.readings(), *self.given(), self.text(ROOM, N=self.N)]
        K, more, words = "K", "", dict(spare="", push="")
        if self.pushed:
            lines.append(self.text(PUSHED))
            K, more = f"&next.E[j * {self.N}]", self.text(TOLD)
            push = wrapped(self.push("next.", "shown", "spare") + ";")
            words["spare"] = "\n        spare[i] = 0.0;"
            words["push"] = f"\n    {push}".replace("\n    ", "\n    ")
        else:
            lines.append(f"    {self.real} K[{self.N}];")
        lines += self.read("next.z", "next.V", "next.D", "next.met", K, more)
        if self.pushed:
            lines.append(f"    next.seen[0] = {self.name}_at[seen];")
        return self.written("estimate", *lines, self.text(ESTIMATED, **words))

    def push(self, of: str, x: str, variances: str) -> str:
        given = dict(O=self.matrix("O", of), z=f"{of}z", E=f"{of}E", e=f"{of}e")
        return self.printed.call("push", **given, x=x, variances=variances)

    def advance(self) -> str:
        lines, n = [], self.n
        if self.plant.B.any():
            lines.append(self.wrong("u", self.plant.m, "isfinite({}) != 0"))
        lines += [f"    {self.name}_state next;", "    next = *state;"]
        room = dict(drive=n, W=n * self.wide, w=self.wide, h=self.wide, made=n)
        lines += [f"    {self.real} {k}[{size}];" for k, size in room.items()]
        drive = [f"    drive[{i}] = {self.known(self.plant.B, i)};" for i in range(n)]
        lines += [self.text(line) for line in drive]
        call = self.printed.call(
            "predict", **{k: self.matrix(k, "next.") for k in "MBGX"},
            d=f"{self.name}_d", drive="drive", z="next.z", V="next.V", D="next.D",
            E="next.E", e="next.e", W="W", w="w", made="made", met="next.met", h="h",
        )  # fmt: skip
        forget = self.text(FORGET, none=self.at[0]) if self.pushed else ""
        lines.append(self.text(ADVANCED, call=wrapped(call), forget=forget))
        return self.written("advance", *lines)

    def variances(self) -> str:
        given = dict(V="state->V", D="state->D", variances="variances")
        lines = [f"    {self.printed.call('spread', **given)};"]
        if self.pushed:
            spare = f"    {self.real} spare[{self.n}] = {listed(np.zeros(self.n))};"
            lines = [self.text(spare), *lines]
            lines.append(f"    {wrapped(self.push('state->', 'spare', 'variances'))};")
        return self.written("variances", *lines)

    def costs(self, functions: Sequence[str]) -> tuple[int, dict[str, Cost]]:
        maps, n, N, wide, p = self.maps, self.n, self.N, self.wide, self.p
        state, m = sum(self.sizes.values()), self.plant.m
        room = lambda *shape: counted(np.zeros(shape))  # noqa: E731
        V = np.tril(np.full((N, N), 0.5), -1) + np.eye(N)
        z, V, D, E, e = map(counted, (np.ones(N), V, np.ones(N), np.ones((p, N)),
                                      np.ones(p)))  # fmt: skip
        given = (counted(X) for X in (maps.M, maps.B, maps.G, maps.X, maps.d))
        Counted.done = 0
        passes.predict.on()(
            *given, room(n), z, V, D, E, e, room(n, wide), room(wide), room(n),
            room(n), room(0, n), room(wide),
        )  # fmt: skip
        ahead, Counted.done = Counted.done, 0
        if self.start.correlated:
            passes.whiten.on()(counted(self.plant.R), counted(maps.C), room(p), room(p))
        for c, r in zip(maps.C, maps.r):
            passes.read.on()(
                Counted(9.0), V, D, counted(c), Counted(r), z, room(n), room(N), room(N)
            )
        if self.pushed:
            passes.push.on()(counted(maps.O), z, E, e, room(n), room(n))
        known = [2 * int((X != 0).sum()) for X in (self.plant.E, self.plant.B)]
        behind = Counted.done + state + p + n + known[0]
        constants = sum(X.size for X in self.file.tables.values())
        return constants, {
            "estimate": Cost(None, behind, state + 2 * N + p + n + 3),
            "advance": Cost(None, ahead + state + m + known[1],
                            state + n * wide + 2 * wide + 2 * n),
        }  # fmt: skip


class Counted(float):
    """A number that counts what is done with it."""

    done = 0

    def __abs__(self) -> Counted:
        return Counted(float.__abs__(self))


def _counting(name: str) -> Any:
    plain = getattr(float, name)

    def made(*given: float) -> Any:
        Counted.done += 1
        found = plain(*given)
        return Counted(found) if type(found) is float else found

    return made


for _name in "add radd sub rsub mul rmul truediv rtruediv gt lt eq".split():
    setattr(Counted, f"__{_name}__", _counting(f"__{_name}__"))


def counted(X: Any) -> np.ndarray:
    """The same numbers, which count."""
    made = np.empty(np.shape(X), dtype=object)
    for at, x in np.ndenumerate(np.asarray(X)):
        made[at] = Counted(x)
    return made
