"""Three replicas of one table, and what is under way between them, for tests."""

from __future__ import annotations

from dray.messages.floor.traffic import (
    PlaceRequested,
    PlaceReservation,
    TableAcknowledged,
    TableAsked,
    TableReplicated,
    TableReported,
)
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.reservations.copies import Copies, Kept

NAMES = ("M1", "M2", "M3")


class Trio:
    """Three replicas and what is under way between them."""

    def __init__(self) -> None:
        self.lives = {name: Life() for name in NAMES}
        self.replicas = {
            name: Copies("M1", name, NAMES, Kept(), self.lives[name], is_signed) for name in NAMES
        }
        self.cut: set[str] = set()
        self.to_vehicles: list[tuple[str, Send]] = []
        """Who has said what to vehicles."""

    def carry(self) -> None:
        """Deliver everything, until nothing is under way."""
        while any(life.effects for life in self.lives.values()):
            for sender, life in self.lives.items():
                effects = list(life.effects)
                life.effects.clear()
                for effect in effects:
                    assert isinstance(effect, Send)
                    if sender not in self.cut and effect.to not in self.cut:
                        self.deliver(sender, effect)

    def deliver(self, sender: str, effect: Send) -> None:
        if effect.to not in self.replicas:
            self.to_vehicles.append((sender, effect))
            return
        replica, message = self.replicas[effect.to], effect.message
        match message:
            case TableReplicated():
                refused = replica.refused
                replica.on_replicated(sender, message, silent=self.is_silent(replica))
                if replica.refused > refused:
                    replica.ask_for_words()
            case TableAcknowledged():
                replica.on_acknowledged(sender, message)
            case TableAsked():
                replica.on_asked(sender, message, silent=self.is_silent(replica))
                replica.on_misses(message.misses)
            case TableReported():
                replica.on_reported(sender, message)

    def is_silent(self, replica: Copies) -> bool:
        """Whether the leader of the present epoch does not answer another one."""
        return replica.leader in self.cut

    def lead(self, name: str) -> Copies:
        """Let one seek to keep the table; whoever is cut off is known not to answer."""
        self.replicas[name].seek(self.cut)
        self.carry()
        return self.replicas[name]


def is_signed(atv: str, request: PlaceRequested) -> bool:
    """Whether a vehicle has signed a request, as these tests sign."""
    return request.signature == atv.encode()


def line(atv: str, number: int, *, mark: bytes = b"") -> tuple[PlaceReservation, ...]:
    """A reservation table of one line."""
    return (PlaceReservation(place="b3", number=number, atv=atv, mark=mark),)
