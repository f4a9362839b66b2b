"""The equations of Haddad and Bernstein (1987) in SymPy.

In reading order: `augmented`, `cost`, `gradients`, `mean_square`, `constant_parameter`,
`stationarity`, `projection`, `equations`, `remarks`, `full_order`, `sensitivity`,
`one_basis`, `converse`, `counterexamples`, `stability`, `model_reduction`, `errata`.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof`, and `luenberger.certificate` where the residuals are proved;
no other paper.
"""

from ....stage_list import StageList

equivalent_noise = StageList(__name__, "augmented.equivalent_noise")
moment_ahead = StageList(__name__, "augmented.moment_ahead")
both_systems = StageList(__name__, "augmented.both_systems")
output_moments = StageList(__name__, "augmented.output_moments")
estimator_moments = StageList(__name__, "augmented.estimator_moments")
adjoint_moments = StageList(__name__, "cost.adjoint_moments")
weight_of_both = StageList(__name__, "cost.weight_of_both")
projection_cost = StageList(__name__, "cost.projection_cost")
projection_gradient = StageList(__name__, "gradients.projection_gradient")
best_output = StageList(__name__, "sensitivity.best_output")
best_output_differential = StageList(__name__, "sensitivity.best_output_differential")
projection_differential = StageList(__name__, "sensitivity.projection_differential")
projection_innovation = StageList(__name__, "stationarity.projection_innovation")
projection_factors = StageList(__name__, "stationarity.projection_factors")
projection_product = StageList(__name__, "stationarity.projection_product")
feedthrough_gain = StageList(__name__, "stationarity.feedthrough_gain")
projection_gains = StageList(__name__, "stationarity.projection_gains")
open_factors = StageList(__name__, "projection.open_factors")
projection_scripts = StageList(__name__, "projection.projection_scripts")
projection_equations = StageList(__name__, "equations.projection_equations")
projection_trace = StageList(__name__, "equations.projection_trace")
first_drive = StageList(__name__, "constant_parameter.first_drive")
second_drive = StageList(__name__, "constant_parameter.second_drive")
innovations_plant = StageList(__name__, "full_order.innovations_plant")
