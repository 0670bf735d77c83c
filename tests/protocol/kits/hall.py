"""An auction in a hall of its own, for tests: its rules, its time, and who is called."""

from __future__ import annotations

from credulous import Credulous
from effects import award_number, facts, sent
from spoken import accepted, bid, declined, transport

from dray.messages import Bid, Refusal, Release, Role
from dray.messages.fact import AwardAnswered, AwardGiven
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.terms import Place, Terms
from dray.protocol.runtime.events import NEVER_S
from dray.protocol.runtime.life import Life

RULES = AuctionRules()

REACH_M = 80.0


class Hall:
    """An auction and the time in its room."""

    def __init__(
        self,
        *,
        deadline_s: float = 300.0,
        role: Role = Role.PRIMARY,
        epoch: int = 1,
        rules: AuctionRules = RULES,
        reach_m: float = REACH_M,
        candidates: tuple[tuple[str, Bid], ...] = (),
        opened: bool = True,
    ) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.radii_m: list[float] = []
        self.now_s = 0.0
        terms = Terms(
            task="T1",
            epoch=epoch,
            role=role,
            work=transport(),
            deadline_s=deadline_s,
            primary="ATV9" if role is Role.SECONDARY else "",
        )
        place = Place(x_m=30.0, y_m=15.0, reach_m=reach_m)
        self.auction = Auction("M8", terms, place, self._audience, rules, self.life, Credulous(), candidates)
        if opened:
            self.auction.open(0.0)

    def _audience(self, radius_m: float) -> tuple[str, ...]:
        self.radii_m.append(radius_m)
        return ("plant/task/0_0", "plant/task/1_0")

    def bids(self, **costs_s: float) -> None:
        for bidder, cost_s in costs_s.items():
            self.auction.on_bid(bidder, bid(cost_s, round=self.auction.round), self.now_s)

    def accepts(self, bidder: str) -> None:
        """It answers the newest award that it was sent."""
        role = self.auction.terms.role
        answer = accepted(role=role, number=award_number(self.life.effects, bidder, role=role))
        self.auction.on_accepted(bidder, answer)

    def declines(self, bidder: str, reason: Refusal = Refusal.BUSY) -> None:
        role = self.auction.terms.role
        answer = declined(role=role, reason=reason, number=award_number(self.life.effects, bidder, role=role))
        self.auction.on_declined(bidder, answer, self.now_s)

    def wait(self) -> None:
        """Until the auction wants to be woken."""
        assert self.auction.wake_at_s < NEVER_S
        self.now_s = max(self.now_s, self.auction.wake_at_s)
        self.auction.wake(self.now_s)

    def wait_for_award(self) -> None:
        """Until somebody is asked."""
        count = len(self.asked)
        while len(self.asked) == count:
            self.wait()

    @property
    def asked(self) -> list[str]:
        """Everybody who was asked, in order."""
        return [fact.bidder for fact in facts(self.life.effects, AwardGiven)]

    @property
    def answers(self) -> list[str]:
        return [fact.reason or fact.answer for fact in facts(self.life.effects, AwardAnswered)]

    def released(self) -> list[str]:
        return [effect.to for effect in self.life.effects if sent([effect], Release)]
