"""Failures in a plant that can be served: a flat battery, and a carrier that waits for too long."""

from __future__ import annotations

from dataclasses import dataclass

from dray.messages import AtvHeartbeat, AtvStatus, Event, Message, Phase, Role
from dray.messages.fact import BidReceived
from dray.plant import Plant
from dray_sim.bodies.vehicle.condition import BATTERY_EMPTY

BEYOND_PROMISE_S = 120.0
"""A carrier may wait so long beyond its promise."""

WORKS_S = 15.0
"""Time of an undisturbed docking beside the manoeuvre itself: the question, the answer, the handover."""

MOVES_MPS = 0.01


@dataclass(slots=True)
class Waiting:
    """The longest wait of a carrier that stood beyond its promise.

    Attributes:
        beyond_s: from its promise to the last heartbeat in which it stood there with nothing to do.
    """

    atv: str = ""
    task: str = ""
    item: str = ""
    phase: str = ""
    node: str = ""
    beyond_s: float = 0.0


class Watch:
    """A listener for the vehicles' heartbeats.

    A carrier waits when it stands at a dock for longer than its manoeuvre takes.

    Args:
        plant: the durations of manoeuvres.

    Attributes:
        flat: vehicles whose battery was empty, in that order.
        longest: the wait that was longest beyond a promise.
        waits: carriers that waited longer than their promise and `BEYOND_PROMISE_S`, by task.
    """

    def __init__(self, plant: Plant) -> None:
        kinds = {vehicle.id: plant.vehicle_types[vehicle.type] for vehicle in plant.fleet.values()}
        self._works_s = {atv: max(kind.load_s, kind.unload_s) + WORKS_S for atv, kind in kinds.items()}
        self._stands: dict[str, tuple[Phase | None, float]] = {}
        """Present phase, and its beginning."""
        self.flat: dict[str, float] = {}
        self.longest = Waiting()
        self.waits: dict[tuple[str, str], float] = {}
        self._promised_s: dict[tuple[str, str], float] = {}
        """Bid of each vehicle for each task; forgotten when a heartbeat names another task."""
        self._carries: dict[str, str] = {}

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        """See `Listener`."""
        if type(message) is AtvHeartbeat:
            self._note(message)
        elif type(message) is Event and isinstance(bid := message.fact, BidReceived):
            if bid.role is Role.PRIMARY and bid.source and self._carries.get(bid.bidder) != bid.task:
                self._promised_s[bid.bidder, bid.task] = bid.finish_s

    def _note(self, beat: AtvHeartbeat) -> None:
        if beat.status is AtvStatus.ERROR and beat.problem == BATTERY_EMPTY:
            self.flat.setdefault(beat.atv, beat.at_s)
        task = beat.task
        before = self._carries.get(beat.atv)
        if before is not None and (task is None or task.task != before):
            del self._carries[beat.atv]
            self._promised_s = {key: s for key, s in self._promised_s.items() if key[0] != beat.atv}
        if task is None:
            return
        self._carries[beat.atv] = task.task
        if beat.speed_mps > MOVES_MPS or beat.status is not AtvStatus.WORKING:
            self._stands.pop(beat.atv, None)
            return
        phase, since_s = self._stands.get(beat.atv, (None, beat.at_s))
        if phase is not task.phase:
            since_s = beat.at_s
        self._stands[beat.atv] = task.phase, since_s
        promised_s = self._promised_s.get((beat.atv, task.task))
        if promised_s is None or task.phase in (None, Phase.RETURNING):
            return
        beyond_s = beat.at_s - promised_s
        if beat.at_s - since_s <= self._works_s[beat.atv]:
            return
        if beyond_s > BEYOND_PROMISE_S:
            self.waits[beat.atv, task.task] = beyond_s
        if beyond_s > self.longest.beyond_s:
            self.longest = Waiting(beat.atv, task.task, task.item, str(task.phase), beat.node, beyond_s)
