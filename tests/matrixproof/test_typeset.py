"""Expressions are set as they stand on a page, in LaTeX and in Unicode."""

import pytest
import sympy as sp
from sympy import Rational, Trace

from matrixproof import BlockMatrix, Identity, MatrixSymbol, ZeroMatrix, latex, text
from matrixproof.names import latex_name, text_name

n, p = sp.symbols("n p", integer=True, positive=True)
beta, gamma = sp.symbols("beta_0 gamma")
A, B, Omega = (MatrixSymbol(name, n, n) for name in ("A", "B", "Omega"))
K, C = MatrixSymbol("K_1*", n, p), MatrixSymbol("C", p, n)
I = Identity(n)

NAMES = {
    "z_next": ("z_{+}", "z₊"),
    "x_minus": ("x_{-}", "x₋"),
    "w_hat": (r"\hat w", "ŵ"),
    "Qhat": (r"\hat Q", "Q̂"),
    "Qh": (r"\hat Q", "Q̂"),
    "xt_next": (r"\tilde x_{+}", "x̃₊"),
    "K_mv": (r"K_{\mathrm{mv}}", "K_mv"),
    "Kmv": (r"K_{\mathrm{mv}}", "K_mv"),
    "M_1": ("M_{1}", "M₁"),
    "Q12": ("Q_{12}", "Q₁₂"),
    "As": ("A_{s}", "A_s"),
    "V2s": ("V_{2s}", "V_2s"),
    "Omega": (r"\Omega", "Ω"),
    "Sigma_p": (r"\Sigma_{p}", "Σ_p"),
    "Gam": (r"\Gamma", "Γ"),
    "dOmega": (r"\mathrm{d}\Omega", "dΩ"),
    "U^*": ("U^{*}", "U*"),
    "X+": ("X^{+}", "X⁺"),
    "Khat_+": (r"\hat K_{+}", "K̂₊"),
    "Pick": (r"\mathrm{Pick}", "Pick"),
    "R_seen": (r"R_{\mathrm{seen}}", "R_seen"),
}
EXPRESSIONS = {
    "Python's sum": (sum([A, B]), "A + B", "A + B"),
    "a sum as written": (I - B * A, "I - B A", "I - B A"),
    "minus first": (-A - B, "-A - B", "-A - B"),
    "a bracket taken away": (A - 2 * (B - I) * A, None, "A - 2 (B - I) A"),
    "minus a bracket": (A + -1 * (A + B) * I, None, "A - (A + B) I"),
    "a fraction": (A / 2 - B / 3, r"\tfrac{1}{2} A - \tfrac{1}{3} B", "1/2 A - 1/3 B"),
    "a scalar": (beta * A, r"\beta_{0} A", "β₀ A"),
    "a transpose": ((A * B).T * A.T, r"\left(A B\right)' A'", "(A B)' A'"),
    "a transposed star": (K.T, "{K_{1}^{*}}'", "K₁*'"),
    "an inverse": ((A + B).I * A.I, r"\left(A + B\right)^{-1} A^{-1}", "(A + B)⁻¹ A⁻¹"),
    "a transposed inverse": (A.I.T, "{A^{-1}}'", "A⁻¹'"),
    "a power": (A**2 * B, "A^{2} B", "A² B"),
    "a trace": (
        Trace(A * B),
        r"\operatorname{tr}\left(A B\right)",
        "tr(A B)",
    ),
    "blocks": (
        BlockMatrix([[A, ZeroMatrix(n, n)], [I, B]]),
        r"\begin{bmatrix}A & 0 \\ I & B\end{bmatrix}",
        "[A 0; I B]",
    ),
    "explicit": (sp.Matrix([[1, Rational(-1, 2)]]), None, "[1 -1/2]"),
    "a root": (sp.sqrt(beta), r"\sqrt{\beta_{0}}", "√β₀"),
    "a quotient": (
        1 / (1 - beta) - 2,
        r"-2 + \frac{1}{1 - \beta_{0}}",
        "-2 + 1/(1 - β₀)",
    ),
    "a quotient of sums": ((1 + beta) / (2 * gamma), None, "(1 + β₀)/(2 γ)"),
    "minus a quotient": (-beta / gamma, r"-\frac{\beta_{0}}{\gamma}", "-β₀/γ"),
    "a quotient in a power": (
        (beta / gamma) ** (1 / gamma),
        r"\left(\beta_{0}/\gamma\right)^{1/\gamma}",
        "(β₀/γ)^(1/γ)",
    ),
    "a quotient of a sum in a power": (
        beta ** ((beta + 1) / gamma),
        r"\beta_{0}^{\left(1 + \beta_{0}\right)/\gamma}",
        "β₀^((1 + β₀)/γ)",
    ),
    "a derivative": (
        sp.Derivative(sp.Function("J")(beta), beta, 2),
        r"\frac{\mathrm{d}^{2}}{\mathrm{d}\beta_{0}^{2}} J\left(\beta_{0}\right)",
        "d²/dβ₀² J(β₀)",
    ),
    "a derivative of a sum": (
        sp.Derivative(beta - gamma, beta),
        None,
        "d/dβ₀ (β₀ - γ)",
    ),
    "an exponential": (sp.exp(-2 * gamma), "e^{-2 \\gamma}", "e^(-2 γ)"),
    "a sine": (
        sp.sin(sp.sqrt(3) * beta),
        r"\sin\left(\beta_{0} \sqrt{3}\right)",
        "sin(β₀ √3)",
    ),
    "a power of a letter": (beta**gamma, r"\beta_{0}^{\gamma}", "β₀^γ"),
    "a negative power of a letter": (beta**-gamma, None, "β₀^(-γ)"),
}


@pytest.mark.parametrize("name", NAMES)
def test_name(name):
    assert (latex_name(name), text_name(name)) == NAMES[name]


@pytest.mark.parametrize("name", EXPRESSIONS)
def test_expression(name):
    expr, typeset, plain = EXPRESSIONS[name]
    assert text(expr) == plain
    if typeset is not None:
        assert latex(expr) == typeset
    assert latex(expr).count("{") == latex(expr).count("}")
    assert "top" not in latex(expr) and "^T" not in latex(expr)
