"""A filter in C as the loops of `filtering.passes`, at the sizes of a plant."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

import numpy as np

from ...errors import DesignError
from ...filtering import passes
from ...filtering.maps import Settings
from ...filtering.passes import Maps
from ...kernels.c.file import File
from ...kernels.c.writer import C, listed
from .filter_functions import Functions
from .printed import ORDER, Printed
from .source_and_header import wrapped

MOST = 6  # outputs of which each choice has matrices of its own
MOVING = ("M", "B", "X", "O")  # maps that hang on which outputs arrived


class Loops(Functions):
    """Loops; of noisy outputs that are treated as exact also what the sample told."""

    def __init__(self, settings: Settings, file: File) -> None:
        super().__init__(settings, file)
        (n, N), g, p = self.maps.B.shape, self.maps.G.shape[1], self.p
        self.pushed = self.maps.O.shape[1]
        t = p if self.pushed else 0
        self.N, self.wide = N, N + g + t
        sizes = dict(n=n, N=N, g=g, p=p, o=self.pushed, e=N - n, t=t, w=self.wide)
        left_out = {"push": not self.pushed, "whiten": not self.correlated}
        wanted = [k for k in ORDER if not left_out.get(k)]
        self.printed = Printed(self.name, self.real, sizes, self.tiny, wanted)
        self.sizes = dict(x=N, met=N, D=N, V=N * N, E=t * N, e=t)
        self.unit = f"((i % {N + 1}) == 0) ? 1.0 : 0.0"
        # for each output its bit, for each sum of bits which maps, and the maps
        self.bits, self.at_, self.found = [0] * p, [0], [self.maps]
        if self.pushed:
            self._patterns()
            self.also = [f"    state->seen[0] = {self.at_[0]};"]
        self.alike = all(np.array_equal(one.M, one.B) for one in self.found)
        whitened = "Cr" if self.correlated else ""
        for k in Maps._fields:
            X = getattr(self.maps, k)
            if k in MOVING:
                X = np.array([getattr(one, k) for one in self.found])
            if X.size and k not in whitened and not (k == "B" and self.alike):
                file.tables[f"{self.name}_{k}"] = X

    def _patterns(self) -> None:
        """Which maps belong to which outputs.

        Where no noise is shared with the next state, only outputs that are treated as
        exact have a bit: whether others arrive changes no matrix.
        """
        S, settings, found = self.plant.S, self.settings, dict[bytes, int]()
        told = isinstance(settings.weight, str) or (S is not None and np.any(S))
        which = range(self.p) if told else sorted(settings.accurate)
        if len(which) > MOST:
            raise DesignError(
                "noisy outputs are treated as exact, and the matrices of a sample hang "
                f"on which of {len(which)} outputs arrive: too many choices for a "
                "device. Leave out m1, or treat outputs without noise as exact."
            )
        for k, j in enumerate(which):
            self.bits[j] = 2**k
        self.at_, self.found = [], []
        for code in range(2 ** len(which)):
            maps = self.at(np.array([not bit or bool(bit & code) for bit in self.bits]))
            key = b"".join(getattr(maps, k).tobytes() for k in MOVING)
            if key not in found:
                found[key] = len(found)
                self.found.append(maps)
            self.at_.append(found[key])

    def functions(self) -> list[str]:
        tables = dict(at=self.at_, bit=self.bits) if self.pushed else {}
        return [
            *(
                f"static const int {self.name}_{k}[{len(values)}] = "
                f"{{{', '.join(map(str, values))}}};\n"
                for k, values in tables.items()
            ),
            *super().functions(),
        ]

    def matrix(self, k: str, state: str) -> str:
        """The table of a map: that of what arrived, where there are several."""
        table = f"{self.name}_{'M' if k == 'B' and self.alike else k}"
        if k in MOVING and len(self.found) > 1:
            return f"&{table}[{state}seen[0] * {getattr(self.maps, k).size}]"
        return table

    def estimate(self) -> C:
        to, n, N, name = self.begun("estimate"), self.n, self.N, self.name
        for k, size in dict(f=N, found=3).items():
            to.array(k, size)
        if self.pushed:
            to.array("shown", n)
            to.array("spare", n)
            to.line("int seen = 0;")
        else:
            to.array("K", N)
        C_, r = ("C", "r") if self.correlated else (f"{name}_C", f"{name}_r")
        call = self.printed.call(
            "read", y="given[j]", V="next.V", D="next.D", c=f"&{C_}[j * {N}]",
            r=f"{r}[j]", z="next.x", met="next.met", f="f", found="found",
            K=f"&next.E[j * {N}]" if self.pushed else "K",
        )  # fmt: skip
        to.loop("j", 0, self.p)
        if self.pushed:
            to.set("next.e[j]", "0.0")
        to.check("isnan(given[j]) == 0")
        to.line(f"{call};")
        clash = f"fabs(found[1]) > {self.clash!r} * found[2]"
        to.when(f"(found[0] == 0.0) && ({clash})", "return 2;")
        if self.pushed:
            to.set("next.e[j]", f"{name}_over(1.0, found[0])")
            to.line(f"seen += {name}_bit[j];")
        to.end()
        to.end()
        if not self.pushed:
            return self.ended(to, "next.x")
        to.line(f"next.seen[0] = {name}_at[seen];")
        to.loop("i", 0, n)
        to.set("shown[i]", "next.x[i]")
        to.set("spare[i]", "0.0")
        to.end()
        to.line(f"{self.push('next.', 'shown', 'spare')};")
        return self.ended(to, "shown")

    def push(self, of: str, x: str, variances: str) -> str:
        given = dict(O=self.matrix("O", of), z=f"{of}x", E=f"{of}E", e=f"{of}e")
        return wrapped(self.printed.call("push", **given, x=x, variances=variances))

    def advance(self) -> C:
        to, n, wide = self.begun("advance"), self.n, self.wide
        for k, size in dict(W=n * wide, w=wide, h=wide, made=n).items():
            to.array(k, size)
        call = self.printed.call(
            "predict", **{k: self.matrix(k, "next.") for k in "MBGX"},
            d=f"{self.name}_d", drive="drive", z="next.x", V="next.V", D="next.D",
            E="next.E", e="next.e", W="W", w="w", made="made", met="next.met", h="h",
        )  # fmt: skip
        to.line(f"{wrapped(call)};")
        if self.pushed:
            to.loop("j", 0, self.p)
            to.set("next.e[j]", "0.0")
            to.end()
            to.line(f"next.seen[0] = {self.at_[0]};")
        return self.ended(to)

    def variances(self) -> C:
        to, given = C(self.real), dict(V="state->V", D="state->D")
        if self.pushed:
            to.array("spare", self.n, f" = {listed(np.zeros(self.n))}")
        to.line(f"{self.printed.call('spread', **given, variances='variances')};")
        if self.pushed:
            to.line(f"{self.push('state->', 'spare', 'variances')};")
        return to

    def operations(self, functions: Sequence[str]) -> tuple[int, int]:
        n, N, wide, p, m = self.n, self.N, self.wide, self.p, self.plant.m
        room = lambda *shape: counted(np.zeros(shape))  # noqa: E731
        z, D, E, e = (counted(np.ones(size)) for size in (N, N, (p, N), p))
        V = counted(np.tril(np.full((N, N), 0.5), -1) + np.eye(N))
        maps = Maps(*map(counted, self.maps))
        Counted.done = 0
        passes.predict.on()(
            maps.M, maps.B, maps.G, maps.X, maps.d, room(n), z, V, D, E, e,
            room(n, wide), room(wide), room(n), room(N), room(0, n), room(wide),
        )  # fmt: skip
        ahead, Counted.done = Counted.done, 0
        if self.correlated:
            passes.whiten.on()(counted(self.plant.R), maps.C, room(p), room(p))
        for c, r in zip(maps.C, maps.r):
            passes.read.on()(Counted(9), V, D, c, r, z, room(N), room(N), room(N))
        if self.pushed:
            passes.push.on()(maps.O, z, E, e, room(n), room(n))
        of_E, of_B = (2 * int((X != 0).sum()) for X in (self.plant.E, self.plant.B))
        return Counted.done + p + n + of_E, ahead + m + of_B


class Counted(float):
    """A number that counts what is done with it."""

    done = 0

    def __abs__(self) -> Counted:
        return Counted(float.__abs__(self))


def _counting(name: str) -> Any:
    def made(*given: float) -> Any:
        Counted.done += 1
        found = getattr(float, name)(*given)
        return Counted(found) if type(found) is float else found

    return made


for _name in "add radd sub rsub mul rmul truediv rtruediv gt lt eq".split():
    setattr(Counted, f"__{_name}__", _counting(f"__{_name}__"))
counted = np.vectorize(Counted, otypes=[object])
