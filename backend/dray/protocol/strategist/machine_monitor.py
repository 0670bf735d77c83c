"""Which machines can work, as their heartbeats tell it to the strategist (paper, case 1).

A machine has failed for its goals when it is silent, or when it has said for long that it is broken; earlier where it offers
them itself, as it judges its breakdown, or because people have taken it out of service.
Nothing is lost by a wrong verdict but work: the gate lets every piece in once, whoever made it.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages import JoiningMachine, MachineHeartbeat, MachineStatus, Production, Reason
from dray.messages.fact import MachineFailure
from dray.messages.heartbeat import JOINING_MACHINES_MAX
from dray.messages.people.command import PROMISE_MAX_S
from dray.plant import Plant
from dray.protocol.liveness.suspicion import BREAKDOWN_S, GOAL_SILENCE_S, ArrivalStatistics
from dray.protocol.runtime.events import NEVER_S


class _LastHeard:
    """What was last heard of one machine."""

    __slots__ = ("broken_s", "heard_s", "is_out", "newest", "waits_s")

    def __init__(self, heard_s: float) -> None:
        self.heard_s = heard_s
        self.newest = (0, 0)
        """Incarnation and number of the newest heartbeat."""
        self.broken_s: float | None = None
        """Since when it says that it is broken; None while it works."""
        self.waits_s = 0.0
        """Until when somebody has promised to come."""
        self.is_out = False
        """It is out of service by a person's word."""

    @property
    def given_up_s(self) -> float:
        """When its goals are taken from it, whatever it says; never while it works."""
        if self.broken_s is None:
            return NEVER_S
        return min(
            max(self.broken_s + BREAKDOWN_S, self.waits_s), self.broken_s + BREAKDOWN_S + PROMISE_MAX_S
        )


class MachineMonitor:
    """All machines of one plant, and those that have come since its file was written.

    Args:
        plant: who can make what, by its file.

    Attributes:
        arrivals: how machines' heartbeats arrive.
    """

    def __init__(self, plant: Plant) -> None:
        self.arrivals = ArrivalStatistics()
        self._plant = plant
        self._heard: dict[str, _LastHeard] = {}
        self._joining: dict[str, JoiningMachine] = {}

    def start(self, now_s: float) -> None:
        """Watch the machines of the plant file; until they have had time to speak all are believed to live."""
        self._heard = {machine: _LastHeard(now_s) for machine in self._plant.machines}

    def on_heartbeat(self, heartbeat: MachineHeartbeat, now_s: float) -> bool:
        """Note a heartbeat; False when it is older than one that was heard, or of no machine here."""
        heard = self._heard.get(heartbeat.machine) or self._welcome(heartbeat, now_s)
        order = (heartbeat.incarnation, heartbeat.seq)
        if heard is None or order <= heard.newest:
            return False
        is_same_life = heartbeat.incarnation == heard.newest[0]
        missed = heartbeat.seq - heard.newest[1] - 1 if is_same_life else 0
        self.arrivals.note(missed, now_s - heartbeat.at_s)
        heard.newest, heard.heard_s = order, now_s
        heard.is_out = heartbeat.out_of_service is not UNSET
        if heartbeat.help is not UNSET and heartbeat.help.promised_by:
            # What is left counts, and not the time when it ends: that is told by another clock.
            heard.waits_s = now_s + heartbeat.help.until_s - heartbeat.at_s
        if heartbeat.status is not MachineStatus.ERROR:
            heard.broken_s, heard.waits_s = None, 0.0
        elif heard.broken_s is None:
            heard.broken_s = now_s
        return True

    def excuse(self, span_s: float) -> None:
        """The strategist's own process was held up for this long: that time does not count as silence of machines."""
        for heard in self._heard.values():
            heard.heard_s += span_s

    def machines_for(self, work: Production) -> tuple[str, ...]:
        """All that can make a goal, those included that the plant file does not know."""
        joining = (
            machine
            for machine, joining in self._joining.items()
            if any(making.product == work.product for making in joining.makes)
        )
        own = (*self._plant.machines_for(work.product), *joining)
        return (*own, *(each.machine for each in work.definition.machines if each.machine not in own))

    def named_for(self, work: Production) -> tuple[str, ...]:
        """Those that can make a goal because its product's definition says so, and do not listen for it by themselves."""
        named = {each.machine for each in work.definition.machines}
        listening = self._plant.machines_for(work.product)
        return tuple(each for each in self.machines_for(work) if each in named and each not in listening)

    def cycle_s(self, work: Production) -> float:
        """The shortest time for a piece, by the plant file, the goal's product, or the machines' own word (s)."""
        product = work.product
        told_s = [self._plant.cycle_s(machine, product) for machine in self._plant.machines_for(product)]
        told_s += [each.cycle_s for each in work.definition.machines]
        told_s += [
            each.cycle_s
            for joining in self._joining.values()
            for each in joining.makes
            if each.product == product
        ]
        return min(told_s, default=0.0)

    def anybody_fit(self, work: Production, now_s: float, besides: str = "") -> bool:
        """Whether anybody lives and works who can make a goal; besides one that offers it, perhaps."""
        others = (machine for machine in self.machines_for(work) if machine != besides)
        return any(not self.failure(machine, now_s) for machine in others)

    def failures(self, work: Production, now_s: float, offered_by: str = "") -> tuple[MachineFailure, ...]:
        """Those that can make a goal and make nothing now; one that offers it and works is closed in."""
        closed_in = {offered_by: Reason.CLOSED}
        failures = (
            (machine, self.failure(machine, now_s) or closed_in.get(machine))
            for machine in self.machines_for(work)
        )
        return tuple(MachineFailure(machine, reason) for machine, reason in failures if reason is not None)

    def failure(self, machine: str, now_s: float) -> Reason | None:
        """Why a machine makes nothing; None when it lives and works."""
        heard = self._heard.get(machine)
        # A joining machine that took a goal in an earlier life of the strategist may never have been heard in this one.
        if heard is None or now_s >= heard.heard_s + GOAL_SILENCE_S:
            return Reason.SILENT
        if heard.broken_s is not None:
            return Reason.BROKEN
        return Reason.OUT_OF_SERVICE if heard.is_out else None

    def is_broken_for_long(self, machine: str, now_s: float) -> bool:
        """Whether it has been broken for longer than anybody waits for."""
        heard = self._heard.get(machine)
        return heard is not None and now_s >= heard.given_up_s

    def _welcome(self, heartbeat: MachineHeartbeat, now_s: float) -> _LastHeard | None:
        """Begin to watch a machine that the plant file does not know, if it says what it is."""
        joining = heartbeat.joining
        if joining is None or len(self._joining) >= JOINING_MACHINES_MAX:
            return None
        self._joining[heartbeat.machine] = joining
        heard = self._heard[heartbeat.machine] = _LastHeard(now_s)
        return heard
