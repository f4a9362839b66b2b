"""`fit`: noise covariances and unknown entries of a plant, from a record."""

import dataclasses
import math
from argparse import ArgumentTypeError, Namespace
from typing import Any

from .registration import as_json, dry_run, file, plant_of, register, sample
from .terminal import say, tell, tell_json

KNOWN = "known"
FORMS = ("full", "diagonal", "scaled", KNOWN)


def add(commands: Any) -> None:
    one = register(
        commands,
        "fit",
        run,
        help="fit the noise covariances of a plant to a record",
        description="Find the most likely Q and R of a plant, and entries of A, B, C "
        "or E that are unknown, from measurements in columns named after its outputs "
        "and inputs; an empty cell was not measured. What no record can determine is "
        "refused, and named. Writes the plant with what was found.",
        examples=[
            "fit nile.json nile.csv --out nile-fitted.json",
            "fit ball-and-beam.json ball-and-beam.csv --sample 0.1 --q diagonal "
            "--out ball-fitted.json",
        ],
    )
    one.add_argument("plant", type=file, metavar="PLANT.json")
    one.add_argument("data", type=file, metavar="DATA.csv")
    one.add_argument(
        "--out", type=file, required=True, metavar="FITTED.json", help="the plant found"
    )
    for letter, meaning in (("q", "process"), ("r", "measurement")):
        one.add_argument(
            f"--{letter}",
            choices=FORMS,
            help=f"what to find of the {meaning} noise's covariance: every entry, the "
            "diagonal, a factor of the plant's own, or nothing; default is to keep "
            "what the plant gives, and to find as much as a record can determine of "
            "what it does not",
        )
    one.add_argument(
        "--parameter",
        action="append",
        type=_entry,
        metavar="ENTRY=START",
        help="an unknown entry such as B[1,0]=4, counted from 0; may be repeated",
    )
    sample(one)
    as_json(one)
    dry_run(one, "fit")


def _entry(text: str) -> tuple[str, float]:
    name, sign, start = text.partition("=")
    try:
        return name.strip(), float(start)
    except ValueError:
        raise ArgumentTypeError(f"give ENTRY=START, not {text!r}") from None


def run(options: Namespace) -> None:
    """Fit, write the plant, and say what was found and how sure it is."""
    from ..formats.atomic import destination, require_other
    from ..run import measurements

    require_other(options.out, options.plant, options.data)
    plant = plant_of(options.plant, options)
    data = measurements.read(options.data, plant)
    destination(options.out)
    fit, said = _fitted(plant, data, options)
    sentences = [*said, *fit.unidentifiable, *fit.whiteness.sentences]
    about = [plant.description] if plant.description else []
    told = dataclasses.replace(fit.plant, description=" ".join([*about, *said]))
    if not options.dry_run:
        told.to_json(options.out)
    if options.json:
        tell_json(_document(fit, sentences))
    else:
        for line in [*fit.lines, *sentences]:
            tell(line)
    say(f"dry run: {options.out} was not written" if options.dry_run else "done")


def _fitted(plant: Any, data: Any, options: Namespace) -> tuple[Any, list[str]]:
    """The fit, and what was fitted in words."""
    from ..identification.fit import fit_missing, fit_noise, lacking

    asked = {"Q": options.q, "R": options.r}
    parameters = dict(options.parameter or ())
    if not (any(asked.values()) or parameters):
        if not lacking(plant):
            options.wrong(
                "the plant gives both Q and R; say with --q, --r or --parameter what "
                "is to be fitted"
            )
        return fit_missing(plant, data.record)
    missing = lacking(plant)
    forms = {
        name: form or ("full" if name in missing else KNOWN)
        for name, form in asked.items()
    }
    kept: dict[str, Any] = {
        name: None if form == KNOWN else form for name, form in forms.items()
    }
    fit = fit_noise(
        plant,
        data.record,
        **kept,
        parameters=parameters or None,
    )
    words = [f"{name} ({form})" for name, form in forms.items() if form != KNOWN]
    words += list(parameters)
    return fit, [f"Fitted to {options.data.name} by maximum likelihood: {_and(words)}."]


def _and(words: list[str]) -> str:
    return " and ".join([", ".join(words[:-1]), words[-1]][len(words) == 1 :])


def _document(fit: Any, sentences: list[str]) -> dict[str, Any]:
    """The fit as plain data; an error that there is not is null."""
    errors = fit.standard_errors
    plain = {name: _plain(value) for name, value in errors.items()}
    white = fit.whiteness
    return {
        "Q": fit.plant.Q.tolist(),
        "R": fit.plant.R.tolist(),
        "parameters": fit.parameters,
        "standard_errors": plain,
        "log_likelihood": fit.log_likelihood,
        "whiteness": {
            "statistic": white.statistic,
            "dof": white.dof,
            "p_value": white.p_value,
            "variance": white.variance.tolist(),
        },
        "sentences": sentences,
    }


def _plain(value: Any) -> Any:
    """Lists of numbers, None for those that are none."""
    if hasattr(value, "tolist"):
        value = value.tolist()
    if isinstance(value, list):
        return [_plain(one) for one in value]
    return value if math.isfinite(value) else None
