"""Standard errors hold the truth as often as they promise."""

import numpy as np
from coverage_of_errors import of_plant, share


def test_two_standard_errors_hold_the_truth():
    """A few of the thousand plants of `python tests/support/coverage_of_errors.py`."""
    found = [one for seed in range(16) for one in of_plant(seed, (2, 1))]
    part, entries = share(found)
    assert entries > 30 and 0.85 <= part
    spread = np.std([off for off, ok in found if ok])
    assert 0.75 < spread < 1.3
