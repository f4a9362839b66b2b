"""Derivation -> callable.  The only place that turns symbols into code.

Each function compiles one stage list at its first call and returns the same callable
afterwards.  Deriving the text takes a few tenths of a second, SymPy's import included,
so `cache` keeps it for the next process.
"""

import functools
from importlib.util import find_spec

AUTO_ROWS = 20_000  # NumPy takes about as long for these as compiling the first time
OPTIONAL = ("B", "E", "Gamma", "J", "G", "W")  # whose terms go if they are zero
UNROLLED = 1000  # operations of one row; more are faster and sooner compiled as loops


def runs_compiled(backend, rows, enough=AUTO_ROWS):
    """Whether a pass over so many rows is to run in code that numba compiles.

    "auto" asks for it where numba is installed and the record has `enough` rows to
    pay for the compiling; that is decided by the length alone, so that the same call
    gives the same bits tomorrow.
    """
    if backend not in ("auto", "numpy", "numba"):
        raise ValueError(f"backend must be 'auto', 'numpy' or 'numba', got {backend!r}")
    if backend == "numpy" or (backend == "auto" and rows < enough):
        return False
    there = find_spec("numba") is not None
    if backend == "numba" and not there:
        raise ImportError(
            "backend='numba' needs numba, which is not installed: "
            "pip install 'luenberger[fast]', or leave backend at 'auto'"
        )
    return there


def entries_known(zero, one):
    """A table of 0.0, 1.0 and None (read at run time), from two boolean matrices."""
    return tuple(
        tuple(0.0 if z else 1.0 if o else None for z, o in zip(*rows))
        for rows in zip(zero.tolist(), one.tolist())
    )


def plain_array(X):
    """X as compiled code takes it: floats by rows, without gaps, and writable."""
    plain = X.flags.c_contiguous and X.flags.writeable and X.dtype == float
    return X if plain else X.astype(float, order="C")


def _vanishes(table):
    return all(value == 0 for row in table for value in row)


@functools.cache
def over_record(recursion, sizes, known, changing):
    """A recursion of `passes` with its loop over a record, compiled by numba.

    Parameters
    ----------
    recursion : "filter_recursion", "observer_recursion", "side_by_side_recursion"
    sizes : tuple of (name, int)
    known : tuple of (name, table)
        Entries of the given matrices that are 0 or 1; see `entries_known`.
    changing : frozenset of str
        Matrices that change from row to row.

    Returns
    -------
    callable
        ``f(**arrays)``, the arguments of `numba.source`'s `run` by name; `f.names`
        lists them, `f.source` is the text.
    """
    from . import cache

    text, types = cache.derived(
        ("numba", recursion, sizes, known, sorted(changing), UNROLLED),
        lambda: _text(recursion, dict(sizes), dict(known), changing),
    )
    run = cache.compiled(text, tuple(types.values()))

    def over(**arrays):
        return run(*(arrays[name] for name in types))

    over.names, over.source = tuple(types), text
    return over


def _text(recursion, sizes, known, changing):
    """The text that numba compiles, and the type of each argument by name."""
    from . import numba, passes, scalars

    zero = tuple(name for name in OPTIONAL if _vanishes(known.get(name, ())))
    found = getattr(passes, recursion)(zero)
    straight = None
    if found.program.work(sizes) <= 4 * UNROLLED:
        straight = scalars.unroll(found.program, sizes, known)
        if straight.operations > UNROLLED:
            straight = None
    text = numba.source(found, sizes, known, changing, straight)
    return text, numba.arguments(found)


@functools.cache
def compiled(module, stages, *outputs, **options):
    """The kernel of `derivations.<module>.<stages>()`, pruned to `outputs`."""
    from . import cache
    from .step import assemble

    def make():
        from importlib import import_module

        from .numpy import kernel

        within = import_module(f"..derivations.{module}", __package__)
        found = kernel(getattr(within, stages)(), *outputs, **options)
        return found.source, list(found.given)

    question = "numpy", module, stages, outputs, sorted(options.items())
    return assemble(*cache.derived(question, make))


def run(step, have):
    """Call a kernel with what it needs of the matrices in `have`, by name."""
    return step(**{name: have[name] for name in step.given})


