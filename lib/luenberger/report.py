"""The report of `luenberger design`: one page of HTML, made in this process.

`page` reads from top to bottom as the page does.  Each part is a few sentences, tables
and figures of one question; the page needs no network and fits a telephone.
"""

import csv
import html
import io
from collections.abc import Iterable, Iterator, Mapping, Sequence
from typing import Any

import numpy as np

from .check import examine, lines
from .comparison import KALMAN, Comparison, Design, noisy, percent
from .comparison.transients import transients
from .formats import json_records
from .identification.fit import NoiseFit
from .identification.whiteness import Whiteness, whiteness
from .numeric import Matrix, Vector
from .observer import Observer
from .plant import Plant
from .run import measurements
from .run.estimate import estimate
from .run.filter import Filter
from .run.measurements import Estimates, Measurements
from .run.record import Record
from .show import Picture, Prose, Table, counted, number, unit

PAGE = "report.html"
FILES = ("plant.json", "data.csv", "observer.json", "designs.csv", "estimates.csv")
RECOMMENDED = ("observer.json", "estimates.csv")  # only where one is recommended
LIMIT = 1.5  # times what is promised that predictions may miss by
LEAST = 20  # samples of which an autocorrelation says something
WIDE = 4.6  # inches of a figure, as wide as a telephone; others stand beside it
SHOWN = 400  # samples of a figure, which could not be told apart if there were more
Part = str | Prose | Table | Picture

STYLE = """
body { max-width: 54em; margin: 2em auto; padding: 0 1em; color: #1a1a1a;
       font: 16px/1.55 system-ui, "Segoe UI", "Helvetica Neue", Arial, sans-serif; }
h1 { font-size: 1.7em; line-height: 1.2; margin: 0 0 .6em; overflow-wrap: anywhere; }
h2 { font-size: 1.25em; margin: 2em 0 .4em; border-bottom: 1px solid #ccc; }
p, ul { margin: .6em 0; overflow-wrap: anywhere; }
.box { border: 2px solid #0072b2; border-radius: .4em; padding: .4em 1em; }
.box p { margin: .4em 0; }
.bad { border-color: #d55e00; }
.figures { display: flex; flex-wrap: wrap; gap: 1em; }
img { max-width: 100%; height: auto; }
table { border-collapse: collapse; margin: .8em 0; font-size: .88em; }
th { text-align: left; border-bottom: 2px solid #444; vertical-align: bottom; }
th, td { padding: .25em .55em; font-variant-numeric: tabular-nums; }
td { border-bottom: 1px solid #ddd; overflow-wrap: anywhere; }
.number { text-align: right; white-space: nowrap; }
.chosen { font-weight: bold; }
pre { font: 13px/1.4 ui-monospace, Menlo, Consolas, monospace; background: #f6f6f6;
      padding: .6em .8em; white-space: pre-wrap; overflow-wrap: anywhere; }
footer { color: #555; font-size: .88em; margin-top: 2em; border-top: 1px solid #ccc; }
@media (max-width: 45em) { /* a row of a wide table is a card */
  .wide thead { display: none; }
  .wide, .wide tbody, .wide tr, .wide td { display: block; }
  .wide tr { border-bottom: 1px solid #444; padding: .4em 0; }
  .wide td { border: 0; padding: .1em 0; text-align: left; }
  .wide td:empty { display: none; }
  .wide td::before { content: attr(data-label) ": "; color: #555; }
}
@media print { body { max-width: none; margin: 0; } img { break-inside: avoid; } }
"""
# the policy makes the browser hold the page to it: no scripts, no network
HEAD = """<!DOCTYPE html>
<html lang="en">
<head>
<meta charset="utf-8">
<meta http-equiv="Content-Security-Policy" content="default-src 'none'; \
style-src 'unsafe-inline'; img-src data:">
<meta name="viewport" content="width=device-width, initial-scale=1">
<title>{title}</title>
<style>{style}</style>
</head>
<body>
<main>
{body}
</main>
</body>
</html>
"""


