"""How a transport job stands: what it is bound to, how far it has come, and what the vehicle tells of it."""

from __future__ import annotations

from typing import Any

from dray.memory import Contract
from dray.messages import Brief, Phase, Reason, Role, Superseded
from dray.protocol.vehicle.job.job_state import VOID, JobState, JobStates


class JobStatus:
    """How one transport of one vehicle stands.

    Args:
        contract: what the vehicle is bound to.

    Attributes:
        due_s: when it now expects to hand over (plant clock).
        ended: why it is over; None while it lasts.
        detail: the same in the words of whoever has held it up; empty where nobody has.
        number: of the award that binds it; 0 for a takeover.
    """

    def __init__(self, contract: Contract) -> None:
        self._contract = contract
        self.task = contract.task
        self.epoch = contract.epoch
        self.work = contract.work
        self.coordinator = contract.coordinator
        self.source = contract.source
        self.promised_s = contract.promised_s
        self.due_s = contract.promised_s
        self.ended: Reason | None = None
        self.detail = ""
        self.number = contract.number
        self._states = JobStates(contract.phase)

    @property
    def state(self) -> JobState:
        """How far it has come."""
        return self._states.now

    @property
    def phase(self) -> Phase:
        """The same, as others hear it."""
        return self._states.phase

    @property
    def is_void(self) -> bool:
        """Whether it is over but for the load, which is on its way back."""
        return self.state in VOID

    @property
    def is_given_back(self) -> bool:
        """Whether it ends as soon as the coordinator has answered."""
        return self.state is JobState.GIVING_BACK

    @property
    def slack_s(self) -> float:
        """How much later than now expected it may be done."""
        return self._contract.deadline_s - self.due_s

    def answers_at(self, station: str) -> str:
        """Who says whether it may load or unload at a place where it stands: where people hand the load over, its coordinator."""
        return self.coordinator if station == self.work.handed_at else station

    def is_meant_by(self, message: Any) -> bool:
        """Whether a coordinator speaks of this contract; a Superseded speaks of another epoch."""
        return self.task == message.task and (type(message) is Superseded or message.epoch == self.epoch)

    def brief(self) -> Brief:
        """What the vehicle tells about it in its heartbeat."""
        return Brief(
            task=self.task,
            epoch=self.epoch,
            role=Role.PRIMARY,
            coordinator=self.coordinator,
            phase=self.phase,
            item=self.work.item,
            quantity=self.work.quantity,
            due_s=self.due_s,
        )
