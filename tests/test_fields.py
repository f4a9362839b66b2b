"""Complex matrices and exact ones: kept as given, refused where they make no sense."""

from fractions import Fraction

import numpy as np
import pytest

import luenberger as lb

A, C = np.array([[1, 2j], [0.5, -0.0 - 1j]]), np.array([[1 + 1j / 3, -0.0]])


def test_complex_plant_and_observer_round_trip_bit_for_bit(tmp_path):
    plant = lb.Plant(A, [[1j], [0]], C, [[5e-324j]], dt=1.0)
    assert plant.is_complex and plant.A.dtype == complex
    plant.to_json(tmp_path / "plant.json")
    again = lb.Plant.from_json(tmp_path / "plant.json")
    for name in "ABCE":
        assert getattr(plant, name).tobytes() == getattr(again, name).tobytes(), name
    z = [[1j]]
    first = lb.Observer(z, z, z, z, z, z, [[1]], z, dt=1.0)
    first.to_json(tmp_path / "observer.json")
    again = lb.Observer.from_json(tmp_path / "observer.json")
    for name in "FGDPVTLW":
        assert getattr(first, name).tobytes() == getattr(again, name).tobytes(), name


@pytest.mark.parametrize(
    "entry, message",
    [
        ('{"real": [[1]], "imag": [[1], [2]]}', "imaginary one of shape"),
        ('{"real": [["1"]], "imag": [[1]]}', "array of real numbers"),
        ('{"real": [[1]]}', "must be numbers or lists"),
        ('{"real": [[1]], "imag": [[1]], "x": 1}', "must be numbers or lists"),
    ],
)
def test_bad_complex_json_is_refused(tmp_path, entry, message):
    path = tmp_path / "plant.json"
    path.write_text(f'{{"A": {entry}, "C": [[1]]}}')
    with pytest.raises(ValueError, match=message):
        lb.Plant.from_json(path)


def test_complex_dtype_without_imaginary_parts_is_real():
    plant = lb.Plant(np.eye(2) + 0j, None, [[1 + 0j, 0]])
    assert not plant.is_complex and plant.A.dtype == float


def test_certificate_of_a_complex_observer():
    plant = lb.Plant([[1j]], [[2 - 1j]], [[1j]], [[0.5j]], dt=1.0)
    # T A - F T = D C: 1j - 0.5 = D 1j; G = T B - D E; W = -V E
    D = (1j - 0.5) / 1j
    exact = dict(F=[[0.5]], G=[[2 - 1j - D * 0.5j]], D=[[D]], P=[[0.5]])
    rest = dict(V=[[0.5 / 1j]], T=[[1]], L=[[1]], W=[[-0.5 / 1j * 0.5j]], dt=1.0)
    assert lb.certify(lb.Observer(**exact, **rest), plant).worst < 1e-15
    wrong = exact | dict(D=[[np.conj(D)]])
    assert lb.certify(lb.Observer(**wrong, **rest), plant).dynamics > 0.1


@pytest.mark.parametrize(
    "use",
    [
        lambda plant, observer: lb.kalman_filter(plant),
        lambda plant, observer: lb.reduced_order_filter(plant, 1),
        lambda plant, observer: lb.Filter(plant).run([[1.0]]),
        lambda plant, observer: lb.error_covariance(observer, plant),
        lambda plant, observer: lb.simulate(plant, observer, 3),
        lambda plant, observer: lb.monte_carlo(
            plant, observer, runs=2, steps=2, seed=1
        ),
        lambda plant, observer: lb.estimate(observer, [[1.0]]),
    ],
)
def test_noise_and_simulation_refuse_complex_matrices(use):
    plant = lb.Plant([[1j]], None, [[1]], dt=1.0, Q=[[1]], R=[[1]], P0=[[1]])
    z = [[0.5j]]
    observer = lb.Observer(z, np.zeros((1, 0)), z, z, z, z, [[1]], dt=1.0)
    with pytest.raises(lb.DesignError, match="is for real matrices.*complex"):
        use(plant, observer)


def test_triangular_F_has_exactly_its_diagonal_as_poles():
    F = np.tril(np.ones((6, 6)), -1) - 0.25 * np.eye(6)
    for X in (F, F.T):
        observer = lb.Observer(
            X, np.zeros((6, 0)), np.zeros((6, 1)), np.eye(6), np.zeros((6, 1)),
            np.eye(6), np.eye(6),
        )  # fmt: skip
        assert (observer.poles == -0.25).all()
    F = np.tril(np.ones((6, 6)), -1)
    F[np.arange(6), np.arange(6)] = -1
    F[[0, 2, 4], [1, 3, 5]] = -1
    block = np.block([[F, np.zeros((6, 0))], [np.zeros((0, 6))]])
    observer = lb.Observer(
        block, np.zeros((6, 0)), np.zeros((6, 1)), np.eye(6), np.zeros((6, 1)),
        np.eye(6), np.eye(6),
    )  # fmt: skip
    assert np.abs(np.sort(observer.poles.imag) - np.repeat([-1, 1], 3)).max() < 1e-15


def test_exact_plants_keep_their_rationals():
    sp = pytest.importorskip("sympy")
    half = Fraction(1, 2)
    for A in ([[1, half], [0, 1]], sp.Matrix([[1, sp.Rational(1, 2)], [0, 1]])):
        plant = lb.Plant(A, None, [[sp.Integer(1), 0]])
        assert plant.exact["A"][0, 1] == half
        assert all(type(x) is Fraction for X in plant.exact.values() for x in X.flat)
        assert type(plant.exact["A"][0, 0].numerator) is int
        assert plant.exact["B"].shape == (2, 0) and plant.exact["E"].shape == (1, 0)
        assert plant.A.dtype == float and plant.A[0, 1] == 0.5
    whole = lb.Plant(np.eye(2, dtype=int), [[2**60 + 1], [0]], [[1, 0]])
    assert whole.exact["B"][0, 0] == 2**60 + 1
    assert whole.exact["E"].tolist() == [[0]]


@pytest.mark.parametrize("entry", [0.5, 1j, np.float64(1), True])
def test_one_float_makes_the_plant_inexact(entry):
    try:
        assert lb.Plant([[1, 0], [0, 1]], None, [[1, entry]]).exact is None
    except ValueError as error:
        assert entry is True and "bool" in str(error)
    assert lb.Plant([[1, 0], [0, 1]], [[0.1], [0]], [[1, 0]]).exact is None
