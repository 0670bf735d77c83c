"""The benchmark that kills: what a kill costs, and who is killed next."""

from __future__ import annotations

from random import Random
from typing import Any

import msgspec
from check_kit import opened
from losses_kit import GOAL, SMALL, Ailing, Deaf, Told, closed, heartbeat, taken

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Brief,
    GoalBrief,
    Phase,
    Pose,
    Reason,
    Role,
)
from dray.messages.fact import (
    CarrierChanged,
    GoalLost,
    PhaseEntered,
    PieceMade,
    WatchLost,
)
from dray_sim.bench.losses import campaign
from dray_sim.bench.losses.cost import (
    ANNOUNCED,
    GIVEN_AWAY,
    KEPT,
    TAKEN_OVER,
    WATCHED_ANEW,
    Fate,
    Kill,
    fates,
)
from dray_sim.bench.losses.victims import DATABASE, LASTING, Kind, Rota, Victim, crew, machine, vehicle
from dray_sim.bench.losses.works import Works


def changed(carrier: str) -> CarrierChanged:
    return CarrierChanged(task="M8-1", epoch=2, replaced="ATV2", carrier=carrier, reason=Reason.SILENT)


# --- what it costs ----------------------------------------------------------------------------------


def fate_of(kind: Kind, name: str, work: str, told: Told) -> list[Fate]:
    return fates(Kill(Victim(name, kind, (work,)), at_s=1.5, away_s=2.0), Works(told.events))


def test_a_task_is_taken_over_when_its_secondary_has_it() -> None:
    told = Told()
    told.by("M8", opened("M8-1"), changed("ATV3"))
    assert fate_of(Kind.FETCHING, "ATV2", "M8-1", told) == [Fate(TAKEN_OVER, 2.0)]


def test_a_task_that_was_announced_anew_goes_on_when_somebody_has_taken_it() -> None:
    told = Told()
    told.by("M8", opened("M8-1"), changed(""))
    told.by("ATV3", taken("M8-1"))
    for kind in (Kind.LOADED, Kind.VEHICLE_AWAY):
        assert fate_of(kind, "ATV2", "M8-1", told) == [Fate(ANNOUNCED, 3.0)]


def test_a_vehicle_that_comes_back_in_time_keeps_its_task() -> None:
    told = Told()
    told.by("M8", opened("M8-1"))
    told.by("ATV2", PhaseEntered(task="M8-1", epoch=1, phase=Phase.LOADING), life=2)
    assert fate_of(Kind.FETCHING, "ATV2", "M8-1", told) == [Fate(KEPT, 2.0)]


def test_a_task_without_its_secondary_is_watched_anew() -> None:
    told = Told()
    told.by("M8", opened("M8-1"), WatchLost(task="M8-1", epoch=1, secondary="ATV4", reason=Reason.SILENT))
    told.by("ATV5", taken("M8-1", Role.SECONDARY))
    assert fate_of(Kind.WATCHING, "ATV4", "M8-1", told) == [Fate(WATCHED_ANEW, 3.0)]


def test_a_goal_is_given_to_another_machine_or_kept() -> None:
    told = Told()
    told.by("strategist", opened("G1", GOAL), GoalLost(goal="G1", machine="M8", arrived=0, successor="G2"))
    for kind in (Kind.MACHINE, Kind.MACHINE_AWAY):
        assert fate_of(kind, "M8", "G1", told) == [Fate(GIVEN_AWAY, 2.0)]
    told = Told()
    told.by("strategist", opened("G1", GOAL))
    told.by("M8", PieceMade(goal="G1", product="pump-p3", made=7), life=2)
    assert fate_of(Kind.MACHINE, "M8", "G1", told) == [Fate(KEPT, 2.0)]


def test_what_was_over_before_the_kill_has_no_fate() -> None:
    told = Told()
    told.by("M8", closed("M8-1"))
    assert fate_of(Kind.LOADED, "ATV2", "M8-1", told) == []


# --- who is next ------------------------------------------------------------------------------------


def beat(**fields: object) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv="ATV2",
        incarnation=1,
        seq=1,
        at_s=0.0,
        status=AtvStatus.WORKING,
        pose=Pose(0.0, 0.0, 0.0),
        node="c3",
        speed_mps=0.0,
        battery_frac=1.0,
        **fields,
    )


def brief(role: Role, phase: Phase | None = None) -> Brief:
    return Brief(task="M8-1", epoch=1, role=role, coordinator="M8", phase=phase)


