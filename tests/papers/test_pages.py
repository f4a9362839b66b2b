"""Pages of derivations: all of a page holds, is used, and notices damage."""

import random

import pytest
from damage import fails
from page_damage import idle_values, stage_lists, wrong_definitions, wrong_stages

<<<<<<< HEAD
from luenberger.ledger import evidence
from matrixproof import Relation
from matrixproof.derivation import End, misplaced

PAGES = (
    "haddad_bernstein.augmented",
    "haddad_bernstein.cost",
    "haddad_bernstein.gradients",
    "haddad_bernstein.stationarity",
    "haddad_bernstein.projection",
    "haddad_bernstein.equations",
    "haddad_bernstein.remarks",
    "haddad_bernstein.full_order",
    "haddad_bernstein.sensitivity",
    "haddad_bernstein.one_basis",
    "haddad_bernstein.converse",
    "haddad_bernstein.counterexamples",
    "haddad_bernstein.mean_square",
    "haddad_bernstein.stability",
    "haddad_bernstein.constant_parameter",
    "haddad_bernstein.model_reduction",
    "leondes_novak.stochastic_system",
    "leondes_novak.huddle",
    "leondes_novak.correlated_noise",
    "leondes_novak.coordinates",
    "leondes_novak.quadratic",
    "leondes_novak.canonical_gain",
    "leondes_novak.start",
    "leondes_novak.any_observer",
    "leondes_novak.known_input",
    "leondes_novak.measured_input",
    "leondes_novak.uniqueness",
    "leondes_novak.best_coordinates",
    "leondes_novak.steady_gain",
    "leondes_novak.settled_ratio",
    "leondes_novak.limiting_cases",
    "leondes_novak.estimate",
    "leondes_novak.brammer",
    "leondes_novak.missing_outputs",
    "leondes_novak.tracking",
    "leondes_novak.square_root",
    "leondes_novak.noise_factors",
    "leondes_novak.factored",
    "leondes_novak.side_by_side",
    "moore.observer",
    "moore.condition",
    "moore.recurrence",
    "moore.signs",
    "van_dooren.theorem",
    "van_dooren.rows",
    "van_dooren.counts",
    "van_dooren.pairs",
    "van_dooren.choices",
    "kawazoe.form",
    "kawazoe.reconstruction",
    "kawazoe.deadbeat",
    "hsia.laws",
    "hsia.loop",
    "hsia.noise",
    "identification.likelihood",
    "identification.score",
    "identification.score_by_blocks",
    "identification.unknown_start",
    "identification.autocovariances",
    "identification.identifiability",
    "smoothing.next_state",
    "smoothing.adjoint",
    "smoothing.disturbances",
    "smoothing.accurate_outputs",
    "forms.change",
    "forms.combinations",
    "forms.gramians",
)

=======
from luenberger.ledger import entries, evidence
>>>>>>> ad8df32 (Say how an entry of the ledger comes about)

PAGES = list(dict.fromkeys(page for entry in entries() for page in entry.pages))
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
