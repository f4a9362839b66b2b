"""Numbers printed in a source, or known in closed form; one test per source.

Tolerances are those of the sources: four printed decimals, or an exact value.
Filter form throughout: A and C of a published control problem are transposed.
"""

import numpy as np
import pytest

import luenberger as lb
from luenberger import kernels
from luenberger.papers.leondes_novak.derivation import gain_step

# the plant that SLICOT's filter examples share
SLICOT_A = [
    [0.2113, 0.8497, 0.7263, 0.8833],
    [0.7560, 0.6857, 0.1985, 0.6525],
    [0.0002, 0.8782, 0.5442, 0.3076],
    [0.3303, 0.0683, 0.2320, 0.9329],
]

FB01VD = dict(
    P=[
        [0.5015, 0.4368, 0.2693, 0.6325],
        [0.4368, 0.4818, 0.2639, 0.4148],
        [0.2693, 0.2639, 0.1121, 0.6856],
        [0.6325, 0.4148, 0.6856, 0.8906],
    ],
    B=[
        [0.0437, 0.7783, 0.5618],
        [0.4818, 0.2119, 0.5896],
        [0.2639, 0.1121, 0.6853],
        [0.4148, 0.6856, 0.8906],
    ],
    Q=[[0.9329, 0.2146, 0.3126], [0.2146, 0.2922, 0.5664], [0.3126, 0.5664, 0.5935]],
    C=[[0.3873, 0.9488, 0.3760, 0.0881], [0.9222, 0.3435, 0.7340, 0.4498]],
)


def filtered(plant, P_pred, K_pred=None):
    """Filter gain and covariance of a predicted covariance, by their definitions."""
    P = np.array(P_pred, dtype=float)
    M = plant.C @ P @ plant.C.T + plant.R
    K = np.linalg.solve(M, plant.C @ P).T
    return K, P - K @ plant.C @ P


def test_slicot_fb01vd_one_recursion():
    """SLICOT FB01VD (SLICOT/SLICOT-Reference, examples/data and results/FB01VD).

    The published P0 and Q are indefinite, so no plant has them; the numbers are run
    through the kernel itself.  Its Sigma is the filtered covariance, so one published
    recursion is the update of the first predicted covariance and half of the next.
    """
    B, Q = np.array(FB01VD["B"]), np.array(FB01VD["Q"])
    A, C, P = np.array(SLICOT_A), np.array(FB01VD["C"]), np.array(FB01VD["P"])
    step, none = kernels.compiled(gain_step), np.zeros((4, 2))
    given = dict(C=C, R=np.eye(2), Gamma=none)
    update = step(A=np.eye(4), Q=np.zeros((4, 4)), Sigma=P, **given)
    after = step(A=A, Q=B @ Q @ B.T, Sigma=update["Sigma_next"], **given)["Omega"]
    gain = [[0.1648, 0.2241], [0.2115, 0.1610], [0.0728, 0.1673], [0.1304, 0.3892]]
    wanted = [
        [1.6007, 1.3283, 1.1153, 1.7177],
        [1.3283, 1.2763, 1.0132, 1.5137],
        [1.1153, 1.0132, 0.8222, 1.2722],
        [1.7177, 1.5137, 1.2722, 2.1562],
    ]
    root = np.array([[1.5091, 1.1543], [0.0, 1.5072]])
    np.testing.assert_allclose(update["K"], gain, rtol=0, atol=1e-4)
    np.testing.assert_allclose(after, wanted, rtol=0, atol=1e-4)
    np.testing.assert_allclose(update["M"], root.T @ root, rtol=0, atol=3e-4)


@pytest.mark.parametrize("which", ["P0", "Q"])
def test_slicot_fb01vd_is_not_a_plant(which):
    """Trap 4: eigenvalues of -0.31 (P0) and -0.14 (Q) are refused by name."""
    noise = dict(Q=np.eye(4), R=np.eye(2), P0=np.eye(4))
    B, Q = np.array(FB01VD["B"]), np.array(FB01VD["Q"])
    noise[which] = FB01VD["P"] if which == "P0" else B @ Q @ B.T
    with pytest.raises(ValueError, match=f"{which} must be positive semi-definite"):
        lb.Plant(SLICOT_A, None, FB01VD["C"], dt=1.0, **noise)


