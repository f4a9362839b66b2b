"""The command line, `luenberger COMMAND` or `python -m luenberger COMMAND`.

Each command is a function; above it stand its options, and its docstring is its help:
a line, a paragraph, examples.  Results go to stdout, everything else to stderr.  What
a command needs of the library it imports itself, so that ``--help`` is quick.
"""

import argparse
import contextlib
import dataclasses
import inspect
import json
import math
import os
import shlex
import sys
import tempfile
import textwrap
from argparse import ArgumentTypeError, Namespace
from collections.abc import Callable, Iterable, Iterator, Sequence
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

if TYPE_CHECKING:
    from .formats.csv_table import Table
    from .identification.fit import NoiseFit
    from .plant import Plant
    from .run.measurements import Measurements

WIDE = 79
STREAM = "-"
STATUSES = """\
exit status:
  0    done
  1    refused, with the reason on stderr; also a file that cannot be read or written
  2    the command line itself is wrong
  130  interrupted (141 if nobody reads the output)
A file is written beside and renamed: it is the old one or the new one, and whole."""
Option = tuple[tuple[str, ...], dict[str, Any]]
Command = Callable[[Namespace], None]
COMMANDS: dict[str, tuple[Command, tuple[Option, ...]]] = {}


def main(arguments: Sequence[str] | None = None) -> int:
    """Run a command; returns the exit status, or raises SystemExit for --help."""
    for stream in (sys.stdout, sys.stderr):
        if hasattr(stream, "reconfigure"):  # any name goes to any terminal
            stream.reconfigure(errors="backslashreplace")
    try:
        options = parser().parse_args(arguments)
        options.line = arguments if arguments is not None else sys.argv[1:]
        with np.errstate(all="ignore"):  # what overflows is refused by what it spoils
            options.run(options)
        sys.stdout.flush()
    except BrokenPipeError:  # nobody reads the rest, so Python is not to try again
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        return 141
    except KeyboardInterrupt:
        say("luenberger: interrupted")
        return 130
    except OSError as error:
        where = f"{error.filename}: " if error.filename else ""
        say(f"luenberger: {where}{error.strerror or error}")
        return 1
    except (ValueError, ImportError, MemoryError) as error:
        said = str(error) or type(error).__name__
        if type(error).__name__ == "LinAlgError" or "infs or NaNs" in said:
            said = f"the numbers are too large or too unlike to compute with: {said}"
        say(f"luenberger: {said.replace('plant.sampled(0.1)', '--sample 0.1')}")
        return 1
    return 0


def parser() -> argparse.ArgumentParser:
    """The parser of every command."""
    plain: dict[str, Any] = dict(formatter_class=argparse.RawDescriptionHelpFormatter)
    about = "Reduced-order state observers."
    top = argparse.ArgumentParser(
        "luenberger", description=about, epilog=STATUSES, allow_abbrev=False, **plain
    )
    top.add_argument("--version", action=_Version, help="print the version and end")
    commands = top.add_subparsers(title="commands", metavar="COMMAND", required=True)
    for name, (run, options) in COMMANDS.items():
        first, *about, examples = inspect.cleandoc(run.__doc__ or "").split("\n\n")
        lines = [f"  luenberger {one}" for one in examples.split("\n")]
        text = "\n\n".join(textwrap.fill(one, WIDE) for one in (first, *about))
        one = commands.add_parser(
            name,
            help=first[0].lower() + first[1:].rstrip("."),
            description=text,
            epilog="\n".join(["examples:", *lines]),
            allow_abbrev=False,
            **plain,
        )
        for names, how in options:
            one.add_argument(*names, **how)
        one.set_defaults(run=run, wrong=one.error)
    return top


class _Version(argparse.Action):
    """Print the version, which takes time to look up, and end."""

    def __init__(self, option_strings: list[str], dest: str, help: str) -> None:
        super().__init__(option_strings, dest, nargs=0, help=help)

    def __call__(self, *_: object) -> None:
        from importlib.metadata import version

        print(f"luenberger {version('luenberger')}")
        raise SystemExit(0)


def command(*options: Option) -> Callable[[Command], Command]:
    """Make a function a command of its name, with these options."""

    def register(run: Command) -> Command:
        COMMANDS[run.__name__.rstrip("_")] = run, options
        return run

    return register


def option(*names: str, **how: Any) -> Option:
    """An argument of a command, as argparse takes it."""
    return names, how


def say(text: object) -> None:
    """One line on stderr, at once."""
    print(text, file=sys.stderr, flush=True)


def tell_json(value: object) -> None:
    """One JSON document on stdout; finite numbers alone, null for what is not there."""
    print(json.dumps(value, indent=2, allow_nan=False))


def tell(*sentences: str, indent: str = "") -> None:
    """Sentences on stdout, in lines of a terminal."""
    for one in sentences:
        print(textwrap.fill(one, WIDE, subsequent_indent=indent))


