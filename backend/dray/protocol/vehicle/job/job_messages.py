"""What a carrier says about its transport to its coordinator and at the docks. The words alone: when is for `transport_job`.

Questions (for a dock, for the acceptance of a handover, to be relieved of the task) are repeated until they are answered,
so a lost message costs seconds and no load. A takeover is told until the coordinator has confirmed it.
"""

from __future__ import annotations

import msgspec

from dray.memory import Contract
from dray.messages import Accepted, Docked, Handover, Message, Reason, Resigned, Role
from dray.protocol.runtime.events import Send
from dray.protocol.runtime.life import Life
from dray.protocol.runtime.retransmission import Retransmitter

ASK = "ask"
"""The alarm for asking again: for the dock, for the acceptance of a handover, to be relieved of the task."""

CLAIM_TASK = "claim task"
"""The alarm for saying again that a task was taken over."""

GIVE_UP_AFTER = 10
"""Questions without an answer: half a minute, longer than a machine's software needs to start again."""

HELD_ASK_AGAIN_S = 5.0
"""A dock that is held has no room yet: asking often would not make any."""


class JobMessages:
    """What the carrier of one contract says.

    Args:
        contract: what it is bound to.
        life: its agent's; its alarms are named ``(ASK, task)`` and ``(CLAIM_TASK, task)``.
    """

    def __init__(self, contract: Contract, life: Life) -> None:
        self._contract = contract
        self._task, self._epoch = contract.task, contract.epoch
        self._coordinator = contract.coordinator
        self._life = life
        self._question = Retransmitter(ASK, life, most=GIVE_UP_AFTER)
        """What the job waits for an answer to: its dock, its handover, or that it is given back."""
        self._claim = Retransmitter(CLAIM_TASK, life)
        """What is said until the coordinator has confirmed a takeover, over all lives of the vehicle."""

    # --- how the contract was made ---

    def tell_bound(self, number: int, now_s: float) -> None:
        """Say how this contract was made: by an award, or by a takeover, which is said again until it is confirmed.

        Args:
            number: of the award; 0 for a takeover.
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
        """The coordinator has not confirmed the takeover yet."""
        self._claim.wake(self._task, now_s)

    def claim_confirmed(self) -> None:
        """The coordinator knows of the takeover."""
        self._claim.settle(self._task)

    # --- questions ---

    def ask_for_dock(self, station: str, now_s: float) -> None:
        """Ask to load or unload at a place, where the vehicle stands."""
        asked, work = Docked(task=self._task, epoch=self._epoch, station=station), self._contract.work
        if work.handed_at == station:
            # Nobody is there but people: its coordinator knows whether they hand it over to this vehicle.
            self._ask(self._coordinator, asked, now_s)
            return
        if station != self._coordinator:
            # A storage may have lost its notes, and has no other word of the task.
            asked = msgspec.structs.replace(asked, item=work.item, quantity=work.quantity)
        # A machine and the station of a storage have the name of the place.
        self._ask(station, asked, now_s)

    def ask_to_put_back(self, station: str, now_s: float) -> None:
        """Ask to put down a load that nobody waits for any more, where the vehicle stands."""
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
        """The load is down: ask the coordinator to take it over."""
        handover = Handover(task=self._task, epoch=self._epoch, quantity=self._contract.work.quantity)
        self._ask(self._coordinator, handover, now_s)

    def ask_for_relief(self, reason: Reason, detail: str, short: str, now_s: float) -> None:
        """Ask the coordinator to let another one carry it.

        Args:
            reason: why.
            detail: the same in the words of whoever has held it up.
            short: the storage that had none of the load; empty when that is not why.
            now_s: the present time.
        """
        resigned = msgspec.structs.replace(self._resigned(reason, detail), short=short)
        self._ask(self._coordinator, resigned, now_s)

    @property
    def is_asking(self) -> bool:
        """Whether an answer is waited for."""
        return self._task in self._question

    @property
    def is_unanswered(self) -> bool:
        """Whether the present question was asked `GIVE_UP_AFTER` times, in vain."""
        return self._question.is_exhausted(self._task)

    def heard(self) -> None:
        """The other side lives: whatever it has not answered yet is asked as often as at first."""
        self._question.count_anew(self._task)

    def ask_later(self, now_s: float) -> None:
        """The dock is held."""
        self._question.defer(self._task, now_s + HELD_ASK_AGAIN_S)

    def answered(self) -> None:
        """Nothing waits for an answer any more."""
        self._question.settle(self._task)

    # --- its end ---

    def resign(self, reason: Reason, detail: str = "") -> None:
        """Give the contract back, once: whoever does not hear it hears no heartbeat about the task either."""
        self._life.send(self._coordinator, self._resigned(reason, detail))

    def stop(self) -> None:
        """Say nothing more."""
        self._question.settle(self._task)
        self._claim.settle(self._task)

    def _resigned(self, reason: Reason, detail: str) -> Resigned:
        return Resigned(task=self._task, epoch=self._epoch, role=Role.PRIMARY, reason=reason, detail=detail)

    def _ask(self, whom: str, question: Message, now_s: float) -> None:
        self._question.say(self._task, Send(whom, question), now_s)
