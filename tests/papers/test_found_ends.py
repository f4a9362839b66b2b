"""What the operations of a page find: the equations of the paper, and no others.

An operation finds the line that follows from what is supposed.  From a wrong
supposition a wrong line follows without a complaint, so the ends stand here.
"""

import pytest

from luenberger.ledger import evidence
from matrixproof import text
from matrixproof.deriving import Derived

ENDS = {
    "kawazoe.form": """
        c₊ = a M R₊
        c = a K_R P_q
        I = J K_R P_q
        X_q P_q = I
        n = q
        E_p P A = φ P
        v_i = p_i + v_h
        P A = Φ P
        P A P⁻¹ = Φ
        E₀ Φ = E_n
        E_p Φ = φ
        e_i E_p P A = φ_ij P_j + φ_o P_o
        φ = -α
        C_i = e_v P
        C P⁻¹ = H
        w₊ = Φ w + G u
        y = H w
        C A_l A = H Φ_l Φ P
    """,
    "kawazoe.reconstruction": """
        e_i y = e_v w
        Φ w_l + G u = Φ_l₊ w + s_l₊
        y_l = H Φ_l w + H s_l
        Γ_l₊ u₊ = s_l₊
        e_l Φ = e_l₊
        e_v Φ_l₊ = e_l₊
        e_l s_l₊ = e_l₊ s_l + g_l u
        e_i y_l = e_l w + e_v s_l
        e_l K = e_l
        e_i y_l - e_v s_l = e_l w
        w_v_i = Y_i - Δ_i u_p
        w_b = e₁' e₁ w_b + E_v' w_v_i
        O_s b = 0
        e_k P b = I
        P⁻¹ w = x
    """,
    "kawazoe.deadbeat": """
        S_i (T_U A_U - F T_U - D C_U) = T_i A_U - A_i T_h - D_i C_U
        (T_i A_U - A_i T_h - D_i C_U) N_c = T_c A_c + T_n S_c - A_i T_h_c
        (T_i A_U - A_i T_h - D_i C_U) N_m = T_i A_m - A_i T_h_m - D_i
        D_i = T_i A_m - A_i T_h_m
        S_i F F_l = 0
    """,
    "moore.observer": """
        ε₊ = F ε + J u
        ε₊ = F ε
        G = T B - D E
        F F_j Δ = Δ A A_j
        P F_j Δ = 0
        k T' M⁻¹ = P₀
        (k T' M⁻¹ T - k) T' = 0
    """,
    "moore.condition": """
        e_i (T A - F T - D C) = t A - e₊ T + b k - d C
        t₊ = t A + b k - d C
        t₊ = h₊ - s₊
        (h - s) X = h X
        e_i (N - L) Q = e_i Q F
        q₊ T = t A - q D C + b k
    """,
    "moore.recurrence": """
        T A - F T = D₁ c
        T Z = F T + (D₁ + T α) c
        T S' i₁ = 0
        T s_i₊ = 0
        k S' = 0
        T₁ F_c = F T₁
        S₂ X_j₊ = I - W_j₊
        k₁ T₁⁻¹ T₂ S₂' = k₂ S₂'
        k₁ T₁⁻¹ T₂ = k₂
        K A_o = A K
        T g_i₊ = F T g_i
        K s_i₊ = A K s_i
        Λ s_τ₊ = λ (1/τ) s_i₊
        s_τ' κ_τ = λ s_i' κ
    """,
    "moore.signs": """
        j S κ = 0
    """,
    "van_dooren.theorem": """
        ε₊ = Φ₊ ε₀
        x̂ - x = P Φ ε₀
        T_U A_U - F T_U = D C_U
        [T; C] U = [T_U; C_U]
        T A - F T = D C
        G = T_U U* B
        U X₁ T + U X₂ C = I
        W* T_U A_U - W* F W W* T_U = W* D C_U
        [W 0; 0 I] [W* T_U; C_U] = [T_U; C_U]
        v* v = 2 v* a_s
        (I - v β v*) a_s = b_s
        β v* v = 2 I
        (I - v β v*) (I - v β v*) = I
        [I 0; 0 Q_r*] [ρ_s h_s; 0 A_r] = [ρ_s h_s; 0 R_r]
        Q_s* A_s W_s = J_s R_s
    """,
    "van_dooren.staircase": """
        C Q₀ = [0  C Q₁]
        C U₀ = [0 0 C₁]
        A U_a = U_a A₁ + U_b A₃
        A U_a V₀ = U_a V₀ M₀
        C U_a V₀ = 0
        V₀ = 0
        D₂* D₂ = [I 0; 0 I]
        D₂* U_C* A U_C D₂ = [A_t  U₂* A₂; A_l  A₄]
        C U_C D₂ = [0 C₁]
    """,
    "van_dooren.rows": """
        t A_U - f T_U - d C_U = a_f + [f_i t_i d] [-T_i; A_f; -C_U]
        -a_f X⁻¹ S M = -a_f
        -a_f R⁻¹ Q* M = -a_f
        (h - a_f R⁻¹ Q*) (h* - Q R*⁻¹ a_f*) = h h* + a_f R⁻¹ R*⁻¹ a_f*
    """,
    "van_dooren.choices": """
        (y_i + (-a_f - y_i M) L) M = -a_f
        x_i + (-a_f - x_i M) L = x_i
        x_i M = x_l X + x_r M_r
        N_T T_U A_U - F_N N_T T_U = N_T D C_U
        dx_l X = f_i dT_i - dx_r M_r
        dJ = f_i dT_i z_l + dx_r (g_r - M_r z_l)
        dΨ = -Ψ dΘ Ψ
    """,
    "van_dooren.pairs": """
        T_p A_U - F_p T_U - d_p C_U = T_p A_U - f_p T_i - Λ T_p - d_p C_U
        w (T_p A_U - Λ T_p - f_p T_i - d_p C_U)
        = w T_p A_U - N w T_p - w f_p T_i - w d_p C_U
        x_i e_i = -a_f v_i
    """,
}


@pytest.mark.parametrize("name", ENDS)
def test_a_page_finds_these_equations(name):
    found = [x for x in evidence.derivation(name).page if isinstance(x, Derived)]
    ends = [f"{text(chain.left)} = {text(chain.right)}" for chain in found]
    assert "\n".join(ends).split() == ENDS[name].split()