def written(paths: Iterable[object], dry: bool) -> None:
    """Print the files of a run; after a dry run, say that none is there."""
    for path in paths:
        print(path)
    if dry:
        say("dry run: nothing was written")


# -- what options mean -----------------------------------------------------------------


def file(text: str) -> Path:
    """The path of a file; an empty one is of a variable that was never set."""
    if not text or text.endswith(os.sep):
        raise ArgumentTypeError(f"name a file, not {text!r}")
    return Path(text)


def folder(text: str) -> Path:
    """The path of a folder; an empty one is not the current folder."""
    if not text:
        raise ArgumentTypeError("give a folder; '.' is the current one")
    return Path(text)


def stream(text: str) -> Path | str:
    """The path of a file, or `STREAM` as it is."""
    return text if text == STREAM else file(text)


def number(text: str) -> float:
    """A number in ASCII; float() takes 1_0 and foreign digits as well."""
    if "_" in text or not text.isascii():
        raise ValueError
    return float(text)


def numbers(text: str) -> list[float]:
    return [number(one) for one in text.split(",")]


def whole_numbers(text: str) -> list[int]:
    return [int(one) for one in text.split(",")]


def rows(text: str) -> int:
    if not (text.isascii() and text.isdigit()):
        raise ArgumentTypeError(f"give a number of rows, 0 or more, not {text!r}")
    return int(text)


def seconds(text: str) -> float:
    with contextlib.suppress(ValueError):
        if 0 < number(text) < math.inf:
            return number(text)
    raise ArgumentTypeError(f"give seconds above 0, not {text!r}")


def combinations(text: str) -> dict[str, list[float]] | list[list[float]] | list[str]:
    """Rows of numbers, rows by name, or names, with semicolons between.

    Examples
    --------
    >>> combinations("a (Nm)=1,0; b=0,1")
    {'a (Nm)': [1.0, 0.0], 'b': [0.0, 1.0]}
    >>> combinations("1,0;0,1"), combinations("speed (rad/s)")
    ([[1.0, 0.0], [0.0, 1.0]], ['speed (rad/s)'])
    """
    parts = [part.strip() for part in text.split(";") if part.strip()]
    pairs = [part.rpartition("=") for part in parts]
    named = {name.strip(): row for name, equals, row in pairs if equals}
    if not parts or named and len(named) < len(parts):  # some, or one twice
        raise ValueError
    if named:
        return {name: numbers(row) for name, row in named.items()}
    try:
        return [numbers(part) for part in parts]
    except ValueError:
        if all(any(map(str.isalpha, part)) for part in parts):
            return parts
        raise


def limits(text: str) -> dict[str, float]:
    """A budget, as it is written behind --budget.

    >>> limits("multiply_adds=30,states=2")
    {'multiply_adds': 30, 'states': 2}
    """
    from .comparison import Budget

    found: dict[str, float] = {}
    for part in text.split(","):
        name, _, most = part.partition("=")
        try:
            value = number(most)
        except ValueError:
            raise ArgumentTypeError(
                f"write NAME=NUMBER, as multiply_adds=30,states=2; not {part!r}"
            ) from None
        if name.strip() in found:
            raise ArgumentTypeError(f"{name.strip()} is there twice")
        found[name.strip()] = int(value) if value.is_integer() else value
    try:
        Budget.read(found)
    except ValueError as error:
        raise ArgumentTypeError(str(error)) from None
    return found


def known_input(text: str) -> Any:
    """Levels, or the path of a file; see `with_input`."""
    if text.endswith(".json"):
        return Path(text)
    try:
        levels = numbers(text)
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
    from .formats.json_records import json_file, require_plain
    from .plant import Plant

    if given is None or not isinstance(given, Path):
        return plant if given is None else plant.with_input(given)
    read = json_file(given, "a plant, or what is known of a known input,")
    if "U" not in read.data or "A" in read.data:
        model = Plant.from_json(read)
        late = model.dt == 0 < plant.dt
        return plant.with_input(model.sampled(plant.dt) if late else model)
    if more := set(read.data) - {"U", "description"}:
        raise ValueError(f"{given}: beside 'U' there is {sorted(more)[0]!r}")
    require_plain(f"{given}: U", read.data["U"])
    return plant.with_input(read.data["U"])


def uncertain(text: str) -> tuple[str, Any]:
    """An entry and its range, which the library checks."""
    name, _, value = text.partition("=")
    if not name or not value:
        raise ArgumentTypeError(f'give "A[1,1]=30%" or "A[1,1]=0.5:0.9", not {text!r}')
    if value.rstrip().endswith("%"):
        return name.strip(), value
    low, _, high = value.partition(":")
    try:
        return name.strip(), (number(low), number(high))
    except ValueError:
        raise ArgumentTypeError(
            f'give "{name}=0.5:0.9" or "{name}=30%", not {text!r}'
        ) from None


