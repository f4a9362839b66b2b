"""Kawazoe's observability form, and the state from p_M samples.

Everything follows from the *structure* of (11) and (14): the last rows of Phi are
named, not computed, and P A P^-1 is never formed.  What the structure gives is
proved here for an index pattern (p_1, ..., p_m) with symbols for every entry that
may differ from 0 and 1; the steps say which pattern.

Source: Kawazoe (1978), (5)-(26).
"""

from functools import cache

import sympy as sp
from sympy import Matrix

from ....symbolic import Claim, Derivation

PATTERNS = ((2, 1), (2, 2), (3, 1), (2, 2, 1))
INPUTS = 2  # concrete number r of inputs


def starts(indices):
    """v_0, v_1, ..., v_m of (19)."""
    return [sum(indices[:i]) for i in range(len(indices) + 1)]


def may_differ_from_zero(indices, i, j, k):
    """Whether the interleaved search leaves phi_ij^k (k from 1) free.

    C_i A^(p_i) depends on rows found before it: lower powers, k - 1 < p_i, and the
    same power of an earlier output, k - 1 = p_i with j < i.
    """
    return k - 1 < indices[i] or (k - 1 == indices[i] and j < i)


def structure(indices):
    """Phi of (11) with named last rows, and H of (14)."""
    n, v = sum(indices), starts(indices)
    Phi, H = sp.zeros(n), sp.zeros(len(indices), n)
    for i, size in enumerate(indices):
        H[i, v[i]] = 1
        for row in range(v[i], v[i + 1] - 1):
            Phi[row, row + 1] = 1
        for j, width in enumerate(indices):
            for k in range(1, width + 1):
                if may_differ_from_zero(indices, i, j, k):
                    name = f"phi_{i + 1}{j + 1}^{k}"
                    Phi[v[i] + size - 1, v[j] + k - 1] = sp.Symbol(name)
    return Phi, H


def named(letter, rows, cols):
    return Matrix(
        rows, cols, lambda i, j: sp.Symbol(f"{letter}_{i + 1}{j + 1}", real=True)
    )


def record(indices, length):
    """The outputs of (9), (10) over some samples, run symbol by symbol."""
    n, m = sum(indices), len(indices)
    Phi, H = structure(indices)
    G, E = named("g", n, INPUTS), named("e", m, INPUTS)
    u = [named(f"u^{k}", INPUTS, 1) for k in range(length)]
    w = Matrix([sp.Symbol(f"w_{k + 1}") for k in range(n)])
    state, y = w, []
    for now in u:
        y.append((H * state + E * now).expand())
        state = (Phi * state + G * now).expand()
    return G, E, u, w, y


def toeplitz(rows, size, samples):
    """(25) for one output: row j = [g_(v+j), ..., g_(v+1), 0, ...].

    `rows` are the rows of G from g_(v+1) on; the matrix has size - 1 block rows and
    samples - 1 block columns, one for each of u_k .. u_(k + p_M - 2).
    """
    r = rows.shape[1]
    Delta = sp.zeros(max(size - 1, 0), r * (samples - 1))
    for j in range(size - 1):
        for column in range(j + 1):
            Delta[j, column * r : (column + 1) * r] = rows[j - column, :]
    return Delta


def printed_25(rows, size, samples):
    """(25) as printed: the rows between the first and the last are diagonal."""
    r = rows.shape[1]
    Delta = toeplitz(rows, size, samples)
    for j in range(1, size - 2):
        Delta[j, :] = sp.zeros(1, Delta.shape[1])
        Delta[j, j * r : (j + 1) * r] = rows[j, :]
    return Delta


def chains(indices):
    """The coefficient matrix of (16): rows h_i Phi^k."""
    Phi, H = structure(indices)
    rows = []
    for i, size in enumerate(indices):
        row = H[i, :]
        for _ in range(size):
            rows.append(row)
            row = row * Phi
    return Matrix.vstack(*rows)


def coordinates(indices):
    """(11): P A = Phi P when the rows of P are C_i A^k and the last powers are named.

    The rows of P are symbols.  A moves each of them to the next, and the last of a
    block to the combination phi_i1' .. phi_im' of all: that is what the named
    entries stand for.
    """
    n, v = sum(indices), starts(indices)
    P, (Phi, _) = named("P", n, n), structure(indices)
    moved = [P[k + 1, :] if k + 1 < n else None for k in range(n)]
    for i in range(len(indices)):
        end = v[i + 1] - 1
        moved[end] = sum((Phi[end, k] * P[k, :] for k in range(n)), sp.zeros(1, n))
    return Claim(Matrix.vstack(*moved), Phi * P)


def inputs_of_16(indices, i, k, G, u):
    """The input term of (15), (16): h_i sum Phi^j G u, for y_i at k + `k`."""
    Phi, H = structure(indices)
    terms = (H[i, :] * Phi ** (k - 1 - j) * G * u[j] for j in range(k))
    return sum(terms, sp.zeros(1, 1))[0].expand()


