"""What a comparison shows: cells, plain rows, refusals, files."""

import json
import pickle
import re
import sys

import numpy as np
import pytest

import luenberger as lb
from luenberger import report
from luenberger.comparison import METHODS

KALMAN, NOVAK, FIXED, REDUCED, DEADBEAT, FUNCTIONAL = METHODS


def tracker(**changes):
    A, C = [[1, 1, 0.5], [0, 1, 1], [0, 0, 1]], np.eye(2, 3)
    given = dict(Q=np.diag([0, 0, 1.0]), R=np.diag([0.25, 4.0]), P0=np.eye(3), dt=1.0)
    return lb.Plant(A, None, C, **given | dict(output_names=["radar_1|x", "doppler"])
                    | changes)  # fmt: skip


@pytest.fixture(scope="module")
def table():
    return lb.compare(tracker())


def test_the_same_every_time_and_after_a_pickle(table):
    again = lb.compare(tracker())
    assert again.to_rows() == table.to_rows() and repr(again) == repr(table)
    sent = pickle.loads(pickle.dumps(table))
    assert sent.to_rows() == table.to_rows() and sent.reasons() == table.reasons()


def test_rows_are_plain_and_complete(table):
    bare = lb.compare(tracker(Q=None, R=None))
    for one in (table, bare, table.within(states=2)):
        rows = one.to_rows()
        assert json.loads(json.dumps(rows, allow_nan=False)) == rows
        assert len(rows) == len(one) and len({tuple(row) for row in rows}) == 1
        assert sum(row["recommended"] for row in rows) == (one.chosen is not None)
        assert sum(row["on_front"] for row in rows) == len(one.pareto())
    row = table.to_rows()[table.every.index(table.chosen)]
    chosen = table.chosen
    assert row["sigma"] == chosen.sigma.tolist() and row["error"] == chosen.error
    assert (row["multiply_adds"], row["bytes"]) == (chosen.work, chosen.bytes)
    assert row["accurate"] == ["radar_1|x"] and row["horizon"] == chosen.horizon
    assert row["worst_on"] == "nominal" and row["excess"] == table.excess(chosen)
    refused = table.to_rows()[table.every.index(table.find(FUNCTIONAL))]
    assert "needs L" in refused["refusal"] and refused["error"] is None


def test_cells_are_the_figures(table):
    shown = table.table
    assert shown.header == [
        "method", "which", "order", "worst state", "mean state", "worst pole",
        "noise gain", "cond [T; C]", "multiply-adds", "bytes", "certificate",
    ]  # fmt: skip
    for cells, one in zip(shown.rows, table.designs, strict=True):
        assert cells[:3] == [one.method, one.label, str(one.order)]
        if one.worst_ratio < 10:
            assert float(cells[3].split()[0]) == pytest.approx(
                100 * (one.worst_ratio - 1), abs=0.006
            )
        assert (int(cells[8]), int(cells[9])) == (one.work, one.bytes)
        assert float(cells[5]) == pytest.approx(one.worst_pole, rel=1e-2, abs=1e-9)
        assert cells[10] == "exact"
    assert [table.designs[k] for k in shown.marked] == [table.chosen]
    assert "<b>" in table._repr_html_() and "why there is none" in repr(table)


def test_equal_reasons_are_told_once(table):
    rows = table.refusals.rows
    assert [row[:2] for row in rows] == [
        [FIXED, "order 1, and 3 more"],
        [FUNCTIONAL, "L x from the fewest states"],
    ]
    assert "for stable plants" in rows[0][2]


def test_digits_that_rounding_spoils_are_not_shown():
    """Two sensors of almost the same: the deadbeat observer has cond about 1e11."""
    close = lb.Plant(tracker().A, None, [[1, 0, 0], [1, 1e-11, 0]], dt=1.0,
                     Q=tracker().Q, R=tracker().R)  # fmt: skip
    some = lb.candidates(close, methods=[KALMAN, DEADBEAT])
    good, badly = lb.compare(close, some).table.rows
    assert re.fullmatch(r"\d(\.\d{1,3})?e\+\d\d", badly[6]) and badly[7] > "1e+10"


def test_find_goes_by_method_name_and_title(table):
    one = table.find(NOVAK, accurate=(0,), horizon="steady")
    assert table.find(one.name) is one is table.find(one.title)
    with pytest.raises(KeyError, match="no 'Kalman filter' with .*'order': 7"):
        table.find(KALMAN, order=7)


def test_a_frame_has_every_design_with_its_figures(table, monkeypatch):
    frame = table.to_frame()
    assert len(frame) == len(table) and list(frame.columns) == [*table.to_rows()[0]]
    assert frame.loc[frame.recommended, "label"].tolist() == [table.chosen.label]
    refused = frame[frame.method == FUNCTIONAL].iloc[0]
    assert "needs L" in refused.refusal and np.isnan(refused.error)
    monkeypatch.setitem(sys.modules, "pandas", None)
    with pytest.raises(ImportError, match=r"pip install pandas, or take to_rows\(\)"):
        table.to_frame()


def test_a_bar_is_drawn_on_a_terminal_only(monkeypatch, capsys):
    from luenberger import comparison

    lb.compare(tracker(), {"it": lb.kalman_filter})
    assert capsys.readouterr().err == ""
    monkeypatch.setattr(sys.stderr, "isatty", lambda: True, raising=False)
    monkeypatch.setattr(comparison.time, "monotonic", iter(range(0, 99, 2)).__next__)
    lb.compare(tracker(), {"slow": lb.kalman_filter, "next": lb.deadbeat_observer})
    said = capsys.readouterr().err
    assert "slow" in said and "[##########          ] next" in said
    assert said.endswith("\r")


def test_matrices_carry_names_and_leave_out_zeros(table):
    chosen = table.recommended()
    tables = [*report._matrices(chosen.observer, tracker())]
    assert [t.header[0][0] for t in tables] == ["F", "D", "P", "V"]  # no input: no G, W
    assert tables[-1].header[1:] == ["radar_1|x", "doppler"]
