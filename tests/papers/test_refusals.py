"""Every refusal says what is wrong, which matrix, output or mode, and what to do."""

import numpy as np
import pytest

import luenberger as lb

STACK = np.stack([np.eye(2)] * 4)


def plant(**changes):
    parts = dict(
        A=[[1, 1], [0, 1]], B=[[0.5], [1]], C=[[1, 0], [2, 0]], dt=1.0,
        Q=np.eye(2), R=np.eye(2), P0=np.eye(2), output_names=["radar", "laser"],
    ) | changes  # fmt: skip
    return lb.Plant(parts.pop("A"), parts.pop("B"), parts.pop("C"), **parts)


def observer(**options):
    return lb.kalman_filter(plant(), **options)


@pytest.mark.parametrize(
    "request_, error, message",
    [
        (
            lambda: lb.kalman_filter(plant(dt=0)),
            lb.DesignError,
            "discrete time.*dt = 0",
        ),
        (lambda: lb.kalman_filter(plant(Q=None)), lb.DesignError, "no Q.*process"),
        (lambda: lb.kalman_filter(plant(R=None)), lb.DesignError, "no R.*measurement"),
        (
            lambda: lb.kalman_filter(plant(P0=None), steps=3),
            lb.DesignError,
            "covariance P0 of the initial",
        ),
        (
            lambda: lb.kalman_filter(
                plant(multiplicative=[(np.eye(2), np.zeros((2, 2)))])
            ),
            lb.DesignError,
            "multiplicative noise, which this filter does not model",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), 2),
            lb.DesignError,
            r"accurate outputs \['radar', 'laser'\] are linearly dependent.*fewer",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), 3),
            lb.DesignError,
            "m1 must be between 0 and p = 2, got 3",
        ),
        (lambda: lb.reduced_order_filter(plant(), -1), lb.DesignError, "got -1"),
        (
            lambda: lb.reduced_order_filter(plant(), ["sonar"]),
            lb.DesignError,
            r"'sonar' is not an output.*'radar', 'laser'",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), [0, "radar"]),
            lb.DesignError,
            "name one output twice",
        ),
        (lambda: lb.reduced_order_filter(plant(), 1.0), lb.DesignError, "got 1.0"),
        (lambda: lb.reduced_order_filter(plant(), True), lb.DesignError, "got True"),
        (
            lambda: lb.reduced_order_filter(plant(), 1, weight=np.diag([1, 0])),
            lb.DesignError,
            "weight must be positive definite",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), 1, weight=np.diag([1, -1])),
            ValueError,
            "weight must be positive semi-definite",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), 1, weight="paper"),
            ValueError,
            "weight must be an .* or 'canonical'",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), 1, weight="canonical"),
            lb.DesignError,
            "'canonical' needs outputs that are linearly independent",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), 1, horizon="long"),
            ValueError,
            "horizon must be 'step' or 'steady'",
        ),
        (
            lambda: lb.reduced_order_filter(plant(), 1, steps=3, horizon="steady"),
            lb.DesignError,
            "leave out steps",
        ),
        (lambda: lb.kalman_filter(plant(), steps=0), ValueError, "whole number >= 1"),
        (lambda: lb.kalman_filter(plant(), steps=2.5), ValueError, "whole number >= 1"),
        (
            lambda: lb.kalman_filter(plant(A=STACK)),
            lb.DesignError,
            "no steady state; give the number of steps",
        ),
        (
            lambda: lb.kalman_filter(plant(A=STACK), steps=4),
            lb.DesignError,
            "needs the plant at instants 0 .. 4, it has rows 0 .. 3; take steps <= 3",
        ),
        (
            lambda: lb.certify(observer(), plant(dt=2.0)),
            ValueError,
            r"observer has dt=1 but the plant dt=2; .*plant\.sampled\(1\)",
        ),
        (
            lambda: lb.certify(observer(), plant(B=None)),
            ValueError,
            r"n, m, p = \(2, 1, 2\), the plant has \(2, 0, 2\)",
        ),
        (
            lambda: lb.certify(observer(), plant(A=STACK)),
            ValueError,
            r"constant observer cannot be measured.*time-varying.*steps=N\)",
        ),
        (
            lambda: lb.error_covariance(observer(steps=5), plant()),
            ValueError,
            "give steps: a time-varying observer has no steady state",
        ),
        (
            lambda: lb.error_covariance(observer(steps=5), plant(), steps=6),
            ValueError,
            "covers instants 1 .. 5",
        ),
        (
            lambda: lb.error_covariance(observer(), plant(B=[[3], [1]])),
            lb.DesignError,
            "depends on the known input",
        ),
        (
            lambda: lb.error_covariance(
                lb.kalman_filter(plant(B=None)), plant(B=None, A=[[2, 1], [0, 1]])
            ),
            lb.DesignError,
            "does not fit this plant, and its error has the mode 1, 2 on or outside",
        ),
        (
            lambda: lb.estimate(observer(), [[1, np.nan]]),
            ValueError,
            "first in row 0; a Filter takes NaN",
        ),
        (lambda: lb.estimate(observer(), [[1]]), ValueError, r"y must be \(N, 2\)"),
        (lambda: lb.estimate(observer(), [["a", 1]]), ValueError, "array of numbers"),
        (
            lambda: lb.estimate(
                observer(), lb.Record(np.ones((3, 2)), np.ones((2, 1)))
            ),
            ValueError,
            "y has 3 rows but u has 2",
        ),
        (
            lambda: lb.estimate(observer(), lb.Record(np.ones((3, 2)), u0=[1])),
            ValueError,
            "u0 is the input before the first row",
        ),
        (
            lambda: lb.estimate(observer(), np.ones((3, 2)), z0=[1, 2], x0=[1, 2]),
            ValueError,
            "not both",
        ),
        (
            lambda: lb.estimate(observer(steps=2), np.ones((3, 2))),
            ValueError,
            "y has 3 rows, the filter was designed for 2",
        ),
        (
            lambda: lb.Filter(plant()).run([[np.inf, 1]]),
            ValueError,
            "y is infinite in row 0",
        ),
        (
            lambda: lb.Filter(plant()).run(lb.Record(np.ones((1, 2)), np.ones((2, 1)))),
            ValueError,
            "y has 1 rows but u has 2",
        ),
        (
            lambda: lb.Filter(plant(A=STACK)).run(np.ones((4, 2))),
            ValueError,
            "rows for instants 0 .. 3, the data reach instant 4",
        ),
        (
            lambda: lb.simulate(plant(), observer(steps=3), 4),
            ValueError,
            "4 steps asked of a filter designed for 3",
        ),
        (
            lambda: lb.simulate(plant(), observer(), [0, 0.5, 1.0]),
            ValueError,
            r"spaced by 0\.5 s but the plant samples every 1 s",
        ),
        (
            lambda: lb.simulate(plant(), observer(), [0, 1, 3]),
            ValueError,
            "equally spaced",
        ),
        (
            lambda: lb.monte_carlo(plant(), observer(), runs=0, steps=3, seed=1),
            ValueError,
            "runs must be at least 1",
        ),
        (
            lambda: lb.monte_carlo(plant(P0=None), observer(), runs=1, steps=3, seed=1),
            lb.DesignError,
            "needs dt > 0 and the covariances",
        ),
        (
            lambda: lb.export.multiply_adds(observer(steps=3)),
            ValueError,
            "constant observer",
        ),
    ],
)
def test_refusal(request_, error, message):
    with pytest.raises(error, match=message):
        request_()


def test_an_unknown_name_is_an_attribute_error():
    with pytest.raises(AttributeError, match="no attribute 'kalman'"):
        lb.kalman  # noqa: B018
