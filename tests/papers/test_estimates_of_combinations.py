"""Designs that estimate L x: the same observer, with the rows that are asked for."""

from fractions import Fraction

import numpy as np
import pytest

import luenberger as lb
from luenberger.numeric.linalg import complete

L = np.array([[0.0, 2, -1, 0.5], [1, 0, 0, 0], [0, 0, 0, 0]])


def plant(dt=1.0, **given):
    rng = np.random.default_rng(3)
    A, B, C = (rng.standard_normal(size) for size in ((4, 4), (4, 1), (2, 4)))
    A = A * 0.9 / np.abs(np.linalg.eigvals(A)).max() if dt else A
    noise = dict(Q=np.diag([1, 2, 0, 1]), R=np.diag([0.5, 0.1]), P0=np.eye(4))
    return lb.Plant(A, B, C, [[1.0], [0]], dt=dt, **noise | given)


DESIGNS = {
    "Kalman": lambda L=None: lb.kalman_filter(plant(), L=L),
    "perfect sensor": lambda L=None: lb.kalman_filter(plant(R=np.diag([0, 1])), L=L),
    "Leondes-Novak": lambda L=None: lb.reduced_order_filter(plant(), 1, L=L),
    "over steps": lambda L=None: lb.reduced_order_filter(plant(), [1], L=L, steps=6),
    "Van Dooren": lambda L=None: lb.reduced_order_observer(plant(), [0.1, 0.2], L=L),
    "Kawazoe": lambda L=None: lb.deadbeat_observer(plant(), L=L),
}


@pytest.mark.parametrize("name", DESIGNS)
def test_the_rows_of_the_same_observer(name, tmp_path):
    whole, some = DESIGNS[name](), DESIGNS[name](L)
    assert (some.L == L).all() and some.P.shape[-2:] == (3, whole.order)
    assert lb.certify(some, plant()).worst < 1e-13
    for same in "FGDT":
        assert (getattr(some, same) == getattr(whole, same)).all()
    y, u = np.random.default_rng(1).standard_normal((2, 6, 2))
    expected = lb.estimate(whole, lb.Record(y, u[:, :1])) @ L.T
    np.testing.assert_allclose(
        lb.estimate(some, lb.Record(y, u[:, :1])), expected, atol=1e-12
    )
    some.to_json(tmp_path / "some.json")
    again = lb.Observer.from_json(tmp_path / "some.json")
    assert all((getattr(again, X) == getattr(some, X)).all() for X in "FGDPVWTL")
    assert some.steps or lb.export.multiply_adds(some) < lb.export.multiply_adds(whole)
    assert (
        lb.estimate(some, lb.Record(y, u[:, :1]))[:, 2].tolist() == [0] * 6
    )  # 0 x is 0


@pytest.mark.parametrize("name", ["Kalman", "perfect sensor", "Leondes-Novak"])
def test_errors_are_those_of_the_combinations(name):
    on = plant(R=np.diag([0, 1])) if "perfect" in name else plant()
    whole, some = DESIGNS[name](), DESIGNS[name](L)
    left = lb.error_covariance(some, on)
    np.testing.assert_allclose(
        left, L @ lb.error_covariance(whole, on) @ L.T, atol=1e-12
    )
    if not some.steps:
        drawn = lb.monte_carlo(on, some, runs=2000, steps=40, seed=2)
        found = drawn.covariance[-1].diagonal()
        np.testing.assert_allclose(found, left.diagonal(), rtol=0.15, atol=1e-12)


def test_an_output_without_noise_is_estimated_as_it_is_read():
    on = plant(R=np.diag([0, 1]))
    one = lb.kalman_filter(on, L=on.C[0])
    np.testing.assert_allclose(one.V, [[1, 0]], atol=1e-12)
    assert lb.error_covariance(one, on)[0, 0] < 1e-24


@pytest.mark.parametrize("form", ["modal", "companion", "balanced"])
def test_forms_of_what_is_asked_for(form):
    one = lb.kalman_filter(plant(), L=L[0])
    other = getattr(one, form)()
    assert lb.certify(other, plant()).worst < 1e-12
    y = np.random.default_rng(4).standard_normal((9, 2))
    np.testing.assert_allclose(
        lb.estimate(other, y), lb.estimate(one, y),
        atol=1e-9,
    )  # fmt: skip


def steady_error(K, on, weight):
    """tr(weight Sigma) of the gain K by the sum of its series; inf if unstable."""
    Y = np.eye(on.n) - K @ on.C
    F, N = Y @ on.A, Y @ on.Q @ Y.T + K @ on.R @ K.T
    if np.abs(np.linalg.eigvals(F)).max() >= 1:
        return np.inf
    X = np.linalg.solve(np.eye(on.n**2) - np.kron(F, F), N.ravel())
    return np.trace(weight @ X.reshape(N.shape))


def blocks():
    """Two plants that have nothing to do with each other."""
    A = np.zeros((4, 4))
    A[:2, :2], A[2:, 2:] = [[0.9, 0.5], [-0.1, 0.8]], [[0.7, 0.3], [0, 0.6]]
    C = [[1, 0, 0.0, 0], [0, 0, 1, 1]]
    return lb.Plant(A, None, C, dt=1.0, Q=np.eye(4), R=np.diag([1.0, 2]))


