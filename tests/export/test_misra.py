"""Exported C breaks no required rule of MISRA C:2012 that cppcheck's addon tests."""

import re
import shutil
import subprocess

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.export import to_c

GCC = shutil.which("gcc") or shutil.which("cc")
CPPCHECK = shutil.which("cppcheck")
needs_cppcheck = pytest.mark.skipif(CPPCHECK is None, reason="there is no cppcheck")

# The addon has no texts of the rules, so it does not say which are advisory.
ADVISORY = {
    "2.4": "an enum without a tag holds the sizes",
    "2.5": "a caller may need no count of a unit",
    "8.7": "what a caller uses is used by the self-test alone, in this one file",
    "8.9": "a table that one function uses is at file scope",
    "12.1": "precedence of * over + is not written with parentheses",
    "12.3": "one declaration of two arrays",
    "15.5": "a function returns where it refuses",
    "18.4": "a pointer to a row is an array plus an offset",
}
# The word stands there, also where the macro is given and the line is left out.
DEFAULT = "#define unit_RESTRICT restrict"
FOUND = re.compile(r"(\S+):(\d+) misra-c2012-(\d+\.\d+)")


def plant(n, p, **options):
    return generators.plant(np.random.default_rng(3), n, p, m=2, **options)


FLOAT, GUARDED = dict(dtype="float"), dict(update="guarded")

# each kind in double and in float: one of them as scalars, the other in loops
EXPORTS = {
    "constant gain": lambda: (lb.kalman_filter(plant(4, 3)), {}),
    "constant gain, loops": lambda: (lb.kalman_filter(plant(9, 2)), FLOAT),
    "no states": lambda: (lb.reduced_order_filter(plant(3, 3), 3), FLOAT),
    "filter": lambda: (plant(2, 1), FLOAT),
    "filter, loops, accurate": lambda: (plant(5, 2, cross=False), dict(m1=1)),
    "guarded": lambda: (plant(2, 1), GUARDED),
    "guarded, loops": lambda: (plant(5, 2, cross=False), FLOAT | GUARDED),
}


FIXED = {
    "unrolled": (2, 1, 16),
    "unrolled, wide": (2, 1, 32),
    "loops": (4, 3, 16),
    "loops, wide": (4, 3, 32),
}


def broken(path, *defines):
    """What cppcheck finds in a file: (rule, the line's text)."""
    given = [f"-D{one}" for one in defines]
    options = "--std=c99 --addon=misra --inline-suppr -q".split()
    template = "--template={file}:{line} {id}"
    done = subprocess.run(
        [CPPCHECK, *options, template, *given, path], capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    found = []
    for line in done.stderr.splitlines():
        if match := FOUND.match(line):
            file, row, rule = match.groups()
            text = open(file).read().splitlines()[int(row) - 1].strip()
            if text != DEFAULT:
                found.append((rule, f"{row}: {text}"))
        else:
            assert line.startswith("nofile:"), line
    return found


@needs_cppcheck
@pytest.mark.parametrize("made", EXPORTS.values(), ids=EXPORTS)
def test_no_required_rule_is_broken(made, tmp_path):
    source, options = made()
    code, _ = to_c(source, tmp_path, name="unit", **options)
    plain = ["unit_RESTRICT=", "unit_LANES=1"]
    found = broken(code, *plain, "unit_SELFTEST")
    assert found, "the addon did not run: 15.5 is broken wherever a step refuses"
    wrong = [one for one in found if one[0] not in ADVISORY]
    assert not wrong, "\n".join(f"{rule}, line {text}" for rule, text in wrong)


@needs_cppcheck
@pytest.mark.parametrize("n, p, bits", FIXED.values(), ids=FIXED)
def test_no_required_rule_is_broken_in_whole_numbers(n, p, bits, tmp_path):
    here = plant(n, p)
    given = dict(plant=here, dtype="fixed", bits=bits, ranges={"u1": 1.0, "u2": 2.0})
    code, _ = to_c(lb.kalman_filter(here), tmp_path, name="unit", **given)
    assert ("unit_row" in code.read_text()) is (n > 2)
    found = broken(code, "unit_SELFTEST")
    assert found, "the addon did not run: 15.5 is broken wherever a step refuses"
    wrong = [one for one in found if one[0] not in ADVISORY]
    assert not wrong, "\n".join(f"{rule}, line {text}" for rule, text in wrong)


@pytest.mark.skipif(GCC is None, reason="there is no C compiler")
def test_restrict_is_left_out_where_the_macro_is_empty(tmp_path):
    code, _ = to_c(plant(5, 2, cross=False), tmp_path, name="unit")

    def words(*options):
        command = [GCC, "-std=c99", "-E", *options, code]
        return subprocess.run(command, capture_output=True, text=True, check=True)

    word = re.compile(r"\brestrict\b")
    assert word.search(words().stdout)
    assert not word.search(words("-Dunit_RESTRICT=").stdout)


@needs_cppcheck
def test_a_broken_rule_is_found_by_name(tmp_path):
    code, _ = to_c(lb.kalman_filter(plant(4, 3)), tmp_path, name="unit")
    text = code.read_text()
    fault = "    if (y[0] > 0.0) state->z[0] = 0.0;\n    return 0;"
    code.write_text(text.replace("    return 0;", fault, 1))
    assert "15.6" in {rule for rule, _ in broken(code, "unit_RESTRICT=")}