def test_slicot_fb01qd_three_recursions():
    """SLICOT FB01QD (SLICOT/SLICOT-Reference, examples/data and results/FB01QD).

    Three recursions from a predicted covariance of zero; K is the predictor gain
    A K of the last, and only S S' is compared, for its columns have no sign.
    """
    B = np.array([[0.5618, 0.5042], [0.5896, 0.3493], [0.6853, 0.3873]])
    B = np.vstack([B, [0.8906, 0.9222]])
    C = [[0.3616, 0.5664, 0.5015, 0.2693], [0.2922, 0.4826, 0.4368, 0.6325]]
    R = np.array([[0.9488, 0.0], [0.3760, 0.7340]])
    plant = lb.Plant(
        SLICOT_A, None, C, dt=1.0, Q=B @ B.T, R=R @ R.T, P0=np.zeros((4, 4)),
        at_first=True,
    )  # fmt: skip
    observer = lb.kalman_filter(plant, steps=3)
    covariance = lb.error_covariance(observer, plant, steps=3)[3]
    S = np.array(
        [
            [-1.2936, 0.0, 0.0, 0.0],
            [-1.1382, -0.2579, 0.0, 0.0],
            [-0.9622, -0.1529, 0.2974, 0.0],
            [-1.3076, 0.0936, 0.4508, -0.4897],
        ]
    )
    gain = [[0.3638, 0.9469], [0.3532, 0.8179], [0.2471, 0.5542], [0.1982, 0.6471]]
    np.testing.assert_allclose(plant.A @ observer.V[2], gain, rtol=0, atol=3e-4)
    after = plant.A @ covariance @ plant.A.T + plant.Q
    np.testing.assert_allclose(after, S @ S.T, rtol=0, atol=3e-4)


def test_matlab_kalman_filter_design():
    """MathWorks, "Kalman Filter Design": innovation gain M at Q = 2.3, R = 1.

    GNU Octave's pkg-control tests inst/kalman.m with the same A and C.
    """
    G = np.array([[-0.3832], [0.5919], [0.5191]])
    plant = lb.Plant(
        [[1.1269, -0.494, 0.1129], [1, 0, 0], [0, 1, 0]], None, [[1, 0, 0]],
        dt=1.0, Q=2.3 * G @ G.T, R=[[1]],
    )  # fmt: skip
    observer = lb.kalman_filter(plant)
    wanted = [[0.5345], [0.0101], [-0.4776]]
    np.testing.assert_allclose(observer.V, wanted, rtol=0, atol=1e-4)


def test_kfas_local_level_from_a_diffuse_start():
    """R package KFAS, exact diffuse start of a local level.

    statsmodels/statsmodels, statsmodels/tsa/statespace/tests/results/
    results_exact_initial_local_level_R.csv.  A diffuse state is, after y1, N(y1, R);
    from there its second instant is our first.  The diffuse instant adds nothing to
    llf, which is the sum over instants 2 .. 10.
    """
    plant = lb.Plant(
        [[1]], None, [[1]], dt=1.0, Q=[[8.253]], R=[[1.993]], P0=[[1.993]],
        x0=[10.2394],
    )  # fmt: skip
    record = np.ones((9, 1))
    run = lb.Filter(plant).run(record)
    predicted = np.concatenate([plant.P0[None], run.P])[:, 0, 0] + 8.253
    assert predicted[0] == pytest.approx(10.246, rel=1e-10)
    assert predicted[1] == pytest.approx(9.92145967807827, rel=1e-10)
    assert run.x[0, 0] == pytest.approx(2.50454483209413, rel=1e-10)
    F = predicted[:9] + 1.993
    assert F[0] == pytest.approx(12.239, rel=1e-10)
    assert F[1] == pytest.approx(11.9144596780783, rel=1e-10)
    surprise = 1 - np.concatenate([[10.2394], run.x[:8, 0]])
    likelihood = -0.5 * (9 * np.log(2 * np.pi) + np.sum(np.log(F) + surprise**2 / F))
    assert likelihood == pytest.approx(-23.0163218509366, rel=1e-10)


def test_alpha_beta_at_tracking_index_one():
    """Kalata (1984): lambda = 1 gives alpha = 3/4, beta = 1/2 exactly."""
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=[[0.25, 0.5], [0.5, 1]], R=[[1]]
    )
    observer = lb.kalman_filter(plant)
    covariance = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(observer.V, [[0.75], [0.5]], rtol=0, atol=1e-12)
    np.testing.assert_allclose(covariance, [[0.75, 0.5], [0.5, 1]], rtol=0, atol=1e-12)


