"""Collection leaves out no example that a docstring holds, and no test."""

import gc

import collecting
import pytest


class DoctestModule:
    """Named as the collector of pytest."""


EXAMPLES, TESTS = DoctestModule(), "the tests"


@pytest.mark.parametrize(
    "name, text, left",
    [
        ("one.py", '"""Words.\n\n>>> 1 + 1\n2\n"""\n', [TESTS, EXAMPLES]),
        ("one.py", "def f():\n    '''\n    >>>1\n    '''\n", [TESTS, EXAMPLES]),
        ("one.py", '"""No example."""\n', [TESTS]),
        ("page.txt", "no example", [TESTS, EXAMPLES]),
    ],
)
def test_only_a_module_without_an_example_is_spared(name, text, left, tmp_path):
    (tmp_path / name).write_text(text)
    hook = collecting.pytest_collect_file(tmp_path / name)
    next(hook)
    with pytest.raises(StopIteration) as end:
        hook.send([TESTS, EXAMPLES])
    assert end.value.value == left


def test_the_name_is_that_of_the_collector_of_pytest():
    from _pytest import doctest

    assert doctest.DoctestModule.__name__ == DoctestModule.__name__


def test_the_garbage_collector_runs_while_tests_do():
    assert gc.isenabled() and gc.get_freeze_count() > 100_000
