"""Derivation -> callable.  The only place that turns symbols into code.

Each function compiles one stage list at its first call (a few tenths of a second,
SymPy's import included) and returns the same callable afterwards.
"""

from functools import cache


def require_backend(backend):
    """Raise unless `backend` is one that exists; "auto" is NumPy for now."""
    if backend not in ("auto", "numpy"):
        raise ValueError(f"backend must be 'auto' or 'numpy', got {backend!r}")


@cache
def compiled(module, stages, *outputs, **options):
    """The kernel of `derivations.<module>.<stages>()`, pruned to `outputs`."""
    from importlib import import_module

    from .numpy import kernel

    derivation = getattr(import_module(f"..derivations.{module}", __package__), stages)
    return kernel(derivation(), *outputs, **options)


def gain_step(*outputs, settled=False):
    """Omega, M, K and the next error covariance: Leondes and Novak (27)-(33).

    `settled` is for noise-free outputs, where rounding would pass for uncertainty.
    """
    return compiled(
        "trace_minimisation", "gain_step", *outputs, flat=True, settled=settled
    )


def estimate_step(*outputs):
    """One step of the estimate, from x_i and y_{i+1} to x_{i+1}: Fig. 1, (43)."""
    return compiled("trace_minimisation", "estimate_step", *outputs, flat=True)


def step_differential(*outputs):
    """How the next covariance moves with Omega; Newton's method needs it."""
    return compiled("trace_minimisation", "step_differential", *outputs)


def steady_gradient(*outputs):
    """Gradient of the steady error trace with respect to a constant gain."""
    return compiled("trace_minimisation", "steady_gradient", *outputs, flat=True)


def observer_matrices(*outputs):
    """F, G, D, T, W of the observer that a gain defines: (10), (14), (15), (25)."""
    return compiled("huddle", "observer", *outputs)


def decorrelation(*outputs):
    """The plant whose two noises are uncorrelated, from one with S."""
    return compiled("huddle", "decorrelation", *outputs, flat=True)


def error_recursion(*outputs):
    """Covariance of the error of any observer, one step: (11), (26), (28)."""
    return compiled("huddle", "error_recursion", *outputs, flat=True)


def functional_row(*outputs):
    """The next row of T from the one above, in companion form: Moore (5)."""
    return compiled("functional", "companion_row", *outputs)


def functional_input(*outputs):
    """G of an observer without feedthrough: Moore (6)."""
    return compiled("functional", "observer", *outputs)


@cache
def sampling_law(name, coefficient):
    """A law of Hsia's Table II without bounds: f(rho, T_max, `coefficient`)."""
    from ..derivations import adaptive_sampling
    from .scalar import function

    return function(
        adaptive_sampling.derive(),
        adaptive_sampling.key(name),
        *("rho", "T_max", coefficient),
    )


def noise_of_a_period(*outputs):
    """Covariance of the noise of one period from Van Loan's exponential."""
    return compiled("adaptive_sampling", "noise_of_a_period", *outputs, flat=True)


def noise_doubled(*outputs):
    """The same of a period twice as long."""
    return compiled("adaptive_sampling", "noise_doubled", *outputs, flat=True)
