"""The recursions that run over a record: which stage lists, and what goes round.

A `Recursion` adds to a lowered program what a loop over time needs to know: what one
row hands to the next, what is read from the record's rows, what is written down.
"""

from dataclasses import dataclass, field

from ..numeric.factors import SAFE
from .lowering import lower
from .program import Factor, Program


@dataclass(frozen=True)
class Recursion:
    """A program that is run once for each row of a record.

    Attributes
    ----------
    name : str
        What it is, for the head of generated code.
    program : Program
    carried : dict of str to str
        Results by the given matrix that they are at the next row.
    rows : dict of str to (str, int)
        Given vectors, as an array of the record and the row in it, k or k + 1.
    before : tuple of str
        Given matrices that belong to the instant before.
    written : tuple of (str, str, str)
        Output array, result, and "vector", "diagonal" or "matrix"; matrices are
        written only where a history is kept.
    """

    name: str
    program: Program
    carried: dict
    rows: dict
    written: tuple
    before: tuple = ()
    matrices: tuple = field(init=False)

    def __post_init__(self):
        given = self.program.given
        known = set(self.carried.values()) | set(self.rows)
        matrices = tuple(name for name in given if name not in known)
        object.__setattr__(self, "matrices", matrices)


def filter_recursion(zero=()):
    """The filter and its covariance; `zero` names matrices that vanish."""
    from ..papers.leondes_novak.derivation.one_pass import filter_step

    carried = {"Sigma_next": "Sigma", "x_next": "x"}
    if "J" not in zero:
        carried["rho_next"] = "rho"
    program = lower(
        filter_step(),
        [*carried, "K"],
        zero=zero,
        symmetric=("Q", "R", "Sigma"),
        definite=[Factor("Sigma_next", SAFE, "Omega")],
        same=[("As", "A")] if "J" in zero else (),
    )
    return Recursion(
        "filter_step",
        program,
        carried,
        {"y": ("y", 0), "u": ("u", 0), "u_next": ("u", 1)},
        (
            ("xs", "x_next", "vector"),
            ("variances", "Sigma_next", "diagonal"),
            ("covariances", "Sigma_next", "matrix"),
            ("gains", "K", "matrix"),
        ),
        before=("A", "As", "Q", "B", "J"),
    )


def observer_recursion(zero=()):
    """Any observer; `zero` names matrices that vanish."""
    from ..papers.leondes_novak.derivation.one_pass import observer_step

    program = lower(observer_step(), ["z_next", "w_hat"], zero=zero)
    return Recursion(
        "observer_step",
        program,
        {"z_next": "z"},
        {"y": ("y", 0), "u": ("u", 0)},
        (("w_hats", "w_hat", "vector"),),
    )


def side_by_side_recursion(zero=()):
    """Plant and observer side by side; `zero` names matrices that vanish."""
    from ..papers.leondes_novak.derivation.side_by_side import side_by_side

    return Recursion(
        "side_by_side",
        lower(side_by_side(), ["x_next", "z_next", "e"], zero=zero),
        {"x_next": "x", "z_next": "z"},
        {"xi": ("xi", 0)},
        (("es", "e", "vector"),),
    )
