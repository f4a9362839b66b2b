"""Exported C breaks no required rule of MISRA C:2012 that cppcheck's addon tests."""

import re
import shutil
import subprocess

import generators
import numpy as np
import pytest

import luenberger as lb
from luenberger.export import to_c

CPPCHECK = shutil.which("cppcheck")
needs_cppcheck = pytest.mark.skipif(CPPCHECK is None, reason="there is no cppcheck")

# The addon has no texts of the rules, so it does not say which are advisory.
ADVISORY = {
    "2.4": "an enum without a tag holds the sizes",
    "8.7": "what a caller uses is used by the self-test alone, in this one file",
    "8.9": "a table that one function uses is at file scope",
    "12.1": "precedence of * over + is not written with parentheses",
    "12.3": "one declaration of two arrays",
    "15.5": "a function returns where it refuses",
    "18.4": "a pointer to a row is an array plus an offset",
}
FOUND = re.compile(r"(\S+):(\d+) misra-c2012-(\d+\.\d+)")


def plant(n, p, **options):
    return generators.plant(np.random.default_rng(3), n, p, m=2, **options)


FLOAT = dict(dtype="float")

# each kind in double and in float: one of them as scalars, the other in loops
EXPORTS = {
    "constant gain": lambda: (lb.kalman_filter(plant(4, 3)), {}),
    "constant gain, loops": lambda: (lb.kalman_filter(plant(9, 2)), FLOAT),
    "no states": lambda: (lb.reduced_order_filter(plant(3, 3), 3), FLOAT),
    "filter": lambda: (plant(2, 1), FLOAT),
    "filter, loops, accurate": lambda: (plant(5, 2, cross=False), dict(m1=1)),
    "filter of correlated noises": lambda: (plant(3, 2, cross=False), {}),
    "filter, S": lambda: (plant(3, 2), {}),
    "filter, loops": lambda: (plant(8, 2, cross=False), FLOAT),
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
            found.append((rule, f"{row}: {text}"))
        else:
            assert line.startswith("nofile:"), line
    return found


@needs_cppcheck
@pytest.mark.parametrize("made", EXPORTS.values(), ids=EXPORTS)
def test_no_required_rule_is_broken(made, tmp_path):
    source, options = made()
    code, _ = to_c(source, tmp_path, name="unit", **options)
    found = broken(code, "unit_SELFTEST")
    assert found, "the addon did not run: 15.5 is broken wherever a step refuses"
    wrong = [one for one in found if one[0] not in ADVISORY]
    assert not wrong, "\n".join(f"{rule}, line {text}" for rule, text in wrong)


@needs_cppcheck
def test_a_broken_rule_is_found_by_name(tmp_path):
    code, _ = to_c(lb.kalman_filter(plant(4, 3)), tmp_path, name="unit")
    text = code.read_text()
    fault = "    if (y[0] > 0.0) state->z[0] = 0.0;\n    return 0;"
    code.write_text(text.replace("    return 0;", fault, 1))
    assert "15.6" in {rule for rule, _ in broken(code)}
