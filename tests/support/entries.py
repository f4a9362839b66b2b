"""An entry of the ledger beside its evidence: what it says must be what is proved.

Every equation in an entry's words stands in its evidence: as a line, as two lines of
one chain, as a reason that is cited, as a statement that is evaluated.  Every pointer
is needed for one of them.
"""

import re
from functools import cache
from itertools import combinations

import sympy as sp
from formulas import equation, letters, parts, side

from luenberger.ledger import OURS, evidence
from matrixproof import (
    AtLeast,
    AtMost,
    Chain,
    Claim,
    Construction,
    Counterexample,
    Derivation,
    Explicit,
    text,
)
from matrixproof.equivalences import Equation
from matrixproof.operators import Operator
from matrixproof.prose import FORMULA, as_text
from matrixproof.relations import Result


def lines(chain):
    """Every equation, or inequality, between two lines of a chain, and its reasons."""
    if isinstance(chain.left, Equation):
        sides = [chain.left, *(line.right for line in chain.lines)]
        return [parts(side.show(text))[0] for side in sides]
    runs, signs = [[text(chain.left)]], []  # lines that are equal; what is between
    for line in chain.lines:
        if isinstance(line, Operator):
            signs.append(line.marks(text))
            runs.append([text(line.right)])
        elif isinstance(line, AtLeast):
            signs.append("≤" if isinstance(line, AtMost) else "≥")
            runs.append([text(line.right)])
        else:
            runs[-1].append(text(line.right))
    found = [(a, "=", b) for run in runs for a, b in combinations(run, 2)]
    for k, sign in enumerate(signs):
        for a in runs[k]:
            for b in runs[k + 1]:
                if isinstance(sign, tuple):
                    found.append((f"{sign[0]}[{a}]{sign[1]}", "=", b))
                else:
                    found.append((a, sign, b))
    if set(signs) <= {"≥"} or set(signs) <= {"≤"}:
        found += [
            (a, signs[0], b)
            for j, k in combinations(range(len(runs)), 2)
            for a in runs[j]
            for b in runs[k]
        ]
    return found


def cited(step):
    """(an equation, its name, whether it is supposed) of what a step rests on."""
    values = step._shown if isinstance(step, Explicit) else {}
    yield from (((text(s), "=", text(v)), "", True) for s, v in values.items())
    for relation in getattr(step, "relations", ()):
        own = not isinstance(relation, Result)  # else another chain has proved it
        name = relation.name if own else ""
        yield parts(relation.show(text))[0], name, own


def stated(step):
    """The equations that a step establishes itself."""
    if isinstance(step, Chain):
        return lines(step)
    if isinstance(step, Counterexample):
        return [(text(step.left), "≠", text(step.right))]
    if isinstance(step, Explicit):
        return [(text(step.left), step.sign, text(step.right))]
    if isinstance(step, Construction):
        values = [(text(s), "=", text(v)) for s, v in step.values.items()]
        return [*values, *(parts(r.show(text))[0] for r in step.satisfies)]
    if isinstance(step, Derivation):
        return [parts(stage.shown(text))[0] for stage in step.stages]
    assert isinstance(step, Claim), step
    return [parts(f"{step} ")[0]]


# -- what an entry says ----------------------------------------------------------------


def formulas(entry):
    """The formulas in an entry's words, as a terminal shows them."""
    return [as_text(source) for source in FORMULA.findall(entry.says.source)]


def equations(entry):
    """The equations among them, as they are printed."""
    return [part for formula in formulas(entry) for part in parts(formula)]


def expressions(entry, there):
    """The formulas without a sign that are more than a name, a product or a size."""
    sizes = set().union(*(p.sizes for p in there.values()))
    return [
        formula
        for formula in formulas(entry)
        if not parts(formula)
        and re.search(r"[(+]| - ", formula)
        and letters(formula) - sizes
    ]


class Evidence:
    """What one pointer leads to: equations by what they are, and letters."""

    def __init__(self, pointer):
        self.steps = list(evidence.steps(pointer).values())
        notation = evidence.derivation(pointer.partition(": ")[0]).letters
        self.symmetric = [text(s) for s in getattr(notation, "symmetric", ())]
        # an equation: the numbers under which it is supposed, and proved
        self.introduced, self.cited, self.proved = {}, {}, {}
        self.sizes, self.sides = sizes(notation), set()
        self.letters = set(self.sizes)
        for step in self.steps:
            for part, name, own in cited(step):
                self.note(self.introduced if own else self.cited, part, name)
            for part in stated(step):
                self.note(self.proved, part, f"({getattr(step, 'number', '')})")
            if isinstance(step, Chain) and not isinstance(step.left, Equation):
                shown = (step.left, *(line.right for line in step.lines))
                self.sides |= {side(text(x), self.symmetric) for x in shown}

    def note(self, group, part, name):
        says, names = equation(*part, symmetric=self.symmetric)
        for known in (self.introduced, self.cited):  # no step proves what it cites
            group = known if says in known else group
        group.setdefault(says, set()).update(numbers(name))
        self.letters |= names

    def numbers(self, part):
        """The numbers that an equation stands under."""
        says, _ = equation(*part, symmetric=self.symmetric)
        groups = (self.introduced, self.cited, self.proved)
        return set().union(*(group.get(says, ()) for group in groups))

    def has(self, formula):
        """Whether an expression stands in a chain."""
        return side(formula, self.symmetric) in self.sides

    def shows(self, part):
        """2 if it proves an equation, 1 if it rests on it, otherwise 0."""
        says, _ = equation(*part, symmetric=self.symmetric)
        return 2 * (says in self.proved) or int(says in self.introduced)