def test_a_victim_is_what_it_says_of_itself() -> None:
    approaching = brief(Role.PRIMARY, Phase.APPROACHING)
    assert vehicle(beat()) == Victim("ATV2", Kind.IDLE)
    assert vehicle(beat(task=approaching)) == Victim("ATV2", Kind.FETCHING, ("M8-1",))
    assert vehicle(beat(task=brief(Role.PRIMARY, Phase.CARRYING), load="shaft")).kind is Kind.LOADED
    assert vehicle(beat(task=brief(Role.PRIMARY, Phase.LOADING), load="shaft")).kind is Kind.LOADED
    assert vehicle(beat(watches=(brief(Role.SECONDARY),))) == Victim("ATV2", Kind.WATCHING, ("M8-1",))
    assert vehicle(beat(task=approaching, watches=(brief(Role.SECONDARY),))).kind is Kind.FETCHING
    assert machine(heartbeat()) == Victim("M8", Kind.MACHINE)


def test_a_machine_is_killed_with_all_that_carry_for_it() -> None:
    carrier, other = (
        brief(Role.PRIMARY, Phase.CARRYING),
        msgspec.structs.replace(brief(Role.PRIMARY), coordinator="M9"),
    )
    vehicles = [beat(task=carrier), msgspec.structs.replace(beat(task=other), atv="ATV3"), beat()]
    killed = crew(heartbeat(), vehicles)
    assert killed is not None
    assert (killed.name, killed.kind) == ("M8", Kind.CREW_MACHINE)
    assert killed.crew == (Victim("ATV2", Kind.CREW_VEHICLE, ("M8-1",)),)
    assert crew(heartbeat(), vehicles[1:]) is None


def test_every_kind_has_its_turns_before_chance_does() -> None:
    living = [Victim(kind.value, kind) for kind in Kind]
    rota = Rota(Random(1), dict.fromkeys(Kind, 2))
    assert [rota.choose(living) for _ in range(2 * len(living))] == [*living, *living]
    named = {rota.choose(living) for _ in range(100)}
    assert named == {victim for victim in living if victim.kind not in LASTING}


def test_a_kind_that_nobody_is_of_waits_for_its_turn() -> None:
    rota = Rota(Random(1), dict.fromkeys(Kind, 1))
    idle, loaded = Victim("ATV1", Kind.IDLE), Victim("ATV2", Kind.LOADED)
    assert rota.choose([loaded]) == loaded
    assert rota.choose([idle, loaded]) == idle
    assert rota.choose([loaded]) == loaded
    assert rota.choose([]) is None


def around(killed: dict[Victim, float], back: set[str]) -> list[Victim]:
    """Who may be killed next, of a vehicle and a machine with work, the offices and the database."""
    watch = Deaf(back)
    watch.heard.on_message(0.0, "", "", beat(task=brief(Role.PRIMARY, Phase.CARRYING), load="shaft"))
    goal = GoalBrief(goal="G1", product="pump-p3", quantity=24, made=0, delivered=0)
    watch.heard.on_message(0.0, "", "", heartbeat(goals=(goal,)))
    paper: Any = Ailing(ended=False), watch, None, object()
    field = campaign._Field(SMALL, *paper)
    field._killed = list(killed.items())
    return list(field._living())


def test_who_has_work_may_also_stay_away_one_of_a_kind_at_a_time() -> None:
    assert {victim.kind for victim in around({}, set())} == {
        Kind.LOADED,
        Kind.MACHINE,
        Kind.CREW_MACHINE,
        *(Kind.STRATEGIST, Kind.HISTORIAN, Kind.GATEWAY, Kind.DATABASE),
        *LASTING,
    }
    away = {Victim("ATV7", Kind.VEHICLE_AWAY): 1.0}
    assert Kind.VEHICLE_AWAY not in {victim.kind for victim in around(away, set())}
    assert Kind.VEHICLE_AWAY in {victim.kind for victim in around(away, {"ATV7"})}


def test_who_is_away_is_not_killed_and_the_database_not_while_others_could_not_start_without_it() -> None:
    away = {Victim("ATV2", Kind.LOADED): 1.0, Victim("gateway", Kind.GATEWAY): 1.0}
    assert {victim.name for victim in around(away, set())} == {"M8", "strategist", "historian"}
    assert DATABASE in around(away, {"gateway"})
