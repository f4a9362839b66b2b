"""Two stage lists that compute the same, in one assertion."""

from collections.abc import Mapping
from typing import Any

from .derivation import Derivation
from .deriving import Derived
from .proofs import Unproved
from .relations import named
from .typeset import text


def equivalent(
    fast: Derivation,
    slow: Derivation,
    *given: Any,
    same: Mapping[Any, Any] = {},
    says: str = "",
) -> tuple[Derived, ...]:
    """Prove that a stage list computes what another one does.

    Parameters
    ----------
    fast, slow : Derivation
        Stage lists.
    *given : Relation or Chain
        What is known of what they are given.
    same : dict of expression to expression, optional
        What of the fast one equals what of the slow one; by default every target that
        both assign.
    says : str, optional
        What is proved, in a few words; by default what the fast one does.

    Returns
    -------
    tuple of Chain
        One for each target, for a page to show: it begins with what the fast list
        computes and ends with what the slow one does, and cites what the proof needs.
        `.rests_on()` lists what that rests on.

    Raises
    ------
    Unproved
        One of them differs; the message names it and what is left over.
    ValueError
        A list fails, or no target is assigned by both.

    Examples
    --------
    >>> from sympy import symbols
    >>> from matrixproof import Derivation, Notation, Stage, equivalent
    >>> n = symbols("n", integer=True, positive=True)
    >>> letters = Notation()
    >>> A, B, S, X = (letters(x, n, n, f"the matrix {x}") for x in "ABSX")
    >>> is_S, is_X = letters.let(S, A + B), letters.let(X, A * A + A * B)
    >>> slow = Derivation((A, B), [Stage(X, A * A + A * B, by=[is_X])], says="two")
    >>> by = [is_S, is_X]
    >>> stages = [Stage(S, A + B, by=[is_S]), Stage(X, A * S, by=by)]
    >>> fast = Derivation((A, B), stages, says="one product")
    >>> print(*equivalent(fast, slow))
    one product
      A S
        = X  S = A + B, X = A A + A B  ✓
    """
    for one in (fast, slow):
        if wrong := one.check():
            raise ValueError(f"{one.says} fails: {wrong[0]}")
    theirs = {stage.target: stage for stage in slow.stages}
    ours = [stage for stage in fast.stages if stage.target not in theirs]
    put = {s.target: s.expression for s in fast.stages if s.target in theirs}
    pairs = same or {target: target for target in put}
    if not pairs:
        raise ValueError(
            f"no target of {fast.says} is one of {slow.says}: say what equals what, "
            "same={left: right}"
        )
    reasons = [r for stage in (*ours, *slow.stages) for r in stage.reasons]
    known = [getattr(x.letters, "symmetric", ()) for x in (fast, slow)]
    symmetric = tuple(dict.fromkeys(x for one in known for x in one))
    found = []
    for left, right in pairs.items():
        stage = theirs.get(right)
        number = stage.equation.strip("()") if stage else ""
        start = left
        for _ in put:
            start = start.xreplace(put)
        begun = Derived(number, says or fast.says, start, (), symmetric)
        try:
            found.append(begun.by(right, *dict.fromkeys((*reasons, *named(given)))))
        except Unproved as e:
            said = f"{text(right)} of {fast.says} is not that of {slow.says}: {e}"
            raise Unproved(said, e.left_over, e.complete, e.counterexample) from None
    return tuple(found)