def sizes(notation):
    """The sizes of the letters, by name."""
    letters = getattr(notation, "meaning", ())
    shapes = (k for s in letters for k in getattr(s, "shape", ()))
    return {str(x) for k in shapes for x in sp.sympify(k).free_symbols}


@cache
def found(pointer):
    return Evidence(pointer)


def numbers(name):
    """The equation numbers at the beginning of a name.

    >>> sorted(numbers("(41–43, 3.10') the estimate"))
    ["3.10'", '41', '42', '43']
    """
    listed = re.match(r"\(((?:[^()]|\(\w\))*)\)('?)", name)
    if not listed:
        return set()
    all_of = set()
    for one in re.split(r", ?", listed[1] + listed[2]):
        ends = re.fullmatch(r"(\d+)[–-](\d+)", one)
        span = range(int(ends[1]), int(ends[2]) + 1) if ends else [one]
        all_of |= set(map(str, span))
    return all_of


def number_of(entry):
    """How steps refer to an entry: "(33)" as 33, "2: V2s" as section 2, ours not."""
    if entry.paper == OURS:
        return ""
    number, _, more = entry.number.partition(": ")
    if number.startswith("remark"):
        return number
    return f"section {number}" if number == "2" else re.sub(r"[()]", "", number)


def proofs(entry):
    return [p for p in entry.evidence if not evidence.is_test(p)]


def complaints(entry):
    """What an entry says, or is said to be, and is not."""
    outside = FORMULA.sub("", entry.says.source)
    if set("=_^\\*~|<>") & set(outside):
        return [f"mathematics in plain text: {outside}"]
    if not proofs(entry):
        return []
    there = {pointer: found(pointer) for pointer in proofs(entry)}
    checks = (unsaid, unneeded, wrong_kind, wrong_level)
    return [complaint for check in checks for complaint in check(entry, there)]


def unsaid(entry, there):
    """What an entry says and its evidence does not."""
    pointers, said = there.values(), equations(entry)
    if not said:
        yield "it says no equation"
    letters_there = set().union(*(p.letters for p in pointers))
    for formula in formulas(entry):
        strange = letters(formula) - letters_there
        if strange:
            yield f"no evidence for {formula} has {', '.join(sorted(strange))}"
    for part in said:
        if not any(p.shows(part) for p in pointers):
            yield f"no evidence shows {' '.join(part)}"
    for formula in expressions(entry, there):
        if not any(p.has(formula) for p in pointers):
            yield f"no evidence has {formula}"
    wanted = number_of(entry)
    under = (p.numbers(part) for part in said for p in pointers)
    if wanted and not any(wanted in found for found in under):
        yield f"nothing that it says stands under {wanted}"


def unneeded(entry, there):
    """Pointers without which all is shown as well."""
    for pointer, p in there.items():
        others = [q for other, q in there.items() if other != pointer]
        best = ((p.shows(x), *(q.shows(x) for q in others)) for x in equations(entry))
        needed = any(mine > max(rest, default=0) for mine, *rest in best)
        if not needed and not any(map(p.has, expressions(entry, there))):
            yield f"it says nothing for which {pointer} is needed"


def wrong_kind(entry, there):
    """A definition gives a letter; a claim or an algorithm is proved, and none."""
    shown = [(p.shows(x), x[0]) for x in equations(entry) for p in there.values()]
    given = any(k == 1 or k and re.fullmatch(r"\w+", left) for k, left in shown)
    if entry.kind == "definition" and not given:
        yield "nothing that it says is a definition of its evidence"
    done = any(k == 2 for k, _ in shown) or expressions(entry, there)
    if entry.kind in ("claim", "algorithm") and not done:
        yield "nothing that it says is proved"


def wrong_level(entry, there):
    proved_part = entry.level
    if len(there) < len(entry.evidence):  # tests besides
        proved_part = entry.level.partition("; ")[0]
    if proved_part != level(entry):
        yield f"its level is: {level(entry)}"


def level(entry):
    """How well an entry is established, from its evidence."""
    steps = [step for p in proofs(entry) for step in found(p).steps]
    explicit = [step for step in steps if not symbolic(step)]
    named = (name for step in explicit for name in getattr(step, "cases", {}) if name)
    cases = list(dict.fromkeys(named))
    parts = ["at symbolic sizes"] if len(explicit) < len(steps) else []
    if cases:
        names = f"{len(cases)} cases from {cases[0]} to {cases[-1]}"
        names = names if len(cases) > 2 else " and ".join(cases)
        parts.append(f"at {names}")
    elif explicit:
        parts.append("for all values of the symbols")
    return "proved " + ", and ".join(parts)


def symbolic(step):
    """Whether a step is about matrices of any size."""
    if isinstance(step, Explicit):
        return False
    return hasattr(step, "check") or step.algebra is not None
