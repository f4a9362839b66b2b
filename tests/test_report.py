"""What the report says of a record and the noises that it was given or fitted."""

import dataclasses
import re

import numpy as np
import pytest

import luenberger as lb
from luenberger import report
from luenberger.run.measurements import Measurements

PLANT = lb.Plant(
    [[1, 1], [0, 0.9]], None, [[1, 0]], dt=1.0, Q=np.diag([0, 0.1]), R=[[1]],
    P0=np.eye(2),
)  # fmt: skip


def judge(plant, record):
    return report._tests(plant, record, None)


def agreement(found, table=None, data=None):
    return " ".join(report._agreement(table, data, found))


@pytest.fixture
def record():
    rng, x, y = np.random.default_rng(8), np.zeros(2), []
    for _ in range(400):
        x = PLANT.A @ x + [0, np.sqrt(0.1) * rng.normal()]
        y.append(PLANT.C @ x + rng.normal())
    return Measurements(np.array(y), np.zeros((400, 0)), np.arange(1.0, 401))


def test_the_true_noises_agree(record):
    found = judge(PLANT, record)
    said = agreement(found)
    assert "The record agrees with the model" in said
    assert "no other observer is tested by that" in said


def test_what_was_fitted_is_counted(record):
    """One test, one probability: that of the fit."""
    fit = lb.fit_noise(dataclasses.replace(PLANT, R=None), record.y, Q=None, R="full")
    assert report._tests(fit.plant, record, fit) is fit.whiteness
    table = lb.compare(fit.plant, lb.candidates(fit.plant, orders=2))
    page = report.files(table, record, fit)["report.html"]
    assert set(re.findall(r"\(p = ([^)]*)\)", page)) == {f"{fit.whiteness.p_value:.2g}"}
    cells = re.findall(r"R\[0,0\]</td><td[^>]*>([^<]*)</td><td[^>]*>([^<]*)<", page)
    error = fit.standard_errors["R"][0, 0]
    assert cells == [(f"{fit.plant.R[0, 0]:.4g}", f"{error:.2g}")]


WRONG = [
    {"Q": np.diag([0, 10.0])},
    {"R": [[9.0]]},
    {"Q": np.diag([0, 0.9]), "R": [[9.0]]},  # white, and of a third of the size
]


@pytest.mark.parametrize("wrong", WRONG)
def test_wrong_noises_do_not(record, wrong):
    plant = dataclasses.replace(PLANT, **wrong)
    assert "does not agree" in agreement(judge(plant, record))
    page = report.files(lb.compare(plant, lb.candidates(plant, orders=2)), record)[
        "report.html"
    ]
    box = page[page.index('<div class="box bad">') : page.index("</div>")]
    assert "does not agree with the model (p = " in box and "luenberger fit" in box


def test_without_noises_or_with_few_samples_nothing_is_said(record):
    silent = dataclasses.replace(PLANT, Q=None)
    few = dataclasses.replace(record, y=record.y[:19], u=record.u[:19])
    for found in (judge(silent, record), judge(PLANT, few)):
        assert found is None
        assert "Nothing was tested" in agreement(found)


def test_a_record_that_the_plant_cannot_produce_is_not_judged(record):
    still = dataclasses.replace(PLANT, Q=np.zeros((2, 2)), R=[[0]], P0=np.zeros((2, 2)))
    assert judge(still, record) is None


OVEN = lb.Plant(
    [[-0.0025, 0.0025], [0.0104166667, -0.01375]], [[0.002], [0]], [[0, 1]],
    Q=np.diag([1e-4, 1e-4]), R=[[0.04]], P0=np.diag([100.0, 100.0]),
    output_names=["air"],
).sampled(1.0)  # fmt: skip


def of_input(u):
    run = lb.simulate(OVEN, lb.kalman_filter(OVEN), len(u) - 1, u=u, seed=1, x0=[0, 0])
    return Measurements(run.y, u, np.arange(1.0, len(u) + 1)), run


def sentence(table, data):
    found = None if data is None else judge(table.plant, data)
    return agreement(found, table, data)


FEW = lb.candidates(OVEN, methods=["Kalman filter", "fixed-order filter"])


@pytest.fixture(scope="module")
def levelled():
    table = lb.compare(OVEN.with_input([60.0]), FEW)
    assert table.chosen.order == 1
    return table


def test_the_recommended_observer_is_judged_on_the_record(levelled):
    switched = np.where((np.arange(4000) // 400) % 2 == 0, 60.0, 0.0)[:, None]
    data, _ = of_input(switched)
    said = sentence(levelled, data)
    assert "The record agrees with the model" in said
    assert "worse on this record than its errors promise" in said
    steady, _ = of_input(np.zeros((4000, 1)))
    still = lb.compare(OVEN.with_input(0), FEW)
    said = sentence(still, steady)
    assert "the recommended observer misses" in said and "worse on this" not in said


def test_what_it_misses_is_that_of_its_estimates(levelled):
    """The figures against a loop over the rows."""
    u = np.random.default_rng(4).normal(size=(3000, 1))
    data, _ = of_input(u)
    figures = []
    settled = max(one.settling for one in (levelled.chosen, levelled.yardstick))
    first = int(np.ceil(settled))
    for one in (levelled.chosen, levelled.yardstick):
        x = lb.estimate(one.observer, lb.Record(data.y, u), x0=[0, 0])
        missed = [
            data.y[k + 1] - OVEN.C @ (OVEN.A @ x[k] + OVEN.B @ u[k])
            for k in range(first, 2999)
        ]
        figures.append(f"{np.sqrt(np.mean(np.square(missed))):.4g}")
    said = sentence(levelled, data)
    assert f"from sample {first + 2} on" in said
    assert f"air by {figures[0]} instead of {figures[1]} (promised 0.2" in said


def test_where_nothing_can_be_said_of_it_nothing_is(levelled):
    data, _ = of_input(np.zeros((400, 1)))
    kalman = lb.compare(OVEN, lb.candidates(OVEN, methods="Kalman filter"))
    gaps = dataclasses.replace(data, y=np.where(np.arange(400)[:, None] % 9, data.y,
                                                np.nan))  # fmt: skip
    for table, record in ((kalman, data), (levelled, gaps), (levelled, None)):
        assert "recommended observer misses" not in sentence(table, record)


def test_the_box_says_what_to_take_and_what_is_next(levelled):
    switched = np.where((np.arange(4000) // 400) % 2 == 0, 60.0, 0.0)[:, None]
    page = report.files(levelled, of_input(switched)[0], None, "made")["report.html"]
    box = page[page.index('<div class="box bad">') : page.index("</div>")]
    assert f"Recommended: {levelled.chosen.title}." in box
    assert "do not take it" in box and "The record agrees with the model" in box
    assert "luenberger export plant.json" in box
    assert page.index("<h2>") > page.index("</div>") and "<p>made</p>" in page
    calm = lb.compare(OVEN.with_input(0), {"Kalman filter": lb.kalman_filter})
    page = report.files(calm, of_input(np.zeros((400, 1)))[0])["report.html"]
    box = page[page.index('<div class="box">') : page.index("</div>")]
    assert "luenberger export observer.json" in box


def test_a_wide_table_is_cards_on_a_telephone(levelled):
    page = report.page(levelled)
    assert page.count("<table class=wide>") == 1
    row = re.search(r"<tr class=chosen>.*?</tr>", page)[0]
    assert len(re.findall("data-label=", row)) == len(levelled.table.header)
