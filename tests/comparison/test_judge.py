"""What a design costs and leaves: exact, sound and zero, ratios, work, settling."""

import dataclasses
import re
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

import luenberger as lb
from luenberger.certificate import Certificate
from luenberger.comparison import METHODS, Design
from luenberger.comparison.judge import (
    Beside,
    noise_gain,
    settling_time,
    steady_covariance,
)
from luenberger.export import to_c

KALMAN, NOVAK, FIXED, REDUCED, DEADBEAT, FUNCTIONAL = METHODS
PLANTS = Path(__file__).parents[2] / "notebooks" / "plants"


def few(plant, *methods, **more):
    return lb.compare(plant, lb.candidates(plant, methods=methods), **more)


def covariance(observer, plant):
    return steady_covariance(observer, plant, lb.certify(observer, plant))


# -- what nothing drives ---------------------------------------------------------------


def resting(gain, R=1.0, C=1.0):
    """x+ = x / 2 with no noise, and its filter with this gain instead of 0."""
    plant = lb.Plant([[0.5]], None, [[C]], dt=1.0, Q=[[0.0]], R=[[R]])
    left = 1 - gain * C
    observer = lb.Observer(
        [[0.5 * left]], np.zeros((1, 0)), [[0.5 * gain]], [[left]], [[gain]],
        T=[[1.0]], L=[[1.0]], dt=1.0,
    )  # fmt: skip
    lb.certify(observer, plant).require()
    return observer, plant


@pytest.mark.parametrize(
    ("R", "C"), [(1.0, 1.0), (1e6, 1.0), (1.0, 1e-3), (1e-12, 8.0)]
)
@pytest.mark.parametrize(("part", "kept"), [(1.05e-14, True), (0.95e-14, False)])
def test_variance_that_a_gain_of_rounding_lets_in_is_zero(part, kept, R, C):
    """x is known to be 0, so its best gain is 0 and what R does is rounding.

    e+ = (1 - g C) e / 2 - g v has the variance g^2 R / (1 - (1 - g C)^2 / 4), about
    4/3 g^2 R; it is compared with R / C^2, that of an estimate y / C.
    """
    observer, plant = resting(part * np.sqrt(3 / 4) / C, R, C)
    found = covariance(observer, plant)[0, 0]
    assert found == (
        pytest.approx(part**2 * R / C**2, rel=1e-6, abs=0) if kept else 0.0
    )


@pytest.mark.parametrize(("part", "kept"), [(1.05e-14, True), (0.95e-14, False)])
def test_an_output_that_does_not_see_a_state_lets_nothing_into_it(part, kept):
    """Of two states at rest one is measured; the least that R lets in is into that."""
    one, _ = resting(part * np.sqrt(3 / 4))
    zero, half = np.zeros((2, 1)), 0.5 * np.eye(2)
    half[0, 0] = one.F[0, 0]
    P = np.diag([one.P[0, 0], 1.0])
    plant = lb.Plant(0.5 * np.eye(2), None, [[1, 0]], dt=1.0, Q=0 * P, R=[[1.0]])
    observer = lb.Observer(
        half, zero[:, :0], [one.D[0], [0]], P, [one.V[0], [0]], T=np.eye(2),
        L=np.eye(2), dt=1.0,
    )  # fmt: skip
    lb.certify(observer, plant).require()
    found = covariance(observer, plant)
    wanted = [pytest.approx(part**2, rel=1e-6, abs=0) if kept else 0.0, 0.0]
    assert found.diagonal().tolist() == wanted


def test_without_outputs_nothing_is_let_in():
    plant = lb.Plant(
        [[0.5]], None, np.zeros((0, 1)), dt=1.0, Q=[[0]], R=np.zeros((0, 0))
    )
    zero = np.zeros((1, 0))
    observer = lb.Observer([[0.5]], zero, zero, [[1]], zero, T=[[1]], L=[[1]], dt=1.0)
    assert covariance(observer, plant) == 0


def test_variance_of_what_is_driven_is_kept_however_small():
    observer, plant = resting(1e-15)
    driven = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1e-40]], R=[[1.0]])
    assert covariance(observer, driven)[0, 0] > 0


