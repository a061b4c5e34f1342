"""XML that is written, whose attributes are numbers, and XML of others that is read.

What others wrote may declare no document type: entities, which stand there, name files of the one
who reads, or repeat themselves until memory is full. No format of meshes or tables needs one.
"""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from typing import IO, Any
from xml.etree import ElementTree
from xml.etree.ElementTree import Element, ParseError, SubElement

import numpy as np
from defusedxml import DefusedXmlException
from defusedxml.ElementTree import fromstring, iterparse


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
    return " ".join(f"{number:.8g}" for number in np.ravel(value))


def text(root: Element) -> str:
    """Return an element as indented text.

    Args:
        root: the outermost one.
    """
    ElementTree.indent(root)
    return ElementTree.tostring(root, encoding="unicode") + "\n"


class XmlError(ValueError):
    """One line about XML that cannot be read."""


class DocumentTypeError(XmlError):
    """One line about XML that declares a document type."""


def parse(content: bytes) -> Element:
    """Parse what others wrote.

    Args:
        content: of the file.

    Returns:
        The outermost element.

    Raises:
        XmlError: one line.
    """
    with _refused():
        root: Element = fromstring(content, forbid_dtd=True)
    return root


def elements(stream: IO[bytes]) -> Iterator[Element]:
    """Parse what others wrote, element by element.

    Args:
        stream: the file.

    Yields:
        Each element once it is whole; its content is dropped when the next one is asked for.

    Raises:
        XmlError: one line.
    """
    with _refused():
        for _, element in iterparse(stream, forbid_dtd=True):
            yield element
            element.clear()


def check_beginning(stream: IO[bytes]) -> None:
    """Refuse a document type before another library reads the file.

    Args:
        stream: the file, of which no more is read than up to its first element.

    Raises:
        XmlError: one line.
    """
    with _refused():
        next(iterparse(stream, events=("start",), forbid_dtd=True))


@contextmanager
def _refused() -> Iterator[None]:
    try:
        yield
    except DefusedXmlException:
        raise DocumentTypeError("XML that declares a document type; allowed: none") from None
    except (ParseError, LookupError, StopIteration) as error:  # an encoding that Python lacks
        raise XmlError(f"not XML: {error or 'no element'}") from None
