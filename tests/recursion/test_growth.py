"""Unstable modes that grow in a gap: what is filtered behind it is right, or refused.

The oracle is the filter with 250 digits.  More plants are tried by

    GROWN_PLANTS=1000 pytest tests/recursion/test_growth.py
"""

import os

import exact_filter
import many_digits
import numpy as np
import pytest

import luenberger as lb
from luenberger.recursion import growth

MIX = np.array([[1, 1, 0], [1, 2, 1], [0, 1, 2.0]])  # its inverse is of integers, too
REFUSED = "too few digits are left from instant"


def plant_of(modes=(4, 0.5, 0.25), mix=MIX, C=((1, 0, 0),), **options):
    """Modes, each of which moves states that another moves as well."""
    A = mix @ np.diag(modes) @ np.linalg.inv(mix).round()
    given = dict(Q=np.eye(3), R=np.eye(len(C)), P0=np.eye(3), dt=1.0)
    return lb.Plant(A, None, C, **(given | options))


def record(gap, p=1, first=3, behind=4):
    """Small readings, as of a closed loop, of which some rows are missing."""
    N = first + gap + behind
    y = np.random.default_rng(1).integers(-3, 4, (N, p)).astype(float)
    y[first : first + gap] = np.nan
    return y


# -- beside many digits ------------------------------------------------------------


def drawn(seed):
    """A plant with unstable modes, noise in every direction, and a record with gaps."""
    rng = np.random.default_rng([7, seed])
    n, p = rng.integers(2, 5), rng.integers(1, 4)
    unstable = rng.integers(1, min(n, 3) + 1)
    modes = np.zeros((n, n))
    many = rng.uniform(1.05, 8, unstable) * rng.choice([-1, 1], unstable)
    few = rng.choice([0, 0.3, 0.9, 0.999, 1.0], n - unstable)
    modes[range(n), range(n)] = [*many, *few]
    if unstable > 1 and rng.random() < 0.3:
        modes[:2, :2] = many[0] * np.array([[0.6, 0.8], [-0.8, 0.6]])
    mix, C, G = (
        rng.normal(size=(n, n)),
        rng.normal(size=(p, n)),
        rng.normal(size=(n, n)),
    )
    unit = 10.0 ** rng.uniform(-3, 3, (n, 1)) ** rng.integers(2)
    A = unit * (mix @ modes @ np.linalg.inv(mix)) / unit.T
    Q = unit * (G @ G.T * 10.0 ** rng.integers(-8, 1)) * unit.T
    R = np.diag(10.0 ** rng.uniform(-6, 1, p)) * float(rng.random() < 0.9 or p >= n)
    P0 = 10.0 ** rng.integers(-4, 5) * np.diag(unit[:, 0] ** 2)
    plant = lb.Plant(A, None, C / unit.T, dt=1.0, Q=0.5 * (Q + Q.T), R=R, P0=P0)
    far, largest = rng.uniform(2, 12), np.abs(many).max()
    gap = int(min(np.ceil(far / np.log10(largest)), 60))
    y = record(gap, p, behind=6) * np.sqrt(
        np.diagonal(C / unit.T @ Q @ (C / unit.T).T + R)
    )
    kind = rng.integers(4) if p > 1 else 0
    if kind == 1:  # outputs come back one after the other
        y[3 + gap : 6 + gap, 0] = np.nan
    elif kind == 2:  # one never left
        y[3 : 3 + gap, -1] = 1.0
    elif kind == 3:  # one never comes back
        y[1:, 0] = np.nan
    return plant, y


BLOCKS, COUNT = 2, int(os.environ.get("GROWN_PLANTS", "80"))


@pytest.mark.parametrize("block", range(BLOCKS))
def test_what_is_filtered_is_right_or_refused(block):
    """To a thousandth of standard deviations, of x and of P."""
    refused = right = 0
    for seed in range(block, COUNT, BLOCKS):
        plant, y = drawn(seed)
        try:
            found = lb.filter_data(plant, y, history=True)
        except lb.DesignError as error:
            assert REFUSED in str(error), seed
            refused += 1
            continue
        x, P = many_digits.filtered(plant, y)
        unit = np.sqrt(np.einsum("kii->ki", P))
        off = np.abs(found.P - P) / (unit[:, :, None] * unit[:, None])
        assert off.max() < 1e-3, seed
        assert (np.abs(found.x - x) / unit).max() < 1e-3, seed
        right += 1
    assert min(refused, right) > 0.2 * COUNT / BLOCKS


