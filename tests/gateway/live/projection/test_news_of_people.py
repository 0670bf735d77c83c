"""News that no fact tells: silence and its end, who was carried away, stopped, and what was closed."""

from __future__ import annotations

import pytest
from fake_bus import PLANT
from heartbeats import atv_heartbeat, machine_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import ClosureView, CommandView, LaneView, NewsView, RemovalView
from dray.store.factory.exclusions import Exclusion

LONG_S = 120.0


@pytest.fixture
def projection() -> Projection:
    """In real time; ATV1, ATV2 and M1 have been heard."""
    projection = Projection(PLANT, TimeScale(0.0, NOW_S))
    beat(projection, 0.0, "ATV1", "ATV2", "M1")
    look(projection, 0.0)
    return projection


def beat(projection: Projection, at_s: float, *agents: str) -> None:
    for agent in agents:
        if agent.startswith("M"):
            projection.fold(machine_heartbeat(agent, int(at_s) + 1, at_s=at_s))
        else:
            projection.fold(atv_heartbeat(agent, int(at_s) + 1, at_s=at_s))


def look(projection: Projection, at_s: float) -> list[NewsView]:
    projection.look(NOW_S + at_s)
    return list(projection.news.views())


def closure(name: str = "C1") -> ClosureView:
    lanes = (LaneView(start="N1", end="N2"),)
    return ClosureView(
        id=name, kind="closed", area="A1", reason="wet", by="Mara", at_s=NOW_S + 1.0, lanes=lanes
    )


def stop(name: str, atv: str, by: str = "Mara", at_s: float = 1.0) -> CommandView:
    return CommandView(id=name, atv=atv, kind="stop", by=by, at_s=NOW_S + at_s)


def test_nothing_has_happened_while_all_are_heard(projection: Projection) -> None:
    beat(projection, 1.0, "ATV1", "ATV2", "M1")
    assert look(projection, 1.0) == []


def test_two_minutes_of_silence_are_told_and_stay_told_when_they_end(projection: Projection) -> None:
    beat(projection, LONG_S - 1.0, "ATV2", "M1")
    [silent] = look(projection, LONG_S - 1.0)
    assert (silent.kind, silent.agent, silent.agents) == ("silent", "ATV1", ())
    beat(projection, LONG_S, "ATV1", "ATV2", "M1")
    [heard] = look(projection, LONG_S)
    assert (heard.kind, heard.agent, heard.silent_s) == ("heard_again", "ATV1", LONG_S)
    assert look(projection, LONG_S + 1.0) == [heard]


def test_those_who_fall_silent_at_one_moment_are_one_piece_of_news(projection: Projection) -> None:
    beat(projection, LONG_S, "M1")
    [silent] = look(projection, LONG_S)
    assert silent.agents == ("ATV1", "ATV2")


def test_whoever_is_shut_out_while_silent_is_not_said_to_be_heard_again(projection: Projection) -> None:
    beat(projection, LONG_S, "ATV2", "M1")
    look(projection, LONG_S)
    projection.shut_out([Exclusion(agent="ATV1", by="Mara", reason="odd", at_s=NOW_S)])
    assert [each.kind for each in look(projection, LONG_S + 1.0)] == ["silent"]


def test_who_carries_a_vehicle_away_and_that_it_is_back(projection: Projection) -> None:
    removal = RemovalView(number=1, by="Mara", at_s=NOW_S + 5.0, believed_at_s=NOW_S + 9.0)
    beat(projection, 5.0, "ATV2", "M1")
    projection.show_removals([("ATV1", removal)])
    [away] = look(projection, 5.0)
    assert (away.kind, away.agent, away.other, away.at_s) == ("carried_away", "ATV1", "Mara", NOW_S + 5.0)
    beat(projection, LONG_S, "ATV2", "M1")
    assert look(projection, LONG_S) == [away]
    beat(projection, LONG_S + 1.0, "ATV1", "ATV2", "M1")
    projection.show_removals([])
    _, back = look(projection, LONG_S + 1.0)
    assert (back.kind, back.agent) == ("put_back", "ATV1")


def test_a_closure_and_its_end_are_told_with_what_it_was(projection: Projection) -> None:
    projection.closures.put([(closure(), 1)])
    [closed] = look(projection, 1.0)
    assert (closed.kind, closed.other) == ("closed", "Mara")
    assert closed.closure is not None
    assert (closed.closure.area, closed.closure.reason, closed.closure.lanes) == ("A1", "wet", ())
    projection.closures.put([])
    _, opened = look(projection, 2.0)
    assert (opened.kind, opened.closure) == ("opened", closed.closure)


def test_who_has_stopped_whom_is_told_and_all_of_one_touch_are_one(projection: Projection) -> None:
    projection.commands.put(stop("1", "ATV1"), ())
    [first] = look(projection, 1.0)
    assert (first.kind, first.agent, first.other, first.agents) == ("stopped", "ATV1", "Mara", ())
    projection.commands.put(stop("2", "ATV2", at_s=1.2), ())
    [both] = look(projection, 1.5)
    assert both.agents == ("ATV1", "ATV2")
    projection.commands.put(stop("3", "ATV1", by="Jon", at_s=7.0), ())
    assert [each.other for each in look(projection, 7.0)] == ["Mara", "Jon"]
