"""XML as a tree with line numbers, by expat of the standard library.

A document type is refused: without one there are no entities, so no text grows beyond what is written and nothing is fetched.
"""

from __future__ import annotations

from xml.parsers import expat

import msgspec

MAX_DEPTH = 64
MAX_ELEMENTS = 2_000_000


class Element(msgspec.Struct):
    """One element; text between elements is not kept, no format here has any."""

    name: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = []

    def all(self, name: str) -> list[Element]:
        """Its children of a name."""
        return [child for child in self.children if child.name == name]

    def first(self, name: str) -> Element | None:
        """Its first child of a name."""
        return next((child for child in self.children if child.name == name), None)


def read_xml(text: bytes) -> Element:
    """The root element of a document.

    Raises:
        ValueError: it is no XML, or has a document type, or is nested too deep.
    """
    parser = expat.ParserCreate()
    open_elements: list[Element] = []
    root: list[Element] = []
    count = 0

    def start(name: str, attributes: dict[str, str]) -> None:
        nonlocal count
        count += 1
        if len(open_elements) >= MAX_DEPTH or count > MAX_ELEMENTS:
            raise ValueError("not a layout: too many elements, or nested too deep")
        element = Element(name.rpartition(":")[2], attributes, parser.CurrentLineNumber)
        if open_elements:
            open_elements[-1].children.append(element)
        else:
            root.append(element)
        open_elements.append(element)

    def end(_: str) -> None:
        open_elements.pop()

    def refuse(*_: object) -> None:
        raise ValueError("it has a document type (<!DOCTYPE ...>): remove it")

    parser.StartElementHandler = start
    parser.EndElementHandler = end
    parser.StartDoctypeDeclHandler = refuse
    try:
        parser.Parse(text, True)
    except expat.ExpatError as error:
        raise ValueError(f"not XML: {error}") from None
    return root[0]
