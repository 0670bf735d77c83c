"""Alerts of several strategists: one that is silent is a warning, since others go on; all of them are an alarm, since orders wait."""

from __future__ import annotations

from alerts_kit import alerts, the_alert
from heartbeats import machine_heartbeat

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.agents.silence import LEAST_S
from dray.messages import StrategistHeartbeat
from dray.protocol.liveness.suspicion import GOAL_SILENCE_S

BEGAN_S = 1.0

LATER_S = BEGAN_S + max(GOAL_SILENCE_S, 10.0 * LEAST_S) + 1.0
"""At the kit's speed, ten times real time."""

PAIR = ("strategist", "strategist2")


def beat(projection: Projection, *strategists: str, at_s: float) -> None:
    for each in strategists:
        projection.fold(StrategistHeartbeat(each, 1, int(at_s), at_s, orders=0))


def plant_beats(projection: Projection, at_s: float) -> None:
    for number in range(1, 5):
        projection.fold(machine_heartbeat(f"M{number}", int(at_s), at_s=at_s))


def test_one_that_is_silent_for_as_long_as_the_others_wait_is_a_warning_that_names_it(
    projection: Projection,
) -> None:
    beat(projection, *PAIR, at_s=BEGAN_S)
    plant_beats(projection, LATER_S)
    beat(projection, "strategist", at_s=LATER_S)
    alert = the_alert(projection, LATER_S)
    assert (alert.kind, alert.level, alert.agents) == ("strategist_lost", "warning", ("strategist2",))
    assert (alert.id, alert.agent, alert.response) == ("strategist_lost", "", "look_at_strategist")
    beat(projection, "strategist2", at_s=LATER_S)
    assert alerts(projection, LATER_S) == []


def test_with_all_of_them_silent_there_is_one_alarm(projection: Projection) -> None:
    beat(projection, *PAIR, at_s=BEGAN_S)
    plant_beats(projection, LATER_S)
    alert = the_alert(projection, LATER_S)
    assert (alert.kind, alert.level, alert.agents) == ("no_strategist", "alarm", PAIR)


def test_an_older_heartbeat_and_one_of_somebody_else_tell_nothing(projection: Projection) -> None:
    beat(projection, *PAIR, at_s=LATER_S)
    beat(projection, *PAIR, at_s=BEGAN_S)
    beat(projection, "strategy", at_s=BEGAN_S)
    plant_beats(projection, LATER_S)
    assert alerts(projection, LATER_S) == []
