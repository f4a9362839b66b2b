"""What a record can tell of the noises, held against the map to autocovariances."""

from fractions import Fraction

import numpy as np
import pytest
import scipy.linalg
import sympy as sp
from sympy.polys.matrices import DomainMatrix

import luenberger as lb
from luenberger.identification.forms import form_of
from luenberger.identification.identifiability import identifiability

POSITION = [[1, 1], [0, 1]], None, [[1, 0]]


def exact_rank(A, C, parts, gain):
    """The rank of the map to the autocovariances, in rational arithmetic.

    Mehra's: solve P = A_L P A_L' + W entry by entry, and stack C P C' + R and the lags.
    """
    A, C, L = sp.Matrix(A), sp.Matrix(C), sp.Matrix(gain)
    n, A_L = A.rows, A - L * C
    kron = sp.eye(n * n) - sp.kronecker_product(A_L, A_L)
    Ws = [list(Q - S * L.T - L * S.T + L * R * L.T) for Q, R, S in parts]
    solved = fractions(kron).lu_solve(fractions(Ws).transpose()).to_Matrix()
    rows = []
    for k, (_, R, S) in enumerate(parts):
        P = solved[:, k].reshape(n, n)
        found, N = list(C * P * C.T + R), A_L * P * C.T + S - L * R
        for _ in range(n + 1):
            found, N = found + list(C * N), A_L * N
        rows.append(found)
    return fractions(rows).rank()


def fractions(X):
    """A matrix that is solved and ranked faster than SymPy's own."""
    return DomainMatrix.from_Matrix(sp.Matrix(X)).convert_to(sp.QQ)


def parts_of(n, p, Q, R, S):
    """What each unknown adds, as exact (Q, R, S)."""
    none = sp.zeros(n, n), sp.zeros(p, p), sp.zeros(n, p)
    for place, letter, wanted, size in ((0, "Q", Q, n), (1, "R", R, p)):
        for X in form_of(letter, wanted, size, np.eye(size), None, None).parts:
            yield tuple(
                sp.Matrix(X.astype(int)) if k == place else none[k] for k in range(3)
            )
    for k in range(n * p if S == "full" else 0):
        yield (*none[:2], sp.Matrix(np.eye(n * p, dtype=int)[k].reshape(n, p)))


def drawn(seed):
    """A plant of small whole numbers, often with zeros, and what is unknown of it."""
    rng = np.random.default_rng(seed)
    n, p = rng.integers(1, 4), rng.integers(1, 3)
    A = rng.integers(-2, 3, (n, n)) * rng.integers(0, 2, (n, n))
    A = A * Fraction(1 if seed % 3 else 3, 7)  # some are unstable
    C = rng.integers(-1, 2, (p, n))
    forms = ["full", "diagonal", None]
    choice = dict(Q=forms[rng.integers(2)], R=forms[rng.integers(3)])
    return A, C, choice | dict(S=[0, "full"][rng.integers(2)]), rng


@pytest.mark.parametrize("seed", range(60))
def test_the_count_is_the_rank_of_mehras_map(seed):
    A, C, unknown, rng = drawn(seed)
    n, p = len(A), len(C)
    gain = [[Fraction(int(k), 11) for k in row] for row in rng.integers(-9, 9, (n, p))]
    plant = lb.Plant(A, None, C, dt=1.0, R=np.eye(p))
    found = identifiability(plant, **unknown)
    wanted = exact_rank(A, C, list(parts_of(n, p, **unknown)), gain)
    assert found.determined == wanted
    assert len(found.sentences) == len(found.unknown) - wanted


