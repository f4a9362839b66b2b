"""The same observer in other coordinates: what it does, its zeros, what is refused."""

import dataclasses

import numpy as np
import pytest
import scipy.linalg

import luenberger as lb
from luenberger.errors import CertificateError, DesignError
from luenberger.forms import system as forms_system
from luenberger.forms.modal import modal

FORMS = {
    "modal": lambda one: one.modal(),
    "companion blocks": lambda one: one.modal("companion"),
    "balanced": lambda one: one.balanced(),
    "companion": lambda one: one.companion(),
    "from an output": lambda one: one.companion(output=0),
}


def observer(seed=0, r=4, q=1, dt=0.1, n=5, m=1, p=2, pole=None):
    """An observer with dense random matrices and its plant, made to measure."""
    rng = np.random.default_rng(seed)
    F = rng.standard_normal((r, r))
    poles = np.linalg.eigvals(F)
    if dt:
        F *= 0.9 / np.abs(poles).max()
    else:
        F -= (poles.real.max() + 0.5) * np.eye(r)
    G, D, P, V, T, L = (
        rng.standard_normal(size)
        for size in ((r, m), (r, p), (q, r), (q, p), (r, n), (q, n))
    )
    return lb.Observer(F, G, D, P, V, T, L, z0=rng.standard_normal(r), dt=dt)


def markov(o, count=12):
    """P [G D], P F [G D], ...: what comes out after each input."""
    found, N = [], np.hstack([o.G, o.D])
    for _ in range(count):
        found.append(o.P @ N)
        N = o.F @ N
    return np.array(found)


@pytest.mark.parametrize("form", FORMS)
@pytest.mark.parametrize("dt", [0, 0.1])
@pytest.mark.parametrize("seed", range(5))
def test_a_form_does_the_same(form, dt, seed):
    """Responses to inputs and to the start, and what it follows."""
    o = observer(seed, dt=dt)
    made = FORMS[form](o)
    size = np.abs(markov(o)).max(axis=(1, 2), keepdims=True)
    assert np.abs((markov(made) - markov(o)) / size).max() < 1e-9
    powers = [(o.P @ np.linalg.matrix_power(o.F, k)) for k in range(4)]
    others = [(made.P @ np.linalg.matrix_power(made.F, k)) for k in range(4)]
    assert np.allclose(
        [X @ o.T for X in powers], [X @ made.T for X in others], rtol=1e-8, atol=1e-8
    )
    assert np.allclose([X @ o.z0 for X in powers], [X @ made.z0 for X in others])
    assert np.array_equal(made.V, o.V) and np.array_equal(made.W, o.W)


@pytest.mark.parametrize("form", FORMS)
def test_a_form_is_certified_on_the_plant(form):
    plant = lb.Plant(
        [[0.9, 0.2, 0], [-0.1, 0.8, 0.1], [0, 0.3, 0.6]],
        [[1], [0], [1]],
        [[1, 0, 0]],
        [[0.5]],
        dt=1.0,
        Q=np.eye(3),
        R=[[1]],
        x0=[1, 2, 3],
    )
    kalman = lb.kalman_filter(plant)
    made = FORMS[form](kalman)
    assert lb.certify(made, plant).require().worst < 1e-13
    assert made.state_names == kalman.state_names
    run, other = (lb.simulate(plant, one, 20) for one in (kalman, made))
    assert np.allclose(run.w_hat, other.w_hat, rtol=1e-10, atol=1e-10)


def test_modal_zeros_are_zeros_and_a_pair_repeats_its_entries():
    F = scipy.linalg.block_diag([[0.5, 0.3], [-0.3, 0.5]], 0.2, -0.4)
    S = np.random.default_rng(3).standard_normal((4, 4))
    o = observer(1)
    o = dataclasses.replace(o, F=S @ F @ np.linalg.inv(S))
    made = o.modal()
    assert np.count_nonzero(made.F) == 6
    assert sorted(np.round(made.poles.real, 10)) == [-0.4, 0.2, 0.5, 0.5]
    assert (made.F[2, 2], made.F[2, 3]) == (made.F[3, 3], -made.F[3, 2])
    assert made.P.tolist() == [[1, 1, 1, 0]]  # one estimate: the ones are in P
    blocks = o.modal("companion")
    assert np.count_nonzero(blocks.F) == 5 and blocks.F[2, 2:].tolist() == [0, 1]
    assert blocks.P.tolist() == [[1, 1, 1, 0]]