def lowered(module, stages, outputs, **options):
    """`derivations.<module>.<stages>()` as steps that a printer writes out."""
    from importlib import import_module

    from .lowering import lower

    derivation = getattr(import_module(f"..derivations.{module}", __package__), stages)
    return lower(derivation(), outputs, **options)


def gain_step(*outputs):
    """Omega, M, K and the next error covariance: Leondes and Novak (27)-(33)."""
    return compiled("trace_minimisation", "gain_step", *outputs, flat=True)


def root(stages, *outputs):
    """The same in factors: "gain", "update", "error" or "decorrelation"."""
    return compiled("square_root", f"root_{stages}", *outputs, flat=True)


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


def padded(*outputs):
    """The matrices of the outputs that arrived, each in the place of its output."""
    return compiled("one_pass", "padded", *outputs, flat=True)


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


@functools.cache
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


def equivalent_noise(*outputs):
    """What a pair (A1, C1) of multiplicative noise adds to V1, V12, V2."""
    return compiled("projection_recursions", "equivalent_noise", *outputs, flat=True)


def output_moments(*outputs):
    """E[x y'], E[x+ y'], E[y y'] from the second moment Q1 of x."""
    return compiled("projection_recursions", "output_moments", *outputs, flat=True)


def estimator_moments(*outputs):
    """Right sides of the equations for Q12 and Q2: Haddad and Bernstein (4.6)."""
    return compiled("projection_recursions", "estimator_moments", *outputs, flat=True)


def adjoint_moments(*outputs):
    """Right sides of the equations for P2, P12 and P1: (4.7)."""
    return compiled("projection_recursions", "adjoint_moments", *outputs, flat=True)


def projection_cost(*outputs):
    """Error covariance of a fixed-order estimator, and J whose trace is its cost."""
    return compiled("projection_recursions", "projection_cost", *outputs, flat=True)


def projection_gradient(*outputs):
    """Gradients of the cost in Ae, Be, Ce, De: (4.8)-(4.11), unreduced."""
    return compiled("projection_recursions", "projection_gradient", *outputs, flat=True)


def best_output(*outputs):
    """CeDe = [Ce De], or Ce without feedthrough, of least cost for given Ae, Be."""
    return compiled("projection_recursions", "best_output", *outputs, flat=True)


def best_output_differential(*outputs):
    """How `best_output` moves with Q12 and Q2; many directions at a time."""
    return compiled("projection_recursions", "best_output_differential", *outputs)


def projection_differential(*outputs):
    """How moments and gradients move with the gains: exact second derivatives."""
    return compiled("projection_recursions", "projection_differential", *outputs)


def projection_innovation(*outputs):
    """Qs and V2s from the error covariance Q."""
    return compiled(
        "projection_equations", "projection_innovation", *outputs, flat=True
    )


def projection_factors(*outputs):
    """G, Gam, tau and Q of an estimator, from its moments: (3.8), (3.9)."""
    return compiled("projection_equations", "projection_factors", *outputs, flat=True)


def feedthrough_gain(*outputs):
    """De of the theorem: (3.13)."""
    return compiled("projection_equations", "feedthrough_gain", *outputs, flat=True)


def projection_gains(*outputs):
    """Ae, Be, Ce of the theorem: (3.10)-(3.12)."""
    return compiled("projection_equations", "projection_gains", *outputs, flat=True)


def projection_scripts(*outputs):
    """Qh and Ph of the theorem, from an estimator's Q2, P2, G, Gam."""
    return compiled("projection_equations", "projection_scripts", *outputs, flat=True)


def projection_equations(*outputs):
    """Residuals of the optimal projection equations: (3.14)-(3.17)."""
    return compiled("projection_equations", "projection_equations", *outputs, flat=True)


def projection_trace(*outputs):
    """J whose trace is the least cost: (3.18)."""
    return compiled("projection_equations", "projection_trace", *outputs, flat=True)


def innovations_plant(*outputs):
    """The Kalman predictor as a plant, on which costs are excesses."""
    return compiled("projection_equations", "innovations_plant", *outputs, flat=True)
