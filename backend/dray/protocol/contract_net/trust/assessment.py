"""How a coordinator assesses bids: what cannot be is refused, and who has broken promises must be cheaper for it.

One place for what an auction asks of a bid beside its price: `plausibility` knows the plant, `reliability` the past.
"""

from __future__ import annotations

from dray.messages import Accepted, Bid, Implausible, TakenOver, Work
from dray.plant import Plant
from dray.plant.restrictions import OPEN
from dray.protocol.contract_net.trust.disbelief import Disbelief
from dray.protocol.contract_net.trust.plausibility import Plausibility, clock_ahead_s, is_clock_wrong
from dray.protocol.contract_net.trust.probation import SHORT_S, is_barred
from dray.protocol.contract_net.trust.reliability import Reliability
from dray.protocol.liveness.progress import STALL_S, Progress
from dray.protocol.runtime.life import Life

RESTRICTED = "a bid for a long task by one that is given short ones only"


class Assessor:
    """Assesses the bids of one coordinator.

    Args:
        plant: where the ways are.

    Attributes:
        reliability: what was learned of every contractor.
    """

    def __init__(self, plant: Plant, life: Life) -> None:
        self._plant = plant
        self._plausibility = Plausibility(plant)
        self.reliability = Reliability(life)
        self.handling_max_s = self._plausibility.handling_max_s
        """The longest loading or unloading of the plant."""
        self._life = life
        self._disbelief = Disbelief(life)

    def refuses(self, bidder: str, work: Work, bid: Bid, now_s: float) -> bool:
        """Whether a bid does not count, by our clock; it is counted why, and said where it cannot be true."""
        if objection := self._plausibility.objection(work, bid, now_s):
            self._disbelief.tell(bidder, bid, objection, now_s, clock_ahead_s(bid.at_s, now_s))
            return True
        if self.reliability.is_restricted(bidder, now_s):
            # That it would be short is its own word, and for a task that it has dropped that is not good enough.
            short = bid.finish_s - now_s <= SHORT_S and not self.reliability.has_dropped(bidder, bid.task)
            if is_barred(short=short, round_number=bid.round):
                self._life.ignore(RESTRICTED)
                return True
        return False

    def refuses_clock(self, speaker: str, said: Accepted | TakenOver, now_s: float) -> bool:
        """Whether a promise was made by a clock that is not made up for; its speaker is told."""
        if not is_clock_wrong(said, now_s):
            return False
        self._disbelief.tell(speaker, said, Implausible.CLOCK, now_s, clock_ahead_s(said.at_s, now_s))
        return True

    @property
    def is_floor_restricted(self) -> bool:
        """Whether people have closed something: who has no way then is not to blame."""
        return self._plant.restrictions != OPEN

    def surcharge_s(self, bidder: str, now_s: float) -> float:
        """What is added to a bid before it is ranked."""
        return self.reliability.surcharge_s(bidder, now_s)

    def believed_s(self, work: Work, bid: Bid | None, promised_s: float, now_s: float) -> float:
        """Until when a contractor is believed to be done (see `Plausibility.believed_s`)."""
        return self._plausibility.believed_s(work, bid, promised_s, now_s)

    def latest_s(self, work: Work, now_s: float) -> float:
        """When a transport that is under way is done at the latest."""
        return now_s + self._plausibility.longest_s(work)

    def progress(self, promised_s: float, now_s: float) -> Progress:
        """The progress that is expected of a carrier that is believed to be done at `promised_s`."""
        return Progress(promised_s, STALL_S + self._plausibility.handling_max_s, now_s)
