"""`--U`: what is known of a plant's known input, as commands are told it."""

from argparse import ArgumentParser, ArgumentTypeError
from pathlib import Path
from typing import Any

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


def statistics(given: Any, dt: float) -> Any:
    """What `compare` takes as U: levels, a covariance or a plant; None if not given.

    A continuous model is sampled every `dt` seconds, its outputs held between.
    """
    from ..formats.json_files import json_file, require_plain
    from ..plant import Plant

    if not isinstance(given, Path):
        return given
    file = json_file(given, "a plant, or what is known of a known input,")
    if ENTRY not in file.data:
        model = Plant.from_json(file)
        return model.sampled(dt) if model.dt == 0 < dt else model
    if more := set(file.data) - {ENTRY, "description"}:
        raise ValueError(f"{given}: beside {ENTRY!r} there is {sorted(more)[0]!r}")
    require_plain(f"{given}: {ENTRY}", file.data[ENTRY])
    return file.data[ENTRY]
