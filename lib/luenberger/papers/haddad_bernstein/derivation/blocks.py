"""The augmented system in normal forms, for claims that are evaluated.

The paper's letters, with those of the library behind them (the rest agree):

    V1, V2, V12   covariances of w1, w2 and E[w1 w2']       Q, R, S of the plant
    Ae, Be        x_e+ = Ae x_e + Be y                      F, D of the observer
    Ce, De        y_e = Ce x_e + De y                       P, V
    Gam, G'       x_e tracks Gam x; G' lifts x_e to R^n     T, and no letter
    R             weight on the error of L x                `weight`

G is never the library's input gain here, and R and P never the plant's R and the
observer's P.  Each pair (A_i, C_i) is multiplied by a white noise of unit variance,
independent of all others; two pairs stand for any number, because the Lagrangian is
proved to be additive over pairs.

Source: Haddad and Bernstein (1987), sections 2 and 4, (3.1)-(3.5), (4.1)-(4.11).
"""

from functools import cache

import sympy as sp
from sympy import Trace

from ....symbolic import (
    Algebra,
    BlockMatrix,
    Derivation,
    Identity,
    MatrixSymbol,
    ZeroMatrix,
    claims,
)

n, l, r, q = sp.symbols("n l n_e q", integer=True, nonnegative=True)

A, V1, Q1, P1 = (MatrixSymbol(k, n, n) for k in ("A", "V1", "Q1", "P1"))
C, V12, V2 = (
    MatrixSymbol("C", l, n),
    MatrixSymbol("V12", n, l),
    MatrixSymbol("V2", l, l),
)
L, R = MatrixSymbol("L", q, n), MatrixSymbol("R", q, q)
Ae, Be = MatrixSymbol("Ae", r, r), MatrixSymbol("Be", r, l)
Ce, De = MatrixSymbol("Ce", q, r), MatrixSymbol("De", q, l)
Q12, P12 = MatrixSymbol("Q12", n, r), MatrixSymbol("P12", n, r)
Q2, P2 = MatrixSymbol("Q2", r, r), MatrixSymbol("P2", r, r)
PAIRS = tuple(
    (MatrixSymbol(f"A_{i}", n, n), MatrixSymbol(f"C_{i}", l, n)) for i in (1, 2)
)
GAINS = (Ae, Be, Ce, De)

Qt = BlockMatrix([[Q1, Q12], [Q12.T, Q2]])
Pt = BlockMatrix([[P1, P12], [P12.T, P2]])
At = BlockMatrix([[A, ZeroMatrix(n, r)], [Be * C, Ae]])
Vt = BlockMatrix([[V1, V12 * Be.T], [Be * V12.T, Be * V2 * Be.T]])
error = BlockMatrix([[L - De * C, -Ce]])  # L x - y_e without what is noise

NU = sp.symbols("nu_1 nu_2")
x, xe, w1, w2 = (
    MatrixSymbol(k, d, 1) for k, d in (("x", n), ("x_e", r), ("w_1", n), ("w_2", l))
)
JOINT = BlockMatrix([[V1, V12], [V12.T, V2]])
SUMS = tuple(zip(zip(*PAIRS), (ZeroMatrix(n, n), ZeroMatrix(l, n))))

SYMMETRIC = (V1, V2, R, Q1, Q2, P1, P2)
ALGEBRA = Algebra(SYMMETRIC)


def noisy(pair):
    """A~_i: what a pair's noise does to the augmented state."""
    Ai, Ci = pair
    return BlockMatrix([[Ai, ZeroMatrix(n, r)], [Be * Ci, ZeroMatrix(r, r)]])


def weight(pairs=()):
    """R~: the cost in the augmented state."""
    corner = sum((Ci.T * De.T * R * De * Ci for _, Ci in pairs), ZeroMatrix(n, n))
    cross = -(L - De * C).T * R * Ce
    return BlockMatrix(
        [
            [(L - De * C).T * R * (L - De * C) + corner, cross],
            [cross.T, Ce.T * R * Ce],
        ]
    )


def moment(pairs=()):
    """The right side of (4.4): the next second moment."""
    found = ALGEBRA.normal(At * Qt * At.T + Vt)
    for pair in pairs:
        found = found + noisy(pair) * Qt * noisy(pair).T
    return found


def adjoint(pairs=()):
    """The right side of (4.5)."""
    found = ALGEBRA.normal(At.T * Pt * At + weight(pairs))
    for pair in pairs:
        found = found + noisy(pair).T * Pt * noisy(pair)
    return found


