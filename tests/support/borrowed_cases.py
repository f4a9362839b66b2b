"""Test cases of other programs, by name: their matrices, for tests in our own words.

Riccati equations: scipy/linalg/tests/test_solvers.py of SciPy 1.17, classes
TestSolveDiscreteAre and TestSolveContinuousAre; control/tests/mateqn_test.py and
stochsys_test.py of python-control 0.10.  Most of SciPy's are from P. Benner, A. Laub,
V. Mehrmann, A Collection of Benchmark Examples for the Numerical Solution of Algebraic
Riccati Equations, I and II, TU Chemnitz-Zwickau, SPC 95_22 and 95_23 (1995): carex and
darex.  Those with more than nine states are left out, or made shorter.

Pole placement: scipy/signal/tests/test_ltisys.py (TestPlacePoles) and
control/tests/statefbk_test.py (testPlace, testPlace_varga_*).

All of them are control problems (A, B); A' and B' make them observer problems.
"""

import numpy as np
from scipy.linalg import block_diag


def array(*rows):
    return np.array(rows, dtype=float)


# (A, B, Q, R) of A'XA - X - A'XB (R + B'XB)^-1 B'XA + Q = 0
DISCRETE = {
    "SciPy gh-2251": (
        array([0.63399379, 0.54906824, 0.76253406], [0.5404729, 0.53745766, 0.08731853],
              [0.27524045, 0.84922129, 0.4681622]),
        array([0.96861695], [0.05532739], [0.78934047]), np.eye(3), np.eye(1),
    ),
    "darex 1": (
        array([4, 3], [-4.5, -3.5]), array([1], [-1]), array([9, 6], [6, 4]), np.eye(1),
    ),
    "darex 2": (
        np.diag([0.9512, 0.9048]), array([4.877, 4.877], [-1.1895, 3.569]),
        np.diag([0.005, 0.02]), np.diag([1 / 3, 3]),
    ),
    "darex 3": (
        array([2, -1], [1, 0]), array([1], [0]), np.diag([0, 1]), array([0]),
    ),
    "darex 5": (
        array([0, 1], [0, 0]), array([0], [1]), array([1, 2], [2, 4]), np.eye(1),
    ),
    "darex 6": (
        array([0.998, 0.067, 0, 0], [-0.067, 0.998, 0, 0], [0, 0, 0.998, 0.153],
              [0, 0, -0.153, 0.998]),
        array([0.0033, 0.02], [0.1, -0.0007], [0.04, 0.0073], [-0.0028, 0.1]),
        array([1.87, 0, 0, -0.244], [0, 0.744, 0.205, 0], [0, 0.205, 0.589, 0],
              [-0.244, 0, 0, 1.048]),
        np.eye(2),
    ),
    "darex 7": (
        array([0.98475, -0.079903, 0.0009054, -0.0010765],
              [0.041588, 0.99899, -0.035855, 0.012684],
              [-0.54662, 0.044916, -0.32991, 0.19318],
              [2.6624, -0.10045, -0.92455, -0.26325]),
        array([0.0037112, 0.0007361], [-0.087051, 9.3411e-6], [-1.19844, -4.1378e-4],
              [-3.1927, 9.2535e-4]),
        0.01 * np.eye(4), np.eye(2),
    ),
    "darex 8": (
        array([-0.6, -2.2, -3.6, -5.400018], [1, 0.6, 0.8, 3.399982],
              [0, 1, 1.8, 3.799982], [0, 0, 0, -0.999982]),
        array([1, -1, -1, -1], [0, 1, -1, -1], [0, 0, 1, -1], [0, 0, 0, 1]),
        array([2, 1, 3, 6], [1, 2, 2, 5], [3, 2, 6, 11], [6, 5, 11, 22]), np.eye(4),
    ),
    "darex 9": (
        array([95.407, 1.9643, 0.3597, 0.0673, 0.019],
              [40.849, 41.317, 16.084, 4.4679, 1.1971],
              [12.217, 26.326, 36.149, 15.93, 12.383],
              [4.1118, 12.858, 27.209, 21.442, 40.976],
              [0.1305, 0.5808, 1.875, 3.6162, 94.28]) / 100,
        array([0.0434, -0.0122], [2.6606, -1.0453], [3.753, -5.51], [3.6076, -6.6],
              [0.4617, -0.9148]) / 100,
        np.eye(5), np.eye(2),
    ),
    "darex 10": (
        np.kron(np.eye(2), np.diag([1, 1], k=1)),
        np.kron(np.eye(2), array([0], [0], [1])),
        block_diag(np.ones((2, 2)), 0, array([1, -1], [-1, 1]), 0), np.diag([3.0, 1]),
    ),
    "darex 11": (
        array([870.1, 135, 11.59, 0.5014, -37.22, 0.3484, 0, 4.242, 7.249],
              [76.55, 897.4, 12.72, 0.5504, -40.16, 0.3743, 0, 4.53, 7.499],
              [-127.2, 357.5, 817, 1.455, -102.8, 0.987, 0, 11.85, 18.72],
              [-363.5, 633.9, 74.91, 796.6, -273.5, 2.653, 0, 31.72, 48.82],
              [-960, 1645.9, -128.9, -5.597, 71.42, 7.108, 0, 84.52, 125.9],
              [-664.4, 112.96, -88.89, -3.854, 84.47, 13.6, 0, 144.3, 101.6],
              [-410.2, 693, -54.71, -2.371, 66.49, 12.49, 0.1063, 99.97, 69.67],
              [-179.9, 301.7, -23.93, -1.035, 60.59, 22.16, 0, 213.9, 35.54],
              [-345.1, 580.4, -45.96, -1.989, 105.6, 19.86, 0, 219.1, 215.2]) / 1000,
        array([4.76, -0.5701, -83.68], [0.879, -4.773, -2.73], [1.482, -13.12, 8.876],
              [3.892, -35.13, 24.8], [10.34, -92.75, 66.8], [7.203, -61.59, 38.34],
              [4.454, -36.83, 20.29], [1.971, -15.54, 6.937],
              [3.773, -30.28, 14.69]) / 1000,
        np.diag([50.0, 0, 0, 0, 50, 0, 0, 0, 0]), np.eye(3),
    ),
    "darex 12": (array([0, 1e6], [0, 0]), array([0], [1]), np.eye(2), np.eye(1)),
    "darex 13": (
        array([16, 10, -2], [10, 13, -8], [-2, -8, 7]) / 9, np.eye(3), 1e6 * np.eye(3),
        1e6 * np.eye(3),
    ),
    "darex 14": (
        array([1 - 1e-8, 0, 0, 0], [1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0]),
        array([1e-8], [0], [0], [0]), np.diag([0.0, 0, 0, 1]), array([0.25]),
    ),
    "darex 15, n = 9": (np.eye(9, k=1), np.eye(9)[:, 8:], np.eye(9), np.eye(1)),
    "control DLQE": (array([0]), array([1]), array([0.1]), array([2])),
}  # fmt: skip

