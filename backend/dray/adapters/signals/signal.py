"""The values that a machine's controller and its agent exchange, and how each is written by that controller."""

from __future__ import annotations

from collections.abc import Container
from enum import StrEnum
from typing import Annotated, Protocol

from msgspec import Meta, Struct, field

from dray.messages.base import COUNT_MAX

Value = bool | int | float | str


class Signal(StrEnum):
    """One value. The first ones are the controller's, the others are written by the agent."""

    PIECES = "pieces"
    """Good pieces: a counter, or a pulse for each."""
    BAD = "bad"
    """Bad pieces, likewise."""
    FAULT = "fault"
    """True, or a number other than 0, or a text, while the machine stands by a fault."""
    FAULT_TEXT = "fault_text"
    """What the fault is, in words."""
    STATE = "state"
    """How the machine is, by the words or numbers of OPC 40001-1."""
    DOCK_READY = "dock_ready"
    """A vehicle may load or unload now."""

    RUN = "run"
    """True while a piece is wanted: the machine makes one after the other."""
    PRODUCT = "product"
    """What is wanted."""
    SPEED = "speed"
    """The part of its top speed at which it is to work; 1 for all of it."""
    RESET = "reset"
    """True while a fault is to be acknowledged."""
    DOCK_PERMIT = "dock_permit"
    """True while a vehicle stands at the dock and waits for `DOCK_READY`, or loads or unloads."""
    DOCK_VEHICLE = "dock_vehicle"
    """Which vehicle that is; empty for none."""
    ALIVE = "alive"
    """Counts up once a second while the agent lives and hears the controller."""


READ = (
    Signal.PIECES,
    Signal.BAD,
    Signal.FAULT,
    Signal.FAULT_TEXT,
    Signal.STATE,
    Signal.DOCK_READY,
)
"""Those that the controller tells."""

AT_A_DOCK = (Signal.DOCK_READY, Signal.DOCK_PERMIT, Signal.DOCK_VEHICLE, Signal.ALIVE)
"""Those of a dock alone."""


class Edge(StrEnum):
    """Which change of a pulse counts a piece."""

    RISING = "rising"
    FALLING = "falling"


class Tag(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Where a controller has one signal, and how it writes it."""

    node: str = ""
    """Its address there: of OPC UA a node id, as `ns=2;s=Press.Good` or `nsu=http://maker/press;i=17`, or a path of browse
    names from Objects, as `2:Press/2:Good`."""
    topic: str = ""
    """Its address there, by MQTT."""
    path: str = ""
    """By MQTT: to the value in a message, as `count.good` or `channels.0.value`; empty where the whole message is the value."""
    scale: Annotated[float, Meta(gt=0)] = 1.0
    """What is read is divided by it, what is written is multiplied: 100 where a controller has percent."""
    invert: bool = False
    """It is true where the signal is false."""
    edge: Edge | None = None
    """For a pulse: which change counts. None for a counter."""
    rolls_over_at: Annotated[int, Meta(ge=2, le=2**62)] | None = None
    """The first number that a counter does not reach; None where its type says it."""


class LinkListener(Protocol):
    """Whoever is told what a controller says (`workcell`, `store`)."""

    outputs: dict[str, Value]

    def on_link(self) -> None: ...

    def on_link_lost(self, reason: str) -> None: ...

    def on_range(self, signal: str, moduli: tuple[int, ...]) -> None: ...

    def on_sample(self, name: str, sample: Sample) -> None: ...

    def on_refused(self, name: str, reason: str) -> None: ...


class Quality(StrEnum):
    """What a controller says of a value of its own."""

    GOOD = "good"
    UNCERTAIN = "uncertain"
    BAD = "bad"


class Sample(Struct, frozen=True):
    """A value at one moment. One that is not good is no value: it tells that nothing is known."""

    value: Value
    quality: Quality = Quality.GOOD
    reason: str = ""
    """Why it is not good, by the controller's word."""


Count = Annotated[int, Meta(ge=0, le=COUNT_MAX)]


LEVEL = "level of "
"""Before a material: the name of what a storage's controller tells of it."""


class SignalMapping(Struct, frozen=True, forbid_unknown_fields=True, omit_defaults=True):
    """Which signals a machine, or the dock of a storage, has, and how it began.

    Raises:
        ValueError: something is said of a signal that makes no sense there.
    """

    signals: dict[Signal, Tag]
    stock: dict[str, Count] = field(default_factory=dict)
    """Pieces that lie there when its agent is started for the first time. Later ones remember."""
    levels: dict[str, Tag] = field(default_factory=dict)
    """Of a storage: where its controller tells how many pieces of a material lie there."""

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
        if Signal.DOCK_READY in self.signals and Signal.DOCK_PERMIT not in self.signals:
            raise ValueError(
                "signals: `dock_ready` needs `dock_permit`: the controller must hear that somebody waits"
            )
        for item, tag in self.levels.items():
            if tag.edge or tag.rolls_over_at or tag.invert:
                raise ValueError(
                    f"levels.{item}: a level has no edge, does not roll over, and is not inverted"
                )

    @property
    def tags(self) -> dict[str, Tag]:
        """Everything that is told or written, by its name."""
        levels = {LEVEL + item: tag for item, tag in self.levels.items()}
        return dict[str, Tag](self.signals.items()) | levels

    def check_machine(self) -> None:
        """See that it is a machine's.

        Raises:
            ValueError: it is not.
        """
        if Signal.PIECES not in self.signals:
            raise ValueError("signals: `pieces` is missing: without it nobody knows that a piece was made")
        if self.levels:
            raise ValueError(
                "levels: a machine's stock is reckoned; only a storage's controller tells levels"
            )

    def check_store(self, items: Container[str]) -> None:
        """See that it is a storage's that keeps these materials.

        Raises:
            ValueError: it is not.
        """
        for signal in self.signals:
            if signal not in AT_A_DOCK:
                raise ValueError(f"signals.{signal}: a storage has {', '.join(AT_A_DOCK)} only")
        for where in ("stock", "levels"):
            for item in getattr(self, where):
                if item not in items:
                    raise ValueError(f"{where}.{item}: this is not kept there")


def is_told(name: str) -> bool:
    """Whether a value of this name is the controller's word; else it is written by the agent."""
    return name in READ or name.startswith(LEVEL)
