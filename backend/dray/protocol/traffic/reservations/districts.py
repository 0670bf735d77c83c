"""The reservation tables that one machine or station leads or copies."""

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
        places: the districts and their replicas.
        atvs: the vehicles of the plant.
        kept: district -> the copy that an earlier run has stored; no entry when it is lost, or there was none.
        neighbours: what is known of the vehicles.
        impostors: reports agents that speak in a vehicle's name.
        key_of: the bus key on which a district's vehicles are published.
        is_signed: whether a vehicle's request is signed by the key that it names.

    Attributes:
        districts: those of which this agent is a replica, by name.
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
        """Start every district."""
        for district in self.districts.values():
            district.start(now_s)

    def on_message(self, sender: str, name: str, message: Message, now_s: float) -> bool:
        """Handle a message about a district; False when this agent is no replica of it."""
        district = self.districts.get(name)
        if district is None:
            return False
        district.on_message(sender, message, now_s)
        return True

    def tick(self, name: str, now_s: float) -> None:
        """Handle a district's alarm."""
        self.districts[name].tick(now_s)

    def on_vehicle(self, atv: str, life: int, removal: int | None, now_s: float, *, is_news: bool) -> None:
        """A vehicle's heartbeat has come.

        Args:
            atv: the vehicle.
            life: its incarnation.
            removal: its newest known removal; None when the heartbeat has no traffic fields.
            now_s: the present time.
            is_news: whether its state has changed.
        """
        for district in self.districts.values():
            district.on_vehicle(atv, life, removal, now_s, is_news=is_news)

    def awaited(self, now_s: float) -> set[str]:
        """Vehicles whose missing answers keep some district from granting anything."""
        return {atv for district in self.districts.values() for atv in district.awaited(now_s)}

    def on_carried(self, atv: str) -> None:
        """A person has carried a vehicle away."""
        for district in self.districts.values():
            district.copies.on_carried(atv)
