"""Names of symbols as they stand on a page: accents, subscripts, Greek letters.

``z_next`` is z with a plus below, ``w_hat`` has a hat, ``K_mv`` an upright mv below,
``Omega`` is Greek.  `parsed` takes a name apart; `latex_name` and `text_name` put it
together again, typeset or in Unicode.
"""

import re
import unicodedata
from dataclasses import dataclass
from functools import cache

SMALL = "alpha beta gamma delta zeta eta theta kappa lambda mu nu xi pi rho sigma tau"
SMALL += " phi chi psi omega varepsilon"
LARGE = "Gamma Delta Theta Lambda Xi Pi Sigma Phi Psi Omega"
GREEK = dict(zip(SMALL.split(), "αβγδζηθκλμνξπρστφχψωε"))
GREEK |= dict(zip(LARGE.split(), "ΓΔΘΛΞΠΣΦΨΩ"))
SHORT = {"eps": "varepsilon", "epsilon": "varepsilon", "Gam": "Gamma", "Lam": "Lambda"}
SHORT |= {"lamda": "lambda"}  # which Python keeps for itself
BACK = {glyph: name for name, glyph in GREEK.items()}
ACCENTS = {"hat": "\u0302", "tilde": "\u0303", "bar": "\u0304"}
ACCENTS |= {"ddot": "\u0308", "dot": "\u0307"}
BELOW = {"next": "+", "plus": "+", "minus": "-", "perp": "⊥"}
ABOVE = {"star": "*", "sharp": "#"}
LOW = str.maketrans("0123456789+-", "₀₁₂₃₄₅₆₇₈₉₊₋")
HIGH = str.maketrans("0123456789+-", "⁰¹²³⁴⁵⁶⁷⁸⁹⁺⁻")


@dataclass(frozen=True)
class Name:
    """A letter or word, with what stands over, below and above it."""

    base: str
    accent: str = ""
    below: tuple = ()
    above: str = ""
    differential: bool = False


@cache
def parsed(name):
    """Take a symbol's name apart.

    >>> parsed("z_next")
    Name(base='z', accent='', below=('+',), above='', differential=False)
    >>> parsed("Vhat_1").accent, parsed("V2s").below, parsed("dOmega").differential
    ('hat', ('2s',), True)
    """
    name, above = re.fullmatch(r"(.+?)((?:\^.+)|\*|(?<!_)\+)?", name).groups()
    head, *parts = name.split("_")
    base, accent, below, differential = core(head)
    below, above = list(below), (above or "").lstrip("^")
    for part in filter(None, parts):
        if part in ACCENTS:
            accent = part
        elif part in ABOVE:
            above += ABOVE[part]
        else:
            below.append(BELOW.get(part, part))
    return Name(base, accent, tuple(below), above, differential)


def core(head):
    """What precedes the first underscore: base, accent, what is below, differential."""
    head = SHORT.get(BACK.get(head, head), BACK.get(head, head))
    if len(head) == 1 or head in GREEK:
        return head, "", (), False
    if re.fullmatch(r"d([A-Z].*|[A-Za-z]{3,})", head) and core(head[1:])[0] != head[1:]:
        return *core(head[1:])[:3], True
    for accent in ACCENTS:
        if head.endswith(accent) and head != accent:
            base, _, below, moved = core(head.removesuffix(accent))
            return base, accent, below, moved
    if re.fullmatch(r"d[A-Z]", head) or (head[0] == "d" and head[1:] in GREEK):
        return head[1:], "", (), True
    if re.fullmatch(r"[A-Z]h", head):
        return head[0], "hat", (), False
    if re.fullmatch(r"[a-ce-z]t", head):
        return head[0], "tilde", (), False
    for letter in sorted((*GREEK, *SHORT), key=len, reverse=True):
        rest = head.removeprefix(letter)
        if rest != head and rest.isdigit():
            return SHORT.get(letter, letter), "", (rest,), False
    split = re.fullmatch(r"([A-Za-z])(\d\w*)|([A-Z])([a-z]{1,2})", head)
    if split:
        base, below = (g for g in split.groups() if g)
        return base, "", (below,), False
    return head, "", (), False


