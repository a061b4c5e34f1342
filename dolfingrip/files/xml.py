"""Elements of XML whose attributes are numbers."""

from __future__ import annotations

from typing import Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, SubElement

import numpy as np


def add(parent: Element, tag: str, **attributes: Any) -> Element:
    """Add an element to another one.

    Args:
        parent: that it is added to.
        tag: its name.
        attributes: texts, or numbers and arrays of them, which are written with eight digits.

    Returns:
        The new element.
    """
    return SubElement(parent, tag, {key: _text(value) for key, value in attributes.items()})


def _text(value: Any) -> str:
    if isinstance(value, str):
        return value
    return " ".join(f"{each:.8g}" for each in np.ravel(value))


def text(root: Element) -> str:
    """Return an element as indented text.

    Args:
        root: the outermost one.
    """
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"
