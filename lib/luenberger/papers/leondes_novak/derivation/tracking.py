"""The radar tracker: a target's position, velocity and acceleration.

The start (57) is the parabola through the last three position measurements: three
equations for three unknowns, so least squares fits exactly.  Its error is linear in
the three measurement noises and in the two manoeuvres between them, which gives the
covariance (58).  All steps are at the concrete sizes of the example, n = 3, p = 2,
m1 = 1, with symbols for T and the variances.

Source: Leondes and Novak (1974), section V, (54)-(58).
"""

from functools import cache

import sympy as sp

from ....symbolic import Claim, Derivation

T, s_x, s_v, s_m = sp.symbols("T sigma_x sigma_xdot sigma_m", positive=True)
Rat = sp.Rational


def model():
    """(54)-(56): A, the manoeuvre's input, C and R."""
    t = sp.Symbol("t")
    # position under constant acceleration, and its derivatives after time T
    integrator = sp.Matrix([[0, 1, 0], [0, 0, 1], [0, 0, 0]])
    A = sum((integrator**k * t**k / sp.factorial(k) for k in range(3)), sp.zeros(3))
    G = sp.Matrix([0, 0, 1])
    C = sp.Matrix([[1, 0, 0], [0, 1, 0]])
    return A.subs(t, T), G, C, sp.diag(s_x**2, s_v**2)


def fit():
    """(57): the state at instant 0 whose parabola meets y_0, y_-1, y_-2."""
    A, _, C, _ = model()
    y = sp.Matrix(sp.symbols("y_0 y_-1 y_-2"))
    back = A.inv()
    positions = sp.Matrix.vstack(*(C[0, :] * back**k for k in range(3)))
    normal = positions.T * positions
    start = (normal.inv() * positions.T * y).applyfunc(sp.factor)
    return positions, y, start


def start_error():
    """Error of (57) as a linear map of v_0, v_-1, v_-2, w_-1, w_-2."""
    A, G, C, _ = model()
    v0, v1, v2, w1, w2 = noise = sp.symbols("v_0 v_-1 v_-2 w_-1 w_-2")
    x0 = sp.Matrix(sp.symbols("x xdot xddot"))
    x1 = A.inv() * (x0 - G * w1)  # the state one step before
    x2 = A.inv() * (x1 - G * w2)
    measured = [C[0, :].dot(x) + v for x, v in ((x0, v0), (x1, v1), (x2, v2))]
    _, y, start = fit()
    error = (start.subs(dict(zip(y, measured))) - x0).applyfunc(sp.expand)
    return error, error.jacobian(noise), sp.Matrix(noise)


def start_covariance():
    """(58): every noise with its variance, all independent."""
    _, gains, _ = start_error()
    variances = sp.diag(s_x**2, s_x**2, s_x**2, s_m**2, s_m**2)
    return (gains * variances * gains.T).applyfunc(sp.expand)


def printed():
    """(57) and (58) as the paper prints them, for comparison only."""
    y0, y1, y2 = sp.symbols("y_0 y_-1 y_-2")
    start = sp.Matrix(
        [
            y0,
            (Rat(3, 2) * y0 - 2 * y1 + Rat(1, 2) * y2) / T,
            (y0 - 2 * y1 + y2) / T**2,
        ]
    )
    velocity = Rat(13, 2) * s_x**2 / T**2 + T**2 * s_m**2 / 16
    cross = 6 * s_x**2 / T**3 + s_m**2 * T / 8
    acceleration = 6 * s_x**2 / T**4 + 5 * s_m**2 / 4
    top = [s_x**2, Rat(3, 2) * s_x**2 / T, s_x**2 / T**2]
    covariance = sp.Matrix(
        [top, [top[1], velocity, cross], [top[2], cross, acceleration]]
    )
    return start, covariance


def limits():
    """(33) for this plant when the velocity is measured badly: (37)."""
    Omega = sp.Matrix(3, 3, lambda i, j: sp.Symbol(f"Omega_{min(i, j)}{max(i, j)}"))
    _, _, C, R = model()
    M, crossed = C * Omega * C.T + R, Omega * C.T
    reduced = crossed[1:, :] * M.adjugate() / M.det()
    full = crossed * M.adjugate() / M.det()

    def limit(matrix):
        return matrix.applyfunc(lambda e: sp.limit(sp.cancel(e), s_v, sp.oo))

    one = crossed[:, 0] / M[0, 0]
    return limit(reduced), one[1:, :], limit(full), one


@cache
def derive():
    A, G, C, R = model()
    positions, y, start = fit()
    error, gains, noise = start_error()
    covariance = start_covariance()
    printed_start, printed_covariance = printed()
    reduced, minimal, full, without = limits()
    formulas = {
        "(54) A": A,
        "(54) input of the manoeuvre": G,
        "(54) Q": G * s_m**2 * G.T,
        "(55) C": C,
        "(56) R": R,
        "(57) positions as a map of the state": positions,
        "(57) xbar_0": start,
        "(58) error of xbar_0": error,
        "(58) Sigma_00": covariance,
    }
    squares = gains * sp.diag(s_x, s_x, s_x, s_m, s_m)
    name = "(n = 3, p = 2, m1 = 1)"
    steps = {
        f"(54) A is the exact transition: A(T) A(-T) = I {name}": Claim(
            A * A.subs(T, -T), sp.eye(3)
        ),
        f"(57) three positions determine the state: det = -T^3 {name}": Claim(
            positions.det(), -(T**3)
        ),
        f"(57) the parabola meets all three measurements {name}": Claim(
            positions * start, y
        ),
        f"(57) as printed {name}": Claim(start, printed_start),
        f"(57) unbiased: the error holds noises only {name}": Claim(
            error, gains * noise
        ),
        f"(58) as printed {name}": Claim(covariance, printed_covariance),
        f"(58) is a sum of squares: the gains times their transpose {name}": Claim(
            covariance, squares * squares.T
        ),
        f"(33),(37) sigma_xdot to infinity: the minimal-order gain {name}": Claim(
            reduced, minimal.row_join(sp.zeros(2, 1))
        ),
        f"(33) sigma_xdot to infinity: Kalman's gain from position only {name}": Claim(
            full, without.row_join(sp.zeros(3, 1))
        ),
    }
    return Derivation(
        formulas=formulas, steps=steps, source="Leondes and Novak (1974), section V"
    )