@pytest.mark.parametrize("pairs", ["rotation", "companion"])
def test_with_several_estimates_the_ones_are_among_the_inputs(pairs):
    made = observer(2, r=5, q=3).modal(pairs)
    N = np.hstack([made.G, made.D])
    upper = [k for k in range(5) if made.F[k, :k].any()]  # second rows of pairs
    assert upper, "no pair in this observer"
    for k in upper:
        places = [tuple(column) for column in N[k - 1 : k + 1].T]
        assert ((1, 0) if pairs == "rotation" else (0, 1)) in places
    for k in set(range(5)) - set(upper) - {k - 1 for k in upper}:
        assert 1 in N[k]


def test_parts_that_do_not_meet_keep_their_zeros():
    F = scipy.linalg.block_diag([[0.5, 0.1], [0.2, 0.3]], [[0.4, 0.1], [0.3, 0.1]])
    D, P = [[1, 0], [2, 0], [0, 3], [0, 1]], [[1, 1, 0, 0], [0, 0, 1, 2]]
    o = lb.Observer(F, np.zeros((4, 0)), D, P, np.zeros((2, 2)), np.eye(4), P, dt=1.0)
    made = o.modal()
    assert [np.count_nonzero(X) for X in (made.F, made.D, made.P)] == [4, 4, 4]


@pytest.mark.parametrize("form", FORMS)
def test_units_of_the_observers_states_have_no_say(form):
    """The same bits, or for balanced coordinates all digits but the last few."""
    o = observer(4)
    units = 2.0 ** np.array([40, -40, 17, 0])
    scaled = dataclasses.replace(
        o,
        F=o.F * units[:, None] / units,
        G=o.G * units[:, None],
        D=o.D * units[:, None],
        P=o.P / units,
        T=o.T * units[:, None],
        z0=o.z0 * units,
    )
    one, other = FORMS[form](o), FORMS[form](scaled)
    for name in "FGDPT":
        X, Y = getattr(one, name), getattr(other, name)
        assert np.allclose(X, Y, rtol=1e-9, atol=1e-9 * np.abs(X).max()), name


@pytest.mark.parametrize("exponent", [-40, 40])
@pytest.mark.parametrize("form", ["modal", "companion blocks", "companion"])
def test_fast_and_slow_observers_and_units_of_signals(form, exponent):
    """In continuous time the rate is any, and so are the units of u, y and w."""
    o, rate = observer(6, dt=0), 2.0**exponent
    fast = dataclasses.replace(o, F=o.F * rate, D=o.D * [rate, 1], P=o.P / rate)
    made, other = FORMS[form](o), FORMS[form](fast)
    poles = np.sort_complex(np.linalg.eigvals(o.F)) * rate
    if form != "companion":
        assert np.allclose(other.poles, poles, rtol=1e-9)
        assert (made.P == other.P).all()
    assert np.count_nonzero(other.F) == np.count_nonzero(made.F)


@pytest.mark.parametrize("dt", [0, 0.1])
@pytest.mark.parametrize("seed", range(3))
def test_both_gramians_are_the_same_diagonal(dt, seed):
    made = observer(seed, r=3, q=2, dt=dt).balanced()
    N = np.hstack([made.G, made.D])
    if dt:
        X = scipy.linalg.solve_discrete_lyapunov(made.F, N @ N.T)
        Y = scipy.linalg.solve_discrete_lyapunov(made.F.T, made.P.T @ made.P)
    else:
        X = scipy.linalg.solve_continuous_lyapunov(made.F, -N @ N.T)
        Y = scipy.linalg.solve_continuous_lyapunov(made.F.T, -made.P.T @ made.P)
    values = X.diagonal()
    assert np.allclose(X, np.diag(values), atol=1e-9 * values[0])
    assert np.allclose(X, Y, atol=1e-9 * values[0])
    assert (np.diff(values) <= 0).all()
    assert (N[np.arange(3), np.abs(N).argmax(axis=1)] > 0).all()


