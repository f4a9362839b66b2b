"""Drawn and damaged files: what a slow reader reads, or a refusal; never anything else.

hypothesis draws the same files in every run.
"""

import copy
import csv
import io
import json
import re
import tempfile
import warnings
from pathlib import Path

import numpy as np
import pytest
from drawn import bounded
from hypothesis import given
from hypothesis import strategies as st
from json_data import OBSERVER_DATA, PLANT_DATA, READERS

from luenberger.formats import csv_table
from luenberger.formats.csv_table import Table
from luenberger.run import tables

# ------------------------------------------------------------------------------ tables

NUMBERS = st.floats(-1e308, 1e308)
WAYS = [repr, "{:.3g}".format, "{:+.2e}".format, " {:g} ".format, '"{!r}"'.format]
CLOCKS = ["1", "2024-01-01T00:00:00", "noon", '"1,5"', "", " 7 "]
TOKENS = [b",", b"\n", b"\r", b'"', b"\0", b" ", b";", b"-", b"e", b"x", b"_", b"nan",
          b"inf", b"1e999", b"\n\n", b"\xff", b"\xc3\xa9", b"\xd9\xa3", b'""', b"#",
          b"\xef\xbb\xbf", b"\x0c", b"\x1c", b"0x1"]  # fmt: skip


@st.composite
def written(draw):
    """A valid table as bytes, with its columns and what they should be read as."""
    names = draw(st.sampled_from([["a"], ["a", "b"], ["b", "c", "a"]]))
    clock = draw(st.sampled_from([None, "time", "T"]))
    columns = draw(st.permutations(names + [clock] * bool(clock)))
    rows, wanted, clocks = [], [], []
    for _ in range(draw(st.integers(1, 6))):
        cells = {name: draw(NUMBERS) for name in names}
        texts = {name: draw(st.sampled_from(WAYS))(cells[name]) for name in names}
        for name in names[:1]:
            if draw(st.integers(0, 4)) == 0:
                texts[name] = "nan" if len(columns) == 1 else draw(GAPS)
        if clock:
            texts[clock] = draw(st.sampled_from(CLOCKS))
            clocks.append(texts[clock].strip())
        rows.append(",".join(texts[name] for name in columns))
        wanted.append([float(texts[n].strip(' "') or "nan") for n in names])
    end = draw(st.sampled_from(["\n", "\r\n"]))
    text = end.join([",".join(columns), *rows]) + end * draw(st.integers(0, 2))
    start = draw(st.sampled_from(["", "\ufeff"]))
    return (start + text).encode(), names, clocks, np.array(wanted)


GAPS = st.sampled_from(["", " ", "nan", "NaN"])


def outcome(data, names, piece=csv_table.PIECE):
    """What the reader makes of a table whose first wanted column may have gaps."""
    try:
        table = Table(io.BytesIO(data), "data.csv", piece)
        clock = tables.time_column(table, names, [])
        parts = list(table.rows(names, names[:1], clock))
    except ValueError as error:
        return str(error)
    lines = [line for part in parts for line in part.lines]
    clocks = [cell for part in parts for cell in part.carried]
    return lines, clocks, np.concatenate([part.values for part in parts])


def by_hand(data, names):
    """The same by `csv` and `float` alone."""
    reader = csv.reader(io.StringIO(data.decode("utf-8-sig"), newline=""), strict=True)
    rows = [row for row in reader if len(row) > 1 or "".join(row).strip()]
    header = [cell.strip() for cell in rows[0]]
    return np.array(
        [
            [by_float(row[header.index(name)].strip()) for name in names]
            for row in rows[1:]
        ]
    )


def by_float(text):
    assert re.fullmatch("[-+0-9.eEnaN]*", text), f"{text!r} is not to be read"
    return float(text or "nan")


def same(one, other):
    if isinstance(one, str) or isinstance(other, str):  # which fault, pieces decide
        return isinstance(one, str) and isinstance(other, str)
    return one[:2] == other[:2] and np.array_equal(one[2], other[2], equal_nan=True)


@bounded(100)
@given(written(), st.integers(1, 80))
def test_a_valid_table_is_read_in_any_pieces(table, piece):
    data, names, clocks, wanted = table
    found = outcome(data, names)
    assert not isinstance(found, str), found
    np.testing.assert_array_equal(found[2], wanted)
    assert found[1] == clocks
    assert same(outcome(data, names, piece), found)


@bounded(150)
@given(written(), st.data())
def test_a_damaged_table_is_read_by_hand_or_refused(table, data):
    raw, names, _, _ = table
    for _ in range(data.draw(st.integers(1, 3), label="damages")):
        at = data.draw(st.integers(0, len(raw)), label="at")
        cut = data.draw(st.sampled_from([0, 0, 1, 3]), label="bytes cut out")
        raw = raw[:at] + data.draw(st.sampled_from(TOKENS)) + raw[at + cut :]
    found = outcome(raw, names)
    if isinstance(found, str):
        assert found.startswith("data.csv") and len(found) < 400
    else:
        np.testing.assert_array_equal(found[2], by_hand(raw, names))
    assert same(
        outcome(raw, names, data.draw(st.integers(1, 40), label="piece")), found
    )


@bounded(100)
@given(st.binary(max_size=60))
def test_bytes_are_read_by_hand_or_refused(data):
    for start in (b"", b"a\n", b"a,b\n1,2\n"):
        names = ["a", "b"] if b"b" in start else ["a"]
        found = outcome(start + data, names)
        if isinstance(found, str):
            assert found.startswith("data.csv")
        else:
            np.testing.assert_array_equal(found[2], by_hand(start + data, names))


