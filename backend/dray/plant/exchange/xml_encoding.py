"""The text of an XML file in any encoding, also in one that it names wrongly.

Expat knows UTF-8, UTF-16 and the encodings of one byte for a letter. Tools of Windows write others, and names that are none (`ANSI`, `unicode`).
"""

from __future__ import annotations

import codecs
import re

from dray.plant.exchange.notes import Notes
from dray.plant.file.reasons import Reason
from dray.plant.file.text_encoding import UnknownEncodingError, decode_text

DECLARED = re.compile(rb"""^\s*<\?xml[^>]{0,200}?\bencoding\s*=\s*["']([A-Za-z0-9._ -]{1,40})["']""")

NO_TEXT = frozenset({"idna", "punycode", "unicode_escape", "raw_unicode_escape", "undefined", "utf-7"})
"""Codecs of Python that no file is in."""

WIDE = ("utf-16", "utf-32")
"""Encodings with a mark, or with zeros that show them."""

LATIN = frozenset({"iso8859-1", "ascii"})
"""Windows-1252 holds these, and its letters stand in files that claim them."""


def xml_text(content: bytes, notes: Notes) -> str:
    """Decode a file; an encoding that had to be guessed is said.

    Raises:
        ValueError: its letters are in no encoding that is read here.
    """
    found = DECLARED.match(content)
    declared = found[1].decode().strip() if found else ""
    codec = _codec(declared)
    if codec and not codec.startswith(WIDE):
        try:
            return content.decode(codec)
        except (UnicodeError, LookupError):
            # Some of Python's codecs are not for texts. The code below finds the real encoding.
            pass
    try:
        decoded = decode_text(content)
    except UnknownEncodingError:
        raise ValueError(
            f"its letters are not in {declared or 'an encoding that is read here'}: save it as UTF-8"
        ) from None
    if declared and not _same(codec, decoded.encoding):
        notes.add(
            "line 1",
            Reason("note_encoding_not_what_read_as", declared=declared, encoding=decoded.encoding),
        )
    elif decoded.assumed:
        notes.add("line 1", Reason("note_does_not_say_its_encoding", encoding=decoded.encoding))
    return decoded.text


def _same(codec: str, encoding: str) -> bool:
    """Whether a file is in the encoding that it claims; of a wide one in either order of its bytes."""
    wide = codec.startswith(WIDE) and codec[:6] == encoding[:6]
    return wide or codec == _codec(encoding)


def _codec(declared: str) -> str:
    """Python's name of an encoding; empty for none that a file may be in."""
    try:
        name = codecs.lookup(declared).name if declared else ""
    except LookupError:
        return ""
    if name in NO_TEXT:
        return ""
    return "cp1252" if name in LATIN else name
