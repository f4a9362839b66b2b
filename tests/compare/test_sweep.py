"""A table of design problems: order, results, refusals, here and on executors."""

import concurrent.futures
import functools
import multiprocessing

import generators
import numpy as np
import pytest

import luenberger as lb

CART = dict(dt=1.0, Q=[[0, 0], [0, 1]], R=[[1]], P0=np.eye(2))
PLANTS = {
    "cart": lb.Plant([[1, 1], [0, 1]], None, [[1, 0]], **CART),
    "deaf": lb.Plant([[1, 1], [0, 1]], None, [[0, 1]], **CART),
    "random": generators.plant(np.random.default_rng(8), 4, 2, m=0),
    "noiseless": lb.Plant([[0.5, 1], [0, 0.5]], None, [[1, 0]], dt=1.0),
}
DESIGNS = {
    "Kalman": lb.kalman_filter,
    "reduced": functools.partial(lb.reduced_order_filter, m1=1),
    "five steps": functools.partial(lb.kalman_filter, steps=5),
    "deadbeat": lb.deadbeat_observer,
}


@pytest.fixture(scope="module")
def here():
    return lb.sweep(DESIGNS, PLANTS)


def as_data(found):
    return [(t.design, t.plant, t.order, t.trace, t.residual, t.refusal) for t in found]


def broken(plant):
    raise ZeroDivisionError("in the design itself")


def test_every_design_on_every_plant_in_order(here):
    pairs = [(trial.plant, trial.design) for trial in here]
    assert pairs == [(plant, design) for plant in PLANTS for design in DESIGNS]
    assert len(here) == 16


@pytest.mark.parametrize("plant", PLANTS)
@pytest.mark.parametrize("design", DESIGNS)
def test_a_trial_is_what_the_design_gives(design, plant, here):
    trial = here.find(design, plant)
    try:
        observer = DESIGNS[design](PLANTS[plant])
    except ValueError as refusal:
        assert trial.refusal == str(refusal)
        assert trial.observer is trial.order is trial.trace is trial.residual is None
        return
    assert trial.refusal == "" and trial.order == observer.order
    np.testing.assert_array_equal(trial.observer.V, observer.V)
    assert trial.residual == lb.certify(observer, PLANTS[plant]).worst
    if plant == "noiseless":
        assert trial.trace is None
    else:
        X = lb.error_covariance(observer, PLANTS[plant], steps=observer.steps)
        last = X if observer.steps is None else X[-1]
        assert trial.trace == pytest.approx(np.trace(last), rel=1e-12)


def test_some_are_refused_and_some_are_not(here):
    refused = {(t.design, t.plant) for t in here if t.refusal}
    assert {("Kalman", "deaf"), ("Kalman", "noiseless")} <= refused
    assert {(t.design, t.plant) for t in here} - refused >= {
        ("Kalman", "cart"),
        ("deadbeat", "noiseless"),
    }
    assert "not detectable" in here.find("Kalman", "deaf").refusal


def test_same_table_from_any_executor(here):
    spawn = multiprocessing.get_context("spawn")
    with concurrent.futures.ThreadPoolExecutor(3) as threads:
        assert as_data(lb.sweep(DESIGNS, PLANTS, executor=threads)) == as_data(here)
    with concurrent.futures.ProcessPoolExecutor(1, mp_context=spawn) as processes:
        assert as_data(lb.sweep(DESIGNS, PLANTS, executor=processes)) == as_data(here)


def test_the_best_has_the_least_trace(here):
    best = here.best("random")
    assert best.design in ("Kalman", "five steps")
    traces = [t.trace for t in here if t.plant == "random" and t.trace is not None]
    assert best.trace == min(traces) and len(traces) > 2
    with pytest.raises(KeyError, match="no trial on 'noiseless' has an error trace"):
        here.best("noiseless")


def test_an_unstable_error_is_refused_not_measured():
    """The design comes from another plant, on which it fits; here it diverges."""
    observer = lb.kalman_filter(PLANTS["cart"])
    unstable = lb.Plant([[1, 1], [0, 1.5]], None, [[1, 0]], **CART)
    (trial,) = lb.sweep({"fixed": lambda plant: observer}, {"faster": unstable})
    assert "no steady state" in trial.refusal and trial.trace is None


def test_the_table_shows_order_trace_and_refusal(here):
    header, *lines = (line.split() for line in repr(here).splitlines())
    assert header == ["plant", "design", "order", "error", "trace", "refused"]
    assert len(lines) == 16
    trace = f"{here.find('Kalman', 'cart').trace:.4g}"
    assert ["cart", "Kalman", "2", trace] in lines
    (deaf,) = (line for line in lines if line[:2] == ["deaf", "Kalman"])
    assert " ".join(deaf[2:]).startswith("not detectable")
    assert here._repr_html_().count("<tr>") == 17


def test_a_fault_in_a_design_ends_the_sweep_and_is_located():
    with pytest.raises(ZeroDivisionError) as caught:
        lb.sweep({"good": lb.kalman_filter, "bad": broken}, {"cart": PLANTS["cart"]})
    assert caught.value.__notes__ == ["in design 'bad' on plant 'cart'"]


def test_progress_is_told():
    told = []
    lb.sweep(
        {"Kalman": lb.kalman_filter}, PLANTS, progress=lambda *now: told.append(now)
    )
    assert told == [(1, 4), (2, 4), (3, 4), (4, 4)]


def test_refusals(here):
    cart = {"cart": PLANTS["cart"]}
    with pytest.raises(ValueError, match="at least one design and one plant"):
        lb.sweep({}, cart)
    with pytest.raises(ValueError, match="at least one design and one plant"):
        lb.sweep(DESIGNS, {})
    with pytest.raises(ValueError, match="designs must be a dict, by name, got list"):
        lb.sweep([lb.kalman_filter], cart)
    with pytest.raises(ValueError, match="plants must be a dict, by name, got Plant"):
        lb.sweep(DESIGNS, cart["cart"])
    with pytest.raises(ValueError, match="design 'Kalman' must be a function"):
        lb.sweep({"Kalman": lb.kalman_filter(cart["cart"])}, cart)
    with pytest.raises(TypeError, match="must return an Observer, got 3"):
        lb.sweep({"three": lambda plant: 3}, cart)
    with pytest.raises(KeyError, match="no trial of 'Kalman' on 'tram'"):
        here.find("Kalman", "tram")


def test_what_cannot_be_sent_is_named():
    with concurrent.futures.ProcessPoolExecutor(1) as executor:
        with pytest.raises(ValueError, match="'local' cannot be sent to another"):
            lb.sweep(
                {"sound": lb.kalman_filter, "local": lambda plant: None},
                PLANTS,
                executor=executor,
            )
