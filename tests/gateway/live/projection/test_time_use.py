"""What time was spent on: exact, whatever was said when."""

from __future__ import annotations

from collections import Counter

import pytest
from heartbeats import atv_heartbeat, events, machine_heartbeat
from hypothesis import given
from hypothesis import strategies as st

from dray.gateway.live.projection.agents.machines import doing as machine_doing
from dray.gateway.live.projection.figures import interventions as interventions_module
from dray.gateway.live.projection.figures.fleet import Fleet, doing
from dray.gateway.live.projection.figures.interventions import Interventions
from dray.gateway.live.projection.figures.time_use import SILENCE_S, SILENT, TimeUse
from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    Brief,
    CommandRefusal,
    GoalBrief,
    MachineStatus,
    OutOfService,
    Pose,
    Role,
)
from dray.messages.fact import CommandObeyed, HelpAsked

GOALS = (GoalBrief(goal="G1", product="P1", quantity=4, made=0, delivered=0),)

# --- time ----------------------------------------------------------------------------------------

STEP_S = 0.25
"""Times are whole numbers of this, so that sums are exact and the twin can look at every instant."""

Said = tuple[str, str, float]
"""Who, what, and when."""


def twin(said: list[Said], until_s: float) -> Counter[str]:
    """The same in the plainest way: look at every agent at every instant, through all that it ever said."""
    spent_s: Counter[str] = Counter()
    for agent in {agent for agent, _, _ in said}:
        told = [(at_s, what) for who, what, at_s in said if who == agent]
        for tick in range(int(told[0][0] / STEP_S), int(until_s / STEP_S)):
            now_s = tick * STEP_S
            heard_s, what = [one for one in told if one[0] <= now_s][-1]
            spent_s[what if now_s < heard_s + SILENCE_S else SILENT] += STEP_S  # type: ignore[assignment]
    return spent_s


@given(
    st.lists(
        st.tuples(st.sampled_from("AB"), st.sampled_from(("moving", "idle", "settle")), st.integers(0, 120)),
        min_size=1,
        max_size=30,
    )
)
def test_time_is_counted_as_by_somebody_who_looks_at_every_instant(
    steps: list[tuple[str, str, int]],
) -> None:
    use, said, now_s = TimeUse(("moving", "idle")), list[Said](), 0.0
    for agent, what, wait in steps:
        now_s += wait * STEP_S
        if what == "settle":
            use.settle(now_s)
        else:
            use.tell(agent, what, now_s)
            said.append((agent, what, now_s))
    use.settle(now_s)
    expected = twin(said, now_s) if said else Counter()
    assert {name: spent_s for name, spent_s in use.totals_s.items() if spent_s} == expected


def test_all_parts_of_the_hour_add_up_and_what_is_older_is_forgotten() -> None:
    use = TimeUse(("moving", "idle"))
    assert use.hour(0.0) == {}
    for at_s in range(0, 7200, 5):
        use.tell("A", "idle" if at_s < 3600 else "moving", float(at_s))
    hour = use.hour(7199.0)
    assert sum(hour.values()) == pytest.approx(1.0)
    assert hour["moving"] > 0.99
    assert use.totals_s["idle"] == 3600.0


def test_a_word_that_comes_late_counts_nothing_twice() -> None:
    use = TimeUse(("moving", "idle"))
    use.tell("A", "moving", 0.0)
    use.settle(10.0)
    use.tell("A", "idle", 8.0)
    use.settle(12.0)
    assert use.totals_s == {"moving": 10.0, "idle": 2.0, SILENT: 0.0}


# --- vehicles and machines -----------------------------------------------------------------------


@pytest.mark.parametrize(
    ("status", "speed_mps", "what"),
    [
        (AtvStatus.WORKING, 1.0, "moving"),
        (AtvStatus.WORKING, 0.0, "waiting"),
        (AtvStatus.IDLE, 1.0, "moving"),
        (AtvStatus.IDLE, 0.0, "idle"),
        (AtvStatus.CHARGING, 0.0, "charging"),
        (AtvStatus.STOPPED, 0.0, "blocked"),
        (AtvStatus.ERROR, 0.0, "blocked"),
    ],
)
def test_what_a_vehicle_does_follows_from_its_status_and_its_speed(
    status: AtvStatus, speed_mps: float, what: str
) -> None:
    assert doing(atv_heartbeat(status=status, speed_mps=speed_mps)) == what


