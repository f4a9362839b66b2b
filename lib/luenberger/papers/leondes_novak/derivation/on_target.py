"""The filter in the order in which a device runs it: use the sample, then predict.

The stages are those of `one_pass.filter_step`, turned round: what belongs to the
outputs of one instant is used up at that instant, and nothing of it is kept.  Outputs
that did not arrive are marked by zeros on a diagonal, so that no size depends on the
data and the matrices of what arrived follow from the plant's by stages too.

Source: Leondes and Novak (1974), (27), (33), (43), (44), (47); the order and the
marks are our own.
"""

from dataclasses import replace
from functools import cache

from sympy import Symbol

from ....symbolic import (
    Algebra,
    Derivation,
    Identity,
    MatrixSymbol,
    Solve,
    Stage,
    claims,
    matrices,
    named,
)
from .correlated_noise import decorrelation
from .letters import SOURCE as PAPER
from .letters import m, n, p, squares
from .one_pass import filter_step, padded
from .quadratic import joseph

AHEAD = {"Omega": "Omega_next", "x_minus": "x_minus_next"}
HERE = {"Sigma_next": "Sigma", "x_next": "x", "rho_next": "rho", "u_next": "u"}


def turned(stages, names):
    """Stages with some symbols under other names."""

    def other(e):
        symbols = e.atoms(MatrixSymbol)
        return e.xreplace(
            {s: MatrixSymbol(names.get(s.name, s.name), *s.shape) for s in symbols}
        )

    def formula(f):
        return Solve(other(f.N), other(f.M)) if isinstance(f, Solve) else other(f)

    return tuple(
        replace(stage, target=other(stage.target), formula=formula(stage.formula))
        for stage in stages
    )


@cache
def predict():
    """Sigma, x and the residual rho of an instant to Omega and x_minus of the next."""
    found = filter_step()
    stages = [stage for stage in found.stages if stage.target.name in AHEAD]
    given = [s for s in found.given if s.name in "A As Q B J Sigma x rho u".split()]
    found = Derivation(tuple(given), turned(stages, HERE | AHEAD), source=PAPER)
    return replace(found, steps=_is_the_error_ahead(found))


def _is_the_error_ahead(derivation):
    s, f = named(derivation), derivation.unfolded()
    A, As, B, J, Q, Sigma = (s[k] for k in "A As B J Q Sigma".split())
    x, rho, u = (s[k] for k in "x rho u".split())
    true, true_next, w = matrices("xt xt_next w", n, 1)
    (C,), (v,) = matrices("C", p, n), matrices("v", p, 1)
    relations = [
        (true_next, A * true + B * u + J * v + w),
        (rho, C * true + v - C * x),
        (As, A - J * C),
    ]
    return claims(
        Algebra([Q, Sigma]),
        {"(44) Omega at i + 1": (f["Omega_next"], As * Sigma * As.T + Q)},
    ) | claims(
        Algebra([], relations),
        {
            "(43) x_minus at i + 1 errs by As (x - true x) - w": (
                f["x_minus_next"] - true_next,
                As * (x - true) - w,
            ),
        },
    )


@cache
def update():
    """Omega, x_minus and the sample (y, u) of an instant to its Sigma, x and rho."""
    found = filter_step()
    stages = [stage for stage in found.stages if stage.target.name not in AHEAD]
    stages = turned(stages, HERE)
    made = {stage.target.name for stage in stages}
    given = [s for s in found.given if s.name in "C R E Gamma y u".split()]
    given += [*squares("Omega"), *matrices("x_minus", n, 1)]
    assert made.isdisjoint(s.name for s in given)
    found = Derivation(tuple(given), stages, source=PAPER)
    return replace(found, steps=_is_the_filter(found))


def _is_the_filter(derivation):
    s, f = named(derivation), derivation.unfolded()
    C, R, E, Gamma, Omega, K = (s[k] for k in "C R E Gamma Omega K".split())
    y, u, x_minus, M = s["y"], s["u"], s["x_minus"], s["M"]
    inner = derivation.unfolded(keep=("M",))
    kept = derivation.unfolded(keep=("K",))
    algebra = Algebra([R, Omega, M])
    Kmv = Omega * C.T * M.I
    x = x_minus + K * (y - E * u - C * x_minus)
    return claims(
        algebra,
        {
            "(33) M = C Omega C' + R": (f["M"], C * Omega * C.T + R),
            "(33) Kmv M = Omega C'": (inner["Kmv"] * M, Omega * C.T),
            "K = Kmv + Gamma - Gamma C Kmv": (
                inner["K"],
                Kmv + Gamma - Gamma * C * Kmv,
            ),
            "(27) for any K, Sigma = Y Omega Y' + K R K'": (
                kept["Sigma"],
                joseph(K, C, Omega, R),
            ),
            "(43) x = x_minus + K (y - E u - C x_minus)": (kept["x"], x),
            "rho = y - E u - C x": (kept["rho"], y - E * u - C * x),
        },
    )