def rank_of_records(steps, C, seen, parts):
    """Ranks of the map to the covariances of all readings, less that of the start's.

    The start's covariance is unknown too.  `steps` moves row k to row k + 1.
    """
    rows, n = len(seen), C.shape[-1]
    none = np.zeros((n, n), dtype=int), np.zeros((len(C[0]), len(C[0])), dtype=int)
    triangle = zip(*np.triu_indices(n))
    starts = []
    for i, j in triangle:
        X = none[0].copy()
        X[i, j] = X[j, i] = 1
        starts.append(X)
    changes = [np.array(X.tolist(), dtype=object) for part in parts for X in part]
    changes = [tuple(changes[k : k + 3]) for k in range(0, len(changes), 3)]
    zero_S = np.zeros((n, len(C[0])), dtype=int)
    columns = [(X, none[0], none[1], zero_S) for X in starts]
    columns += [(none[0], *one) for one in changes]
    table = []
    for X, Q, R, S in columns:
        found = []
        for k in range(rows):
            here = C[k][seen[k]]
            found += list((here @ X @ here.T + R[seen[k]][:, seen[k]]).ravel())
            N = (steps[k] @ X @ here.T) + S[:, seen[k]]
            for later in range(k + 1, rows):
                found += list((C[later][seen[later]] @ N).ravel())
                N = steps[later] @ N
            X = steps[k] @ X @ steps[k].T + Q
        table.append(found)
    whole = fractions(table).rank()
    return whole - fractions(table[: len(starts)]).rank()


@pytest.mark.parametrize("seed", range(40))
def test_the_count_is_the_rank_of_the_covariances_of_a_record(seed):
    """Of plants that vary, that hide what they move, and of records with gaps."""
    rng = np.random.default_rng(seed)
    n, p, rows = rng.integers(1, 4), rng.integers(1, 3), rng.integers(3, 8)
    varies, gaps = [(True, False), (False, True), (True, True)][seed % 3]
    A = rng.integers(-1, 2, (rows + 1, n, n)) * rng.integers(0, 2, (n, n))
    C = rng.integers(-1, 2, (rows + 1, p, n)) * rng.integers(0, 2, (p, n))
    if not varies:
        A[:], C[:] = A[0], C[0]
    A = A * Fraction(1, 2)
    seen = rng.random((rows, p)) < (0.6 if gaps else 1.0)
    seen[rng.integers(rows), rng.integers(p)] = not gaps
    unknown = dict(
        Q=["full", "diagonal"][seed % 2], R="full", S=[0, "full"][seed % 4 > 1]
    )
    given = (A, None, C) if varies else (A[0], None, C[0])
    plant = lb.Plant(*given, dt=1.0, R=np.eye(p))
    found = identifiability(plant, **unknown, seen=seen)
    wanted = rank_of_records(A[1:], C[1:], seen, list(parts_of(n, p, **unknown)))
    assert found.determined == wanted


@pytest.mark.parametrize("seed", range(12))
def test_units_decide_nothing(seed):
    A, C, unknown, rng = drawn(seed)
    x, y = (2.0 ** rng.integers(-40, 41, k) for k in (len(A), len(C)))
    plant = lb.Plant(A, None, C, dt=1.0, R=np.eye(len(C)))
    other = lb.Plant(
        A / x[:, None] * x, None, C / y[:, None] * x, dt=1.0, R=np.eye(len(C))
    )
    found, again = (identifiability(one, **unknown) for one in (plant, other))
    assert again.determined == found.determined


@pytest.mark.parametrize("seed", range(6))
def test_a_silent_change_leaves_no_trace(seed):
    """Not even in the likelihood of a record: its exact covariance is the same."""
    rng = np.random.default_rng(seed)
    A, C = rng.normal(size=(3, 3)), rng.normal(size=(1, 3))
    plant = lb.Plant(A, None, C, dt=1.0)
    directions = identifiability(plant).directions
    assert len(directions) == 3  # X with A X C' = 0: a symmetric one of two columns
    P = scipy.linalg.solve_discrete_are(A.T, C.T, np.eye(3), [[1]])
    L = A @ P @ C.T / (C @ P @ C.T + 1)
    A_L = A - L @ C
    for one in directions:
        W = one["Q"] - one["S"] @ L.T - L @ one["S"].T + L @ one["R"] @ L.T
        P = sum(
            np.linalg.matrix_power(A_L, k) @ W @ np.linalg.matrix_power(A_L, k).T
            for k in range(400)
        )
        assert abs(C @ P @ C.T + one["R"]).max() < 1e-9
        assert abs(A_L @ P @ C.T + one["S"] - L @ one["R"]).max() < 1e-9


