"""The coordinator of tasks: announced, contracted, closed; several at a time.

A machine coordinates its transports (`transports`), the strategist its goals (`goal_auctions`). This class has
their common part; it leaves the contractor's progress on a task to them.

    AUCTION --accepted--> CONTRACTED --delivered, withdrawn--> closed
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from msgspec.structs import replace

from dray.messages import (
    Accepted,
    Bid,
    Declined,
    Reason,
    Refusal,
    Release,
    Role,
    TakenOver,
    Transport,
    Withdrawn,
    Work,
)
from dray.messages.fact import Outcome, TaskClosed
from dray.protocol.contract_net.auction import Auction
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.auctions import Auctions
from dray.protocol.contract_net.changes import ContractChanged
from dray.protocol.contract_net.task import CarrierContract, ClosedTask, OpenTask
from dray.protocol.contract_net.task_state import TaskState
from dray.protocol.contract_net.terms import Place, Terms
from dray.protocol.contract_net.trust.assessment import Assessor
from dray.protocol.contract_net.trust.plausibility import by_our_clock
from dray.protocol.liveness.suspicion import ArrivalStatistics
from dray.protocol.runtime.bounded_map import BoundedMap
from dray.protocol.runtime.life import Life

CLOSED_KEPT = 1024
"""Closed tasks for which late questions are answered: a day of one machine's work."""

PRIMARY_AUCTION = "primary auction"