def test_alpha_beta_of_a_radar():
    """Kalata (1984) in closed form: T = 2, acceleration 0.3, position noise 10.

    r = (4 + lambda - sqrt(8 lambda + lambda^2)) / 4, alpha = 1 - r^2,
    beta = 2 (2 - alpha) - 4 sqrt(1 - alpha), lambda = 0.3 T^2 / 10 = 0.12; the
    numbers are those of W. D. Blair, "Design of nearly constant velocity track
    filters".
    """
    T, index = 2.0, 0.12
    G = np.array([[T**2 / 2], [T]])
    plant = lb.Plant(
        [[1, T], [0, 1]], None, [[1, 0]], dt=T, Q=0.09 * G @ G.T, R=[[100]]
    )
    observer = lb.kalman_filter(plant)
    r = (4 + index - np.sqrt(8 * index + index**2)) / 4
    alpha = 1 - r**2
    beta = 2 * (2 - alpha) - 4 * np.sqrt(1 - alpha)
    assert alpha == pytest.approx(0.38656526238522615, abs=1e-15)
    assert beta / T == pytest.approx(0.046993244784896415, abs=1e-15)
    np.testing.assert_allclose(observer.V, [[alpha], [beta / T]], rtol=0, atol=1e-12)
    wanted = [
        [38.656526238522616, 4.6993244784896415],
        [4.6993244784896415, 1.3006755215103691],
    ]
    np.testing.assert_allclose(lb.error_covariance(observer, plant), wanted, rtol=1e-12)


def shift_register(n):
    return np.eye(n, k=-1)


def petkov():
    V = np.eye(3) - 2 / 3 * np.ones((3, 3))
    return V @ np.diag([0.0, 1.0, 3.0]) @ V


def paper_machine():
    A = np.eye(4, k=1)
    A[0, 0] = 0.9
    return A


DAREX = {
    # name: A, C, Q, R, predicted covariance, predictor gain A K, poles, tolerance
    "1.1 R = 0 (Van Dooren 1981)": (
        [[2, 1], [-1, 0]], [[1, 0]], np.diag([0, 1]), [[0]],
        np.eye(2), [[2], [-1]], [0, 0], 1e-12,
    ),
    "2.1 r = 1 (Laub 1979)": (
        [[4, -4.5], [3, -3.5]], [[1, -1]], [[9, 6], [6, 4]], [[1]],
        (1 + np.sqrt(5)) / 2 * np.array([[9, 6], [6, 4]]),
        [[1.8541019662496847], [1.2360679774997898]], [0.38196601125010515, -0.5], 1e-9,
    ),
    "2.3 eps = 1 (Drake issue 8034)": (
        [[0, 0], [1, 0]], [[0, 1]], np.eye(2), [[1]],
        np.diag([1, 2]), [[0], [0]], [0, 0], 1e-9,
    ),
    "2.4 eps = 1 (Petkov et al. 1989)": (
        petkov(), np.eye(3), np.eye(3), np.eye(3),
        [
            [4.879024985509483, 3.4670023263428864, -1.5274898335881455],
            [3.4670023263428864, 4.6730136559261855, -1.939512492754742],
            [-1.5274898335881455, -1.939512492754742, 2.1757675759606694],
        ],
        [
            [1.4761295103549825, 1.0641068511883842, -0.32604209601089484],
            [1.0641068511883849, 1.270118180771684, -0.738064755177491],
            [-0.32604209601089457, -0.7380647551774909, 0.5750437071720439],
        ],
        [0.3819660112501044, 0.2967425904511854, 0], 1e-9,
    ),
    "2.5 tau = 10 (Pappas et al. 1980)": (
        paper_machine(), [[0.1, 0, 0, 0]], np.diag([0, 0, 0, 1]), [[0.25]],
        np.diag([3.465002340823458, 1, 1, 1]), [[1.0955565959215368], [0], [0], [0]],
        [0.7904443404078463, 0, 0, 0], 1e-6,
    ),
    "4.1 n = 5 (shift register)": (
        shift_register(5), np.eye(5)[4:], np.eye(5), [[1]],
        np.diag([1, 2, 3, 4, 5]), np.zeros((5, 1)), [0] * 5, 1e-9,
    ),
    "4.1 n = 20 (shift register)": (
        shift_register(20), np.eye(20)[19:], np.eye(20), [[1]],
        np.diag(np.arange(1, 21)), np.zeros((20, 1)), [0] * 20, 1e-9,
    ),
}  # fmt: skip


@pytest.mark.parametrize("case", DAREX.values(), ids=DAREX.keys())
def test_darex(case):
    """DAREX (Abels and Benner, SLICOT working note 1999-16), in filter form.

    SLICOT/SLICOT-Reference, src/BB02AD.f and doc/BB02AD.html; the closed forms
    printed there.  Poles of a nilpotent F are compared through its characteristic
    polynomial, since multiple zeros scatter.
    """
    A, C, Q, R, P_pred, gain, poles, tol = case
    plant = lb.Plant(A, None, C, dt=1.0, Q=Q, R=R)
    observer = lb.kalman_filter(plant)
    found = lb.error_covariance(observer, plant)
    scale = np.abs(P_pred).max()
    np.testing.assert_allclose(
        plant.A @ found @ plant.A.T + plant.Q, P_pred, rtol=0, atol=tol * scale
    )
    np.testing.assert_allclose(plant.A @ observer.V, gain, rtol=0, atol=tol * scale)
    np.testing.assert_allclose(
        np.poly(observer.F), np.poly(poles), rtol=0, atol=1e-9 * scale
    )
    K, P = filtered(plant, P_pred)
    np.testing.assert_allclose(observer.V, K, rtol=0, atol=tol * scale)
    np.testing.assert_allclose(found, P, rtol=0, atol=tol * scale)


