"""Pages of derivations: all of a page holds, is used, and notices damage."""

import random

import pytest
from damage import fails
from page_damage import idle_values, stage_lists, wrong_definitions, wrong_stages

from luenberger.ledger import entries, evidence
from matrixproof import Relation
from matrixproof.derivation import End, misplaced

COMMON = ["theory.observer", "theory.regression"]  # cited by the others
PAGES = COMMON + sorted({page for entry in entries() for page in entry.pages})
page = evidence.derivation


@pytest.mark.parametrize("name", PAGES)
def test_everything_on_a_page_holds_and_is_used(name):
    assert page(name).check() == []
    assert page(name).steps and page(name).source


@pytest.mark.parametrize("name", PAGES)
def test_what_is_left_out_is_missed_where_it_is_cited(name):
    """Some of what a page introduces, each left out in turn."""
    items = [item for item in page(name).page if not isinstance(item, End)]
    introduced = [item for item in items if isinstance(item, Relation)]
    for gone in random.Random(name).sample(introduced, min(4, len(introduced))):
        rest = [item for item in items if item != gone]
        found = [f for k, item in enumerate(rest) for f in misplaced(item, rest[:k])]
        assert any(f"{gone.name} is cited and not introduced" in f for f in found)


@pytest.mark.parametrize("name", PAGES)
def test_a_wrong_sign_in_a_stage_is_noticed(name):
    for stages in stage_lists(page(name)):
        wrong = wrong_stages(stages)
        assert [what for what, one in wrong if not fails(one, stages)] == []


@pytest.mark.parametrize("name", PAGES)
def test_a_wrong_sign_in_a_definition_is_noticed(name):
    passed = [
        what
        for what, changed in wrong_definitions(page(name))
        if not any(fails(*pair) for pair in changed)
    ]
    assert passed == []


@pytest.mark.parametrize("name", PAGES)
def test_explicit_values_matter(name):
    assert list(idle_values(page(name))) == []


LOOSE = {  # these only name a factor, or are concluded about on another page
    "haddad_bernstein.cost": "J",
    "haddad_bernstein.stationarity": "X_G X_Gamma I_e tau",
}
assert set(LOOSE) <= set(PAGES)


@pytest.mark.parametrize("name", PAGES)
def test_a_theorem_of_the_page_says_something_of_what_a_stage_assigns(name):
    tied = page(name).tied()
    loose = [target.name for target, says in tied.items() if says == ("definition",)]
    assert loose == LOOSE.get(name, "").split()


@pytest.mark.parametrize("name", PAGES)
def test_a_page_is_shown(name):
    derivation = page(name)
    text, markdown = str(derivation), derivation._repr_markdown_()
    assert "✗" not in text and r"\times &" not in markdown
    for item in derivation.page:
        if getattr(item, "number", ""):
            assert f"({item.number})" in text and item.says in text


def test_words_have_no_formulas_in_plain_text():
    """Headings and words are sentences; what is mathematics is set as such."""
    says = [
        getattr(x, "says", "").replace("`", "") for n in PAGES for x in page(n).page
    ]
    assert [words for words in says if set("=_^\\*") & set(words)] == []
