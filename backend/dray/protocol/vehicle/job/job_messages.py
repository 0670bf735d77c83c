"""A carrier's messages about its transport to its coordinator and to docks; `transport_job` decides when.

Questions for a dock, a handover's acceptance, or relief from the task are repeated until they are answered. A lost
message costs seconds and no load. A takeover is repeated until the coordinator has confirmed it.
"""

from __future__ import annotations

import msgspec

from dray.memory import Contract
from dray.messages import Accepted, Docked, Handover, Message, Reason, Resigned, Role
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.retransmission import Retransmitter

ASK = "ask"
"""Alarm of a repeated question: for the dock, the handover's acceptance, or relief from the task."""

CLAIM_TASK = "claim task"
"""Alarm of a repeated takeover."""

GIVE_UP_AFTER = 10
"""Maximum unanswered questions: half a minute, longer than a machine's restart."""

HELD_ASK_AGAIN_S = 5.0
"""Interval of questions at a held dock (s): frequent questions make no room."""


class JobMessages:
    """The messages of one contract's carrier.

    Args:
        contract: its contract.
        life: the agent's life; alarms are named ``(ASK, task)`` and ``(CLAIM_TASK, task)``.
    """

    def __init__(self, contract: Contract, life: Life) -> None:
        self._contract = contract
        self._task, self._epoch = contract.task, contract.epoch
        self._coordinator = contract.coordinator
        self._life = life
        self._question = Retransmitter(ASK, life, most=GIVE_UP_AFTER)
        """The present question: for a dock, a handover, or relief."""
        self._claim = Retransmitter(CLAIM_TASK, life)
        """The takeover until its confirmation, over all lives of the vehicle."""

    # --- how the contract was made ---

    def tell_bound(self, number: int, now_s: float) -> None:
        """Tell how this contract was made: by an award, or by a takeover, which is repeated until it is confirmed.

        Args:
            number: the award's number; 0 for a takeover.
            now_s: the present time.
        """
        if self._contract.claim is not None:
            self._claim.say(self._task, Send(self._coordinator, self._contract.claim), now_s)
            return
        accepted = Accepted(
            task=self._task,
            epoch=self._epoch,
            role=Role.PRIMARY,
            finish_s=self._contract.promised_s,
            number=number,
            at_s=now_s,
        )
        self._life.send(self._coordinator, accepted)

    @property
    def is_claiming(self) -> bool:
        """Whether a takeover is not confirmed yet."""
        return self._task in self._claim

    def claim_again(self, now_s: float) -> None:
        """Repeat the unconfirmed takeover."""
        self._claim.wake(self._task, now_s)

    def claim_confirmed(self) -> None:
        """The coordinator has confirmed the takeover."""
        self._claim.settle(self._task)

    # --- questions ---

    def ask_for_dock(self, station: str, now_s: float) -> None:
        """Ask to load or unload at the place where the vehicle stands."""
        asked, work = Docked(task=self._task, epoch=self._epoch, station=station), self._contract.work
        if work.handed_at == station:
            # Only people are there: the coordinator knows whether they give the load to this vehicle.
            self._ask(self._coordinator, asked, now_s)
            return
        if station != self._coordinator:
            # A storage may have lost its notes, and then knows the task only from this message.
            asked = msgspec.structs.replace(asked, item=work.item, quantity=work.quantity)
        # The agent of a machine or a storage has the place's name.
        self._ask(station, asked, now_s)

    def ask_to_put_back(self, station: str, now_s: float) -> None:
        """Ask to put a returned load down where the vehicle stands."""
        work = self._contract.work
        asked = Docked(
            task=self._task,
            epoch=self._epoch,
            station=station,
            item=work.item,
            quantity=work.quantity,
            returns=True,
        )
        self._ask(station, asked, now_s)

    def ask_for_handover(self, now_s: float) -> None:
        """The load is down: ask the coordinator to accept it."""
        handover = Handover(task=self._task, epoch=self._epoch, quantity=self._contract.work.quantity)
        self._ask(self._coordinator, handover, now_s)

    def ask_for_relief(self, reason: Reason, detail: str, short: str, now_s: float) -> None:
        """Ask the coordinator for another carrier.

        Args:
            reason: the reason.
            detail: the reason in the words of the agent or device that held it up.
            short: the storage that lacked the load; empty if that is not the reason.
            now_s: the present time.
        """
        resigned = msgspec.structs.replace(self._resigned(reason, detail), short=short)
        self._ask(self._coordinator, resigned, now_s)

    @property
    def is_asking(self) -> bool:
        """Whether an answer is awaited."""
        return self._task in self._question

    @property
    def is_unanswered(self) -> bool:
        """Whether the present question was sent `GIVE_UP_AFTER` times without an answer."""
        return self._question.is_exhausted(self._task)

    def heard(self) -> None:
        """The other side lives: reset the count of the present question."""
        self._question.count_anew(self._task)

    def ask_later(self, now_s: float) -> None:
        """The dock is held: repeat the question later."""
        self._question.defer(self._task, now_s + HELD_ASK_AGAIN_S)

    def answered(self) -> None:
        """Stop the question."""
        self._question.settle(self._task)

    # --- its end ---

    def resign(self, reason: Reason, detail: str = "") -> None:
        """Give the contract back, once: if that is lost, the missing task in the heartbeat tells the same."""
        self._life.send(self._coordinator, self._resigned(reason, detail))

    def stop(self) -> None:
        """Stop all repetitions."""
        self._question.settle(self._task)
        self._claim.settle(self._task)

    def _resigned(self, reason: Reason, detail: str) -> Resigned:
        return Resigned(task=self._task, epoch=self._epoch, role=Role.PRIMARY, reason=reason, detail=detail)

    def _ask(self, whom: str, question: Message, now_s: float) -> None:
        self._question.say(self._task, Send(whom, question), now_s)