def cost(pairs=()):
    """J in terms of Q~: tr Q~ R~ + tr De V2 De' R."""
    return ALGEBRA.normal(Trace(Qt * weight(pairs))) + Trace(De * V2 * De.T * R)


@cache
def lagrangian(pairs=()):
    """J + tr P~ (right side of (4.4) - Q~)."""
    return cost(pairs) + ((moment(pairs) - Qt) @ ALGEBRA.normal(Pt)).trace()


@cache
def gradients(pairs=()):
    """{gain: half the gradient of the Lagrangian}, which is half that of J."""
    return {X: sp.S.Half * ALGEBRA.gradient(lagrangian(pairs), X) for X in GAINS}


def mean(value):
    """The expectation over nu_1, nu_2 of a normal form of degree two in them.

    The mean over the four signs nu_i = +-1 has the same first and second moments.
    """
    signs = [{NU[0]: a, NU[1]: b} for a in (1, -1) for b in (1, -1)]
    parts = [value.as_expr().subs(sign) for sign in signs]
    found = ALGEBRA.normal(parts[0])
    for part in parts[1:]:
        found = found + part
    return sp.Rational(1, 4) * found


def formulas():
    Ai, Ci = (sum((nu * X for nu, X in zip(NU, Xs)), Z) for Xs, Z in SUMS)
    x_next, y = (A + Ai) * x + w1, (C + Ci) * x + w2
    return {
        "(3.1) x_+": x_next,
        "(3.2) y": y,
        "(3.3) x_e+": Ae * xe + Be * y,
        "(3.4) y_e": Ce * xe + De * y,
        "(3.5) J": cost(PAIRS).as_expr(),
        "A~": At,
        "A~_i": noisy(PAIRS[0]),
        "V~": Vt,
        "R~": weight(PAIRS),
        "(4.1) x~": BlockMatrix([[x], [xe]]),
        "(4.2) Q~": Qt,
        "(4.3),(4.4) Q~_+": moment(PAIRS).as_expr(),
        "(4.5) P~": adjoint(PAIRS).as_expr(),
    } | {
        f"(4.{k}) half of dJ/d{X.name}": gradients(PAIRS)[X].as_expr()
        for k, X in enumerate(GAINS, 8)
    }


def printed_weight():
    """R~ as section 2 has it, its lost letters filled in."""
    corner = (
        L.T * R * L
        - L.T * R * De * C
        - C.T * De.T * R * L
        + C.T * De.T * R * De * C
        + sum((Ci.T * De.T * R * De * Ci for _, Ci in PAIRS), ZeroMatrix(n, n))
    )
    return BlockMatrix(
        [
            [corner, -L.T * R * Ce + C.T * De.T * R * Ce],
            [-Ce.T * R * L + Ce.T * R * De * C, Ce.T * R * Ce],
        ]
    )


def system_steps():
    """(3.1)-(3.5) and (4.1)-(4.5): the augmented system, its moment and its cost."""
    at = formulas()
    noisy_A = ALGEBRA.normal(At)
    for nu, pair in zip(NU, PAIRS):
        noisy_A = noisy_A + nu * ALGEBRA.normal(noisy(pair))
    xt = BlockMatrix([[x], [xe]])
    # columns of w~ = [w1; Be w2] and of the error's own noise
    into = BlockMatrix([[Identity(n), ZeroMatrix(n, l)], [ZeroMatrix(r, n), Be]])
    out = ALGEBRA.normal(error)
    for nu, (_, Ci) in zip(NU, PAIRS):
        out = out - nu * ALGEBRA.normal(BlockMatrix([[De * Ci, ZeroMatrix(q, r)]]))
    e_cov = mean(out @ ALGEBRA.normal(Qt) @ out.T) + De * V2 * De.T
    ahead = mean(noisy_A @ ALGEBRA.normal(Qt) @ noisy_A.T)
    P, Q = ALGEBRA.normal(Pt), ALGEBRA.normal(Qt)
    dual = ((moment(PAIRS) - Vt) @ P).trace()
    return {
        "(3.1)-(3.3),(4.1) x~_+ = (A~ + sum nu_i A~_i) x~ + [w1; Be w2]": (
            noisy_A @ ALGEBRA.normal(xt) + into * BlockMatrix([[w1], [w2]]),
            BlockMatrix([[at["(3.1) x_+"]], [at["(3.3) x_e+"]]]),
        ),
        "V~ = cov [w1; Be w2]": (Vt, into * JOINT * into.T),
        "(3.4) L x - y_e = [L - De C | -Ce] x~ - sum nu_i De C_i x - De w2": (
            out @ ALGEBRA.normal(xt) - De * w2,
            L * x - at["(3.4) y_e"],
        ),
        "(4.2),(4.3),(4.4) Q~_+ = A~Q~A~' + sum A~_i Q~ A~_i' + V~": (
            ahead + Vt,
            moment(PAIRS),
        ),
        "(3.5) J = E e'R e = tr Q~R~ + tr De V2 De'R": (
            Trace(R * e_cov.as_expr()),
            cost(PAIRS).as_expr(),
        ),
        "R~ as section 2 has it": (weight(PAIRS), printed_weight()),
        "(4.5) is the dual of (4.4): tr P~ (A~Q~A~' + ..) = tr Q~ (A~'P~A~ + ..)": (
            dual,
            ((adjoint(PAIRS) - weight(PAIRS)) @ Q).trace(),
        ),
        "(4.5) J - tr P~V~ - tr De V2 De'R vanishes with (4.4) - Q~ and (4.5) - P~": (
            cost(PAIRS)
            - Trace(Pt * Vt)
            - Trace(De * V2 * De.T * R)
            - ((Q - moment(PAIRS)) @ P).trace(),
            -((P - adjoint(PAIRS)) @ Q).trace(),
        ),
    }


