"""Three keepers of one book, and what is under way between them, for tests."""

from __future__ import annotations

from dray.messages.floor.traffic import BookAsked, BookKept, BookTold, PlaceBooked, PlaceBooking, PlaceWished
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.books.copies import Copies, Kept

NAMES = ("M1", "M2", "M3")


class Trio:
    """Three keepers and what is under way between them."""

    def __init__(self) -> None:
        self.lives = {name: Life() for name in NAMES}
        self.keepers = {
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
        if effect.to not in self.keepers:
            self.to_vehicles.append((sender, effect))
            return
        keeper, message = self.keepers[effect.to], effect.message
        match message:
            case PlaceBooked():
                keeper.on_booked(sender, message, silent=self.is_silent(keeper))
            case BookKept():
                keeper.on_kept(sender, message)
            case BookAsked():
                keeper.on_asked(sender, message, silent=self.is_silent(keeper))
            case BookTold():
                keeper.on_told(sender, message)

    def is_silent(self, keeper: Copies) -> bool:
        """Whether the keeper of the present epoch does not answer another one."""
        return keeper.leader in self.cut

    def lead(self, name: str) -> Copies:
        """Let one seek to keep the book; whoever is cut off is known not to answer."""
        self.keepers[name].seek(self.cut)
        self.carry()
        return self.keepers[name]


def is_signed(atv: str, wish: PlaceWished) -> bool:
    """Whether a vehicle has signed a wish, as these tests sign."""
    return wish.signature == atv.encode()


def line(atv: str, number: int, *, mark: bytes = b"") -> tuple[PlaceBooking, ...]:
    """A book of one line."""
    return (PlaceBooking(place="b3", number=number, atv=atv, mark=mark),)
