"""One matrix is at least another: as a hypothesis, and as what follows."""

import pytest
from sympy import Matrix, Trace

from matrixproof import Chain, derive, letters, prove
from matrixproof.lines import AtLeast
from matrixproof.models import evaluate
from matrixproof.orders import at_least, prove_at_least
from matrixproof.proofs import Unproved

P, Q, S, X, V, W = letters("P:n*n= Q:n*n= S:n*n= X:n*n= V:n*n= W:n*n=")
T, A, B, K, R = letters("T:m*n A:n*n B:n*n K:n*p R:p*p=")
above, positive = at_least(P, Q), at_least(Q)

HOLD = {
    "between factors": (T * P * T.T, T * Q * T.T, [above]),
    "between sums": ((A + B) * P * (A + B).T, (A + B) * Q * (A + B).T, [above]),
    "inverses": (Q.I, P.I, [above, positive]),
    "inverses between factors": (T * Q.I * T.T, T * P.I * T.T, [above, positive]),
    "one after the other": (P, S, [above, at_least(Q, S)]),
    "a sum": (P + X, Q + V, [above, at_least(X, V)]),
    "means": (A * A.T + B * B.T, A * B.T + B * A.T, []),
    "a multiple, and more": (2 * P + K * R * K.T, P, [at_least(P), at_least(R)]),
    "traces": (Trace(W * P), Trace(W * Q), [above, at_least(W)]),
    "a definition": (S, 0 * S, [(S, A * P * A.T + W), at_least(P), at_least(W)]),
    "itself": (P, P, []),
}
FALSE = {
    "squares": (P * P, Q * Q, [above]),
    "squares of what is positive": (P * P, Q * Q, [above, positive]),
    "inverses the wrong way": (P.I, Q.I, [above, positive]),
    "inverses of any": (Q.I, P.I, [above]),
    "the wrong way": (Q, P, [above]),
    "against the chain": (S, P, [above, at_least(Q, S)]),
    "no more than another": (P, X, [above, at_least(X, Q)]),
    "twice": (P, 2 * Q, [above, positive]),
    "the other mean": (A * B.T + B * A.T, A * A.T, []),
    "a symmetrised product": (P * Q + Q * P, 0 * P, [at_least(P), positive]),
    "symmetric alone": (P, 0 * P, []),
    "traces with any weight": (Trace(W * P), Trace(W * Q), [above]),
}


@pytest.mark.parametrize("name", HOLD)
def test_what_follows_is_proved_with_roots_that_the_machine_finds(name):
    left, right, given = HOLD[name]
    proof = prove_at_least(left, right, given)
    assert proof.check()
    assert set(proof.cited) == {
        r.name if hasattr(r, "name") else f"{r[0]} = {r[1]}" for r in given
    }


def negative(matrix):
    return not Matrix(matrix).is_positive_semidefinite


@pytest.mark.parametrize("name", FALSE)
def test_what_does_not_follow_is_refuted_with_all_that_is_given(name):
    left, right, given = FALSE[name]
    with pytest.raises(Unproved, match="it is false") as refused:
        prove_at_least(left, right, given)
    found = refused.value.counterexample
    for r in given:
        assert not negative(evaluate(r.left - r.least, found))
        assert evaluate(r.left, found) == evaluate(r.right, found)
    gap = evaluate(left, found) - evaluate(right, found)
    assert negative(gap) if hasattr(gap, "shape") else gap < 0


def test_what_is_not_symmetric_is_no_sum_of_squares():
    with pytest.raises(Unproved, match="no sum of squares"):
        prove_at_least(A * A.T + 2 * A * B + B.T * B, 0 * A)


def test_it_is_a_hypothesis_of_equations_too():
    root = above.root
    assert prove(P - Q, root * root.T, [above]).check()
    with pytest.raises(Unproved):
        prove(P, Q, [above])


def test_a_line_goes_down_by_it():
    line = derive(K.T * P * K).at_least(K.T * Q * K, above, positive)
    assert line.check() == []
    assert line.lines[-1].by == (above,)  # and not what it does without
    assert "≥ K' Q K" in str(line) and "P ≥ Q" in str(line)
    with pytest.raises(Unproved):
        derive(K.T * Q * K).at_least(K.T * P * K, above)
    both = derive(P + X).at_least(Q + V, above, at_least(X, V))
    assert both.check() == []
    wrong = AtLeast(Q + 2 * V, by=both.lines[-1].by, root=both.lines[-1].root)
    assert Chain("", "", P + X, [wrong]).check()


def test_it_is_shown_as_it_is_meant():
    assert str(at_least(P, Q, "7")) == "Suppose (7) P ≥ Q"
    assert above._repr_latex_() == r"$$ \text{Suppose }P \ge Q $$"
    assert [str(x) for x in above.expressions] == ["P", "Q"]


def test_it_goes_over_into_other_letters():
    line = derive(T * P * T.T, says="between").at_least(T * Q * T.T, above)
    F, G, H = letters("F:r*r= G:r*r= H:k*r")
    there = at_least(F, G)
    moved = above.mapped(lambda e: e.xreplace({P: F, Q: G, P.rows: F.rows}))
    assert (moved.left, moved.least) == (there.left, there.least)
    assert prove_at_least(H * F * H.T, H * G * H.T, [moved]).check()
    assert line.check() == []
