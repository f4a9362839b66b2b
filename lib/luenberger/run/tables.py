"""A CSV table of any length, through an observer, a filter or a smoother.

A few rows are held at a time, but for a smoother without a lag.
"""

from __future__ import annotations

import csv
from collections import Counter
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from functools import partial
from itertools import chain
from typing import TextIO

import numpy as np

from ..at_work import start
from ..certificate import require_match
from ..errors import DesignError, few, short
from ..filtering import back
from ..formats import csv_table, time_stamps
from ..formats.csv_table import Table
from ..numeric import Matrix, Vector
from ..numeric.validation import names
from ..observer import Observer
from ..plant import Plant
from .arrivals import known
from .clock import Column
from .estimate import estimated, require_finite, require_samples
from .filter import Filter
from .record import Rows
from .smoothed import over

TIME = ("time", "t", "instant")  # a first column of such a name holds instants
NEVER = ("", "nan", "nat")  # cells of readings that do not arrive
MICROSECOND = 1e-6  # the last digit of a date
Piece = tuple[Sequence[str], np.ndarray]  # times of some rows, the estimates at them
Read = tuple[csv_table.Rows, Rows]  # some rows of a table, and what they hold
Found = tuple[csv_table.Rows, Matrix, Matrix]  # estimates and deviations at them


def time_column(
    table: Table, outputs: Sequence[str], inputs: Sequence[str], others: bool = False
) -> str | None:
    """The name of a table's time column, or None.

    Blanks around a name do not count, in the plant as in the table.

    Raises
    ------
    ValueError
        Unless the outputs and the inputs are columns, and, but for `others`, there
        are no more.
    """
    where, header = table.where, table.header
    wanted = [name.strip() for name in (*outputs, *inputs)]
    if shared := _repeated(wanted):
        raise ValueError(
            f"{where}: {few(shared)} each name more than one output or input, so a "
            "column does not say which it is; rename one in the plant"
        )
    if twice := _repeated(header):
        raise ValueError(f"{where}: the columns {few(twice)} occur more than once")
    time = next((n for n in header if n.lower() in TIME and n not in wanted), None)
    lacking = [name for name in wanted if name not in header or name == time]
    known = header if others else (*wanted, time)
    foreign = [name for name in header if name not in known]
    if lacking and (marks := csv_table.separator(header)):
        raise ValueError(
            f"{where}: {marks} separate the columns, and commas should; numbers "
            "have a decimal point"
        )
    parts = [f"lacks the columns {few(lacking)}"] * bool(lacking)
    parts += [f"has the unknown columns {few(foreign)}"] * bool(foreign)
    if parts:
        raise ValueError(
            f"{where} {' and '.join(parts)}; outputs and inputs are {few(wanted)}"
        )
    return time


def _repeated(names: Iterable[str]) -> list[str]:
    return sorted(name for name, count in Counter(names).items() if count > 1)


def estimates(
    observer: Observer, table: Table, plant: Plant | None = None
) -> tuple[list[str], Iterator[Piece]]:
    """Run an observer over a table.

    Parameters
    ----------
    observer : Observer
    table : Table
        With a column for each of its outputs and inputs, among others; the names are
        the observer's own, or the plant's, or else y1, y2, ..., u1, u2, ...
    plant : Plant, optional
        Its mean x0, carried to the first sample, is where the estimates start.

    Returns
    -------
    header : list of str
        The time column of the table, or "instant", and the names of the estimates.
    rows : iterator of (list of str, (N, q) ndarray)
        Of some rows the times, if there are any, and the estimates.

    Raises
    ------
    ValueError
        Naming line and column, if a value is missing, an estimate overflows, or a
        time is none or contradicts dt.
    """
    require_samples(observer)
    x0 = None
    if plant is not None:
        require_match(observer, plant)
        for kind in ("state", "output", "input"):
            mine, theirs = (getattr(one, f"{kind}_names") for one in (observer, plant))
            if mine and mine != theirs:
                raise ValueError(
                    f"the observer's {kind}s are {few(mine)} and the plant's "
                    f"{few(theirs)}; give the plant that the observer was designed for"
                )
        observer = observer.named(plant)
        x0 = plant.x0 if observer.steps else plant.first_step()[0] @ plant.x0
    outputs = observer.output_names or names("y output", None, observer.D.shape[-1])
    inputs = observer.input_names or names("u input", None, observer.G.shape[-1])
    clock = time_column(table, outputs, inputs, others=True)
    header = _header(table, clock, observer.estimate_names)
    pieces = table.rows([*outputs, *inputs], outputs, clock)
    times = None if clock is None else Column(clock, observer)

    def rows() -> Iterator[Piece]:
        state = 0, start(observer, x0=x0)
        for piece in pieces:
            at = partial(_line, table, piece)
            if times is not None:
                times.steps(times.seconds(piece.carried, at), at)
            y, u = np.split(piece.values, [len(outputs)], axis=1)
            for k, j in np.argwhere(np.isnan(y))[:1]:
                raise ValueError(
                    f"{at(k)}: {short(outputs[j])} was not measured, and an observer "
                    "whose gains are fixed beforehand cannot leave a measurement out. "
                    "`luenberger filter PLANT.json` can, and so does "
                    "lb.Filter(plant)"
                )
            state, x = estimated(observer, state, y, u)
            require_finite(x, observer.estimate_names, at)
            yield piece.carried, x

    return header, rows()


