"""Pages of derivations with one thing wrong: a stage, a definition, a reason."""

import dataclasses
from itertools import product

import sympy as sp
from damage import damaged_sides, fails
from worlds import one_wrong_sign

from matrixproof import Derivation, Explicit, Relation
from matrixproof.instances import Step
from matrixproof.relations import Result


def stage_lists(derivation):
    """The stage lists on a page."""
    return [item for item in derivation.page if isinstance(item, Derivation)]


def wrong_stages(derivation):
    """(what, the stage list with one wrong sign in it)."""
    for k, what, formula in one_wrong_sign(derivation.stages):
        stages = list(derivation.stages)
        stages[k] = dataclasses.replace(stages[k], formula=formula)
        yield what, dataclasses.replace(derivation, stages=tuple(stages))


def definitions(derivation):
    """What a page introduces or supposes."""
    return [item for item in derivation.page if isinstance(item, Relation)]


def wrong_definitions(derivation):
    """(what, its page) with one wrong sign in a definition, wherever it is cited."""
    for relation in definitions(derivation):
        for what, right in damaged_sides(relation.right):
            wrong = dataclasses.replace(relation, right=right)
            yield f"{relation.name}, {what}", cited_instead(derivation, relation, wrong)


def cited_instead(derivation, old, new):
    """(An item that cites a relation, with another in its place, and as it was)."""
    changed = []
    for item in derivation.page:
        if isinstance(item, Derivation):
            stages = tuple(with_reason(stage, old, new) for stage in item.stages)
            swapped = dataclasses.replace(item, stages=stages, steps={})
        elif hasattr(item, "lines"):
            swapped = with_lines(item, old, new)
        elif hasattr(item, "given"):
            swapped = with_reason(item, old, new, "given")
        elif hasattr(item, "satisfies"):
            swapped = with_reason(with_reason(item, old, new), old, new, "satisfies")
        else:
            continue
        if old in cited(item):
            changed.append((swapped, item))
    return changed


def with_lines(chain, old, new):
    """A chain that cites `new` for `old`, also where a theorem cites it before."""
    deeper = {
        r: with_lines(r.chain, old, new).relation
        for r in chain.relations
        if isinstance(r, Result) and isinstance(r.chain, Step)
    }
    lines = chain.lines
    for a, b in {**deeper, old: new}.items():
        lines = [with_reason(line, a, b) for line in lines]
    return dataclasses.replace(chain, lines=lines)


def cited(item):
    if isinstance(item, Derivation):
        return [r for stage in item.stages for r in stage.by]
    return item.relations


def with_reason(holder, old, new, field=None):
    """A line, stage or construction that cites `new` where it cited `old`."""
    fields = [field] if field else ["by", "moments"]
    for name in fields:
        cites = getattr(holder, name, None)
        if isinstance(cites, tuple) and old in cites:
            reasons = tuple(new if r == old else r for r in cites)
            holder = dataclasses.replace(holder, **{name: reasons})
    return holder


def idle_values(derivation):
    """Letters of explicit statements that could have other values unnoticed."""
    for item in derivation.page:
        if isinstance(item, Explicit):
            for symbol in next(iter(item.cases.values()), {}):
                if not any(map(fails, other_values(item, symbol))):
                    yield f"{item.says}: {symbol}"


def other_values(item, symbol):
    """An explicit statement with one entry one off, or with one number negated."""
    for name, chosen in item.cases.items():
        if not hasattr(symbol, "shape"):
            other = chosen | {symbol: -chosen[symbol] if chosen[symbol] != 0 else 1}
            yield dataclasses.replace(item, cases={name: other})
            continue
        matrix = sp.Matrix(chosen[symbol])
        for k, step in product(range(len(matrix)), (-1, 1)):
            wrong = matrix.copy()
            wrong[k] += step
            yield dataclasses.replace(item, cases={name: {**chosen, symbol: wrong}})
