"""`--U`: what is known of a plant's known input, as commands are told it."""

from argparse import ArgumentParser, ArgumentTypeError
from pathlib import Path
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from ..plant import Plant

ENTRY = "U"  # of a file: levels, or the covariance of white inputs


def known_input(one: ArgumentParser) -> None:
    """The option of commands that judge errors."""
    one.add_argument(
        "--U",
        type=_given,
        metavar="U1,U2,...|FILE.json",
        help="what is known of the known input, which errors then count: a level for "
        "each input, constant for ever from before the start (an input that switches "
        "is not that), 0 for inputs that are always zero, or a file with a plant whose "
        'outputs they are (modes on the unit circle are tones), or {"U": [[144]]}, the '
        "covariance of white inputs",
    )


def _given(text: str) -> Any:
    """Levels, or the path of a file."""
    if text.endswith(".json"):
        return Path(text)
    try:
        if "_" in text or not text.isascii():  # float() takes 1_0 and foreign digits
            raise ValueError
        levels = [float(number) for number in text.split(",")]
    except ValueError:
        raise ArgumentTypeError(
            f"give levels such as 12 or 12,0.5, or a file that ends in .json, not "
            f"{text!r}"
        ) from None
    return 0 if levels == [0] else levels


def with_input(plant: "Plant", given: Any) -> "Plant":
    """The plant with what the option says of its input: levels, a covariance, a model.

    A continuous model is sampled with a discrete plant, its outputs held between.
    """
    from ..formats.json_files import json_file, require_plain
    from ..plant import Plant

    if given is None:
        return plant
    if not isinstance(given, Path):
        return plant.with_input(given)
    file = json_file(given, "a plant, or what is known of a known input,")
    if ENTRY not in file.data or "A" in file.data:
        model = Plant.from_json(file)
        late = model.dt == 0 < plant.dt
        return plant.with_input(model.sampled(plant.dt) if late else model)
    if more := set(file.data) - {ENTRY, "description"}:
        raise ValueError(f"{given}: beside {ENTRY!r} there is {sorted(more)[0]!r}")
    require_plain(f"{given}: {ENTRY}", file.data[ENTRY])
    return plant.with_input(file.data[ENTRY])