@pytest.mark.parametrize("modes", [(4, 0.5, 0.25), (4, 2, 0.5), (4, -4, 0.5)])
def test_the_first_row_that_is_spoiled_is_named(modes):
    """From a growth of 1e6 on, which is ten rows of the mode 4."""
    plant, words = plant_of(modes), "instant 14 on: .* instant 4 on, .* 'x1' and 'x.' "
    for behind in (0, 4):
        found = lb.filter_data(plant, record(10, behind=behind), history=True)
        x, P = many_digits.filtered(plant, record(10, behind=behind))
        unit = np.sqrt(np.einsum("kii->ki", P))
        off = np.abs(found.P - P) / (unit[:, :, None] * unit[:, None])
        assert off.max() < 1e-4 and (np.abs(found.x - x) / unit).max() < 1e-4
        with pytest.raises(lb.DesignError, match=words + "together"):
            lb.filter_data(plant, record(11, behind=behind))


def test_a_state_that_the_mode_does_not_move_is_spoiled_within_the_gap(monkeypatch):
    """Why rows are refused there, and not from the next reading on."""
    monkeypatch.setattr(growth, "FAR", np.inf)
    monkeypatch.setattr(growth, "NOISE_FREE", np.inf)
    plant, y = plant_of(), record(30, behind=0)
    std = np.sqrt(np.einsum("kii->ki", many_digits.filtered(plant, y)[1]))
    off = np.abs(lb.filter_data(plant, y).std / std - 1).max(axis=0)
    assert off[0] < 1e-9 and off[1] < 1e-9 and off[2] > 1


def test_a_mode_that_is_a_state_of_its_own_keeps_its_digits():
    """As many as numbers have: one unit beside 1e8 of them is the end."""
    plant, y = plant_of((4, -4, 0.5), np.eye(3), C=((1, 1, 1),)), record(14)
    x, P = many_digits.filtered(plant, y)
    found = lb.filter_data(plant, y, history=True)
    unit = np.sqrt(np.einsum("kii->ki", P))
    assert (np.abs(found.x - x) / unit).max() < 1e-4
    assert (np.abs(found.P - P) / (unit[:, :, None] * unit[:, None])).max() < 1e-4
    with pytest.raises(lb.DesignError, match="instant 18 on: .* has moved 'x.', to 3e"):
        lb.filter_data(plant, record(15))


RIGHT = [257, 268, 390, 463, 542, 707, 851, 874, 1039, 1040, 1479, 2008, 2811]


@pytest.mark.parametrize("seed", RIGHT)
def test_a_deviation_that_is_rounding_has_not_grown(seed):
    """States that are known exactly, but for rounding, and then driven by noise."""
    problem = exact_filter.problem(seed)
    given = dict(m1=list(problem.accurate), history=True)
    run = lb.filter_data(problem.plant, problem.record, **given)
    assert max(problem.errors(run.x, run.P, problem.exact())) < 1e-9


def test_growth_is_counted_from_the_least_deviation_in_the_gap():
    """One output never comes back; the state was vague when it went."""
    plant = plant_of(C=((1, 0, 0), (0, 1, 1)), P0=1e14 * np.eye(3))
    y = record(14, p=2, first=6)
    y[0:, 1] = np.nan
    with pytest.raises(
        lb.DesignError, match="from instant 20 on: .* from instant 1 on"
    ):
        lb.filter_data(plant, y)


# -- a mode that no output shows ----------------------------------------------------