@pytest.mark.parametrize(
    ("given", "unknown", "said"),
    [
        (
            ([[0]], None, [[1]]),
            {},
            ["Q[0,0] and R[0,0] apart, but only the sum Q[0,0] + R[0,0]."],
        ),
        (
            POSITION,
            {},
            ["Q[0,0] and Q[0,1] apart, but only the difference Q[0,0] - Q[0,1]."],
        ),
        (POSITION, dict(Q="diagonal"), []),
        (POSITION, dict(Q=[[0.5], [1]]), []),
        (
            ([[0.5, 0], [0, 0.25]], None, [[1, 0]]),
            dict(Q="diagonal"),
            ["Q[1,1], which leaves no trace in the outputs."],
        ),
        (
            ([[2, 2], [0, 2]], None, [[1, 0]]),
            {},
            [
                "Q[0,0], Q[0,1] and Q[1,1] apart, which may change together as "
                "1 : 1 : 0.75."
            ],
        ),
    ],
)
def test_it_is_said_in_words(given, unknown, said):
    plant = lb.Plant(*given, dt=1.0)
    assert list(identifiability(plant, **unknown).sentences) == said


@pytest.mark.parametrize("turn", [1.0, 2.0, 0.25])
def test_a_plant_that_varies_is_judged_by_all_its_instants(turn):
    """Constant in disguise, and one whose change of speed tells what was hidden."""
    A, C = turn * np.array(POSITION[0]), POSITION[2]
    constant = identifiability(lb.Plant(A, None, C, dt=1.0))
    steps = A * np.ones((40, 1, 1))
    found = identifiability(lb.Plant(steps, None, C, dt=1.0))
    assert found.sentences == constant.sentences != ()
    steps[::3, 0, 1] *= 2
    assert identifiability(lb.Plant(steps, None, C, dt=1.0)).sentences == ()


def test_outputs_that_never_meet_do_not_tell_their_correlation():
    plant = lb.Plant([[0.5, 0], [0.3, 0.2]], None, np.eye(2), dt=1.0)
    seen = np.ones((50, 2), dtype=bool)
    seen[::2, 0] = seen[1::2, 1] = False
    assert identifiability(plant).sentences == ()
    found = identifiability(plant, seen=seen)
    assert found.sentences == ("R[0,1], which leaves no trace in the outputs.",)
    with pytest.raises(lb.DesignError, match=r"no record of this plant.*R\[0,1\]"):
        found.require()


@pytest.mark.parametrize("meet", [70, 300])
def test_outputs_that_meet_late_tell_it_then(meet):
    plant = lb.Plant([[0.5, 0], [0.3, 0.2]], None, np.eye(2), dt=1.0)
    seen = np.ones((400, 2), dtype=bool)
    seen[::2, 0] = seen[1::2, 1] = False
    seen[meet : meet + 6] = True
    assert identifiability(plant, seen=seen).sentences == ()
    assert identifiability(plant, seen=seen[:meet]).sentences != ()


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        (dict(Q="round"), "Q must be 'full'"),
        (dict(R=None), "it has none"),
        (dict(Q=[[1, 0], [1, 0]]), "column 1 of the matrix G of Q is zero"),
        (dict(Q=np.diag), "function of positive numbers"),
        (dict(S="some"), "S must be 0"),
    ],
)
def test_what_is_no_form_is_refused(wrong, said):
    with pytest.raises(ValueError, match=said):
        identifiability(lb.Plant(*POSITION, dt=1.0), **wrong)
