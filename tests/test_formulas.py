"""No formula of matrices is written by hand, or a test ties it to what is derived.

A formula is a sum with two products of matrices in it.  It comes from a stage list,
which chains prove.  What numerical linear algebra does otherwise stands below, function
by function, with the test that notices a wrong sign in it or a term that is missing.
"""

import ast
from pathlib import Path

import numpy as np
import pytest
import scipy.integrate
import scipy.linalg
import scipy.signal

import luenberger as lb
from luenberger.certificate import residuals
from luenberger.export import from_statespace
from luenberger.kernels import run
from luenberger.numeric import linalg
from luenberger.numeric.covariance_maps import Sums, spread, stack
from luenberger.numeric.linalg import lyapunov
from luenberger.papers.haddad_bernstein.derivation import equivalent_noise, moment_ahead
from luenberger.papers.leondes_novak.derivation import any_observer as joint
from luenberger.papers.leondes_novak.derivation import huddle
from luenberger.papers.leondes_novak.derivation.letters import observer, plant
from matrixproof import Identity, prove
from matrixproof.proofs import Unproved

ROOM = Path(lb.__file__).parent
TESTS = Path(__file__).parent


# -- tied here ---------------------------------------------------------------------


def test_residuals_are_what_the_conditions_leave():
    """Those of Leondes and Novak (9), (10), (13), in the letters of their page."""
    A, B, C, E = (getattr(plant, name) for name in "ABCE")
    F, G, D, P, V, W, T, T_next = (
        getattr(observer, name) for name in "F G D P V W T T_next".split()
    )
    found = residuals(A, B, C, E, Identity(C.cols), F, G, D, P, V, W, T, T_next)
    conditions = huddle.dynamics, huddle.driven, huddle.unbiased, huddle.is_W
    for residual, one in zip(found, conditions, strict=True):
        prove(residual, one.left - one.right)
    N_1 = joint.is_N_1.right
    prove(found[0], N_1)
    with pytest.raises(Unproved):
        prove(found[0], -N_1)


@pytest.mark.parametrize("solve", [lyapunov, lambda A, Q: Sums(A)(Q)])
def test_sums_of_powers_repeat_one_step_exactly(solve):
    """In whole numbers, with an A whose powers end."""
    rng = np.random.default_rng(3)
    A = np.tril(rng.integers(-3, 4, (5, 5)), -1).astype(float)
    half = rng.integers(-3, 4, (5, 5))
    Q = (half @ half.T).astype(float)
    X = solve(A, Q)
    ahead = run(moment_ahead, dict(A=A, Q1=X, V1=Q))["Q1_next"]
    np.testing.assert_array_equal(X, ahead)


def test_the_map_of_parameter_noise_adds_what_each_pair_adds():
    rng = np.random.default_rng(4)
    A1, A2, X = rng.integers(-5, 6, (3, 4, 4)).astype(float)
    X = X + X.T
    pairs = [(A1, np.zeros((1, 4))), (A2, np.zeros((1, 4)))]
    each = (run(equivalent_noise, dict(A1=A1, X=X), "dV1")["dV1"] for A1, _ in pairs)
    np.testing.assert_array_equal(spread(stack(A1, pairs), X), sum(each))


def test_accurate_outputs_are_met_to_the_last_digits(monkeypatch):
    """One more step squares what is left over of C1 Gamma1 = I."""
    rng = np.random.default_rng(6)
    C1 = rng.normal(size=(3, 5))
    rough = np.linalg.pinv(C1) + 1e-4 * rng.normal(size=(5, 3))
    monkeypatch.setattr(linalg, "_right_inverse", lambda *_: rough)
    left, found = (np.eye(3) - C1 @ X for X in (rough, linalg.complete(C1)[1]))
    assert np.abs(left).max() > 1e-5
    np.testing.assert_allclose(found, left @ left, atol=1e-14)


def test_what_a_system_tracks_is_refined_and_read_off(monkeypatch):
    """T of T A = F T + D C, and L = P T + V C of it."""
    solve, rough = scipy.linalg.solve_sylvester, iter([1e-10, 0.0])
    monkeypatch.setattr(
        scipy.linalg, "solve_sylvester", lambda *args: solve(*args) + next(rough)
    )
    A, C, F, D = [[1, 1], [0, 1]], [[1, 0]], [[0.5]], [[1]]
    plant = lb.Plant(A, None, C, dt=1.0)
    T = np.array([[2.0, -4.0]])  # by hand
    L = [[2 * 2 + 1.5 * 1, 2 * -4]]
    system = scipy.signal.StateSpace(F, D, [[2]], [[1.5]], dt=1.0)
    found = from_statespace(system, plant)
    np.testing.assert_allclose(found.T, T, rtol=1e-12)
    np.testing.assert_allclose(found.L, L, rtol=1e-12)


