"""A machine's transports without the machine, for tests: one task, the time, and vehicles that beat."""

from __future__ import annotations

from typing import cast

import msgspec
from credulous import Credulous
from defaults import KEYS, PLANT
from dock_parts import dock_parts
from effects import award_number, sent
from spoken import accepted, bid, declined, rhb, transport

from dray.messages import (
    AtvHeartbeat,
    Award,
    Brief,
    Reason,
    Refusal,
    Release,
    Resigned,
    Role,
    Work,
)
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.contract_net.changes import ContractChanged
from dray.protocol.contract_net.task import OpenTask
from dray.protocol.liveness.failure_detector import HeartbeatSubscriptions
from dray.protocol.runtime.life import BEAT, Life
from dray.protocol.transports.reservations import Reservations
from dray.protocol.transports.transports import Transports


class OneCell(Transports):
    """Its vehicles are all in one cell."""

    def _audience(self, _work: Work, _radius_m: float) -> tuple[str, ...]:
        return ("plant/task/0_0",)


class TransportsRig:
    """A machine's transports, the time, and the one task T1 unless more are opened."""

    def __init__(self) -> None:
        self.life = Life()
        self.out = self.life.effects
        self.now_s = 0.0
        self.subscriptions = HeartbeatSubscriptions(KEYS.atv_heartbeat, self.life)
        self.transports = OneCell(
            "M8",
            PLANT,
            KEYS,
            Reservations({}),
            AuctionRules(),
            self.life,
            self.subscriptions,
            dock_parts("m8", self.subscriptions, self.life)[0],
            Credulous(),
        )
        self.seq = 0

    def open(self, task: str = "T1") -> OpenTask:
        return self.transports.open(task, transport(), self.now_s + 300.0, self.now_s)

    @property
    def contracted(self) -> list[str]:
        """The tasks whose contracts have changed, in order."""
        return [change.task.id for change in self.life.changes if isinstance(change, ContractChanged)]

    @property
    def task(self) -> OpenTask:
        found = self.transports.get("T1")
        assert found is not None
        return found

    def heartbeat(self, atv: str) -> AtvHeartbeat:
        """What a vehicle that keeps its contract says: it carries the task, or watches it."""
        carried = rhb(atv, self.seq, self.now_s, task="T1")
        if atv != self.task.secondary:
            return carried
        brief = cast(Brief, carried.task)
        watch = msgspec.structs.replace(brief, role=Role.SECONDARY, phase=None)
        return msgspec.structs.replace(carried, task=None, watches=(watch,))

    def run(self, until_s: float, *alive: str) -> None:
        """Let time pass; the vehicles that are alive beat every second."""
        while self.life.timers.next_s <= until_s or self.now_s + 1.0 <= until_s:
            if self.life.timers.next_s <= self.now_s + 1.0:
                self.now_s = max(self.now_s, self.life.timers.next_s)
                for name in self.life.timers.due(self.now_s):
                    if isinstance(name, tuple):  # The heartbeat is the agent's.
                        self.transports.alarms[name[0]](name[1], self.now_s)
            else:
                self.now_s += 1.0
            self.seq += 1
            for atv in alive:
                self.transports.on_heartbeat(self.heartbeat(atv), self.now_s)
        self.now_s = until_s

    def bids(self, task: str = "T1", role: Role = Role.PRIMARY, epoch: int = 1, **costs_s: float) -> None:
        for bidder, cost_s in costs_s.items():
            message = bid(cost_s, task=task, role=role, epoch=epoch)
            self.transports.on_bid(bidder, message, self.now_s)

    def accepts(self, atv: str, role: Role = Role.PRIMARY, task: str = "T1", epoch: int = 1) -> None:
        """It answers the newest award of that role that it was sent."""
        answer = accepted(
            task, role=role, epoch=epoch, number=award_number(self.life.effects, atv, task, role)
        )
        self.transports.on_accepted(atv, answer, self.now_s)
        self.life.cancel(BEAT)  # The agent sends it at once.

    def declines(self, atv: str, role: Role = Role.PRIMARY) -> None:
        answer = declined(
            role=role, reason=Refusal.BUSY, number=award_number(self.life.effects, atv, role=role)
        )
        self.transports.on_declined(atv, answer, self.now_s)

    def resigns(self, atv: str, task: str = "T1") -> None:
        message = Resigned(task=task, epoch=1, role=Role.SECONDARY, reason=Reason.HAS_WORK)
        self.transports.on_resigned(atv, message, self.now_s)

    def asked(self, role: Role = Role.SECONDARY) -> list[str]:
        """Everybody who was asked for a role, in order."""
        return [
            effect.to for effect in self.life.effects for award in sent([effect], Award) if award.role is role
        ]

    def released(self) -> list[tuple[str, Role]]:
        return [(effect.to, said.role) for effect in self.life.effects for said in sent([effect], Release)]


def contracted() -> TransportsRig:
    """An rig whose T1 is carried by ATV2, with ATV1 and ATV4 left over."""
    rig = TransportsRig()
    rig.open()
    rig.bids(ATV1=55.9, ATV2=54.8, ATV4=60.0)
    rig.run(1.0)
    rig.accepts("ATV2")
    return rig


def watched() -> TransportsRig:
    """An rig whose T1 is carried by ATV2 and watched by ATV1."""
    rig = contracted()
    rig.accepts("ATV1", Role.SECONDARY)
    return rig