@pytest.mark.parametrize(
    ("A", "q", "L", "error"),
    [
        ([[0.9, 0.1], [0, 0.8]], [0, 0], None, 0),
        ([[0.9, 0.1], [0, 0.8]], [1, 0], [0, 1], 0),
        ([[1.2, 0.1], [0, 0.8]], [0, 0], None, (1.44 - 1) / 1.44),
        ([[0.9, 0.0], [0, 0.8]], [1e-60, 0], None, 1e-60 / 0.19),
    ],
    ids=["nothing driven", "L x not driven", "grows undriven", "hardly driven"],
)
def test_what_nothing_drives_is_known_without_error(A, q, L, error):
    plant = lb.Plant(A, None, [[1.0, 0]], Q=np.diag(q), R=[[1.0]], dt=1.0)
    table = few(plant, KALMAN, NOVAK, DEADBEAT, L=L)
    found = table.find(KALMAN).trace
    assert found == 0 if error == 0 else found == pytest.approx(error, rel=0.3, abs=0)
    if error == 0:
        worst = table.find(DEADBEAT)
        assert worst.trace > 1 and table.excess(worst) == np.inf
        assert L or "is not zero, and that of the Kalman" in table.reasons()[-1]
        assert "unbounded" in repr(table)


# -- exact and sound -------------------------------------------------------------------


@pytest.mark.parametrize(("worst", "exact"), [(0.9e-9, True), (1.1e-9, False)])
def test_exact_is_what_a_certificate_requires(worst, exact):
    certificate = Certificate(0.0, 0.0, worst, 0.0, np.array([0.5]), True)
    one = Design(KALMAN, certificate=certificate)
    assert one.exact is exact and one.sound is exact
    if exact:
        certificate.require()
    else:
        with pytest.raises(lb.CertificateError, match="output residual is 1.1e-09"):
            certificate.require()


@pytest.mark.parametrize(("worst", "sound"), [(0.9e-8, True), (1.1e-8, False)])
def test_sound_is_what_an_optimum_requires(worst, sound):
    conditions = dict.fromkeys(
        "F D P V riccati estimate adjoint idempotent".split(), 0.0
    )
    conditions |= dict.fromkeys("aligned trace cost".split(), 0.0)
    matrices = dict.fromkeys("tau Q Qh Ph G Gam".split())
    found = lb.optimality.__globals__["Optimality"](**conditions | matrices)
    object.__setattr__(found, "adjoint", worst)
    certificate = SimpleNamespace(worst=1.0, stable=True)
    one = Design(FIXED, certificate=certificate, optimality=found)
    assert one.sound is sound


def test_numbers_are_those_of_the_library(table):
    plant = table.plant
    one = table.find(NOVAK, accurate=(0,), horizon="steady")
    observer = lb.reduced_order_filter(plant, [0], horizon="steady")
    np.testing.assert_allclose(one.observer.V, observer.V, rtol=1e-9, atol=1e-9)
    left = lb.error_covariance(observer, plant)
    np.testing.assert_allclose(one.covariance, left, rtol=1e-9)
    np.testing.assert_allclose(one.sigma, np.sqrt(left.diagonal()), rtol=1e-9)
    assert one.order == observer.order == 2
    assert one.work == lb.export.multiply_adds(one.observer)
    assert one.cond == lb.certify(one.observer, plant).cond
    assert one.certificate.worst == lb.certify(one.observer, plant).worst
    assert one.worst_pole == pytest.approx(np.abs(observer.poles).max(), rel=1e-12)
    assert one.errors == {"nominal": one.error}


def test_fixed_order_filters_carry_their_optimality():
    A = [[0.8, 0.2, 0], [0, 0.6, 0.3], [0.1, 0, 0.5]]
    given = dict(dt=1.0, Q=np.diag([1.0, 0.5, 0.2]), R=[[0.1]])
    plant = lb.Plant(A, None, [[1, 0, 0]], **given)
    found = few(plant, KALMAN, FIXED)
    fixed = [one for one in found.designs if one.method == FIXED]
    assert [one.order for one in fixed] == [1, 1, 2, 2]
    assert [bool(one.observer.V.any()) for one in fixed] == [True, False] * 2
    for one in fixed:
        assert one.optimality.worst < 1e-8 and one.sound and not one.exact
        assert one.optimality.cost == pytest.approx(one.trace, rel=1e-9)
        assert one.cond is None
    assert found.recommended(1.0).method == FIXED
    assert any("It is not exact" in words for words in found.reasons(1.0))


