"""Agents in the middle of something: each situation is played from the agent's first moment.

One vehicle (ATV1), one machine (M7) and the strategist; everybody else is a voice of the script. The ids
that mean something to them are `NAMES`.
"""

from __future__ import annotations

from collections.abc import Callable

from bodies import PlainGate, PlainVehicle, PlainWorkcell
from defaults import PLANT
from played import Played
from seals import granted, trusts_seals
from spoken import accepted, announcement, award, bid, goal_bid, mhb, production, rhb, transport

from dray.body import Pick
from dray.messages import (
    Accepted,
    AdmissionAsked,
    AtvHeartbeat,
    Award,
    CommandKind,
    Confirmed,
    Docked,
    DockOpened,
    GateReported,
    GoalBrief,
    Handover,
    MachineHeartbeat,
    OrderItem,
    OrderReleased,
    Phase,
    Role,
    Superseded,
    TaskAnnounced,
    Transport,
    VehicleCommand,
)
from dray.messages.keys import GATE, STRATEGIST
from dray.protocol.gate.gate import DeliveryGate
from dray.protocol.machine.machine import Machine
from dray.protocol.strategist.gated import GatedStrategist
from dray.protocol.strategist.strategist import Strategist
from dray.protocol.vehicle.atv import Atv

PRODUCT = "pump-p3"
MATERIALS = tuple(line.material for line in PLANT.products[PRODUCT].bill)
WAREHOUSE = PLANT.delivery_warehouses[0]

TASKS = ("M8-1", "M7-1", "M7-2", "M7-3", "G1", "O1-1.1", "O1-1.2")
AGENTS = ("ATV1", "ATV2", "ATV3", "M7", "M8", STRATEGIST, GATE, "gateway")
STATIONS = ("S3", "M7", "M8", WAREHOUSE)

NAMES = {
    "": (*AGENTS, *TASKS, *STATIONS, PRODUCT, *MATERIALS, "O1"),
    "task": TASKS,
    "goal": TASKS,
    "order": ("O1", "O2"),
    "coordinator": ("M7", "M8", STRATEGIST),
    "machine": ("M7", "M8"),
    "atv": ("ATV1", "ATV2", "ATV3"),
    "primary": ("ATV1", "ATV2", "ATV3", ""),
    "item": (*MATERIALS, "shaft", PRODUCT),
    "product": tuple(PLANT.products),
    "station": STATIONS,
    "destination": STATIONS,
    "source": STATIONS,
    "sources": STATIONS,
    "ability": ("tote", "heavy", ""),
    "dwell_point": tuple(PLANT.dwell_points[:3]),
    "node": tuple(PLANT.nodes)[:3],
}
"""By the name of the field that they fit into."""

# --- a vehicle -----------------------------------------------------------------------------------


def idle_vehicle(battery_frac: float = 0.9) -> Played:
    body = PlainVehicle("ATV1", PLANT, "p3", lambda *_: "")
    body.battery_frac = battery_frac
    return Played(
        lambda life: Atv("ATV1", PLANT, vehicle_type="light", incarnation=life, trusts=trusts_seals), body
    )


def _vehicle(actor: Played) -> PlainVehicle:
    assert isinstance(actor.body, PlainVehicle)
    return actor.body


def _in_phase(phase: Phase) -> Callable[[Played], bool]:
    def is_there(actor: Played) -> bool:
        beat = actor.newest(AtvHeartbeat)
        return beat is not None and beat.task is not None and beat.task.phase is phase

    return is_there


def vehicle_on_its_way_to_a_charger() -> Played:
    return idle_vehicle(battery_frac=0.4).until(lambda actor: _vehicle(actor).moved)


def charging_vehicle() -> Played:
    return idle_vehicle(battery_frac=0.4).until(lambda actor: _vehicle(actor).sense().charging)


def vehicle_that_has_bid() -> Played:
    return idle_vehicle().told("M8", announcement())


def approaching_vehicle() -> Played:
    return idle_vehicle().told("M8", award(source="S3"))


def loading_vehicle() -> Played:
    return approaching_vehicle().until(lambda actor: isinstance(_vehicle(actor).action, Pick))


def carrying_vehicle() -> Played:
    return approaching_vehicle().until(_in_phase(Phase.CARRYING))


