"""What is claimed of the stage lists of `moment_stages`.

A stage list is unfolded into its formulas and compared with the blocks of (4.4) and
(4.5), and with the gradients of the Lagrangian, so a damaged stage makes a claim
fail.  Here the plant is the equivalent one: no pairs, V1, V12, V2 stand for all
noise; `equivalent_noise` is where that is proved.

Source: Haddad and Bernstein (1987), (4.4)-(4.11).
"""

import sympy as sp
from sympy import Trace

from ....symbolic import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix, claims, named
from .augmented import (
    ALGEBRA,
    GAINS,
    P1,
    P2,
    P12,
    Q1,
    Q2,
    Q12,
    V2,
    V12,
    A,
    Ae,
    Be,
    C,
    Ce,
    De,
    L,
    Qt,
    R,
    adjoint,
    cost,
    error,
    gradients,
    l,
    moment,
    n,
    noisy,
    r,
)


def known(found):
    """Moments with the output as symbols, and what they stand for."""
    s = named(found)
    meant = {"Qxy": Q1 * C.T, "Qxy_next": A * Q1 * C.T + V12, "Qyy": C * Q1 * C.T + V2}
    relations = [(s[name], value) for name, value in meant.items() if name in s]
    return ALGEBRA.with_relations(*relations, symmetric={s.get("Qyy", Q1)})


def equivalent_noise(found):
    s, f = named(found), found.unfolded()
    A1, C1, X = s["A1"], s["C1"], s["X"]
    algebra = ALGEBRA.with_relations(symmetric=[X])
    both = BlockMatrix([[A1], [C1]])
    added = BlockMatrix([[f["dV1"], f["dV12"]], [f["dV12"].T, f["dV2"]]])
    into = BlockMatrix([[Identity(n), ZeroMatrix(n, l)], [ZeroMatrix(r, n), Be]])
    change = noisy((A1, C1)) * BlockMatrix([[X, Q12], [Q12.T, Q2]]) * noisy((A1, C1)).T
    return claims(
        algebra,
        {
            "(3.1),(3.2) what is added is the covariance of [A1; C1] x": (
                added,
                both * X * both.T,
            ),
            "(4.4) A~1 Q~ A~1' = [I 0; 0 Be] (what is added) [I 0; 0 Be]'": (
                change,
                into * added * into.T,
            ),
            "(3.5) tr C1'De'R De C1 X = tr De dV2 De' R": (
                Trace(C1.T * De.T * R * De * C1 * X),
                Trace(De * f["dV2"] * De.T * R),
            ),
        },
    )


def output_moments(found):
    f = found.unfolded()
    x, w, v = (MatrixSymbol(k, d, 1) for k, d in (("x", n), ("w1", n), ("w2", l)))
    joint = BlockMatrix(
        [
            [Q1, ZeroMatrix(n, n), ZeroMatrix(n, l)],
            [ZeroMatrix(n, n), MatrixSymbol("V1", n, n), V12],
            [ZeroMatrix(l, n), V12.T, V2],
        ]
    )
    state = BlockMatrix([[Identity(n), ZeroMatrix(n, n), ZeroMatrix(n, l)]])
    after = BlockMatrix([[A, Identity(n), ZeroMatrix(n, l)]])
    output = BlockMatrix([[C, ZeroMatrix(l, n), Identity(l)]])
    together = BlockMatrix([[x], [w], [v]])
    return claims(
        ALGEBRA,
        {
            "(3.1) x+ = [A I 0] (x, w1, w2)": (after * together, A * x + w),
            "(3.2) y = [C 0 I] (x, w1, w2)": (output * together, C * x + v),
            "Qxy = E[x y']": (f["Qxy"], state * joint * output.T),
            "Qxy_next = E[x+ y']": (f["Qxy_next"], after * joint * output.T),
            "Qyy = E[y y']": (f["Qyy"], output * joint * output.T),
        },
    )


def estimator_moments(found):
    f, algebra, blocks = found.unfolded(), known(found), moment()
    return claims(
        algebra,
        {
            "(4.6) block 12 of A~Q~A~' + V~ is A Q12 Ae' + N12": (
                A * Q12 * Ae.T + f["N12"],
                blocks[0, 1].as_expr(),
            ),
            "(4.6) block 22 of A~Q~A~' + V~ is Ae Q2 Ae' + N2": (
                Ae * Q2 * Ae.T + f["N2"],
                blocks[1, 1].as_expr(),
            ),
        },
    )


def adjoint_moments(found):
    f, blocks = found.unfolded(), adjoint()
    return claims(
        ALGEBRA,
        {
            "(4.7) block 22 of A~'P~A~ + R~ is Ae'P2 Ae + M2": (
                Ae.T * P2 * Ae + f["M2"],
                blocks[1, 1],
            ),
            "(4.7) block 12 of A~'P~A~ + R~ is A'P12 Ae + M12": (
                A.T * P12 * Ae + f["M12"],
                blocks[0, 1],
            ),
            "(4.7) block 11 of A~'P~A~ + R~ is A'P1 A + M1": (
                A.T * P1 * A + f["M1"],
                blocks[0, 0],
            ),
        },
    )


