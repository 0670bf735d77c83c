"""The machines that can work, by their heartbeats to the strategist (paper, case 1).

A machine has failed for its goals when it is silent, or broken for long. It has failed earlier if it offers them
itself: by its estimate of a breakdown, or out of service. A wrong verdict costs only work: the gate admits every
piece once, from whichever machine.
"""

from __future__ import annotations

from msgspec import UNSET

from dray.messages import JoiningMachine, MachineHeartbeat, MachineStatus, Production, Reason
from dray.messages.fact import MachineFailure
from dray.messages.heartbeat import JOINING_MACHINES_MAX
from dray.messages.overtaken import LatestNumber
from dray.messages.people.command import PROMISE_MAX_S
from dray.plant import Plant
from dray.protocol.liveness.suspicion import BREAKDOWN_S, GOAL_SILENCE_S, ArrivalStatistics
from dray.protocol.runtime.events import NEVER_S


class _LastHeard:
    """The last state of one machine."""

    __slots__ = ("broken_s", "heard_s", "is_out", "newest", "waits_s")

    def __init__(self, heard_s: float) -> None:
        self.heard_s = heard_s
        self.newest = LatestNumber((0, 0), heard_s)
        """The newest heartbeat, by incarnation and number."""
        self.broken_s: float | None = None
        """Since when it reports a breakdown; None while it works."""
        self.waits_s = 0.0
        """Until when a person has promised to come."""
        self.is_out = False
        """Whether a person has taken it out of service."""

    @property
    def given_up_s(self) -> float:
        """When its goals are taken from it in any case; never while it works."""
        if self.broken_s is None:
            return NEVER_S
        return min(
            max(self.broken_s + BREAKDOWN_S, self.waits_s), self.broken_s + BREAKDOWN_S + PROMISE_MAX_S
        )


class MachineMonitor:
    """All machines of one plant, including those that its file lacks.

    Args:
        plant: the plant with its machines.

    Attributes:
        arrivals: arrival statistics of machines' heartbeats.
    """

    def __init__(self, plant: Plant) -> None:
        self.arrivals = ArrivalStatistics()
        self._plant = plant
        self._heard: dict[str, _LastHeard] = {}
        self._joining: dict[str, JoiningMachine] = {}

    def start(self, now_s: float) -> None:
        """Watch the machines of the plant file; all are assumed to live until they have had time to speak."""
        self._heard = {machine: _LastHeard(now_s) for machine in self._plant.machines}

    def on_heartbeat(self, heartbeat: MachineHeartbeat, now_s: float) -> bool:
        """Note a heartbeat; False if it is older than the last one, or from no machine here."""
        heard = self._heard.get(heartbeat.machine) or self._welcome(heartbeat, now_s)
        if heard is None:
            return False
        life, seq = heard.newest.number
        if not heard.newest.takes((heartbeat.incarnation, heartbeat.seq), now_s):
            return False
        missed = heartbeat.seq - seq - 1 if heartbeat.incarnation == life else 0
        self.arrivals.note(missed, now_s - heartbeat.at_s)
        heard.heard_s = now_s
        heard.is_out = heartbeat.out_of_service is not UNSET
        if heartbeat.help is not UNSET and heartbeat.help.promised_by:
            # The remaining time counts, because the end is told by another clock.
            heard.waits_s = now_s + heartbeat.help.until_s - heartbeat.at_s
        if heartbeat.status is not MachineStatus.ERROR:
            heard.broken_s, heard.waits_s = None, 0.0
        elif heard.broken_s is None:
            heard.broken_s = now_s
        return True

    def excuse(self, span_s: float) -> None:
        """The strategist's own process was held up for this long: machines' silence in that time does not count."""
        for heard in self._heard.values():
            heard.heard_s += span_s

    def machines_for(self, work: Production) -> tuple[str, ...]:
        """All machines for a goal, including those that the plant file lacks."""
        joining = (
            machine
            for machine, joining in self._joining.items()
            if any(making.product == work.product for making in joining.makes)
        )
        own = (*self._plant.machines_for(work.product), *joining)
        return (*own, *(each.machine for each in work.definition.machines if each.machine not in own))

    def named_for(self, work: Production) -> tuple[str, ...]:
        """Machines for a goal by its product's definition, which do not subscribe to it by themselves."""
        named = {each.machine for each in work.definition.machines}
        listening = self._plant.machines_for(work.product)
        return tuple(each for each in self.machines_for(work) if each in named and each not in listening)

    def cycle_s(self, work: Production) -> float:
        """The shortest cycle time by the plant file, the goal's product, or the machines' own data (s)."""
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
        """Whether any machine for a goal lives and works, except `besides`."""
        others = (machine for machine in self.machines_for(work) if machine != besides)
        return any(not self.failure(machine, now_s) for machine in others)

    def failures(self, work: Production, now_s: float, offered_by: str = "") -> tuple[MachineFailure, ...]:
        """Machines for a goal that cannot work; a working one that offers it is closed in."""
        closed_in = {offered_by: Reason.CLOSED}
        failures = (
            (machine, self.failure(machine, now_s) or closed_in.get(machine))
            for machine in self.machines_for(work)
        )
        return tuple(MachineFailure(machine, reason) for machine, reason in failures if reason is not None)

    def failure(self, machine: str, now_s: float) -> Reason | None:
        """Why a machine makes nothing; None if it lives and works."""
        heard = self._heard.get(machine)
        # A joining machine with a goal of an earlier life may never have been heard in this one.
        if heard is None or now_s >= heard.heard_s + GOAL_SILENCE_S:
            return Reason.SILENT
        if heard.broken_s is not None:
            return Reason.BROKEN
        return Reason.OUT_OF_SERVICE if heard.is_out else None

    def is_broken_for_long(self, machine: str, now_s: float) -> bool:
        """Whether it has been broken for longer than goals wait."""
        heard = self._heard.get(machine)
        return heard is not None and now_s >= heard.given_up_s

    def _welcome(self, heartbeat: MachineHeartbeat, now_s: float) -> _LastHeard | None:
        """Begin to watch a machine that the plant file lacks, if it publishes its data."""
        joining = heartbeat.joining
        if joining is None or len(self._joining) >= JOINING_MACHINES_MAX:
            return None
        self._joining[heartbeat.machine] = joining
        heard = self._heard[heartbeat.machine] = _LastHeard(now_s)
        return heard
