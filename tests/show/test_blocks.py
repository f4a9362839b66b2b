"""What a person sees of a plant, an observer, a run and a fit."""

import numpy as np
import pytest

import luenberger as lb

PLANT = lb.Plant(
    [[0.9, 0.1], [0, 1]], [[0.5], [0]], [[1, 0]], dt=0.1, Q=[[0.04, 0], [0, 0.01]],
    R=[[0.25]], P0=np.eye(2), name="a cart", state_names=["speed (m/s)", "slope (deg)"],
    output_names=["radar (m/s)"], input_names=["force (N)"],
)  # fmt: skip


def test_a_plant_in_a_few_lines_with_its_units():
    assert repr(PLANT).splitlines() == [
        "Plant 'a cart': 2 states, 1 input, 1 output, one sample every 0.1 s",
        "  states   speed (m/s), slope (deg)",
        "  inputs   force (N)",
        "  outputs  radar (m/s)",
        "  given    Q, R, P0",
    ]
    page = PLANT._repr_html_()
    for cell in ("slope (deg)+", "one sigma of noise", ">0.2<", ">0.5<", ">0.9<"):
        assert cell in page
    big = lb.Plant(np.eye(40), None, np.eye(3, 40))
    assert "and 34 more" in repr(big) and "continuous" in repr(big)
    assert "x6 and 2 more" in repr(lb.Plant(np.eye(8), None, np.eye(1, 8)))
    assert "no noise" in repr(big) and "<table>" not in big._repr_html_()


@pytest.mark.parametrize("steps", [None, 3])
def test_an_observer_says_what_it_estimates_from_what(steps):
    observer = lb.reduced_order_filter(PLANT, 1, steps=steps)
    first, *lines = repr(observer).splitlines()
    assert first.startswith("Observer: 1 state for 2 of the plant, one sample every")
    assert ("over 3 rows" in first) == (steps == 3)
    assert "  estimates  speed (m/s), slope (deg)" in lines
    assert any(line.startswith("  poles") for line in lines) == (steps is None)
    assert ("z1</th>" in observer._repr_html_()) == (steps is None)


def test_a_run_shows_where_it_ended():
    y = np.ones((5, 1))
    found = lb.Filter(PLANT).run(y)
    assert len(repr(found).splitlines()) == 4
    assert repr(found).startswith("Filtered: 5 rows; at the last one")
    assert f"{found.x[-1, 0]:.4g}" in repr(found) and "<table>" in found._repr_html_()
    many = lb.Filter(PLANT).run([y, y[:3]])
    assert repr(many).startswith("Filtered: 2 records; at the end of the first")
    assert repr(many).splitlines()[1:] == repr(found).splitlines()[1:]


def test_a_fit_leaves_out_what_was_known():
    y = np.cumsum(np.random.default_rng(1).normal(size=(200, 1)), axis=0)
    plant = lb.Plant([[1]], None, [[1]], dt=1.0, R=[[1e-4]])
    fit = lb.fit_noise(plant, y, R=None)
    assert "R[0,0]" not in repr(fit) and "Known of Q and R: 1 number." in repr(fit)
    assert "Q[0,0]" in repr(fit) and "<td>Q[0,0]</td>" in fit._repr_html_()