# ---------------------------------------------------------------- plants and observers

NASTY = [None, True, False, 0, -1, 1.5, 2**70, 10**400, 1e308, -1e308, 1e-320, 5e-324]
NASTY += [float("nan"), float("inf"), "", "1", "x\n", "\ud800", "../..", [], [[]], {}]
NASTY += [{"shape": [0, 1]}, {"shape": [0]}, {"shape": [1, 0]}, {"shape": [10**9, 0]}]
NASTY += [{"real": [[1]], "imag": [[2]]}, {"real": 1}, [1, [2]], [[True]], [[[]]]]
KEYS = st.sampled_from(["shape", "real", "imag"])
LEAVES = st.one_of(st.sampled_from(NASTY), NUMBERS, st.integers(), st.text(max_size=3))
VALUES = st.one_of(
    LEAVES,
    st.recursive(
        LEAVES, lambda inner: st.lists(inner, max_size=3)
        | st.dictionaries(KEYS, inner, max_size=2),
        max_leaves=6,
    ),
)  # fmt: skip
FOLDER = tempfile.TemporaryDirectory()
JSON_TOKENS = [
    "[",
    "]",
    "{",
    "}",
    ",",
    ":",
    '"',
    "1",
    "e999",
    "-",
    "null",
    "true",
    "\\",
]


def places(value):
    """Every container within, with each of its keys or indices."""
    if isinstance(value, dict | list):
        keys = value if isinstance(value, dict) else range(len(value))
        for key in list(keys):
            yield value, key
            yield from places(value[key])


def as_numpy(value):
    """What an entry means, by numpy alone."""
    assert not re.search("true|false|null|NaN|Inf", json.dumps(value))
    if isinstance(value, dict) and "shape" in value:
        return np.zeros(value["shape"])
    if isinstance(value, dict):
        return np.array(value["real"], float) + 1j * np.array(value["imag"], float)
    return np.array(value, dtype=float)


def check(kind, text):
    """Read a file; compare what is read with json and numpy, or look at the refusal."""
    reader, valid = READERS[kind]
    path = Path(FOLDER.name) / "a.json"
    path.write_text(text, encoding="utf-8")
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            found = reader(path)
    except ValueError as error:
        message = str(error).removeprefix(f"{path}: ")
        assert message != str(error) and len(message) < 600
        words = set(re.findall(r"\w+", re.sub(r" names?\b", "_names", message)))
        known = {*PLANT_DATA, *OBSERVER_DATA, "E", "S", "T0"}
        assert words & {*known, "JSON", "key", "keys"}, message
        return None
    data = {key: value for key, value in json.loads(text).items() if value is not None}
    for key, value in data.items():
        if key in ("luenberger", "format", "description"):
            continue
        mine = getattr(found, key)
        if isinstance(value, str):
            assert mine == value
        elif key.endswith("_names"):
            assert list(mine) == value
        elif key == "multiplicative":
            for pair, given_pair in zip(mine, value, strict=True):
                for X, wanted in zip(pair, given_pair, strict=True):
                    np.testing.assert_array_equal(X, as_numpy(wanted))
        elif key in ("Q", "R", "P0"):
            wanted = as_numpy(value)  # made symmetric, where it is so up to rounding
            rounding = 1e-9 * np.abs(wanted).max(initial=0)
            np.testing.assert_allclose(mine, wanted, rtol=0, atol=rounding)
        else:
            np.testing.assert_array_equal(mine, as_numpy(value), err_msg=key)
    return found


@pytest.mark.parametrize("kind", READERS)
def test_a_file_that_is_not_damaged_is_read(kind):
    found = check(kind, json.dumps(READERS[kind][1]))
    assert found is not None and found.dt == 0.5


@pytest.mark.parametrize("kind", READERS)
@bounded(100)
@given(st.data())
def test_a_damaged_record_is_read_as_numpy_would_or_refused(kind, draws):
    data = copy.deepcopy(READERS[kind][1])
    for _ in range(draws.draw(st.integers(1, 2), label="damages")):
        where = list(places(data))
        inside, key = where[draws.draw(st.integers(0, len(where) - 1), label="where")]
        if isinstance(inside, dict) and draws.draw(st.integers(0, 5)) == 0:
            del inside[key]
        else:
            inside[key] = copy.deepcopy(draws.draw(VALUES, label="what"))
    check(kind, json.dumps(data))


@pytest.mark.parametrize("kind", READERS)
@bounded(100)
@given(st.data())
def test_a_damaged_text_is_read_as_numpy_would_or_refused(kind, draws):
    text = json.dumps(READERS[kind][1])
    for _ in range(draws.draw(st.integers(1, 2))):
        at = draws.draw(st.integers(0, len(text)))
        cut = draws.draw(st.sampled_from([0, 1, 1, 5]))
        text = text[:at] + draws.draw(st.sampled_from(JSON_TOKENS)) + text[at + cut :]
    check(kind, text)


@pytest.mark.parametrize("kind", READERS)
@bounded(60)
@given(
    st.dictionaries(
        st.sampled_from([*PLANT_DATA, *OBSERVER_DATA, "E", "S", "T0", "_"]) | st.text(),
        VALUES,
        max_size=8,
    )
    | VALUES
)
def test_any_json_at_all_is_read_as_numpy_would_or_refused(kind, value):
    check(kind, json.dumps(value))
