"""A vehicle that needs somebody calls; one that is switched off cannot."""

from __future__ import annotations

import msgspec
import pytest
from check_kit import heartbeat

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