def entry(text: str) -> tuple[str, float]:
    """An unknown entry, and where the search for it starts."""
    name, _, start = text.partition("=")
    try:
        return name.strip(), float(start)
    except ValueError:
        raise ArgumentTypeError(f"give ENTRY=START, not {text!r}") from None


def pair(text: str) -> tuple[str, str]:
    """An output and a column."""
    output, _, column = text.partition("=")
    if not (output and column):
        raise ArgumentTypeError(f"give OUTPUT=COLUMN, not {text!r}")
    return output, column


def plant_of(source: Any, options: Namespace) -> "Plant":
    """The plant of a JSON file, sampled if the options say so."""
    from .plant import Plant

    found = Plant.from_json(source)
    return found if options.sample is None else found.sampled(options.sample)


def require_other(path: Path | str, *read: Path | str | None) -> None:
    """Raise ValueError unless `path` can be written and is none of the files read."""
    from .formats.writing import require_file

    if path == STREAM or not require_file(path).exists():
        return
    for other in read:
        if other not in (None, STREAM) and os.path.exists(other):
            if os.path.samefile(other, path):
                raise ValueError(f"{path} would replace {other}, which is read")


PLANT = option("plant", type=file, metavar="PLANT.json")
DATA = option("data", type=stream, metavar="DATA.csv", help="a record; - reads stdin")
ESTIMATED = option(
    "--out",
    type=stream,
    required=True,
    metavar="FILE.csv",
    help="estimates; - writes to stdout, where rows before a refusal remain",
)
SAMPLE = option(
    "--sample",
    type=seconds,
    metavar="DT",
    help="sample a continuous plant every DT seconds, with inputs held between",
)
JSON = option("--json", action="store_true", help="one JSON document on stdout instead")
DRY = option(
    "--dry-run",
    action="store_true",
    help="check everything, write nothing, and print which files would be written",
)
K = option(
    "--k",
    type=combinations,
    metavar="K1,K2,...",
    help="estimate only this combination k x of the states, or several with "
    "semicolons between, named or not: --k 'torque (Nm)=0,120,0; drift=1,0,0'; "
    "write --k=-1,2 where the first number is negative. A name alone is that of a "
    'state or of the plant\'s "estimates", which are the default',
)
U = option(
    "--U",
    type=known_input,
    metavar="U1,U2,...|FILE.json",
    help="what is known of the known input, which errors then count: a level for "
    "each input, constant for ever from before the start (an input that switches "
    "is not that), 0 for inputs that are always zero, or a file with a plant whose "
    'outputs they are (modes on the unit circle are tones), or {"U": [[144]]}, the '
    "covariance of white inputs",
)
BUDGET = option(
    "--budget",
    type=limits,
    metavar="NAME=MOST,...",
    help="recommend the most accurate design within these limits: multiply_adds "
    "of a step, states, bytes of state and constants; any of them",
)
DTYPE = option(
    "--dtype",
    choices=["double", "float"],
    default="double",
    help="numbers of the device (double)",
)
ORDERS = option(
    "--orders", type=whole_numbers, metavar="R1,R2,...", help="only these orders"
)


# -- plants and designs ----------------------------------------------------------------


@command(PLANT, SAMPLE, JSON)
def check(options: Namespace) -> None:
    """Validate a plant's file, and say what the plant means.

    Prints what each output reads, the noise of each signal in its unit, modes, time
    constants in seconds, observability indices, modes that no output shows, the
    structure of the noise, whether there is a steady filter, and what looks like a
    mistake. A file that is not a plant is refused; a plant that no observer can be had
    for is not. Writes nothing.

    check tracker.json
    check reactor.json --json
    """
    from .check import examine, lines

    found = examine(plant_of(options.plant, options))
    if options.json:
        return tell_json(found)
    for head, text in lines(found):
        text = text.replace("plant.sampled(0.1)", "--sample 0.1")
        filled = textwrap.fill(
            f"{head:<15}{text}",
            WIDE,
            subsequent_indent=" " * 15,
            break_on_hyphens=False,
        )
        print(filled)


