"""The values exchanged between a machine's controller and its agent, and their form at the controller."""

from __future__ import annotations

import math
from collections.abc import Mapping
from enum import StrEnum
from typing import Annotated, Protocol

from msgspec import Meta, Struct, field

from dray.messages.base import COUNT_MAX

Value = bool | int | float | str


class Signal(StrEnum):
    """One value. The controller writes the first ones, the agent the others."""

    PIECES = "pieces"
    """Good pieces: a counter, or a pulse for each."""
    BAD = "bad"
    """Bad pieces, likewise."""
    FAULT = "fault"
    """True, or a number other than 0, or a text, while a fault stops the machine."""
    FAULT_TEXT = "fault_text"
    """The fault in words."""
    STATE = "state"
    """The machine's state, by the words or numbers of OPC 40001-1."""
    DOCK_READY = "dock_ready"
    """A vehicle may load or unload now."""
    GOAL = "goal"
    """The label of the container at the gate; empty for none."""

    RUN = "run"
    """True while a piece is wanted: the machine makes one after the other."""
    PRODUCT = "product"
    """The wanted product."""
    SPEED = "speed"
    """The wanted fraction of its top speed; 1 for all of it."""
    RESET = "reset"
    """True while a fault is to be acknowledged."""
    DOCK_PERMIT = "dock_permit"
    """True while a vehicle stands at the dock and waits for `DOCK_READY`, or loads or unloads."""
    DOCK_VEHICLE = "dock_vehicle"
    """The vehicle at the dock; empty for none."""
    ADMITTED = "admitted"
    """Pieces of the container at the gate that may come in, from the beginning of the permit on; 0 for no permit."""
    ADMITTED_GOAL = "admitted_goal"
    """The label for which `ADMITTED` is said."""
    ALIVE = "alive"
    """Counts up once a second while the agent lives and hears the controller."""


READ = (
    Signal.PIECES,
    Signal.BAD,
    Signal.FAULT,
    Signal.FAULT_TEXT,
    Signal.STATE,
    Signal.DOCK_READY,
    Signal.GOAL,
)
"""Signals that the controller writes."""

TEXTS = (Signal.FAULT_TEXT, Signal.GOAL)
"""Signals that are always texts: nothing is an empty one."""

AT_A_DOCK = (Signal.DOCK_READY, Signal.DOCK_PERMIT, Signal.DOCK_VEHICLE, Signal.ALIVE)
"""Signals of a dock alone."""

OF_A_GATE = (Signal.GOAL, Signal.ADMITTED, Signal.ADMITTED_GOAL)
"""Signals that only the gate has, and that it must have."""

AT_A_GATE = (Signal.PIECES, *OF_A_GATE, Signal.FAULT, Signal.FAULT_TEXT, Signal.ALIVE)
"""Signals of the gate."""


class Edge(StrEnum):
    """The change of a pulse that counts a piece."""

    RISING = "rising"
    FALLING = "falling"


