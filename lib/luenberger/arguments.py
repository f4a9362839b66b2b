"""Plants and observers as arguments: a TypeError where something else was given."""

from .observer import Observer
from .plant import Plant

KINDS: dict[str, tuple[type, ...]] = {
    "plant": (Plant,),
    "observer": (Observer,),
    "source": (Observer, Plant),
}


def expect(**given: object) -> None:
    """Raise TypeError unless `plant` is a Plant, `observer` an Observer, and so on.

    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0)
    >>> lb.certify(plant, lb.deadbeat_observer(plant))
    Traceback (most recent call last):
        ...
    TypeError: observer must be an Observer, got a Plant
    """
    for name, value in given.items():
        if name in KINDS:
            expect_as(name, name, value)


def expect_as(where: str, kind: str, value: object) -> None:
    """Raise TypeError unless a value, described by `where`, is of a kind by name."""
    if not isinstance(value, KINDS[kind]):
        wanted = " or ".join(_one(each.__name__) for each in KINDS[kind])
        got = _one(type(value).__name__)
        got = f"the class {value.__name__}" if isinstance(value, type) else got
        raise TypeError(f"{where} must be {wanted}, got {got}")


def _one(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiouAEIOU' else 'a'} {noun}"
