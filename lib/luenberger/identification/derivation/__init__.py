"""The equations of identification in SymPy, in reading order.

`likelihood`
    The likelihood of a record, from the innovations of its filter.
`score`
    The score: how the likelihood changes with the covariances of the noises.
`unknown_start`
    A start of which nothing is known: the limit of wide ones.
`autocovariances`
    Autocovariances of the innovations of any stable gain.
`identifiability`
    Which changes of the noise covariances leave no trace in a record.

A proof or a stage list of a record enters here.
"""

from ...stage_list import StageList

weighed = StageList(__name__, "likelihood.weighed")
error_noise = StageList(__name__, "autocovariances.error_noise")
first_autocovariances = StageList(__name__, "autocovariances.first_autocovariances")
autocovariance_step = StageList(__name__, "autocovariances.autocovariance_step")
silent_change = StageList(__name__, "identifiability.silent_change")
change_step = StageList(__name__, "identifiability.change_step")
