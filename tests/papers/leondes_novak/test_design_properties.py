"""What holds for every plant: hypothesis draws them, derandomized and bounded.

A failing example is shrunk to the smallest sizes and ranks and printed by name.
"""

import dataclasses
import json
import warnings

import generators
import numpy as np
import pytest
from drawn import bounded
from hypothesis import given, settings
from hypothesis import strategies as st

import luenberger as lb


@st.composite
def plants(draw, most=8, outputs=4, varying=True, full_rank=False):
    """Sizes, ranks and kinds are drawn; the numbers follow from a seed."""
    n, p = draw(st.integers(1, most)), draw(st.integers(1, outputs))
    rng = np.random.default_rng(draw(st.integers(0, 10**6)))
    rank = n + p if full_rank else draw(st.integers(0, n + p))
    kind = dict(
        m=draw(st.integers(0, 2)),
        rank=rank,
        cross=draw(st.booleans()),
        radius=draw(st.sampled_from([0.0, 0.5, 0.95, 1.0, 1.3])),
        at_first=draw(st.booleans()),
    )
    if draw(st.booleans()):
        kind["P0"] = np.zeros((n, n))
    if varying and draw(st.booleans()):
        return generators.varying(rng, n, p, 25, **kind)
    return generators.plant(rng, n, p, **kind)


def size(plant, P):
    """What rounding in P is measured against: P, and what it came from."""
    A = np.abs(plant.A).max() ** 2 * plant.n + 1
    return A * (np.abs(P).max() + np.abs(plant.P0).max()) + np.abs(plant.Q).max()


@bounded(60)
@given(plants(), st.data())
def test_a_certified_observer_or_a_refusal(plant, data):
    """Never NaN, never a warning, and covariances that are covariances."""
    m1 = data.draw(st.sets(st.integers(0, plant.p - 1)).map(sorted), label="m1")
    steps = 20 if plant.steps or data.draw(st.booleans()) else None
    horizon = "step" if steps else data.draw(st.sampled_from(["step", "steady"]))
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            observer = lb.reduced_order_filter(plant, m1, steps=steps, horizon=horizon)
        except (lb.DesignError, lb.CertificateError) as refusal:
            assert len(str(refusal)) > 40
            return
        certificate = lb.certify(observer, plant)
        covariance = lb.error_covariance(observer, plant, steps=steps)
    assert certificate.worst < 1e-9
    assert certificate.stable or steps
    assert observer.order == plant.n - len(m1)
    for name in "FGDPVTW":
        assert np.isfinite(getattr(observer, name)).all()
    np.testing.assert_array_equal(covariance, covariance.mT)
    least = np.linalg.eigvalsh(covariance).min()
    # rounding of the sums (11), (26), whose terms can be larger than the result
    terms = np.linalg.norm(observer.D) ** 2 + np.linalg.norm(observer.V) ** 2
    terms = terms * np.abs(plant.R).max() + size(plant, covariance)
    assert least >= -1e-11 * terms


@bounded(50)
@given(plants(), st.data())
def test_covariances_of_a_pass_are_semidefinite_and_finite(plant, data):
    m1 = data.draw(st.integers(0, plant.p), label="m1")
    rng = np.random.default_rng(1)
    y, u, u0 = generators.record(rng, plant, 20)
    y[rng.random(y.shape) < data.draw(st.sampled_from([0.0, 0.3]))] = np.nan
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        try:
            run = lb.Filter(plant, m1).run(lb.Record(y, u, u0=u0))
        except lb.DesignError as refusal:
            assert "dependent" in str(refusal) or "contradicts" in str(refusal)
            return
    np.testing.assert_array_equal(run.P, run.P.mT)
    assert np.linalg.eigvalsh(run.P).min() >= -1e-13 * size(plant, run.P)
    for part in (run.x, run.std, run.K):
        assert np.isfinite(part).all()


@bounded(6)
@given(
    st.sampled_from([(2, 1), (5, 2), (10, 4), (20, 5), (20, 1)]),
    st.booleans(),
    st.booleans(),
    st.integers(0, 10**6),
)
def test_order_n_is_the_kalman_filter_for_200_steps(sizes, cross, varying, seed):
    rng = np.random.default_rng(seed)
    make = generators.varying if varying else generators.plant
    rest = (200,) if varying else ()
    plant = make(rng, *sizes, *rest, cross=cross, radius=rng.choice([0.9, 1.05]))
    y, u, u0 = generators.record(rng, plant, 200)
    x, P, K = generators.kalman(plant, y, u, u0)
    run = lb.Filter(plant).run(lb.Record(y, u, u0=u0))
    for k in range(200):  # relative to each row, not to the largest
        assert generators.relative(run.P[k], P[k]) < 1e-12
        assert generators.relative(run.K[k], K[k]) < 1e-12
    assert generators.relative(run.x, x) < 1e-12
    observer = lb.kalman_filter(plant, steps=200)
    assert generators.relative(observer.V, K) < 1e-12


