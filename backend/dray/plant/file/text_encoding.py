"""Bytes of a file as text: spreadsheets and planning tools on Windows still write other encodings than UTF-8."""

from __future__ import annotations

import codecs
import re

import msgspec

BOMS = (
    (codecs.BOM_UTF8, "utf-8"),
    (codecs.BOM_UTF32_LE, "utf-32"),
    (codecs.BOM_UTF32_BE, "utf-32"),
    (codecs.BOM_UTF16_LE, "utf-16"),
    (codecs.BOM_UTF16_BE, "utf-16"),
)
"""Byte order marks and their encodings. UTF-32 stands first: its mark begins with that of UTF-16."""

WINDOWS = "windows-1252"

SAMPLE_BYTES = 4_096
"""Size of the sample from the start of a file without a mark: enough to recognise UTF-16."""

ZEROS_FRAC = 0.3
"""Fraction of zeros among every second byte from which a file is UTF-16: in Western languages nearly all of them are
zero."""

LOST = "\ufffd"
"""A program's replacement for a character that it could not read."""

_MISREAD = re.compile(r"[^\W\d_](?:[‚ƒ„…†‡ˆ‰‹“”•˜›][^\W\d_]|[ŠŒŽŸ][a-zß-ÿ])")  # noqa: RUF001 - these are the marks that are meant
"""Marks and capitals inside of a word, where letters stand in an older code page (DOS, Macintosh)."""


class Decoded(msgspec.Struct, frozen=True):
    """The text of a file."""

    text: str
    encoding: str
    """Name of the encoding, as `utf-8`."""
    assumed: bool = False
    """Whether nothing in the file tells its encoding, and it is not UTF-8."""


class UnknownEncodingError(ValueError):
    """The bytes are no text of an encoding that is read here."""


def decode_text(content: bytes) -> Decoded:
    """Read UTF-8, UTF-16 and UTF-32 by their marks, UTF-16 by its zeros, and the rest as Windows-1252.

    Raises:
        UnknownEncodingError: it is none of them.
    """
    for mark, encoding in BOMS:
        if content.startswith(mark):
            return Decoded(
                _strictly(content[len(mark) :] if encoding == "utf-8" else content, encoding), encoding
            )
    if wide := _wide(content[:SAMPLE_BYTES]):
        return Decoded(_strictly(content, wide), "utf-16")
    try:
        return Decoded(content.decode(), "utf-8")
    except UnicodeDecodeError:
        text = _strictly(content, WINDOWS)
    if _MISREAD.search(text):
        raise UnknownEncodingError
    return Decoded(text, WINDOWS, assumed=True)


def _wide(sample: bytes) -> str:
    """The kind of UTF-16 that a sample is; empty for none."""
    half = len(sample) // 2
    if half and sample[1::2].count(0) > ZEROS_FRAC * half:
        return "utf-16-le" if sample[0::2].count(0) == 0 else ""
    if half and sample[0::2].count(0) > ZEROS_FRAC * half:
        return "utf-16-be" if sample[1::2].count(0) == 0 else ""
    return ""


def _strictly(content: bytes, encoding: str) -> str:
    try:
        return content.decode(encoding)
    except UnicodeDecodeError:
        raise UnknownEncodingError from None
