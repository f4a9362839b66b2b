"""Multiply-adds, operations and bytes are one thing in table, report and header."""

import csv
import dataclasses
import io
import re
from pathlib import Path

import numpy as np
import pytest

import luenberger as lb
from luenberger import report
from luenberger.export import to_c

PLANTS = Path(__file__).parents[2] / "notebooks" / "plants"
EXACT = ["Kalman filter", "Leondes-Novak filter"]


def motor():
    """Angle and speed; the angle is read, and the voltage is known."""
    A, Q = [[0, 1], [0, -2.0]], np.diag([1e-6, 0.1])
    return lb.Plant(A, [[0], [8.0]], [[1, 0]], Q=Q, R=[[1e-6]]).sampled(0.01)


def plants(name):
    if name == "motor":
        return motor()
    plant = lb.Plant.from_json(PLANTS / f"{name}.json")
    if name == "ball-and-beam":  # its noise is not known
        plant = dataclasses.replace(plant, Q=1e-4 * np.eye(plant.n), R=[[1e-6]])
    return plant if plant.dt > 0 else plant.sampled(0.1)


def of_the_header(observer, folder, dtype="double"):
    """Multiply-adds, operations and bytes as the exported header gives them."""
    text = to_c(observer, folder, dtype=dtype)[1].read_text()
    words = ("multiply-adds", "operations", "bytes of state and constants")
    return tuple(int(re.search(rf"(\d+) {what}", text)[1]) for what in words)


@pytest.mark.parametrize("name", ["reactor", "ball-and-beam", "motor", "tracker"])
def test_the_recommended_design_costs_the_same_wherever_it_is_said(name, tmp_path):
    orders = [6, 9] if name == "reactor" else None  # saves seconds
    table = lb.compare(plants(name), methods=EXACT, orders=orders)
    chosen, files = table.chosen, report.files(table)
    (tmp_path / "observer.json").write_text(files["observer.json"])
    observer = lb.Observer.from_json(tmp_path / "observer.json")
    header = of_the_header(observer, tmp_path)
    (marked,) = table.table.marked
    shown = dict(zip(table.table.header, table.table.rows[marked]))
    assert header[::2] == (int(shown["multiply-adds"]), int(shown["bytes"]))
    (row,) = (r for r in csv.DictReader(io.StringIO(files["designs.csv"]))
              if r["recommended"] == "yes")  # fmt: skip
    assert header == tuple(
        int(row[k]) for k in ("multiply_adds", "operations", "bytes")
    )
    assert header[0] == lb.export.multiply_adds(observer)
    assert header == (chosen.work, chosen.operations, chosen.bytes)


def test_every_design_costs_what_its_header_says(tmp_path):
    plant = plants("tracker")
    for one in (*lb.compare(plant), *lb.compare(plant, k=[1, 1, 0])):
        if not one.refusal:
            counted = (one.work, one.operations, one.bytes)
            assert of_the_header(one.observer, tmp_path) == counted, one.title


def test_an_observer_is_counted_as_it_is_exported(tmp_path):
    """With what is rounding, and with what float does not tell from 1."""
    observer = lb.Observer([[0.5]], [[]], [[0.25, 1e-17]], [[1 + 1e-9]], [[0.5, 0]],
                           T=[[1]], L=[[1]], dt=1.0)  # fmt: skip
    assert of_the_header(observer, tmp_path) == (5, 14, 48)
    assert of_the_header(observer, tmp_path, "float") == (5, 13, 20)
    assert lb.export.multiply_adds(observer, dtype="float") == 5
