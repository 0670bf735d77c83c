"""The coordinator of tasks: from the first announcement to the end, several at a time.

A machine coordinates its transports, the strategist the production goals; both through this class.
Where its agent wants a watch, every task has a secondary (`secondaries`), and its primary is replaced
when it fails (`failover`).

    AUCTION --accepted--> CARRIED --delivered, withdrawn--> closed
       ^                    |  ^
       |                    |  +-- taken over: epoch + 1, another carrier
       +--- epoch + 1 ------+ nobody carries it any more; where its primary has given it
                              back, the secondary is asked before anything is announced
"""

from __future__ import annotations

from collections.abc import Callable, Iterator

from dray.memory import TaskMemory
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    Bid,
    Brief,
    Confirmed,
    Declined,
    Release,
    Resigned,
    Role,
    Superseded,
    TakenOver,
    Withdrawn,
    Work,
)
from dray.messages.fact import CarrierChanged, TaskClosed
from dray.protocol.auction import Auction, AuctionRules, Place, Terms
from dray.protocol.auctions import Auctions
from dray.protocol.events import Effect, Ignore, Record, Send
from dray.protocol.failover import Failover
from dray.protocol.secondaries import Secondaries
from dray.protocol.supervision import Following
from dray.protocol.suspicion import IDLE_INTERVAL_S, WORKING_INTERVAL_S
from dray.protocol.tasks import ClosedTask, OpenTask, Outcome
from dray.protocol.timers import Timers

CLOSED_KEPT = 1024
"""Closed tasks that late questions are still answered for: a day of one machine's work."""

ADOPT_S = 10.0
"""How long a coordinator that was started again listens for vehicles that work for it: many heartbeats."""

PRIMARY_AUCTION = "primary auction"


def _do_nothing(*_args: object) -> None:
    """For an owner that has nothing to do then."""