def _header(table: Table, clock: str | None, columns: Sequence[str]) -> list[str]:
    """The names of columns that are written."""
    header = [clock or "instant", *columns]
    for twice in _repeated(header)[:1]:
        raise ValueError(
            f"{table.where}: {short(twice)} would be the name of two columns; rename "
            "a state or the column of times"
        )
    return header


def _line(table: Table, rows: csv_table.Rows, k: int) -> str:
    return table.at(rows.lines[k])


def filtered(
    plant: Plant,
    table: Table,
    undriven: bool = False,
    arrival: Mapping[str, str] | None = None,
) -> tuple[list[str], Iterator[Piece]]:
    """Filter a table.

    Parameters
    ----------
    plant : Plant
        With Q and R, continuous or discrete.  Its names are those of the columns, among
        others; empty cells of outputs were not measured.  Times agree with dt, or say
        when a continuous plant is sampled.
    table : Table
    undriven : bool
        No known input acts, so no column of one is needed.
    arrival : dict of str to str, optional
        Of outputs that may be late, the column that says when a reading is known:
        numbers or dates like those in the column of times, or numbers of rows from 1
        on where there is none.  A reading whose cell is empty never arrives.

    Returns
    -------
    header : list of str
        The time column of the table, or "instant", then each state and its one sigma.
    rows : iterator of (list of str, (N, 2 n) ndarray)

    Raises
    ------
    ValueError
        Naming line and column, as `estimates`; and as `Filter.run`; if a reading
        arrives before it was measured, or the cell that says when is not of the kind
        of the times.
    """
    header, parts = _read(plant, table, undriven, arrival or {})

    def found() -> Iterator[Found]:
        run, end = Filter(plant), None
        for rows, part in parts:
            one = run.over(part, end)
            end = one.end
            yield rows, one.x, one.std

    return header, _told(plant, table, found())


def smoothed(
    plant: Plant, table: Table, lag: int | None = None, undriven: bool = False
) -> tuple[list[str], Iterator[Piece]]:
    """Smooth a table; `lag` as in `Filter.smooth`, and without one it is held whole.

    What is returned and raised is as in `filtered`.
    """
    header, parts = _read(plant, table, undriven, {})
    run = Filter(plant)
    found = _whole(run, parts) if lag is None else _lagged(run, parts, lag)
    return header, _told(plant, table, found)


def _whole(run: Filter, parts: Iterator[Read]) -> Iterator[Found]:
    """All parts together, and then of each part its rows."""
    rows, (first, *later) = zip(*parts)
    found, k = over(run, first.then(*later)), 0
    for one in rows:
        own = slice(k, k + len(one.lines))
        yield one, found.x[own], found.std[own]
        k = own.stop


def _lagged(run: Filter, parts: Iterator[Read], lag: int) -> Iterator[Found]:
    """Each part as soon as so many rows behind it are there."""
    held: list[Read] = []
    start = None
    for part in chain(parts, [None]):
        held += [] if part is None else [part]
        while held and (part is None or sum(len(one.y) for _, one in held[1:]) >= lag):
            (rows, first), *later = held
            own = slice(len(first.y))
            known = first.then(*(one for _, one in later)).part(slice(own.stop + lag))
            settings = next(run.parts(known, start.instant if start else 0))[1]
            passed = back.Passed.of([*run._windows(known, start, "all")], settings)
            found = back.smoothed(passed, lag, whole=False)
            std = np.sqrt(np.maximum(found.variances[own], 0.0))
            yield rows, found.z[own, : run.plant.n], std
            for window in run._windows(first, start, "all"):
                start = window.end
            held = later


def _told(plant: Plant, table: Table, found: Iterator[Found]) -> Iterator[Piece]:
    """Rows of a table with their estimates and one sigmas side by side."""
    with np.errstate(over="ignore", invalid="ignore"):
        for rows, x, std in found:
            require_finite(x, plant.state_names, partial(_line, table, rows))
            yield rows.carried, paired(x, std)


def paired(x: Matrix, std: Matrix) -> Matrix:
    """Each estimate and its one sigma, side by side."""
    return np.stack([x, std], axis=2).reshape(len(x), 2 * x.shape[1])


def with_sigmas(names: Sequence[str]) -> list[str]:
    """The columns of `paired`."""
    return [name + wide for name in names for wide in ("", "_sigma")]


