"""When it is looked whether a filter has settled, and what looks cost at most."""

import numpy as np
import pytest

import luenberger as lb
from luenberger.recursion import settled_pass
from luenberger.recursion.looks import FREE, QUICK, SHARE, Looks, settled
from luenberger.recursion.root_step import Spread
from luenberger.recursion.settings import Settings
from luenberger.recursion.settled import near
from luenberger.recursion.settled_pass import SettledPass


@pytest.mark.parametrize("ratio", [0.1, 0.9, 0.99])
@pytest.mark.parametrize("left, wanted", [(0.9e-6, True), (1.1e-6, False)])
def test_changes_that_shrink_evenly_are_added_up(ratio, left, wanted):
    """Row k is 1 + a ratio^k: from the last row but one on, a ratio is left."""
    rows = 1 + left / ratio * ratio ** np.arange(3.0)
    assert settled(rows[:, None], 1e-6) is wanted


def test_each_state_counts():
    still = np.ones(3)
    moves = np.array([1.01, 1.001, 1.0001])
    assert settled(np.stack([still, still], axis=1), 1e-6)
    assert not settled(np.stack([still, moves], axis=1), 1e-6)
    assert not settled(np.stack([moves, still], axis=1), 1e-6)
    assert not settled(np.stack([still, 0 * still], axis=1), 1e-6)


def test_changes_that_do_not_shrink_are_no_end():
    rows = 1 + 1e-9 * np.arange(3.0)
    assert not settled(rows[:, None], 1e-6)
    assert settled(1 + 1e-15 * np.arange(3.0)[:, None], 1e-6)  # which is rounding


@pytest.mark.parametrize("quick", [True, False])
@pytest.mark.parametrize("fast", [True, False])
def test_looks_that_find_nothing_cost_a_share_of_the_rows(fast, quick):
    """But for the first one, or four where rows are slow."""
    looks, still, counted = Looks.none(3), np.ones((100, 3)), 0
    for _ in range(40_000):
        looks = looks.after(still)
        if looks.worth(1e-9, fast):
            looks, counted = looks.failed(fast, quick), counted + 1
    cost, free = looks.cost(fast), 1 if fast else FREE
    assert looks.rows == 4_000_000
    assert looks.spent == counted * (cost // QUICK if quick else cost)
    assert 0.5 * SHARE * looks.rows <= looks.spent <= SHARE * looks.rows + free * cost


@pytest.mark.parametrize("short", [0, 3])
@pytest.mark.parametrize("driven", [[1.0, 0, 0], [1.0, 1.0, 0]])
def test_plants_that_never_settle_are_hardly_looked_at(monkeypatch, driven, short):
    """Variances of the first fall for ever; those of the second stay.

    A mode that no output shows lasts there.  The plant tells it, or where states are
    many the first look, behind which there is none.
    """
    told, found = settled_pass.near, []

    def near(*given):
        found.append(told(*given))
        return found[-1]

    monkeypatch.setattr(settled_pass, "SHORT", short)
    monkeypatch.setattr(settled_pass, "near", near)
    monkeypatch.setattr(settled_pass, "ball", None)  # which none comes to
    C = [[1, 0, 0], [0, 1, 1]]
    plant = lb.Plant(
        np.eye(3), None, C, dt=1.0, Q=np.diag(driven), R=np.eye(2), P0=np.eye(3)
    )
    y = np.random.default_rng(0).standard_normal((700, 2))
    assert not len(lb.filter_data(plant, y, backend="numpy").settled_at)
    if short or not driven[1]:
        assert not found
    else:
        assert len(found) <= 4 and found[-1] == (None, False)


def unseen(mode):
    """A random walk that is measured, and a mode that is neither seen nor driven."""
    noise = dict(Q=np.diag([1.0, 0]), R=[[1.0]], P0=np.eye(2))
    return lb.Plant(np.diag([1.0, mode]), None, [[1, 0]], dt=1.0, **noise)


def test_a_mode_that_lasts_is_given_up_where_variances_are_still():
    now, Sigma = Settings(unseen(1.0), 0).at(2), np.eye(2)
    assert near(now, Spread(Sigma), 10.0) == (None, True)
    for _ in range(100):
        Sigma = now.step(now.move, Spread(Sigma))[1].Sigma
    assert near(now, Spread(Sigma), 10.0) == (None, False)


def test_a_mode_that_decays_does_not_last():
    made = [SettledPass(Settings(unseen(mode), 0), 1e-9) for mode in (0.5, 1.0)]
    assert [one.lasting for one in made] == [False, True]
    assert [one.settings.unseen_growth for one in made] == [[], []]
