"""The equations of Haddad and Bernstein (1987) in SymPy, in reading order.

`augmented`
    Plant and estimator as one system: its moments, the Lagrangian and its gradients.
`stationarity`
    From stationarity to the optimal projection: (4.8)-(4.16) to (3.10)-(3.20).
`remarks`
    What is said beside the theorem: lemma 3.1, (3.18)-(3.20), remarks 3.3 and 3.4.
`full_order`
    The fixed-order filter of full order: corollary 3.1 and the Kalman filter.
`mean_square`
    Mean-square stability of plant and estimator: lemma 4.1, and the largest noise.
`equivalent_plant`
    Multiplicative noise acts only through the plant's own second moment.
`converse`
    Do (3.14)-(3.17) imply stationarity?  Yes, if (3.17) is read as it is printed.
`counterexamples`
    Where a weaker form of the theorem goes wrong, in exact arithmetic.
`stability`
    Is an estimator built from (3.14)-(3.17) stable?
`model_reduction`
    H2 model reduction is a fixed-order filter of a plant that is its own noise.
`moment_stages`
    What the fixed-order filter computes, as lists of small assignments.
`moment_claims`
    What is claimed of the stage lists of `moment_stages`.
`theorem_stages`
    The theorem's formulas (3.10)-(3.18), as lists of small assignments.
`theorem_claims`
    What is claimed of the stage lists of `theorem_stages`.
`paper`
    The optimal projection equations: Haddad and Bernstein's paper, entire.
`errata`
    What Haddad and Bernstein's pages print, or the scan leaves, and what holds.

A proof or a stage list of this paper enters here; of a stage list, its `StageList`
stands below, so that nobody loads SymPy only to name it.  It uses
`luenberger.symbolic`, and `luenberger.certificate` where the residuals are proved;
no other paper.
"""

from ....stage_list import StageList

equivalent_noise = StageList(__name__, "moment_stages.equivalent_noise", "dV1 dV12 dV2")
output_moments = StageList(__name__, "moment_stages.output_moments", "Qxy Qxy_next Qyy")
estimator_moments = StageList(__name__, "moment_stages.estimator_moments", "N12 N2")
adjoint_moments = StageList(__name__, "moment_stages.adjoint_moments", "M2 M12 M1")
projection_cost = StageList(__name__, "moment_stages.projection_cost", "Sigma J")
projection_gradient = StageList(
    __name__, "moment_stages.projection_gradient", "gradAe gradBe gradCe gradDe"
)
best_output = StageList(__name__, "moment_stages.best_output", "Czy Nzy CeDe Ce")
best_output_differential = StageList(
    __name__, "moment_stages.best_output_differential", "dNzy dCeDe dCe"
)
projection_differential = StageList(
    __name__,
    "moment_stages.projection_differential",
    "dN12 dN2 dM2 dM12 dgradAe dgradBe dgradCe dgradDe",
)
projection_innovation = StageList(
    __name__, "theorem_stages.projection_innovation", "Qs V2s"
)
projection_factors = StageList(
    __name__, "theorem_stages.projection_factors", "Gt Gamt G Gam GamG tau Q"
)
feedthrough_gain = StageList(__name__, "theorem_stages.feedthrough_gain", "De")
projection_gains = StageList(
    __name__, "theorem_stages.projection_gains", "Kq Aq Ae Be Ce"
)
projection_scripts = StageList(
    __name__, "theorem_stages.projection_scripts", "Kq Aq Lq Qh Ph"
)
projection_equations = StageList(
    __name__,
    "theorem_stages.projection_equations",
    "Kq Aq Lq forgets riccati estimate adjoint idempotent aligned_Q aligned_P",
)
projection_trace = StageList(__name__, "theorem_stages.projection_trace", "J")
innovations_plant = StageList(__name__, "theorem_stages.innovations_plant", "Kq V1i Lq")