@command(
    PLANT,
    K,
    option(
        "--scale",
        type=numbers,
        metavar="S1,S2,...",
        help="typical sizes of the states, or of the rows of k x: errors of equal "
        "importance; by default each state is judged beside its own Kalman error",
    ),
    U,
    ORDERS,
    option(
        "--plants",
        type=file,
        nargs="+",
        default=[],
        metavar="OTHER.json",
        help="plants that there may be, beside PLANT.json",
    ),
    option(
        "--ranges",
        type=uncertain,
        nargs="+",
        default=[],
        metavar="ENTRY=RANGE",
        help='entries of the plant, counted from 0: "A[1,1]=30%%" to either side of '
        'the nominal one, or "A[1,1]=-0.65:-0.35" from the least to the greatest; a '
        "continuous plant is varied before it is sampled",
    ),
    option(
        "--samples",
        type=int,
        default=100,
        metavar="N",
        help="how many plants are drawn from the ranges (100)",
    ),
    option("--seed", type=int, default=0, metavar="N", help="of what is drawn (0)"),
    option(
        "--observers",
        type=file,
        nargs="+",
        default=[],
        metavar="OBSERVER.json",
        help="compare these, and not designs by every method",
    ),
    BUDGET,
    DTYPE,
    SAMPLE,
    JSON,
    option("--csv", type=file, metavar="FILE", help="write every design to a file"),
    DRY,
)
def compare(options: Namespace) -> None:
    """Compare what every method makes of a plant.

    Designs observers of a plant by every method and order, or takes observers from
    files, and prints the error, the worst pole, the work of each, the one recommended
    and why, and which methods do not apply. With --ranges or --plants each is judged
    on every plant that there may be, beside the Kalman filter that knows this plant,
    and its error is that on the worst of them.

    compare tracker.json
    compare tracker.json --k=1,0.5,0 --orders 1,2 --json
    compare tracker.json --k 'climb (m/s)=0,1,0; change (m/s^2)=0,0,1'
    compare tracker.json --csv designs.csv
    compare ball-and-beam.json --sample 0.1 --U 0
    compare tracker.json --budget multiply_adds=12,bytes=60 --dtype float
    compare tracker.json --ranges "A[2,2]=0.9:1" --samples 10 --json
    compare tracker.json --plants tracker.json --observers report/observer.json
    """
    from .comparison import compare
    from .formats import writing
    from .report import designs_csv

    if options.json and options.csv is not None:
        options.wrong("--csv goes without --json")
    if options.csv is not None:
        require_other(options.csv, options.plant)
    plant = with_input(plant_of(options.plant, options), options.U)
    scale = options.scale[0] if len(options.scale or ()) == 1 else options.scale
    designs, plants = _designs(options, plant), _plants(options)
    given = dict(plants=plants, L=options.k, scale=scale) | _within(options)
    found = compare(plant, designs, **given)
    if options.json:
        rows = None if found.rows is None else found.rows.tolist()
        data = {"plant": plant.name, "k": rows} | _chosen(found)
        cases = {} if plants is None else {"cases": found.to_cases()}
        return tell_json(data | {"designs": found.to_rows()} | cases)
    if options.csv is not None:
        if not options.dry_run:
            writing.write(options.csv, designs_csv(found.to_rows()))
        return written([options.csv], options.dry_run)
    _show(found.table, found.table.header.index("order"))
    for method, which, reason in found.refusals.rows:
        tell("", f"{method}, {which}: {reason}", indent="  ")
    tell("", *(() if found.chosen is None else [f"Take the {found.chosen.name}."]))
    tell(*found.reasons())


def _within(options: Namespace) -> dict[str, Any]:
    """What a device has to spare, and what it computes in."""
    return {"budget": (options.budget or {}) | {"dtype": options.dtype}}


def _designs(options: Namespace, plant: Any) -> Any:
    """The designs that are asked for; None for the default."""
    from .comparison import candidates
    from .observer import Observer

    if options.observers:
        return {str(one): Observer.from_json(one) for one in options.observers}
    return options.orders and candidates(plant, orders=options.orders)


def _plants(options: Namespace) -> dict[str, Any] | None:
    """The plants that there may be, beside the one that designs are for."""
    from .comparison import vary
    from .plant import Plant

    ranges = dict(options.ranges)
    if len(ranges) < len(options.ranges):
        options.wrong("--ranges name one entry twice")
    found = {str(one): Plant.from_json(one) for one in options.plants}
    if ranges:
        nominal = Plant.from_json(options.plant)
        found |= vary(nominal, ranges, options.samples, options.seed)
    return found or None


def _chosen(found: Any) -> dict[str, Any]:
    return {
        "estimates": list(found.estimates),
        "recommended": None if found.chosen is None else found.chosen.name,
        "reasons": found.reasons(),
    }


def _show(table: Any, names: int) -> None:
    """A table, its numbers first, as long names may leave the terminal.

    A star marks what is recommended; `names` columns go to the end.
    """
    from .show import Table

    def turned(cells: list[str], mark: str) -> list[str]:
        return [mark, *cells[names:], *cells[:names]]

    marks = ("*" if k in table.marked else "" for k in range(len(table.rows)))
    print(Table(turned(table.header, ""), map(turned, table.rows, marks)))


