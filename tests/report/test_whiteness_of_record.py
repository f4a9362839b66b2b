"""What the report says of a record and the noises that it was given or fitted."""

import dataclasses

import numpy as np
import pytest

import luenberger as lb
from luenberger import report
from luenberger.run.measurements import Measurements

PLANT = lb.Plant(
    [[1, 1], [0, 0.9]], None, [[1, 0]], dt=1.0, Q=np.diag([0, 0.1]), R=[[1]],
    P0=np.eye(2),
)  # fmt: skip


@pytest.fixture
def record():
    rng, x, y = np.random.default_rng(8), np.zeros(2), []
    for _ in range(400):
        x = PLANT.A @ x + [0, np.sqrt(0.1) * rng.normal()]
        y.append(PLANT.C @ x + rng.normal())
    return Measurements(np.array(y), np.zeros((400, 0)), np.arange(1.0, 401))


def test_the_true_noises_agree(record):
    found = report.judged(PLANT, record)
    assert "The record agrees with" in repr(report.agreement(found))


@pytest.mark.parametrize("wrong", [{"Q": np.diag([0, 10.0])}, {"R": [[9.0]]}])
def test_wrong_noises_do_not(record, wrong):
    found = report.judged(dataclasses.replace(PLANT, **wrong), record)
    assert "does not agree" in repr(report.agreement(found))


def test_without_noises_or_with_few_samples_nothing_is_said(record):
    silent = dataclasses.replace(PLANT, Q=None)
    few = dataclasses.replace(record, y=record.y[:19], u=record.u[:19])
    for found in (report.judged(silent, record), report.judged(PLANT, few)):
        assert found is None
        assert "Nothing was tested" in repr(report.agreement(found))
        assert "No figure" in repr(report.innovations(found, []))


def test_a_record_that_the_plant_cannot_produce_is_not_judged(record):
    still = dataclasses.replace(PLANT, Q=np.zeros((2, 2)), R=[[0]], P0=np.zeros((2, 2)))
    assert report.judged(still, record) is None
