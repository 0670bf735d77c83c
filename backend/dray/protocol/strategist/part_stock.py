"""The stock of parts in a plant, by heartbeats to the strategist.

The stock of an agent that was silent for a minute does not count; it counts again when the agent is back.
"""

from __future__ import annotations

from collections import Counter

from msgspec import UNSET

from dray.messages import AtvHeartbeat, MachineHeartbeat, StationHeartbeat
from dray.messages.heartbeat_stock import with_stock
from dray.plant import Plant
from dray.protocol.runtime.bounded_map import BoundedMap

COUNTS_S = 60.0
"""Time for which an agent's stock counts after its last heartbeat (s)."""

AGENTS_MAX = 4096
"""Maximum agents with parts, more than a large plant has; the one silent for longest is forgotten first."""


class PartStock:
    """The parts of one plant.

    Args:
        plant: its parts and their machines.
    """

    def __init__(self, plant: Plant) -> None:
        self._plant = plant
        self._told: BoundedMap[str, MachineHeartbeat] = BoundedMap(AGENTS_MAX)
        self._lies: BoundedMap[str, tuple[float, Counter[str]]] = BoundedMap(AGENTS_MAX)
        """By agent: time of its last heartbeat and its parts; only agents with parts."""

    def on_machine(self, heartbeat: MachineHeartbeat, now_s: float) -> None:
        """Note a machine's buffers and spare goods."""
        told = self._told[heartbeat.machine] = with_stock(heartbeat, self._told.get(heartbeat.machine))
        lies: Counter[str] = Counter()
        for buffer in () if told.buffers is UNSET else told.buffers:
            lies[buffer.item] += buffer.level
        for goods in () if told.goods is UNSET else told.goods:
            lies[goods.item] += goods.spare
        self._note(heartbeat.machine, lies, now_s)

    def on_station(self, _sender: str, heartbeat: StationHeartbeat, now_s: float) -> None:
        """Note a storage's stock."""
        lies = Counter({stock.item: stock.level for stock in heartbeat.stocks})
        self._note(heartbeat.station, lies, now_s)

    def on_vehicle(self, _sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note a vehicle's load, unless it goes to a customer: a machine sends away only goods, and never material."""
        task = heartbeat.task
        makers = self._plant.machines_for(heartbeat.load)
        wanted = heartbeat.load and not (task is not None and task.coordinator in makers)
        lies = Counter({heartbeat.load: heartbeat.load_quantity}) if wanted else Counter[str]()
        self._note(heartbeat.atv, lies, now_s)

    def lies(self, part: str, now_s: float) -> int:
        """Pieces in stock, as far as was heard."""
        return sum(lies[part] for heard_s, lies in self._lies.values() if now_s < heard_s + COUNTS_S)

    def excuse(self, span_s: float) -> None:
        """The strategist was deaf for this long."""
        for agent, (heard_s, lies) in self._lies.items():
            self._lies[agent] = heard_s + span_s, lies

    def _note(self, agent: str, lies: Counter[str], now_s: float) -> None:
        parts = Counter({item: n for item, n in lies.items() if n and item in self._plant.parts})
        self._lies.pop(agent, None)
        if parts:
            self._lies[agent] = now_s, parts