@command(
    PLANT,
    option("--out", type=folder, required=True, metavar="DIR", help="for the results"),
    option(
        "--data",
        type=file,
        metavar="DATA.csv",
        help="measurements, in columns named after the plant's outputs and inputs",
    ),
    BUDGET,
    DTYPE,
    K,
    U,
    SAMPLE,
    DRY,
)
def design(options: Namespace) -> None:
    """Design observers of every order for a plant, and write a report.

    Designs observers of every order, compares them, and writes a report, the
    recommended observer and, with measurements, estimates. Noise that the plant does
    not give is fitted to the measurements. Without noise covariances nothing is
    recommended, and the report says how to get them. Prints what it wrote.

    design tracker.json --out report --data tracker.csv
    design reactor.json --out reactor --dry-run
    design tracker.json --out small --budget multiply_adds=12 --dry-run
    design tracker.json --k 'climb (m/s)=0,1,0' --out climb --dry-run
    design ball-and-beam.json --sample 0.1 --U 0 --out ball --dry-run
    """
    from . import report
    from .analysis.known_input import known_input as driven
    from .comparison import compare
    from .comparison.stated_input import require_stated
    from .formats.json_records import as_data, json_file, layout
    from .formats.writing import require_folder, write_all
    from .plant import Plant
    from .plant.estimates import asking
    from .run import measurements

    read, out, fit = json_file(options.plant, "a plant"), options.out, None
    given = Plant.from_json(read)
    plant, record = asking(plant_of(read, options), options.k), None
    if options.data is not None:
        record = measurements.read(options.data, plant)
        if plant.dt == 0:
            plant = _sampled_as(plant, record, options.data)
        fit = _fitted(plant, record)
    plant = with_input(plant if fit is None else fit.plant, options.U)
    if plant.U is not None:  # or its error, before anything is designed
        driven(plant)
        if record is not None:
            require_stated(plant, record.u)
    require_folder(out)
    taken = [name for name in report.FILES if (out / name).exists()]
    if taken and not (out / report.PAGE).exists():
        raise ValueError(
            f"{out} holds {', '.join(taken)} but no report, so these are not of an "
            "earlier run and would be overwritten; give --out another folder"
        )
    if options.dry_run:
        names = report.planned(plant, record)
        return written([out / name for name in names], dry=True)
    say("designing by every method and order")
    line = shlex.join(["luenberger", *options.line])
    texts = report.files(compare(plant, **_within(options)), record, fit, line)
    about = [plant.description] if plant.description else []
    if plant.dt != given.dt:
        about.append(f"Sampled every {plant.dt:g} s, with inputs held between.")
    if fit is not None:
        about.append(f"Noise fitted to {options.data.name} by maximum likelihood.")
    told = dataclasses.replace(plant, description=" ".join(about) or None)
    same = plant == given
    texts["plant.json"] = read.text if same else layout(as_data("plant", told))
    if options.data is not None:
        texts["data.csv"] = options.data.read_text(encoding="utf-8")
    names = report.in_order(texts)
    written(write_all(out, {name: texts[name] for name in names}), dry=False)
    for name in set(report.FILES) - set(names):  # of a run that recommended one
        (out / name).unlink(missing_ok=True)
    if "observer.json" not in texts:
        say("observer.json is not written: nothing is recommended, the report says why")
    say(f"done: open {out / report.PAGE}")


def _sampled_as(plant: "Plant", record: "Measurements", data: Path) -> "Plant":
    """A continuous plant, sampled as often as a record."""
    from .run.clock import periods

    if not record.stamps:
        raise ValueError(
            f"the plant is continuous, and {data} has no column of times; --sample DT "
            "says how many seconds its rows are apart"
        )
    steps = periods(record.time)
    if not len(steps) or not (steps == steps[0]).all():
        apart = f", {steps.min():g} to {steps.max():g} s apart" if len(steps) else ""
        raise ValueError(
            f"the plant is continuous, and the {len(record.time)} rows of {data} are "
            f"at no constant period{apart}; --sample DT gives the one to design for. "
            "`luenberger filter` filters at uneven instants"
        )
    say(f"sampled every {steps[0]:g} s, as {data} is")
    return plant.sampled(float(steps[0]))


def _fitted(plant: "Plant", record: "Measurements") -> "NoiseFit | None":
    """The noise that a plant does not give, where the record tells it."""
    from .errors import DesignError
    from .identification.fit import fit_missing, lacking

    if not lacking(plant) or plant.multiplicative or plant.is_complex:
        return None
    say(f"fitting {' and '.join(lacking(plant))} to the record")
    try:
        fit, said = fit_missing(plant, record.record)
    except DesignError as error:
        say(f"{' and '.join(lacking(plant))} cannot be fitted to the record: {error}")
        return None
    for sentence in (*said, *fit.unidentifiable, *fit.whiteness.sentences):
        say(sentence)
    return fit


# -- records ---------------------------------------------------------------------------

FORMS = ("full", "diagonal", "scaled", "known")
MEANING = "every entry, the diagonal, a factor of the plant's own, or nothing (known)"


