"""What several tests of exported C share."""

import pytest

from luenberger.export.c import filter as filter_


@pytest.fixture
def without_a_bound(monkeypatch):
    """A header says nothing of rounding: what it says there takes longest to find."""
    monkeypatch.setattr(filter_, "filter_notes", lambda *_: [])