@bounded(25)
@given(plants(varying=False, full_rank=True), st.data())
def test_no_reduced_filter_beats_the_kalman_filter(plant, data):
    """P - P_kalman is semi-definite at every step, not only in the trace."""
    m1 = data.draw(st.integers(0, min(plant.p, plant.n)), label="m1")
    least = lb.error_covariance(lb.kalman_filter(plant, steps=15), plant, steps=15)
    found = lb.reduced_order_filter(plant, m1, steps=15)
    P = lb.error_covariance(found, plant, steps=15)
    gap = np.linalg.eigvalsh(P - least).min()
    assert gap >= -1e-11 * size(plant, P)


@bounded(25)
@given(plants(most=6, varying=False, full_rank=True), st.integers(0, 10**6), st.data())
def test_other_coordinates_with_the_matching_weight(plant, seed, data):
    """q = Z x with weight Z^-T Z^-1 is the same estimator; with weight I it is not."""
    m1 = data.draw(st.integers(0, min(plant.p, plant.n)), label="m1")
    rng = np.random.default_rng(seed)
    Z = np.linalg.qr(rng.normal(size=(plant.n, plant.n)))[0]
    Z = Z * rng.uniform(0.5, 2, size=plant.n)
    back = np.linalg.inv(Z)
    other = lb.Plant(
        Z @ plant.A @ back, Z @ plant.B, plant.C @ back, plant.E, dt=1.0,
        Q=Z @ plant.Q @ Z.T, R=plant.R, S=None if plant.S is None else Z @ plant.S,
        x0=Z @ plant.x0, P0=Z @ plant.P0 @ Z.T, at_first=plant.at_first,
    )  # fmt: skip
    y, u, u0 = generators.record(rng, plant, 15)
    a = lb.Filter(plant, m1).run(lb.Record(y, u, u0=u0))
    weight = back.T @ back
    b = lb.Filter(other, m1, weight=weight).run(lb.Record(y, u, u0=u0))
    scale = np.abs(a.x).max() + 1
    np.testing.assert_allclose(b.x @ back.T, a.x, rtol=0, atol=1e-9 * scale)
    moved = back @ b.P @ back.T
    np.testing.assert_allclose(moved, a.P, rtol=0, atol=1e-9 * size(plant, a.P))


@bounded(40)
@given(
    plants(most=5, varying=False, full_rank=True),
    st.sampled_from("FGDPVWT"),
    st.booleans(),
    st.data(),
)
def test_certificate_bites_on_any_entry(plant, name, over, data):
    m1 = data.draw(st.integers(0, min(plant.p, plant.n)), label="m1")
    sound = lb.reduced_order_filter(plant, m1, steps=6)
    if not over:
        try:
            sound = lb.reduced_order_filter(plant, m1)
        except ValueError:
            return  # a mode on the unit circle, refused elsewhere
    assert lb.certify(sound, plant).worst < 1e-11
    damaged = getattr(sound, name).copy()
    if damaged.size == 0:
        return
    where = data.draw(st.integers(0, damaged.size - 1), label="entry")
    damaged.flat[where] += 1e-3 * (1 + np.abs(damaged).max())
    broken = dataclasses.replace(sound, **{name: damaged})
    certificate = lb.certify(broken, plant)
    assert certificate.worst > 1e-8
    with pytest.raises(lb.CertificateError, match="residual"):
        certificate.require(1e-8, stable=False)


@pytest.fixture(scope="module")
def folder(tmp_path_factory):
    return tmp_path_factory.mktemp("json")


def test_json_brings_plants_and_observers_back_bit_for_bit(folder):
    @bounded(25)
    @given(plants(most=4), st.data())
    def check(plant, data):
        plant.to_json(folder / "plant.json")
        same(plant, lb.Plant.from_json(folder / "plant.json"))
        m1 = data.draw(st.integers(0, plant.p))
        try:
            observer = lb.reduced_order_filter(plant, m1, steps=5)
        except ValueError:
            return
        observer.to_json(folder / "observer.json")
        same(observer, lb.Observer.from_json(folder / "observer.json"))

    check()


