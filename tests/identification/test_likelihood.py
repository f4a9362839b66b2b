"""The likelihood of a record, against statsmodels, exact rationals and batches."""

import pytest

import luenberger as lb

nan = float("nan")
BACKENDS = ("numpy", "numba")


def nile():
    import statsmodels.datasets.nile as data

    return data.load_pandas().data["volume"].to_numpy(float)


@pytest.mark.parametrize("backend", BACKENDS)
def test_nile_with_a_wide_start(backend):
    """The local level with a prior variance of 10^7, the first year included."""
    plant = lb.Plant(
        [[1]], None, [[1]], dt=1.0, Q=[[1469.1]], R=[[15099.0]], P0=[[1e7]],
        P0_is="prior",
    )  # fmt: skip
    found = lb.log_likelihood(plant, nile(), backend=backend)
    assert round(found, 2) == -641.59