class Tag(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """A signal's address at a controller, and its form there."""

    node: str = ""
    """The address by OPC UA: a node id, as `ns=2;s=Press.Good` or `nsu=http://maker/press;i=17`, or a path of browse names from
    Objects, as `2:Press/2:Good`."""
    topic: str = ""
    """The topic by MQTT."""
    path: str = ""
    """The path to the value in an MQTT message, as `count.good` or `channels.0.value`; empty where the message is the value."""
    scale: Annotated[float, Meta(gt=0)] = 1.0
    """The divisor of values read and factor of values written: 100 where a controller uses percent."""
    invert: bool = False
    """Whether it is true where the signal is false."""
    edge: Edge | None = None
    """The counting change of a pulse. None for a counter."""
    rolls_over_at: Annotated[int, Meta(ge=2, le=2**62)] | None = None
    """The number at which a counter rolls over; None where its type defines it."""
    at_least: Annotated[int, Meta(ge=1, le=COUNT_MAX)] | None = None
    """For a level that is a switch: the pieces that lie there at least while it is on; fewer lie there while it is off. None for a
    level in numbers."""


class LinkListener(Protocol):
    """The receiver of a controller's values (`workcell`, `store`, `gate`)."""

    outputs: dict[str, Value]

    def on_link(self) -> None: ...

    def on_link_lost(self, reason: str) -> None: ...

    def on_range(self, signal: str, moduli: tuple[int, ...]) -> None: ...

    def on_sample(self, name: str, sample: Sample) -> None: ...

    def on_refused(self, name: str, reason: str) -> None: ...

    def on_written(self, name: str, value: Value) -> None:
        """The controller has confirmed a value. By MQTT none is confirmed."""


class Quality(StrEnum):
    """The quality of a value, by the controller."""

    GOOD = "good"
    UNCERTAIN = "uncertain"
    BAD = "bad"


class Sample(Struct, frozen=True):
    """A value at one moment. Without good quality, the value is unknown."""

    value: Value
    quality: Quality = Quality.GOOD
    reason: str = ""
    """The controller's reason for bad quality."""


Count = Annotated[int, Meta(ge=0, le=COUNT_MAX)]


UP_TO = ", up to "
"""What stands before the end of a counter in words (`SignalMapping.source`)."""

LEVEL = "level of "
"""The prefix of a material in the name of a storage's level."""


class Checked(Struct, frozen=True, forbid_unknown_fields=True):
    """People's count at a gate whose count was in doubt."""

    doubt: Annotated[int, Meta(ge=1)]
    """The number of the doubt, as the agent's log has it: an old count settles no new doubt."""
    arrived: dict[str, Count] = field(default_factory=dict)
    """Pieces that are in, by goal; those of other goals stay as they were counted."""


class SignalMapping(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """The signals of a machine, of a storage's dock or of the gate, and its initial stock.

    Raises:
        ValueError: a signal has an impossible property.
    """

    signals: dict[Signal, Tag]
    stock: dict[str, Count] = field(default_factory=dict)
    """Pieces at the first start of its agent. Later starts use the memory."""
    levels: dict[str, Tag] = field(default_factory=dict)
    """For a storage: the level of each material at its controller, or its switch (`at_least`)."""
    checked: Checked | None = None
    """For the gate: people's count after a doubt."""

    def __post_init__(self) -> None:
        for signal, tag in self.signals.items():
            counts = signal in (Signal.PIECES, Signal.BAD)
            if not counts and (tag.edge or tag.rolls_over_at):
                raise ValueError(f"signals.{signal}: only `pieces` and `bad` have an edge, or roll over")
            if tag.edge and tag.rolls_over_at:
                raise ValueError(f"signals.{signal}: a pulse with an edge is no counter that rolls over")
            if counts and tag.invert:
                raise ValueError(
                    f"signals.{signal}: to count at the other change of a pulse, say `edge: falling`"
                )
            if tag.at_least is not None:
                raise ValueError(f"signals.{signal}: only a switch of `levels` has `at_least`")
            if signal in OF_A_GATE and (tag.invert or tag.scale != 1.0):
                raise ValueError(f"signals.{signal}: it is neither inverted nor scaled")
        if Signal.DOCK_READY in self.signals and Signal.DOCK_PERMIT not in self.signals:
            raise ValueError(
                "signals: `dock_ready` needs `dock_permit`: the controller must hear that somebody waits"
            )
        for item, tag in self.levels.items():
            if tag.edge or tag.rolls_over_at or (tag.invert and tag.at_least is None):
                raise ValueError(
                    f"levels.{item}: a level has no edge, does not roll over, and is not inverted"
                )
            if tag.at_least is not None and tag.scale != 1.0:
                raise ValueError(f"levels.{item}: a switch (`at_least`) is on or off, and not scaled")

    @property
    def tags(self) -> dict[str, Tag]:
        """All signals, by name."""
        levels = {LEVEL + item: tag for item, tag in self.levels.items()}
        return dict[str, Tag](self.signals.items()) | levels

    def source(self, name: str, moduli: tuple[int, ...] = ()) -> str:
        """What shows a signal, in words: two equal ones mean that values go on from one another.

        Args:
            name: the signal.
            moduli: the possible numbers at which a counter rolls over.
        """
        tag = self.tags[name]
        forms = [self.address(tag)]
        end = ""
        if tag.scale != 1.0:
            forms.append(f"scale {tag.scale:g}")
        if tag.edge is not None:
            forms.append(f"edge {tag.edge}")
        elif moduli:
            end = UP_TO + " or ".join(f"{modulus:,}" for modulus in moduli)
        return ", ".join(forms) + end

    def address(self, tag: Tag) -> str:
        """The address of a signal, in words."""
        return tag.node or " ".join((tag.topic, tag.path)).strip()

    def check_machine(self) -> None:
        """Check that it is a machine's.

        Raises:
            ValueError: it is not.
        """
        if Signal.PIECES not in self.signals:
            raise ValueError("signals: `pieces` is missing: without it nobody knows that a piece was made")
        self._check_no_gate("a machine")
        if self.levels:
            raise ValueError(
                "levels: a machine's stock is reckoned; only a storage's controller tells levels"
            )

    def check_store(self, room: Mapping[str, int]) -> None:
        """Check that it is that of a storage with these materials.

        Args:
            room: the most pieces of each material.

        Raises:
            ValueError: it is not.
        """
        for signal in self.signals:
            if signal not in AT_A_DOCK:
                raise ValueError(f"signals.{signal}: a storage has {', '.join(AT_A_DOCK)} only")
        self._check_no_gate("a storage")
        for where in ("stock", "levels"):
            for item in getattr(self, where):
                if item not in room:
                    raise ValueError(f"{where}.{item}: this is not kept there")
        for item, tag in self.levels.items():
            if tag.at_least is not None and tag.at_least > room[item]:
                raise ValueError(
                    f"levels.{item}: `at_least` is {tag.at_least}, and no more than {room[item]} fit in there"
                )

    def check_gate(self) -> None:
        """Check that it is the gate's.

        Raises:
            ValueError: it is not.
        """
        for signal in self.signals:
            if signal in AT_A_DOCK and signal not in AT_A_GATE:
                raise ValueError(
                    f"signals.{signal}: vehicles ask nobody at the gate; its controller lets containers in by their label (`goal`)"
                )
            if signal not in AT_A_GATE:
                raise ValueError(f"signals.{signal}: the gate has {', '.join(AT_A_GATE)} only")
        reasons = {
            Signal.PIECES: "without it nobody knows that pieces came in",
            Signal.GOAL: "without the label nobody knows whose pieces came in",
            Signal.ADMITTED: "the controller must hear how many pieces may come in",
            Signal.ADMITTED_GOAL: "the controller must hear for which label that is said",
        }
        for signal, reason in reasons.items():
            if signal not in self.signals:
                raise ValueError(f"signals: `{signal}` is missing: {reason}")
        if self.stock or self.levels:
            raise ValueError(f"{'stock' if self.stock else 'levels'}: nothing is kept at the gate")

    def _check_no_gate(self, what: str) -> None:
        if self.checked is not None:
            raise ValueError(f"checked: only the gate has it, and this is {what}")
        for signal in OF_A_GATE:
            if signal in self.signals:
                raise ValueError(f"signals.{signal}: only the gate has it, and this is {what}")


def bounds(value: Value, tag: Tag) -> tuple[int, int] | None:
    """The fewest and the most pieces that lie there, by a level or its switch; None for an invalid value."""
    if tag.at_least is None:
        if isinstance(value, bool | str) or not math.isfinite(value) or value < 0:
            return None
        pieces = min(round(value / tag.scale), COUNT_MAX)
        return pieces, pieces
    if isinstance(value, float | str) or value not in (0, 1):
        return None
    return (tag.at_least, COUNT_MAX) if bool(value) is not tag.invert else (0, tag.at_least - 1)


def no_level(value: Value, tag: Tag) -> str:
    """Why a value is no level, in words; empty where it is one."""
    if bounds(value, tag) is not None:
        return ""
    if tag.at_least is not None:
        return "that is neither yes nor no: a level in numbers has no `at_least`"
    if isinstance(value, bool):
        return "that is no number of pieces: of a switch say how many lie there `at_least` while it is on"
    return "that is no number of pieces"


BRIEF = 200
"""Maximum characters of a controller's text that are shown or logged."""


def brief(text: str, most: int = BRIEF) -> str:
    """A controller's text in one line, cut where it is too long."""
    line = " ".join(text[: 4 * most].split())
    return line if len(line) <= most else f"{line[:most].rstrip()}..."


def quoted(value: Value) -> str:
    """A controller's value for people who are to find it there."""
    return brief(repr(value), BRIEF // 2)


def fault_words(value: Value, *, inverted: bool) -> str:
    """A fault in words; empty for none."""
    if isinstance(value, str):
        return value.strip()
    if bool(value) is inverted:
        return ""
    return "a fault" if isinstance(value, bool) or inverted else f"fault {value:g}"


def is_told(name: str) -> bool:
    """Whether the controller writes this value; otherwise the agent does."""
    return name in READ or name.startswith(LEVEL)
