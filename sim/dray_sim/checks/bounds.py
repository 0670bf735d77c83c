"""Upper bounds of all durations once every fault is over: pure arithmetic over a plant.

    settle_s      = NOTICE_S + PATIENCE_MAX_S + calling + vehicles * one duty of an operator, where there are any, with their rests
                    + 2 * vehicles / chargers * one full charge, where that takes minutes
    transport_s   = bidding + 2 * longest way + loading + unloading + ASKING_S
    task bound_s  = settle_s + transport_s * (1 + tasks that were done meanwhile / vehicles that are able)
    stall bound_s = settle_s + GOAL_BIDDING_S + transport_s + longest cycle + longest rest
    must charge_s = vehicles / chargers * charging from empty until a vehicle takes work again, where that takes long

In the worst case a task waits while the whole fleet carries others. So its bound grows with the transports that were
done meanwhile, and with nothing else. A task that waits while no transport is done is a deadlock. A task that is
passed over again and again is caught as soon as other tasks run out. The demand has ended by then, so they do. The
stall bound holds for all work together: as long as any order is open, some progress must come within it.
"""

from __future__ import annotations

from math import ceil

from dray.plant import Plant
from dray.plant.people import people_of
from dray.plant.working_time import DAY_S, WorkingTime
from dray.protocol.calls.call_rules import ANSWER_S as CALL_ANSWER_S
from dray.protocol.calls.call_rules import ASKED_IN_ROUND, LATE_S, REST_MAX_S
from dray.protocol.contract_net.auction_rules import AuctionRules
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, LATENESS_MAX_S, bound_s
from dray.protocol.people.patience import PATIENCE_MAX_S
from dray_sim.bodies.vehicle.battery import Battery
from dray_sim.people.habits import Habits
from dray_sim.people.operators import LOOK_S
from dray_sim.people.tablet import ANSWER_S, TRIES

NOTICE_S = bound_s(IDLE_INTERVAL_S, loss_frac=1.0, deviation_s=LATENESS_MAX_S) + 25.0
"""Time from the end of the last fault until agents know the living agents and the carriers of tasks. It is the
longest bound of suspicion, for an idle vehicle on the worst link, and its consequences."""

ASKING_S = 20.0
"""Docks that are held for a moment, questions asked again, a handover answered."""

GOAL_BIDDING_S = 60.0
"""The strategist's rounds for a goal, at most."""

QUICK_CHARGE_S = 1200.0
"""A battery that is filled in less is emptied in an hour of driving, and counts in a run."""


class Bounds:
    """The bounds of one plant.

    Args:
        plant: where the ways are.
        habits: of its operators, if there are any.
    """

    def __init__(self, plant: Plant, habits: Habits | None) -> None:
        rules = AuctionRules()
        kinds = [plant.vehicle_types[spec.type] for spec in plant.fleet.values()]
        self._able = {
            ability: sum(ability in kind.abilities for kind in kinds)
            for ability in sorted({ability for kind in kinds for ability in kind.abilities})
        }
        self._plant = plant
        # In the worst case every vehicle needs a person, and all stand in one area.
        duties_s = 0.0 if habits is None else _calling_s(habits) + len(kinds) * _duty_s(habits)
        duties_s = _with_rests_s(plant, duties_s)
        self.settle_s = NOTICE_S + PATIENCE_MAX_S + duties_s + _charging_s(plant)
        """Longest time until all agents have noticed the end of the faults, and people have repaired everything (s)."""
        handling_s = max(kind.load_s + kind.unload_s for kind in kinds)
        bidding_s = (
            rules.rest_aged_max_s + rules.window_max_s + rules.answer_s * rules.window_max_s / rules.window_s
        )
        self.transport_s = bidding_s + 2.0 * _longest_way_s(plant) + handling_s + ASKING_S
        """Longest time from the announcement to the handover, with a free vehicle (s)."""
        cycle_s = max(making.cycle_s for spec in plant.machines.values() for making in spec.makes)
        self.stall_s = self.settle_s + GOAL_BIDDING_S + self.transport_s + cycle_s + _longest_rest_s(plant)
        """Longest time without any progress while anything is open (s)."""
        self.must_charge_s = _must_charge_s(plant)
        """Additional time for all of these while a vehicle must charge (s)."""

    def task_s(self, item: str, done_meanwhile: int) -> float:
        """Longest time for which a transport may stay open (s).

        Args:
            item: of the transport.
            done_meanwhile: transports that were delivered since it was announced, or since the quiet phase began.
        """
        able = self._able.get(self._plant.ability_of(item), 1)
        return self.settle_s + self.transport_s * (1.0 + done_meanwhile / able)