def same(one, other):
    for field in dataclasses.fields(one):
        a, b = getattr(one, field.name), getattr(other, field.name)
        if isinstance(a, np.ndarray):
            assert a.shape == b.shape and a.tobytes() == b.tobytes(), field.name
        else:
            assert a == b, field.name


@pytest.mark.parametrize(
    "value", [5e-324, 1.7976931348623157e308, -0.0, 0.1 + 0.2, 1 / 3, 2**53 + 1.0]
)
def test_json_keeps_awkward_numbers(folder, value):
    plant = lb.Plant([[value]], None, [[1]], dt=1.0)
    plant.to_json(folder / "one.json")
    assert lb.Plant.from_json(folder / "one.json").A.tobytes() == plant.A.tobytes()


CODE = "__import__('pathlib').Path('{trap}').write_text('run')"
HOSTILE = {
    "code as A": {"A": CODE},
    "code as an entry": {"A": [[CODE]]},
    "code as dt": {"dt": CODE},
    "code as at_first": {"at_first": CODE},
    "code as P0_is": {"P0_is": CODE},
    "code as an unknown key": {CODE: [[1]]},
    "a dunder key": {"__class__": "os.system"},
    "a tag": {"A": {"py/object": "os.system", "shape": [0, 1]}},
    "a huge empty shape": {"A": {"shape": [0, 10**9]}},
    "a negative shape": {"A": {"shape": [0, -1]}},
    "a shape of code": {"A": {"shape": [0, CODE]}},
    "text for numbers": {"A": [["1"]]},
    "null for a number": {"A": [[None]]},
    "true for a number": {"A": [[True]]},
    "a ragged matrix": {"A": [[1, 2], [3]]},
    "a deep nest": {"A": [[[[[1]]]]]},
    "a huge integer": {"A": [[10**400]]},
    "a list for dt": {"dt": [1]},
    "true for dt": {"dt": True},
    "a number as names": {"state_names": 7},
    "numbers as names": {"state_names": [7]},
    "an object in the middle": {"A": [[{"re": 1, "im": 0}]]},
    "a number for multiplicative": {"multiplicative": 3},
    "numbers in multiplicative": {"multiplicative": [3]},
    "an object for the name": {"name": {"first": "x"}},
    "no A": {"A": None},
}


@pytest.mark.parametrize("change", HOSTILE.values(), ids=HOSTILE.keys())
def test_hostile_json_is_refused_and_never_run(tmp_path, change):
    trap = tmp_path / "trap"
    data = {"A": [[1]], "C": [[1]], "dt": 1.0} | change
    text = json.dumps(data).replace("{trap}", str(trap))
    (tmp_path / "plant.json").write_text(text)
    with pytest.raises(ValueError):
        lb.Plant.from_json(tmp_path / "plant.json")
    assert not trap.exists()


@pytest.mark.parametrize(
    "text",
    [
        '{"A": [[NaN]], "C": [[1]]}',
        '{"A": [[Infinity]], "C": [[1]]}',
        '{"A": [[1e999]], "C": [[1]]}',
        '{"A": [[-1e999]], "C": [[1]]}',
        '{"A": [[1]], "C": [[1]], "dt": 1e999}',
        '{"A": [[1]], "C": [[1]], "dt": NaN}',
        "[" * 100000 + "]" * 100000,
        '{"A": ' + "[" * 5000 + "1" + "]" * 5000 + ', "C": [[1]]}',
        '{"A": [[' + "9" * 5000 + ']], "C": [[1]]}',
        "[[1]]",
        "7",
        '"plant"',
        "null",
        "",
        "import os",
        "\x00\x01",
        '{"A": [[1]], "C": [[1]]',
    ],
    ids=lambda text: repr(text[:24]),
)
@pytest.mark.parametrize("kind", [lb.Plant, lb.Observer])
def test_what_is_not_a_record_is_refused(tmp_path, kind, text):
    path = tmp_path / "bad.json"
    path.write_text(text)
    with pytest.raises(ValueError, match="bad.json"):
        kind.from_json(path)


def test_bytes_that_are_no_text_are_refused(tmp_path):
    path = tmp_path / "bad.json"
    path.write_bytes(b"\xff\xfe\x00{")
    with pytest.raises(ValueError, match="bad.json"):
        lb.Plant.from_json(path)


def test_the_long_run_draws_more_and_others():
    usual = settings.get_current_profile_name()
    try:
        settings.load_profile("long")
        long = bounded(7)
    finally:
        settings.load_profile(usual)
    assert (long.max_examples, long.derandomize) == (140, False)
    assert (bounded(7).max_examples, bounded(7).derandomize) == (7, True)
