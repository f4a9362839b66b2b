"""The letters of Kawazoe (1978), each with its size and what it stands for."""

from sympy import symbols

from ....symbolic import Identity as Identity
from ....symbolic import Notation
from ....symbolic import ZeroMatrix as ZeroMatrix

SOURCE = "Kawazoe (1978)"

n, m, r, s = symbols("n m r s", integer=True, nonnegative=True)
letters = Notation()
chain, define = letters.chain, letters.define

A = letters("A", n, n, "moves the state")
B = letters("B", n, r, "what the input does to the state")
C = letters("C", m, n, "what is measured; its rows are independent")
x = letters("x", n, 1, "state")
x_next = letters("x_next", n, 1, "state one sample on")
u = letters("u", r, 1, "input")
y = letters("y", m, 1, "measurement, less `E u` where the input feeds through")
A_l = letters("A_l", n, n, "`A` to the power `l`")
P = letters("P", n, n, "the rows `C_i A^k` that are kept, sorted by output")
P_A = letters("P_A", n, n, "the rows of `P` times `A`, the last of a block in full")
Phi = letters("Phi", n, n, "moves the state in the new coordinates")
Phi_l = letters("Phi_l", n, n, "`Phi` to the power `l`")
Phi_next = letters("Phi_l_next", n, n, "`Phi` to the power `l + 1`")
G = letters("G", n, r, "what the input does to it")
H = letters("H", m, n, "reads the first entry of each block")
w = letters("w", n, 1, "state in the new coordinates")
w_next = letters("w_next", n, 1, "the same one sample on")
w_l = letters("w_l", n, 1, "the same `l` samples on")
s_l = letters("s_l", n, 1, "what the inputs have added in `l` samples")
s_next = letters("s_l_next", n, 1, "what they have added in `l + 1` samples")
y_l = letters("y_l", m, 1, "measurement `l` samples on")
K = letters("K", n, n, "the rows `h_i Phi^l` for `l < p_i`")
y_s = letters("y_s", n, 1, "the outputs `i` at `p_i` samples, stacked")
d_s = letters("d_s", n, 1, "what the inputs contribute to them")
w_t = letters("w_t", m, 1, "the first entry of each block of `w`")
w_o = letters("w_o", n - m, 1, "the other entries of `w`")
y_o = letters("y_o", n - m, 1, "the outputs from the next sample on")
Delta = letters("Delta", n - m, s, "the blocks of (25) below each other")
u_p = letters("u_p", s, 1, "the inputs of the samples")
Pi = letters("Pi", n, n, "sorts what is read and what is computed by block")
O_s = letters("O_s", s, n, "the rows `h_i Phi^k` of one sample less")
b = letters("b", n, 1, "the last entry of the longest block")
