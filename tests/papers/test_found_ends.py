"""What the operations of a page find: the equations of the paper, and no others.

An operation finds the line that follows from what is supposed.  From a wrong
supposition a wrong line follows without a complaint, so the ends stand in
`test_found_ends.txt`: read them beside the paper before you change them there.
"""

from functools import cache
from pathlib import Path

import pytest

from luenberger.ledger import coq, evidence
from matrixproof import text
from matrixproof.deriving import Derived


@cache
def told():
    """{page: its ends}, as they stand in the file."""
    found, page = {}, ""
    for line in Path(__file__).with_suffix(".txt").read_text("utf-8").splitlines():
        if line.startswith(" "):
            found[page].append(line.strip())
        elif line:
            page = line
            found[page] = []
    return found


def ends(page):
    chains = [x for x in evidence.derivation(page).page if isinstance(x, Derived)]
    return [f"{text(chain.left)} = {text(chain.right)}" for chain in chains]


@pytest.mark.parametrize("page", coq.pages())
def test_a_page_finds_these_equations(page):
    assert ends(page) == told().get(page, [])


def test_every_page_of_the_file_is_there():
    assert set(told()) <= set(coq.pages())