def files(
    table: Comparison,
    record: Measurements | None = None,
    fit: NoiseFit | None = None,
    command: str = "",
) -> dict[str, str]:
    """The files of a report by name, but for those that were read.

    Parameters
    ----------
    table : Comparison
    record : Measurements, optional
        What the recommended observer is run and judged on.
    fit : NoiseFit, optional
        Where Q or R of the plant were fitted to this record.
    command : str
        The line that made it, to be read at the end.
    """
    chosen, found = table.chosen, None
    texts = {"designs.csv": designs_csv(table.to_rows())}
    if chosen is not None and chosen.observer is not None:
        data = json_records.as_data("observer", chosen.observer)
        texts["observer.json"] = json_records.layout(data)
        if record is not None:
            observer, plant = chosen.observer, table.plant
            found = measurements.apply(observer, chosen.accurate, plant, record)
            out = io.StringIO()
            measurements.write(out, found)
            texts["estimates.csv"] = out.getvalue()
    return texts | {PAGE: page(table, record, found, fit, command)}


def planned(plant: Plant, record: Measurements | None) -> list[str]:
    """The files of a run: without noise no observer is recommended, nor run."""
    left_out = set() if record is not None else {"data.csv", "estimates.csv"}
    left_out |= set() if noisy(plant) else set(RECOMMENDED)
    return in_order({*FILES, PAGE} - left_out)


def in_order(names: Iterable[str]) -> list[str]:
    """File names by letter, the report last."""
    return sorted(names, key=lambda name: (name == PAGE, name))


def designs_csv(rows: Sequence[Mapping[str, Any]]) -> str:
    """The rows of a comparison, a line each.

    Lists have spaces between, names semicolons; what does not apply is empty.
    """
    out = io.StringIO()
    writer = csv.writer(out, lineterminator="\n")
    writer.writerow(rows[0])
    writer.writerows(map(_cell, row.values()) for row in rows)
    return out.getvalue()


def _cell(value: Any) -> Any:
    if isinstance(value, bool):
        return "yes" if value else "no"
    if isinstance(value, list):
        between = "; " if all(isinstance(one, str) for one in value) else " "
        return between.join(map(str, value))
    return value  # None is an empty cell


# -- the page --------------------------------------------------------------------------


def page(
    table: Comparison,
    record: Measurements | None = None,
    found: Estimates | None = None,
    fit: NoiseFit | None = None,
    command: str = "",
) -> str:
    """The report as text; parameters are those of `files`."""
    import matplotlib

    with matplotlib.rc_context({"font.size": 9.0}):
        body = list(_parts(table, record, found, fit, command))
    title = html.escape(f"{table.plant.name or 'Plant'}: observer design")
    return HEAD.format(title=title, style=STYLE, body="\n".join(map(_html, body)))


def _parts(
    table: Comparison,
    record: Measurements | None,
    found: Estimates | None,
    fit: NoiseFit | None,
    command: str,
) -> Iterator[Part]:
    plant, chosen = table.plant, table.chosen
    tests = _tests(plant, record, fit)
    yield Prose(heading=plant.name or "Unnamed plant")
    yield from _box(table, record, tests, fit)
    yield from ([Prose(plant.description)] if plant.description else [])

    yield _section("Recommendation")
    yield Prose(*table.reasons())
    yield from _errors(table)

    yield _section("Does the record agree with the model?")
    yield Prose(*_agreement(table, record, tests))
    if tests is not None:
        yield from _drawn(_innovations, [(tests, plant)])

    yield _section("Estimates from the record")
    yield Prose(_about(record, found))
    if found is not None and record is not None and chosen is not None:
        each = range(len(found.names))
        yield from _drawn(_estimate, [(found, record, chosen, plant, k) for k in each])

    yield _section("The plant")
    yield Table(["", ""], lines(examine(plant)))
    if fit is not None:
        yield Prose("Fitted to this record, by maximum likelihood:")
        yield _fitted(fit)

    yield _section("Every design")
    yield Prose(
        "The error is one sigma in steady state; above the best, of the worst state or "
        "of the mean. The settling time is that of a wrong start, to 1 %. "
        "Multiply-adds of a step and bytes of state and constants are counted in the C "
        "source that `luenberger export` writes."
    )
    yield table.table
    yield table.refusals if table.refused else Prose("None was refused.")
    if table.pareto():
        yield from _drawn(_front, [(table,)])

    yield _section("From the start to the steady state")
    curves, remarks = transients(table)
    yield Prose(*remarks, *_start(curves))
    if curves:
        names = tuple(table.estimates)
        yield from _drawn(_variance, [(curves, plant, names, one) for one in names])

    yield _section("The observer")
    if chosen is None or chosen.observer is None:
        yield Prose("No observer is recommended, and observer.json is not written.")
    else:
        yield _equations()
        yield from _matrices(chosen.observer, plant)
        yield from _drawn(_poles, [(chosen.observer, plant)])

    yield _section("The same in Python")
    yield _python(table, record)
    yield _footer(command)


