"""The run of one seed of the search: a plant, a load, a schedule of faults, and people.

Everything is drawn here, before anything runs, so that a run can be shown and replayed. Plants are small: protocol
errors occur between a handful of agents, and a hundred small runs meet more of them than one large run.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass, field, replace
from random import Random
from typing import Any

from dray.messages.keys import strategists_of
from dray.plant import Plant
from dray.plant.file.check_levels import levels_of
from dray.priorities import Priority
from dray_sim.explore.bodies import Cut, Damage, draw_cuts, draw_damages
from dray_sim.explore.closings import draw_closings, draw_outline
from dray_sim.explore.levels import with_priorities
from dray_sim.explore.profile import PROFILES, Profile
from dray_sim.explore.small_plant import TRANSPORT_S, bearable_load, loads_per_piece, small_plant
from dray_sim.faults import (
    CLOCKS,
    DOORS,
    DROPPED,
    LEAVING,
    OBSTACLES,
    Timed,
    describe,
    random_kills,
    random_schedule,
    random_waves,
)
from dray_sim.insiders import BEHAVIOURS
from dray_sim.people import demand
from dray_sim.people.carriers import Carrying, draw_carryings
from dray_sim.people.floor_manager import Closing
from dray_sim.people.habits import Habits
from dray_sim.people.random.revoker import Revocation
from dray_sim.people.transport_caller import Call, draw_calls, with_things

DURATION_S = 1200.0
"""The least virtual time of a run."""

FAULTS_UNTIL_S = 900.0
"""Beginning of the quiet phase: every fault has ended, no order comes any more, and everything must end."""

LONGEST_S = 6 * 3600.0
"""A run that takes longer is broken, unless its vehicles have more to carry than this allows for."""

LONGEST_PER_WORK = 3.0
"""Longest duration of a run, as a multiple of the time that its whole fleet needs for the transports when it is
always busy. Parts that come in less than whole containers make twice as many ways (seed 10, one vehicle: 2.2)."""

TAKEN_BACK_TIMES = (1, 1, 1, 2, 3)
"""Number of revocations of an order that is revoked at all."""

LONGEST_REST_S = 120.0
"""Longest rest of an order before it is published again: long enough for its goals to be gone, and for goods on the
way to have found the gate shut."""


IMPOSTORS_FRAC = 0.1
"""Fraction of the insiders, in a plant with right of way, that take the name of one of its vehicles."""

DOUBLES_FRAC = 0.1
"""Fraction of these insiders that have the vehicle's key, too."""

USURPERS_FRAC = 0.1
"""Fraction of the insiders that take the name of a replica of reservation tables."""

LEADERS_FRAC = 0.1
"""Fraction of the insiders that take the name of a replica that leads reservation tables."""

LONGEST_CARRIED_S = 400.0
"""Longest absence of a vehicle that people carry away: one that leaves this long before the quiet phase is back by
then, or nearly."""