def docked_vehicle() -> Played:
    asked = Docked(task="M8-1", epoch=1, station="M8")
    return carrying_vehicle().until(lambda actor: actor.newest(Docked) == asked)


def unloading_vehicle() -> Played:
    return docked_vehicle().told("M8", DockOpened(task="M8-1", epoch=1, station="M8"))


def vehicle_that_hands_over() -> Played:
    return unloading_vehicle().until(lambda actor: actor.newest(Handover))


def returning_vehicle() -> Played:
    return carrying_vehicle().told("M8", Superseded(task="M8-1", epoch=2))


def vehicle_at_the_goods() -> Played:
    work = transport(item=PRODUCT, quantity=12, sources=("M7",), destination=WAREHOUSE, goal="G1")
    actor = idle_vehicle().told("M7", award(task="M7-1", work=work, source="M7"))
    return actor.until(lambda actor: actor.newest(Docked))


def vehicle_with_goods() -> Played:
    actor = vehicle_at_the_goods().told("M7", DockOpened(task="M7-1", epoch=1, station="M7"))
    return actor.until(_in_phase(Phase.CARRYING))


def watching_vehicle() -> Played:
    watch = award(role=Role.SECONDARY, primary="ATV2")
    return idle_vehicle().told("M8", watch).told("ATV2", rhb("ATV2", 1, 0.0, task="M8-1"))


def _stop(actor: Played) -> Played:
    return actor.told("operator", granted("ATV1", VehicleCommand(command="c1", kind=CommandKind.STOP)))


def stopped_vehicle() -> Played:
    return _stop(idle_vehicle())


def stopped_vehicle_with_a_load() -> Played:
    return _stop(carrying_vehicle())


def acknowledged_vehicle() -> Played:
    acknowledge = VehicleCommand(command="c2", kind=CommandKind.ACKNOWLEDGE)
    return stopped_vehicle_with_a_load().told("operator", granted("ATV1", acknowledge))


def vehicle_with_a_problem() -> Played:
    actor = carrying_vehicle()
    actor.report(_vehicle(actor).break_down("the way is blocked", actor.now_s), actor.now_s)
    return actor


def vehicle_in_its_second_life() -> Played:
    actor = carrying_vehicle()
    actor.crash()
    actor.start(actor.now_s + 1.0)
    return actor


# --- a machine -----------------------------------------------------------------------------------


def idle_machine(stock: int = 0) -> Played:
    body = PlainWorkcell("M7", PLANT, dict.fromkeys(MATERIALS, stock))
    return Played(lambda life: Machine("M7", PLANT, incarnation=life), body)


def _workcell(actor: Played) -> PlainWorkcell:
    assert isinstance(actor.body, PlainWorkcell)
    return actor.body


def machine_with_an_unconfirmed_goal() -> Played:
    goal = Award(task="G1", epoch=1, role=Role.PRIMARY, work=production(), deadline_s=3600.0)
    return idle_machine().told(STRATEGIST, goal)


def _with_goal(stock: int) -> Played:
    goal = Award(task="G1", epoch=1, role=Role.PRIMARY, work=production(), deadline_s=3600.0)
    return idle_machine(stock).told(STRATEGIST, goal).told(STRATEGIST, Confirmed(task="G1", epoch=1))


def announcing_machine() -> Played:
    return _with_goal(stock=0)


def producing_machine() -> Played:
    return _with_goal(stock=60)


def asking_machine() -> Played:
    actor = announcing_machine()
    for cost_s, atv in enumerate(("ATV1", "ATV2", "ATV3")):
        # A way and a source as they are in this plant: others would be no bid.
        actor.told(atv, bid(100.0 + cost_s, task="M7-1", source="S1", finish_s=600.0))
    return actor.until(lambda actor: actor.newest(Award))


def machine_with_a_carrier() -> Played:
    return asking_machine().told("ATV1", accepted("M7-1"))


def machine_with_carrier_and_watch() -> Played:
    return machine_with_a_carrier().told("ATV2", accepted("M7-1", role=Role.SECONDARY))


def machine_with_a_silent_carrier() -> Played:
    actor = machine_with_carrier_and_watch()
    actor.run(actor.now_s + 10.0)
    return actor


def machine_with_an_open_dock() -> Played:
    return machine_with_carrier_and_watch().told("ATV1", Docked(task="M7-1", epoch=1, station="M7"))