def _box(
    table: Comparison,
    record: Measurements | None,
    tests: Whiteness | None,
    fit: NoiseFit | None,
) -> Iterator[Part]:
    """What to take, how good it is, whether the record agrees, and what comes next."""
    chosen, best = table.chosen, table.yardstick
    told: list[str] = []
    holds = tests is None or (tests.white and tests.sized)
    if chosen is None:
        told.append("No observer is recommended; the reasons are below.")
    else:
        told.append(f"Recommended: {chosen.title}.")
        own, least = chosen.sigma, None if best is None else best.sigma
        if best is not None and own is not None and least is not None:
            each = zip(table.estimates, own, least)
            told.append(
                "One sigma in steady state, if the model holds: "
                + "; ".join(
                    f"{_plain(name)} {_sized(a, name)}"
                    + ("" if best is chosen else f" ({best.method} {_sized(b, name)})")
                    for name, a, b in each
                )
                + "."
            )
    if record is None:
        told.append("The model was not tested: --data DATA.csv gives a record.")
    elif tests is None:
        told.append("The record does not test the model; the reason is below.")
    elif holds:
        told.append(f"The record agrees with the model (p = {tests.p_value:.2g}).")
    else:
        told.append(
            f"The record does not agree with the model (p = {tests.p_value:.2g}): take "
            "no bound on this page as more than a guess."
        )
    worse = list(_recommended(table, record))[1:]
    told += worse
    note = ""
    if chosen is None:
        step = "luenberger fit plant.json DATA.csv --out fitted.json"
    elif not holds and fit is None:
        step = "luenberger fit plant.json data.csv --q diagonal --r diagonal "
        step += "--out fitted.json"
    elif not holds:  # no other noise helps
        step = "luenberger fit plant.json data.csv --parameter ENTRY=START "
        step += "--out fitted.json"
        note = ", an entry of A, B, C or E that is not sure and where to look for it"
    elif worse:
        step = "luenberger export plant.json --c firmware"
    else:
        step = "luenberger export observer.json --plant plant.json --c firmware"
    inner = "".join(f"<p>{html.escape(one)}</p>" for one in told)
    bad = "" if holds and not worse and chosen is not None else " bad"
    yield (
        f'<div class="box{bad}">{inner}<p>Next: <code>{html.escape(step)}</code>{note}.'
        "</p></div>"
    )


def _errors(table: Comparison) -> Iterator[Part]:
    """One-sigma steady error of each estimate, recommended design against the best."""
    chosen, best = table.chosen, table.yardstick
    if chosen is None or best is None or best is chosen:
        return  # as the reasons say
    assert best.sigma is not None and chosen.sigma is not None  # their errors are known
    rows = [
        [name, number(a, 4), number(b, 4), percent(b / a - 1 if a > 0 else 0.0)]
        for name, a, b in zip(table.estimates, best.sigma, chosen.sigma)
    ]
    yield Table(["one sigma of", best.method, "recommended", "more"], rows)