def hidden(seed):
    """A plant with an unstable mode that no output shows, in whole numbers."""
    rng = np.random.default_rng([9, seed])
    n, p, N = rng.integers(2, 5), rng.integers(1, 3), rng.integers(5, 60)
    rest = rng.choice([0.25, 0.875, -0.5, 1.1875], n - 1)
    modes = np.array([rng.integers(17, 48) / 16, *rest])
    low, high = (np.tril(rng.integers(-2, 3, (n, n)), -1) + np.eye(n) for _ in "12")
    mix = low @ high.T
    unmix = np.linalg.inv(mix).round()
    C = rng.integers(-3, 4, (p, n)) * (np.arange(n) > 0)
    G = rng.integers(-2, 3, (n, n))
    noise = dict(Q=G @ G.T + np.eye(n), R=np.eye(p), P0=np.eye(n))
    plant = lb.Plant(mix @ np.diag(modes) @ unmix, None, C @ unmix, dt=1.0, **noise)
    return plant, rng.integers(-3, 4, (N, p)).astype(float)


def test_a_mode_that_no_output_shows_grows_without_any_gap():
    """What is filtered is right, or refused; never a failure of the algebra."""
    refused = right = 0
    for seed in range(30, 55):
        plant, y = hidden(seed)
        try:
            found = lb.filter_data(plant, y, history=True)
        except lb.DesignError as error:
            assert REFUSED in str(error), seed
            assert "no output shows the unstable mode at" in str(error), seed
            refused += 1
            continue
        x, P = many_digits.filtered(plant, y)
        unit = np.sqrt(np.einsum("kii->ki", P))
        off = np.abs(found.P - P) / (unit[:, :, None] * unit[:, None])
        assert max(off.max(), (np.abs(found.x - x) / unit).max()) < 1e-3, seed
        right += 1
    assert min(refused, right) > 4


def test_a_mode_that_no_output_shows_is_followed_from_chunk_to_chunk():
    plant, y = plant_of(C=((1, -1, 0),)), np.ones((30, 1))
    whole = refusal(plant, y)
    assert "no output shows the unstable mode at 4," in whole
    for length in (1, 4, 10, 29):
        parts = iter(np.split(y, range(length, len(y), length)))
        assert refusal(plant, parts) == whole
    assert np.isfinite(lb.filter_data(plant, y[:10]).x).all()


# -- however the record is read ----------------------------------------------------


def refusal(*args, **options):
    with pytest.raises(lb.DesignError, match=REFUSED) as caught:
        found = lb.filter_data(*args, **options)
        list(found)
    return str(caught.value)


@pytest.mark.parametrize(
    "options",
    [dict(history=True), dict(settle=1e-6), dict(m1=1), dict(backend="numba")],
)
def test_every_way_refuses_alike(options):
    if "backend" in options:
        pytest.importorskip("numba", reason="numba is an optional extra")
    plant, y = plant_of(), record(20, first=90)
    assert refusal(plant, y, **options) == refusal(plant, y, backend="numpy")


