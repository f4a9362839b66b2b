"""The C of a filter that waits for readings: what a sample and a reading do.

What the device keeps is one vector `xi` with its covariance P: the state, the p
readings of this sample, and a ring with those of late outputs of earlier samples.
"""

from collections.abc import Sequence

from ...kernels import lowered
from ...kernels.c import C, Module, function
from ...kernels.c.numbers import representable
from ...kernels.program import Cost, Program
from ...kernels.writer import entry
from ...numeric import Matrices
from ...papers.leondes_novak.derivation import (
    late_ahead,
    late_corrected,
    late_fresh,
    late_known,
)
from ...recursion.settings import Settings


class Kernels:
    """What is written from stage lists; `costs` grow with it."""

    def __init__(
        self, settings: Settings, late: Sequence[int], horizon: int, module: Module
    ) -> None:
        self.settings, self.plant, self.module = settings, settings.plant, module
        self.late, self.horizon = list(late), horizon
        plant, now = self.plant, settings.at(0)
        self.n, self.p, self.m = plant.n, plant.p, plant.m
        self.q = horizon * len(self.late)
        self.N = self.n + self.p + self.q
        self.cross = bool(now.J.any())
        given = dict(A=now.A, As=now.As, B=now.B, J=now.J, C=now.C, E=now.E, R=now.R)
        given |= dict(Qs=now.Qs)
        self.constants = {k: representable(k, X, module.real) for k, X in given.items()}
        self.zero = [k for k, X in self.constants.items() if not X.any()]
        self.costs: dict[str, Cost] = {}

    def members(self) -> list[tuple[str, int, str]]:
        """Of the state's struct."""
        n, N = self.n, self.N
        return [
            ("xi", N, f"the estimate in [0] to [{n - 1}], then what is expected"),
            (
                "P",
                N * N,
                f"its covariance, {N} to a row; that of the estimate is first",
            ),
            ("u", self.m, "inputs of the last sample"),
            ("awaited", self.p + self.q, "1 for a reading that has not arrived"),
            ("at", 2, "where the ring begins; whether a sample has been taken"),
        ]

    def size(self) -> int:
        return sum(max(length, 1) for _, length, _ in self.members())

    def written(
        self,
        to: C,
        program: Program,
        sizes: dict[str, int],
        results: dict[str, tuple[str, int]],
        places: dict[str, str],
        constants: Matrices | None = None,
    ) -> Cost:
        """Write one pass of a program between braces, and return its cost."""
        constants = self.constants if constants is None else constants
        to.line("{")
        to.depth += 1
        cost = self.module.steps(program, sizes, to, constants, places, results)
        to.end()
        return cost

    def get(self, to: C, name: str, row: int, rows: int, col: int, cols: int) -> None:
        """An array with a block of P."""
        to.array(name, rows * cols)
        to.loop("i", 0, rows * cols)
        to.set(f"{name}[i]", self.entry(row, col, cols))
        to.end()

    def put(self, to: C, name: str, row: int, rows: int, col: int, cols: int) -> None:
        """A block of P, and its mirror image, from an array."""
        to.loop("i", 0, rows * cols)
        to.set(self.entry(row, col, cols), f"{name}[i]")
        to.set(self.entry(row, col, cols, turned=True), f"{name}[i]")
        to.end()

    def entry(self, row: int, col: int, cols: int, turned: bool = False) -> str:
        """That of P which belongs to entry i of a block."""
        r, c = f"i / {cols}", f"i % {cols}"
        r, c = (f"({k} + {at})" if k else f"({at})" for k, at in ((row, r), (col, c)))
        r, c = (c, r) if turned else (r, c)
        return entry("state->P", (r, self.N), (c, 1))

    def use(self) -> str:
        """A reading arrived: everything else is corrected, and it is known."""
        to, N = C(self.module.real), self.N
        for array, length in {
            "P_rt": N,
            "gain": N,
            "P_tt": 1,
            "t": 1,
            "t_hat": 1,
        }.items():
            to.array(array, length)
        to.fill("P_rt[i]", f"state->P[i * {N} + k]", N)
        to.set("P_tt[0]", "P_rt[k]")
        to.set("t[0]", "y")
        to.set("t_hat[0]", "state->xi[k]")
        to.need("P_tt[0] > 0.0")
        program = lowered(late_known, ["K_t", "P_next"], symmetric=("P_rr", "P_tt"))
        cost = self.written(
            to, program, {"s": N, "k": 1},
            {"K_t": ("gain", N), "P_next": ("state->P", N * N)},
            {"P_rr": "state->P"}, {},
        )  # fmt: skip
        cost += self.written(
            to, lowered(late_corrected, ["xi_hat_next"]), {"s": N, "k": 1},
            {"xi_hat_next": ("state->xi", N)},
            {"K_t": "gain", "xi_hat": "state->xi"}, {},
        )  # fmt: skip
        to.set("state->xi[k]", "y")
        to.loop("i", 0, N)
        to.set(f"state->P[i * {N} + k]", "0.0")
        to.set(f"state->P[k * {N} + i]", "0.0")
        to.need(f"state->P[i * {N + 1}] >= 0.0")
        to.end()
        to.line("return 0;")
        self.costs["use"] = cost + Cost(N, 0, 2 * N + 3)
        name, real = self.module.name, self.module.real
        head = f"static int {name}_use({name}_state *state, int k, {real} y)"
        return function(head, to.lines)

    def predict(self) -> str:
        """The state of the next sample, beside what is held; the ring moves on."""
        to, n, p, held = C(self.module.real), self.n, self.p, self.p + self.q
        program = lowered(
            late_ahead,
            ["Omega", "X_h_next", "x_minus"],
            zero=self.zero,
            symmetric=("Qs", "Sigma", "Z_f"),
            same=() if self.cross else [("As", "A")],
        )
        self.get(to, "Sigma", 0, n, 0, n)
        self.get(to, "X_h", 0, n, n, held)
        if self.cross:
            self.get(to, "X_f", 0, n, n, p)
            self.get(to, "Z_f", n, p, n, p)
            self.get(to, "Z_fh", n, p, n, held)
        to.array("ahead", n * n)
        to.array("moved", n * held)
        cost = self.written(
            to, program, {"n": n, "p": p, "m": self.m, "q": held},
            {
                "Omega": ("ahead", n * n),
                "X_h_next": ("moved", n * held),
                "x_minus": ("state->xi", n),
            },
            {"x": "state->xi", "u": "state->u", "y_hat": f"(state->xi + {n})"},
        )  # fmt: skip
        self.put(to, "ahead", 0, n, 0, n)
        self.put(to, "moved", 0, n, n, held)
        self.turn(to)
        self.costs["predict"] = cost + Cost(0, 0, 3 * n * held + 2 * n * n)
        head = (
            f"static void {self.module.name}_predict({self.module.name}_state *state)"
        )
        return function(head, to.lines)

    def turn(self, to: C) -> None:
        """The late readings of the last sample take the place of the oldest."""
        N, L = self.N, len(self.late)
        to.index("at", "(int)state->at[0]")
        to.index("following", f"(at + 1) % {self.horizon}")
        shift = "at" if L == 1 else f"at * {L}"
        for k, j in enumerate(self.late):
            old, new = self.n + j, f"({self.n + self.p + k} + {shift})"
            to.fill(f"state->P[i * {N} + {new}]", f"state->P[i * {N} + {old}]", N)
            to.fill(f"state->P[{new} * {N} + i]", f"state->P[{old * N} + i]", N)
            to.set(f"state->xi[{new}]", f"state->xi[{old}]")
            to.set(f"state->awaited[{self.p + k} + {shift}]", f"state->awaited[{j}]")
        to.set("state->at[0]", f"({self.module.real})following")

    def take(self) -> str:
        """New readings: what is expected of them, and what they are correlated with."""
        to, n, p, q = C(self.module.real), self.n, self.p, self.q
        program = lowered(
            late_fresh, ["y_minus", "N", "N_h", "M"], zero=self.zero,
            symmetric=("R", "Omega"),
        )  # fmt: skip
        self.get(to, "Omega", 0, n, 0, n)
        self.get(to, "X_h", 0, n, n + p, q)
        sizes = {"with_state": n * p, "with_held": q * p, "among": p * p}
        for array, length in sizes.items():
            to.array(array, length)
        cost = self.written(
            to, program, {"n": n, "p": p, "m": self.m, "q": q},
            {
                "y_minus": (f"(state->xi + {n})", p),
                "N": ("with_state", n * p),
                "N_h": ("with_held", q * p),
                "M": ("among", p * p),
            },
            {"x_minus": "state->xi", "u_next": "u"},
        )  # fmt: skip
        self.put(to, "with_state", 0, n, n, p)
        self.put(to, "with_held", n + p, q, n, p)
        self.put(to, "among", n, p, n, p)
        to.fill("state->awaited[i]", "1.0", p)
        to.fill("state->u[i]", "u[i]", self.m)
        to.set("state->at[1]", "1.0")
        self.costs["take"] = cost + Cost(0, 0, n * n + n * q + sum(sizes.values()))
        name, real = self.module.name, self.module.real
        head = f"static void {name}_take({name}_state *state, const {real} u[])"
        return function(head, to.lines, ["u"])