def _tests(
    plant: Plant, record: Measurements | None, fit: NoiseFit | None
) -> Whiteness | None:
    """The tests of a record's innovations; None without noises or without a record.

    A fit has tested them, and counts what it fitted.
    """
    if fit is not None:
        return fit.whiteness
    if record is None or plant.Q is None or plant.R is None or not plant.dt:
        return None
    if plant.multiplicative or len(record.y) - record.missing / plant.p < LEAST:
        return None
    try:
        rows = Record(record.y, record.u if plant.m else None, "rows")
        return whiteness(Filter(plant).innovations(rows))
    except ValueError:  # the record contradicts the plant, or does not tell the state
        return None


def _agreement(
    table: Comparison, record: Measurements | None, tests: Whiteness | None
) -> Iterator[str]:
    """What the tests say of the model, and the record of the recommended observer."""
    if tests is None:
        yield (
            f"Nothing was tested: this needs Q, R and {LEAST} samples that the plant "
            "can produce."
        )
        return
    good = tests.white and tests.sized
    yield (
        "An innovation is a measurement minus its prediction, here divided by the "
        "standard deviation that the plant with Q and R promises. If the model is "
        "right, innovations are white: of variance 1, and uncorrelated from sample to "
        "sample."
    )
    yield from tests.sentences
    yield (
        f"The record {'agrees' if good else 'does not agree'} with the model, as the "
        "innovations of its Kalman filter tell; no other observer is tested by that."
        + ("" if good else " One-sigma bounds are only as good as these are.")
    )
    yield from _recommended(table, record)