@pytest.mark.parametrize("dt", [0.0, 0.25])
def test_a_run_is_that_of_the_equations(dt):
    """With every matrix of plant and observer, from instant to instant."""
    rng = np.random.default_rng(5)
    n, m, p, r, q = 2, 1, 2, 1, 2
    A, B, C, E = (rng.normal(size=s) for s in ((n, n), (n, m), (p, n), (p, m)))
    F, G, D, T = (rng.normal(size=s) for s in ((r, r), (r, m), (r, p), (r, n)))
    P, V, W, L = (rng.normal(size=s) for s in ((q, r), (q, p), (q, m), (q, n)))
    plant = lb.Plant(A, B, C, E, dt=dt)
    observer = lb.Observer(F, G, D, P, V, T, L, W, z0=[0.5], dt=dt)
    t, u, x0 = np.arange(5) / 4, rng.normal(size=(5, m)), [1.0, -2.0]
    found = lb.simulate(plant, observer, t, u=u, x0=x0)
    s = np.array([*x0, 0.5])

    def moves(_, s, u):
        y = C @ s[:n] + E @ u
        return np.concatenate([A @ s[:n] + B @ u, F @ s[n:] + G @ u + D @ y])

    for k in range(5):
        y = C @ s[:n] + E @ u[k]
        w_hat = P @ s[n:] + V @ y + W @ u[k]
        now = found.x[k], found.z[k], found.y[k], found.w_hat[k]
        np.testing.assert_allclose(np.hstack(now), [*s, *y, *w_hat], rtol=1e-9)
        held = dict(args=(u[k],), rtol=1e-12, atol=1e-13)
        flow = scipy.integrate.solve_ivp(moves, (0, 0.25), s, **held).y[:, -1]
        s = moves(0, s, u[k]) if dt else flow


# -- every formula, and its test ------------------------------------------------------

TIED = """
residuals test_residuals_are_what_the_conditions_leave
_missed test_what_it_misses_is_that_of_its_estimates
_promised test_the_recommended_observer_is_judged_on_the_record
export.c._record test_a_self_test_agrees_and_notices_damage
export._tracked test_what_a_system_tracks_is_refined_and_read_off
export.from_statespace test_what_a_system_tracks_is_refined_and_read_off
filtering._factors test_digits_decide_which_way_back_is_taken
filtering.score test_the_score_is_that_of_the_density
filtering.Settings._make test_filters_equal_exact_ones
filtering.steady test_the_tail_is_the_recursion
forms._require_same test_a_wrong_entry_is_measured
identification.gain_for test_innovations_of_any_start_are_those_of_the_right_one
identification.left test_innovations_of_any_start_are_those_of_the_right_one
numeric.Sums.__call__ test_sums_of_powers_repeat_one_step_exactly
numeric.outside test_structural_zeros
numeric._right_inverse test_right_inverse_is_the_one_of_least_weighted_trace
numeric._seen_in_part test_a_push_of_least_weight_for_a_singular_weight
numeric.complete test_accurate_outputs_are_met_to_the_last_digits
numeric._turn test_form_is_backward_stable_and_echelon
papers.haddad_bernstein.Frame.model test_step_is_the_best_within_reach
papers.haddad_bernstein.observer_of test_a_whitened_estimator_costs_the_excess
papers.haddad_bernstein.Schur._march test_stein_equations
papers.kawazoe.reconstruct_state test_states_from_every_window
papers.moore._Factor.step test_an_observer_in_orthonormal_coordinates
papers.moore._row test_a_row_is_the_nearest_that_its_equation_leaves
papers.moore._error test_several_outputs
papers.van_dooren.slant test_slopes_by_differences
filtering._products test_a_record_is_what_it_is_by_itself
run._Work._met test_records_are_smoothed_as_by_conditioning
run._Work.neighbours test_records_are_smoothed_as_by_conditioning
plant.Plant.at_first_sample test_a_start_is_carried_to_the_first_sample
LiveObserver.advance test_an_observer_at_work_estimates_as_over_the_record
LiveObserver.measure test_an_observer_at_work_estimates_as_over_the_record
run._simulate_continuous test_a_run_is_that_of_the_equations
run.follow test_a_run_is_that_of_the_equations
run.trajectory test_a_run_is_that_of_the_equations
"""


def test_no_other_formula_is_written_by_hand():
    tied = dict(line.split() for line in TIED.strip().splitlines())
    found = {name for path in ROOM.rglob("*.py") for name in formulas(path)}
    assert found == set(tied)
    tests = "".join(path.read_text("utf-8") for path in TESTS.rglob("test_*.py"))
    assert [test for test in tied.values() if f"def {test}" not in tests] == []


def formulas(path):
    """The functions with a sum of matrix products, by their rooms."""
    parts = path.relative_to(ROOM).parts[:-1]
    if "derivation" not in parts:
        yield from _within(ast.parse(path.read_text(encoding="utf-8")), parts)


def _within(node, parts):
    for child in ast.iter_child_nodes(node):
        named = isinstance(child, ast.FunctionDef | ast.ClassDef)
        yield from _within(child, (*parts, child.name) if named else parts)
    sums = isinstance(node, ast.BinOp | ast.AugAssign)
    if sums and isinstance(node.op, ast.Add | ast.Sub):
        if sum(map(_is_product, ast.walk(node))) > 1:
            yield ".".join(parts)


def _is_product(node):
    function = getattr(getattr(node, "func", None), "id", "")
    return isinstance(getattr(node, "op", 0), ast.MatMult) or function == "times"