def projection_cost(found):
    f, algebra = found.unfolded(), known(found)
    return claims(
        algebra,
        {
            "(3.5) Sigma = E[e e'], e = [L - De C | -Ce] x~ - De w2": (
                f["Sigma"],
                error * Qt * error.T + De * V2 * De.T,
            ),
            "(3.5) tr J = tr Q~ R~ + tr De V2 De' R": (
                Trace(f["J"]),
                cost().as_expr(),
            ),
        },
    )


def projection_gradient(found):
    f, algebra, halves = found.unfolded(), known(found), gradients()
    return claims(
        algebra,
        {
            f"(4.{k}) grad{X.name} is the gradient of the Lagrangian in {X.name}": (
                f[f"grad{X.name}"],
                2 * halves[X].as_expr(),
            )
            for k, X in enumerate(GAINS, 8)
        },
    )


def best_output(found):
    s, f = named(found), found.unfolded(keep=("Czy", "Nzy"))
    algebra, halves = known(found), gradients()
    both, Czy, Nzy = BlockMatrix([[Ce, De]]), s["Czy"], s["Nzy"]
    gradient = BlockMatrix([[halves[Ce].as_expr(), halves[De].as_expr()]])
    silent = {De: ZeroMatrix(*De.shape)}
    seen = BlockMatrix([[Identity(r), ZeroMatrix(r, n)], [ZeroMatrix(l, r), C]])
    apart = BlockMatrix([[ZeroMatrix(r, r), ZeroMatrix(r, l)], [ZeroMatrix(l, r), V2]])
    moments = BlockMatrix([[Q2, Q12.T], [Q12, Q1]])
    return claims(
        algebra,
        {
            "Czy is the covariance of (x_e, y)": (
                f["Czy"],
                seen * moments * seen.T + apart,
            ),
            "(4.10),(4.11) R ([Ce De] Czy - Nzy) is half the gradient": (
                R * (both * f["Czy"] - f["Nzy"]),
                gradient,
            ),
            "(4.10) De = 0: R (Ce Q2 - L Q12) is half the gradient": (
                R * (Ce * Q2 - L * Q12),
                halves[Ce].as_expr().xreplace(silent),
            ),
            "(4.10) De = 0: Ce Q2 = L Q12": (f["Ce"] * Q2, L * Q12),
        },
    ) | claims(
        ALGEBRA.with_relations(symmetric=[Czy]),
        {"(4.10),(4.11) [Ce De] Czy = Nzy": (f["CeDe"] * Czy, Nzy)},
    )


def best_output_differential(found, best):
    s, f = named(found), found.unfolded(keep=("dNzy",))
    before, algebra = best.unfolded(), known(best)
    step = {Q12: s["dQ12"], Q2: s["dQ2"]}
    algebra = algebra.with_relations(symmetric=[s["dQ2"]])
    moved = {
        name: algebra.differential(before[name], step).as_expr()
        for name in ("Czy", "Nzy")
    }
    alone = {De: ZeroMatrix(*De.shape)}
    return claims(
        algebra,
        {
            "dNzy = d(Nzy) - [Ce De] d(Czy)": (
                f["dNzy"],
                moved["Nzy"] - BlockMatrix([[Ce, De]]) * moved["Czy"],
            ),
            "De = 0: dCe Q2 = d(L Q12) - Ce dQ2": (
                f["dCe"] * Q2,
                algebra.differential(L * Q12 - Ce * Q2, step),
            ),
            "De = 0: its right side is the first block of dNzy": (
                f["dCe"] * Q2,
                f["dNzy"].blocks[0, 0].xreplace(alone),
            ),
        },
    ) | claims(
        ALGEBRA.with_relations(symmetric=[s["Czy"]]),
        {"dCeDe Czy = dNzy": (f["dCeDe"] * s["Czy"], s["dNzy"])},
    )


def projection_differential(found):
    s, f, algebra = named(found), found.unfolded(), known(found)
    moving = (*GAINS, Q12, Q2, P12, P2)
    step = {X: s[f"d{X.name}"] for X in moving}
    algebra = algebra.with_relations(symmetric=[step[Q2], step[P2]])
    ahead, back, halves = moment(), adjoint(), gradients()
    d = lambda value: algebra.differential(value.as_expr(), step)  # noqa: E731
    return claims(
        algebra,
        {
            "A dQ12 Ae' + dN12 is the differential of block 12 of (4.6)": (
                A * step[Q12] * Ae.T + f["dN12"],
                d(ahead[0, 1]),
            ),
            "Ae dQ2 Ae' + dN2 is the differential of block 22 of (4.6)": (
                Ae * step[Q2] * Ae.T + f["dN2"],
                d(ahead[1, 1]),
            ),
            "Ae'dP2 Ae + dM2 is the differential of block 22 of (4.7)": (
                Ae.T * step[P2] * Ae + f["dM2"],
                d(back[1, 1]),
            ),
            "A'dP12 Ae + dM12 is the differential of block 12 of (4.7)": (
                A.T * step[P12] * Ae + f["dM12"],
                d(back[0, 1]),
            ),
        }
        | {
            f"dgrad{X.name} is the differential of the gradient in {X.name}": (
                f[f"dgrad{X.name}"],
                sp.Integer(2) * d(halves[X]),
            )
            for X in GAINS
        },
    )