def in_turn(*parts):
    """Stage lists one after the other; what one makes is given to the next."""
    given, stages, steps = [], (), {}
    for part in parts:
        made = {stage.target for stage in stages}
        given += [s for s in part.given if s not in made and s not in given]
        stages, steps = stages + part.stages, steps | part.steps
    return Derivation(tuple(given), stages, steps=steps, source=PAPER)


@cache
def complete_sample():
    """From one prediction to the next, where every output arrived."""
    return in_turn(update(), predict())


@cache
def partial_sample():
    """The update where some outputs did not arrive, from the plant's matrices."""
    return in_turn(arrived(), update())


@cache
def arrived():
    """The matrices of the outputs that arrived, from the plant's.

    Seen (p, p) has ones on its diagonal for the outputs that arrived, Taken for the
    accurate ones among them; all else is zero.  Inverse is that of the weight.
    """
    (C_all,), (E_all,) = matrices("C_all", p, n), matrices("E_all", p, m)
    A, As, Q, Q_all, Inverse = squares("A As Q Q_all Inverse")
    R, R_all, Seen, Taken, Spread = squares("R R_all Seen Taken Spread", p)
    C, E = MatrixSymbol("C", p, n), MatrixSymbol("E", p, m)
    S, S_all, J, Lifted, Gamma = matrices("S S_all J Lifted Gamma", n, p)
    one = Identity(p)
    stages = (
        Stage(C, Seen * C_all),
        Stage(E, Seen * E_all),
        Stage(R, Seen * R_all * Seen + one - Seen, symmetric=True),
        Stage(S, S_all * Seen),
        Stage(J, Solve(S, R)),
        Stage(As, A - J * C),
        Stage(Q, Q_all - J * S.T, symmetric=True),
        Stage(Lifted, Inverse * C_all.T * Taken),
        Stage(Spread, Taken * C_all * Lifted + one - Taken, symmetric=True),
        Stage(Gamma, Solve(Lifted, Spread), "(47)"),
    )
    given = (A, Q_all, C_all, E_all, R_all, S_all, Inverse, Seen, Taken)
    found = Derivation(given, stages, source="our own")
    return replace(found, steps=_is_padded(found))


def _is_padded(derivation):
    """With Seen = Pick' Pick they are those of the shorter problem, in their places."""
    s, f = named(derivation), derivation.unfolded()
    kept = derivation.unfolded(keep=("J", "S", "R"))
    A, C_all, E_all, R_all, S_all = (s[k] for k in "A C_all E_all R_all S_all".split())
    Inverse, Q_all, J, S = (s[k] for k in "Inverse Q_all J S".split())
    pa, m1 = (Symbol(k, integer=True, nonnegative=True) for k in ("p_a", "m1"))
    Pick, First = MatrixSymbol("Pick", pa, p), MatrixSymbol("First", m1, p)
    Ra, M1 = MatrixSymbol("R_seen", pa, pa), MatrixSymbol("M_1", m1, m1)
    algebra = Algebra(
        [Ra, M1, s["R"], R_all, Q_all, Inverse],
        [
            (s["Seen"], Pick.T * Pick),
            (s["Taken"], First.T * First),
            (Pick * Pick.T, Identity(pa)),
            (First * First.T, Identity(m1)),
            (Pick * R_all * Pick.T, Ra),
            (First * C_all * Inverse * C_all.T * First.T, M1),
        ],
    )
    pad = {k.name: k for k in padded().given} | padded().unfolded()
    pad |= {"C": Pick.T * Pick * C_all, "E": Pick.T * Pick * E_all}
    white = decorrelation().unfolded()
    white = {
        k: e.xreplace({w: {"C": s["C"], "Q": Q_all}.get(w.name, w) for w in _of(e)})
        for k, e in white.items()
    }
    one = Identity(p)
    J_seen = S_all * Pick.T * Ra.I
    Gamma1 = Inverse * C_all.T * First.T * M1.I
    return claims(
        algebra,
        {
            "C is padded": (f["C"], pad["C"]),
            "E is padded": (f["E"], pad["E"]),
            "R is padded": (f["R"], pad["R"]),
            "J R = S": (kept["J"] * s["R"], S),
            "J = J_seen Pick": (J_seen * Pick * f["R"], f["S"]),
            "As is that of decorrelation": (
                derivation.unfolded(keep=("J", "C"))["As"],
                white["As"],
            ),
            "Qs is that of decorrelation": (kept["Q"], white["Qs"]),
            "(47) Gamma Spread = Lifted": (
                derivation.unfolded(keep=("Lifted", "Spread"))["Gamma"] * s["Spread"],
                s["Lifted"],
            ),
            "(47) Spread is C1 Inverse C1', padded: definite": (
                f["Spread"],
                First.T * M1 * First + one - First.T * First,
            ),
            "(47) Gamma = Gamma1 First": (
                Gamma1 * First * f["Spread"],
                f["Lifted"],
            ),
            "(47) accurate outputs are matched: C1 Gamma1 = I": (
                First * C_all * Gamma1,
                Identity(m1),
            ),
            "what did not arrive has noise of its own": (
                (one - s["Seen"]) * f["R"],
                one - s["Seen"],
            ),
        },
    )


def _of(e):
    return e.atoms(MatrixSymbol)
