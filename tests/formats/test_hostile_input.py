"""Files that are damaged, absurd or meant to harm: the right answer or a clear refusal.

Never another exception, a number that is not there, or memory that grows with what a
file claims.
"""

import io
import json
import tracemalloc

import numpy as np
import pytest
from json_data import PLANT_DATA, READERS

import luenberger as lb
from luenberger.formats import csv_table
from luenberger.formats.csv_table import Table
from luenberger.run import measurements, tables

PLANT = lb.Plant(
    [[0.5, 0.1], [0, 0.5]], [[1], [0]], np.eye(2), dt=1.0, Q=np.eye(2), R=np.eye(2),
    output_names=["range (m)", "b"], input_names=["u"],
)  # fmt: skip
HEADER = b"time,range (m),b,u\n"
ROWS = HEADER + b"1,2,3,4\n2,3,4,5\n"


def table(data, piece=csv_table.PIECE):
    return Table(io.BytesIO(data), "data.csv", piece)


def read(data, piece=csv_table.PIECE, may_miss=("range (m)", "b")):
    """Lines, times and values of a whole table."""
    one = table(data, piece)
    clock = tables.time_column(one, PLANT.output_names, PLANT.input_names)
    parts = list(one.rows(["range (m)", "b", "u"], may_miss, clock))
    return (
        [line for part in parts for line in part.lines],
        [cell for part in parts for cell in part.carried],
        np.concatenate([part.values for part in parts]),
    )


# ---------------------------------------------------------------------- what is read

READ = {
    "as it should be": ROWS,
    "byte order mark": b"\xef\xbb\xbf" + ROWS,
    "CRLF": ROWS.replace(b"\n", b"\r\n"),
    "no end of line at the end": ROWS[:-1],
    "quotes": b'"time","range (m)",b,u\n"1","2",3,4\n2,"3",4,"5"\n',
    "blanks around": b"time, range (m) ,b,u\n 1, 2 ,3 ,4\n2,3,4,5  \n",
    "blank lines": b"\n\n" + ROWS.replace(b"\n", b"\n  \n\n"),
    "other columns first": b"b,u,time,range (m)\n3,4,1,2\n4,5,2,3\n",
    "exponents and signs": HEADER + b"1,+2e0,.3e1,4.\n2,0.03E+2,400e-2,5.0\n",
}


@pytest.mark.parametrize("data", READ.values(), ids=READ)
def test_every_way_to_write_the_same_table(data, tmp_path):
    _, times, values = read(data)
    assert times == ["1", "2"]
    np.testing.assert_array_equal(values, [[2, 3, 4], [3, 4, 5]])
    (tmp_path / "data.csv").write_bytes(data)
    found = measurements.read(tmp_path / "data.csv", PLANT)
    np.testing.assert_array_equal(found.time, [1, 2])
    np.testing.assert_array_equal(found.y, values[:, :2])
    np.testing.assert_array_equal(found.u, values[:, 2:])


def test_lines_are_those_of_the_file():
    lines, _, _ = read(b"\n\n" + HEADER + b"1,2,3,4\n\n2,3,4,5\n")
    assert lines == [4, 6]
    assert read(ROWS)[0] == [2, 3]


@pytest.mark.parametrize("missing", [b"", b"nan", b"NaN", b" ", b"-nan"])
def test_a_missing_measurement_is_nan_and_a_row_of_them_is_a_row(missing):
    _, times, values = read(HEADER + b"1,%s,3,4\n2,%s,%s,5\n" % ((missing,) * 3))
    assert times == ["1", "2"]
    nan = np.nan
    np.testing.assert_array_equal(values, [[nan, 3, 4], [nan, nan, 5]])
    without_time = b"range (m),b,u\n,3,4\n%s,%s,5\n" % (missing, missing)
    np.testing.assert_array_equal(read(without_time)[2], values)


# ------------------------------------------------------------------- what is refused