def stationarity_steps():
    """(4.6)-(4.11): gradients of the Lagrangian."""
    whole, half = lagrangian(PAIRS), sp.S.Half
    ahead, back = moment(PAIRS) - Qt, adjoint(PAIRS) - Pt
    first, second = PAIRS
    steps = {}
    for k, duals, blocks in (
        (6, (P1, P12, P2), ahead),
        (7, (Q1, Q12, Q2), back),
    ):
        for X, (i, j) in zip(duals, ((0, 0), (0, 1), (1, 1))):
            # an off-diagonal block occurs twice
            scale = half if i != j else 1
            steps[f"(4.{k}) block {i + 1}{j + 1} is the gradient in {X.name}"] = (
                scale * ALGEBRA.gradient(whole, X),
                blocks[i, j],
            )
    found = gradients(PAIRS)
    Qs_hat = A * Q1 * C.T + V12 + pairs_sum(Q1, 0) - A * Q12 * Q2.I * Q12.T * C.T
    V2s_hat = C * Q1 * C.T + V2 + pairs_sum(Q1, 1) - C * Q12 * Q2.I * Q12.T * C.T
    return steps | {
        "(4.8) half the gradient in Ae is P12'A Q12 + P2 Be C Q12 + P2 Ae Q2": (
            found[Ae],
            P12.T * A * Q12 + P2 * Be * C * Q12 + P2 * Ae * Q2,
        ),
        "(4.9) modulo (4.8): P12'Qs + P2 Be V2s": (
            found[Be] - found[Ae] @ ALGEBRA.normal(Q2.I * Q12.T * C.T),
            P12.T * Qs_hat + P2 * Be * V2s_hat,
        ),
        "(4.10) half the gradient in Ce is -R L Q12 + R De C Q12 + R Ce Q2": (
            found[Ce],
            -R * L * Q12 + R * De * C * Q12 + R * Ce * Q2,
        ),
        "(4.11) modulo (4.10), times R^-1: De V2s - L Q C'": (
            ALGEBRA.normal(R.I)
            @ (found[De] - found[Ce] @ ALGEBRA.normal(Q2.I * Q12.T * C.T)),
            De * V2s_hat - L * (Q1 - Q12 * Q2.I * Q12.T) * C.T,
        ),
        "two pairs stand for any number: the Lagrangian is additive over pairs": (
            whole + lagrangian(),
            lagrangian((first,)) + lagrangian((second,)),
        ),
    }


def pairs_sum(X, k):
    """sum A_i X C_i' (k = 0) or sum C_i X C_i' (k = 1)."""
    return sum((pair[k] * X * pair[1].T for pair in PAIRS), ZeroMatrix((n, l)[k], l))


@cache
def derive():
    return Derivation(
        given=(A, C, V1, V12, V2, L, R, *GAINS),
        formulas=formulas(),
        steps=claims(ALGEBRA, system_steps() | stationarity_steps()),
        source="Haddad and Bernstein (1987), (3.1)-(3.5), (4.1)-(4.11)",
    )
