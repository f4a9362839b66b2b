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

weighed = StageList(__name__, "likelihood.weighed", "W e")
error_noise = StageList(__name__, "autocovariances.error_noise", "W")
first_autocovariances = StageList(
    __name__, "autocovariances.first_autocovariances", "Lambda_0 N_1"
)
autocovariance_step = StageList(
    __name__, "autocovariances.autocovariance_step", "Lambda_k N_next"
)
silent_change = StageList(__name__, "identifiability.silent_change", "dQ dR dS")
change_step = StageList(
    __name__, "identifiability.change_step", "dW X_next dLambda_0 dN_1"
)