def test_certificates_are_made_once(monkeypatch):
    """One for each design that is measured, beside those that designs make."""
    from luenberger.comparison import judge

    made, real = [], judge.certify

    def counted(observer, plant):
        made.append(observer)
        return real(observer, plant)

    monkeypatch.setattr(judge, "certify", counted)
    plant = oven()
    own = {"a": lb.kalman_filter(plant), "b": lb.deadbeat_observer(plant)}
    lb.compare(plant, own)
    assert len(made) == 3  # and the Kalman filter that errors are measured beside


# -- ratios ----------------------------------------------------------------------------


def oven(units=(1.0, 1.0, 1.0), R=(0.1, 0.05)):
    """Three states, the last one a small current; `units` are those of the states."""
    A = np.array([[0.9, 0.3, 0], [0, 0.8, 0.2], [0.05, 0, 0.7]])
    S, C = np.asarray(units), np.array([[1.0, 0, 0], [0, 0, 1.0]])
    Q = np.diag([1.0, 0.5, 0.01]) * np.outer(S, S)
    names = ["temperature (K)", "speed (rad/s)", "current (A)"]
    moved = A * S[:, None] / S
    return lb.Plant(moved, None, C / S, dt=1.0, Q=Q, R=np.diag(R), state_names=names)


@pytest.fixture(scope="module")
def table():
    return lb.compare(oven())


def test_ratios_by_hand(table):
    best = table.yardstick.sigma
    assert table.yardstick.method == KALMAN and (table.yardstick.ratios == 1).all()
    for one in table.ranked:
        by_hand = one.sigma / best
        np.testing.assert_allclose(one.ratios, by_hand, rtol=1e-9)
        assert one.error == one.worst_ratio == pytest.approx(by_hand.max())
        assert one.mean_ratio == pytest.approx(by_hand.mean())
        assert table.excess(one) >= 0


def test_no_units_of_the_states_decide(table):
    units = 2.0 ** np.array([40, -40, 10])
    other = few(oven(units), KALMAN, DEADBEAT)
    for one in other.designs:
        np.testing.assert_allclose(one.ratios, table.find(one.method).ratios, rtol=1e-9)
    scale = np.array([1, 1, 0.01])
    mine, theirs = (
        few(oven(u), NOVAK, scale=scale * u).ranked for u in (np.ones(3), units)
    )
    for one, same in zip(mine, theirs, strict=True):
        assert one.error == pytest.approx(same.error, rel=1e-6), one.name


def test_the_trace_would_take_a_design_that_spoils_the_current(table):
    within = [o for o in table.ranked if o.trace <= 1.05 * table.yardstick.trace]
    least = min(within, key=lambda one: one.work)
    assert least.ratios[2] > 1.7  # in amperes the sensor's own error
    chosen = table.recommended()
    assert chosen.worst_ratio <= 1.1 and chosen.work > least.work
    assert table.table.header[3:5] == ["worst state", "mean state"]


def test_a_scale_weighs_states_and_designs():
    scale = [1.0, 1.0, 0.01]
    plain, scaled = (
        few(oven(), KALMAN, NOVAK, DEADBEAT, scale=one) for one in (1.0, scale)
    )
    first = lb.candidates(oven(), methods=FIXED, orders=1)
    fixed, best = (lb.compare(oven(), first, scale=one) for one in (1.0, scale))
    for one in plain.ranked:
        assert one.error == pytest.approx(np.sqrt(one.trace / 3), rel=1e-12)
    for one in (*plain.ranked, *fixed.ranked):
        table = best if one.method == FIXED else scaled
        same = table.find(one.method, label=one.label)
        size = np.sqrt(np.mean((same.sigma / scale) ** 2))
        assert same.error == pytest.approx(size, rel=1e-12)
        if one.method in (FIXED, NOVAK) and one.horizon != "step":
            mine = np.sqrt(np.mean((one.sigma / scale) ** 2))
            assert same.error <= mine * (1 + 1e-9), one.name
    (one, *_), (same, *_) = fixed.designs, best.designs
    mine = np.sqrt(np.mean((one.sigma / scale) ** 2))
    assert same.sound and same.error < 0.97 * mine
    assert "error in the given scale is at most 10 %" in scaled.reasons()[0]
    assert scaled.table.header[3:5] == ["error in scale", "above the best"]