def test_companion_has_ones_zeros_and_the_characteristic_polynomial():
    o = observer(7, r=4)
    made = o.companion(estimate=0)
    assert (made.F[:-1] == np.eye(4, k=1)[:-1]).all()
    assert np.allclose(made.F[-1], -np.poly(o.F)[:0:-1], rtol=1e-9)
    assert made.P.tolist() == [[1, 0, 0, 0]]
    other = o.companion(output=1)
    assert (other.F[:, :-1] == np.eye(4, k=-1)[:, :-1]).all()
    assert other.D[:, 1].tolist() == [1, 0, 0, 0]


def test_a_deadbeat_observer_is_a_chain_of_delays():
    F = [[0, 2, 3], [0, 0, 5], [0, 0, 0]]
    o = lb.Observer(F, np.zeros((3, 0)), [[1], [2], [3]], [[1, 2, 3]], [[0]],
                    np.eye(3), [[1, 2, 3]], dt=1.0)  # fmt: skip
    assert (o.companion().F == np.eye(3, k=1)).all()


def refusal(action):
    with pytest.raises((DesignError, CertificateError)) as caught:
        action()
    return str(caught.value)


@pytest.mark.parametrize("gap", [0, 1e-15, -1e-15])
def test_defective_poles_are_refused_by_name(gap):
    o = observer(8, r=2)
    o = dataclasses.replace(o, F=[[0.5, 1], [gap, 0.5]])
    message = refusal(o.modal)
    assert "0.5" in message and "companion()" in message
    assert np.allclose(o.companion().poles, 0.5, atol=1e-5)


def test_modes_that_cancel_are_refused_in_odd_units():
    """The poles of this F are apart as far as F alone tells."""
    unit = np.array([1, 2.0**-25])
    F = np.array([[0.5, 1], [2.0**-50, 0.5]]) / unit[:, None] * unit
    odd = forms_system.System(F, np.ones((2, 1)) / unit[:, None], unit[None], unit)
    assert "0.5" in refusal(lambda: modal(odd))


def test_a_chain_of_nearly_dependent_rows_is_refused():
    o = dataclasses.replace(observer(8, r=2), F=np.diag([0.5, 0.5 + 1e-8]))
    assert "nearly dependent" in refusal(o.companion)


def test_equal_poles_that_are_not_defective_are_fine():
    o = dataclasses.replace(observer(8, r=2), F=0.5 * np.eye(2))
    assert (o.modal().F == 0.5 * np.eye(2)).all()
    assert "do" in refusal(o.companion) and "modal()" in refusal(o.companion)


def test_balanced_refuses_what_is_not_stable_or_not_minimal():
    o = observer(9, r=2)
    grows = dataclasses.replace(o, F=[[1.1, 0.2], [0, 0.5]])
    assert "1.1" in refusal(grows.balanced) and "stable" in refusal(grows.balanced)
    apart = dataclasses.replace(o, F=np.diag([0.5, 0.25]))
    idle = dataclasses.replace(apart, G=[[0], [1]], D=[[0, 0], [1, 1]])
    assert "reach only 1 of 2" in refusal(idle.balanced)
    hidden = dataclasses.replace(apart, P=[[0, 1]])
    assert "shows only 1 of 2" in refusal(hidden.balanced)
    dead = dataclasses.replace(apart, P=[[0, 0]])
    assert "shows only 0 of 2" in refusal(dead.balanced)


def test_forms_are_of_constant_real_observers():
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    varying = lb.kalman_filter(plant, steps=3)
    whole = dataclasses.replace(observer(1, r=1), F=[[0.5j]])
    for form in FORMS.values():
        assert "varies over time" in refusal(lambda form=form: form(varying))
        assert "complex" in refusal(lambda form=form: form(whole))


def test_a_form_that_is_asked_for_wrongly():
    o = observer(1)
    with pytest.raises(ValueError, match="pairs must be 'rotation' or 'companion'"):
        o.modal("jordan")
    with pytest.raises(ValueError, match="no estimate 'torque'; there are"):
        o.companion("torque")
    with pytest.raises(ValueError, match="no output 2; there are"):
        o.companion(output=2)
    with pytest.raises(ValueError, match="an estimate or from an output"):
        o.companion(0, 0)


@pytest.mark.parametrize("form", ["modal", "balanced", "companion"])
def test_no_states_are_in_every_form(form):
    none = np.zeros((0, 1))
    o = lb.Observer(none[:, :0], none, none, none.T, [[1]], none, [[1]], dt=1.0)
    assert FORMS[form](o).order == 0


