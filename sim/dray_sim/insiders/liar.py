"""A vehicle that never moves and sends any message it likes: bids, acceptances, heartbeats, handovers, claims."""

from __future__ import annotations

from dataclasses import dataclass
from itertools import cycle
from math import hypot

from dray.body import VehicleState
from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    Award,
    Bid,
    Brief,
    Declined,
    Docked,
    DwellPointClaimed,
    Handover,
    HandoverAccepted,
    MachineHeartbeat,
    Message,
    Phase,
    Pose,
    Reason,
    Refusal,
    Release,
    Resigned,
    Role,
    Superseded,
    TaskAnnounced,
    TaskBrief,
    Transport,
    TransportCost,
    Withdrawn,
)
from dray.messages.floor.traffic import FIRST_S, HOLDS_MAX, HoldsAsked, PlaceGranted, PlaceRequested
from dray.messages.keys import Keys
from dray.plant import Plant
from dray.protocol.contract_net.dock import dock_of
from dray.protocol.liveness.suspicion import WORKING_INTERVAL_S
from dray.protocol.runtime.events import (
    Effect,
    Event,
    Leave,
    Leaving,
    Publish,
    Received,
    Send,
    Started,
    Subscribe,
    Woke,
)
from dray.protocol.traffic.places import Places
from dray_sim.insiders.behaviour import Answer, Behaviour, Price

SPEAKS_S = 1.0
"""Time for which it goes on after an award, so that its messages about it are heard."""

HELD_MAX = 64
"""Tasks that it holds at once; the oldest is forgotten."""

HANDLING_S = 15.0
"""Duration of its pretended loading and unloading: that of the quicker vehicles of the default plant."""

ABSURD_S = -1e11


@dataclass(slots=True)
class Held:
    """A task that it was awarded, and will not do."""

    task: str
    epoch: int
    role: Role
    coordinator: str
    work: Transport
    source: str
    since_s: float


