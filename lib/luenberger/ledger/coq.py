"""Every proof of the pages as a lemma of Coq, in a file for each page."""

from collections.abc import Iterator
from dataclasses import dataclass
from importlib.resources import files
from pathlib import Path

from matrixproof.coq import HEAD, TAIL, NotWritten, lemma
from matrixproof.proofs import Proof, kept

from ..formats import writing
from . import evidence
from .records import PAPERS, find_paper

NAME = "proof_0"  # until it is known to be the first that says this
PROJECT = "-Q . matrixproof\n-arg -w -arg none\nwords.v\n"


@dataclass(frozen=True)
class Written:
    """What `write` has written.

    Attributes
    ----------
    lemmas : dict of str to int
        How many lemmas the file of each page has.
    left_out : tuple of (page, equation, reason)
        The proofs that have no lemma.
    """

    lemmas: dict[str, int]
    left_out: tuple[tuple[str, str, str], ...]

    def __str__(self) -> str:
        written, missing = sum(self.lemmas.values()), len(self.left_out)
        said = f"{written} of {written + missing} proofs on {len(self.lemmas)} pages "
        lines = [f"not written: {', '.join(one)}" for one in self.left_out]
        return "\n".join([f"{said}are written as lemmas", *lines])


def pages(paper: str | None = None) -> list[str]:
    """The names "room.module" of the pages of one paper, of our own, or of all."""
    rooms: tuple[str, ...] = (*evidence.ROOMS, evidence.COMMON)
    if paper is not None:
        key = find_paper(paper)
        ours = tuple(r for r in rooms if r not in PAPERS)
        rooms = (key,) if key in PAPERS else ours
    found = []
    for room in rooms:
        modules = [Path(x.name) for x in files(evidence.package(room)).iterdir()]
        found += [f"{room}.{x.stem}" for x in sorted(modules) if x.suffix == ".py"]
    return [name for name in found if hasattr(evidence.module(name), "page")]


def paths(folder: str | Path, paper: str | None = None) -> dict[str, Path]:
    """{page: its file}."""
    return {page: Path(folder, f"{page.replace('.', '_')}.v") for page in pages(paper)}


def write(folder: str | Path, paper: str | None = None) -> Written:
    """Write a file of lemmas for each page, their tactics, and `_CoqProject`.

    A proof that several lines or pages have is written once.  To compile all of it,
    in the folder: `coq_makefile -f _CoqProject -o Makefile && make -j2`.

    Parameters
    ----------
    folder : str or Path
        Made if it is not there.
    paper : str, optional
        One paper, or "ours", instead of all.
    """
    Path(folder).mkdir(parents=True, exist_ok=True)
    seen, lemmas, left_out = set[str](), {}, []
    for page, path in paths(folder, paper).items():
        found: list[str] = []
        for proof in proofs(page):
            said = f"{proof.left} = {proof.right}"
            try:
                body = lemma(NAME, proof)
            except NotWritten as reason:
                left_out += [(page, said, str(reason))]
                continue
            if body not in seen:
                seen.add(body)
                name = f"Lemma proof_{len(found) + 1}"
                found.append(body.replace(f"Lemma {NAME}", name, 1))
        writing.write(path, "\n\n".join([HEAD, *found, TAIL]))
        lemmas[page] = len(found)
    tactics = files("matrixproof").joinpath("words.v").read_text("utf-8")
    writing.write(Path(folder, "words.v"), tactics)
    names = "\n".join(path.name for path in paths(folder, paper).values())
    writing.write(Path(folder, "_CoqProject"), f"{PROJECT}{names}\n")
    return Written(lemmas, tuple(dict.fromkeys(left_out)))


def proofs(page: str) -> Iterator[Proof]:
    """The proofs that a page's check finds, the first time that a process runs it.

    A proof of another page that it cites is among them, unless that was checked before.
    """
    with kept() as found:
        evidence.derivation(page).check()
    yield from found
