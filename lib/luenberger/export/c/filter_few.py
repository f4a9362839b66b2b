"""A filter of few states in C: a statement an entry, without what is zero."""

from __future__ import annotations

import re
from collections.abc import Iterable, Sequence
from typing import Any

import numpy as np

from ...filtering import scalars
from ...filtering.maps import Settings
from ...kernels.c.file import File
from ...kernels.c.writer import C
from .filter_functions import Functions
from .printed import Printed

SIGNS = re.compile(r" (?:[-+*/<>]|==|!=|[-+]=) ")


class Few(Functions):
    """Statements; of correlated readings C and r are combined as what arrived says."""

    unit = "0.0"  # V has what is above the diagonal of U

    def __init__(self, settings: Settings, file: File) -> None:
        super().__init__(settings, file)
        maps, n, p = self.maps, self.n, self.p
        known = {k: getattr(maps, k).ravel().tolist() for k in "BGC"}
        r = maps.r.tolist()
        # whether a reading without noise contradicts is told by what it is made of
        self.exact = [j for j in range(p) if not r[j] > 0]
        if self.correlated:
            known["C"], r = [None] * (p * n), None
            self.exact = [*range(p)] if self.exact else []
        entries = tuple((k, tuple(x)) for k, x in known.items())
        size = scalars.Sizes(n, p, maps.G.shape[1], entries, not self.exact)
        self.row = scalars.Row(size, r, self.tiny)
        below = [self.first["V"][j, i] for j in range(n) for i in range(j)]
        self.first["V"] = np.array(below)
        self.sizes = dict(x=n, met=n if self.exact else 0, D=n, V=len(below))
        wanted = ("over", "whiten") if self.correlated else ()
        self.printed = Printed(file.name, file.real, dict(p=p, N=n), self.tiny, wanted)
        self.places = {f"z_{i}": f"x[{i}]" for i in range(n)}
        self.places |= {f"D_{i}": f"D[{i}]" for i in range(n)}
        pairs = [f"V_{j}_{i}" for j in range(n) for i in range(j)]
        self.places |= {name: f"V[{k}]" for k, name in enumerate(pairs)}
        self.places |= {f"met_{i}": f"met[{i}]" for i in range(self.sizes["met"])}

    def statements(
        self, to: C, found: Iterable[tuple[str, Any]], prefix: str
    ) -> dict[str, str]:
        """Statements, and what then is what."""
        found = [*found]
        lines, shown = scalars.written([x for _, x in found], scalars.C99, prefix)
        for name, text in lines:
            to.constant(name, text)
        return {name: shown(x) for name, x in found}

    def estimate(self) -> C:
        to = self.begun("estimate")
        for name, place in self.places.items():
            to.let(name, f"state->{place}")
        for j in range(self.p):
            to.check(f"isnan(given[{j}]) == 0")
            to.constant(f"y_{j}", f"given[{j}]")
            if self.correlated:
                to.constant(f"r_{j}", f"r[{j}]")
                for i in range(self.n):
                    to.constant(f"C_{j}_{i}", f"C[{j * self.n + i}]")
            z, V, D, met, _, *tested = self.row.read(j)
            moved = scalars.names(z, V, D, met if self.exact else ())
            found = [one for one in moved if scalars.renamed(*one)]
            names = [name for name, _ in found]
            if j in self.exact:
                found += zip(("pivot", "nu", "made"), tested, strict=True)
            is_ = self.statements(to, found, f"r{j}_")
            if j in self.exact:
                clash = f"fabs({is_['nu']}) > {self.clash!r} * ({is_['made']})"
                to.when(f"({is_['pivot']} == 0.0) && ({clash})", "return 2;")
            for name in names:
                to.set(name, is_[name])
            to.end()
        for name, place in self.places.items():
            to.set(f"next.{place}", name)
        return self.ended(to, "next.x")

    def advance(self) -> C:
        to = self.begun("advance")
        for name, place in self.places.items():
            to.constant(name, f"state->{place}")
        for i in range(self.n):
            to.constant(f"drive_{i}", f"drive[{i}]")
        z, V, D, met = self.row.predict()
        found = scalars.names(z, V, D, met if self.exact else ())
        for name, text in self.statements(to, found, "t").items():
            to.set(f"next.{self.places[name]}", text)
        return self.ended(to)

    def variances(self) -> C:
        to = C(self.real)
        for name, place in self.places.items():
            if name[0] in "DV":
                to.constant(name, f"state->{place}")
        spread = ((f"variances[{i}]", v) for i, v in enumerate(self.row.spread()))
        for name, text in self.statements(to, spread, "t").items():
            to.set(name, text)
        return to

    def operations(self, functions: Sequence[str]) -> list[int]:
        return [len(SIGNS.findall(text)) for text in functions[-3:-1]]