def test_darex_1_1_needs_one_state_only():
    """DAREX 1.1: the filtered covariance is diag(0, 1), so m1 = 1 loses nothing."""
    plant = lb.Plant(
        [[2, 1], [-1, 0]], None, [[1, 0]], dt=1.0, Q=np.diag([0, 1]), R=[[0]]
    )
    observer = lb.reduced_order_filter(plant, 1)
    assert observer.order == 1
    np.testing.assert_allclose(observer.poles, [0], rtol=0, atol=1e-12)
    covariance = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(covariance, np.diag([0, 1]), rtol=0, atol=1e-12)


@pytest.mark.parametrize("r", [1e-6, 1e-2, 1.0, 1e3, 1e6])
def test_darex_2_1_for_every_r(r):
    """DAREX 2.1: P = (1 + sqrt(1 + 4 r))/2 Q for every r; pole 0.999 at r = 1e6."""
    Q = np.array([[9.0, 6], [6, 4]])
    plant = lb.Plant([[4, -4.5], [3, -3.5]], None, [[1, -1]], dt=1.0, Q=Q, R=[[r]])
    observer = lb.kalman_filter(plant)
    P = plant.A @ lb.error_covariance(observer, plant) @ plant.A.T + plant.Q
    wanted = (1 + np.sqrt(1 + 4 * r)) / 2 * Q
    np.testing.assert_allclose(P, wanted, rtol=1e-9)


@pytest.mark.parametrize("q, T", [(1.0, 1.0), (3.0, 0.25), (1e-8, 10.0), (1e8, 1e-3)])
@pytest.mark.parametrize("m1", [0, 1])
def test_double_integrator_with_exact_position(q, T, m1):
    """White acceleration, exact position (spectral factor of the cubic B-spline).

    P22 = q T sqrt(3)/6, K = [1, (3 - sqrt 3)/T], and the minimal-order observer's
    pole is sqrt(3) - 2, for any q and T; the order-2 filter has the same K.
    """
    Q = q * np.array([[T**3 / 3, T**2 / 2], [T**2 / 2, T]])
    plant = lb.Plant([[1, T], [0, 1]], None, [[1, 0]], dt=T, Q=Q, R=[[0]])
    observer = lb.reduced_order_filter(plant, m1)
    gain = [[1], [(3 - np.sqrt(3)) / T]]
    np.testing.assert_allclose(observer.V, gain, rtol=1e-12)
    assert np.min(np.abs(observer.poles - (np.sqrt(3) - 2))) < 1e-12
    covariance = lb.error_covariance(observer, plant)
    size = q * T * np.sqrt(3) / 6
    assert covariance[1, 1] == pytest.approx(size, rel=1e-12)
    others = [covariance[0, 0] / T**2, covariance[0, 1] / T]
    np.testing.assert_allclose(others, 0, rtol=0, atol=1e-12 * size)


def test_simon_full_order_filter_bounds_every_order():
    """D. Simon, Optimal State Estimation, reduced-order example (full-order values).

    br5555/Kalman-examples, Reduced.m.  The published reduced filters (0.52716 by
    Anderson's formula, 0.48594 the best of order one) have another structure, so for
    us they are bounds: no estimate of x1 is better than the full-order filter's.
    """
    plant = lb.Plant(
        [[0.9, 0.1], [0.2, 0.7]], None, [[0, 1]], dt=1.0, Q=np.diag([0.1, 0]), R=[[1]]
    )
    full = lb.kalman_filter(plant)
    covariance = lb.error_covariance(full, plant)
    assert covariance[0, 0] == pytest.approx(0.48593425, abs=1e-6)
    gain = [[0.1983494], [0.11675053]]
    np.testing.assert_allclose(full.V, gain, rtol=0, atol=1e-6)
    predicted = plant.A @ covariance @ plant.A.T + plant.Q
    assert predicted[0, 0] == pytest.approx(0.53047714, abs=1e-6)
    minimal = lb.reduced_order_filter(plant, 1, horizon="steady")
    assert lb.error_covariance(minimal, plant)[0, 0] > covariance[0, 0]
    assert covariance[0, 0] < 0.48593771387104884 < 0.5271575174808169
