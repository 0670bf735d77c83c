"""How a coordinator assesses bids: it refuses implausible ones and adds a surcharge for broken promises.

`plausibility` knows the plant, `reliability` the past.
"""

from __future__ import annotations

from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    Bid,
    Implausible,
    Link,
    Reason,
    TakenOver,
    Transport,
    Work,
)
from dray.plant import Plant
from dray.plant.restrictions import OPEN
from dray.protocol.contract_net.dock import dock_of
from dray.protocol.contract_net.trust.disbelief import Disbelief
from dray.protocol.contract_net.trust.dock_failures import DockFailures, Failure, Fault
from dray.protocol.contract_net.trust.plausibility import Plausibility, clock_ahead_s, is_clock_wrong
from dray.protocol.contract_net.trust.probation import SHORT_S, is_barred
from dray.protocol.contract_net.trust.reliability import Reliability
from dray.protocol.liveness.progress import STALL_S, Progress
from dray.protocol.runtime.life import Life

RESTRICTED = "a bid for a long task by a bidder that gets short ones only"


class Assessor:
    """Assesses the bids of one coordinator.

    Args:
        plant: its ways.

    Attributes:
        reliability: the ratings of contractors.
        docks: docks at which carriers stood in vain.
    """

    def __init__(self, plant: Plant, life: Life) -> None:
        self._plant = plant
        self._plausibility = Plausibility(plant)
        self.reliability = Reliability(life)
        self.docks = DockFailures()
        self.handling_max_s = self._plausibility.handling_max_s
        """The plant's longest loading or unloading (s)."""
        self._life = life
        self._disbelief = Disbelief(life)

    def refuses(self, bidder: str, work: Work, bid: Bid, now_s: float) -> bool:
        """Whether a bid does not count; the reason is counted, and an implausible bidder is told."""
        if objection := self._plausibility.objection(work, bid, now_s):
            self._disbelief.tell(bidder, bid, objection, now_s, clock_ahead_s(bid.at_s, now_s))
            return True
        if self.reliability.is_restricted(bidder, now_s):
            # The short duration is the bidder's own claim, which does not suffice for a task that it has
            # dropped.
            short = bid.finish_s - now_s <= SHORT_S and not self.reliability.has_dropped(bidder, bid.task)
            if is_barred(short=short, round_number=bid.round):
                self._life.ignore(RESTRICTED)
                return True
        return False

    def refuses_clock(self, speaker: str, said: Accepted | TakenOver, now_s: float) -> bool:
        """Whether a promise comes from a clock too wrong to correct; its sender is told."""
        if not is_clock_wrong(said, now_s):
            return False
        self._disbelief.tell(speaker, said, Implausible.CLOCK, now_s, clock_ahead_s(said.at_s, now_s))
        return True

    @property
    def is_floor_restricted(self) -> bool:
        """Whether people have closed something: a vehicle without a way is then not to blame."""
        return self._plant.restrictions != OPEN

    def surcharge_s(self, bidder: str, now_s: float) -> float:
        """Added to a bid before it is ranked (s)."""
        return self.reliability.surcharge_s(bidder, now_s)

    def stands_in_vain(self, work: Transport, place: str, heartbeat: AtvHeartbeat) -> bool:
        """Whether a carrier that has stalled says something of a place: it stands at that dock, and nothing is wrong with it.

        A carrier without WLAN, in error, or stopped by a person is held up by that.
        """
        if place == work.handed_at or not self._plant.has_place(place):
            return False
        held_up = bool(heartbeat.problem) or heartbeat.help is not None or heartbeat.link is not Link.WLAN
        is_well = heartbeat.status is AtvStatus.WORKING and not held_up
        return is_well and heartbeat.node == dock_of(self._plant, work, place)

    def note_dock_failure(
        self, place: str, item: str, reason: Reason, carrier: str, task: str, now_s: float
    ) -> Fault:
        """Note that a carrier stood at a place in vain. Returns who is at fault.

        A restricted carrier accuses a place only if nobody else takes its task, and one that accuses another place accuses no
        second one.
        """
        believed = not self.reliability.is_restricted(carrier, now_s)
        fault, before = self.docks.note(place, item, reason, Failure(carrier, task), believed=believed)
        if before is not None:
            self.reliability.take_back(before.carrier, before.task, now_s)
        return fault

    def believed_s(self, work: Work, bid: Bid | None, promised_s: float, now_s: float) -> float:
        """Credible finish time of a contractor (see `Plausibility.believed_s`)."""
        return self._plausibility.believed_s(work, bid, promised_s, now_s)

    def latest_s(self, work: Work, now_s: float) -> float:
        """Latest finish time of a transport that is under way."""
        return now_s + self._plausibility.longest_s(work)

    def progress(self, promised_s: float, now_s: float) -> Progress:
        """The expected progress of a carrier with the credible finish `promised_s`."""
        return Progress(promised_s, STALL_S + self._plausibility.handling_max_s, now_s)