class Coordinator:
    """All open tasks of one coordinating agent.

    Args:
        agent: the coordinator's id.
        place: where it stands.
        audience: for a task's work and a radius (m), the bus keys of those to ask.
        rules: the auction's patience and reach.
        timers: the agent's alarms; this class uses names ``(kind, task)``.
        following: which heartbeats the agent hears; None where contractors are not watched.
        out: where effects go.
        contracted: called when a task has got its primary, another one, or is without one again.
        lost: called when goods are given up with the vehicle that had them on board.
        left: called with a vehicle that does not carry a task any more.
        unloaded: called when a task has ended because its load is down, though nobody has said so.

    Attributes:
        alarms: what its agent calls when an alarm of this class has come, with (task, now_s).
    """

    def __init__(
        self,
        agent: str,
        place: Place,
        audience: Callable[[Work, float], tuple[str, ...]],
        rules: AuctionRules,
        timers: Timers,
        following: Following | None,
        out: list[Effect],
        contracted: Callable[[OpenTask, float], None],
        *,
        lost: Callable[[OpenTask, float], None] = _do_nothing,
        left: Callable[[str], None] = _do_nothing,
        unloaded: Callable[[OpenTask, float], None] = _do_nothing,
    ) -> None:
        self._rules = rules
        self._timers = timers
        self._out = out
        self._contracted = contracted
        self._lost = lost
        self._left = left
        self._unloaded = unloaded
        self._open: dict[str, OpenTask] = {}
        self._closed: dict[str, ClosedTask] = {}
        hearing = following.hearing if following is not None else None
        self._auctions = Auctions(agent, place, audience, timers, out, hearing)
        self.alarms: dict[str, Callable[[str, float], None]] = {PRIMARY_AUCTION: self._wake_auction}
        self._secondaries: Secondaries | None = None
        self._failover: Failover | None = None
        if following is not None:
            self._secondaries = Secondaries(self._open, self._auctions, following, timers, out)
            self._failover = Failover(self._open, self._secondaries, following, timers, out, self)
            self.alarms |= self._secondaries.alarms | self._failover.alarms

    def __iter__(self) -> Iterator[OpenTask]:
        return iter(self._open.values())

    def __len__(self) -> int:
        return len(self._open)

    @property
    def awaits_answers(self) -> bool:
        """Whether a carrier is sought for any task, and somebody may be about to answer."""
        return any(task.auction.awaits_answers for task in self)

    def get(self, task: str) -> OpenTask | None:
        return self._open.get(task)

    def closed(self, task: str) -> ClosedTask | None:
        return self._closed.get(task)

    def superseded(self, task_id: str, epoch: int) -> Superseded:
        """What to tell somebody who believes to carry a task in this epoch, and does not."""
        task, closed = self._open.get(task_id), self._closed.get(task_id)
        if task is not None:
            return Superseded(task=task_id, epoch=task.epoch)
        # Of a task that has ended no epoch is right any more, also not one that was never heard of.
        return Superseded(task=task_id, epoch=max(closed.epoch, epoch) if closed is not None else 0)

    # --- the life of a task ---

    def open(self, task: str, work: Work, deadline_s: float, now_s: float, *, epoch: int = 1) -> OpenTask:
        """Put a task up for auction."""
        opened = OpenTask(task, work, self._auction(task, epoch, work, deadline_s), now_s)
        self._open[task] = opened
        self._announce(opened, now_s)
        return opened

    def close(self, task: OpenTask, outcome: Outcome) -> None:
        """End a task; whoever is bound by it, except a carrier that has delivered, is let go."""
        carrier = task.primary
        task.auction.cancel()
        self._timers.clear((PRIMARY_AUCTION, task.id))
        self._unbind(task, "the task has ended")
        if carrier and outcome == "withdrawn":
            withdrawn = Withdrawn(task=task.id, epoch=task.epoch, reason="not needed any more")
            self._out.append(Send(carrier, withdrawn))
        fact = TaskClosed(
            task=task.id, epoch=task.epoch, outcome=outcome, carrier=carrier, promised_s=task.promised_s
        )
        self._out.append(Record(fact))
        del self._open[task.id]
        self._closed[task.id] = ClosedTask(carrier, task.epoch, outcome)
        if len(self._closed) > CLOSED_KEPT:
            del self._closed[next(iter(self._closed))]

    # --- without a carrier (`dray.protocol.failover.Remedies`) ---

    def reopen(self, task: OpenTask, reason: str, now_s: float) -> None:
        """Announce a task anew, with a higher epoch; whoever carried it is superseded."""
        self._replace(task, (), reason, now_s)

    def pass_on(self, task: OpenTask, reason: str, now_s: float) -> None:
        """Ask the secondary of a task to carry it, with a higher epoch; announce it when that will not."""
        heir = self._secondaries.heir(task) if self._secondaries is not None else ()
        self._replace(task, heir, reason, now_s)

    def _replace(
        self, task: OpenTask, candidates: tuple[tuple[str, Bid], ...], reason: str, now_s: float
    ) -> None:
        replaced, silent_s = self._supersede(task, task.epoch + 1, reason, now_s)
        deadline_s = _prolonged_s(task.due_s, task.opened_s, now_s)
        task.auction = self._auction(task.id, task.epoch, task.work, deadline_s, candidates)
        self._note_change(task, replaced, reason, silent_s)
        self._announce(task, now_s)
        self._contracted(task, now_s)

    def wait(self, task: OpenTask, trouble: str, now_s: float) -> None:
        """Let a task wait for its carrier, and say why."""
        task.trouble = trouble
        self._contracted(task, now_s)

    def give_up(self, task: OpenTask, now_s: float) -> None:
        """Goods are lost with their carrier."""
        self.close(task, "withdrawn")
        self._lost(task, now_s)

    def conclude(self, task: OpenTask, now_s: float) -> None:
        """The load is down, though nobody has said so."""
        self.close(task, "delivered")
        self._unloaded(task, now_s)

    def note_loaded(self, task: OpenTask) -> None:
        """Goods have left with their carrier."""
        if self._failover is not None:
            self._failover.note_loaded(task)

    # --- after a restart ---

    def restore(self, memory: TaskMemory, now_s: float) -> OpenTask:
        """Go on with a task of an earlier life.

        One that had a primary is followed as if nothing had been: the vehicle's own heartbeat shows soon
        enough whether it still carries it. One that had none may have been accepted while nobody listened:
        it is announced after ADOPT_S, with a higher epoch, unless a vehicle has named it by then.
        """
        epoch = memory.epoch if memory.primary else memory.epoch + 1
        deadline_s = _prolonged_s(memory.deadline_s, memory.opened_s, now_s)
        auction = self._auction(memory.task, epoch, memory.work, deadline_s)
        task = self._open[memory.task] = OpenTask(memory.task, memory.work, auction, memory.opened_s)
        task.due_s = memory.deadline_s
        if memory.primary:
            auction.cancel()
            task.loaded = memory.loaded
            self._bind(task, memory.primary, memory.source, memory.promised_s, IDLE_INTERVAL_S, now_s)
        else:
            auction.open_later(now_s + ADOPT_S)
            self._auctions.arm(PRIMARY_AUCTION, auction)
        return task

    def adopt(self, atv: str, brief: Brief, work: Work, now_s: float) -> OpenTask | None:
        """Acknowledge the contract of a vehicle that names this coordinator, after a restart.

        Returns:
            The task, when it was without a carrier or not known at all; None when it is in other hands,
            or may be: the vehicle carries it with an epoch that was over in the last life already.
        """
        task = self._open.get(brief.task)
        if task is None:
            deadline_s = brief.due_s if brief.due_s is not None else now_s
            auction = self._auction(brief.task, brief.epoch, work, deadline_s)
            task = self._open[brief.task] = OpenTask(brief.task, work, auction, now_s)
        elif task.primary or task.is_offered or brief.epoch < task.epoch - 1:
            return None  # Others were asked since then, in this life or before: its epoch must not fall.
        task.auction.cancel()
        task.epoch = brief.epoch
        self._timers.clear((PRIMARY_AUCTION, task.id))
        self._bind(task, atv, "", brief.due_s or 0.0, WORKING_INTERVAL_S, now_s)
        self._contracted(task, now_s)
        return task

    # --- what is heard ---

    def hear_bid(self, sender: str, bid: Bid, now_s: float) -> None:
        task = self._open.get(bid.task)
        if task is None or bid.epoch != task.epoch:
            self._out.append(Ignore("a bid for a task that has ended or moved on"))
        elif bid.role is Role.PRIMARY:
            task.auction.hear_bid(sender, bid, now_s)
            self._auctions.arm(PRIMARY_AUCTION, task.auction)
        elif self._secondaries is not None:
            self._secondaries.hear_bid(task, sender, bid, now_s)

    def hear_accepted(self, sender: str, answer: Accepted, now_s: float) -> None:
        task = self._open.get(answer.task)
        if task is None or answer.epoch != task.epoch:
            self._release(sender, answer.task, answer.epoch, answer.role, "the task has ended")
        elif answer.role is Role.SECONDARY:
            if self._secondaries is not None:
                self._secondaries.hear_accepted(task, sender, answer, now_s)
        else:
            task.auction.hear_accepted(sender, answer)
            if task.auction.winner == sender and not task.primary:
                self._contract(task, sender, answer, now_s)

    def hear_declined(self, sender: str, answer: Declined, now_s: float) -> None:
        task = self._open.get(answer.task)
        if task is None or answer.epoch != task.epoch:
            self._out.append(Ignore("declined a task that has ended or moved on"))
        elif answer.role is Role.PRIMARY:
            task.auction.hear_declined(sender, answer, now_s)
            self._auctions.arm(PRIMARY_AUCTION, task.auction)
        elif self._secondaries is not None:
            self._secondaries.hear_declined(task, sender, answer, now_s)

    def hear_resigned(self, sender: str, message: Resigned, now_s: float) -> None:
        """A secondary leaves, or a primary gives its task back: another one is sought at once.

        A primary may say so until it hears that its contract is over.
        """
        task = self._open.get(message.task)
        if task is None or message.epoch != task.epoch:
            self._out.append(Ignore("resigned from a contract that has ended"))
            if message.role is Role.PRIMARY:
                self._out.append(Send(sender, self.superseded(message.task, message.epoch)))
        elif message.role is Role.SECONDARY and sender == task.secondary and self._secondaries is not None:
            self._secondaries.lose(task, message.reason, now_s)
        elif message.role is Role.PRIMARY and sender == task.primary and self._failover is not None:
            self._failover.give_back(task, message.reason, now_s)
        else:
            self._out.append(Ignore("resigned from a contract that it does not have"))

    def hear_taken_over(self, sender: str, message: TakenOver, now_s: float) -> None:
        """A secondary carries a task from now on, because its primary has failed."""
        task = self._open.get(message.task)
        if task is not None and task.primary == sender and task.epoch == message.epoch:
            self._confirm(task)
        elif task is None or self._failover is None or message.epoch <= task.epoch:
            self._out.append(Send(sender, self.superseded(message.task, message.epoch)))
        elif veto := self._failover.veto(task, message, now_s):
            self._release(sender, task.id, message.epoch, Role.PRIMARY, veto)
        else:
            self._change_carrier(task, sender, message, now_s)

    def hear_heartbeat(self, heartbeat: AtvHeartbeat, now_s: float) -> None:
        """Note that a contracted vehicle lives, and whether it knows of its contract."""
        if self._failover is None or self._secondaries is None:
            return
        for task in list(self._open.values()):
            if task.primary == heartbeat.atv:
                self._failover.hear_heartbeat(task, heartbeat, now_s)
            elif task.secondary == heartbeat.atv:
                self._secondaries.hear_heartbeat(task, heartbeat, now_s)

    # --- how it is done ---

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

    def _contract(self, task: OpenTask, atv: str, answer: Accepted, now_s: float) -> None:
        bid = task.auction.winning_bid
        source = bid.source if bid is not None else ""
        self._timers.clear((PRIMARY_AUCTION, task.id))
        candidates = task.auction.left_over
        self._bind(task, atv, source, answer.finish_s, WORKING_INTERVAL_S, now_s, candidates)
        self._contracted(task, now_s)

    def _change_carrier(self, task: OpenTask, atv: str, message: TakenOver, now_s: float) -> None:
        failure = task.vigil.failure(now_s) if task.vigil is not None else ""
        if task.secondary == atv and self._secondaries is not None:
            self._secondaries.end(task)
        replaced, silent_s = self._supersede(task, message.epoch, "another one has taken over", now_s)
        self._bind(task, atv, message.source, message.finish_s, WORKING_INTERVAL_S, now_s)
        self._confirm(task)
        self._note_change(task, replaced, failure or message.reason, silent_s)
        self._contracted(task, now_s)

    def _supersede(self, task: OpenTask, epoch: int, reason: str, now_s: float) -> tuple[str, float]:
        """Fence the carrier off; who it was, and how long nothing had been heard of it (s)."""
        replaced = task.primary
        silent_s = self._failover.silent_s(task, now_s) if self._failover is not None else 0.0
        self._unbind(task, reason)
        task.epoch = epoch
        self._out.append(Send(replaced, Superseded(task=task.id, epoch=epoch)))
        return replaced, silent_s

    def _bind(
        self,
        task: OpenTask,
        atv: str,
        source: str,
        promised_s: float,
        interval_s: float,
        now_s: float,
        candidates: tuple[tuple[str, Bid], ...] = (),
    ) -> None:
        task.primary, task.source, task.promised_s = atv, source, promised_s
        if self._failover is not None and self._secondaries is not None:
            self._failover.follow(task, interval_s, now_s)
            self._secondaries.seek(task, candidates, now_s)

    def _unbind(self, task: OpenTask, reason: str) -> None:
        if self._failover is not None and self._secondaries is not None:
            self._secondaries.drop(task, reason)
            self._failover.leave(task)
        if task.primary:
            self._left(task.primary)
        task.primary, task.source, task.loaded, task.unloaded = "", "", False, False

    def _confirm(self, task: OpenTask) -> None:
        self._out.append(Send(task.primary, Confirmed(task=task.id, epoch=task.epoch)))

    def _release(self, to: str, task: str, epoch: int, role: Role, reason: str) -> None:
        self._out.append(Send(to, Release(task=task, epoch=epoch, role=role, reason=reason)))

    def _note_change(self, task: OpenTask, replaced: str, reason: str, silent_s: float) -> None:
        changed = CarrierChanged(
            task=task.id,
            epoch=task.epoch,
            replaced=replaced,
            carrier=task.primary,
            reason=reason,
            silent_s=silent_s,
        )
        self._out.append(Record(changed))


def _prolonged_s(due_s: float, opened_s: float, now_s: float) -> float:
    """A deadline for who begins now: as much time as the task was given at first, and no earlier than then."""
    return max(due_s, now_s + due_s - opened_s)
