"""The equations of Leondes and Novak (1974) in SymPy, in reading order.

`letters`
    The letters of Leondes and Novak (1974), each with its size and what it stands for.
`stochastic_system`
    The plant and its statistics, (1)-(6), and what each assumption is good for.
`huddle`
    Luenberger's conditions, the error equation, and Huddle's solution.
`coordinates`
    The canonical coordinates of the paper, and the way back.
`canonical_gain`
    The paper's derivation in its canonical coordinates, block by block.
`uniqueness`
    When (32) has one solution only: exactly when M, the innovation covariance, is > 0.
`best_coordinates`
    The best gain that treats the accurate outputs as exact.
`stages`
    The recursions that run, as lists of small assignments at symbolic sizes.
`claims`
    What is claimed of the stage lists, and the relations under which it holds.
`square_root`
    The filter's recursions with covariances as factors, Sigma = H H'.
`paper`
    The gain of least error trace, step by step: the paper's section III, entire.
`limiting_cases`
    What the reduced-order filter becomes at the ends of its range.
`brammer`
    Brammer's filter for outputs without noise, and that Fig. 2 is Fig. 1.
`tracking`
    The radar tracker: a target's position, velocity and acceleration.
`missing_outputs`
    A step at which some outputs did not arrive: the same theorem for fewer outputs.
`one_pass`
    One step of a filter over a record, as one stage list that compiled loops run.
`on_target`
    The filter in the order in which a device runs it: use the sample, then predict.
`side_by_side`
    Plant and observer side by side, one step: what a Monte Carlo run repeats.
`errata`
    What the page prints and the algebra refuses.

A proof or a stage list of this paper enters here.  It uses
`luenberger.symbolic`, and `luenberger.certificate` where the residuals are
proved; no other paper.
"""
