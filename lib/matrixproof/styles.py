"""What differs between an expression in LaTeX and in Unicode."""

from dataclasses import dataclass, replace

import sympy as sp

from .names import HIGH, latex_name, text_name


def apart(rows):
    """What stands between the entries of a row: wider where an entry has blanks."""
    return "  " if any(" " in cell for row in rows for cell in row) else " "


def with_caret(exponent):
    """An exponent that has no superscript of its own."""
    return f"^{exponent}" if exponent.isalnum() else f"^({exponent})"


@dataclass(frozen=True)
class Style:
    """What differs between the two ways of setting an expression."""

    name: object
    open: str
    close: str
    trace: str
    determinant: str
    series: object
    power: object
    fraction: object
    quotient: object
    root: object
    differential: str
    function: object
    tight: int  # how tightly the parts of a quotient and a root must hold together
    rows: object
    fallback: object


LATEX = Style(
    name=latex_name,
    open=r"\left(",
    close=r"\right)",
    trace=r"\operatorname{tr}",
    determinant=r"\det",
    series=lambda k, a, b, body: rf"\sum_{{{k}={a}}}^{{{b}}} {body}",
    power=lambda base, k: f"{base}^{{{k}}}",
    fraction=lambda p, q: rf"\tfrac{{{p}}}{{{q}}}",
    quotient=lambda above, below: rf"\frac{{{above}}}{{{below}}}",
    root=lambda inner: rf"\sqrt{{{inner}}}",
    differential=r"\mathrm{d}",
    function=lambda name: rf"\{name}" if hasattr(sp, name) else name,
    tight=0,
    rows=lambda rows: (
        r"\begin{bmatrix}"
        + r" \\ ".join(" & ".join(row) for row in rows)
        + r"\end{bmatrix}"
    ),
    fallback=sp.latex,
)
TEXT = Style(
    name=text_name,
    open="(",
    close=")",
    trace="tr",
    determinant="det",
    series=lambda k, a, b, body: f"Σ[{k} = {a} .. {b}] {body}",
    power=lambda base, k: (
        base + (k.translate(HIGH) if k.lstrip("-").isdigit() else with_caret(k))
    ),
    fraction=lambda p, q: f"{p}/{q}",
    quotient=lambda above, below: f"{above}/{below}",
    root=lambda inner: f"√{inner}",
    differential="d",
    function=str,
    tight=2,
    rows=lambda rows: "[" + "; ".join(apart(rows).join(row) for row in rows) + "]",
    fallback=str,
)


def slashed(style):
    """The same style for where a bar would be too small."""
    return replace(style, quotient=TEXT.quotient, tight=TEXT.tight)