class Coordinator:
    """All open tasks of one coordinating agent.

    Args:
        agent: the coordinator's id.
        place: where it stands.
        rules: the auctions' time-outs and radius.
        life: the agent's life; alarms are named ``(PRIMARY_AUCTION, task)``.
        assessor: checks bids and adds surcharges.
        arrivals: arrival statistics of heartbeats; None if the agent follows nobody.

    Attributes:
        alarms: handlers of this class's alarms, called with (task, now_s).
    """

    def __init__(
        self,
        agent: str,
        place: Place,
        rules: AuctionRules,
        life: Life,
        assessor: Assessor,
        arrivals: ArrivalStatistics | None = None,
    ) -> None:
        self._rules = rules
        self._life = life
        self._open: dict[str, OpenTask] = {}
        self._closed: BoundedMap[str, ClosedTask] = BoundedMap(CLOSED_KEPT)
        self._assessor = assessor
        self._auctions = Auctions(agent, place, self._audience, life, arrivals, assessor)
        self.alarms: dict[str, Callable[[str, float], None]] = {PRIMARY_AUCTION: self._wake_auction}

    def __iter__(self) -> Iterator[OpenTask]:
        return iter(self._open.values())

    def __len__(self) -> int:
        return len(self._open)

    @property
    def awaits_answers(self) -> bool:
        """Whether an answer to any task's auction may still arrive."""
        return any(task.auction.awaits_answers for task in self)

    def get(self, task: str) -> OpenTask | None:
        return self._open.get(task)

    def closed(self, task: str) -> ClosedTask | None:
        return self._closed.get(task)

    def knows(self, task: str, epoch: int) -> bool:
        """Whether it can tell what has become of a task in an epoch.

        Of a task that it learned of from a carrier, after it had lost its notes, it knows no epoch before that carrier's.
        """
        known = self._open.get(task) or self._closed.get(task)
        return known is not None and not (known.recovered and epoch < known.epoch)

    # --- the life of a task ---

    def open(self, task: str, work: Work, deadline_s: float, now_s: float, *, epoch: int = 1) -> OpenTask:
        """Put a task up for auction."""
        opened = OpenTask(task, work, self._auction(task, epoch, work, deadline_s), now_s)
        self._open[task] = opened
        self._announce(opened, now_s)
        return opened

    def close(self, task: OpenTask, outcome: Outcome) -> None:
        """End a task; release its contractors, except one that has delivered."""
        contract = task.contract
        carrier = contract.primary
        task.auction.cancel()
        self._life.cancel((PRIMARY_AUCTION, task.id))
        self._let_go(task, Reason.TASK_ENDED)
        if carrier and outcome == "withdrawn":
            withdrawn = Withdrawn(task=task.id, epoch=task.epoch, reason=Reason.NOT_NEEDED)
            self._life.send(carrier, withdrawn)
        fact = TaskClosed(
            task=task.id,
            epoch=task.epoch,
            outcome=outcome,
            carrier=carrier,
            promised_s=contract.promised_s,
        )
        self._life.record(fact)
        task.states.enter(TaskState(outcome))
        del self._open[task.id]
        self._closed[task.id] = ClosedTask(carrier, task.epoch, outcome, recovered=task.recovered)

    # --- messages ---

    def on_bid(self, sender: str, bid: Bid, now_s: float) -> None:
        task = self._present(bid)
        if task is None:
            self._life.ignore("a bid for a task or an epoch that has ended")
        elif bid.role is Role.PRIMARY:
            task.auction.on_bid(sender, bid, now_s)
            self._auctions.arm(PRIMARY_AUCTION, task.auction)

    def on_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        task = self._present(answer)
        if task is None:
            self._release(sender, answer, Reason.TASK_ENDED)
        elif answer.role is not Role.PRIMARY:
            return
        elif task.primary == sender:
            # The contract stands across restarts of either side: a restarted carrier accepts again.
            self._life.ignore("a second acceptance of one award")
        elif task.primary:
            self._release(sender, answer, Reason.ANOTHER_CARRIES)
        elif self._assessor.refuses_clock(sender, answer, now_s):
            self._release(sender, answer, Reason.CLOCK_WRONG)
            declined = Declined(answer.task, answer.epoch, answer.role, Refusal.NOT_FIT, answer.number)
            self.on_declined(sender, declined, now_s)
        else:
            answer = by_our_clock(answer, now_s)
            task.auction.on_accepted(sender, answer)
            if task.auction.winner == sender and not task.primary:
                self._contract(task, sender, answer, now_s)

    def on_declined(self, sender: str, answer: Declined, now_s: float) -> None:
        task = self._present(answer)
        if task is None:
            self._life.ignore("a refusal of a task or an epoch that has ended")
        elif answer.role is Role.PRIMARY:
            task.auction.on_declined(sender, answer, now_s)
            self._auctions.arm(PRIMARY_AUCTION, task.auction)

    # --- what each coordinator does in its own way ---

    def _audience(self, work: Work, radius_m: float) -> tuple[str, ...]:
        """The bus keys of the agents to ask for a work within a radius (m)."""
        raise NotImplementedError

    def _contracted(self, task: OpenTask, now_s: float) -> None:
        """A task has a contractor."""
        self._life.note(ContractChanged(task))

    def _bound(self, task: OpenTask, runners_up: tuple[tuple[str, Bid], ...], now_s: float) -> None:
        """Called when a task has a contractor; `runners_up` are the other bids, cheapest first."""

    def _let_go(self, task: OpenTask, reason: Reason) -> None:
        """Release every contractor that is bound by a task."""

    # --- internals ---

    def _present(self, message: Bid | Accepted | Declined) -> OpenTask | None:
        """The open task of a message of the present epoch; else None."""
        task = self._open.get(message.task)
        return task if task is not None and task.epoch == message.epoch else None

    def _auction(
        self,
        task: str,
        epoch: int,
        work: Work,
        deadline_s: float,
        candidates: tuple[tuple[str, Bid], ...] = (),
    ) -> Auction:
        terms = Terms(task=task, epoch=epoch, role=Role.PRIMARY, work=work, deadline_s=deadline_s)
        return self._auctions.prepare(terms, self._rules, candidates)

    def _announce(self, task: OpenTask, now_s: float) -> None:
        task.auction.open(now_s)
        self._auctions.arm(PRIMARY_AUCTION, task.auction)

    def _wake_auction(self, task_id: str, now_s: float) -> None:
        task = self._open.get(task_id)
        if task is not None:
            task.auction.wake(now_s)
            self._auctions.arm(PRIMARY_AUCTION, task.auction)

    def _contract(self, task: OpenTask, contractor: str, answer: Accepted, now_s: float) -> None:
        auction = task.auction
        bid = auction.winning_bid
        # An old bid for the watch says nothing of the ways from where the contractor is now.
        fresh = bid if auction.round else None
        source = bid.source if bid is not None else ""
        promised_s = self._assessor.believed_s(task.work, fresh, answer.finish_s, now_s)
        task.assign(CarrierContract(contractor, source, promised_s, now_s))
        if source and isinstance(task.work, Transport):
            # From now on the load is there and nowhere else: a successor fetches it there, too.
            task.work = replace(task.work, sources=(source,))
        # This life sees the loading itself, even if an earlier life missed something.
        task.witnessed = True
        self._life.cancel((PRIMARY_AUCTION, task.id))
        self._bound(task, auction.left_over, now_s)
        self._contracted(task, now_s)

    def _release(self, to: str, said: Accepted | TakenOver, reason: Reason) -> None:
        """Release a contractor from an award."""
        role, number = (said.role, said.number) if isinstance(said, Accepted) else (Role.PRIMARY, 0)
        release = Release(task=said.task, epoch=said.epoch, role=role, reason=reason, number=number)
        self._life.send(to, release)
