"""`ledger`: every equation of the papers, our own theorems, and their evidence."""

import textwrap
from argparse import Namespace
from types import ModuleType
from typing import Any

from .registration import as_json, dry_run, file, folder, register
from .terminal import say, tell, tell_json, written

WIDE, INDENT = 79, " " * 6


def add(commands: Any) -> None:
    one = register(
        commands,
        "ledger",
        run,
        help="list the papers' equations, their evidence and their misprints",
        description="List every numbered equation of the papers: what defines it, what "
        "is proved of it and for which sizes, what uses it, and what is wrong with it "
        "in our scan or in the paper. The part `ours` has the theorems that are in no "
        "paper. Without --paper it prints counts.",
        examples=[
            "ledger",
            'ledger --paper "Van Dooren"',
            "ledger --misprints --json",
            "ledger --paper ours",
            "ledger --prove --paper moore",
            "ledger --paper hsia --html ledger.html",
            "ledger --paper moore --coq lemmas",
        ],
    )
    one.add_argument(
        "--paper",
        metavar="NAME",
        help="one paper, by part of its name or title; or ours",
    )
    one.add_argument(
        "--misprints", action="store_true", help="list misprints, not equations"
    )
    one.add_argument(
        "--prove",
        action="store_true",
        help="check every proof, and count by how equations are established: half a "
        "minute for all papers",
    )
    as_json(one)
    one.add_argument(
        "--html",
        type=file,
        metavar="FILE",
        help="write a page with every equation and its proved formulas, which runs "
        "the derivations: half a minute for all papers",
    )
    one.add_argument(
        "--coq",
        type=folder,
        metavar="DIR",
        help="write every proof as a lemma of Coq, in a file for each page; this runs "
        "the derivations, two minutes for all papers; compile them there with "
        "coq_makefile -f _CoqProject -o Makefile && make -j2",
    )
    dry_run(one)


def run(options: Namespace) -> None:
    """Print the ledger, or write its page."""
    from .. import ledger
    from ..formats import atomic

    if options.paper is not None:
        options.paper = ledger.find_paper(options.paper)
    if options.prove and (options.json or options.misprints or options.html):
        options.wrong("--prove goes without --json, --misprints and --html")
    if options.prove:
        return _prove(ledger, options)
    if options.coq is not None:
        return _lemmas(options)
    if options.html is None:
        return _print(ledger, options)
    if options.json or options.misprints:
        options.wrong("--html goes without --json and --misprints")
    atomic.destination(options.html)
    if not options.dry_run:
        say("running the derivations, for their formulas")
        ledger.write_page(options.html, options.paper)
    written([options.html], options.dry_run)


def _prove(ledger: ModuleType, options: Namespace) -> None:
    """Check the evidence of each entry, and say which is not proved."""
    failed = 0
    for entry in ledger.entries(options.paper):
        faults = entry.check()
        failed += bool(faults)
        for fault in faults:
            tell(_filled(f"{entry.source} {entry.number}: not proved: {fault}", INDENT))
    if failed:
        raise ValueError(f"{failed} of the entries are not proved")
    tell(ledger.levels(options.paper))


def _lemmas(options: Namespace) -> None:
    from ..ledger import coq

    if options.prove or options.html or options.json or options.misprints:
        options.wrong("--coq goes without --prove, --html, --json and --misprints")
    if not options.dry_run:
        say("running the derivations, for their proofs")
        tell(str(coq.write(options.coq, options.paper)))
    written(coq.paths(options.coq, options.paper).values(), options.dry_run)


def _print(ledger: ModuleType, options: Namespace) -> None:
    if options.json:
        tell_json(_data(ledger, options))
    elif options.misprints:
        for entry, slip in ledger.misprints(options.paper):
            tell(f"{entry.source} {entry.number}")
            tell(_filled(f"  {slip.where}: {slip.printed}", "    "))
            tell(_filled(f"  correct: {slip.correct}", "    "))
    elif options.paper is None:
        tell(ledger.summary())
    else:
        for entry in ledger.entries(options.paper):
            used = entry.used.removeprefix("luenberger.")
            tell(_filled(f"{entry.number:<4}  {entry.level}; {used}", INDENT))
            for row in entry.says.lines():
                tell(_filled(f"{INDENT}{row}", INDENT + "  "))


def _filled(text: str, indent: str) -> str:
    filled = textwrap.fill(
        text,
        WIDE,
        subsequent_indent=indent,
        break_on_hyphens=False,
        break_long_words=False,
    )
    return filled.replace("\u00a0", " ")


def _data(ledger: ModuleType, options: Namespace) -> dict[str, Any]:
    """The entries as plain data, or the misprints with the place of each."""
    if options.misprints:
        return {
            "misprints": [
                {"paper": entry.paper, "number": entry.number}
                | {"kind": slip.kind, "printed": slip.printed, "correct": slip.correct}
                for entry, slip in ledger.misprints(options.paper)
            ]
        }
    return {"entries": [entry.as_dict() for entry in ledger.entries(options.paper)]}