@pytest.mark.parametrize("matrix", ["F", "N", "P"])
def test_a_wrong_entry_is_measured(matrix):
    o = observer(3)
    system = o._system()
    made = o.modal()
    S = modal(system).S
    right = dict(F=made.F, N=np.hstack([made.G, made.D]), P=made.P)
    forms_system._require_same(system, S, **right)
    wrong = right | {matrix: right[matrix] * (1 + 1e-8)}
    with pytest.raises(CertificateError, match="rounding spoils this form"):
        forms_system._require_same(system, S, **wrong)


# -- what the estimate never shows ---------------------------------------------------


def two_parts(seed=0, q=1, dt=0.1):
    """An observer whose last two states show nothing, though the others move them."""
    o = observer(seed, r=5, q=q, dt=dt)
    F, P = o.F.copy(), o.P.copy()
    F[:3, 3:], P[:, 3:] = 0, 0
    if dt:
        F *= 0.9 / np.abs(np.linalg.eigvals(F)).max()
    return dataclasses.replace(o, F=F, P=P)


@pytest.mark.parametrize("mixed", [False, True], ids=["entries", "directions"])
@pytest.mark.parametrize("dt", [0, 0.1])
@pytest.mark.parametrize("q", [1, 2])
def test_hidden_states_are_left_out_and_nothing_else(mixed, dt, q):
    o = two_parts(4, q, dt)
    if mixed:
        S = np.random.default_rng(5).standard_normal((5, 5)) * 2.0 ** np.arange(5)
        back = np.linalg.inv(S)
        made = dict(F=S @ o.F @ back, G=S @ o.G, D=S @ o.D, P=o.P @ back)
        o = dataclasses.replace(o, **made, T=S @ o.T, z0=S @ o.z0)
    made = o.without_hidden()
    assert (o.order, made.order) == (5, 3)
    size = np.abs(markov(o)).max(axis=(1, 2), keepdims=True)
    assert np.abs((markov(made) - markov(o)) / size).max() < 1e-11
    for k in range(3):
        before = o.P @ np.linalg.matrix_power(o.F, k)
        after = made.P @ np.linalg.matrix_power(made.F, k)
        assert np.allclose(after @ made.T, before @ o.T, rtol=1e-8, atol=1e-9)
        assert np.allclose(after @ made.z0, before @ o.z0, rtol=1e-8, atol=1e-9)
    if not mixed:
        assert np.array_equal(made.F, o.F[:3, :3])
        assert np.array_equal(made.T, o.T[:3])
    assert made.without_hidden() is made


def test_what_shows_a_little_stays():
    o = two_parts(4)
    P = o.P.copy()
    P[0, 4] = 1e-9 * np.abs(P).max()
    assert dataclasses.replace(o, P=P).without_hidden().order == 5
    assert observer(1).without_hidden().order == 4


def test_a_filter_without_its_hidden_states_is_certified():
    """Two tanks that do not meet; only the level of one is wanted."""
    A = scipy.linalg.block_diag([[0.9, 0.1], [0, 0.8]], [[0.7, 0.2], [-0.2, 0.7]])
    plant = lb.Plant(A, None, np.eye(2, 4)[:, [0, 2, 1, 3]], dt=1.0, Q=np.eye(4),
                     R=np.eye(2))  # fmt: skip
    whole = lb.kalman_filter(plant, L=[1, 0, 0, 0])
    made = whole.without_hidden()
    assert (whole.order, made.order) == (4, 2)
    assert lb.certify(made, plant).require().worst < 1e-13
    left = lb.error_covariance(made, plant)
    np.testing.assert_allclose(left, lb.error_covariance(whole, plant), rtol=1e-12)
    assert lb.export.multiply_adds(made) < lb.export.multiply_adds(whole)
    few = lb.candidates(plant, methods="Kalman filter")
    (one,) = lb.compare(plant, few, L=[1, 0, 0, 0])
    forms = (made.modal(), made.modal("companion"), made.companion())
    least = min(map(lb.export.multiply_adds, forms))
    assert one.order == 2 and one.work <= least < lb.export.multiply_adds(made)
    assert "Left out: 2 states that the estimate never shows." in one.note


def test_hidden_states_of_an_observer_over_steps_stay():
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    with pytest.raises(DesignError, match="varies over time"):
        lb.kalman_filter(plant, steps=3).without_hidden()
