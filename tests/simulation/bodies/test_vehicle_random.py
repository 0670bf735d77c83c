"""Whatever a vehicle is told and whatever befalls it, some things never happen.

Hypothesis plays agent, people and fate against two vehicles that share storages, dock and chargers.
"""

from __future__ import annotations

from collections import Counter

from hypothesis import settings
from hypothesis import strategies as st
from hypothesis.stateful import RuleBasedStateMachine, initialize, invariant, precondition, rule
from yard import PLANT, Yard, drive

from dray.body import (
    ActionDone,
    ActionFailed,
    Charge,
    Drop,
    Hold,
    LimitSpeed,
    NodePassed,
    OpenDock,
    Pick,
    ReleaseWay,
    StartCycle,
    Unhold,
    WayDone,
)
from dray.messages.base import Part
from dray_sim.bodies.vehicle.odometer import Activity
from dray_sim.bodies.vehicle.vehicle import SimVehicle

ROUNDING = 1e-9
NODES = st.sampled_from(sorted(PLANT.nodes))
WHO = st.sampled_from(["ATV1", "ATV2"])
ITEMS = st.sampled_from(["shaft", "seal", "gear"])
STATIONS = st.sampled_from(["S1", "M1", "SOURCE", "DELIVERY"])
INITIAL = {"shaft": 60, "seal": 15}


class Carried(Part, frozen=True):
    """People have carried the vehicle to a node; it does not say so itself."""

    node: str


