"""YAML text as plain values, with the line of every field: the only place that knows YAML.

The text is read event by event rather than composed at once, because a file may come from any source. Deep nesting
overflows the stack of the composer, and aliases let a few lines stand for gigabytes. A plant file needs neither; both
are refused by name.
"""

from __future__ import annotations

from collections.abc import Iterator
from math import isfinite

import msgspec
import yaml

from dray.errors import PlantError

MAX_DEPTH = 16
"""Levels of lists and mappings; a plant needs six (`machines[0].makes[0].product`)."""

MAX_VALUES = 1_000_000
"""Numbers, texts, lists and mappings: twenty times a plant of 500 vehicles, and some 300 MB to read."""

_LOADER = getattr(yaml, "CSafeLoader", yaml.SafeLoader)
"""libyaml where PyYAML was built with it: ten times as fast on a plant of 500 vehicles."""


class _Dumper(getattr(yaml, "CSafeDumper", yaml.SafeDumper)):  # type: ignore[misc]
    """Writes everything out: a plant file has no aliases."""

    def ignore_aliases(self, data: object) -> bool:
        return True


LINE_CHARS = 110
"""Width at which written lines are folded, as in our sources."""


class Document(msgspec.Struct, frozen=True):
    """The values of a YAML text, and their lines."""

    data: object
    """Mappings, lists, strings, numbers, booleans and None."""
    lines: dict[str, int]
    """Field path such as ``machines[3].node`` -> 1-based line; the path of the whole text is empty."""
    faults: tuple[PlantError, ...]
    """Keys that were given twice: the value is the last one, as YAML readers do it."""

    def line_of(self, field: str) -> int | None:
        """The line of a field, or of the innermost thing around it that is written down."""
        while field not in self.lines:
            cut = max(field.rfind("."), field.rfind("["))
            if cut < 0:
                return self.lines.get("")
            field = field[:cut]
        return self.lines[field]


def read_document(text: str, file: str) -> Document:
    """Read one YAML document.

    Args:
        text: the text.
        file: its name, for errors.

    Raises:
        PlantError: the text is no YAML, or uses forbidden parts: aliases, tags, several documents, keys that are no
            plain text, or nesting beyond `MAX_DEPTH`.
    """
    reader = _Reader(file)
    try:
        data = reader.read(yaml.parse(text, Loader=_LOADER))
    except UnicodeEncodeError:
        raise PlantError(file, "", "not YAML: half of a character stands in it") from None
    except yaml.MarkedYAMLError as error:
        mark = error.problem_mark or error.context_mark
        problem = ", ".join(part for part in (error.context, error.problem) if part)
        reason = f"not YAML: {problem}"
        raise PlantError(file, "", reason, mark.line + 1 if mark else None) from None
    except yaml.YAMLError as error:
        # A forbidden character; libyaml gives its place in bytes only.
        raise PlantError(file, "", f"not YAML: {str(error).splitlines()[0]}") from None
    return Document(data, reader.lines, tuple(reader.faults))


def write_document(data: object) -> str:
    """The text of which `read_document` makes the same data; innermost lists and mappings on one line."""
    text: str = yaml.dump(
        data,
        Dumper=_Dumper,
        allow_unicode=True,
        default_flow_style=None,
        sort_keys=False,
        width=LINE_CHARS,
    )
    return text


class _Reader:
    """Turns events into values; holds where it is for the sake of the lines."""

    def __init__(self, file: str) -> None:
        self.lines: dict[str, int] = {}
        self.faults: list[PlantError] = []
        self._file = file
        self._resolver = yaml.resolver.Resolver()
        self._constructor = yaml.constructor.SafeConstructor()

    def read(self, events: Iterator[yaml.Event]) -> object:
        """All events of a text; None for an empty one."""
        data, documents = None, 0
        for event in events:
            if isinstance(event, yaml.DocumentStartEvent):
                documents += 1
                if documents > 1:
                    raise self._fault("", "a second document begins: put one plant into one file", event)
            elif isinstance(event, yaml.NodeEvent):
                data = self._value(event, events, "", 0)
        return data

    def _value(self, event: yaml.Event, events: Iterator[yaml.Event], field: str, depth: int) -> object:
        """The value that begins with `event`; its other events are taken from `events`."""
        self.lines.setdefault(field, _line(event))
        if not isinstance(event, yaml.ScalarEvent | yaml.CollectionStartEvent):
            raise self._fault(field, "aliases (*name) are not allowed: write the value out", event)
        if event.tag not in (None, "!"):
            raise self._fault(field, f"the tag {event.tag} is not allowed: write the plain value", event)
        if depth >= MAX_DEPTH:
            raise self._fault(field, f"nested more than {MAX_DEPTH} levels deep", event)
        if len(self.lines) > MAX_VALUES:
            raise self._fault("", f"holds more than {MAX_VALUES} values: this is no plant file", event)
        if isinstance(event, yaml.MappingStartEvent):
            return self._mapping(events, field, depth)
        if isinstance(event, yaml.ScalarEvent):
            return self._scalar(event, field)
        return self._sequence(events, field, depth)

    def _sequence(self, events: Iterator[yaml.Event], field: str, depth: int) -> list[object]:
        values: list[object] = []
        for event in events:
            if isinstance(event, yaml.SequenceEndEvent):
                break
            values.append(self._value(event, events, f"{field}[{len(values)}]", depth + 1))
        return values

    def _mapping(self, events: Iterator[yaml.Event], field: str, depth: int) -> dict[str, object]:
        values: dict[str, object] = {}
        for event in events:
            if isinstance(event, yaml.MappingEndEvent):
                break
            if not isinstance(event, yaml.ScalarEvent):
                raise self._fault(field, "a key must be plain text", event)
            key = event.value
            inner = f"{field}.{key}" if field else key
            if key in values:
                line = self.lines[inner]
                self.faults.append(self._fault(inner, f"given twice, first in line {line}: keep one", event))
            values[key] = self._value(next(events), events, inner, depth + 1)
        return values

    def _scalar(self, event: yaml.ScalarEvent, field: str) -> object:
        """A scalar as YAML 1.1 reads it; a value that only looks like a date stays text."""
        tag: str = self._resolver.resolve(  # type: ignore[no-untyped-call]
            yaml.ScalarNode, event.value, event.implicit
        )
        node = yaml.ScalarNode(tag, event.value)
        try:
            match tag.rpartition(":")[2]:
                case "int":
                    return self._constructor.construct_yaml_int(node)
                case "float":
                    return self._finite(self._constructor.construct_yaml_float(node), event, field)
                case "bool":
                    return self._constructor.construct_yaml_bool(node)
                case "null":
                    return None
        except ValueError as error:
            raise self._fault(field, f"not a number: {error}", event) from None
        return str(event.value)

    def _finite(self, number: float, event: yaml.Event, field: str) -> float:
        if not isfinite(number):
            raise self._fault(field, f"{number} is no measure: write a finite number", event)
        return number

    def _fault(self, field: str, reason: str, event: yaml.Event) -> PlantError:
        return PlantError(self._file, field, reason, _line(event))


def _line(event: yaml.Event) -> int:
    """The 1-based line where an event begins; libyaml and PyYAML give one to each."""
    return event.start_mark.line + 1 if event.start_mark else 1
