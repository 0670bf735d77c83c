"""JSON decoding tables, built before a process has a second thread.

msgspec builds a type's table of fields on the first decoding or conversion. If two threads do that first at the same moment, the process
crashes (seen with msgspec 0.22.0: the second thread sees a table that is not filled yet). So a process that decodes on several threads
builds all tables while it has one.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec


def prepare_shapes() -> None:
    """Make the table of fields of every message, fact, view and row that this process has imported.

    Types that cannot be decoded (a union without tags, say) are skipped: no thread decodes them.
    """
    for shape in _below(msgspec.Struct):
        try:
            msgspec.json.Decoder(shape)
        except (TypeError, NameError):
            continue


def _below(shape: type[msgspec.Struct]) -> Iterator[type[msgspec.Struct]]:
    for each in shape.__subclasses__():
        yield each
        yield from _below(each)