# (A, B, Q, R), and what is said of it
NOT_COVARIANCES = {
    "SciPy, complex A": (
        np.array([[2, 1 - 2j], [0, -3j]]), array([0], [1]), np.diag([1, 2]), np.eye(1),
        "the plant is complex",
    ),
    "SciPy, complex B": (
        array([2, 1], [0, -1]), np.array([[-2j], [1j]]), np.diag([1, 2]), np.eye(1),
        "the plant is complex",
    ),
    "SciPy, complex Q": (
        array([3, 1], [0, -1]), array([1, 2], [1, 3]),
        np.array([[1, 1 + 1j], [1 - 1j, 2]]),
        np.array([[2, -2j], [2j, 3]]), "Q.*complex",
    ),
    "darex 4": (
        array([0, 1], [0, -1]), array([1, 0], [2, 1]), array([-4, -4], [-4, 7]) / 11,
        array([9, 3], [3, 1]), "Q must be positive semi-definite",
    ),
    "carex 11": (
        array([3, 1], [4, 2]), array([1], [1]), array([-11, -5], [-5, -2]), np.eye(1),
        "Q must be positive semi-definite",
    ),
    "SciPy infeasible": (
        array([1, -1, 1], [0, 1, 1], [0, 0, 1]), array([1, 0], [1, 0], [0, 1]),
        np.full((3, 3), -2) + np.diag([8, -1, -1.9]), np.diag([-10, 0.1]),
        "must be positive semi-definite",
    ),
    "control dare, first": (
        array([-0.6, 0], [-0.1, -0.4]), array([2, 1], [0, 1]), array([2, 1], [1, 0]),
        np.eye(2), "Q must be positive semi-definite",
    ),
    "control dare, second": (
        array([1, 0], [-1, 1]), array([1], [0]), array([0, 1], [1, 1]), array([2]),
        "Q must be positive semi-definite",
    ),
}  # fmt: skip


