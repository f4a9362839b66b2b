"""The equations of identification in SymPy.

In reading order: `likelihood`, `score`, `unknown_start`, `autocovariances`,
`identifiability`.

A proof or a stage list of a record enters here.
"""

from ...stage_list import StageList

weighed = StageList(__name__, "likelihood.weighed")
error_noise = StageList(__name__, "autocovariances.error_noise")
first_autocovariances = StageList(__name__, "autocovariances.first_autocovariances")
autocovariance_step = StageList(__name__, "autocovariances.autocovariance_step")
silent_change = StageList(__name__, "identifiability.silent_change")
change_step = StageList(__name__, "identifiability.change_step")
