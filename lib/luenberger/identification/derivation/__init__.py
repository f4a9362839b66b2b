"""The equations of identification in SymPy, in reading order.

`likelihood`
    The likelihood of a record, from the innovations of its filter.
`letters`
    The letters of a predictor, of its likelihood and of how that changes.
`score`
    The score: how the likelihood changes with everything that the plant says.
`score_by_blocks`
    The score by blocks: a row of the pass back over a record.
`unknown_start`
    The likelihood of a record whose start is not known.
`settled`
    A record of a plant that does not change, from a filter that has settled.
`settled_score`
    The score of a settled record: its sums, and what an uncertain start adds.
`any_gain_letters`
    The letters of a predictor with any stable gain, and of its innovations.
`autocovariances`
    Autocovariances of the innovations of any stable gain.
`identifiability`
    Which changes of the noise covariances leave no trace in a record.
`direction_letters`
    The letters of a plant that moves in one direction, or in two, and of its filter.
`sensitivity`
    How a filter moves with its plant: the change of each row in one direction.
`information`
    The expected information of a record in what a plant says.
`first_rows`
    The information of a record whose start is not known: its first rows as one row.

A proof or a stage list of a record enters here.
"""

from ...stage_list import StageList

likelihood_step = StageList(
    __name__,
    "likelihood.likelihood_step",
    "Omega N M Kmv K Z Sigma_next x_minus known innovation x_next rho_next W e",
)
weighed = StageList(__name__, "likelihood.weighed", "W e")
prediction_gain = StageList(__name__, "likelihood.prediction_gain", "G")
score_step = StageList(
    __name__,
    "score_by_blocks.score_step",
    "h eta F T V Pi x_s U Y gA gB gC gE gQ gR gS",
)
score_pass = StageList(
    __name__,
    "score_by_blocks.score_pass",
    "N G h eta F T V Pi x_s U Y gA gB gC gE gQ gR gS",
)
start_score = StageList(__name__, "score_by_blocks.start_score", "gP")
mean_moves = StageList(__name__, "unknown_start.mean_moves", "F X_next")
collapse = StageList(__name__, "unknown_start.collapse", "X_f H_c x_c rho_c")
before_start = StageList(__name__, "unknown_start.before_start", "B_c D_c")
after_start = StageList(
    __name__, "unknown_start.after_start", "N_c Pi eta_n T_c delta_all"
)
with_mean = StageList(__name__, "unknown_start.with_mean", "x_n e_n")
settled_row = StageList(__name__, "settled.settled_row", "N M W G F V")
carried_on = StageList(__name__, "settled.carried_on", "z_next")
settled_start = StageList(__name__, "settled.settled_start", "x_1 Omega_1 Delta Y_1")
settled_score = StageList(
    __name__,
    "settled_score.settled_score",
    "D U H K_ee K_eh K_hh K_ex K_hx gA gC gQ gR gS",
)
told_of_start = StageList(__name__, "settled_score.told_of_start", "Pi_1")
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
gain_of_prediction = StageList(__name__, "sensitivity.gain_of_prediction", "N G")
driven = StageList(__name__, "sensitivity.driven", "F H D")
changed_on = StageList(__name__, "sensitivity.changed_on", "dOmega_next")
shown_by_row = StageList(__name__, "sensitivity.shown_by_row", "dM T")
mean_step = StageList(__name__, "sensitivity.mean_step", "b dn dm_x_next m_x_next")
told_back = StageList(__name__, "information.told_back", "F Pi")
weighed_noise = StageList(__name__, "information.weighed_noise", "B_M B_T")
weighed_motion = StageList(__name__, "information.weighed_motion", "B_C B_H")
weighed_mean = StageList(__name__, "information.weighed_mean", "B_n")
correlations = StageList(__name__, "information.correlations", "N X_next X_i_next")
more_readings = StageList(
    __name__, "first_rows.more_readings", "Phi_next mu_next P_next"
)
moved_readings = StageList(
    __name__, "first_rows.moved_readings", "dPhi_next dmu_next dP_next"
)
as_one_row = StageList(__name__, "first_rows.as_one_row", "L H J_r beta_r")
one_row_moved = StageList(__name__, "first_rows.one_row_moved", "dL dH dJ_r dbeta_r")