class Liar:
    """An insider without a body (see `dray.protocol.runtime.events.Agent`).

    Args:
        atv: its name on the bus.
        plant: its knowledge of the plant.
        behaviour: how it lies.
        incarnation: of this life.
    """

    def __init__(self, atv: str, plant: Plant, behaviour: Behaviour, incarnation: int = 1) -> None:
        self.id, self.incarnation = atv, incarnation
        self.wake_at_s = float("inf")
        self._plant = plant
        self._behaviour = behaviour
        self._keys = Keys(plant.id)
        self._fastest_mps = max(kind.max_speed_mps for kind in plant.vehicle_types.values())
        first = next(iter(plant.nodes.values()))
        self._node, self._pose = first.id, Pose(first.x_m, first.y_m, 0.0)
        self._held: dict[str, Held] = {}
        self._seq = 0
        self._silent_until_s = 0.0
        self._others: dict[str, tuple[str, TaskBrief]] = {}
        """Overheard tasks of others, with their owners."""
        self._turns = cycle(plant.machines)
        self._places = Places(plant)
        self._requests = 0
        self._epochs: dict[str, int] = {}
        """District -> of its table, as it was told."""
        self._removal = 0
        self._out: list[Effect] = []

    def handle(self, event: Event, now_s: float) -> list[Effect]:
        """Take one step."""
        if isinstance(event, Started):
            self._start(event, now_s)
        elif isinstance(event, Leaving):
            self._out.append(Leave())
        elif isinstance(event, Woke):
            self._beat(now_s)
        elif isinstance(event, Received) and now_s >= self._silent_until_s:
            self._on_message(event.sender, event.message, now_s)
        effects, self._out = self._out, []
        return effects

    # --- what it hears ---------------------------------------------------------------------------

    def _start(self, started: Started, now_s: float) -> None:
        if isinstance(started.body, VehicleState):
            self._node, self._pose = started.body.node, started.body.pose
        cells = self._plant.cells_within(0.0, 0.0, 2.0 * self._plant.diameter_m)
        self._out += [Subscribe(self._keys.transports(cell)) for cell in cells]
        if self._behaviour.names_others:
            self._out.append(Subscribe(self._keys.all_machine_heartbeats))
        self.wake_at_s = now_s

    def _on_message(self, sender: str, message: Message, now_s: float) -> None:
        if isinstance(message, TaskAnnounced):
            self._bid(message, now_s)
        elif isinstance(message, Award):
            self._answer(sender, message, now_s)
        elif isinstance(message, Release | Superseded | Withdrawn | HandoverAccepted):
            held = self._held.get(message.task)
            # Let go by one epoch it may have been awarded the next one already.
            if held is not None and held.epoch <= message.epoch:
                del self._held[message.task]
        elif isinstance(message, PlaceGranted | HoldsAsked):
            self._epochs[message.district] = message.epoch
            if isinstance(message, PlaceGranted):
                self._removal = max(self._removal, message.removal)
        elif isinstance(message, MachineHeartbeat):
            self._others = {task: each for task, each in self._others.items() if each[0] != sender}
            self._others |= {brief.task: (sender, brief) for brief in message.tasks if brief.primary}

    def _bid(self, announced: TaskAnnounced, now_s: float) -> None:
        work, price = announced.work, self._behaviour.price
        if price is None or not isinstance(work, Transport):
            return
        source = min(work.sources, key=lambda each: self._way_s(work, each))
        way_s = self._way_s(work, source)
        cost = {
            Price.NOTHING: TransportCost(0.0, 0.0, 0.0, 0.0),
            Price.ABSURD: TransportCost(ABSURD_S, ABSURD_S, ABSURD_S, ABSURD_S),
            Price.LEAST: TransportCost(0.0, way_s, 0.0, 0.0),
        }[price]
        takes_s = way_s + 2.0 * HANDLING_S if price is Price.LEAST else 0.0
        bid = Bid(
            task=announced.task,
            epoch=announced.epoch,
            role=announced.role,
            round=announced.round,
            cost=cost,
            finish_s=now_s + takes_s,
            source=source,
        )
        self._out.append(Send(announced.coordinator, bid))

    def _answer(self, sender: str, award: Award, now_s: float) -> None:
        work, answers = award.work, self._behaviour.answers
        if not isinstance(work, Transport) or answers is Answer.NONE:
            return
        if answers is Answer.DECLINE:
            declined = Declined(
                task=award.task,
                epoch=award.epoch,
                role=award.role,
                reason=Refusal.BUSY,
                number=award.number,
            )
            self._out.append(Send(sender, declined))
            return
        source = award.source or work.sources[0]
        finish_s = now_s + self._way_s(work, source) + 2.0 * HANDLING_S
        accepted = Accepted(
            task=award.task, epoch=award.epoch, role=award.role, finish_s=finish_s, number=award.number
        )
        self._out.append(Send(sender, accepted))
        if answers is Answer.RESIGN:
            resigned = Resigned(task=award.task, epoch=award.epoch, role=award.role, reason=Reason.HAS_WORK)
            self._out.append(Send(sender, resigned))
            return
        self._held[award.task] = Held(award.task, award.epoch, award.role, sender, work, source, now_s)
        if len(self._held) > HELD_MAX:
            del self._held[next(iter(self._held))]

    # --- what it says ----------------------------------------------------------------------------

    def _beat(self, now_s: float) -> None:
        flood_hz = self._behaviour.flood_hz
        self.wake_at_s = now_s + (min(WORKING_INTERVAL_S, 1.0 / flood_hz) if flood_hz else WORKING_INTERVAL_S)
        if self._behaviour.names_others:
            for coordinator, brief in self._others.values():
                self._say_heartbeat(
                    Brief(brief.task, brief.epoch, Role.PRIMARY, coordinator, Phase.CARRYING), now_s
                )
            if self._others:
                return
        watches = tuple(
            Brief(held.task, held.epoch, held.role, held.coordinator)
            for held in self._held.values()
            if held.role is Role.SECONDARY
        )
        carried = [held for held in self._held.values() if held.role is Role.PRIMARY]
        for held in carried or (None,):
            self._say_heartbeat(None if held is None else self._brief(held, now_s), now_s, watches)
        if self._behaviour.silent_s and any(now_s - held.since_s >= SPEAKS_S for held in carried):
            self._fall_silent(now_s)
        if self._behaviour.claims_all:
            self._claim_all()
        if self._behaviour.claims_floor:
            self._claim_floor()
        if flood_hz:
            self._flood(now_s)

    def _fall_silent(self, now_s: float) -> None:
        """Forget everything, and be back as if nothing had been."""
        self.wake_at_s = self._silent_until_s = now_s + self._behaviour.silent_s
        self._held.clear()

    def _say_heartbeat(self, brief: Brief | None, now_s: float, watches: tuple[Brief, ...] = ()) -> None:
        self._seq += 1
        heartbeat = AtvHeartbeat(
            atv=self.id,
            incarnation=self.incarnation,
            seq=self._seq,
            at_s=now_s,
            status=AtvStatus.IDLE if brief is None else AtvStatus.WORKING,
            pose=self._pose,
            node=self._node,
            speed_mps=0.0,
            battery_frac=1.0,
            task=brief,
            watches=watches,
        )
        self._out.append(Publish(self._keys.atv_heartbeat(self.id), heartbeat))

    def _brief(self, held: Held, now_s: float) -> Brief:
        phase = Phase.CARRYING if self._behaviour.boasts else Phase.APPROACHING
        if self._behaviour.pretends:
            phase = self._pretend(held, now_s)
        return Brief(
            task=held.task,
            epoch=held.epoch,
            role=Role.PRIMARY,
            coordinator=held.coordinator,
            phase=phase,
            item=held.work.item,
            quantity=held.work.quantity,
            due_s=now_s + 10.0,
        )

    def _pretend(self, held: Held, now_s: float) -> Phase:
        """Be where an honest vehicle would be by now."""
        took_s, way_s = now_s - held.since_s, self._way_s(held.work, held.source)
        done_frac = min(max((took_s - HANDLING_S) / max(way_s, 1.0), 0.0), 1.0)
        here, there = self._spot(held.work, held.source), self._spot(held.work, held.work.destination)
        x_m, y_m = (a + done_frac * (b - a) for a, b in zip(here, there, strict=True))
        self._pose = Pose(x_m, y_m, 0.0)
        if took_s < HANDLING_S:
            if held.source == held.coordinator:
                docked = Docked(task=held.task, epoch=held.epoch, station=held.source)
                self._out.append(Send(held.coordinator, docked))
            return Phase.LOADING
        if done_frac < 1.0:
            return Phase.CARRYING
        if self._behaviour.hands_over:
            handover = Handover(task=held.task, epoch=held.epoch, quantity=held.work.quantity)
            self._out.append(Send(held.coordinator, handover))
        return Phase.UNLOADING

    def _claim_all(self) -> None:
        for dwell_point in self._plant.dwell_points:
            claim = DwellPointClaimed(dwell_point=dwell_point, atv=self.id, battery_frac=0.0, standing=True)
            self._out.append(Publish(self._keys.dwell_point(dwell_point), claim))

    def _claim_floor(self) -> None:
        self._requests += 1
        for district, replicas in self._places.replicas_of.items():
            inside = sorted(self._places.places_in(district))
            request = PlaceRequested(
                district=district,
                life=self.incarnation,
                seq=self._requests,
                epoch=self._epochs.get(district, 0),
                rank=(0, FIRST_S, self.id),
                holds=tuple(inside[:HOLDS_MAX]),
                groups=tuple((place,) for place in inside[:HOLDS_MAX]),
                seen=0,
                stands=True,
                docked=True,
                removal=self._removal,
            )
            self._out += [Send(replica, request) for replica in replicas]

    def _flood(self, now_s: float) -> None:
        machine = next(self._turns)
        cost = TransportCost(0.0, 0.0, 0.0, 0.0)
        for task in (*self._held, f"{machine}-1"):
            bid = Bid(
                task=task, epoch=1, role=Role.PRIMARY, round=1, cost=cost, finish_s=now_s, source="nowhere"
            )
            self._out.append(Send(machine, bid))

    # --- what it knows ---------------------------------------------------------------------------

    def _way_s(self, work: Transport, source: str) -> float:
        """The loaded way as the crow flies, at the speed of the fastest."""
        (x_m, y_m), (to_x_m, to_y_m) = self._spot(work, source), self._spot(work, work.destination)
        return hypot(to_x_m - x_m, to_y_m - y_m) / self._fastest_mps

    def _spot(self, work: Transport, place: str) -> tuple[float, float]:
        node = self._plant.nodes[dock_of(self._plant, work, place)]
        return node.x_m, node.y_m
