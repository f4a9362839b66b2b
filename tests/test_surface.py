"""What `import luenberger as lb` shows: few names, each with a help of one screen."""

import inspect
import pkgutil
import pydoc

import pytest

import luenberger as lb

LINES = 60
EARLY = 12  # lines until the example begins
# what a plant or a record is made of counts once
FIELDS = set("y u u0 time arrival".split()) | set("Q R S x0 P0".split())
MORE = {"monte_carlo": 9}
THINGS = {name: getattr(lb, name) for name in lb.__all__}
CALLED = {name: one for name, one in THINGS.items() if not inspect.ismodule(one)}


def methods(kind):
    """The public methods of a class, by name."""
    found = ((name, getattr(kind, name)) for name in vars(kind) if name[0] != "_")
    return {name: one for name, one in found if callable(one)}


def test_there_is_nothing_else():
    assert dir(lb) == sorted(lb.__all__) and len(lb.__all__) <= 26
    assert {"Plant", "kalman_filter", "compare", "plot"} <= {*THINGS}
    with pytest.raises(AttributeError, match="no attribute 'import_module'"):
        _ = lb.import_module


def test_no_function_has_the_name_of_a_module():
    modules = {found.name for found in pkgutil.iter_modules(lb.__path__)}
    assert {"plant", "sampling"} <= modules
    assert not modules & {*CALLED}


@pytest.mark.parametrize("name", sorted(CALLED))
def test_its_help_is_a_screen_that_begins_with_an_example(name):
    one = CALLED[name]
    text = inspect.getdoc(one)
    told = [text]
    if inspect.isclass(one):  # `help` has pages of what a class inherits
        told += [inspect.getdoc(method) for method in methods(one).values()]
    else:
        told = [pydoc.render_doc(one, renderer=pydoc.plaintext)]
    assert all(len(each.splitlines()) <= LINES for each in told)
    assert ">>> " in "\n".join(text.splitlines()[:EARLY])


@pytest.mark.parametrize("name", sorted(CALLED))
def test_it_asks_for_few_things(name):
    one = CALLED[name]
    asked = methods(one) if inspect.isclass(one) else {name: one}
    for each in asked.values():
        parameters = {*inspect.signature(each).parameters} - {"self"} - FIELDS
        most = MORE.get(each.__name__, 7)
        assert len(parameters) <= most, (each.__qualname__, parameters)
