"""Vehicles that people carry away and put back: what one reservation table reports about them."""

from __future__ import annotations

from collections.abc import Iterable

from dray.messages import Removal
from dray.messages.fact import PlaceKept, PlacesFreed
from dray.messages.floor.traffic import FIRST_S, HOLDS_MAX, PlaceRequested
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.reservations.reservation_table import ReservationTable


class Carried:
    """The carried vehicles of one district.

    Attributes:
        unaware: vehicles that were carried away and have not acknowledged it.
    """

    def __init__(self, life: Life) -> None:
        self._life = life
        self._to_tell: list[tuple[int, PlacesFreed]] = []
        """Version of the table, and the freed places to report once it counts."""
        self._keeping: dict[str, tuple[int, str]] = {}
        """Vehicle that is being put back -> number of the removal, and the place to reserve."""
        self._kept: dict[str, tuple[int, str]] = {}
        """The same for reserved places that were reported."""
        self.unaware: set[str] = set()

    def take_over(self, atvs: Iterable[str]) -> None:
        """Start with a table that was taken over, in which these vehicles are carried away."""
        self._to_tell, self._keeping, self.unaware = [], {}, set(atvs)

    def free(self, removal: Removal, places: tuple[str, ...], version: int) -> None:
        """Report a vehicle's places as free once this version of the table counts."""
        self.unaware.add(removal.atv)
        if places:
            freed = PlacesFreed(
                atv=removal.atv, number=removal.number, by=removal.grant.person, places=places[:HOLDS_MAX]
            )
            self._to_tell.append((version, freed))

    def is_kept(self, removal: Removal, place: str) -> bool:
        """Whether that place is reserved for the vehicle, and reported."""
        return self._kept.get(removal.atv) == (removal.number, place)

    def keep(self, removal: Removal, place: str) -> None:
        """Reserve a place for a vehicle that is being put back."""
        self._keeping[removal.atv] = (removal.number, place)

    def is_being_put_back(self, atv: str) -> bool:
        """Whether a place is requested for the vehicle, and not reserved yet."""
        return atv in self._keeping

    def tell(self, table: ReservationTable, counted: int) -> None:
        """Report to people the places that were freed and reserved, once that counts."""
        for version, fact in self._to_tell:
            if version <= counted:
                self._life.record(fact)
        self._to_tell = [told for told in self._to_tell if told[0] > counted]
        for atv, (number, place) in tuple(self._keeping.items()):
            line = next((line for line in table.of(atv) if line.place == place), None)
            if line is not None and line.number <= counted:
                self._kept[atv] = self._keeping.pop(atv)
                self._life.record(PlaceKept(atv=atv, number=number, place=place))


def absent(district: str, removal: Removal, place: str, epoch: int) -> PlaceRequested:
    """A request in the name of a vehicle that is off the floor, for the place where it is being put back, if any.

    Args:
        district: of the table.
        removal: the person's report.
        place: where it is being put back; empty when that is outside the district.
        epoch: of the table.
    """
    return PlaceRequested(
        district=district,
        life=removal.life,
        seq=0,
        epoch=epoch,
        rank=(0, FIRST_S, removal.atv),
        holds=(),
        groups=((place,),) if place else (),
        seen=0,
        stands=True,
        docked=False,
        avoid=(removal.node,) if place else (),
        removal=removal.number,
    )
