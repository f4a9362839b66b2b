"""Derivation -> callable.  The only place that turns symbols into code.

Each function compiles one stage list at its first call and returns the same callable
afterwards.  Deriving the text takes a few tenths of a second, SymPy's import included,
so `cache` keeps it for the next process.

What writes code from a stage list enters here, nothing that knows a plant.  It uses
`symbolic`, `numeric`, and the stage lists of the papers' derivations.
"""

import functools
from importlib.util import find_spec

from .inputs import entries_known as entries_known
from .inputs import plain_array as plain_array

AUTO_ROWS = 20_000  # NumPy takes about as long for these as compiling the first time
OPTIONAL = ("B", "E", "Gamma", "J", "G", "W")  # whose terms go if they are zero
UNROLLED = 1000  # operations of one row; more are faster and sooner compiled as loops
# where the stage lists are: paper.module, in its room's `derivation`
STAGES = "leondes_novak.stages"
MOMENTS = "haddad_bernstein.moment_stages"
THEOREM = "haddad_bernstein.theorem_stages"


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
    """The kernel of `<paper.module>.<stages>()`, pruned to `outputs`."""
    from . import cache
    from .step import assemble

    def make():
        from .numpy import kernel

        found = kernel(_derived(module, stages), *outputs, **options)
        return found.source, list(found.given)

    question = "numpy", module, stages, outputs, sorted(options.items())
    return assemble(*cache.derived(question, make))


def run(step, have):
    """Call a kernel with what it needs of the matrices in `have`, by name."""
    return step(**{name: have[name] for name in step.given})


def lowered(module, stages, outputs, **options):
    """`<paper.module>.<stages>()` as steps that a printer writes out."""
    from .lowering import lower

    return lower(_derived(module, stages), outputs, **options)


def _derived(module, stages):
    """A stage list by the paper, the module of its derivation, and its name."""
    from importlib import import_module

    paper, _, name = module.partition(".")
    module = import_module(f"..papers.{paper}.derivation.{name}", __package__)
    return getattr(module, stages)()


def gain_step(*outputs):
    """Omega, M, K and the next error covariance: Leondes and Novak (27)-(33)."""
    return compiled(STAGES, "gain_step", *outputs, flat=True)


def root(stages, *outputs):
    """The same in factors: "gain", "update", "error" or "decorrelation"."""
    return compiled("leondes_novak.square_root", f"root_{stages}", *outputs, flat=True)


def estimate_step(*outputs):
    """One step of the estimate, from x_i and y_{i+1} to x_{i+1}: Fig. 1, (43)."""
    return compiled(STAGES, "estimate_step", *outputs, flat=True)


def step_differential(*outputs):
    """How the next covariance moves with Omega; Newton's method needs it."""
    return compiled(STAGES, "step_differential", *outputs)


def steady_gradient(*outputs):
    """Gradient of the steady error trace with respect to a constant gain."""
    return compiled(STAGES, "steady_gradient", *outputs, flat=True)


def observer_matrices(*outputs):
    """F, G, D, T, W of the observer that a gain defines: (10), (14), (15), (25)."""
    return compiled(STAGES, "observer", *outputs)


def padded(*outputs):
    """The matrices of the outputs that arrived, each in the place of its output."""
    return compiled("leondes_novak.one_pass", "padded", *outputs, flat=True)


def decorrelation(*outputs):
    """The plant whose two noises are uncorrelated, from one with S."""
    return compiled(STAGES, "decorrelation", *outputs, flat=True)


def error_recursion(*outputs):
    """Covariance of the error of any observer, one step: (11), (26), (28)."""
    return compiled(STAGES, "error_recursion", *outputs, flat=True)


def functional_row(*outputs):
    """The next row of T from the one above, in companion form: Moore (5)."""
    return compiled("moore.observer", "companion_row", *outputs)


def functional_input(*outputs):
    """G of an observer without feedthrough: Moore (6)."""
    return compiled("moore.observer", "observer", *outputs)