@command(
    PLANT,
    option("data", type=file, metavar="DATA.csv"),
    option("--out", type=file, required=True, metavar="FITTED.json"),
    option("--q", choices=FORMS, help=f"what to find of Q: {MEANING}"),
    option(
        "--r",
        choices=FORMS,
        help="the same of R; default of both is to keep what the plant gives, and to "
        "find as much as a record can determine of what it does not",
    ),
    option(
        "--parameter",
        action="append",
        type=entry,
        default=[],
        metavar="ENTRY=START",
        help="an unknown entry such as B[1,0]=4, counted from 0; may be repeated",
    ),
    SAMPLE,
    JSON,
    DRY,
)
def fit(options: Namespace) -> None:
    """Fit the noise covariances of a plant to a record.

    Finds the most likely Q and R of a plant, and entries of A, B, C or E that are
    unknown, from measurements in columns named after its outputs and inputs; an empty
    cell was not measured. What no record can determine is refused, and named. Writes
    the plant with what was found.

    fit nile.json nile.csv --out nile-fitted.json
    fit ball-and-beam.json ball-and-beam.csv --sample 0.1 --q diagonal --out b.json
    """
    from .identification.fit import fit_missing, fit_noise, lacking
    from .run import measurements

    require_other(options.out, options.plant, options.data)
    plant = plant_of(options.plant, options)
    data = measurements.read(options.data, plant)
    forms, parameters = {"Q": options.q, "R": options.r}, dict(options.parameter)
    missing = lacking(plant)
    if any(forms.values()) or parameters:
        for name in forms:
            forms[name] = forms[name] or ("full" if name in missing else "known")
        found = {name: form for name, form in forms.items() if form != "known"}
        Q, R = found.get("Q"), found.get("R")
        fit = fit_noise(plant, data.record, Q=Q, R=R, parameters=parameters or None)
        words = [f"{name} ({form})" for name, form in found.items()] + [*parameters]
        listed = " and ".join([", ".join(words[:-1]), words[-1]][len(words) == 1 :])
        about = f"Fitted to {options.data.name} by maximum likelihood: {listed}."
        said = [about]
    elif missing:
        fit, said = fit_missing(plant, data.record)
    else:
        options.wrong(
            "the plant gives both Q and R; say with --q, --r or --parameter what is "
            "to be fitted"
        )
    sentences = [*said, *fit.unidentifiable, *fit.whiteness.sentences]
    about = " ".join([plant.description, *said] if plant.description else said)
    if not options.dry_run:
        dataclasses.replace(fit.plant, description=about).to_json(options.out)
    if options.json:
        white = fit.whiteness
        tell_json(
            {
                "Q": _plain(fit.plant.Q),
                "R": _plain(fit.plant.R),
                "parameters": fit.parameters,
                "standard_errors": _plain(fit.standard_errors),
                "log_likelihood": fit.log_likelihood,
                "whiteness": {
                    "statistic": white.statistic,
                    "dof": white.dof,
                    "p_value": white.p_value,
                    "variance": white.variance.tolist(),
                },
                "sentences": sentences,
            }
        )
    else:
        print("\n".join([*fit.lines, *sentences]))
    say(f"dry run: {options.out} was not written" if options.dry_run else "done")


def _plain(value: Any) -> Any:
    """Lists of numbers, None for those that are none."""
    if isinstance(value, dict):
        return {name: _plain(one) for name, one in value.items()}
    if isinstance(value, np.ndarray | list):
        return [_plain(one) for one in value]
    return float(value) if math.isfinite(value) else None


@command(
    PLANT,
    DATA,
    ESTIMATED,
    option("--lag", type=rows, metavar="N", help="smooth each row with N more rows"),
    option(
        "--smooth",
        action="store_true",
        help="smooth each row with all rows, earlier and later; the file is held whole",
    ),
    option(
        "--undriven",
        action="store_true",
        help="no known input acts: the file needs no columns of inputs",
    ),
    SAMPLE,
    option(
        "--arrival",
        type=pair,
        action="append",
        default=[],
        metavar="OUTPUT=COLUMN",
        help="readings of this output are known at the times in that column, numbers "
        "or dates like those in the column of times; never where its cell is empty; "
        "repeat it for other outputs",
    ),
)
def filter_(options: Namespace) -> None:
    """Filter a record of a plant: gaps, several rates, dates, any length.

    Filters a record in one pass, a few rows at a time: each row gives the states and
    their one sigma, from what was measured up to it. The file has a column for each
    output and input, by name, in any order and among others. An empty cell of an
    output was not measured, so sensors may have rates of their own and drop out. A
    column called time or t holds seconds or dates. A continuous plant is sampled at
    these instants, however uneven; those of a discrete one agree with its dt. With
    --lag N, each row waits for N more. With --arrival, a reading is used from the row
    on at which it is known.

    filter tracker.json tracker.csv --out filtered.csv
    filter tracker.json tracker.csv --lag 20 --out lagged.csv
    filter tracker.json tracker.csv --smooth --out -
    """
    from .run import tables

    late, whole = dict(options.arrival), options.smooth or options.lag is not None
    if late and whole:
        options.wrong("--arrival does not go with --lag or --smooth: late readings are "
                      "filtered")  # fmt: skip
    if options.smooth and options.lag is not None:
        options.wrong("give --lag or --smooth, one of them")
    plant = plant_of(options.plant, options)

    def read(table: "Table") -> Any:
        if whole:
            return tables.smoothed(plant, table, options.lag, options.undriven)
        return tables.filtered(plant, table, options.undriven, late)

    _run_over(options, options.plant, read)


