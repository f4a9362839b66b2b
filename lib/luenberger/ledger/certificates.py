"""Every claim of the library, with a certificate where it is about matrix symbols.

A claim about explicit matrices or scalars is evaluated, and has none.
"""

from collections.abc import Iterator
from importlib import import_module
from pkgutil import iter_modules
from typing import Any

from ..symbolic import Claim, Explicit
from ..symbolic.proofs import Proof
from .evidence import derivation, is_test, steps
from .records import PAPERS, entries

Key = tuple[str, str]  # where, name


def claims() -> dict[Key, Any]:
    """{(where, name): Claim} of every derivation and of the ledger's evidence.

    A claim that several derivations share is listed where it is found first.  A few
    steps are bare: a residual that is zero, without sides.
    """
    found: dict[Key, Any] = {}
    seen = set()
    for where, known in _listed():
        for name, claim in known.items():
            if isinstance(claim, Explicit):
                cases = claim.claims.items()
                found |= {(where, f"{name}, {case}"): one for case, one in cases}
            elif hasattr(claim, "check"):  # a chain: `check` has checked its proofs
                continue
            elif not isinstance(claim, Claim) or id(claim) not in seen:
                seen.add(id(claim))
                found[where, name] = claim
    return found


def _listed() -> Iterator[tuple[str, dict[str, Any]]]:
    for paper in PAPERS:
        package = f"luenberger.papers.{paper}.derivation"
        for module in iter_modules(import_module(package).__path__):
            if hasattr(import_module(f"{package}.{module.name}"), "derive"):
                name = f"{paper}.{module.name}"
                yield name, derivation(name).steps
    for entry in entries():
        for pointer in entry.evidence:
            if not is_test(pointer):
                yield pointer.partition(":")[0], steps(pointer)


def symbolic(claim: object) -> bool:
    """Whether a claim is about matrix symbols, and so proved rather than evaluated."""
    return getattr(claim, "algebra", None) is not None


def explicit() -> dict[Key, Any]:
    """The claims that are evaluated, not proved: {(where, name): Claim}."""
    return {key: claim for key, claim in claims().items() if not symbolic(claim)}


def certified() -> Iterator[tuple[Key, Proof]]:
    """Yield ((where, name), Proof) for each claim about matrix symbols.

    Raises
    ------
    Unproved
        A claim has no proof.

    Examples
    --------
    >>> from luenberger.ledger import certificates
    >>> key, proof = next(certificates.certified())
    >>> proof.check()
    True
    """
    for key, claim in claims().items():
        if symbolic(claim):
            yield key, claim.proof()
