"""The reduced order observer: every kind of plant and poles, published cases."""

import json

import numpy as np
import pytest
import scipy.linalg
import scipy.signal
from pairs import characteristic, conjugates, hidden_chains

import luenberger as lb

METHODS = ("minimum-norm", "back-substitution")


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("kind", ["real", "pairs", "complex", "one multiple pole"])
@pytest.mark.parametrize("dt", [0.0, 0.5])
def test_every_kind_of_plant_and_poles(kind, method, dt):
    A, C, rng = hidden_chains(11, 3, complex_=kind == "complex")
    C = np.vstack([C, C[0] + C[2]])  # one redundant output
    B, E = rng.standard_normal((11, 2)), rng.standard_normal((4, 2))
    shift = 0 if dt else 1
    plant = lb.Plant(A - shift * np.eye(11), B, C, E, dt=dt)
    poles = {
        "real": 0.3 * rng.random(8),
        "pairs": conjugates(8, rng),
        "complex": 0.3 * (rng.random(8) + 1j * rng.standard_normal(8)),
        "one multiple pole": np.full(8, 0.2),
    }[kind] - shift
    observer = lb.reduced_order_observer(plant, poles, method=method)
    assert observer.order == 8 and observer.is_complex == (kind == "complex")
    wanted = poles if kind == "complex" else np.real(poles)
    assert (observer.F.diagonal() == wanted).all()
    if kind != "pairs":
        assert not np.triu(observer.F, 1).any()
        assert (observer.poles == np.sort_complex(poles)).all()
    certificate = lb.certify(observer, plant)
    assert certificate.worst < 1e-14 and certificate.cond < 1e4
    assert certificate.sensitivity.shape == (8,)
    both = np.vstack([observer.T, plant.C])
    assert certificate.cond == pytest.approx(np.linalg.cond(both))


