"""The equations of Leondes and Novak (1974) in SymPy.

In reading order: `stochastic_system`, `huddle`, `correlated_noise`, `coordinates`,
`quadratic`, `canonical_gain`, `start`, `any_observer`, `known_input`, `measured_input`,
`uniqueness`, `best_coordinates`, `steady_gain`, `settled_ratio`, `limiting_cases`,
`estimate`, `brammer`, `tracking`, `missing_outputs`, `factored`, `square_root`,
`noise_factors`, `side_by_side`, `errata`.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`matrixproof`, and `luenberger.certificate` where the residuals are proved;
no other paper.
"""

from ....stage_list import StageList

gain_step = StageList(__name__, "best_coordinates.gain_step")
estimate_step = StageList(__name__, "estimate.estimate_step")
step_differential = StageList(__name__, "steady_gain.step_differential")
closed_loop = StageList(__name__, "steady_gain.closed_loop")
steady_gradient = StageList(__name__, "steady_gain.steady_gradient")
observer_matrices = StageList(__name__, "best_coordinates.observer")
exact_gain = StageList(__name__, "best_coordinates.exact_gain")
decorrelation = StageList(__name__, "correlated_noise.decorrelation")
error_recursion = StageList(__name__, "correlated_noise.error_recursion")
start_root = StageList(__name__, "start.start_root")
beside_the_state = StageList(__name__, "any_observer.beside_the_state")
driven_beside_the_state = StageList(__name__, "any_observer.driven_beside_the_state")
error_of_input = StageList(__name__, "any_observer.error_of_input")
driven_plant = StageList(__name__, "known_input.driven_plant")
driven_pair = StageList(__name__, "known_input.driven_pair")
observer_of_both = StageList(__name__, "measured_input.observer_of_both")
root_update = StageList(__name__, "square_root.root_update")
root_error = StageList(__name__, "noise_factors.root_error")
root_decorrelation = StageList(__name__, "noise_factors.root_decorrelation")
observer_step = StageList(__name__, "side_by_side.observer_step")
side_by_side_step = StageList(__name__, "side_by_side.side_by_side")
