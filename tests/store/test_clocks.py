"""How far clocks are off, and what is made of times by one that is wrong."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    BodyWait,
    Brief,
    Event,
    HelpWanted,
    LostWlan,
    MachineHeartbeat,
    MachineStatus,
    OutOfService,
    Pose,
    Role,
)
from dray.messages.fact import GoalContracted, OrderFulfilled
from dray.store.history.clocks import HEARD_KEPT, OLDEST_S, Clocks

NOW_S = 1.9e9


def beat(atv: str, at_s: float) -> AtvHeartbeat:
    return AtvHeartbeat(
        atv=atv,
        incarnation=1,
        seq=1,
        at_s=at_s,
        status=AtvStatus.IDLE,
        pose=Pose(0.0, 0.0, 0.0),
        node="n1",
        speed_mps=0.0,
        battery_frac=1.0,
    )


def machine_beat(at_s: float) -> MachineHeartbeat:
    return MachineHeartbeat(
        machine="M9",
        incarnation=1,
        seq=1,
        at_s=at_s,
        status=MachineStatus.IDLE,
        help=HelpWanted(until_s=at_s + 60.0),
        out_of_service=OutOfService("anna", since_s=at_s - 5.0),
    )


def heard(
    ahead_s: dict[str, float], *, delays_s: tuple[float, ...] = (0.05,), rounds: int = HEARD_KEPT
) -> Clocks:
    """Everybody beats once a second, by a clock that is so far ahead; delays take turns."""
    clocks = Clocks()
    for second in range(rounds):
        for place, (atv, ahead) in enumerate(ahead_s.items()):
            at_s = NOW_S + second
            delay_s = delays_s[(second + place) % len(delays_s)]
            clocks.right(beat(atv, at_s + ahead), at_s + delay_s)
    return clocks


FLEET = dict.fromkeys(("ATV1", "ATV2", "ATV3", "ATV4"), 0.0)


def test_honest_clocks_are_right_whatever_the_link_takes() -> None:
    clocks = heard(FLEET, delays_s=(0.02, 3.0, 0.5, 4.5))
    assert list(clocks.wrong(NOW_S + 8.0)) == []
    assert all(abs(offset.ahead_s) <= 0.5 for offset in clocks.offsets().values())


@pytest.mark.parametrize("ahead_s", [3.0, 60.0, 3600.0, -3.0, -3600.0, -1.8e9])
def test_a_wrong_clock_is_named_with_its_offset_and_moves_no_other(ahead_s: float) -> None:
    clocks = heard({**FLEET, "ATV9": ahead_s}, delays_s=(0.02, 0.4, 0.1))
    [(agent, offset)] = clocks.wrong(NOW_S + 8.0)
    assert agent == "ATV9"
    assert abs(offset.ahead_s - ahead_s) <= offset.bound_s + 0.5
    assert all(abs(clocks.offsets()[atv].ahead_s) < 0.5 for atv in FLEET)


@pytest.mark.parametrize("ahead_s", [-3600.0, -90.0, 5.0, 3600.0])
def test_how_far_a_clock_is_from_our_own_is_known_whichever_is_wrong(ahead_s: float) -> None:
    clocks = heard({"ATV1": ahead_s, "ATV2": 0.0})
    assert clocks.ahead_s("ATV1") == pytest.approx(ahead_s, abs=0.1)
    assert (clocks.ahead_s("ATV2"), clocks.ahead_s("ATV9")) == (0.0, 0.0)
    clocks.right(beat("ATV1", NOW_S + 10.0), NOW_S + 10.05)
    # Right again: an hour longer is no harm while it is not certain, and an hour shorter would be.
    assert clocks.ahead_s("ATV1") == pytest.approx(max(0.0, ahead_s), abs=0.1)
    ours = heard(dict.fromkeys(("ATV1", "ATV2", "ATV3"), 3600.0))
    assert ours.ahead_s("ATV1") == pytest.approx(3600.0, abs=0.1)


@pytest.mark.parametrize("ahead_s", [-30.0, -0.5, 0.5])
def test_what_links_and_clocks_of_one_plant_explain_is_no_clock_that_is_off(ahead_s: float) -> None:
    assert heard({"ATV1": ahead_s}).ahead_s("ATV1") == 0.0


def test_a_gateway_whose_own_clock_is_wrong_blames_nobody() -> None:
    clocks = heard(dict.fromkeys(FLEET, -500.0))
    assert list(clocks.wrong(NOW_S + 8.0)) == []


def test_times_by_a_wrong_clock_are_told_by_the_right_one() -> None:
    clocks = heard({**FLEET, "ATV9": 3600.0})
    ahead = beat("ATV9", NOW_S + 10.0 + 3600.0)
    ahead = replace(
        ahead,
        help=HelpWanted(until_s=ahead.at_s + 60.0),
        task=Brief("T1", 1, Role.PRIMARY, "M1", due_s=ahead.at_s + 30.0),
        out_of_service=OutOfService("anna", since_s=ahead.at_s - 5.0, back_s=ahead.at_s + 600.0),
        lost_wlan=LostWlan(since_s=ahead.at_s - 9.0, access_point="AP2"),
        body_wait=BodyWait("it charges", since_s=ahead.at_s - 12.0),
    )
    righted = clocks.right(ahead, NOW_S + 10.05)
    assert isinstance(righted, AtvHeartbeat)
    assert righted.at_s == pytest.approx(NOW_S + 10.0, abs=0.2)
    assert righted.help is not None
    assert righted.help.until_s - righted.at_s == pytest.approx(60.0)
    assert righted.task is not None
    assert righted.task.due_s is not None
    assert righted.task.due_s - righted.at_s == pytest.approx(30.0)
    assert isinstance(righted.out_of_service, OutOfService)
    assert righted.at_s - righted.out_of_service.since_s == pytest.approx(5.0)
    assert righted.out_of_service.back_s == pytest.approx(righted.at_s + 600.0)
    assert isinstance(righted.lost_wlan, LostWlan)
    assert righted.at_s - righted.lost_wlan.since_s == pytest.approx(9.0)
    assert isinstance(righted.body_wait, BodyWait)
    assert righted.at_s - righted.body_wait.since_s == pytest.approx(12.0)


def test_a_machine_by_a_wrong_clock_is_out_of_service_since_when_it_was_told_so() -> None:
    clocks = heard({**FLEET, "ATV9": 3600.0})
    for second in range(HEARD_KEPT):
        at_s = NOW_S + second + 3600.0
        told = machine_beat(at_s)
        righted = clocks.right(told, NOW_S + second + 0.05)
    assert isinstance(righted, MachineHeartbeat)
    assert righted.at_s == pytest.approx(NOW_S + HEARD_KEPT - 1, abs=0.2)
    assert isinstance(righted.help, HelpWanted)
    assert righted.help.until_s - righted.at_s == pytest.approx(60.0)
    assert isinstance(righted.out_of_service, OutOfService)
    assert righted.at_s - righted.out_of_service.since_s == pytest.approx(5.0)


def test_facts_of_an_agent_with_a_wrong_clock_are_moved_as_a_whole() -> None:
    clocks = heard({**FLEET, "ATV9": -1.8e9})
    at_s = NOW_S + 10.0 - 1.8e9
    fact = GoalContracted("G1", "O1", 0, "p", 1, "M1", finish_s=at_s + 90.0)
    righted = clocks.right(Event("ATV9", 1, 1, at_s, fact), NOW_S + 10.05)
    assert isinstance(righted, Event)
    assert righted.at_s == pytest.approx(NOW_S + 10.0, abs=0.2)
    assert isinstance(righted.fact, GoalContracted)
    assert righted.fact.finish_s - righted.at_s == pytest.approx(90.0)


@pytest.mark.parametrize("at_s", [NOW_S + 1e9, 1e11, -1e11, NOW_S - OLDEST_S - 1.0])
def test_what_cannot_be_counts_as_now_also_of_agents_that_never_beat(at_s: float) -> None:
    righted = Clocks().right(Event("strategist", 1, 1, at_s, OrderFulfilled("O1")), NOW_S)
    assert isinstance(righted, Event)
    assert righted.at_s == pytest.approx(NOW_S)


def test_history_that_is_told_again_keeps_its_time() -> None:
    event = Event("ATV1", 1, 1, NOW_S - 86_400.0, OrderFulfilled("O1"))
    assert heard(FLEET).right(event, NOW_S + 8.0) == event