@command(
    option("observer", type=file, metavar="OBSERVER.json"),
    DATA,
    ESTIMATED,
    option(
        "--plant",
        type=file,
        metavar="PLANT.json",
        help="the plant it observes: names the observer lacks, and x0 for the start",
    ),
    SAMPLE,
)
def estimate(options: Namespace) -> None:
    """Run a saved observer on measurements.

    Runs an observer on a CSV file of any length, a few rows at a time. The file has a
    column for each output and input, by name, in any order and among others, and
    perhaps one called time, t or instant: seconds, dates or numbers of samples, which
    agree with dt and are written as they are. A missing measurement is refused: gains
    that are fixed beforehand cannot leave it out; `luenberger filter` can, and
    smooths, and takes late readings.

    estimate report/observer.json tracker.csv --out estimates.csv
    estimate report/observer.json tracker.csv --plant tracker.json --out -
    """
    from .observer import Observer
    from .run import tables

    if options.sample is not None and options.plant is None:
        options.wrong("--sample goes with --plant")
    require_other(options.out, options.plant)
    observer = Observer.from_json(options.observer)
    known = None if options.plant is None else plant_of(options.plant, options)

    def read(table: "Table") -> Any:
        return tables.estimates(observer, table, known)

    _run_over(options, options.observer, read)


def _run_over(
    options: Namespace, model: Path, read: Callable[["Table"], tuple[Any, Any]]
) -> None:
    """Run `read` over the data; `model` is the file that says how."""
    from .errors import few
    from .formats.csv_table import Table
    from .run import tables

    require_other(options.out, model, options.data)
    with _source(options.data) as source, _sink(options.out) as out:
        where = "stdin" if options.data == STREAM else options.data
        header, found = read(Table(source, where))
        count = tables.write(out, header, found)
    if options.out != STREAM:
        print(options.out)
    say(f"{count} rows of {few(header)}")


@contextlib.contextmanager
def _source(path: Path | str) -> Iterator[Any]:
    if path == STREAM:
        yield sys.stdin.buffer
    else:
        with open(path, "rb") as source:
            yield source


@contextlib.contextmanager
def _sink(path: Path | str) -> Iterator[Any]:
    from .formats.writing import replacing

    if path == STREAM:
        if hasattr(sys.stdout, "reconfigure"):  # UTF-8, whatever the terminal has
            sys.stdout.reconfigure(encoding="utf-8", newline="")
        yield sys.stdout
    else:
        with replacing(path) as out:
            yield out


# -- devices, and the equations --------------------------------------------------------


@command(
    option("source", type=file, metavar="OBSERVER.json|PLANT.json"),
    option("--c", type=folder, required=True, metavar="DIR", help="for the two files"),
    option(
        "--plant",
        type=file,
        help="beside an observer: names for the comments, and what --measure runs on",
    ),
    option(
        "--m1",
        action="append",
        metavar="OUTPUT",
        help="beside a plant: the name of an output treated as exact, once for each; "
        "or how many of the first outputs; default none",
    ),
    option("--name", default="observer", help="of files and functions"),
    DTYPE,
    option(
        "--measure",
        action="store_true",
        help="beside an observer with --plant: compile the source, run it on a "
        "simulated record and say how far rounding moves the estimates",
    ),
    SAMPLE,
    DRY,
)
def export(options: Namespace) -> None:
    """Write an observer, or a plant's time-varying filter, as C99 source.

    Writes C99 source that allocates nothing: NAME.c and NAME.h. An observer becomes
    its recursion; a plant becomes the time-varying filter with its covariance, where
    NaN in y means not measured. Compiled with -DNAME_SELFTEST it is a program that
    ends with 0 if it computes what Python does. Prints the two paths.

    export report/observer.json --c firmware
    export tracker.json --m1 "radar position (m)" --c firmware --name filter
    export report/observer.json --c firmware --dtype float --dry-run
    export report/observer.json --c firmware --plant tracker.json --measure
    """
    from .export import rounding_error, to_c
    from .export.c.source_and_header import places
    from .formats.json_records import json_file, kind
    from .observer import Observer
    from .plant import Plant

    read = json_file(options.source, "a record")
    is_observer = kind(read) == "observer"
    if is_observer and options.sample is not None:
        options.wrong("--sample goes with a plant, not with an observer")
    source: Any = Observer.from_json(read) if is_observer else plant_of(read, options)
    plant = None if options.plant is None else Plant.from_json(options.plant)
    if options.measure and not (is_observer and plant):
        options.wrong("--measure goes with an observer, and --plant says of what plant")
    m1 = options.m1
    if m1 and len(m1) == 1 and m1[0].isdecimal():
        m1 = m1 if m1[0] in (source.output_names or ()) else int(m1[0])
    with tempfile.TemporaryDirectory() as nowhere:
        where = nowhere if options.dry_run else options.c
        paths = to_c(
            source=source, path=where, plant=plant, m1=m1, name=options.name,
            dtype=options.dtype,
        )  # fmt: skip
    if options.dry_run:
        paths = places(options.c, [path.name for path in paths])
    written(paths, options.dry_run)
    if options.measure and plant:
        for sentence in rounding_error(source, plant, dtype=options.dtype).sentences:
            say(sentence)