@pytest.mark.parametrize(
    ("scale", "said"),
    [([1, 2], r"shape \(3,\)"), ([1, 0, 1], "all are positive"), (-1, "positive"),
     ([1, np.nan, 1], "not finite")],
)  # fmt: skip
def test_a_scale_that_makes_no_sense(scale, said):
    with pytest.raises(ValueError, match=f"scale .*{said}"):
        lb.compare(oven(), scale=scale)


def test_a_perfect_sensor_leaves_nothing_to_divide_by():
    found = few(oven(R=(0.0, 0.05)), KALMAN, NOVAK)
    exact = found.find(NOVAK, accurate=(0,), horizon="steady")
    assert exact.ratios[0] == 1 == found.yardstick.ratios[0] and exact.error < 1.0001
    beside = Beside(np.array([0.0, 4.0]), np.array([1e-14, 1e-14]))
    assert beside.error(np.array([1e-15, 9.0])) == 1.5
    assert beside.error(np.array([1e-13, 9.0])) == np.inf


def test_without_the_kalman_filter_in_the_table_it_is_still_what_one_is_beside():
    some = few(oven(), DEADBEAT)
    (one,) = some.designs
    best = lb.error_covariance(lb.kalman_filter(oven()), oven()).diagonal()
    np.testing.assert_allclose(one.ratios, one.sigma / np.sqrt(best), rtol=1e-9)
    assert some.excess(one) == 0 and some.recommended() is one
    assert "beside that of the Kalman filter, is at most" in some.reasons()[0]


def test_where_no_kalman_filter_is_the_most_accurate_design_is_the_measure():
    """Two states, the second unseen and at rest on the circle: no steady filter."""
    deaf = lb.Plant(np.diag([0.5, 1.0]), None, [[1, 0]], dt=1.0, Q=np.eye(2), R=[[1.0]])
    with pytest.raises(lb.DesignError):
        lb.kalman_filter(deaf)
    own = [
        lb.Observer([[0.5 * (1 - k)]], [[]], [[0.5 * (1 - k) * k]], [[1.0]], [[k]],
                    T=[[1 - k, 0]], L=[[1, 0]], dt=1.0)
        for k in (0.4, 0.6)
    ]  # fmt: skip
    found = [one.error for one in lb.compare(deaf, own)]
    assert min(found) == 1 < max(found) < 1.2


def test_rows_of_L_are_judged_each_by_itself():
    L = np.array([[1.0, -1, 0], [0, 0, 1000]])
    found = few(oven(), KALMAN, DEADBEAT, L=L)
    one = found.find(DEADBEAT)
    np.testing.assert_allclose(one.ratios, one.sigma / found.yardstick.sigma)
    assert "row of L x" in " ".join(found.reasons(1000))


def test_every_design_estimates_L_x_and_is_counted_for_it_alone(table):
    L = np.array([[1.0, -1, 0]])
    found = lb.compare(oven(), L={"difference (K)": L[0]})
    assert {one.observer.L.shape for one in found.designs} == {(1, 3)}
    assert found.estimates == ("difference (K)",)
    for one in found.designs:
        if one.method == FUNCTIONAL or one.method == FIXED:
            continue
        other = table.find(one.method, label=one.label)
        assert one.work <= other.work and one.bytes <= other.bytes
        assert one.method != KALMAN or one.work < other.work
        left = lb.error_covariance(other.observer.combined(L), oven()).item()
        if one.horizon != "steady":
            assert one.trace == pytest.approx(left, rel=1e-9)
        else:
            assert one.trace <= left * (1 + 1e-9)
    moore = found.find(FUNCTIONAL)
    assert moore.order == lb.functional_observer(oven(), L).order
    # a deviation, as the percentage beside it is of one
    assert found.table.header[3:5] == ["sigma of difference (K)", "above the best"]
    best = found.find(KALMAN).sigma[0]
    for cells, one in zip(found.table.rows, found.designs, strict=True):
        sigma, above = float(cells[3]), cells[4].split()
        assert sigma == pytest.approx(one.sigma[0], rel=1e-3)
        if above[1] == "%":
            assert 100 * (sigma / best - 1) == pytest.approx(float(above[0]), abs=0.02)


