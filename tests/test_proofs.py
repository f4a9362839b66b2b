"""The prover: identities proved, certificates checked, nonsense refused."""

import time

import pytest
from identities import FALSE, TRUE, parts

from luenberger.symbolic import Unproved, prove


@pytest.mark.parametrize("name", TRUE)
def test_identity_is_proved_within_a_second(name):
    start = time.process_time()
    proof = prove(*parts(TRUE[name]))
    assert time.process_time() - start < 1
    assert proof.complaints() == []


@pytest.mark.parametrize("name", FALSE)
def test_false_variant_is_not_proved(name):
    with pytest.raises(Unproved) as failure:
        prove(*parts(FALSE[name]))
    assert not failure.value.left_over.is_zero