@dataclass(frozen=True, slots=True)
class Run:
    """One run of the search, completely determined.

    Attributes:
        seed: it follows from this, and from the profile.
        profile: the name of the profile.
        load: part of the machines' time that the demand takes.
        faults_until_s: the quiet phase begins then.
        duration_s: it lasts at least so long, and on until everything has ended.
        orders: the demand.
        codec: whether all messages go through the wire format.
        habits: of the operators; None where there are none.
        random_operator: whether a person presses buttons at random.
        strategists: how many there are.
        random_answers: whether a person answers calls for help at random.
        cancelled: orders that are cancelled, and when (plant clock), in the order of their times.
        revocations: orders that are taken back and published again.
        closings: closures by a manager, with their times.
        carryings: vehicles that people carry away and put back; only where vehicles drive with right of way.
        calls: transports that people ask for, and when they call them off.
        wired: whether machines, stores and the gate are controllers.
        cuts: of their wires, and resets of their counters.
        damages: of what their bodies have kept.
        insider: the behaviour of an insider until the quiet phase (`dray_sim.insiders`); empty where there is none.
        traffic: whether vehicles drive with right of way; nothing but the carryings follows from it.
    """

    seed: int
    profile: str
    plant: Plant
    load: float
    stock_frac: tuple[float, float]
    faults_until_s: float
    duration_s: float
    codec: bool
    habits: Habits | None
    random_operator: bool
    orders: tuple[demand.Order, ...] = field(repr=False)
    schedule: tuple[Timed, ...] = field(repr=False)
    cancelled: tuple[tuple[float, str], ...] = field(repr=False)
    revocations: tuple[Revocation, ...] = field(repr=False)
    closings: tuple[Closing, ...] = field(repr=False, default=())
    carryings: tuple[Carrying, ...] = field(repr=False, default=())
    calls: tuple[Call, ...] = field(repr=False, default=())
    insider: str = ""
    traffic: bool = False
    random_answers: bool = False
    strategists: int = 1
    wired: bool = False
    cuts: tuple[Cut, ...] = field(repr=False, default=())
    damages: tuple[Damage, ...] = field(repr=False, default=())

    @property
    def has_faults(self) -> bool:
        """Whether it has faults."""
        people = self.random_operator or self.insider or self.closings or self.carryings
        return bool(self.schedule or people or self.cuts or self.damages)

    @property
    def bodies_until_s(self) -> float:
        """When all wires are whole, and people have counted where memories were damaged."""
        ends_s = [cut.until_s for cut in self.cuts] + [damage.until_s for damage in self.damages]
        return max(ends_s, default=0.0)

    @property
    def has_scrap(self) -> bool:
        """Whether machines make bad pieces."""
        return any(making.scrap_frac for spec in self.plant.machines.values() for making in spec.makes)

    @property
    def longest_s(self) -> float:
        """A run that has not ended by then is broken."""
        loads = sum(
            item.quantity * loads_per_piece(self.plant, item.product)
            for order in self.orders
            for item in order.items
        )
        return max(LONGEST_S, LONGEST_PER_WORK * loads * TRANSPORT_S / len(self.plant.fleet))

    def __str__(self) -> str:
        """One line for a reader."""
        parts = (
            f"{len(self.plant.machines)} machines",
            *((f"{levels_of(self.plant.file)} levels",) if self.plant.parts else ()),
            f"{len(self.plant.fleet)} vehicles",
            *((f"{self.strategists} strategists",) if self.strategists > 1 else ()),
            f"{len(self.orders)} orders ({len(self.cancelled)} cancelled, {len(self.revocations)} taken back)",
            f"load {self.load:.0%}",
            *(("priorities",) if any(o.priority is not Priority.NORMAL for o in self.orders) else ()),
            *(("bad pieces",) if self.has_scrap else ()),
            *((f"{len(self.calls)} transports called",) if self.calls else ()),
            f"{len(self.schedule)} faults",
            *((f"controllers ({len(self.cuts)} cuts and resets)",) if self.wired else ()),
            *((f"{len(self.damages)} damaged memories",) if self.damages else ()),
            *((f"{len(self.closings)} closures",) if self.closings else ()),
            *((f"{len(self.carryings)} carried away",) if self.carryings else ()),
            "operators" if self.habits is not None else "no operators",
        )
        more = ("a random operator",) * self.random_operator + (f"one that {self.insider}",) * bool(
            self.insider
        )
        return ", ".join((*parts, *more))

    def timetable(self) -> list[str]:
        """The faults and their times, line by line."""
        return [
            f"{timed.at_s:7.1f} to {timed.until_s or self.faults_until_s:7.1f} s  {describe(timed.fault)}"
            for timed in self.schedule
        ] + [str(each) for each in (*self.cuts, *self.damages)]


def draw(seed: int, profile: str = "all", *, traffic: bool = False) -> Run:
    """The run of a seed; the same in every process.

    Args:
        seed: decides everything.
        profile: a name in `PROFILES`.
        traffic: whether vehicles drive with right of way.
    """
    ranges = PROFILES[profile]
    # A generator is named by the seed and a word. Another word draws another run, so these stay as they are.
    random = Random(f"{seed} trial")
    plant = small_plant(seed, ranges, random)
    load = random.uniform(*ranges.load) * min(1.0, bearable_load(plant))
    emptiest = random.uniform(*ranges.stock_frac)
    orders = tuple(demand.orders(plant, Random(f"{seed} demand"), load=load, until_s=FAULTS_UNTIL_S))
    if Random(f"{seed} has priorities").random() < ranges.priorities_frac:
        orders = with_priorities(orders, Random(f"{seed} priorities"))
    run = Run(
        seed=seed,
        profile=profile,
        plant=plant,
        load=load,
        stock_frac=(emptiest, max(emptiest, ranges.stock_frac[1])),
        faults_until_s=FAULTS_UNTIL_S,
        duration_s=DURATION_S,
        # It costs time and finds little that the other runs would not: a few runs show that it is harmless.
        codec=random.random() < 0.1,
        habits=_careless(_habits(random), Random(f"{seed} careless"))
        if random.random() < ranges.operators_frac
        else None,
        random_operator=random.random() < ranges.random_operator_frac,
        random_answers=Random(f"{seed} answers").random() < ranges.random_operator_frac,
        orders=orders,
        schedule=_schedule(seed, plant, ranges, random.uniform(*ranges.intensity)),
        strategists=ranges.strategists,
        cancelled=_cancelled(orders, ranges.cancelled_frac, Random(f"{seed} regret")),
        revocations=_revocations(orders, ranges, Random(f"{seed} revised")),
        closings=_closings(plant, ranges, seed),
        carryings=_carryings(plant, ranges, Random(f"{seed} carried")) if traffic else (),
        calls=_calls(plant, ranges, seed),
        insider=_insider(ranges, Random(f"{seed} insider"), Random(f"{seed} impostor"), traffic=traffic),
        traffic=traffic,
        **_bodies(plant, ranges, Random(f"{seed} bodies"), Random(f"{seed} damaged")),
    )
    lies = BEHAVIOURS[run.insider] if run.insider else None
    if lies is not None and (lies.takes_replica or lies.leads_falsely):
        return replace(run, schedule=_of_vehicles(run.schedule, plant))
    if lies is not None and lies.has_key and run.habits is None:
        # A vehicle that has found its double stands until a person lets it go.
        return replace(run, habits=_habits(Random(f"{seed} who lets it go")))
    return run


