"""Docstrings in Google style as Markdown."""

from __future__ import annotations

import inspect
import re
from dataclasses import dataclass, field

from equations import displayed, is_equation

SECTIONS = ("Args", "Attributes", "Example", "Raises", "Returns", "Yields")


@dataclass
class Docstring:
    """A docstring by its parts.

    Attributes:
        paragraphs: the text, its first line among it.
        sections: text of each section by its name.
    """

    paragraphs: list[str] = field(default_factory=list)
    sections: dict[str, str] = field(default_factory=dict)

    @classmethod
    def of(cls, thing: object) -> Docstring:
        """The docstring of a module, class or function."""
        text = inspect.getdoc(thing) or ""
        parts = re.split(rf"^({'|'.join(SECTIONS)}):\s*$", text, flags=re.M)
        sections = {
            name: inspect.cleandoc("\n" + body)
            for name, body in zip(parts[1::2], parts[2::2], strict=True)
        }
        paragraphs = [each for each in re.split(r"\n\s*\n", parts[0].rstrip()) if each.strip()]
        return cls(paragraphs, sections)

    @property
    def title(self) -> str:
        """First sentence without its full stop."""
        return plain(self.paragraphs[0]).rstrip(".") if self.paragraphs else ""

    def body(self) -> str:
        """All but the first sentence, in Markdown."""
        return "\n\n".join(block(each) for each in self.paragraphs[1:])

    def items(self, section: str) -> list[tuple[str, str]]:
        """Names and descriptions of a section, such as ``Args``."""
        found: list[tuple[str, str]] = []
        for line in self.sections.get(section, "").splitlines():
            start = re.match(r"(\w+): (.*)", line)
            if start:
                found.append((start[1], start[2]))
            elif found:
                name, text = found[-1]
                found[-1] = (name, f"{text} {line.strip()}")
        return found


def plain(text: str) -> str:
    """One line of text without Sphinx's roles."""
    text = re.sub(r":\w+:`~?([^`]*)`", lambda found: f"`{found[1].rpartition('.')[2]}`", text)
    return " ".join(text.replace("``", "`").split())


def inline(text: str) -> str:
    """Markdown of running text: code stays, what Markdown would take for a mark is escaped."""
    parts = re.split(r"(`[^`]*`)", plain(text))
    return "".join(
        part if part.startswith("`") else re.sub(r"([*_<\[\]|$])", r"\\\1", part) for part in parts
    )


def block(paragraph: str) -> str:
    """Markdown of one paragraph: an equation, a list, or text."""
    if is_equation(paragraph):
        return displayed(inspect.cleandoc("\n" + paragraph))
    listed = [each for each in re.split(r"(?m)^(?=(?:\d+\.|-) )", paragraph) if each.strip()]
    if re.match(r"(\d+\.|-) ", paragraph):
        return "\n".join(inline(each) for each in listed)
    return inline(paragraph)


def table(header: list[str], rows: list[list[str]]) -> str:
    """A table in Markdown."""
    lines = [header, ["---"] * len(header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)
