"""NumPy 2.5 returns eigenvalues as complex numbers, also real ones: nothing changes."""

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.check import examine
from luenberger.numeric.detectability import hidden_modes
from luenberger.numeric.linalg import eigenvalues

PLANT = generators.plant(np.random.default_rng(2), 4, 2, m=1)
HARBOUR = lb.Plant(
    [[0.9, 0], [0.1, 0.5]], None, [[0, 1]], dt=1.0, Q=np.eye(2), R=[[1]], P0=np.eye(2)
)
GROWING = lb.Plant([[2.0, 0], [0, 0.5]], None, [[0, 1.0]], dt=1.0, Q=np.eye(2), R=[[1]])


def numbers(observer):
    return [getattr(observer, name) for name in "FGDPVTWL"]


def refusal(design):
    with pytest.raises(ValueError) as caught:
        design(GROWING)
    return str(caught.value)


RESULTS = {
    "Kalman": lambda: numbers(lb.kalman_filter(PLANT)),
    "reduced order": lambda: numbers(lb.reduced_order_filter(PLANT, 1)),
    "fixed order": lambda: numbers(lb.fixed_order_filter(HARBOUR, 1, starts=2)),
    "placed poles": lambda: numbers(lb.reduced_order_observer(PLANT, [0.1, 0.2])),
    "deadbeat": lambda: numbers(lb.deadbeat_observer(HARBOUR)),
    "functional": lambda: numbers(lb.functional_observer(HARBOUR, [[1.0, 0.0]])),
    "modal": lambda: numbers(lb.kalman_filter(HARBOUR).modal()),
    "balanced": lambda: numbers(lb.kalman_filter(HARBOUR).balanced()),
    "poles": lambda: [lb.kalman_filter(PLANT).poles],
    "poles of blocks": lambda: [eigenvalues(np.diag([3.0, 2.0, 1.0]) + np.eye(3, k=1))],
    "hidden": lambda: [hidden_modes(GROWING.A, GROWING.C)],
    "sentence": lambda: str(examine(PLANT)),
    "table": lambda: str(lb.compare(HARBOUR)),
    "refused": lambda: refusal(lb.kalman_filter),
    "refused at a fixed order": lambda: refusal(lambda p: lb.fixed_order_filter(p, 1)),
}


@pytest.fixture
def newest(monkeypatch):
    eig, eigvals = np.linalg.eig, np.linalg.eigvals

    def complex_eig(matrix):
        return type(eig(matrix))(*(X.astype(complex) for X in eig(matrix)))

    monkeypatch.setattr(np.linalg, "eig", complex_eig)
    monkeypatch.setattr(np.linalg, "eigvals", lambda A: eigvals(A).astype(complex))


@pytest.mark.parametrize("name", RESULTS)
def test_no_result_depends_on_the_type_of_eigenvalues(name, request):
    before = RESULTS[name]()
    request.getfixturevalue("newest")
    after = RESULTS[name]()
    if isinstance(before, str):
        assert after == before
        return
    for one, other in zip(before, after, strict=True):
        np.testing.assert_allclose(other, one, rtol=1e-12, atol=1e-14)
        if name not in ("poles", "hidden", "poles of blocks"):
            assert np.isrealobj(other)