@pytest.mark.parametrize(
    ("status", "with_goal", "without"),
    [
        (MachineStatus.PRODUCING, "making", "idle"),
        (MachineStatus.BLOCKED, "making", "idle"),
        (MachineStatus.STARVED, "starved", "idle"),
        (MachineStatus.ERROR, "broken", "down"),
        (MachineStatus.IDLE, "idle", "idle"),
    ],
)
def test_what_a_machine_does_follows_from_its_status_and_its_goals(
    status: MachineStatus, with_goal: str, without: str
) -> None:
    assert machine_doing(machine_heartbeat(status=status, goals=GOALS)) == with_goal
    assert machine_doing(machine_heartbeat(status=status)) == without


def drive(*legs: tuple[float, float, str]) -> Fleet:
    """A vehicle that is at a place (m) at a time (s), with this on board from there on."""
    fleet, last = Fleet(top_mps=1.5), None
    for seq, (at_s, x_m, load) in enumerate(legs, 1):
        heartbeat: AtvHeartbeat = atv_heartbeat(seq=seq, at_s=at_s, pose=Pose(x_m, 0.0, 0.0), load=load)
        fleet.fold(last, heartbeat)
        last = heartbeat
    return fleet


def test_a_way_is_empty_or_loaded_by_what_was_on_board_when_it_began() -> None:
    fleet = drive((0.0, 0.0, ""), (10.0, 6.0, "shaft"), (20.0, 16.0, "shaft"), (21.0, 16.0, ""))
    assert (fleet.empty_m, fleet.loaded_m) == (6.0, 10.0)
    assert fleet.empty_frac(21.0) == pytest.approx(0.375)
    assert fleet.empty_frac(21.0 + 7200.0) is None


def test_a_vehicle_that_was_carried_while_it_was_silent_has_not_driven() -> None:
    fleet = drive((0.0, 0.0, ""), (SILENCE_S + 1.0, 50.0, ""))
    assert (fleet.empty_m, fleet.loaded_m) == (0.0, 0.0)


# --- people --------------------------------------------------------------------------------------


def test_commands_that_were_obeyed_and_cries_for_help_are_counted_once_each() -> None:
    seen = Interventions()
    told = events(
        "ATV1",
        CommandObeyed(command="c1", what="stop", done=True),
        CommandObeyed(command="c2", what="resume", done=False, reason=CommandRefusal.NOT_ACKNOWLEDGED),
        HelpAsked(task="T1", reason="the load has shifted", until_s=300.0),
    )
    assert [seen.fold(event) for event in [*told, *told]] == [True, False, True, False, False, False]
    assert (seen.commands, seen.helps) == (1, 1)
    assert seen.in_hour(110.0) == (1, 1)
    assert seen.in_hour(110.0 + 7200.0) == (0, 0)


def test_what_was_seen_is_not_remembered_for_ever(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(interventions_module, "SEEN_KEPT", 3)
    seen = Interventions()
    for event in events("ATV1", *[CommandObeyed(command=f"c{n}", what="stop", done=True) for n in range(9)]):
        assert seen.fold(event)
    assert len(seen._seen) == 3


def test_time_out_of_service_is_counted_apart_and_lasts_through_silence() -> None:
    fleet = Fleet(2.0)
    out = OutOfService(by="Maria", since_s=0.0)
    fleet.fold(None, atv_heartbeat(at_s=0.0, status=AtvStatus.ERROR, out_of_service=out))
    fleet.use.settle(1000.0)
    assert fleet.use.totals_s["out_of_service"] == 1000.0
    assert sum(fleet.use.totals_s.values()) == 1000.0
    carrying = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M1")
    assert doing(atv_heartbeat(task=carrying, status=AtvStatus.WORKING, out_of_service=out)) == "waiting"