def gradient(name):
    """The d of a differential or nothing, and the symbol in which a gradient is.

    >>> gradient("dgradAe"), gradient("gradual")
    (('d', 'Ae'), None)
    """
    found = re.fullmatch(r"(d?)grad([A-Z]\w*)", name)
    return found and found.groups()


# -- LaTeX --------------------------------------------------------------------------


def latex_name(name):
    r"""A symbol's name in LaTeX.

    >>> print(latex_name("w_hat"), latex_name("K_mv"), latex_name("dM_1"))
    \hat w K_{\mathrm{mv}} \mathrm{d}M_{1}
    >>> print(latex_name("Qhat"), latex_name("X+"), latex_name("As"), latex_name("eps"))
    \hat Q X^{+} A_{s} \varepsilon
    >>> print(latex_name("tau_perp"), latex_name("gradAe"), latex_name("M_tau_sharp"))
    \tau_{\perp} \nabla_{A_{e}} M_{\tau}^{\#}
    >>> print(latex_name("H_eps"), latex_name("sigma_xdot"))
    H_{\varepsilon} \sigma_{\dot x}
    """
    if slope := gradient(name):
        moved = r"\mathrm{d}" if slope[0] else ""
        return rf"{moved}\nabla_{{{latex_name(slope[1])}}}"
    p = parsed(name)
    base = latex_piece(p.base)
    if p.accent:
        wide = base.startswith(r"\mathrm")
        base = rf"\{p.accent}{{{base}}}" if wide else rf"\{p.accent} {base}"
    below = ",".join(map(latex_piece, p.below))
    above = p.above.replace("#", r"\#")
    return (
        (r"\mathrm{d}" if p.differential else "")
        + base
        + (f"_{{{below}}}" if below else "")
        + (f"^{{{above}}}" if above else "")
    )


def latex_piece(piece):
    """A letter in italics, a Greek one by its command, a word upright."""
    piece = SHORT.get(piece, piece)
    if dotted := re.fullmatch(r"([a-z])(d?dot)", piece):
        return rf"\{dotted[2]} {dotted[1]}"
    if piece in GREEK:
        return rf"\{piece}"
    if piece == "⊥":
        return r"\perp"
    index = re.fullmatch("[u-z]+|[i-l]+", piece)
    word = re.fullmatch(r"[A-Za-z]{2,}", piece) and not index
    return rf"\mathrm{{{piece}}}" if word else piece


# -- Unicode ------------------------------------------------------------------------


def text_name(name):
    """A symbol's name in Unicode; a subscript of letters keeps its underscore.

    >>> print(text_name("w_hat"), text_name("z_next"), text_name("K_mv"))
    ŵ z₊ K_mv
    >>> print(text_name("Omega_21"), text_name("R^-1"), text_name("sigma_xdot"))
    Ω₂₁ R⁻¹ σ_ẋ
    >>> print(text_name("tau_perp"), text_name("gradAe"))
    τ_⊥ ∇A_e
    """
    if slope := gradient(name):
        return f"{slope[0]}∇{text_name(slope[1])}"
    p = parsed(name)
    base = GREEK.get(p.base, p.base)
    if p.accent:
        base = unicodedata.normalize("NFC", base[0] + ACCENTS[p.accent]) + base[1:]
    below = "".join(
        b.translate(LOW) if re.fullmatch(r"[\d+-]+", b) else "_" + text_piece(b)
        for b in p.below
    )
    above = "^" + p.above if p.above[:1].isalpha() else p.above.translate(HIGH)
    return ("d" if p.differential else "") + base + below + above


def text_piece(piece):
    """A Greek letter, a letter with dots, or a word as it stands."""
    piece = SHORT.get(piece, piece)
    dotted = re.fullmatch(r"([a-z])(d?dot)", piece)
    if dotted:
        return unicodedata.normalize("NFC", dotted[1] + ACCENTS[dotted[2]])
    return GREEK.get(piece, piece)
