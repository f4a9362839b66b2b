"""Two stage lists that compute the same."""

import dataclasses

import pytest
from page_damage import wrong_stages

from luenberger.papers.leondes_novak.derivation import (
    gain_step,
    root_decorrelation,
    root_update,
    square_root,
)
from luenberger.papers.leondes_novak.derivation.letters import letters
from luenberger.papers.leondes_novak.derivation.letters.plant import C
from luenberger.papers.leondes_novak.derivation.letters.step import (
    K,
    Kmv,
    M,
    N,
    Omega,
    Sigma_next,
)
from luenberger.papers.leondes_novak.derivation.quadratic import is_Kmv, is_Y, square
from matrixproof import Chain, Derivation, Relation, Stage
from matrixproof.derivation import equivalent
from matrixproof.proofs import Unproved

slow = gain_step()
short = Omega - N * Kmv.T + (K - Kmv) * M * (K - Kmv).T
is_N = Relation("N = Omega C'", N, Omega * C.T)
fast = Derivation(
    slow.given,
    (
        *slow.stages[:4],
        Stage(N, Omega * C.T, by=(is_N,)),
        Stage(Sigma_next, short, symmetric=True, by=(square,)),
    ),
    letters=letters,
    says="the square",
)


def test_a_short_form_of_a_step_is_the_step():
    found = equivalent(fast, slow)
    assert [chain.right for chain in found] == [Omega, M, Kmv, K, Sigma_next]
    last = found[-1]
    assert isinstance(last, Chain) and last.number == "27"
    assert all(word in str(last.rests_on()) for word in ("K_mv M = N", "is symmetric"))
    assert is_Y in last.relations and is_Kmv in last.relations


def test_a_wrong_sign_in_either_list_is_refused():
    for what, wrong in wrong_stages(fast):
        with pytest.raises((ValueError, Unproved)):
            assert equivalent(wrong, slow) == what
    for what, wrong in wrong_stages(slow):
        with pytest.raises((ValueError, Unproved)):
            assert equivalent(fast, wrong) == what


def test_it_is_said_which_target_differs_and_what_is_left():
    other = Relation("what is wrong", Sigma_next, Omega - N * K.T)
    stages = (*fast.stages[:-1], Stage(Sigma_next, Omega - N * K.T, by=(other,)))
    wrong = dataclasses.replace(fast, stages=stages)
    with pytest.raises(Unproved, match="Σ₊ of the square is not that of from one .*; "):
        equivalent(wrong, slow)


@pytest.mark.parametrize("gone", range(2))
def test_what_is_known_of_what_they_are_given_is_needed(gone):
    pair = root_update(), slow
    known = [square_root.is_H_minus, square_root.is_R]
    (found,) = equivalent(*pair, *known, same=square_root.square)
    assert set(known) <= set(found.rests_on().relations)
    del known[gone]
    with pytest.raises(Unproved, match="of a factor of the next covariance"):
        equivalent(*pair, *known, same=square_root.square)


def test_lists_without_a_common_target_are_not_compared():
    with pytest.raises(ValueError, match="say what equals what"):
        equivalent(root_decorrelation(), slow)
