"""Plants and observers as arguments: one way to say that something else was given."""

from .observer import Observer
from .plant import Plant

Kind = tuple[type, ...]

PLACES = ("first", "second", "third")
KINDS = {
    "plant": (Plant,),
    "observer": (Observer,),
    "source": (Observer, Plant),
}
MAKING: dict[type, str] = {
    Plant: "Plant(A, B, C, ...)",
    Observer: "a design such as kalman_filter",
}


def expect(**given: object) -> None:
    """Raise ValueError unless `plant` is a Plant, `observer` an Observer, and so on.

    The arguments are the caller's first ones, by name and in the caller's order; one
    with a name of its own only takes a place.

    Examples
    --------
    >>> import luenberger as lb
    >>> plant = lb.Plant([[0.5]], None, [[1]], dt=1.0)
    >>> lb.certify(plant, lb.deadbeat_observer(plant))
    Traceback (most recent call last):
        ...
    ValueError: expected an Observer in the first place, got a Plant; the order is (observer, plant)
    >>> lb.kalman_filter([[0.5]])
    Traceback (most recent call last):
        ...
    ValueError: expected a Plant in the first place, got a list; Plant(A, B, C, ...) makes one
    """  # noqa: E501
    for place, (name, value) in zip(PLACES, given.items()):
        wanted = KINDS.get(name)
        if wanted and not isinstance(value, wanted):
            message = _message(f"in the {place} place", wanted, value)
            others = (type(value) in KINDS.get(one, ()) for one in given)
            if any(others):
                message += f"the order is ({', '.join(given)})"
            else:
                message += _advice(wanted, value)
            raise ValueError(message)


def expect_as(where: str, kind: str, value: object) -> None:
    """Raise ValueError unless a value, described by `where`, is of a kind by name."""
    if not isinstance(value, KINDS[kind]):
        wanted = KINDS[kind]
        message = _message(f"as {where}", wanted, value) + _advice(wanted, value)
        raise ValueError(message)


def expect_beside(source: object, plant: object) -> None:
    """Raise unless there is a Plant, or an Observer with perhaps a Plant beside it."""
    expect(source=source)
    if plant is not None:
        expect_as("plant=", "plant", plant)
        if isinstance(source, Plant):
            raise ValueError(
                "plant= goes with an observer, and the source is a plant: leave it out"
            )


def _message(where: str, wanted: Kind, value: object) -> str:
    names = " or ".join(_one(kind.__name__) for kind in wanted)
    got = "None" if value is None else _one(type(value).__name__.removeprefix("nd"))
    got = f"the class {value.__name__}" if isinstance(value, type) else got
    return f"expected {names} {where}, got {got}; "


def _advice(wanted: Kind, value: object) -> str:
    if isinstance(value, Observer):
        return "give the Plant that it was designed for"
    return f"{' or '.join(MAKING[kind] for kind in wanted)} makes one"


def _one(noun: str) -> str:
    return f"{'an' if noun[0] in 'aeiouAEIOU' else 'a'} {noun}"
