"""A vehicle that needs somebody calls; one that is switched off cannot."""

from __future__ import annotations

import msgspec
import pytest
from check_kit import heartbeat

from dray.messages import (
    AtvHeartbeat,
    AtvStatus,
    CallState,
    CommandKind,
    Event,
    HelpCall,
    VehicleCommand,
)
from dray.messages.fact import CommandObeyed, MemoryLost
from dray.messages.fact.base import Fact
from dray.protocol.vehicle.people.command_handling import ALONE, DOUBLED
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.people.called import LOST_S, NoCallIsLost

BLOCKED = msgspec.structs.replace(heartbeat("ATV2"), problem="the way is blocked")


def test_a_vehicle_that_calls_nobody_is_noticed() -> None:
    check = NoCallIsLost()
    check.on_message(10.0, "ATV2", "*", BLOCKED)
    check.on_message(10.0 + LOST_S, "ATV2", "*", BLOCKED)
    with pytest.raises(InvariantBroken, match="ATV2 has had 'the way is blocked' for 61 s and calls nobody"):
        check.on_message(11.0 + LOST_S, "ATV2", "*", BLOCKED)


def test_the_time_in_which_it_is_switched_off_is_not_counted_and_the_time_before_is() -> None:
    check = NoCallIsLost()
    check.on_message(10.0, "ATV2", "*", BLOCKED)
    check.on_message(40.0, "ATV2", "*", BLOCKED)
    again = msgspec.structs.replace(BLOCKED, incarnation=2)
    check.on_message(500.0, "ATV2", "*", again)
    check.on_message(470.0 + LOST_S, "ATV2", "*", again)
    with pytest.raises(InvariantBroken, match="for 61 s"):
        check.on_message(471.0 + LOST_S, "ATV2", "*", again)


STANDS = msgspec.structs.replace(heartbeat("ATV2"), status=AtvStatus.STOPPED)
DRIVES = heartbeat("ATV2")
CALLS = HelpCall(
    call="ATV2-1-1",
    caller="ATV2",
    incarnation=1,
    number=1,
    at_s=0.0,
    since_s=0.0,
    state=CallState.RESTING,
    reason="its name is used by another",
)


def says(check: NoCallIsLost, at_s: float, fact: Fact) -> None:
    check.on_message(at_s, "ATV2", "*", Event(agent="ATV2", incarnation=1, number=1, at_s=at_s, fact=fact))


def obeys(check: NoCallIsLost, at_s: float, kind: CommandKind) -> None:
    says(check, at_s, CommandObeyed(command="C1", what=kind.value, done=True))


def stands(
    check: NoCallIsLost, from_s: float, beat: AtvHeartbeat = STANDS, until_s: float = 2.0 * LOST_S
) -> None:
    """It is heard once a second from then on."""
    for second in range(int(until_s)):
        check.on_message(from_s + second, "ATV2", "*", beat)


def test_one_that_has_stopped_itself_and_calls_nobody_is_noticed() -> None:
    with pytest.raises(InvariantBroken, match="ATV2 has had 'stopped itself' for 61 s and calls nobody"):
        stands(NoCallIsLost(), 10.0)


def test_one_that_has_stopped_itself_and_calls_on_is_not() -> None:
    check = NoCallIsLost()
    for second in range(0, 300, 5):
        stands(check, float(second), until_s=5.0)
        check.on_message(float(second), "ATV2", "*", CALLS)
    obeys(check, 300.0, CommandKind.ACKNOWLEDGE)
    stands(check, 301.0)


def test_one_that_a_person_has_stopped_need_not_call_until_it_drives_again() -> None:
    check = NoCallIsLost()
    check.on_message(1.0, "ATV2", "*", DRIVES)
    obeys(check, 2.0, CommandKind.STOP)
    stands(check, 3.0)
    stands(check, 200.0, msgspec.structs.replace(STANDS, incarnation=2))
    obeys(check, 400.0, CommandKind.ACKNOWLEDGE)
    obeys(check, 401.0, CommandKind.RESUME)
    check.on_message(402.0, "ATV2", "*", DRIVES)
    with pytest.raises(InvariantBroken, match="stopped itself"):
        stands(check, 500.0)


