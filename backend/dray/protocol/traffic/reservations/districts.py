"""The reservation tables that one machine, or station, keeps or has a copy of."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from dray.messages import Message
from dray.protocol.runtime.life import Life
from dray.protocol.traffic.neighbours import Neighbours
from dray.protocol.traffic.places import Places
from dray.protocol.traffic.reservations.copies import Kept
from dray.protocol.traffic.reservations.district import District
from dray.protocol.traffic.reservations.floor_report import FloorReport
from dray.protocol.traffic.reservations.impostors import Impostors
from dray.protocol.traffic.reservations.reach import Reach
from dray.protocol.traffic.traffic_map import IsSigned, names_no_key


class Districts:
    """One agent's part in right of way.

    Args:
        me: the agent.
        places: which districts there are, and who keeps their reservation tables.
        atvs: the vehicles of the plant.
        kept: district -> what an earlier life has left; without an entry it is lost, or there was none.
        neighbours: what is known of the vehicles.
        impostors: tells people of those that speak in a vehicle's name.
        key_of: the bus key on which a district is told.
        is_signed: whether a vehicle's request is signed by the key that it names.

    Attributes:
        districts: those that it keeps, or has copies of, by name.
    """

    def __init__(
        self,
        me: str,
        places: Places,
        atvs: Sequence[str],
        kept: Mapping[str, Kept],
        neighbours: Neighbours,
        impostors: Impostors,
        key_of: Callable[[str], str],
        life: Life,
        is_signed: IsSigned = names_no_key,
    ) -> None:
        reach = Reach(places, neighbours, atvs)
        self.districts = {
            name: District(
                name,
                places.places_in(name),
                me,
                replicas,
                atvs,
                kept.get(name),
                neighbours,
                reach,
                FloorReport(name, key_of(name), neighbours, life),
                impostors,
                life,
                is_signed,
            )
            for name, replicas in places.replicas_of.items()
            if me in replicas
        }

    def start(self, now_s: float) -> None:
        """Begin with every district."""
        for district in self.districts.values():
            district.start(now_s)

    def on_message(self, sender: str, name: str, message: Message, now_s: float) -> bool:
        """A message about a district; False when it is none of this replica's."""
        district = self.districts.get(name)
        if district is None:
            return False
        district.on_message(sender, message, now_s)
        return True

    def tick(self, name: str, now_s: float) -> None:
        """The alarm of a district has come."""
        self.districts[name].tick(now_s)

    def on_vehicle(self, atv: str, life: int, removal: int | None, now_s: float, *, is_news: bool) -> None:
        """A vehicle was heard.

        Args:
            atv: the vehicle.
            life: its incarnation.
            removal: the newest one that it knows of; None where it tells nothing of traffic.
            now_s: when.
            is_news: it tells more than that it is there.
        """
        for district in self.districts.values():
            district.on_vehicle(atv, life, removal, now_s, is_news=is_news)

    def awaited(self, now_s: float) -> set[str]:
        """Vehicles without whose word some district grants nothing."""
        return {atv for district in self.districts.values() for atv in district.awaited(now_s)}

    def on_carried(self, atv: str) -> None:
        """A person has said that a vehicle was carried away."""
        for district in self.districts.values():
            district.copies.on_carried(atv)

    def kept(self) -> list[tuple[str, Kept]]:
        """What must be written down before anything is said, by district."""
        return [
            (name, district.copies.kept)
            for name, district in self.districts.items()
            if not district.copies.lost
        ]