def chains(lengths, order):
    """Output i sees a chain of delays of its own; `order` shuffles the outputs."""
    n, k = sum(lengths), 0
    A, C = 0.3 * np.eye(n), np.zeros((len(lengths), n))
    for i, length in enumerate(lengths):
        A[k : k + length, k : k + length] += np.eye(length, k=1)
        C[i, k] = 1
        k += length
    return A, C[list(order)]


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("order", [(0, 1, 2), (2, 0, 1), (1, 2, 0)], ids=str)
@pytest.mark.parametrize("lengths", [(1, 2, 1), (3, 1, 1), (1, 3, 2), (4, 2, 1)])
def test_outputs_that_do_not_see_the_next_stair(lengths, order, method):
    """The foot of a tall block is zero then, and must not be divided by."""
    A, C = chains(lengths, order)
    rng = np.random.default_rng(1)
    turn = np.linalg.qr(rng.standard_normal(A.shape))[0]
    r = len(A) - 3
    pairs = [x for _ in range(r // 2) for x in (0.1 + 0.2j, 0.1 - 0.2j)]
    for plant in (
        lb.Plant(A, None, C, dt=1.0),
        lb.Plant(turn.T @ A @ turn, None, C @ turn, dt=1.0),
        lb.Plant(A + 0.1j * np.diag(rng.standard_normal(len(A))), None, C, dt=1.0),
    ):
        for poles in (np.linspace(-0.3, 0.4, r), pairs + [0.2] * (r % 2)):
            observer = lb.reduced_order_observer(plant, poles, method=method)
            certificate = lb.certify(observer, plant)
            assert certificate.worst < 1e-13 and certificate.cond < 1e4


def test_trolley_of_notebook_01_by_back_substitution():
    A = [[1, 0.5, 0.125], [0, 1, 0.5], [0, 0, 1]]
    plant = lb.Plant(A, None, [[1, 0, 0], [0, 0, 1]], dt=0.5)
    observer = lb.reduced_order_observer(plant, [0.5], method="back-substitution")
    assert observer.F[0, 0] == 0.5 and lb.certify(observer, plant).worst < 1e-15


def test_the_error_dies_out_as_the_poles_say():
    """A second method: simulate, and compare with e = P F^k eps_0."""
    A, C, rng = hidden_chains(6, 2)
    plant = lb.Plant(A, rng.standard_normal((6, 1)), C, [[0.3], [-0.2]], dt=1.0)
    observer = lb.reduced_order_observer(plant, [0.5, 0.2 + 0.3j, 0.2 - 0.3j, 0.5])
    x0 = rng.standard_normal(6)
    run = lb.simulate(plant, observer, 30, u=1.0, x0=x0)
    eps = observer.z0 - observer.T @ x0
    for k in (0, 1, 5, 30):
        wanted = observer.P @ np.linalg.matrix_power(observer.F, k) @ eps
        assert np.abs(run.error[k] - wanted).max() < 1e-12


@pytest.mark.parametrize("method", METHODS)
@pytest.mark.parametrize("n, p", [(100, 4), (300, 5), (300, 60)])
def test_residual_of_large_well_conditioned_pairs(n, p, method):
    A, C, rng = hidden_chains(n, p)
    plant = lb.Plant(A, None, C, dt=1.0)
    poles = 0.5 * rng.random(n - p) - 0.25
    o = lb.reduced_order_observer(plant, poles, method=method)
    residual = np.linalg.norm(o.T @ A - o.F @ o.T - o.D @ C)
    assert residual < 1e-13 * np.linalg.norm(o.T @ A)
    assert (o.F.diagonal() == poles).all()


def test_all_states_measured_gives_order_zero():
    C = np.array([[1.0, 2.0], [0.0, 1.0], [1.0, 1.0]])
    plant = lb.Plant([[0, 1], [2, 3]], [[1], [1]], C, [[1], [2], [3]])
    observer = lb.reduced_order_observer(plant, [])
    assert observer.order == 0
    assert np.abs(observer.V @ C - np.eye(2)).max() < 1e-15
    assert np.abs(observer.W + observer.V @ plant.E).max() == 0


def test_a_pole_of_the_plant_may_be_a_pole_of_the_observer():
    """Where T A - F T = D C has no unique solution as a Sylvester equation."""
    A, C = np.diag([-1.0, -2.0, -3.0]), [[1.0, 1.0, 1.0]]
    plant = lb.Plant(A, None, C)
    for poles in ([-1, -1], [-2, -3], [-3, -2]):
        observer = lb.reduced_order_observer(plant, poles)
        assert (observer.F.diagonal() == poles).all()


def test_more_equal_poles_than_outputs_where_place_poles_refuses():
    A, C, _ = hidden_chains(5, 2)
    plant = lb.Plant(A, None, C, dt=1.0)
    poles = [0.1, 0.1, 0.1]
    Q = np.roll(scipy.linalg.qr(C.T)[0], 3, axis=1)  # C Q = [0 R]
    dual = (Q.T @ A @ Q).T
    with pytest.raises(ValueError, match="repeated more than rank"):
        scipy.signal.place_poles(dual[:3, :3], dual[:3, 3:], poles)
    observer = lb.reduced_order_observer(plant, poles)
    assert (observer.poles == 0.1).all()


def test_conjugates_apart_are_moved_together_and_the_rest_keeps_its_order():
    A, C, _ = hidden_chains(7, 2)
    plant = lb.Plant(A, None, C, dt=1.0)
    pair = 0.1 + 0.2j
    observer = lb.reduced_order_observer(plant, [0.3, pair, 0.2, pair.conjugate(), 0.1])
    assert observer.F.diagonal().tolist() == [0.3, 0.1, 0.1, 0.2, 0.1]


@pytest.mark.parametrize(
    "poles, error, message",
    [
        ([-1], lb.DesignError, r"1 poles are given.*is 2 .n = 3, rank C = 1.*Give 2"),
        ([-1, -1, -1], lb.DesignError, "3 poles are given"),
        ([-1 + 1j, -2], lb.DesignError, r"pole -1\+1j needs its conjugate -1-1j"),
        ([-1 + 1j, -1 + 1j], lb.DesignError, "needs its conjugate"),
        ([-1, np.nan], ValueError, "finite"),
        ([-1, "a"], ValueError, "list of numbers"),
        ([[-1, -1]], ValueError, "list of finite numbers"),
        ([-1, 1], lb.CertificateError, "stable|pole|Re"),
        ([-1, 0], lb.CertificateError, "stable|pole|Re"),
    ],
)
def test_refused_poles(poles, error, message):
    plant = lb.Plant([[0, 1, 0], [0, 0, 1], [1, 2, 3]], None, [[1, 0, 0]])
    with pytest.raises(error, match=message):
        lb.reduced_order_observer(plant, poles)


def test_refused_methods_and_plants():
    plant = lb.Plant([[0, 1], [1, 2]], None, [[1, 0]])
    with pytest.raises(ValueError, match="method must be one of.*'least'"):
        lb.reduced_order_observer(plant, [-1], method="least")
    varying = lb.Plant([[[0, 1], [1, 2]]] * 3, None, [[1, 0]])
    with pytest.raises(lb.DesignError, match="constant plant.*3 steps"):
        lb.reduced_order_observer(varying, [-1])


def test_a_pair_near_an_unobservable_one_warns_with_the_number_then_is_refused():
    """One output of two modes that are nearly the same, in whatever units."""

    def designed(gap):
        plant = lb.Plant(np.diag([-1, -1 - gap]), None, [[1, 1]])
        return lb.certify(lb.reduced_order_observer(plant, [-5]), plant)

    assert designed(1.0).cond < 40
    with pytest.warns(
        RuntimeWarning, match=r"cond\(\[T; C\]\) = 1\.6e\+10.* 10 digits"
    ):
        assert designed(1e-9).worst < 1e-15
    with pytest.raises(lb.DesignError, match="unobservable one"):
        designed(1e-12)
    with pytest.raises(lb.DesignError, match="not observable: the eigenvalue.*-1 of A"):
        designed(1e-14)


def test_complex_observer_comes_back_from_json(tmp_path):
    A, C, rng = hidden_chains(5, 2, complex_=True)
    plant = lb.Plant(A, None, C, dt=1.0)
    first = lb.reduced_order_observer(plant, [0.1j, 0.2, -0.3j])
    first.to_json(tmp_path / "observer.json")
    assert json.loads((tmp_path / "observer.json").read_text())["F"]["imag"]
    again = lb.Observer.from_json(tmp_path / "observer.json")
    assert lb.certify(again, plant).worst == lb.certify(first, plant).worst


def gain_form(observer, p=1):
    """Ogata's z = x_b - Ke y: Ke, Ahat, Bhat, Fhat from any coordinates of z."""
    M = observer.T[:, p:]
    Ke = -np.linalg.solve(M, observer.T[:, :p])
    return Ke, *(
        np.linalg.solve(M, X) for X in (observer.F @ M, observer.D, observer.G)
    )


@pytest.mark.parametrize("method", METHODS)
def test_ogata_minimum_order_observer(method):
    """Ogata, Modern Control Engineering, 5th ed., 10-7: Ke and the controller."""
    plant = lb.Plant(
        [[0, 1, 0], [0, 0, 1], [0, -24, -10]], [[0], [10], [-80]], [[1, 0, 0]]
    )
    o = lb.reduced_order_observer(plant, [-10, -10], method=method)
    Ke, Ahat, Bhat, Fhat = gain_form(o)
    assert np.abs(Ke.ravel() - [10, -24]).max() < 1e-9
    assert np.abs(Ahat - [[-10, 1], [0, -10]]).max() < 1e-9
    assert np.abs(Bhat.ravel() - [-124, 240]).max() < 1e-9
    assert np.abs(Fhat.ravel() - [10, -80]).max() < 1e-9
    K = np.array([[1.25, 1.25, 0.19375]])
    KP, KV = K @ o.P, K @ o.V
    num, den = scipy.signal.ss2tf(o.F - o.G @ KP, o.D - o.G @ KV, KP, KV)
    assert np.abs(num[0] - [9.1, 73.5, 125]).max() < 1e-9
    assert np.abs(den - [1, 17, -30]).max() < 1e-9
    second = lb.reduced_order_observer(plant, [-4.5, -4.5], method=method)
    assert np.abs(gain_form(second)[0].ravel() - [-1, 6.25]).max() < 1e-9


def test_pendulum_with_a_triple_pole():
    """Ogata's inverted pendulum, observer poles -15 three times; acker's numbers."""
    A = [[0, 0, 0, 1], [0, 0, 20.601, 0], [0, 1, 0, 0], [0, 0, -0.4905, 0]]
    plant = lb.Plant(A, [[0], [-1], [0], [0.5]], [[1, 0, 0, 0]])
    Ke, Ahat, Bhat, Fhat = gain_form(lb.reduced_order_observer(plant, [-15] * 3))
    wanted = [-8770.733944954129, -1418.1467889908256, 45]
    assert np.allclose(Ke.ravel(), wanted, rtol=1e-9)
    assert np.allclose(
        Bhat.ravel(), [365467.78552293574, 55045.871559633015, -1329.399]
    )
    assert np.allclose(Fhat.ravel(), [-1, 0, 0.5], atol=1e-9)


def full_order_gain(A, C, poles):
    """L with eig(A - L C) = poles, from the reduced order observer of x and C x.

    With the state [x; q], q+ = C x, and q measured, T = M [I, -L] and F = A - L C.
    """
    A, C = np.array(A, float), np.array(C, float)
    n, p = A.shape[0], C.shape[0]
    wide = np.block([[A, np.zeros((n, p))], [C, np.zeros((p, p))]])
    plant = lb.Plant(wide, None, np.eye(n + p)[n:])
    observer = lb.reduced_order_observer(plant, poles)
    assert not observer.is_complex
    M = observer.T[:, :n]
    assert np.allclose(np.linalg.solve(M, observer.F @ M), A + np.linalg.solve(
        M, observer.T[:, n:]) @ C, atol=1e-8 * np.abs(A).max())  # fmt: skip
    return -np.linalg.solve(M, observer.T[:, n:])


ASSIGNMENT = {
    "ControlSystems.jl double pole, L = [4, 4]": (
        [[0, 1], [0, 0]], [[1, 0]], [-2, -2], [4, 4], 1e-9,
    ),
    "SLICOT SB01MD quadruple pole, integer gain": (
        np.array([[-1, 0, 2, -3], [1, -4, 3, -1], [0, 2, 4, -5], [0, 0, -1, -2]]).T,
        [[1, 0, 0, 0]], [-1] * 4, [1, 29, 93, -76], 1e-8,
    ),
    "SLICOT SB01BD helicopter": (
        np.array([[-6.8, 0, -207, 0], [1, 0, 0, 0], [43.2, 0, 0, -4.2],
                  [0, 0, 1, 0]]).T,
        np.array([[5.64, 0], [0, 0], [0, 1.18], [0, 0]]).T,
        [-3.3984 + 94.5253j, -3.3984 - 94.5253j, -0.5 + 0.15j, -0.5 - 0.15j], None,
        1e-8,
    ),
    "ControlSystems.jl issue 995": (
        [[0, 1, 0], [0, -1, 1], [0, 0, -20.0]], [[1, 0, 0], [0, 1, 0]],
        [-40, -40.1, -39], None, 1e-8,
    ),
    "Kautsky, Nichols, Van Dooren distillation column": (
        np.array([
            [-0.1094, 0.0628, 0, 0, 0], [1.306, -2.132, 0.9807, 0, 0],
            [0, 1.595, -3.149, 1.547, 0], [0, 0.0355, 2.632, -4.257, 1.855],
            [0, 0.00227, 0, 0.1636, -0.1625],
        ]).T,
        np.array([[0, 0], [0.0638, 0], [0.0838, -0.1396], [0.1004, -0.206],
                  [0.0063, -0.0128]]).T,
        [-0.2, -0.5, -1, -1 + 1j, -1 - 1j], None, 1e-8,
    ),
    "python-control issue 177": (
        [[0, 1], [100, 0]], [[1, 0]], [-20 + 10j, -20 - 10j], [40, 600], 1e-9,
    ),
}  # fmt: skip


@pytest.mark.parametrize("name", ASSIGNMENT)
def test_published_pole_assignment(name):
    """Multiple eigenvalues scatter, so characteristic polynomials are compared."""
    A, C, poles, gain, tol = ASSIGNMENT[name]
    L = full_order_gain(A, C, poles)
    found = np.poly(np.array(A, float) - L @ np.array(C, float))
    wanted = characteristic(poles).real
    assert np.abs(found - wanted).max() < tol * np.abs(wanted).max()
    if gain is not None:
        assert np.abs(L.ravel() - gain).max() < tol * max(np.abs(gain))


def test_issue_995_as_a_reduced_observer():
    plant = lb.Plant(
        [[0, 1, 0], [0, -1, 1], [0, 0, -20.0]], None, [[1, 0, 0], [0, 1, 0]]
    )
    observer = lb.reduced_order_observer(plant, [-40])
    assert observer.F[0, 0] == -40 and lb.certify(observer, plant).worst < 1e-15