def _carex_5():
    A = array(
        [-4.019, 5.12, 0, 0, -2.082, 0, 0, 0, 0.87],
        [-0.346, 0.986, 0, 0, -2.34, 0, 0, 0, 0.97],
        [-7.909, 15.407, -4.069, 0, -6.45, 0, 0, 0, 2.68],
        [-21.816, 35.606, -0.339, -3.87, -17.8, 0, 0, 0, 7.39],
        [-60.196, 98.188, -7.907, 0.34, -53.008, 0, 0, 0, 20.4],
        [0, 0, 0, 0, 94, -147.2, 0, 53.2, 0],
        [0, 0, 0, 0, 0, 94, -147.2, 0, 0],
        [0, 0, 0, 0, 0, 12.8, 0, -31.6, 0],
        [0, 0, 0, 0, 12.8, 0, 0, 18.8, -31.6],
    )
    B = np.zeros((9, 3))
    B[:5] = [[0.01, -0.011, -0.151], [0.003, -0.021, 0], [0.009, -0.059, 0],
             [0.024, -0.162, 0], [0.068, -0.445, 0]]  # fmt: skip
    return A, B, np.eye(9), np.eye(3)


def _carex_4():
    A = np.diag([-0.991, -1.051, -1.118, -1.548, -1.64, -1.721, -1.823, -1.943])
    A += np.diag([0.529, 0.596, 0.596, 0.718, 0.799, 0.901, 1.021], k=1)
    A += np.diag([0.522, 0.522, 0.522, 0.922, 0.922, 0.922, 0.922], k=-1)
    B = (
        array(
            [3.84, 4, 37.6, 3.08, 2.36, 2.88, 3.08, 3],
            [-2.88, -3.04, -2.8, -2.32, -3.32, -3.82, -4.12, -3.96],
        ).T
        / 1000
    )
    Q = np.diag([1.0, 1, 1, 1, 0.1, 0.1, 0.1, 0.1])
    for i, j, value in ((0, 4, 0.5), (0, 7, 0.1), (1, 4, 0.1), (2, 5, 0.5)):
        Q[i, j] = Q[j, i] = value
    return A, B, Q, np.eye(2)


_MIRROR = array([1, -2, -2], [-2, 1, -2], [-2, -2, 1]) / 3

# (A, B, Q, R) of A'X + XA - XB R^-1 B'X + Q = 0
CONTINUOUS = {
    "carex 1": (np.eye(2, k=1), array([0], [1]), np.diag([1.0, 2]), np.eye(1)),
    "carex 2": (
        array([4, 3], [-4.5, -3.5]), array([1], [-1]), array([9, 6], [6, 4]), np.eye(1),
    ),
    "carex 3": (
        array([0, 1, 0, 0], [0, -1.89, 0.39, -5.53], [0, -0.034, -2.98, 2.43],
              [0.034, -0.0011, -0.99, -0.21]),
        array([0, 0], [0.36, -1.6], [-0.95, -0.032], [0.03, 0]),
        array([2.313, 2.727, 0.688, 0.023], [2.727, 4.271, 1.148, 0.323],
              [0.688, 1.148, 0.313, 0.102], [0.023, 0.323, 0.102, 0.083]),
        np.eye(2),
    ),
    "carex 4": _carex_4(),
    "carex 5": _carex_5(),
    "carex 7": (np.diag([1.0, -2]), array([1e-6], [0]), np.ones((2, 2)), np.eye(1)),
    "carex 8": (
        np.diag([-0.1, -0.02]), array([0.1, 0], [0.001, 0.01]),
        array([100, 1000], [1000, 10000]), np.ones((2, 2)) + np.diag([1e-6, 0]),
    ),
    "carex 9": (array([0, 1e6], [0, 0]), array([0], [1]), np.eye(2), np.eye(1)),
    "carex 10": (
        array([1.0000001, 1], [1, 1.0000001]), np.eye(2), np.eye(2), np.eye(2),
    ),
    "carex 12": (
        1e6 * array([7, 2, 0], [2, 6, -2], [0, -2, 5]) / 3, np.eye(3),
        _MIRROR @ np.diag([1e-6, 1, 1e6]) @ _MIRROR, 1e6 * np.eye(3),
    ),
    "carex 13": (
        array([0, 0.4, 0, 0], [0, 0, 0.345, 0], [0, -0.524e6, -0.465e6, 0.262e6],
              [0, 0, 0, -1e6]),
        array([0], [0], [0], [1e6]), np.diag([1.0, 0, 1, 0]), np.eye(1),
    ),
    "carex 14": (
        array([-1e-6, 1, 0, 0], [-1, -1e-6, 0, 0], [0, 0, 1e-6, 1], [0, 0, -1, 1e-6]),
        np.ones((4, 1)), np.ones((4, 4)), np.eye(1),
    ),
    "carex 17, n = 9": (
        np.eye(9, k=1), np.eye(9)[:, 8:], np.diag([1.0] + [0] * 8), np.eye(1),
    ),
    "control care": (
        array([-2, -1], [-1, -1]), array([1, 0], [0, 4]), np.diag([0.0, 1]), np.eye(2),
    ),
    "control LQE": (array([0]), array([1]), array([0.1]), array([2])),
}  # fmt: skip