REFUSED = {
    "nothing": (b"", "the file is empty"),
    "blank lines only": (b"\n \r\n\n", "the file is empty"),
    "header only": (HEADER, "column names but no measurements"),
    "semicolons": (
        b"time;range (m);b;u\n1;2,5;3;4\n",
        "semicolons separate the columns, and commas should",
    ),
    "tabs": (HEADER.replace(b",", b"\t"), "tabs separate the columns"),
    "decimal comma": (HEADER + b"1,2,5,3,4\n", "line 2: 5 cells, .* 4 columns"),
    "quoted decimal comma": (
        HEADER + b'1,"2,5",3,4\n',
        r"line 2: 'range \(m\)' is '2,5', not a number; write a point",
    ),
    "column missing": (b"time,b,u\n1,2,3\n", r"lacks the columns \['range \(m\)'\]"),
    "column unknown": (b"x,range (m),b,u\n1,2,3,4\n", r"unknown columns \['x'\]"),
    "column without a name": (HEADER[:-1] + b",\n1,2,3,4,5\n", r"unknown columns \[''"),
    "column twice": (HEADER[:-1] + b",b\n1,2,3,4,5\n", r"\['b'\] occur more than once"),
    "a million columns": (b"," * 900_000 + b"\n", r"\[''\] occur more than once"),
    "half a million names": (
        b",".join(b"%x" % k for k in range(160_000)) + b"\n",
        r"unknown columns \['0', '1', '2', '3', '4', and \d+ more\]",
    ),
    "short row": (ROWS + b"3,4\n", "line 4: 2 cells"),
    "long row": (ROWS + b"3,4,5,6,7\n", "line 4: 5 cells"),
    "rows that make up for each other": (
        HEADER + b"1,2,3\n4,5,6,7,8\n",
        "line 2: 3 cells",
    ),
    "such rows, times last": (
        b"range (m),b,u,time\n1,2,3\n4,5,6,7,8\n",
        "line 2: 3 cells",
    ),
    "text": (HEADER + b"1,2,fast,4\n", "line 2: 'b' is 'fast', not a number"),
    "formula": (HEADER + b"1,2,=1+1,4\n", "line 2: 'b' is '=1"),
    "underscore": (HEADER + b"1,2,1_0,4\n", "line 2: 'b' is '1_0'"),
    "hexadecimal": (HEADER + b"1,2,0x10,4\n", "line 2: 'b' is '0x10'"),
    "complex": (HEADER + b"1,2,1j,4\n", "line 2: 'b' is '1j'"),
    "digits of another script": (HEADER + "1,2,٣,4\n".encode(), "line 2: 'b'"),
    "infinite": (HEADER + b"1,2,inf,4\n", "line 2: 'b' is 'inf', not a number"),
    "too large": (HEADER + b"1,2,1e999,4\n", "line 2: 'b' is '1e999', not a number"),
    "input missing": (HEADER + b"1,2,3,\n", "line 2: 'u' is '', not a number"),
    "input not a number": (HEADER + b"1,2,3,nan\n", "line 2: 'u' is 'nan'"),
    "NUL": (ROWS + b"3,4,\x005,6\n", r"line 4: .b. is .*x005., not a number"),
    "zeros of a device": (b"\0" * 4096, "lacks the columns"),
    "quote not closed": (ROWS + b'3,"4,5,6\n4,5,6,7\n' * 10, "line 4: a quotation m"),
    "a line end in quotes": (HEADER + b'1,"2\n",3,4\n', "line 2: a quotation mark"),
    "text behind a gap": (HEADER + b"1,2,NaN,4\n2,3,fast,4\n", "line 3: .b. is .fast."),
    "text after a quote": (ROWS + b'3,"4"4,5,6\n', "line 4: a quotation mark"),
    "header's quote not closed": (b'time,"range (m),b,u\n1,2,3,4\n', "line 1: a quot"),
    "long cell": (HEADER + b"1,2,%s,4\n" % (b"x" * 10**5), r"line 2: .b. is .x*\.{3},"),
    "lines that end in CR": (ROWS.replace(b"\n", b"\r"), "line 1: a carriage return"),
    "not UTF-8": (HEADER + b"1,2,3\xe9,4\n", "line 2: not UTF-8 text: the byte 0xe9"),
    "UTF-16": (ROWS.decode().encode("utf-16"), "not UTF-8 text: .* 0xff; save"),
    "UTF-16 without a mark": (ROWS.decode().encode("utf-16-le"), "lacks the columns"),
    "JSON": (b'{"time": [1, 2]}\n', "lacks the columns"),
}


