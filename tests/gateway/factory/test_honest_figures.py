"""One sender spoils no figure, whatever its clock shows and whatever it says; and people are told."""

from __future__ import annotations

import pytest
from fake_bus import PLANT
from gateway_kit import House
from heartbeats import atv_heartbeat, events, station_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.auctions.tasks import MAX_OPEN_EACH
from dray.gateway.live.timescale import TimeScale
from dray.messages import Event, Implausible, Transport
from dray.messages.fact import (
    BookRefused,
    HandoverDisputed,
    HelpAsked,
    NameMisused,
    TaskClosed,
    TaskOpened,
    WordDisbelieved,
)
from dray.messages.heartbeat import Role


class Watch:
    """A projection beside a wall clock."""

    def __init__(self) -> None:
        self.now_s = NOW_S
        self.projection = Projection(PLANT, TimeScale(0.0, NOW_S), wall_s=lambda: self.now_s)
        self._seq = 0

    def beat(self, **ahead_s: float) -> None:
        """A second passes; everybody beats, some by a clock that is ahead."""
        self.now_s += 1.0
        self._seq += 1
        for atv in ("ATV1", "ATV2", "ATV3", "ATV4"):
            at_s = self.now_s - NOW_S + ahead_s.get(atv, 0.0)
            self.projection.fold(atv_heartbeat(atv, self._seq, at_s=at_s))
        if "S3" in ahead_s:
            at_s = self.now_s - NOW_S + ahead_s["S3"]
            self.projection.fold(station_heartbeat("S3", self._seq, at_s=at_s))

    def alerts(self) -> dict[str, tuple[str, str]]:
        self.projection.look(self.now_s)
        return {
            alert.kind: (alert.agent, "" if alert.cause is None else alert.cause.text)
            for alert in self.projection.alerts.views()
        }


@pytest.mark.parametrize("ahead_s", [-1.8e9, 3600.0, 60.0])
def test_a_wrong_clock_is_an_alert_is_shown_and_leaves_the_fleets_figures_as_they_are(ahead_s: float) -> None:
    honest, mixed = Watch(), Watch()
    for _ in range(120):
        honest.beat()
        mixed.beat(ATV4=ahead_s)
    assert "clock_wrong" not in honest.alerts()
    assert mixed.alerts()["clock_wrong"][0] == "ATV4"
    view = mixed.projection.atvs.view("ATV4")
    assert view is not None
    assert view.clock is not None
    assert view.clock.ahead_s == pytest.approx(ahead_s, abs=1.0)
    assert view.seen_at_s == pytest.approx(mixed.now_s, abs=2.0)
    used, told = mixed.projection.factory(mixed.now_s).use, honest.projection.factory(honest.now_s).use
    assert used is not None
    assert told is not None
    assert used.idle == pytest.approx(told.idle, abs=0.02)


@pytest.mark.parametrize(("ahead_s", "wrong"), [(90.0, True), (-90.0, True), (0.3, False)])
def test_the_clock_of_a_station_is_measured_too_and_makes_nobody_silent(ahead_s: float, wrong: bool) -> None:
    watch = Watch()
    for _ in range(30):
        watch.beat(S3=ahead_s)
    view = watch.projection.stations.view("S3")
    assert view is not None
    assert view.clock is not None
    assert view.clock.ahead_s == pytest.approx(ahead_s, abs=0.1)
    assert view.clock.wrong is wrong
    assert view.seen_at_s == pytest.approx(watch.now_s, abs=2.0)
    assert watch.alerts().keys() == ({"clock_wrong"} if wrong else set())
    honest = watch.projection.atvs.view("ATV1")
    assert honest is not None
    assert honest.clock is not None
    assert not honest.clock.wrong


def test_nobody_is_silent_because_of_its_clock() -> None:
    watch = Watch()
    for _ in range(30):
        watch.beat(ATV4=-3600.0)
    assert "atv_lost" not in watch.alerts()


def test_a_transport_that_began_in_1970_is_in_no_quantile(projection: Projection) -> None:
    for event in events("M1", *auction_of("M1-1"), at_s=-1.8e9):
        projection.fold(event)
    for event in events("M1", TaskClosed("M1-1", 1, "delivered", "ATV2"), first=50, at_s=100.0):
        projection.fold(event)
    assert projection.tasks.transports.quantile_s(0.95) is None


def auction_of(task: str) -> list[TaskOpened]:
    work = Transport(item="shaft", quantity=4, sources=("S1",), destination="M1", ability="tote")
    return [TaskOpened(task, 1, Role.PRIMARY, 1, work, 10.0, 100.0, 1.0)]


def test_a_coordinator_that_opens_tasks_without_end_pushes_out_its_own(projection: Projection) -> None:
    for event in events("M2", *auction_of("M2-1")):
        projection.fold(event)
    for number in range(MAX_OPEN_EACH + 10):
        for event in events("M1", *auction_of(f"M1-{number}"), first=number + 1):
            projection.fold(event)
    names = [task.id for task in projection.tasks.under_way()]
    assert "M2-1" in names
    assert len(names) == MAX_OPEN_EACH + 1


def test_a_vehicle_that_calls_for_help_all_the_time_is_counted_as_often_as_it_can_need_it(
    projection: Projection,
) -> None:
    for number in range(100):
        projection.fold(Event("ATV1", 1, number + 1, number * 0.09, HelpAsked("T1", "stuck", 60.0)))
    assert projection.interventions.helps == 1


def test_what_coordinators_do_not_believe_is_an_alert_until_it_is_old() -> None:
    watch = Watch()
    disputed = HandoverDisputed("M1-1", 1, "ATV1", "shaft", 20, 0, "M1")
    doubted = WordDisbelieved("ATV2", "M1-2", Implausible.NEGATIVE)
    for number in range(2):
        for event in events("M1", disputed, doubted, first=2 * number + 1, at_s=0.0):
            watch.projection.fold(event)
    alerts = watch.alerts()
    assert alerts["handover_disputed"] == ("ATV1", "says 20 of shaft to M1, counted 0 (2 times)")
    assert alerts["word_disbelieved"][0] == "ATV2"
    watch.now_s += 1810.0
    assert not {"handover_disputed", "word_disbelieved"} & watch.alerts().keys()


def test_a_vehicle_in_whose_name_another_requests_places_is_an_alert() -> None:
    watch = Watch()
    for event in events("M1", NameMisused("ATV2"), first=1, at_s=0.0):
        watch.projection.fold(event)
    atv, words = watch.alerts()["word_disbelieved"]
    assert (atv, words) == ("ATV2", "requests places without this vehicle's signature")


def test_a_replica_whose_table_is_not_copied_is_an_alert() -> None:
    watch = Watch()
    for event in events("M1", BookRefused("M2"), first=1, at_s=0.0):
        watch.projection.fold(event)
    replica, words = watch.alerts()["word_disbelieved"]
    assert replica == "M2"
    assert "takes places from vehicles without their word, or has a higher number" in words


@pytest.mark.anyio
async def test_prometheus_is_told_of_wrong_clocks(house: House) -> None:
    for second in range(8):
        house.wall.now_s += 1.0
        for atv in ("ATV1", "ATV2", "ATV3"):
            ahead_s = 3600.0 if atv == "ATV3" else 0.0
            house.bus.say(atv_heartbeat(atv, second + 1, at_s=second + 1 + ahead_s))
    text = (await house.client.get("/metrics")).text
    assert "dray_agents_clock_wrong 1.0" in text
    assert 'dray_agents_clock_ahead_seconds{extreme="first"} 3600.0' in text
