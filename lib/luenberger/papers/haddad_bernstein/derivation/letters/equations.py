"""Letters: the equations."""

from . import l, letters, n, q, square
from .both import both

root_Qt = letters("H", both, both, "a root of `Q_tilde`")
root_R = letters("H_R", q, q, "a root of the weight")
root_V = letters("H_V", l, l, "a root of the innovation covariance")
riccati = square("riccati", n, "residual of (3.14)")