def _recommended(table: Comparison, record: Measurements | None) -> Iterator[str]:
    """How the recommended observer predicts the record, beside the Kalman filter."""
    if record is None or record.missing:
        return
    chosen, kalman, plant = table.chosen, table.yardstick, table.plant
    if chosen is None or kalman is None:
        return
    if kalman is chosen or kalman.method != KALMAN:
        return
    if table.rows is not None or chosen.observer is None:
        return
    settled = max(chosen.settling, kalman.settling) / plant.dt
    first = int(min(np.ceil(settled), len(record.y) // 2))
    pair = (one.observer for one in (chosen, kalman) if one.observer is not None)
    both = (_missed(one, plant, record)[first:] for one in pair)
    own, least = (np.sqrt((x**2).mean(axis=0)) for x in both)
    promised = np.sqrt(_promised(chosen, plant))
    each = (
        f"{name} by {number(a, 4)} instead of {number(b, 4)} (promised {number(c, 4)})"
        for name, a, b, c in zip(plant.output_names, own, least, promised)
    )
    yield (
        "One sample ahead, the recommended observer misses, as a root mean square from "
        f"sample {first + 2} on and beside the Kalman filter, {'; '.join(each)}."
    )
    if (own > LIMIT * np.maximum(promised, least)).any():
        yield (
            "The recommended observer is worse on this record than its errors promise: "
            "do not take it, nor the bounds of its estimates, for this input."
        )


def _missed(observer: Observer, plant: Plant, record: Measurements) -> Matrix:
    """Readings from the second on, less what the estimates before predict of them."""
    x = estimate(observer, record.record, x0=plant.at_first_sample().x0)
    ahead = x[:-1] @ plant.A.T + record.u[:-1] @ plant.B.T
    missed: Matrix = record.y[1:] - ahead @ plant.C.T - record.u[1:] @ plant.E.T
    return missed


def _promised(one: Design, plant: Plant) -> Vector:
    """Variances of that, as the steady error of a design says."""
    Q, R, _ = plant.at(0).covariances()
    A, C = plant.A, plant.C
    found: Vector = (C @ (A @ one.covariance @ A.T + Q) @ C.T + R).diagonal()
    return found


def _about(record: Measurements | None, found: Estimates | None) -> str:
    """How many measurements there were and what was done with them."""
    if record is None:
        return "No measurements were given."
    none = "No estimates, as no observer is recommended."
    return f"{counted(len(record.y), 'sample')}. {found.how if found else none}"


def _fitted(fit: NoiseFit) -> Table:
    """Each number that was fitted, with its standard error."""
    rows = []
    for letter in "QR":
        X, errors = getattr(fit.plant, letter), fit.standard_errors[letter]
        for i, j in zip(*np.triu_indices(len(X))):
            if errors[i, j] != 0:
                sure = number(errors[i, j], 2)
                sure = {"inf": "not determined", "nan": "at its bound"}.get(sure, sure)
                rows.append([f"{letter}[{i},{j}]", number(X[i, j], 4), sure])
    return Table(["entry", "value", "standard error"], rows)


def _start(curves: Mapping[str, Matrix]) -> Iterator[str]:
    """Where a constant gain pays at the start for what it saves for ever."""
    if not curves:
        return
    yield (
        "Error variance of each estimate against time, from P0 on. A constant gain "
        "forgets a wrong start more slowly than gains of each instant."
    )
    by_variance = [np.diagonal(one, axis1=1, axis2=2) for one in curves.values()]
    first, last = by_variance[0], by_variance[-1]
    ratio = np.divide(last, first, where=first > 0, out=np.ones_like(first))
    worst = float(np.sqrt(ratio.max(initial=1.0)))
    if worst > 2:
        yield (
            f"On the way its one sigma is up to {number(worst, 2)} times that of the "
            "Kalman filter. Where the start counts, `luenberger export plant.json` "
            "writes the filter with gains of each instant."
        )


def _equations() -> str:
    return (
        "<p>It runs as z<sub>i+1</sub> = F z<sub>i</sub> + G u<sub>i</sub> + D "
        "y<sub>i</sub> and estimates P z<sub>i</sub> + V y<sub>i</sub> + W "
        "u<sub>i</sub>. Matrices that are zero are left out; all are in "
        "observer.json.</p>"
    )


def _matrices(o: Observer, plant: Plant) -> Iterator[Table]:
    """The observer's matrices, each a table with names; zero ones are left out."""
    z, w = [f"z{k + 1}" for k in range(o.order)], o.estimate_names
    sides = dict(
        F=(z, z, "next z from z"),
        G=(z, plant.input_names, "next z from u"),
        D=(z, plant.output_names, "next z from y"),
        P=(w, z, "estimate from z"),
        V=(w, plant.output_names, "estimate from y"),
        W=(w, plant.input_names, "estimate from u"),
    )
    for name, (rows, columns, meaning) in sides.items():
        X = getattr(o, name)
        if X.size and X.any():
            scale = np.abs(X).max()
            cells = [[number(entry, 5, scale) for entry in row] for row in X]
            named = [[row, *line] for row, line in zip(rows, cells)]
            yield Table([f"{name}: {meaning}", *columns], named)


def _python(table: Comparison, record: Measurements | None) -> str:
    """The lines that go on from here."""
    lines = ["import luenberger as lb", 'plant = lb.Plant.from_json("plant.json")']
    lines.append("table = lb.compare(plant)  # every method and order")
    if table.chosen is not None:
        lines += [
            'observer = lb.Observer.from_json("observer.json")',
            "lb.certify(observer, plant).require()",
        ]
        if record is not None:
            lines += [
                "import pandas as pd",
                'record = pd.read_csv("data.csv")',
                "found = lb.Filter(plant).run(record)  # found.x, found.std",
            ]
    return f"<pre>{html.escape(chr(10).join(lines))}</pre>"


def _footer(command: str) -> str:
    from datetime import datetime
    from importlib.metadata import version

    made = f"luenberger {version('luenberger')}, {datetime.now():%Y-%m-%d %H:%M}"
    return f"<footer><p>{html.escape(command)}</p><p>{made}</p></footer>"


# -- figures ---------------------------------------------------------------------------


def _drawn(draw: Any, each: Iterable[tuple[Any, ...]]) -> Iterator[str]:
    """A figure for each, side by side where the screen is wide enough."""
    from matplotlib.figure import Figure

    pictures = []
    for given in each:
        figure = Figure(figsize=(WIDE, 3.0), layout="constrained")
        says = draw(figure.subplots(), *given)
        pictures.append(_html(Picture(figure, says)))
    yield f'<div class="figures">{"".join(pictures)}</div>'


def _front(ax: Any, table: Comparison) -> str:
    from . import plot

    plot.pareto(table, ax)
    return "Designs by error and work; a star marks the recommended one."


def _innovations(ax: Any, tests: Whiteness, plant: Plant) -> str:
    from . import plot

    plot.innovations(tests, ax=ax, names=plant.output_names)
    return "Autocorrelations of the normalised innovations, and the band of white ones."


def _estimate(
    ax: Any, found: Estimates, record: Measurements, chosen: Any, plant: Plant, k: int
) -> str:
    from . import plot

    own = slice(max(len(found.x) - SHOWN, 0), None)  # the last, where it has settled
    y = record.of(plant, chosen.observer.L[k])
    std = None if found.std is None else found.std[own]
    plot.estimates(
        plant, found.time[own], found.x[own], std, k, ax,
        y=None if y is None else y[own], names=found.names,
    )  # fmt: skip
    if std is not None:  # a spike at the start sets no axis
        x, far = found.x[own][:, k], 3 * np.median(std[:, k])
        low, high = ax.get_ylim()
        low, high = max(low, x.min() - far), min(high, x.max() + far)
        if low < high:
            ax.set_ylim(low, high)
    ax.legend(fontsize="small")
    shown = "" if own.start == 0 else f", the last {SHOWN} samples"
    return f"Estimates of {found.names[k]} with their one-sigma band{shown}."


def _variance(
    ax: Any, curves: Any, plant: Plant, names: tuple[str, ...], name: str
) -> str:
    from . import plot

    plot.error_variance(curves, plant, name, ax, names=names)
    ax.legend(fontsize="small")
    return f"Error variance of {name} against time, from P0 to the steady state."


def _poles(ax: Any, observer: Observer, plant: Plant) -> str:
    from . import plot

    plot.poles({"plant": plant, "observer": observer}, plant.dt, ax)
    return "Poles of the plant and of the observer in the complex plane."


# -- HTML ------------------------------------------------------------------------------


def _html(part: Part) -> str:
    """A part of the page; names from a file stay text."""
    if isinstance(part, Table):
        return _rows(part)
    if isinstance(part, Picture):
        alt = html.escape(part.alt, quote=True)
        source = f"data:image/png;base64,{part.png}"
        return f'<img alt="{alt}" width="{part.width}" src="{source}">'
    return part if isinstance(part, str) else part._repr_html_()


def _rows(table: Table) -> str:
    """A table; of more than four columns, its rows become cards on a telephone."""
    heads = [html.escape(cell, quote=True) for cell in table.header]
    lines = [f"<table{' class=wide' if len(heads) > 4 else ''}><thead><tr>"]
    lines += [f"<th>{one}</th>" if one else "<td></td>" for one in heads]
    lines.append("</tr></thead><tbody>")
    right = [' class="number"' if numeric else "" for numeric in table._numeric()]
    for k, row in enumerate(table.rows):
        lines.append(f"<tr{' class=chosen' if k in table.marked else ''}>")
        lines += [
            f'<td data-label="{head}"{side}>{html.escape(cell)}</td>'
            for head, side, cell in zip(heads, right, row)
        ]
        lines.append("</tr>")
    return "".join([*lines, "</tbody></table>"])


def _section(title: str) -> str:
    return f"<h2>{title}</h2>"


def _sized(value: float, name: str) -> str:
    """A number in the unit of a name."""
    return f"{number(value, 4)} {unit(name)}".rstrip()


def _plain(name: str) -> str:
    """A name without its unit."""
    own = unit(name)
    return name.rstrip().removesuffix(f"({own})").rstrip() if own else name
