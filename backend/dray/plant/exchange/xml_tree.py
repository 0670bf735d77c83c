"""XML as a tree with line numbers, by expat of the standard library.

A document type is refused. Without one there are no entities, so no text grows beyond the file, and nothing is fetched.
"""

from __future__ import annotations

from xml.parsers import expat
from xml.parsers.expat import errors

import msgspec

MAX_DEPTH = 64
MAX_ELEMENTS = 2_000_000


class Element(msgspec.Struct):
    """One element; text between elements is not kept, because no format here has any."""

    name: str
    attributes: dict[str, str]
    line: int
    children: list[Element] = []

    def all(self, name: str) -> list[Element]:
        """Its children with a name."""
        return [child for child in self.children if child.name == name]

    def first(self, name: str) -> Element | None:
        """Its first child with a name."""
        return next((child for child in self.children if child.name == name), None)


WORDS = {
    errors.codes[
        errors.XML_ERROR_NO_ELEMENTS
    ]: "it ends before there is an element, or before the last one is closed",
    errors.codes[errors.XML_ERROR_TAG_MISMATCH]: "an element is closed that is not the one that is open",
    errors.codes[errors.XML_ERROR_INVALID_TOKEN]: "a character stands where none may, as & or < in a name",
    errors.codes[errors.XML_ERROR_DUPLICATE_ATTRIBUTE]: "an attribute is given twice",
    errors.codes[errors.XML_ERROR_UNDEFINED_ENTITY]: "it uses an entity that it does not explain",
    errors.codes[errors.XML_ERROR_JUNK_AFTER_DOC_ELEMENT]: "something stands behind its last element",
    errors.codes[errors.XML_ERROR_UNCLOSED_TOKEN]: "it ends in the middle of an element",
}
"""Errors of expat, in our words."""


def read_xml(text: str) -> Element:
    """The root element of a document; which encoding it names is no matter.

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
        what = WORDS.get(error.code, "it cannot be read")
        raise ValueError(f"not XML: line {error.lineno}, column {error.offset + 1}: {what}") from None
    except UnicodeEncodeError:
        raise ValueError("not XML: half of a character stands in it") from None
    return root[0]