@pytest.mark.parametrize(("data", "pattern"), REFUSED.values(), ids=REFUSED)
def test_refused_with_line_and_column(data, pattern, tmp_path):
    (tmp_path / "data.csv").write_bytes(data)
    with pytest.raises(ValueError, match=pattern) as refused:
        measurements.read(tmp_path / "data.csv", PLANT)
    message = str(refused.value)
    assert message.startswith(f"{tmp_path / 'data.csv'}") and len(message) < 500


@pytest.mark.parametrize("clock", ["soon", "1_0", "inf", ""])
def test_a_report_needs_times_that_are_numbers(clock, tmp_path):
    (tmp_path / "data.csv").write_bytes(HEADER + clock.encode() + b",2,3,4\n")
    with pytest.raises(ValueError, match="line 2: 'time' is .*, not a number"):
        measurements.read(tmp_path / "data.csv", PLANT)


def test_a_column_on_its_own_with_a_blank_line_is_ambiguous():
    """Nobody can tell a missing measurement from a line left blank."""
    one = table(b"y\n1\n\n2\n", piece=2)
    with pytest.raises(ValueError, match="line 3: blank, with more lines after it"):
        list(one.rows(["y"], ["y"]))
    values = [part.values for part in table(b'y\n1\n""\n2\n\n \n').rows(["y"], ["y"])]
    np.testing.assert_array_equal(np.concatenate(values)[:, 0], [1, np.nan, 2])


@pytest.mark.parametrize("row", [b"1,,3,4\n", b'"1",,3,4\n'], ids=["plain", "quotes"])
def test_memory_is_that_of_a_piece(row):
    file, piece = io.BytesIO(HEADER + row * 8_000), 4096
    tracemalloc.start()
    one = Table(file, "data.csv", piece)
    assert sum(len(part.lines) for part in one.rows(["b"], (), "time")) == 8_000
    assert tracemalloc.get_traced_memory()[1] < 100 * piece
    tracemalloc.stop()


# ------------------------------------------------------------------ plants, observers


def with_(key, text, kind="plant"):
    """A valid file with one value replaced by a piece of JSON text."""
    data = READERS[kind][1] | {key: "@"}
    return kind, json.dumps(data).replace('"@"', text)