@functools.cache
def sampling_law(name, coefficient):
    """A law of Hsia's Table II without bounds: f(rho, T_max, `coefficient`)."""
    from ..papers.hsia.derivation import laws as adaptive_sampling
    from .scalar import function

    return function(
        adaptive_sampling.derive(),
        adaptive_sampling.key(name),
        *("rho", "T_max", coefficient),
    )


def noise_of_a_period(*outputs):
    """Covariance of the noise of one period from Van Loan's exponential."""
    return compiled("hsia.laws", "noise_of_a_period", *outputs, flat=True)


def noise_doubled(*outputs):
    """The same of a period twice as long."""
    return compiled("hsia.laws", "noise_doubled", *outputs, flat=True)


def equivalent_noise(*outputs):
    """What a pair (A1, C1) of multiplicative noise adds to V1, V12, V2."""
    return compiled(MOMENTS, "equivalent_noise", *outputs, flat=True)


def output_moments(*outputs):
    """E[x y'], E[x+ y'], E[y y'] from the second moment Q1 of x."""
    return compiled(MOMENTS, "output_moments", *outputs, flat=True)


def estimator_moments(*outputs):
    """Right sides of the equations for Q12 and Q2: Haddad and Bernstein (4.6)."""
    return compiled(MOMENTS, "estimator_moments", *outputs, flat=True)


def adjoint_moments(*outputs):
    """Right sides of the equations for P2, P12 and P1: (4.7)."""
    return compiled(MOMENTS, "adjoint_moments", *outputs, flat=True)


def projection_cost(*outputs):
    """Error covariance of a fixed-order estimator, and J whose trace is its cost."""
    return compiled(MOMENTS, "projection_cost", *outputs, flat=True)


def projection_gradient(*outputs):
    """Gradients of the cost in Ae, Be, Ce, De: (4.8)-(4.11), unreduced."""
    return compiled(MOMENTS, "projection_gradient", *outputs, flat=True)


def best_output(*outputs):
    """CeDe = [Ce De], or Ce without feedthrough, of least cost for given Ae, Be."""
    return compiled(MOMENTS, "best_output", *outputs, flat=True)


def best_output_differential(*outputs):
    """How `best_output` moves with Q12 and Q2; many directions at a time."""
    return compiled(MOMENTS, "best_output_differential", *outputs)


def projection_differential(*outputs):
    """How moments and gradients move with the gains: exact second derivatives."""
    return compiled(MOMENTS, "projection_differential", *outputs)


def projection_innovation(*outputs):
    """Qs and V2s from the error covariance Q."""
    return compiled(THEOREM, "projection_innovation", *outputs, flat=True)


def projection_factors(*outputs):
    """G, Gam, tau and Q of an estimator, from its moments: (3.8), (3.9)."""
    return compiled(THEOREM, "projection_factors", *outputs, flat=True)


def feedthrough_gain(*outputs):
    """De of the theorem: (3.13)."""
    return compiled(THEOREM, "feedthrough_gain", *outputs, flat=True)


def projection_gains(*outputs):
    """Ae, Be, Ce of the theorem: (3.10)-(3.12)."""
    return compiled(THEOREM, "projection_gains", *outputs, flat=True)


def projection_scripts(*outputs):
    """Qh and Ph of the theorem, from an estimator's Q2, P2, G, Gam."""
    return compiled(THEOREM, "projection_scripts", *outputs, flat=True)


def projection_equations(*outputs):
    """Residuals of the optimal projection equations: (3.14)-(3.17)."""
    return compiled(THEOREM, "projection_equations", *outputs, flat=True)


def projection_trace(*outputs):
    """J whose trace is the least cost: (3.18)."""
    return compiled(THEOREM, "projection_trace", *outputs, flat=True)


def innovations_plant(*outputs):
    """The Kalman predictor as a plant, on which costs are excesses."""
    return compiled(THEOREM, "innovations_plant", *outputs, flat=True)