def _charging_s(plant: Plant) -> float:
    """Time until the last vehicle of an empty fleet has charged, and once more for its use meanwhile.

    Zero where batteries outlast a run by far.
    """
    if not _charges_quickly(plant):
        return 0.0
    kinds = [plant.vehicle_types[spec.type] for spec in plant.fleet.values()]
    charge_s = max(Battery(kind).charging_s(0.0) for kind in kinds)
    return 2.0 * ceil(len(kinds) / len(plant.chargers)) * charge_s


def _must_charge_s(plant: Plant) -> float:
    """Time until the last of a fleet that must charge takes work again; 0 where every bound includes full charges."""
    if _charges_quickly(plant) or not plant.chargers:
        return 0.0
    types = sorted({spec.type for spec in plant.fleet.values()})
    one_s = max(
        Battery(plant.vehicle_types[kind]).charging_s(0.0, plant.charger_queue.enough_frac(kind))
        for kind in types
    )
    return ceil(len(plant.fleet) / len(plant.chargers)) * one_s


def _charges_quickly(plant: Plant) -> bool:
    kinds = [plant.vehicle_types[spec.type] for spec in plant.fleet.values()]
    return min(kind.battery_wh / kind.charge_w for kind in kinds) * 3600.0 <= QUICK_CHARGE_S


def _longest_way_s(plant: Plant) -> float:
    """Between any two places where something is fetched, brought or kept, for the slowest vehicle."""
    places = (*plant.machines, *plant.storages, *plant.delivery_warehouses, *plant.dwell_points)
    nodes = sorted({plant.node_of(place) for place in places})
    routes = [plant.routes(kind) for kind in sorted({spec.type for spec in plant.fleet.values()})]
    return max(each.duration_s(start, end) for each in routes for start in nodes for end in nodes)


def _longest_rest_s(plant: Plant) -> float:
    """Longest rest of any machine, by its working time on the first day: runs do not last longer."""
    return max(_rest_s(plant.working_time_of(machine)) for machine in plant.machines)


def _rest_s(working_time: WorkingTime) -> float:
    longest_s = at_s = 0.0
    while at_s < DAY_S:
        on_s = working_time.next_on_s(at_s)
        longest_s = max(longest_s, on_s - at_s)
        at_s = working_time.next_change_s(on_s)
    return longest_s


def _with_rests_s(plant: Plant, duties_s: float) -> float:
    """The duties with the rests of the people who do them, by the working time of their area on the first day."""
    times = [people_of(plant, area) for area in plant.areas] or [plant.working_time]
    return max(_longest_s(working_time, duties_s) for working_time in times)


def _longest_s(working_time: WorkingTime, work_s: float) -> float:
    """Longest time that so much work takes, from any moment of the first day: the worst beginning is that of a rest."""
    longest_s = at_s = 0.0
    while at_s < DAY_S and work_s > 0.0:
        longest_s = max(longest_s, working_time.after_s(at_s, work_s) - at_s)
        at_s = working_time.next_change_s(working_time.next_on_s(at_s))
    return longest_s


def _calling_s(habits: Habits) -> float:
    """Time until a person who will come answers a call: earlier takers stay away, and for a while no one was there."""
    promised_s = habits.estimate[1] * (habits.walk_s[1] + habits.mend_s[1])
    return promised_s + LATE_S + len(ASKED_IN_ROUND) * CALL_ANSWER_S + REST_MAX_S


def _duty_s(habits: Habits) -> float:
    """The longest that one vehicle keeps an operator."""
    there_s = LOOK_S + habits.react_s[1] + habits.walk_s[1]
    mending_s = habits.mend_s[1] + ANSWER_S * TRIES
    return there_s + max(mending_s, habits.carry_s[1] + habits.push_s[1])