def _bodies(plant: Plant, ranges: Profile, random: Random, of_damages: Random) -> dict[str, Any]:
    if random.random() >= ranges.bodies_frac:
        return {}
    has_damages = of_damages.random() < ranges.damaged_frac
    return {
        "wired": True,
        "cuts": draw_cuts(plant, random, FAULTS_UNTIL_S),
        "damages": draw_damages(plant, of_damages, FAULTS_UNTIL_S) if has_damages else (),
    }


def _of_vehicles(schedule: tuple[Timed, ...], plant: Plant) -> tuple[Timed, ...]:
    """Faults that do not touch replicas of reservation tables: a thief among two reachable replicas is not defended against."""
    return tuple(timed for timed in schedule if getattr(timed.fault, "agent", "") in plant.fleet)


def _closings(plant: Plant, ranges: Profile, seed: int) -> tuple[Closing, ...]:
    random = Random(f"{seed} closures")
    if random.random() >= ranges.closures_frac:
        return ()
    drawn = draw_outline(plant, Random(f"{seed} outlines"), FAULTS_UNTIL_S)
    return (*draw_closings(plant, random, FAULTS_UNTIL_S), *drawn)


def _calls(plant: Plant, ranges: Profile, seed: int) -> tuple[Call, ...]:
    random = Random(f"{seed} calls")
    if random.random() >= ranges.calls_frac:
        return ()
    calls = draw_calls(
        plant, random, Random(f"{seed} requests"), Random(f"{seed} wanted abilities"), FAULTS_UNTIL_S
    )
    return with_things(plant, calls, Random(f"{seed} things"), ranges.things_frac, FAULTS_UNTIL_S)


def _carryings(plant: Plant, ranges: Profile, random: Random) -> tuple[Carrying, ...]:
    if random.random() >= ranges.carried_frac:
        return ()
    return draw_carryings(plant, random, FAULTS_UNTIL_S - LONGEST_CARRIED_S)


def _insider(ranges: Profile, random: Random, takes_name: Random, *, traffic: bool) -> str:
    """The behaviour of an insider that never moves; one that drives would leave its loads to the quiet phase."""
    if random.random() >= ranges.insiders_frac:
        return ""
    drawn = takes_name.random()
    if traffic and drawn < IMPOSTORS_FRAC:
        return next(name for name, it in BEHAVIOURS.items() if it.takes_name and not it.has_key)
    if traffic and drawn < IMPOSTORS_FRAC + USURPERS_FRAC:
        return next(name for name, behaviour in BEHAVIOURS.items() if behaviour.takes_replica)
    if traffic and drawn < IMPOSTORS_FRAC + USURPERS_FRAC + LEADERS_FRAC:
        return next(name for name, behaviour in BEHAVIOURS.items() if behaviour.leads_falsely)
    if traffic and drawn >= 1.0 - DOUBLES_FRAC:
        return next(name for name, behaviour in BEHAVIOURS.items() if behaviour.has_key)
    still = [name for name, it in BEHAVIOURS.items() if not it.drives and not it.is_thief]
    return random.choice(still)