def _read(
    plant: Plant, table: Table, undriven: bool, arrival: Mapping[str, str]
) -> tuple[list[str], Iterator[Read]]:
    """The header of estimates with their sigmas, and the rows of a plant's record."""
    outputs = plant.output_names
    if foreign := [name for name in arrival if name not in outputs]:
        raise ValueError(f"--arrival has {few(foreign)}; outputs are {few(outputs)}")
    if lacking := [name for name in arrival.values() if name not in table.header]:
        raise ValueError(f"{table.where} lacks the columns {few(lacking)} of arrivals")
    inputs = () if undriven else plant.input_names
    clock = time_column(table, outputs, inputs, others=True)
    if plant.dt == 0 and clock is None:
        raise DesignError(
            f"the plant is continuous, and {table.where} has no column 'time'; add it, "
            "or give --sample DT, how many seconds its rows are apart"
        )
    header = _header(table, clock, with_sigmas(plant.state_names))
    times = None if clock is None else Column(clock, plant)
    pieces = table.rows([*outputs, *inputs], outputs, clock, [*arrival.values()])

    def parts() -> Iterator[Read]:
        last, count = None, 0
        for rows in _two_first(pieces) if plant.dt == 0 else pieces:
            at, N = partial(_line, table, rows), len(rows.lines)
            y, u = np.split(rows.values, [plant.p], axis=1)
            u = u if u.shape[1] else np.zeros((N, plant.m))
            labels, steps = np.arange(count + 1.0, count + 1 + N), None
            if times is not None:
                labels = times.seconds(rows.carried, at)
                steps = times.steps(labels, at)
            own = Rows(y, u, np.zeros(plant.m), steps)
            if arrival:
                due, early = _due(plant, table, rows, labels, times, arrival)
                never = np.isnan(due)
                own = known(own, due, never, labels, last, MICROSECOND, early)
            yield rows, own
            last, count = labels[-1], count + N

    return header, parts()


def _two_first(pieces: Iterator[csv_table.Rows]) -> Iterator[csv_table.Rows]:
    """The same, but the first piece has two rows: no period leads to a single one."""
    first = next(pieces)
    while len(first.lines) < 2 and (more := next(pieces, None)) is not None:
        first = csv_table.Rows(
            [*first.lines, *more.lines],
            [*first.carried, *more.carried],
            np.concatenate([first.values, more.values]),
            [[*a, *b] for a, b in zip(first.texts, more.texts)],
        )
    yield from chain([first], pieces)


def _due(
    plant: Plant,
    table: Table,
    rows: csv_table.Rows,
    labels: Vector,
    times: Column | None,
    arrival: Mapping[str, str],
) -> tuple[Matrix, Callable[[int, int], str]]:
    """When readings are known, as the times of rows are told; NaN for never.

    Beside it what is to be said of a reading that arrives before its own row.
    """
    due = np.repeat(labels[:, None], plant.p, axis=1)
    origin, unit = (0, 1.0) if times is None else (times.origin, times.unit)
    cells_of = dict(zip(arrival, rows.texts))
    for output, cells in cells_of.items():
        given = [k for k, cell in enumerate(cells) if cell.lower() not in NEVER]
        try:
            seconds, own = time_stamps.seconds([cells[k] for k in given], origin)
            wrong, text = (0, cells[given[0]]) if own != origin else (-1, "")
        except time_stamps.NoStamp as error:
            wrong, text = error.row, str(error)
        if wrong >= 0:
            kind = f"a date, or lacks the zone of {origin}" if origin else "a number"
            raise ValueError(
                f"{_line(table, rows, given[wrong])}: {short(arrival[output])} is "
                f"{text!r}, which is not {kind}; when a reading is known is told as "
                "the times of the rows are"
            )
        j = plant.output_names.index(output)
        due[:, j] = np.nan
        due[given, j] = seconds * unit

    def early(k: int, j: int) -> str:
        output = plant.output_names[j]
        measured = rows.carried[k] if rows.carried else f"{labels[k]:g}"
        return (
            f"{_line(table, rows, k)}: {short(arrival[output])} is "
            f"{cells_of[output][k]}, before the reading was measured at {measured}. A "
            "reading arrives at its own row or later; leave the cell empty where it "
            "never does."
        )

    return due, early


def write(file: TextIO, header: Sequence[str], rows: Iterable[Piece]) -> int:
    """Write rows of estimates to an open file; returns how many."""
    csv.writer(file, lineterminator="\n").writerow(header)
    count = 0
    for told, x in rows:
        if not len(x):
            continue
        times = told or map(str, range(count + 1, count + len(x) + 1))
        numbers = repr(x.tolist())[2:-2].replace(", ", ",").split("],[")
        file.write("".join([f"{time},{row}\n" for time, row in zip(times, numbers)]))
        count += len(x)
    return count