DEEP = "[" * 500 + "]" * 500
HUGE = "1" * 10**6
BAD_JSON = {
    "number beyond floats": (*with_("A", "[[1e999, 0], [0, 1]]"), "A has entries .* b"),
    "number of 400 digits": (
        *with_("R", f"[[{'9' * 400}]]"),
        "R has entries .* beyond",
    ),
    "number of 310 digits": (
        *with_("R", f"[[{'9' * 310}]]"),
        "R has entries .* beyond",
    ),
    "number of a million digits": (*with_("dt", HUGE), "dt has entries .* beyond"),
    "negative one": (*with_("x0", f"[-{HUGE}, 0]"), "x0 has entries .* beyond"),
    "infinite in an observer": (*with_("z0", "[-1e999]", "observer"), "z0 has entries"),
    "NaN": (*with_("Q", "[[NaN, 0], [0, 1]]"), "Q has entries .* NaN"),
    "Infinity": (*with_("dt", "Infinity"), "dt has entries"),
    "true for 1": (*with_("A", "[[1, 0], [0, true]]"), "A holds true, .* not a number"),
    "true for a step": (*with_("dt", "true"), "dt holds true"),
    "true for a format": (*with_("format", "true"), "format must be a whole number"),
    "null within": (*with_("A", "[[1, 0], [0, null]]"), "A holds null, .* not a num"),
    "null for a matrix": (*with_("A", "null"), "the plant has no 'A'"),
    "text for numbers": (
        *with_("A", '[["1", 0], [0, 1]]'),
        "A must be an array of real",
    ),
    "symbols": (*with_("dt", '"1/0"'), "dt must be 0 .* got '1/0'"),
    "a formula": (*with_("A", "\"__import__('os')\""), "A must be an array of real"),
    "ragged": (*with_("A", "[[1, 0], [0]]"), "A must be an array of real"),
    "no matrix": (*with_("A", "[]"), r"A must be a matrix.*shape \(0,\)"),
    "empty matrix": (*with_("A", "[[]]"), "A must be square and not empty, got 1 x 0"),
    "a number for a matrix": (*with_("C", "3"), r"C must be a matrix.*shape \(\)"),
    "step below normal numbers": (*with_("dt", "1e-320"), "dt must be 0 .* got 1e-320"),
    "negative step": (*with_("dt", "-0.5"), "dt must be 0 .* got -0.5"),
    "nested": (*with_("A", DEEP), "A is nested too deeply"),
    "nested objects": (
        *with_("name", '{"a": ' * 50 + "1" + "}" * 50),
        "name is nested",
    ),
    "nested without end": ("plant", "[" * 10**6, "not a JSON file: nested too deeply"),
    "objects without end": ("plant", '{"a":' * 10**6, "JSON file: nested too deeply"),
    "key twice": (
        "plant",
        '{"A": [[1]], "C": [[1]], "A": [[2]]}',
        "key 'A' occurs more",
    ),
    "key twice within": (
        *with_("A", '{"shape": [0, 2], "shape": [2, 0]}'),
        "key 'shape' occurs",
    ),
    "sizes claimed": (*with_("n", "1000000000"), r"unknown keys \['n'\]"),
    "a shape claimed": (*with_("B", '{"shape": [1000000000, 0]}'), "B has the shape"),
    "a shape that is not empty": (
        *with_("B", '{"shape": [30000, 9]}'),
        "B must be num",
    ),
    "a shape of many axes": (
        *with_("B", f'{{"shape": {[0] * 70}}}'),
        "B has the shape",
    ),
    "a shape of halves": (*with_("B", '{"shape": [0, 0.5]}'), "B has the shape"),
    "many unknown keys": (
        "plant",
        json.dumps({f"k{k}": 0 for k in range(10**5)}),
        "unknown keys .*, and 99995 more",
    ),
    "a name that is a path": (*with_("state_names", '["../../x", 5]'), "state names"),
    "a NUL in a name": (
        *with_("name", r'"a\u0000b"'),
        r"name 'a\\x00b' must be one line",
    ),
    "a line end in a name": (*with_("name", r'"a\nb"'), "must be one line of text"),
    "colours in a name": (
        *with_("output_names", r'["\u001b[31mred"]', "observer"),
        r"output name '\\x1b\[31mred' must be one line .* without control characters",
    ),
    "a name read backwards": (
        *with_("output_names", r'["\u202egnp"]'),
        "one line of tex",
    ),
    "half a character": (*with_("output_names", r'["\ud800"]'), "must be one line of"),
    "a number for a name": (*with_("name", "5"), "name must be a string, got 5"),
    "a matrix for a name": (
        *with_("name", '{"real": 1, "imag": 2}'),
        "name must be a st",
    ),
    "names that are numbers": (
        *with_("output_names", "[5]"),
        "output names must be a li",
    ),
    "names that are one number": (
        *with_("output_names", "5"),
        "output names must be a l",
    ),
    "100000 names": (
        *with_("output_names", json.dumps([str(k) for k in range(10**5)])),
        "output names must be 1 different strings, got 100000: .* and 99995 more",
    ),
    "a long text": (*with_("P0_is", f'"{HUGE}"'), "P0_is must be 'prior'"),
    "a matrix for a text": (*with_("P0_is", "[[1]]"), "P0_is must be 'prior'"),
    "a text for a truth": (*with_("at_first", '"yes"'), "at_first must be True"),
    "a truth": (*with_("at_first", "true"), "at_first holds true, which is not a"),
    "a text for pairs": (
        *with_("multiplicative", '"ab"'),
        "multiplicative must be a li",
    ),
    "a format to come": (*with_("format", "2"), "format 2, .* reads format 1"),
    "a format of 400 digits": (
        *with_("format", "9" * 400),
        "format must be a whole num",
    ),
    "another kind": (*with_("luenberger", '"observer"'), "does not hold a plant"),
    "a list for a kind": (*with_("luenberger", "[[]]"), "does not hold a plant"),
    "a list": ("observer", "[]", "an observer is a JSON object, got list"),
    "nothing": ("observer", "", "not a JSON file"),
    "NULs": ("plant", "\0" * 100, "not a JSON file"),
    "trailing text": ("plant", json.dumps(PLANT_DATA) + "x", "behind .*: Extra data"),
    "unequal parts": (
        *with_("F", '{"real": [[1]], "imag": [1]}', "observer"),
        r"F has a real part of shape \(1, 1\)",
    ),
    "inputs that are claimed": (
        "observer",
        json.dumps(
            dict(
                F={"shape": [0, 0]},
                G={"shape": [0, 999_999]},
                D={"shape": [0, 0]},
                P={"shape": [999_999, 0]},
                V={"shape": [999_999, 0]},
                T={"shape": [0, 0]},
                L={"shape": [999_999, 0]},
            )
        ),
        "W would be 999999 x 999999 zeros",
    ),
    "a feedthrough that is implied": (
        "plant",
        json.dumps(dict(A=[[1]], B=[[0] * 20_000], C=[[0]] * 20_000)),
        "E would be 20000 x 20000 zeros",
    ),
}


