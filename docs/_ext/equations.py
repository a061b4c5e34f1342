"""Equations of docstrings, which are written in Unicode, as TeX."""

from __future__ import annotations

import re
import unicodedata

RAISED = "⁰¹²³⁴⁵⁶⁷⁸⁹⁻⁺ᵀᵃᵇᶜᵈᵉᶠⁱʲᵏˡᵐⁿᵒᵖʳˢᵗᵘᵛʷˣʸᶻ"
LOWERED = "₀₁₂₃₄₅₆₇₈₉₋₊ₐₑᵢⱼₖₗₘₙₒₚᵣₛₜᵤᵥₓ"
ACCENTS = {"\u0304": "bar", "\u0302": "hat", "\u0307": "dot", "\u0303": "tilde"}
SYMBOLS = {
    "−": "-",
    "·": r"\cdot ",
    "×": r"\times ",
    "⊗": r"\otimes ",
    "→": r"\to ",
    "←": r"\leftarrow ",
    "≤": r"\le ",
    "≥": r"\ge ",
    "∫": r"\int ",
    "Σ": r"\sum ",
    "∂": r"\partial ",
    "∇": r"\nabla ",
    "∞": r"\infty ",
    "√": r"\sqrt ",
    "½": r"\tfrac12 ",
    "⅓": r"\tfrac13 ",
    "⅔": r"\tfrac23 ",
    "¼": r"\tfrac14 ",
    "|": r"\vert ",
    "…": r"\ldots ",
    "°": r"{}^\circ ",
    "%": r"\%",
    "#": r"\#",
}
OPERATORS = ("ln", "exp", "det", "min", "max", "sin", "cos", "arctan", "erf", "tr", "cof", "sym")
EVERYDAY = {"a", "is", "in", "of", "to", "if", "at", "by", "on"}


def is_equation(paragraph: str) -> bool:
    """Whether a paragraph of a docstring is a displayed equation: ``ψ = …`` and no sentence."""
    if " = " not in paragraph and "≤" not in paragraph and "←" not in paragraph:
        return False
    bare = re.sub(r"[ ,;.]*$", "", paragraph.strip())
    words = re.findall(r"(?<![A-Za-z_])[A-Za-z]{3,}(?![A-Za-z_(])", bare)
    return len([word for word in words if word not in OPERATORS]) <= len(bare.splitlines())


def to_tex(text: str) -> str:
    """TeX of one line of an equation.

    Example:
        >>> to_tex("ψ = μ/2 (Ī₁ − 3)²")
        'ψ = μ/2 (\\\\bar{I}_{1} - 3)^{2}'
    """
    text = re.sub(r"`+", "", text)
    text = unicodedata.normalize("NFD", text)
    text = re.sub(
        r"(.)([\u0304\u0302\u0307\u0303])",
        lambda found: rf"\{ACCENTS[found[2]]}{{{found[1]}}}",
        text,
    )
    text = re.sub(
        rf"[{RAISED}]+", lambda found: f"^{{{unicodedata.normalize('NFKC', found[0])}}}", text
    )
    text = re.sub(
        rf"[{LOWERED}]+", lambda found: f"_{{{unicodedata.normalize('NFKC', found[0])}}}", text
    )
    text = re.sub(r"\^\(([^()]*)\)", r"^{\1}", text)
    text = re.sub(r"\^([^\W\d_](?:_\w+)?)", r"^{\1}", text)
    text = re.sub(r"_([A-Za-z0-9]{2,})", r"_{\1}", text)
    text = re.sub(r"√\(([^()]*)\)", r"\\sqrt{\1}", text)
    text = re.sub(r"√([^\s(){}]+)", r"\\sqrt{\1}", text)
    for symbol, tex in SYMBOLS.items():
        text = text.replace(symbol, tex)
    names = "|".join(OPERATORS)
    text = re.sub(rf"(?<![A-Za-z\\])({names})(?![A-Za-z])", r"\\operatorname{\1}", text)
    text = re.sub(
        r"(?<![A-Za-z\\{_^])([A-Za-z]{3,}|(?:is|in|of|to|if|at|by|on))(?![A-Za-z}])",
        lambda found: rf"\text{{ {found[1]} }}",
        text,
    )
    return re.sub(r" {3,}", r" \\qquad ", text.strip())


LONGEST = 50
"""Characters of a displayed line; equations that stand side by side in a longer one are stacked."""


def displayed(paragraph: str) -> str:
    """A displayed equation in Markdown, of one line or several."""
    lines = []
    for line in paragraph.strip().splitlines():
        parts = re.split(r" {3,}", line.strip()) if len(line) > LONGEST else [line]
        lines += [to_tex(part) for part in parts]
    body = lines[0] if len(lines) == 1 else "\\begin{gathered}\n" + " \\\\\n".join(lines)
    end = "" if len(lines) == 1 else "\n\\end{gathered}"
    return f"$$\n{body}{end}\n$$"