def test_a_stop_of_one_that_has_stopped_itself_is_no_acknowledgement() -> None:
    check = NoCallIsLost()
    stands(check, 10.0, until_s=10.0)
    obeys(check, 20.0, CommandKind.STOP)
    with pytest.raises(InvariantBroken, match="stopped itself"):
        stands(check, 21.0)


def test_its_next_life_has_to_call_too() -> None:
    check = NoCallIsLost()
    check.on_message(10.0, "ATV2", "*", STANDS)
    check.on_message(11.0, "ATV2", "*", CALLS)
    with pytest.raises(InvariantBroken, match="stopped itself"):
        stands(check, 12.0, msgspec.structs.replace(STANDS, incarnation=2))


def test_one_that_was_stopped_in_its_last_moment_may_not_have_told() -> None:
    check = NoCallIsLost()
    check.on_message(10.0, "ATV2", "*", DRIVES)
    stop = VehicleCommand(command="C1", kind=CommandKind.STOP, issued_by="shift lead")
    check.on_message(10.5, "gateway", ">ATV2", stop)
    stands(check, 100.0, msgspec.structs.replace(STANDS, incarnation=2))


def test_one_that_has_lost_its_memory_does_not_know_who_has_stopped_it() -> None:
    check = NoCallIsLost()
    says(check, 10.0, MemoryLost(reason="its journal was lost"))
    stands(check, 11.0)


def test_a_stop_that_people_knew_of_has_ended_with_the_life_whose_body_was_held() -> None:
    """The next life drives, though nobody has let it go on: its next stop is another one."""
    check = NoCallIsLost()
    check.on_message(1.0, "ATV2", "*", DRIVES)
    obeys(check, 2.0, CommandKind.STOP)
    stands(check, 3.0)
    later = msgspec.structs.replace(DRIVES, incarnation=2)
    check.on_message(200.0, "ATV2", "*", later)
    with pytest.raises(InvariantBroken, match="stopped itself"):
        stands(check, 201.0, msgspec.structs.replace(STANDS, incarnation=2))


def test_one_whose_stop_nobody_remembers_is_forgiven_that_stop_alone() -> None:
    check = NoCallIsLost()
    says(check, 10.0, MemoryLost(reason="its journal was lost"))
    stands(check, 11.0)
    check.on_message(200.0, "ATV2", "*", msgspec.structs.replace(DRIVES, incarnation=2))
    with pytest.raises(InvariantBroken, match="stopped itself"):
        stands(check, 201.0, msgspec.structs.replace(STANDS, incarnation=2))


@pytest.mark.parametrize("problem", [ALONE, DOUBLED])
def test_one_that_a_person_has_stopped_and_that_then_stops_itself_calls_also_when_the_problem_has_ended(
    problem: str,
) -> None:
    check = NoCallIsLost()
    check.on_message(1.0, "ATV2", "*", DRIVES)
    obeys(check, 2.0, CommandKind.STOP)
    stands(check, 3.0)
    stands(check, 200.0, msgspec.structs.replace(STANDS, problem=problem), until_s=10.0)
    with pytest.raises(InvariantBroken, match="stopped itself"):
        stands(check, 210.0)


def test_one_that_a_person_has_stopped_and_that_then_has_another_problem_need_not_call_after_it() -> None:
    check = NoCallIsLost()
    check.on_message(1.0, "ATV2", "*", DRIVES)
    obeys(check, 2.0, CommandKind.STOP)
    stands(check, 3.0, msgspec.structs.replace(STANDS, problem="the way is blocked"), until_s=10.0)
    stands(check, 13.0)