@pytest.mark.parametrize("row", [[0, 1, 0, 0], [1, 1, 0, 0], [1, 0, 0, 0]])
@pytest.mark.parametrize("on", [plant(), blocks()], ids=["coupled", "blocks"])
@pytest.mark.parametrize("accurate", [[0], [1], [0, 1]])
def test_the_best_constant_gain_is_best_for_what_is_asked_for(on, accurate, row):
    """No gain beside it that shows the accurate outputs as they are does better."""
    weight = np.outer(row, row)
    made = lb.reduced_order_filter(on, accurate, L=row, horizon="steady")
    K = lb.reduced_order_filter(on, accurate, weight=weight, horizon="steady").V
    least = steady_error(K, on, weight)
    u = None if on.m == 0 else 0
    np.testing.assert_allclose(
        lb.error_covariance(made, on.with_input(u)), least, rtol=1e-9
    )
    whole = lb.reduced_order_filter(on, accurate, horizon="steady").V
    assert least <= steady_error(whole, on, weight) * (1 + 1e-9)
    free = np.linalg.svd(on.C[accurate])[2][len(accurate) :].T
    rng = np.random.default_rng(5)
    for _ in range(40):
        step = free @ rng.standard_normal((free.shape[1], 2))
        beside = steady_error(K + 1e-3 * step, on, weight)
        assert beside >= least * (1 - 1e-9)


def test_where_no_gain_is_best_the_whole_state_may_be_weighed():
    """States that do not count could remember ever more of the others."""
    with pytest.raises(lb.CertificateError, match=r"weight=numpy.eye\(n\)"):
        lb.reduced_order_filter(blocks(), [1], L=[0, 1, 0, 1], horizon="steady")
    given = dict(L=[0, 1, 0, 1], weight=np.eye(4), horizon="steady")
    made = lb.reduced_order_filter(blocks(), [1], **given)
    assert lb.error_covariance(made, blocks())[0, 0] < 3.2


def test_the_step_wise_gain_weighs_the_whole_state():
    with pytest.raises(lb.DesignError, match="weight must be positive definite"):
        lb.reduced_order_filter(plant(), 1, weight=np.diag([1, 0, 0, 0]))
    whole = lb.reduced_order_filter(plant(), 1)
    some = lb.reduced_order_filter(plant(), 1, L=L)
    np.testing.assert_allclose(some.V, L @ whole.V, atol=1e-14)


@pytest.mark.parametrize("rank", [1, 2, 3])
def test_a_push_of_least_weight_for_a_singular_weight(rank):
    rng = np.random.default_rng(rank)
    C1, rows = rng.standard_normal((2, 4)), rng.standard_normal((rank, 4))
    Phat, Gamma, _ = complete(C1, rows.T @ rows)
    np.testing.assert_allclose(C1 @ Gamma, np.eye(2), atol=1e-12)
    np.testing.assert_allclose(Phat.T @ rows.T @ rows @ Gamma, 0, atol=1e-11)


HIDDEN = lb.Plant(
    [[0.5, 0, 0], [0, 1.2, 0], [0.1, 0, 0.0]], None, [[1, 0, 0]], dt=1.0,
    Q=np.eye(3), R=[[1]],
)  # fmt: skip
STATE = {
    "Kalman": lambda L: lb.kalman_filter(HIDDEN, L=L),
    "best constant": lambda L: lb.reduced_order_filter(
        HIDDEN, 1, L=L, horizon="steady"
    ),
    "Kawazoe": lambda L: lb.deadbeat_observer(HIDDEN, L=L),
}


@pytest.mark.parametrize("name", STATE)
def test_what_needs_no_hidden_mode_is_sent_to_the_functional_observer(name):
    with pytest.raises(lb.DesignError, match=r"1\.2.*functional_observer\(plant, L\)"):
        STATE[name]([1, 0, 1])
    assert lb.certify(lb.functional_observer(HIDDEN, [1, 0, 1]), HIDDEN).stable
    with pytest.raises(lb.DesignError) as refused:
        STATE[name]([1, 1, 0])
    assert "functional_observer" not in str(refused.value)


@pytest.mark.parametrize(
    "rows, message",
    [
        ([1, 0], "L must be 1 x 4, got 1 x 2"),
        (np.zeros((0, 4)), "L has no rows"),
        ([[1, 0, np.nan, 0]], "L has entries that are not finite"),
        (np.zeros((2, 2, 4)), "L must be a matrix"),
    ],
)
@pytest.mark.parametrize("name", ["Kalman", "over steps", "Van Dooren"])
def test_what_is_no_combination_is_refused(name, rows, message):
    with pytest.raises(ValueError, match=message):
        DESIGNS[name](rows)


def test_combinations_of_an_exact_observer_are_exact():
    cart = lb.Plant([[0, 1, 0], [0, 0, 1], [0, 0, 0]], [[0], [0], [1]], [[1, 0, 0]])
    one = lb.functional_observer(cart, [2, 3, -1])
    third = one.combined([[Fraction(1, 3)]])
    assert third.exact["P"].tolist() == [[Fraction(1, 3), 0]]
    assert (third.exact["F"] == one.exact["F"]).all()
    assert one.combined([0.5]).exact is None
    with pytest.raises(ValueError, match="H must have 1 column, got 1 x 2"):
        one.combined([1, 2])
