"""Kawazoe's definitions and the outputs (15), each as a claim that can fail.

The part of `form` that holds for every size, and the names of (4)-(7), (12),
(19)-(24) at the index patterns of that module.

Source: Kawazoe (1978), (1)-(8), (12), (15), (19)-(24).
"""

from functools import cache

import sympy as sp
from sympy import Matrix

from ....symbolic import Algebra, Claim, Derivation, MatrixSymbol, ZeroMatrix, claims
from .form import PATTERNS, chains, named, record, starts, structure, toeplitz

n, m, r = sp.symbols("n m r", integer=True, positive=True)
P, A, Phi = (MatrixSymbol(k, n, n) for k in ("P", "A", "Phi"))
B, C, H = MatrixSymbol("B", n, r), MatrixSymbol("C", m, n), MatrixSymbol("H", m, n)
G, x, w = MatrixSymbol("G", n, r), MatrixSymbol("x", n, 1), MatrixSymbol("w", n, 1)


def every_size():
    """(1)-(3), (8), (13), (15): the outputs to come, in x and in w."""
    algebra = Algebra([], [(P * A, Phi * P), (C, H * P), (P * x, w), (P * B, G)])
    steps, state, moved = {}, x, w
    for k in range(5):
        steps[f"(3) C A^{k} = H Phi^{k} P: both pairs are observable, or none"] = (
            C * A**k,
            H * Phi**k * P,
        )
    for k in range(1, 5):
        now = MatrixSymbol(f"u_{k - 1}", r, 1)
        state, moved = A * state + B * now, Phi * moved + G * now
        inputs = sum(
            (
                H * Phi ** (k - 1 - i) * G * MatrixSymbol(f"u_{i}", r, 1)
                for i in range(k)
            ),
            ZeroMatrix(m, 1),
        )
        steps |= {
            f"(1),(2),(15) y_{k} = H Phi^{k} w + the inputs since": (
                C * state,
                H * Phi**k * w + inputs,
            ),
            f"(8),(9),(13) P x_{k} = w_{k}": (P * state, moved),
        }
    return claims(algebra, steps)


def pattern_steps(indices):
    """(4)-(7), (12), (19)-(24) for one index pattern."""
    size, v, samples = sum(indices), starts(indices), max(indices)
    Phi, H = structure(indices)
    G, E, u, w, y = record(indices, samples)
    past = Matrix.vstack(*u[:-1]) if samples > 1 else sp.zeros(0, 1)
    tops = [w[k] for k in v[:-1]]
    name = f"p = {indices}"
    steps = {
        f"(6),(7) the rows C_i A^k, k < p_i, are n independent ones [{name}]": Claim(
            sp.Integer(chains(indices).rank()), sp.Integer(size)
        ),
        f"(19) block i begins behind the first p_1 + .. + p_(i-1) [{name}]": Claim(
            Matrix([H[i, v[i]] for i in range(len(indices))]), sp.ones(len(indices), 1)
        ),
    }
    for i, width in enumerate(indices):
        below = slice(v[i] + 1, v[i + 1])
        outputs = [y[k][i] - (E[i, :] * u[k])[0] for k in range(1, width)]  # (24)
        Delta = toeplitz(G[v[i] : v[i + 1], :], width, samples)
        phi = [Phi[v[i + 1] - 1, v[j] : v[j + 1]] for j in range(len(indices))]
        where = f"output {i + 1} [{name}]"
        steps |= {
            f"(4),(14) C_{i + 1} heads block {i + 1}: h P = C_{i + 1}, {where}": Claim(
                H[i, :] * named("P", size, size), named("P", size, size)[v[i], :]
            ),
            f"(12) phi_{i + 1}1' .. phi_{i + 1}m' make the last row, {where}": (
                Claim(Matrix.hstack(*phi), Phi[v[i + 1] - 1, :])
            ),
        }
        if width > 1:
            steps[f"(20),(22)-(25) w_vi = Y_i - Delta_i u, {where}"] = Claim(
                w[below, :], (Matrix(outputs) - Delta * past).expand()
            )
    others = [w[v[i] + 1 : v[i + 1], :] for i in range(len(indices))]
    sorted_w = [x for top, rest in zip(tops, others) for x in (top, *rest)]
    steps[f"(18),(23) what is read and what is computed make w [{name}]"] = Claim(
        Matrix(sorted_w), w
    )
    return steps | index_steps(indices, Phi, H, name)


def index_steps(indices, Phi, H, name):
    """(21): p_M samples determine the state, one sample less does not."""

    def rank(samples):
        return Matrix.vstack(*(H * Phi**k for k in range(samples))).rank()

    longest = max(indices)
    short = sum(min(p, longest - 1) for p in indices)
    return {
        f"(21) p_M samples have rank n [{name}]": Claim(
            sp.Integer(rank(longest)), sp.Integer(sum(indices))
        ),
        f"(21) p_M - 1 samples have rank sum min(p_i, p_M - 1) < n [{name}]": Claim(
            sp.Integer(rank(longest - 1)), sp.Integer(short)
        ),
    }


def search():
    """(5): C_1, C_2, C_1 A, .. by columns, where C_1 A = C_2 is omitted."""
    A = Matrix([[0, 1, 0], [0, 0, 1], list(sp.symbols("a_1:4"))])
    C = Matrix([[1, 0, 0], [0, 1, 0]])
    table = [C * A**k for k in range(3)]
    kept = []
    for level in table:
        for i in range(2):
            if Matrix.vstack(*kept, level[i, :]).rank() > len(kept):
                kept.append(level[i, :])
    return {
        "(5) by columns the search keeps C_1, C_2, C_2 A [n = 3]": Claim(
            Matrix.vstack(*kept), Matrix.vstack(C, C[1, :] * A)
        )
    }


@cache
def derive():
    steps = every_size() | search()
    for indices in PATTERNS:
        steps |= pattern_steps(indices)
    return Derivation(
        given=(A, B, C),
        formulas={"(8) w": P * x, "(9) w_+": Phi * w + G * MatrixSymbol("u", r, 1)},
        steps=steps,
        source="Kawazoe (1978), sections II to IV",
    )
