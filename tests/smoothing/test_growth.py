"""Unstable modes that grow in a gap: what is smoothed is right, or refused."""

import many_digits
import numpy as np
import pytest

import luenberger as lb

MIX = np.array([[1, 1, 0], [1, 2, 1], [0, 1, 2.0]])  # its inverse is of integers, too
MODES = {
    "real": np.diag([4, 0.5, 0.25]),
    "two": np.diag([4, 2, 0.5]),
    "pair": np.array([[2, 2, 0], [-2, 2, 0], [0, 0, 0.5]]),
    "Jordan": np.array([[4, 1, 0], [0, 4, 0], [0, 0, 0.5]]),
}


def case(modes, growth, R=1.0, mix=MIX):
    """A plant, and a record as of a closed loop, that is missing for some rows."""
    A = mix @ modes @ np.linalg.inv(mix).round()
    seen = [[1, 0, 0]] if mix is MIX else [[1, 1, 1]]
    plant = lb.Plant(A, None, seen, dt=1.0, Q=np.eye(3), R=[[R]], P0=np.eye(3))
    gap = int(np.ceil(np.log(growth) / np.log(np.abs(np.linalg.eigvals(modes)).max())))
    y = np.random.default_rng(1).integers(-3, 4, (gap + 7, 1)).astype(float)
    y[3 : 3 + gap] = np.nan
    return plant, y


def errors(found, x, P, least):
    """Of x and P, in standard deviations, or in `least` where the state is known."""
    unit = np.sqrt(np.maximum(np.einsum("kii->ki", P), 0)) + least
    far = np.abs(found.P - P) / (unit[:, :, None] * unit[:, None])
    return np.abs((found.x - x) / unit).max(), far.max()


@pytest.mark.parametrize("R", [1.0, 0.0])
@pytest.mark.parametrize("modes", MODES)
def test_what_grows_is_right_or_refused(modes, R):
    for growth in (1e3, 1e5, 1e6, 1e7, 1e8, 1e10, 1e16):
        plant, y = case(MODES[modes], growth, R)
        if growth >= 1e7:
            with pytest.raises(lb.DesignError, match="'x1' and 'x2' together"):
                lb.smooth(plant, y)
            continue
        try:
            found = lb.smooth(plant, y)
        except lb.DesignError:  # two equal modes grow faster than their powers
            assert growth == 1e6 and modes == "Jordan"
            continue
        x, P, _ = many_digits.smoothed(plant, y)
        of_x, of_P = errors(found, x, P, 1e-6 if R else 1e-2)
        assert of_x < 1e-3 and of_P < 3e-3, (growth, of_x, of_P)


def test_pieces_are_refused_as_the_whole():
    plant, y = case(MODES["real"], 1e12)
    with pytest.raises(
        lb.DesignError,
        match="from instant 14 on: .* from instant 4 on",
    ):
        list(lb.smooth(plant, iter(np.split(y, [5, 9, 20])), lag=30))


@pytest.mark.parametrize("modes", [MODES["real"], np.diag([4, -4, 0.5])])
def test_modes_that_are_states_of_their_own_keep_their_digits(modes):
    plant, y = case(modes, 1e8, mix=np.eye(3))
    x, P, _ = many_digits.smoothed(plant, y)
    of_x, of_P = errors(lb.smooth(plant, y), x, P, 1e-6)
    assert of_x < 1e-5 and of_P < 1e-5


def test_a_position_that_drifts_in_a_long_gap_is_no_unstable_mode():
    plant = lb.Plant(
        [[1, 1], [0, 1]], None, [[1, 0]], dt=1.0, Q=np.diag([0, 1]), R=[[1]],
        P0=np.diag([1e-20, 1]),
    )  # fmt: skip
    y = np.zeros((3000, 1))
    y[1:-1] = np.nan
    x, P, _ = many_digits.smoothed(plant, y[:50])
    assert max(errors(lb.smooth(plant, y[:50]), x, P, 1e-6)) < 1e-6
    assert np.isfinite(lb.smooth(plant, y).std).all()
