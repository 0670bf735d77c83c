"""The stations of storages and the delivery gate, as panels see them: the last heartbeat of each."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping

from msgspec import UNSET

from dray.gateway.live.projection.agents.atvs import clock_of
from dray.gateway.live.projection.agents.loads import doubts_of, loads_of
from dray.gateway.live.projection.agents.outsiders import Outsiders
from dray.gateway.live.projection.agents.silence import Silence
from dray.gateway.live.projection.changes import Changes
from dray.gateway.live.views import StationView, StockView, ToComeView
from dray.messages import StationHeartbeat, StockLevel
from dray.messages.keys import GATE
from dray.messages.overtaken import LatestNumbers
from dray.plant.model import Storage
from dray.store.history.clocks import Clocks, ToWall


class Stations:
    """The stations.

    Args:
        storages: storages of the plant file, by id. Only these stations and the gate are heard: storages do
            not join at run time.
        to_wall_s: plant clock to wall clock.
        outsiders: the agents that are shut out.
        clocks: of all agents.
        silence: of all agents.
    """

    def __init__(
        self,
        storages: Mapping[str, Storage],
        to_wall_s: ToWall,
        outsiders: Outsiders,
        clocks: Clocks,
        silence: Silence,
    ) -> None:
        self._storages = storages
        self._to_wall_s = to_wall_s
        self._outsiders, self._clocks, self._silence = outsiders, clocks, silence
        self._last: dict[str, StationHeartbeat] = {}
        self._newest: LatestNumbers[str] = LatestNumbers()
        self.changes = Changes("station")
        self.name_of: Callable[[str], str] = lambda item: item
        """The name of a material or product."""
        self.product_of: Callable[[str], str] = lambda _goal: ""
        """The product of a goal; empty where it is not known."""

    def fold(self, heartbeat: StationHeartbeat, now_s: float) -> bool:
        """Take a heartbeat in, which came at this time of the plant's clock.

        Returns:
            False when it is older than the last one, or from a storage that is not in the plant.
        """
        if heartbeat.station not in self._storages and heartbeat.station != GATE:
            return False
        if not self._newest.takes(heartbeat.station, (heartbeat.incarnation, heartbeat.seq), now_s):
            return False
        self._last[heartbeat.station] = heartbeat
        self.changes.mark(heartbeat.station)
        return True

    def heartbeats(self) -> Iterable[StationHeartbeat]:
        """The last one of each station."""
        return self._last.values()

    def mark(self, agents: Iterable[str]) -> None:
        """Mark these stations as changed, if they were heard."""
        for agent in agents:
            if agent in self._last:
                self.changes.mark(agent)

    def view(self, storage: str) -> StationView | None:
        """One station, or None when it was never heard."""
        heartbeat = self._last.get(storage)
        return None if heartbeat is None else self._view(heartbeat)

    def views(self) -> tuple[StationView, ...]:
        """All of them, by id."""
        return tuple(self._view(self._last[storage]) for storage in sorted(self._last))

    def take_changed(self) -> tuple[StationView, ...]:
        """Those that have changed since the last call."""
        return tuple(self._view(self._last[storage]) for storage in self.changes.take_changed())

    def _name(self, station: str) -> str:
        """A storage's name by the plant file; the gate's id, since panels have words for it."""
        return self._storages[station].name if station in self._storages else station

    def _view(self, heartbeat: StationHeartbeat) -> StationView:
        return StationView(
            id=heartbeat.station,
            name=self._name(heartbeat.station),
            stocks=tuple(_stock(level) for level in heartbeat.stocks),
            software=heartbeat.software,
            draining=heartbeat.draining,
            shut_out=self._outsiders.view(heartbeat.station),
            clock=clock_of(self._clocks, heartbeat.station),
            problem=heartbeat.problem,
            unconfirmed=loads_of(heartbeat.people),
            doubts=doubts_of(heartbeat.doubts, self.name_of),
            to_come=tuple(
                ToComeView(goal=each.goal, product=self.product_of(each.goal), quantity=each.quantity)
                for each in (() if heartbeat.people is UNSET else heartbeat.people.goals)
            ),
            seen_at_s=self._to_wall_s(heartbeat.at_s),
            silence=self._silence.view(heartbeat.station, heartbeat),
        )


def _stock(level: StockLevel) -> StockView:
    return StockView(
        item=level.item,
        level=level.level,
        capacity=level.capacity,
        promised=level.promised,
        wanted=level.wanted,
        on_order=level.on_order,
        uncounted=level.uncounted,
    )
