"""A layout file of any format as an unfinished plant: the one way in."""

from __future__ import annotations

from pathlib import PurePath

from dray.errors import PlantError
from dray.plant.exchange.assemble import Imported, assemble
from dray.plant.exchange.lif import decode, read_lif
from dray.plant.exchange.names import Ids
from dray.plant.exchange.notes import Notes
from dray.plant.exchange.opentcs import read_opentcs
from dray.plant.exchange.xml_encoding import xml_text
from dray.plant.exchange.xml_tree import read_xml
from dray.plant.file.reasons import Reason
from dray.plant.file.text_encoding import LOST, UnknownEncodingError, decode_text

MAX_BYTES = 64 * 1024 * 1024
"""Largest layout file. A LIF file takes about 1 KiB for an edge."""


def read_layout(
    content: bytes | str,
    file: str,
    *,
    plant: str = "",
    name: str = "",
    unit: str = "",
    layouts: tuple[str, ...] = (),
) -> Imported:
    """Read a LIF file (JSON) or a plant model of openTCS (XML).

    Args:
        content: the file; its text where somebody else has read it.
        file: its name, for errors and for the id of the plant.
        plant: the id of the plant; from the file's name if it is empty.
        name: of the plant, for people; from the file if it is empty.
        unit: of a LIF file, `m`, `cm` or `mm`; found out if it is empty.
        layouts: of a LIF file, the ids of the wanted layouts; empty for all.

    Raises:
        PlantError: it is neither of them, or has no node.
    """
    if len(content) > MAX_BYTES:
        raise PlantError(file, "", f"has more than {MAX_BYTES // 1024 // 1024} MiB: this is no layout")
    notes = Notes()
    try:
        text = content if isinstance(content, str) else _text(content, notes)
        text = text.lstrip("\ufeff \t\r\n")
        if LOST in text:
            notes.add("", Reason("note_letters_were_lost_before_came", lost=LOST))
        if text.startswith("<"):
            layout = read_opentcs(read_xml(text), notes)
        else:
            layout = read_lif(decode(text), notes, unit=unit, layouts=layouts)
    except ValueError as error:
        raise PlantError(file, "", str(error)) from None
    if not layout.nodes:
        said = "; ".join(note.line() for note in notes.all()[:3])
        raise PlantError(file, "", f"there is no node in it{f' ({said})' if said else ''}")
    chosen = plant or Ids("p-").give(PurePath(file).stem)
    return assemble(layout, notes, plant=chosen, name=name or layout.name)


def _text(content: bytes, notes: Notes) -> str:
    """The text of a file; guesses are reported in the notes.

    Raises:
        ValueError: its encoding is not supported.
    """
    if content.lstrip(b" \t\r\n").startswith(b"<") and b"\0" not in content[:4]:
        return xml_text(content, notes)
    try:
        decoded = decode_text(content)
    except UnknownEncodingError:
        raise ValueError("is not UTF-8: save it as UTF-8") from None
    if decoded.assumed:
        notes.add("", Reason("note_not_utf_read_as_look", encoding=decoded.encoding))
    return decoded.text
