"""A vehicle's dialogue in a file, and its replay: a fresh master gets the same events, and its effects are compared.

A master is pure. So a file of its events contains all that it knew, and a replay gives the same messages; a changed driver, or another
profile, shows the differences. Each line is JSON: a head, then events and effects with their times. A file may also come from
listening alone (`dray vehicle record`): then it has no instructions, and shows how a vehicle's messages are understood.
"""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from typing import Any, get_args

import msgspec

from dray.adapters.vda5050.control.master import MasterControl
from dray.adapters.vda5050.events import (
    Cancel,
    Effect,
    Event,
    Heard,
    Instructed,
    Linked,
    Memory,
    Note,
    Remember,
    Say,
    Tell,
    Unlinked,
    Woke,
)
from dray.adapters.vda5050.profile import Profile
from dray.body import VehicleInstruction
from dray.errors import SettingsError
from dray.plant import Plant

LARGEST_BYTES = 100 * 2**20
"""Maximum size of a file: some eight hours of a vehicle that sends ten states a second. Then writing stops."""

INSTRUCTIONS: dict[str, Any] = {kind.__name__: kind for kind in get_args(VehicleInstruction)}


class Head(msgspec.Struct, frozen=True):
    """The first line of a dialogue."""

    agent: str
    plant: str
    type: str
    profile: Profile
    life: int = 1
    memory: Memory = Memory()


class Line(msgspec.Struct, frozen=True, omit_defaults=True):
    """An event or an effect.

    Attributes:
        at_s: on the plant's clock.
        event: the class of an event; empty for an effect.
        effect: the class of an effect; empty for an event.
        about: topic, reason, text, or the class of an instruction or report.
        text: the received message, as text.
        fields: of an instruction, a report, a sent message, or a memory.
    """

    at_s: float
    event: str = ""
    effect: str = ""
    about: str = ""
    text: str = ""
    fields: dict[str, Any] = {}


def line_of(at_s: float, what: Event | Effect) -> Line:
    """One event or effect as a line."""
    name = type(what).__name__
    match what:
        case Heard(topic, data):
            return Line(at_s, event=name, about=topic, text=data.decode("utf-8", "replace"))
        case Instructed(instruction):
            return Line(at_s, event=name, about=type(instruction).__name__, fields=_fields(instruction))
        case Unlinked(reason):
            return Line(at_s, event=name, about=reason)
        case Linked() | Woke() | Cancel():
            return Line(at_s, event=name)
        case Say(topic, body):
            return Line(at_s, effect=name, about=topic, fields=body)
        case Tell(report):
            return Line(at_s, effect=name, about=type(report).__name__, fields=_fields(report))
        case Remember(memory):
            return Line(at_s, effect=name, fields=_fields(memory))
        case Note(text):
            return Line(at_s, effect=name, about=text)


class Recorder:
    """Writes a dialogue.

    Args:
        path: the file; an existing one is replaced.
        head: the first line.

    Raises:
        SettingsError: writing failed.
    """

    def __init__(self, path: Path, head: Head) -> None:
        try:
            path.parent.mkdir(parents=True, exist_ok=True)
            self._file = path.open("wb")
        except OSError as error:
            raise SettingsError("--record", f"{path} cannot be written: {error.strerror}") from None
        self._left = LARGEST_BYTES
        self._write(head)

    def write(self, at_s: float, *what: Event | Effect) -> None:
        """Write events and effects, in order."""
        for one in what:
            self._write(line_of(at_s, one))

    def close(self) -> None:
        """Stop writing."""
        self._file.close()

    def _write(self, what: Head | Line) -> None:
        data = msgspec.json.encode(what) + b"\n"
        self._left -= len(data)
        if self._left >= 0 and not self._file.closed:
            self._file.write(data)
            self._file.flush()


def read_dialogue(path: Path) -> tuple[Head, list[Line]]:
    """Read a dialogue from its file.

    Raises:
        SettingsError: reading failed; names the line.
    """
    try:
        lines = path.read_bytes().splitlines()
    except OSError as error:
        raise SettingsError("FILE", f"{path} cannot be read: {error.strerror}") from None
    number = 1
    try:
        if not lines:
            raise SettingsError("FILE", f"{path} is empty: `dray vehicle record` writes one")
        head = msgspec.json.decode(lines[0], type=Head)
        read = []
        for data in lines[1:]:
            number += 1
            read.append(msgspec.json.decode(data, type=Line))
            _event(read[-1])
    except (msgspec.DecodeError, msgspec.ValidationError, UnicodeDecodeError, KeyError) as error:
        raise SettingsError("FILE", f"{path}:{number}: no line of a dialogue: {error}") from None
    return head, read


def replay(head: Head, lines: list[Line], plant: Plant, profile: Profile | None = None) -> Iterator[Line]:
    """Play a dialogue into a fresh master.

    Args:
        head: the first line.
        lines: the recorded lines; effects are skipped.
        plant: the vehicle's plant.
        profile: another one than at the recording.

    Yields:
        Events, and the effects of this master after each of them.

    Raises:
        SettingsError: the plant lacks this type of vehicle.
    """
    kind = plant.vehicle_types.get(head.type)
    if kind is None:
        raise SettingsError(
            "--plant", f"it has no vehicle type {head.type!r}; the dialogue is of plant {head.plant}"
        )
    master = MasterControl(
        head.agent, plant, kind, profile or head.profile, life=head.life, memory=head.memory
    )
    for line in lines:
        event = _event(line)
        if event is None or (isinstance(event, Instructed) and not master.is_known):
            continue
        yield line
        for effect in master.handle(event, line.at_s):
            yield line_of(line.at_s, effect)


def first_difference(recorded: list[Line], played: list[Line]) -> tuple[Line | None, Line | None] | None:
    """The first effect that differs; None when all are equal."""
    one = [line for line in recorded if line.effect]
    other = [line for line in played if line.effect]
    for here, there in zip(one, other, strict=False):
        if msgspec.json.encode(here) != msgspec.json.encode(there):
            return here, there
    if len(one) != len(other):
        longer, at = (one, len(other)) if len(one) > len(other) else (other, len(one))
        return (longer[at], None) if longer is one else (None, longer[at])
    return None


def _event(line: Line) -> Event | None:
    match line.event:
        case "Heard":
            return Heard(line.about, line.text.encode())
        case "Instructed":
            return Instructed(msgspec.convert(line.fields, INSTRUCTIONS[line.about]))
        case "Linked":
            return Linked()
        case "Unlinked":
            return Unlinked(line.about)
        case "Woke":
            return Woke()
        case "Cancel":
            return Cancel()
    return None


def _fields(what: Any) -> dict[str, Any]:
    fields: dict[str, Any] = msgspec.to_builtins(what)
    return fields