@command(
    option("--paper", metavar="NAME", help="one, by part of its name; or ours"),
    option("--misprints", action="store_true", help="list misprints, not equations"),
    option(
        "--prove",
        action="store_true",
        help="check every proof, and count by how equations are established: half a "
        "minute for all papers",
    ),
    JSON,
    option(
        "--html",
        type=file,
        metavar="FILE",
        help="write a page with every equation and its proved formulas, which runs "
        "the derivations: half a minute for all papers",
    ),
    option(
        "--coq",
        type=folder,
        metavar="DIR",
        help="write every proof as a lemma of Coq, in a file for each page; this runs "
        "the derivations, two minutes for all papers; compile them there with "
        "coq_makefile -f _CoqProject -o Makefile && make -j2",
    ),
    DRY,
)
def ledger(options: Namespace) -> None:
    """List the papers' equations, their evidence and their misprints.

    Lists every numbered equation of the papers: what defines it, what is proved of it
    and for which sizes, what uses it, and what is wrong with it in our scan or in the
    paper. The part `ours` has the theorems that are in no paper. Without --paper it
    prints counts.

    ledger
    ledger --paper "Van Dooren"
    ledger --misprints --json
    ledger --paper ours
    ledger --prove --paper moore
    ledger --paper hsia --html ledger.html
    ledger --paper moore --coq lemmas
    """
    from . import ledger
    from .formats.writing import require_file
    from .ledger import coq

    paper = None if options.paper is None else ledger.find_paper(options.paper)
    ways = {name: getattr(options, name) for name in ("prove", "html", "coq")}
    asked = [f"--{name}" for name, given in ways.items() if given]
    others = [f"--{one}" for one in ("json", "misprints") if getattr(options, one)]
    if asked and len(asked) + len(others) > 1:
        options.wrong(f"{asked[0]} goes without {' and '.join(asked[1:] + others)}")
    if options.prove:
        return _prove(ledger, paper)
    if options.coq:
        if not options.dry_run:
            say("running the derivations, for their proofs")
            print(coq.write(options.coq, paper))
        return written(coq.paths(options.coq, paper).values(), options.dry_run)
    if options.html:
        require_file(options.html)
        if not options.dry_run:
            say("running the derivations, for their formulas")
            ledger.write_page(options.html, paper)
        return written([options.html], options.dry_run)
    if options.misprints:
        found = ledger.misprints(paper)
        if options.json:
            slips = [
                {"paper": one.paper, "number": one.number}
                | {"kind": slip.kind, "printed": slip.printed, "correct": slip.correct}
                for one, slip in found
            ]
            return tell_json({"misprints": slips})
        for one, slip in found:
            _tell(f"{one.source} {one.number}")
            _tell(f"  {slip.where}: {slip.printed}", 4)
            _tell(f"  correct: {slip.correct}", 4)
    elif options.json:
        tell_json({"entries": [one.as_dict() for one in ledger.entries(paper)]})
    elif paper is None:
        print(ledger.summary())
    else:
        for one in ledger.entries(paper):
            used = one.used.removeprefix("luenberger.")
            _tell(f"{one.number:<4}  {one.level}; {used}")
            for row in one.says.lines():
                _tell(f"{' ' * 6}{row}", 8)


def _tell(text: str, indent: int = 6) -> None:
    """A formula is not broken within, and takes the lines that it needs."""
    whole: dict[str, Any] = dict(break_on_hyphens=False, break_long_words=False)
    filled = textwrap.fill(text, WIDE, subsequent_indent=" " * indent, **whole)
    print(filled.replace("\u00a0", " "))


def _prove(ledger: Any, paper: str | None) -> None:
    """Check the evidence of each entry, and say which is not proved."""
    failed = 0
    for one in ledger.entries(paper):
        faults = one.check()
        failed += bool(faults)
        for fault in faults:
            _tell(f"{one.source} {one.number}: not proved: {fault}")
    if failed:
        raise ValueError(f"{failed} of the entries are not proved")
    print(ledger.levels(paper))