@cache
def derive(indices=(3, 1)):
    """The structure (11)-(14) and the reconstruction (15)-(26) for one pattern."""
    indices = tuple(indices)
    samples, v = max(indices), starts(indices)
    Phi, H = structure(indices)
    G, E, u, w, y = record(indices, samples)
    pairs = [(i, k) for i, size in enumerate(indices) for k in range(size)]
    stacked = Matrix([y[k][i] - (E[i, :] * u[k])[0] for i, k in pairs])
    driven = Matrix([inputs_of_16(indices, i, k, G, u) for i, k in pairs])
    past = Matrix.vstack(*u[:-1]) if samples > 1 else sp.zeros(0, 1)
    Delta = [
        toeplitz(G[v[i] : v[i + 1], :], size, samples) for i, size in enumerate(indices)
    ]
    unknown = [v[i] + k for i, k in pairs if k]
    formulas = {
        "(11) Phi": Phi,
        "(13) G": G,
        "(14) H": H,
        "(16) coefficient matrix": chains(indices),
        "(16) input term": driven,
        "(19) v": Matrix([v]),
        "(21) p_M": sp.Integer(samples),
        **{f"(25) Delta_{i + 1}": block for i, block in enumerate(Delta)},
    }
    name = f"p = {indices}"
    Delta = Matrix.vstack(*Delta)
    steps = {
        f"(11) P A = Phi P for rows C_i A^k [{name}]": coordinates(indices),
        f"(16) the coefficient matrix is I [{name}]": Claim(
            chains(indices), sp.eye(sum(indices))
        ),
        f"(16) outputs = w + input term, less E u [{name}]": Claim(
            stacked, (w + driven).expand()
        ),
        f"(17) w from outputs and inputs, with a minus [{name}]": Claim(
            (stacked - driven).expand(), w
        ),
        f"(18) the first of each block is an output [{name}]": Claim(
            Matrix([y[0][i] - (E[i, :] * u[0])[0] for i in range(len(indices))]),
            Matrix([w[k] for k in v[:-1]]),
        ),
        f"(22) the n - m others, Delta lower block Toeplitz (25) [{name}]": Claim(
            (stacked.extract(unknown, [0]) - Delta * past).expand(),
            w.extract(unknown, [0]),
        ),
    }
    return Derivation(
        formulas=formulas,
        steps={name: one for name, one in steps.items() if not one.is_empty}
        | single_output(),
        source="Kawazoe (1978), sections III and IV",
    )


@cache
def single_output(n=3):
    """One output: the last row of Phi is the characteristic polynomial's."""
    A, c = named("a", n, n), named("c", 1, n)
    coefficients = A.charpoly().all_coeffs()[:0:-1]  # of 1, s, ..., s^(n-1)
    row, chain = c, []
    for _ in range(n):
        chain.append(row)
        row = (row * A).expand()
    combined = sum((-a * r for a, r in zip(coefficients, chain)), sp.zeros(1, n))
    return {
        f"(11) one output: phi = minus the coefficients of det(s I - A) [n = {n}]": (
            Claim(row, combined.expand())
        )
    }


@cache
def row_first():
    """A plant on which (5), read row by row, does not give the form.

    Row by row takes C_1, C_1 A, C_1 A^2 and nothing of the second output: p = (3, 0),
    (14) fails, and the largest index is 3 where two samples suffice.
    """
    a = sp.symbols("a_1:4")
    A = Matrix([[0, 1, 0], [0, 0, 1], list(a)])
    C = Matrix([[1, 0, 0], [0, 1, 0]])
    by_row = Matrix.vstack(C[0, :], C[0, :] * A, C[0, :] * A**2)
    by_level = Matrix.vstack(C[0, :], C[1, :], C[1, :] * A)
    _, H = structure((1, 2))
    return Derivation(
        given=(A, C),
        formulas={"(6) row by row": by_row, "(6) interleaved": by_level},
        steps={
            "(5) row by row: C_1, C_1 A, C_1 A^2 are independent, p = (3, 0)": Claim(
                by_row, sp.eye(3)
            ),
            "(14) row by row: C_2 is the second row of P, not the head of a block": (
                Claim(C * by_row.inv(), Matrix([[1, 0, 0], [0, 1, 0]]))
            ),
            "(5) interleaved: C_1 A = C_2 is dependent": Claim(C[0, :] * A, C[1, :]),
            "(5) interleaved: C_1, C_2, C_2 A are independent, p = (1, 2)": Claim(
                by_level.det(), 1
            ),
            "(14) interleaved: H has the form": Claim(C * by_level.inv(), H),
        },
        source="our own; on Kawazoe (1978), (5), (6)",
    )


def misprints():
    """(place, what is printed, what comes out of it): each tried, not remembered."""
    indices = (4, 1)
    G, E, u, w, y = record(indices, 4)
    pairs = [(0, 1), (0, 2), (0, 3)]
    outputs = Matrix([y[k][0] - (E[0, :] * u[k])[0] for _, k in pairs])
    past = Matrix.vstack(*u[:-1])
    states = w.extract([1, 2, 3], [0])

    def wrong(Delta, sign=-1):
        left = (outputs + sign * Delta * past - states).expand()
        return [f"w_{k + 2}" for k in range(3) if left[k] != 0]

    good, bad = toeplitz(G[:4, :], 4, 4), printed_25(G[:4, :], 4, 4)
    assert not wrong(good)
    return [
        (
            "(5), (6)",
            "the order of the search is left open",
            "row by row gives p = (3, 0) on a plant with p = (1, 2)",
        ),
        (
            "(17), (20)",
            "= between the outputs and the input term",
            "must be minus; plus spoils " + ", ".join(wrong(good, 1)),
        ),
        (
            "(25)",
            "second row [0, g_(v+2), 0]",
            "lower block Toeplitz; as printed it spoils " + ", ".join(wrong(bad)),
        ),
    ]
