"""The equations of Leondes and Novak (1974) in SymPy, in reading order.

`stochastic_system`
    The plant and its statistics.
`huddle`
    Luenberger's conditions, the error equation, and Huddle's solution.
`correlated_noise`
    Noises that are correlated, and the covariance of any observer's error.
`coordinates`
    The canonical coordinates of the paper, and the way back.
`quadratic`
    The error covariance is a quadratic in the gain, and the Kalman filter its minimum.
`canonical_gain`
    The gain of least error trace in the coordinates of the paper, block by block.
`start`
    How the observer starts, from what is known of the first state.
`any_observer`
    An observer that is none: with the state beside it, it satisfies every condition.
`known_input`
    A plant whose known input has statistics, as a plant without input.
`measured_input`
    An observer that uses the known input as one more measurement.
`uniqueness`
    When the best gain is the only one.
`best_coordinates`
    The best gain that treats the accurate outputs as exact.
`steady_gain`
    How a step moves with what it starts from, and the best gain in the long run.
`settled_ratio`
    How far two filters are apart behind rows that they filter alike.
`limiting_cases`
    What the reduced-order filter becomes at the ends of its range.
`estimate`
    The filter in innovation form: predict, compare with the measurement, correct.
`brammer`
    Brammer's filter for outputs without noise is the same system, drawn differently.
`tracking`
    The radar tracker: a target's position, velocity and acceleration.
`missing_outputs`
    A step at which some outputs did not arrive is the theorem for fewer outputs.
`factored`
    A covariance in factors `U D U'`: what one reading and one prediction make of it.
`square_root`
    The filter's recursions with factors of the covariances.
`noise_factors`
    The error of any observer, and both noises of the plant, with factors.
`side_by_side`
    Plant and observer side by side: a step of both, and the error between them.
`errata`
    What the page prints and the algebra refuses.

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