@pytest.mark.parametrize(
    ("L", "rows", "called"),
    [
        ("speed (rad/s)", [[0, 1, 0]], ("speed (rad/s)",)),
        ("pull (N)", [[2, 0, 1]], ("pull (N)",)),
        (
            ["pull (N)", "current (A)"],
            [[2, 0, 1], [0, 0, 1]],
            ("pull (N)", "current (A)"),
        ),
        ([1, 1, 0], [[1, 1, 0]], ("row 1 of L x",)),
        (None, [[2, 0, 1]], ("pull (N)",)),
    ],
)
def test_what_is_estimated_is_named_as_elsewhere(L, rows, called):
    plant = dataclasses.replace(oven(), estimates={"pull (N)": [2, 0, 1]})
    found = few(plant, KALMAN, L=L)
    assert found.estimates == called
    np.testing.assert_array_equal(found.rows, rows)
    names = lb.compare(oven(), [lb.kalman_filter(oven(), L={"pull (N)": [2, 0, 1]})])
    assert names.estimates == ("pull (N)",)


# -- work ------------------------------------------------------------------------------


@pytest.mark.parametrize("name", ["tracker", "ball-and-beam"])
def test_work_is_that_of_the_exported_source(name, tmp_path):
    """Products and sums are counted in the text of the C, not by our own count."""
    plant = lb.Plant.from_json(PLANTS / f"{name}.json")
    if plant.dt == 0:  # its noise is not known
        plant = dataclasses.replace(plant, Q=1e-4 * np.eye(plant.n), R=[[1e-6]])
        plant = plant.sampled(0.1)
    for table in lb.compare(plant), lb.compare(plant, L=np.eye(plant.n)[0]):
        for one in table.designs:
            source, header = to_c(one.observer, tmp_path)
            text = source.read_text().partition("_estimate(")[2].partition("#ifdef")[0]
            sums = re.findall(r"const double \w+ = ([^[;]+);", text)
            terms = sum(1 + s.count(" + ") + s.count(" - ") for s in sums)
            numbers = sum(s.count(" * ") for s in sums)
            assert one.work == terms == lb.export.multiply_adds(one.observer)
            assert one.bytes == 8 * (numbers + one.order)
            said = header.read_text()
            words = "multiply-adds", "operations", "bytes of state and constants"
            found = [int(re.search(rf"(\d+) {what}", said)[1]) for what in words]
            assert found == [*one.cost]


def test_float_counts_half_the_bytes_and_the_same_work(table):
    narrow = lb.compare(oven(), budget=dict(dtype="float"))
    assert (
        "bytes (float)" in narrow.table.header and "budget" not in narrow.table.header
    )
    assert [2 * one.bytes for one in narrow.designs] == [
        one.bytes for one in table.designs
    ]


