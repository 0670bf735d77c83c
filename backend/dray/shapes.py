"""What can be read from JSON, made ready before a process has a second thread.

msgspec makes a type's table of fields when the type is first read or converted to. Two threads that are the first at the same
moment end the process (seen with msgspec 0.22.0: the table can be seen before it is filled). So a process that
reads on several threads has all tables made while it has one.
"""

from __future__ import annotations

from collections.abc import Iterator

import msgspec


def prepare_shapes() -> None:
    """Make the table of fields of every message, fact, view and row that this process has imported.

    What cannot be read (a union of types without tags, say) is passed over: nobody reads it on any thread.
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