def supplied_machine() -> Played:
    actor = machine_with_an_open_dock()
    announced = actor.newest(TaskAnnounced)
    assert announced is not None
    work = announced.work
    assert isinstance(work, Transport)
    [brief] = [each for each in _beat(actor).tasks if each.task == "M7-1"]
    reason, reports = _workcell(actor).transfer("ATV1", brief.item, brief.quantity)
    assert not reason
    actor.report(reports, actor.now_s)
    return actor.told("ATV1", Handover(task="M7-1", epoch=1, quantity=brief.quantity))


def _beat(actor: Played) -> MachineHeartbeat:
    actor.run(actor.now_s + 1.0)
    beat = actor.newest(MachineHeartbeat)
    assert beat is not None
    return beat


def machine_with_goods() -> Played:
    return producing_machine().until(lambda actor: _workcell(actor).made.get(PRODUCT, 0) >= 24)


def broken_machine() -> Played:
    actor = producing_machine()
    actor.report(_workcell(actor).break_down("no air"), actor.now_s)
    return actor


def machine_in_its_second_life() -> Played:
    actor = machine_with_carrier_and_watch()
    actor.crash()
    actor.start(actor.now_s + 1.0)
    return actor


# --- the strategist ------------------------------------------------------------------------------


def idle_strategist() -> Played:
    return Played(lambda life: Strategist(PLANT, incarnation=life), PlainGate())


def idle_gate() -> Played:
    return Played(lambda life: DeliveryGate(PLANT, incarnation=life), PlainGate())


def gate_with_goods() -> Played:
    actor = idle_gate().told("strategist", AdmissionAsked("O1-1.1", 24, 1, 1))
    assert isinstance(actor.body, PlainGate)
    _, reports = actor.body.put("O1-1.1", 5)
    actor.report(reports, actor.now_s)
    return actor


def gated_strategist() -> Played:
    actor = Played(lambda life: GatedStrategist(PLANT, incarnation=life), PlainGate())
    return actor.told(GATE, GateReported("", (), more=False, since=1))


def strategist_with_an_order() -> Played:
    order = OrderReleased(order="O1", items=(OrderItem(product=PRODUCT, quantity=48),), due_s=7200.0)
    return idle_strategist().told("gateway", order)


def asking_strategist() -> Played:
    actor = strategist_with_an_order().told("M7", goal_bid("O1-1.1", 60.0))
    return actor.until(lambda actor: actor.newest(Award))


def strategist_with_a_machine() -> Played:
    answer = Accepted(task="O1-1.1", epoch=1, role=Role.PRIMARY, finish_s=500.0)
    return asking_strategist().told("M7", answer)


def strategist_with_a_silent_machine() -> Played:
    goal = GoalBrief(goal="O1-1.1", product=PRODUCT, quantity=24, made=3, delivered=0)
    actor = strategist_with_a_machine().told("M7", mhb("M7", goal))
    actor.run(actor.now_s + 60.0)
    return actor


def strategist_in_its_second_life() -> Played:
    actor = strategist_with_a_machine()
    actor.crash()
    actor.start(actor.now_s + 1.0)
    return actor


SITUATIONS: tuple[Callable[[], Played], ...] = (
    idle_vehicle,
    vehicle_on_its_way_to_a_charger,
    charging_vehicle,
    vehicle_that_has_bid,
    approaching_vehicle,
    loading_vehicle,
    carrying_vehicle,
    docked_vehicle,
    unloading_vehicle,
    vehicle_that_hands_over,
    returning_vehicle,
    vehicle_at_the_goods,
    vehicle_with_goods,
    watching_vehicle,
    stopped_vehicle,
    stopped_vehicle_with_a_load,
    acknowledged_vehicle,
    vehicle_with_a_problem,
    vehicle_in_its_second_life,
    idle_machine,
    machine_with_an_unconfirmed_goal,
    announcing_machine,
    producing_machine,
    asking_machine,
    machine_with_a_carrier,
    machine_with_carrier_and_watch,
    machine_with_a_silent_carrier,
    machine_with_an_open_dock,
    supplied_machine,
    machine_with_goods,
    broken_machine,
    idle_gate,
    gate_with_goods,
    gated_strategist,
    machine_in_its_second_life,
    idle_strategist,
    strategist_with_an_order,
    asking_strategist,
    strategist_with_a_machine,
    strategist_with_a_silent_machine,
    strategist_in_its_second_life,
)