def test_noise_gain_is_what_v_alone_does(table):
    plant = lb.Plant([[0.5]], None, [[1]], dt=1.0, Q=[[1]], R=[[4]])
    observer = lb.Observer([[0.5]], [[]], [[1]], [[0.5]], [[0.25]], [[1]], [[1]], dt=1)
    # V^2 R + P^2 X, X = D^2 R / (1 - F^2): the certificate plays no part
    by_hand = np.sqrt(0.25**2 * 4 + 0.5**2 * 4 / (1 - 0.25))
    found = noise_gain(observer, plant, lb.certify(observer, plant))
    assert found == pytest.approx(by_hand, rel=1e-12)
    kalman = table.find(KALMAN)
    assert kalman.noise_gain**2 < kalman.trace
    quiet = dataclasses.replace(oven(R=(1.0, 1.0)), Q=None)
    unit = few(dataclasses.replace(quiet, R=None), DEADBEAT).designs[0]
    same = few(quiet, DEADBEAT).designs[0]
    assert unit.noise_gain == pytest.approx(same.noise_gain, rel=1e-9)
    k = np.array([[0, 0, 2.0]])
    for one in few(
        dataclasses.replace(quiet, R=None), REDUCED, FUNCTIONAL, L=k
    ).designs:
        F, D, P, V = (getattr(one.observer, name) for name in "FDPV")
        total, response = (V @ V.T).trace(), D
        for _ in range(3000):
            total += (P @ response @ response.T @ P.T).trace()
            response = F @ response
        assert one.noise_gain == pytest.approx(np.sqrt(total), rel=1e-9)


def test_order_zero():
    """Every state measured: no poles, and a matrix product is all there is."""
    plant = lb.Plant([[0.5]], None, [[1.0]], Q=[[1.0]], R=[[0.0]], dt=1.0)
    table = lb.compare(plant)
    assert table.yardstick.trace == pytest.approx(0, abs=1e-15)
    assert table.recommended().order == 0 == table.recommended().work
    assert table.recommended().worst_pole == 0
    (one,) = lb.compare(lb.Plant([[-1.0]], None, [[1.0]])).designs
    assert one.worst_pole == -np.inf and one.settling == 0


ODD = {
    "complex": (
        lb.Plant([[0.5, 1], [0, 0.3j]], None, [[1, 0]], dt=1.0),
        [REDUCED, REDUCED, REDUCED, DEADBEAT],
    ),
    "no outputs": (
        lb.Plant([[0.5]], None, np.zeros((0, 1)), dt=1.0, Q=[[1]], R=np.zeros((0, 0))),
        [KALMAN],
    ),
    "feedthrough": (
        lb.Plant([[0.5]], [[1]], [[1]], [[2]], dt=1.0, Q=[[1]], R=[[1]]),
        [KALMAN, NOVAK, NOVAK, REDUCED, DEADBEAT],
    ),
}


@pytest.mark.parametrize(("plant", "methods"), ODD.values(), ids=ODD)
def test_odd_plants_get_what_applies(plant, methods):
    found = lb.compare(plant)
    assert [one.method for one in found.designs] == methods
    assert all(one.refusal for one in found.refused) and found.reasons()


# -- settling --------------------------------------------------------------------------


def observer(F, dt):
    F = np.atleast_2d(F)
    r, none = len(F), np.zeros((1, 0))
    D, P = np.zeros((r, 1)), np.ones((1, r))
    return lb.Observer(F, D[:, :0], D, P, [[0]], T=P.T, L=[[1]], W=none, dt=dt)


@pytest.mark.parametrize(
    ("F", "dt", "seconds"),
    [
        ([[0.1]], 0.5, 1.0),
        ([[0.0999]], 0.5, 1.0),
        ([[0.1001]], 0.5, 1.5),
        ([[-0.1]], 0.5, 1.0),
        ([[0.5]], 2.0, 14.0),  # 0.5^7 = 0.8 %
        ([[0.0, 1], [0, 0]], 0.5, 1.0),
        ([[0.0, 1], [1e-17, 0]], 0.5, 1.0),  # rounding beside a pole of zero
        ([[0.0, 1, 0], [0, 0, 1], [0, 0, 0]], 0.5, 1.5),
        ([[0.0, 0], [0, 0]], 0.5, 0.5),
        ([[1.0]], 0.5, np.inf),
        ([[-2.0]], 0.0, np.log(100) / 2),
        ([[0.0, 1], [-1, 0]], 0.0, np.inf),
        (np.zeros((0, 0)), 0.5, 0.0),
        (np.zeros((0, 0)), 0.0, 0.0),
    ],
)
def test_settling_is_when_one_percent_is_left(F, dt, seconds):
    assert settling_time(observer(F, dt)) == pytest.approx(seconds, rel=1e-12)