@pytest.mark.parametrize(("kind", "text", "pattern"), BAD_JSON.values(), ids=BAD_JSON)
def test_json_is_refused_with_the_key(kind, text, pattern, tmp_path):
    path = tmp_path / "bad.json"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(ValueError, match=pattern) as refused:
        READERS[kind][0](path)
    message = str(refused.value)
    assert message.startswith(f"{path}: ") and len(message) < 600


def test_bytes_that_are_not_text_are_refused(tmp_path):
    (tmp_path / "bad.json").write_bytes(b'{"A": "\xff"}')
    with pytest.raises(ValueError, match="not a JSON file in UTF-8; save it as UTF-8"):
        lb.Plant.from_json(tmp_path / "bad.json")


MEANT = {
    "Ts": "dt is the sampling period in seconds",
    "QN": "Q is the covariance of w",
    "RN": "R is the covariance of one reading",
    "D": "E is the matrix from u to y",
    "a": "Is 'a' meant for 'A'",
    "output_name": "Is 'output_name' meant for 'output_names'",
}


@pytest.mark.parametrize(("key", "hint"), MEANT.items())
def test_a_key_of_another_program_gets_a_hint(key, hint, tmp_path):
    (tmp_path / "p.json").write_text(json.dumps({"A": [[1]], "C": [[1]], key: [[1]]}))
    with pytest.raises(ValueError, match=f"unknown keys .*{hint}"):
        lb.Plant.from_json(tmp_path / "p.json")


MISTAKES = {
    "missing comma": ('{"A": [[1]],\n "C": [[1]]\n "dt": 1}', "line 2, .*a comma or a"),
    "trailing comma": (
        '{"A": [[1]],\n "C": [[1]],\n}',
        "line 2, .*nothing follows",
    ),
    "comment": ('{"A": [[1]], // of the motor\n "C": [[1]]}', "line 1, .*no comments"),
}


@pytest.mark.parametrize(("text", "said"), MISTAKES.values(), ids=MISTAKES)
def test_json_that_is_none_is_quoted_where_it_stops(text, said, tmp_path):
    (tmp_path / "p.json").write_text(text)
    with pytest.raises(ValueError, match=f"not a JSON file: {said}"):
        lb.Plant.from_json(tmp_path / "p.json")


def test_json_with_a_byte_order_mark_is_read(tmp_path):
    (tmp_path / "plant.json").write_text(json.dumps(PLANT_DATA), encoding="utf-8-sig")
    assert lb.Plant.from_json(tmp_path / "plant.json").name == "cart"


def test_a_matrix_too_large_for_fractions_has_none(tmp_path):
    """Each would be an object of 100 bytes, for arithmetic that never ends."""
    assert lb.Plant(np.eye(30, dtype=int), None, np.eye(30, dtype=int)).exact
    data = dict(A=np.eye(320, dtype=int).tolist(), C=np.eye(1, 320, dtype=int).tolist())
    (tmp_path / "plant.json").write_text(json.dumps(data))
    assert lb.Plant.from_json(tmp_path / "plant.json").exact is None
    wide = dict(A=[[1]], B=[[0] * 400], C=[[0]] * 400)
    assert lb.Plant(**wide, dt=1.0).exact is None