def _schedule(seed: int, plant: Plant, ranges: Profile, intensity: float) -> tuple[Timed, ...]:
    """Mishaps, agents that leave or are restarted, and clocks that are set, in the order in which they begin."""
    schedule = list(
        random_schedule(plant, Random(f"{seed} faults"), FAULTS_UNTIL_S, intensity, weights=ranges.weights)
    )
    random = Random(f"{seed} sent away")
    if random.random() < ranges.leaving_frac:
        a_minute = random.uniform(*ranges.leaving)
        schedule += random_schedule(plant, random, FAULTS_UNTIL_S, a_minute, weights=LEAVING)
    if ranges.strategists > 1:
        schedule += random_kills(
            strategists_of(ranges.strategists), Random(f"{seed} strategists"), FAULTS_UNTIL_S
        )
    random = Random(f"{seed} waves")
    if random.random() < ranges.waves_frac:
        schedule += random_waves(plant, random, FAULTS_UNTIL_S, random.uniform(*ranges.waves))
    random = Random(f"{seed} clocks")
    if random.random() < ranges.clocks_frac:
        a_minute = random.uniform(*ranges.clocks)
        schedule += random_schedule(plant, random, FAULTS_UNTIL_S, a_minute, weights=CLOCKS)
    random = Random(f"{seed} obstacles")
    if random.random() < ranges.obstacles_frac:
        a_minute = random.uniform(*ranges.obstacles)
        schedule += random_schedule(plant, random, FAULTS_UNTIL_S, a_minute, weights=OBSTACLES)
        dropped = Random(f"{seed} dropped loads")
        a_minute = dropped.uniform(*ranges.obstacles)
        schedule += random_schedule(plant, dropped, FAULTS_UNTIL_S, a_minute, weights=DROPPED)
    if plant.doors:
        random = Random(f"{seed} failing doors")
        a_minute = random.uniform(*ranges.obstacles)
        schedule += random_schedule(plant, random, FAULTS_UNTIL_S, a_minute, weights=DOORS)
    return tuple(sorted(schedule, key=lambda timed: timed.at_s))


def _cancelled(
    orders: tuple[demand.Order, ...], frac: float, random: Random
) -> tuple[tuple[float, str], ...]:
    """Some are cancelled at once, most while they are made."""
    cancelled = [order for order in orders if random.random() < frac]
    return tuple(sorted((random.uniform(order.at_s, FAULTS_UNTIL_S), order.id) for order in cancelled))


def _revocations(orders: tuple[demand.Order, ...], ranges: Profile, random: Random) -> tuple[Revocation, ...]:
    """Taken back at any moment of their lives, some more than once, and published again at once or later."""
    if random.random() >= ranges.revoking_frac:
        return ()
    return tuple(
        Revocation(order, tuple(_takings_back(order.at_s, random)))
        for order in orders
        if random.random() < ranges.revoked_frac
    )


def _takings_back(placed_s: float, random: Random) -> Iterator[tuple[float, float]]:
    at_s = placed_s
    for _ in range(random.choice(TAKEN_BACK_TIMES)):
        at_s = random.uniform(at_s, FAULTS_UNTIL_S)
        again_s = min(at_s + random.choice((0.0, random.uniform(0.0, LONGEST_REST_S))), FAULTS_UNTIL_S)
        yield at_s, again_s
        at_s = again_s


def _habits(random: Random) -> Habits:
    """Quick people, since runs are short; some promise more than they keep."""
    return Habits(
        react_s=(1.0, random.uniform(2.0, 15.0)),
        promises_frac=random.random(),
        estimate=(random.uniform(0.3, 1.0), 1.5),
        walk_s=(5.0, 30.0),
        mend_s=(5.0, random.uniform(10.0, 60.0)),
        carry_s=(10.0, 30.0),
        push_s=(10.0, 30.0),
        silent_s=random.uniform(10.0, 40.0),
        slow_frac=random.uniform(0.3, 1.0),
    )


def _careless(habits: Habits, random: Random) -> Habits:
    """Habits in which some operators forget their promises, and some come on duty and go."""
    forgets_frac = random.uniform(0.0, 0.6) if random.random() < 0.5 else 0.0
    on_duty_s = (20.0, random.uniform(60.0, 400.0)) if random.random() < 0.5 else None
    off_duty_s = (5.0, random.uniform(10.0, 200.0))
    hands_over_frac = random.random()
    hold_s = (1.0, random.uniform(10.0, 200.0))
    return replace(
        habits,
        hands_over_frac=hands_over_frac,
        hold_s=hold_s,
        forgets_frac=forgets_frac,
        on_duty_s=on_duty_s,
        off_duty_s=off_duty_s,
        careless_until_s=FAULTS_UNTIL_S,
    )