@pytest.mark.parametrize("length", [1, 2, 5, 13, 23, 24])
def test_chunks_are_refused_as_the_whole(length):
    """And chunks are given up to the one with the row, of index 13."""
    plant, y = plant_of(), record(20)
    parts = lambda: iter(np.split(y, range(length, len(y), length)))  # noqa: E731
    assert refusal(plant, parts()) == refusal(plant, y)
    found = lb.filter_data(plant, parts())
    given = [len(next(found).x) for _ in range(13 // length)]
    assert sum(given) == 13 // length * length


def test_a_continuous_plant_is_refused_at_its_rows():
    A = MIX @ np.diag([1.5, -0.5, -1]) @ np.linalg.inv(MIX).round()
    plant = lb.Plant(A, None, [[1, 0, 0]], Q=np.eye(3), R=[[1]], P0=np.eye(3))
    y = record(20)
    even = np.arange(len(y))
    for time in (even, even**1.01):
        whole = refusal(plant, y, time=time)
        assert "on: outputs are missing from instant 4 on" in whole
        parts = (iter(np.split(X, [7, 9, 15])) for X in (y, time))
        assert refusal(plant, next(parts), time=next(parts)) == whole


def test_a_plant_that_changes():
    plant = plant_of()
    A = np.array([plant.A if k < 20 else 0.5 * np.eye(3) for k in range(40)])
    changing = lb.Plant(A, None, plant.C, dt=1.0, Q=plant.Q, R=plant.R, P0=plant.P0)
    assert refusal(changing, record(12)) == refusal(plant, record(12))
    assert np.isfinite(lb.filter_data(changing, record(10)).x).all()


def test_gaps_of_a_long_record_are_looked_at_one_by_one():
    """Past some thousand rows, short gaps and long ones, each by itself."""
    plant, N = plant_of(), 3 * growth.BLOCK
    y = np.random.default_rng(2).normal(size=(N, 1))
    y[::3] = np.nan
    for k in (5, 1020, 2045, 2990):
        y[k : k + 9] = np.nan
    assert np.isfinite(lb.filter_data(plant, y).x).all()
    for k in (4, 1019, 2050, N - 20):
        longer = y.copy()
        longer[k - 1 : k + 13], longer[k - 1] = np.nan, 0.0
        with pytest.raises(lb.DesignError, match=f"{REFUSED} {k + 11} on"):
            lb.filter_data(plant, longer)
        assert np.isfinite(lb.filter_data(plant, longer[: k + 10]).x).all()


def test_a_gap_longer_than_a_block_is_followed_through_all_of_it():
    """One output never comes, and the start is vague, so every block is looked at."""
    plant = plant_of(C=((1, 0, 0), (0, 1, 1)), P0=1e14 * np.eye(3))
    y = np.random.default_rng(2).normal(size=(2 * growth.BLOCK, 2))
    y[:, 1] = np.nan
    for k in (growth.BLOCK - 5, growth.BLOCK - 12, growth.BLOCK + 2):
        longer = y.copy()
        longer[k : k + 13] = np.nan
        with pytest.raises(
            lb.DesignError, match=f"{REFUSED} {k + 10} on: .* instant 1"
        ):
            lb.filter_data(plant, longer)


# -- the likelihood ----------------------------------------------------------------


@pytest.mark.parametrize("P0", [np.eye(3), None])
@pytest.mark.parametrize("what", ["log_likelihood", "score", "innovations"])
def test_a_likelihood_is_refused_as_well(what, P0):
    plant, y = plant_of(P0=P0, C=((1, 1, 1),)), record(20, first=6)
    with pytest.raises(lb.DesignError, match=f"{REFUSED} 17 on: .* instant 7 on"):
        getattr(lb.Filter(plant), what)(y)
    assert np.isfinite(lb.Filter(plant).log_likelihood([y[:6], y[26:]]))


def test_a_start_that_is_not_found_before_a_gap_is_not_found_behind_it():
    """The directions that grow fastest hide the others."""
    plant, y = plant_of(P0=None), record(20, first=6)
    with pytest.raises(lb.DesignError, match="does not determine where it starts"):
        lb.Filter(plant).log_likelihood(y)
    plant, y = plant_of(P0=None, C=((1, 1, 1), (1, 0, 0))), record(20, p=2, first=6)
    y[1:, 1] = np.nan
    with pytest.raises(lb.DesignError, match=f"{REFUSED} 1. on|does not determine"):
        lb.Filter(plant).log_likelihood(y)


def test_what_a_likelihood_has_behind_an_allowed_gap_is_right():
    """Beside exact densities: digits are there up to what is refused."""
    plant, y = plant_of(), record(10, behind=2)
    x, P = many_digits.filtered(plant, y)
    x_minus = np.vstack([np.zeros(3), x[:-1]]) @ plant.A.T
    before = np.concatenate([plant.P0[None], P[:-1]])
    M = (plant.C @ (plant.A @ before @ plant.A.T + plant.Q) @ plant.C.T)[:, 0, 0] + 1
    nu, seen = y[:, 0] - x_minus[:, 0], ~np.isnan(y[:, 0])
    wanted = -0.5 * (np.log(2 * np.pi * M) + nu**2 / M)[seen].sum()
    assert lb.Filter(plant).log_likelihood(y) == pytest.approx(wanted, rel=1e-6)


def test_a_fit_names_the_row():
    plant = plant_of(Q=None, R=None)
    y = np.random.default_rng(3).normal(size=(120, 1))
    y[60:90] = np.nan
    with pytest.raises(lb.DesignError, match=f"{REFUSED} 71 on"):
        lb.fit_noise(plant, y, Q=np.ones((3, 1)), R="diagonal")
