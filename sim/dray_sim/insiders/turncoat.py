"""A vehicle that works well, until it does not: a vehicle's software, with an insider between it and its body."""

from __future__ import annotations

from msgspec.structs import replace

from dray.body import ActionDone, Drive, Drop, Instruction, LimitSpeed, VehicleState
from dray.messages import AtvHeartbeat, Bid, Phase, Role, TransportCost
from dray.messages.fact import ContractEnded, ContractTaken
from dray.protocol.runtime.events import (
    Effect,
    Event,
    Instruct,
    Publish,
    Record,
    Reported,
    Send,
    Started,
    Woke,
)
from dray.protocol.vehicle.atv import Atv
from dray_sim.insiders.behaviour import Behaviour


class Turncoat:
    """An insider that drives (see `dray.protocol.runtime.events.Agent`).

    Args:
        atv: the honest vehicle.
        behaviour: its deviations.
    """

    def __init__(self, atv: Atv, behaviour: Behaviour) -> None:
        self._atv = atv
        self._behaviour = behaviour
        self._taken = 0
        """Transports so far."""
        self._betrays = False
        """Whether it will not finish its present task."""
        self._down: Drop | None = None
        """A drop that its software will believe to have done, with the next step."""
        self._hoards = False
        """A load is on board of which its software knows nothing."""
        self.id, self.incarnation = atv.id, atv.incarnation

    @property
    def wake_at_s(self) -> float:
        return self._atv.wake_at_s

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step, as the honest one would, and do another thing."""
        effects = self._atv.handle(self._hide(event), now_s)
        if isinstance(event, Started) and self._behaviour.speed_frac < 1.0:
            effects.append(Instruct(LimitSpeed(self._behaviour.speed_frac)))
        twisted = [each for effect in effects for each in self._twist(effect)]
        if self._down is not None:
            done, self._down = Reported(ActionDone(self._down.order)), None
            twisted += self.handle(done, now_s)
        return twisted

    def _twist(self, effect: Effect) -> list[Effect]:
        if isinstance(effect, Record):
            self._note(effect)
        elif isinstance(effect, Send) and isinstance(effect.message, Bid):
            return [replace(effect, message=self._bid_low(effect.message))]
        elif self._betrays and self._behaviour.says_down and isinstance(effect, Instruct):
            return self._keep(effect)
        elif self._betrays and isinstance(effect, Instruct):
            return [] if isinstance(effect.instruction, self._withheld) else [effect]
        elif self._betrays and isinstance(effect, Publish) and isinstance(effect.message, AtvHeartbeat):
            return [replace(effect, message=self._look_well(effect.message))]
        return [effect]

    def _keep(self, effect: Instruct) -> list[Effect]:
        """Let its software believe that the load is down."""
        if not isinstance(effect.instruction, Drop):
            return [effect]
        self._down, self._hoards = effect.instruction, True
        return []

    def _hide(self, event: Event) -> Event:
        """Hide the kept load from its software."""
        body = event.body if isinstance(event, Woke) else None
        if not self._hoards or not isinstance(body, VehicleState):
            return event
        return Woke(replace(body, load="", load_quantity=0))

    def _note(self, record: Record) -> None:
        fact = record.fact
        if isinstance(fact, ContractTaken) and fact.role is Role.PRIMARY:
            self._taken += 1
            every = self._behaviour.betrays_every
            self._betrays = bool(every) and self._taken % every == 0
        elif isinstance(fact, ContractEnded) and fact.role is Role.PRIMARY:
            self._betrays = False

    @property
    def _withheld(self) -> type[Instruction]:
        """The instruction that its body does not get while it betrays a task."""
        return Drop if self._behaviour.keeps_loads else Drive

    def _bid_low(self, bid: Bid) -> Bid:
        """Bid as if it stood at the source already, with a full battery, and were good for nothing else."""
        cost = bid.cost
        if self._behaviour.price is None or not isinstance(cost, TransportCost):
            return bid
        return replace(bid, cost=replace(cost, empty_way_s=0.0, energy_s=0.0, suitability_s=0.0))

    def _look_well(self, heartbeat: AtvHeartbeat) -> AtvHeartbeat:
        """Never say more of the phase than that it comes."""
        brief = heartbeat.task
        if self._behaviour.says_down or brief is None or brief.phase is not Phase.UNLOADING:
            return heartbeat
        return replace(heartbeat, task=replace(brief, phase=Phase.CARRYING))