class VehicleMachine(RuleBasedStateMachine):
    """Two vehicles, a workcell, and everything that can be done to them."""

    @initialize(levels=st.tuples(st.floats(0.001, 1.0), st.floats(0.001, 1.0)))
    def begin(self, levels: tuple[float, float]) -> None:
        self.yard = Yard()
        self.vehicles = {
            "ATV1": self.yard.vehicle("west", levels[0], "ATV1"),
            "ATV2": self.yard.vehicle("east", levels[1], "ATV2"),
        }
        self.order = 0
        self.by_hand: Counter[str] = Counter()
        """What people have taken off vehicles."""
        self.actions: dict[str, set[int]] = {"ATV1": set(), "ATV2": set()}
        self.standing: dict[str, tuple[float, float]] = {}
        """Where a vehicle has come to a stand that may not move."""
        self.metres = dict.fromkeys(self.vehicles, 0.0)
        self.seconds = dict.fromkeys(self.vehicles, dict.fromkeys(Activity, 0.0))

    def next_order(self) -> int:
        self.order += 1
        return self.order

    # --- the agent ---

    @rule(who=WHO, goal=NODES, part=st.floats(0.0, 1.0))
    def drive_to(self, who: str, goal: str, part: float) -> None:
        vehicle = self.vehicles[who]
        nodes = PLANT.routes("light").way(vehicle.sense().next_node, goal).nodes
        released = 1 + round(part * (len(nodes) - 1))
        order = self.next_order()
        vehicle.instruct(drive(*nodes, order=order, released=released))
        self.yard.run(self.yard.clock.now_s())
        failures = [said for _, _, said in self.yard.said if isinstance(said, ActionFailed)]
        assert all(failure.order != order for failure in failures)

    @rule(who=WHO, nodes=st.lists(NODES, max_size=3), released=st.integers(-1, 4))
    def drive_anywhere(self, who: str, nodes: list[str], released: int) -> None:
        self.vehicles[who].instruct(drive(*nodes, order=self.next_order(), released=released))

    @rule(who=WHO, back=st.integers(0, 3), released=st.integers(0, 7))
    def release(self, who: str, back: int, released: int) -> None:
        self.vehicles[who].instruct(ReleaseWay(order=self.order - back, released=released))

    @rule(who=WHO, station=STATIONS, item=ITEMS, quantity=st.sampled_from([1, 5, 10, 20]))
    def pick(self, who: str, station: str, item: str, quantity: int) -> None:
        order = self.next_order()
        self.actions[who].add(order)
        self.vehicles[who].instruct(Pick(order=order, station=station, item=item, quantity=quantity))

    @rule(who=WHO, station=STATIONS)
    def drop(self, who: str, station: str) -> None:
        order = self.next_order()
        self.actions[who].add(order)
        self.vehicles[who].instruct(Drop(order=order, station=station))

    @rule(who=WHO, charger=st.sampled_from(["CH1", "CH2"]))
    def charge(self, who: str, charger: str) -> None:
        self.vehicles[who].instruct(Charge(order=self.next_order(), charger=charger))

    @rule(who=WHO)
    def hold(self, who: str) -> None:
        self.vehicles[who].instruct(Hold())

    @rule(who=WHO)
    def unhold(self, who: str) -> None:
        self.vehicles[who].instruct(Unhold())

    @rule(who=WHO, speed_frac=st.floats(-0.5, 1.5))
    def limit_speed(self, who: str, speed_frac: float) -> None:
        self.vehicles[who].instruct(LimitSpeed(speed_frac=speed_frac))

    @rule(who=WHO)
    def open_dock(self, who: str) -> None:
        state = self.vehicles[who].sense()
        item, quantity = (state.load, state.load_quantity) if state.load else ("gear", 1)
        self.yard.workcell.instruct(OpenDock(vehicle=who, item=item, quantity=quantity))

    @rule()
    def start_cycle(self) -> None:
        self.yard.workcell.instruct(StartCycle(product="gear"))

    # --- fate ---

    @rule(who=WHO, broken=st.booleans())
    def break_or_repair(self, who: str, broken: bool) -> None:
        if broken:
            self.vehicles[who].break_down("wheel")
        else:
            self.vehicles[who].repair()

    @rule(who=WHO, power=st.booleans())
    def switch(self, who: str, power: bool) -> None:
        if power:
            self.vehicles[who].power_on()
        else:
            self.vehicles[who].power_off()

    @rule(who=WHO)
    def shift_load(self, who: str) -> None:
        self.vehicles[who].shift_load()

    @rule(who=WHO)
    def take_load_off(self, who: str) -> None:
        item, quantity = self.vehicles[who].recover_load()
        self.by_hand[item] += quantity

    @rule(who=WHO, node=NODES)
    def carry(self, who: str, node: str) -> None:
        # What was said before belongs to where it stood before.
        self.yard.run(self.yard.clock.now_s())
        self.vehicles[who].place_at(node)
        self.standing.pop(who, None)
        self.yard.said.append((self.yard.clock.now_s(), who, Carried(node=node)))

    @rule(who=WHO, level_frac=st.floats(0.01, 1.0))
    def replace_battery(self, who: str, level_frac: float) -> None:
        self.vehicles[who].replace_battery(level_frac)

    @rule(seconds=st.one_of(st.floats(0.0, 3.0), st.floats(0.0, 120.0)))
    def pass_time(self, seconds: float) -> None:
        self.yard.run(self.yard.clock.now_s() + seconds)

    @precondition(lambda self: bool(self.yard.clock.heap))
    @rule()
    def go_to_the_next_event(self) -> None:
        self.yard.step()

    # --- what must hold ---

    @invariant()
    def a_stopped_vehicle_does_not_move(self) -> None:
        for who, vehicle in self.vehicles.items():
            state = vehicle.sense()
            pose = (state.pose.x_m, state.pose.y_m)
            if (state.held or vehicle.problem or vehicle.off) and state.speed_mps == 0.0:
                assert pose == self.standing.setdefault(who, pose)
            else:
                self.standing.pop(who, None)

    @invariant()
    def batteries_are_between_empty_and_full(self) -> None:
        for vehicle in self.vehicles.values():
            assert 0.0 <= vehicle.sense().battery_frac <= 1.0

    @invariant()
    def no_vehicle_is_too_fast(self) -> None:
        for vehicle in self.vehicles.values():
            assert 0.0 <= vehicle.sense().speed_mps <= 1.0 + 1e-4

    @invariant()
    def odometers_only_grow_and_all_time_is_accounted_for(self) -> None:
        for who, vehicle in self.vehicles.items():
            sums = vehicle.odometer()
            assert sums.metres_m >= self.metres[who] - ROUNDING
            assert all(sums.seconds[each] >= self.seconds[who][each] - ROUNDING for each in Activity)
            assert abs(sum(sums.seconds.values()) - self.yard.clock.now_s()) < 1e-6
            self.metres[who], self.seconds[who] = sums.metres_m, sums.seconds

    @invariant()
    def material_is_conserved(self) -> None:
        cell, states = self.yard.workcell, [vehicle.sense() for vehicle in self.vehicles.values()]
        for item, initial in INITIAL.items():
            on_board = sum(state.load_quantity for state in states if state.load == item)
            in_cell = cell.sense().stock[item] + cell.consumed[item]
            there = self.yard.storage.stock[item] + on_board + in_cell + self.by_hand[item]
            assert initial + self.yard.source.supplied(item) == there
        gears = sum(state.load_quantity for state in states if state.load == "gear")
        gears += self.by_hand["gear"] + self.yard.delivery.arrived["gear"]
        assert cell.made["gear"] == cell.sense().stock["gear"] + gears

    @invariant()
    def a_vehicle_is_on_a_lane_or_at_a_node(self) -> None:
        for vehicle in self.vehicles.values():
            state = vehicle.sense()
            start, end = PLANT.nodes[state.node], PLANT.nodes[state.next_node]
            assert state.node == state.next_node or PLANT.roads.lane(state.node, state.next_node)
            assert min(start.x_m, end.x_m) - 1e-6 <= state.pose.x_m <= max(start.x_m, end.x_m) + 1e-6
            assert min(start.y_m, end.y_m) - 1e-6 <= state.pose.y_m <= max(start.y_m, end.y_m) + 1e-6

    @invariant()
    def an_action_ends_at_most_once(self) -> None:
        for who, orders in self.actions.items():
            ends = [
                said.order
                for _, speaker, said in self.yard.said
                if speaker == who and isinstance(said, ActionDone | ActionFailed) and said.order in orders
            ]
            assert len(ends) == len(set(ends))

    @invariant()
    def nodes_are_passed_one_after_the_other_along_lanes(self) -> None:
        for who in self.vehicles:
            nodes = ["west" if who == "ATV1" else "east"]
            for _, speaker, said in self.yard.said:
                if speaker == who and isinstance(said, NodePassed):
                    assert said.node == nodes[-1] or PLANT.roads.lane(nodes[-1], said.node)
                    nodes.append(said.node)
                elif speaker == who and isinstance(said, Carried):
                    nodes = [said.node]
                elif speaker == who and isinstance(said, WayDone):
                    assert said.node == nodes[-1]

    def teardown(self) -> None:
        if hasattr(self, "yard"):
            self.free_vehicles_finish_their_ways()

    def free_vehicles_finish_their_ways(self) -> None:
        """However it was mistreated: repaired, let go and released, every vehicle gets where it should."""
        for vehicle in self.vehicles.values():
            self.send_home(vehicle)

    def send_home(self, vehicle: SimVehicle) -> None:
        self.order += 1
        vehicle.power_on()
        vehicle.repair()
        vehicle.replace_battery()
        nodes = PLANT.routes("light").way(vehicle.sense().next_node, "west").nodes
        said = self.yard.do(
            vehicle,
            LimitSpeed(speed_frac=1.0),
            Unhold(),
            drive(*nodes, order=self.order),
            for_s=1000.0,
        )
        assert WayDone(order=self.order, node="west") in said
        assert vehicle.sense().node == "west"


VehicleMachine.TestCase.settings = settings(max_examples=60, stateful_step_count=40, deadline=None)
test_a_vehicle_survives_whatever_it_is_told = VehicleMachine.TestCase
