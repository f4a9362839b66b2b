"""What kernels of this project find loaded when they are forked."""

MODULES = (
    "luenberger",
    "luenberger.comparison",
    "luenberger.kernels.text",
    "luenberger.papers.kawazoe.derivation",
    "luenberger.papers.leondes_novak.derivation",
    "luenberger.plot",
    "luenberger.show",
    "matplotlib.pyplot",
    "matrixproof",
    "numba",
    "numpy",
    "scipy.optimize",
    "sympy",
)