_FOUR = array(
    [1.38, -0.2077, 6.715, -5.676],
    [-0.5814, -4.29, 0, 0.675],
    [1.067, 4.273, -6.654, 5.893],
    [0.048, 4.273, 1.343, -2.104],
)
_CAR = np.zeros((4, 4))
_CAR[0, 1], _CAR[1, 3] = 7, 7 / 3
_SIX = array(
    [-2148, -2902, -2267, -598, -1722, -1829], [-165, -283, -2546, -167, -754, -2285],
    [-543, -1700, -584, -2978, -925, -1300], [-1583, -984, -386, -2650, -764, -897],
    [-517, -1598, 2, -1709, -291, -338], [-153, -1804, -1106, -1168, -867, -2297],
)  # fmt: skip
_SIX_INPUTS = array(
    [-108, -374, -524, -1285, -1232], [-161, -1204, -672, -637, -15],
    [-483, -23, -931, -780, -1245], [-1129, -1290, -1502, -952, -1374],
    [-62, -964, -930, -939, -792], [-756, -1437, -491, -1543, -686],
)  # fmt: skip
_BIG = np.ones((11, 11)) - np.eye(11)
_BIG[:6, :6] = _SIX
_BIG_INPUTS = np.ones((11, 10)) - np.eye(11, 10)
_BIG_INPUTS[:6, :5] = _SIX_INPUTS
_FIVE = np.zeros((5, 5))
_FIVE[0, 1], _FIVE[1, 3], _FIVE[3, 4], _FIVE[4, 4] = 7, 7 / 3, 5, 9
_FIVE_INPUTS = array([0, 0], [0, 0], [1, 0], [0, 1], [2, 3])
_PAIRS = [-10 + 10j, -20 + 20j, -30 + 30j, -40 + 40j, -50 + 50j]
_FOUR_INPUTS = array([0, 5.679], [1.136, 1.136], [0, 0], [-3.146, 0])
_TRICKY = array([0, 5.679, 1.136, 1.136], [0, 0, -3.146, 0], [1, 2, 3, 4], [5, 6, 7, 8])

# (A, B, all poles of A - B K)
PLACEMENT = {
    "real": (_FOUR, _FOUR_INPUTS, [-0.2, -0.5, -5.0566, -8.6659]),
    "double": (_FOUR, _FOUR_INPUTS, [2, 2, 3, 3]),
    "car": (_CAR, np.eye(4)[:, 2:], [-3, -1, -2 - 1j, -2 + 1j]),
    "car, near zero": (_CAR, np.eye(4)[:, 2:], [-1e-6j, 1e-6j, -10, 10]),
    "two null vectors": (
        _SIX, _SIX_INPUTS,
        [-25 - 29j, -25 + 29j, 31 - 42j, 31 + 42j, 33 - 41j, 33 + 41j],
    ),
    "eleven": (
        _BIG, _BIG_INPUTS,
        [-10, -20, -30, 40, 50, 60, 70, -20 - 5j, -20 + 5j, 5 + 3j, 5 - 3j],
    ),
    "ten real": (
        _BIG[:10, :10], _BIG_INPUTS[:10, :9], [-10 * k for k in range(1, 11)],
    ),
    "ten complex": (
        _BIG[:10, :10], _BIG_INPUTS[:10, :9], _PAIRS + [p.conjugate() for p in _PAIRS],
    ),
    "five, one real": (_FIVE, _FIVE_INPUTS, [-2, -3 + 1j, -3 - 1j, -1 + 1j, -1 - 1j]),
    "five, three real": (_FIVE, _FIVE_INPUTS, [-2, -3, -4, -1 + 1j, -1 - 1j]),
    "as many inputs as states": (_FOUR, _TRICKY, [-0.2, -0.5, -5.0566, -8.6659]),
    "as many, complex": (_FOUR, _TRICKY, [-2 + 1j, -2 - 1j, -3, -2]),
    "one input": (_FOUR, _TRICKY[:, :1], [-2 + 1j, -2 - 1j, -3, -2]),
    "control place": (_FOUR, _FOUR_INPUTS, [-0.5 + 1j, -0.5 - 1j, -5.0566, -8.6659]),
    "control, three at one place": (_FOUR, _FOUR_INPUTS, [-0.5, -0.5, -0.5, -8.6659]),
    "control varga": (array([1, -2], [3, -4]), array([5], [7]), [-2, -2]),
    "control gh-177": (
        array([0, 1], [100, 0]), array([0], [1]), [-20 + 10j, -20 - 10j],
    ),
    "control varga, discrete": (np.diag([1, 0.5]), array([5], [7]), [0.5, 0.5]),
}  # fmt: skip
