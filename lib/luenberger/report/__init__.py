"""What a report says and shows of one plant: facts, sentences, pictures, files.

What is written for a reader of one plant's report enters here, and what runs a
notebook.  It uses `compare`, `run` and what is below them.
"""

from importlib import import_module

_CONTENT = (  # on demand, because `content` imports matplotlib
    "Prose Table Picture about estimates gains_and_poles matrices "
    "pareto plant_poles recommendation refusals signals sizes "
    "state_errors title variances"
).split()
_AGREEMENT = ("judged", "agreement", "innovations")


def __getattr__(name):
    if name in _CONTENT:
        return getattr(import_module(".content", __name__), name)
    if name in _AGREEMENT:
        return getattr(import_module(".whiteness_of_record", __name__), name)
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")
