"""Waits: who cannot drive on, since when and why, as the stream, REST and alerts tell it."""

from __future__ import annotations

from typing import Any

import pytest
from fake_bus import PLANT
from gateway_kit import House
from heartbeats import atv_heartbeat
from wall_clock import NOW_S

from dray.gateway.live.projection import Projection
from dray.gateway.live.projection.alerting.wait_rules import CIRCLE_S, LONG_WAIT_S, UNHEARD_S
from dray.gateway.live.timescale import TimeScale
from dray.gateway.live.views import WaitView
from dray.messages import AtvHeartbeat, AtvStatus, Brief, Phase, Pose, Role
from dray.messages.heartbeat import FloorBrief
from dray.plant import load_plant
from dray.store.factory.exclusions import Exclusion

FLOOR = load_plant("single-track")
M8 = FLOOR.node_of("M8")

CARRYING = Brief(task="T1", epoch=1, role=Role.PRIMARY, coordinator="M1", phase=Phase.CARRYING)


@pytest.fixture
def projection() -> Projection:
    """In real time."""
    return Projection(PLANT, TimeScale(0.0, NOW_S))


def waiting(atv: str, behind: str = "", *, at_s: float = 1.0, **fields: Any) -> AtvHeartbeat:
    floor = FloorBrief(holds=("c1",), waits=True, waits_for=behind, waits_at="c2" if behind else "")
    usual: dict[str, Any] = {
        "floor": floor,
        "status": AtvStatus.WORKING,
        "task": CARRYING,
        "way": ("c2",),
        "node": "c1",
    }
    return atv_heartbeat(atv, int(at_s * 10), at_s=at_s, **usual | fields)


def docked(atv: str, node: str = M8, *, at_s: float = 1.0) -> AtvHeartbeat:
    floor = FloorBrief(holds=(node,), docked=True)
    return atv_heartbeat(
        atv, int(at_s * 10), at_s=at_s, floor=floor, node=node, status=AtvStatus.WORKING, task=CARRYING
    )


def driving(atv: str, *, at_s: float = 1.0, node: str = "d1") -> AtvHeartbeat:
    floor = FloorBrief(holds=(node, "e1"), stands=False)
    return atv_heartbeat(
        atv, int(at_s * 10), at_s=at_s, floor=floor, node=node, speed_mps=1.2, status=AtvStatus.WORKING
    )


def fold(projection: Projection, *heartbeats: AtvHeartbeat) -> None:
    for heartbeat in heartbeats:
        projection.fold(heartbeat)


def told(projection: Projection, at_s: float = 1.0) -> dict[str, WaitView]:
    projection.look(NOW_S + at_s)
    return {view.id: view for view in projection.waits.views()}


def text_of(projection: Projection, atv: str) -> str:
    return told(projection)[atv].text


# --- who waits for whom -----------------------------------------------------------------------------


def test_without_right_of_way_nobody_waits_and_nothing_is_held(projection: Projection) -> None:
    fold(projection, atv_heartbeat("ATV1", way=("c2",)), atv_heartbeat("ATV2"))
    assert told(projection) == {}
    assert projection.atvs.views()[0].holds == ()


def test_what_is_held_is_shown_with_the_vehicle(projection: Projection) -> None:
    fold(projection, driving("ATV1"))
    assert projection.atvs.views()[0].holds == ("d1", "e1")


def test_a_wait_is_a_sentence_down_to_the_dock(projection: Projection) -> None:
    fold(projection, waiting("ATV5", "ATV3"), waiting("ATV3", "ATV7"), docked("ATV7"))
    view = told(projection)["ATV5"]
    assert view.text == "waits for ATV3, which waits for ATV7 at the dock of M8"
    assert (view.place, view.cause.kind, view.cause.chain, view.cause.place) == (
        "c2",
        "docked",
        ("ATV3", "ATV7"),
        "M8",
    )
    assert view.cause.since_at_s == view.since_at_s == NOW_S + 1.0


@pytest.mark.parametrize(
    ("other", "words"),
    [
        (driving("ATV2"), "waits for ATV2, which is driving"),
        (atv_heartbeat("ATV2", floor=FloorBrief(holds=("c2",))), "waits for ATV2, which stands there"),
        (
            atv_heartbeat("ATV2", floor=FloorBrief(holds=("c2",)), node=FLOOR.node_of("P1")),
            "waits for ATV2, which stands at P1",
        ),
        (
            atv_heartbeat("ATV2", floor=FloorBrief(), node=FLOOR.node_of("CH1"), status=AtvStatus.CHARGING),
            "waits for ATV2, which is charging at CH1",
        ),
        (waiting("ATV2", status=AtvStatus.STOPPED), "waits for ATV2, which was stopped"),
        (waiting("ATV2", status=AtvStatus.ERROR, problem="wheel"), "waits for ATV2, which is in error"),
        (atv_heartbeat("ATV2", speed_mps=1.0), "waits for ATV2, which is driving"),
        (atv_heartbeat("ATV2", status=AtvStatus.ERROR), "waits for ATV2, which is in error"),
        (waiting("ATV2", "ATV2"), "waits for ATV2, which makes room or has no answer yet"),
        (waiting("ATV2"), "waits for ATV2, which makes room or has no answer yet"),
        (waiting("ATV2", "ATV1"), "waits for ATV2, in a circle"),
        (docked("ATV2", "nowhere"), "waits for ATV2 at a dock"),
        (waiting("ATV2", at_s=-60.0), "waits for ATV2, which is not heard"),
        (
            atv_heartbeat("ATV2", floor=FloorBrief(holds=("c2",)), task=CARRYING, status=AtvStatus.WORKING),
            "waits for ATV2, which has no way left by what is closed",
        ),
    ],
)
def test_what_holds_up_the_last_one_is_named(projection: Projection, other: AtvHeartbeat, words: str) -> None:
    fold(projection, waiting("ATV1", "ATV2"), other)
    assert text_of(projection, "ATV1") == words


def test_a_load_that_no_way_is_left_for_waits_though_nobody_is_ahead(projection: Projection) -> None:
    for seq in (1, 2):
        fold(projection, atv_heartbeat("ATV2", seq, floor=FloorBrief(holds=("c2",)), task=CARRYING))
    assert text_of(projection, "ATV2") == "has no way left by what is closed"


def test_who_is_shut_out_waits_no_more_and_is_not_heard(projection: Projection) -> None:
    fold(projection, waiting("ATV1", "ATV2"), waiting("ATV2", "ATV3"), driving("ATV3"))
    projection.shut_out([Exclusion(agent="ATV2", reason="lies", by="Ada", at_s=NOW_S)])
    assert {atv: view.text for atv, view in told(projection).items()} == {
        "ATV1": "waits for ATV2, which is not heard"
    }


def test_who_has_just_set_off_and_has_no_answer_yet_is_not_said_to_wait(projection: Projection) -> None:
    fold(projection, waiting("ATV1"))
    assert told(projection) == {}
    fold(projection, waiting("ATV1", at_s=2.0))
    assert text_of(projection, "ATV1") == "makes room or has no answer yet"


def test_of_a_long_chain_the_first_ones_and_the_last_are_named(projection: Projection) -> None:
    fold(projection, *(waiting(f"V{number}", f"V{number + 1}") for number in range(20)), docked("V20"))
    cause = told(projection)["V0"].cause
    assert (len(cause.chain), cause.chain[0], cause.chain[-1], cause.more) == (8, "V1", "V20", 12)
    assert text_of(projection, "V0").endswith(
        "V7, which waits for 12 more, which waits for V20 at the dock of M8"
    )


def test_a_vehicle_that_tells_less_by_radio_holds_and_waits_as_long_as_it_stands(
    projection: Projection,
) -> None:
    fold(projection, waiting("ATV1", "ATV2"), driving("ATV2"))
    by_radio = atv_heartbeat("ATV1", 20, at_s=2.0, node="c1", way=("c2",), status=AtvStatus.WORKING)
    fold(projection, by_radio)
    assert told(projection, 2.0)["ATV1"].since_at_s == NOW_S + 1.0
    fold(projection, atv_heartbeat("ATV1", 30, at_s=3.0, node="c2", pose=Pose(9.0, 2.0, 0.0)))
    assert told(projection, 3.0) == {}
    assert projection.atvs.views()[0].holds == ()


# --- since when -------------------------------------------------------------------------------------


def test_a_wait_counts_from_when_it_came_to_a_stand_and_is_over_when_it_moves(projection: Projection) -> None:
    fold(projection, driving("ATV2"))
    for at_s in (1.0, 2.0, 3.0):
        fold(projection, waiting("ATV1", "ATV2", at_s=at_s))
    assert told(projection, 3.0)["ATV1"].since_at_s == NOW_S + 1.0
    fold(projection, driving("ATV1", at_s=4.0))
    assert told(projection, 4.0) == {}
    fold(projection, waiting("ATV1", "ATV2", at_s=5.0))
    assert told(projection, 5.0)["ATV1"].since_at_s == NOW_S + 5.0


def test_a_wait_is_told_once_and_when_it_changes_and_when_it_is_over(projection: Projection) -> None:
    fold(projection, waiting("ATV1", "ATV2"), driving("ATV2"))
    first = projection.delta(1, NOW_S + 1.0, None)
    assert [view.id for view in first.waits] == ["ATV1"]
    fold(projection, waiting("ATV1", "ATV2", at_s=2.0))
    assert projection.delta(2, NOW_S + 2.0, None).waits == ()
    fold(projection, docked("ATV2", at_s=3.0))
    (again,) = projection.delta(3, NOW_S + 3.0, None).waits
    assert again.cause.kind == "docked"
    fold(projection, driving("ATV1", at_s=4.0))
    over = projection.delta(4, NOW_S + 4.0, None)
    assert (over.waits, over.gone) == ((), ("wait:ATV1",))


def test_silence_changes_a_chain_without_anybody_saying_so(projection: Projection) -> None:
    fold(projection, docked("ATV2"), *(waiting("ATV1", "ATV2", at_s=at_s) for at_s in (1.0, 60.0)))
    fold(projection, *(driving(f"ATV{number}", at_s=60.0) for number in (5, 6, 7, 8)))
    assert told(projection, 60.0)["ATV1"].cause.kind == "silent"


# --- alerts -----------------------------------------------------------------------------------------


def beat(projection: Projection, until_s: float, *of: tuple[str, str]) -> None:
    """Vehicles that wait, each for another one, and one at the dock of M8."""
    for at_s in (1.0, until_s):
        fold(projection, docked("ATV9", at_s=at_s), *(waiting(*each, at_s=at_s) for each in of))


def now(projection: Projection, at_s: float) -> list[Any]:
    projection.look(NOW_S + at_s)
    return list(projection.alerts.views())


def test_a_long_wait_is_an_alert_that_names_its_cause_once(projection: Projection) -> None:
    beat(projection, LONG_WAIT_S, ("ATV1", "ATV9"))
    assert now(projection, LONG_WAIT_S) == []
    beat(projection, LONG_WAIT_S + 2, ("ATV1", "ATV9"))
    (alert,) = now(projection, LONG_WAIT_S + 2)
    assert (alert.kind, alert.agent, alert.cause.text) == (
        "atv_waits",
        "ATV1",
        "waits for ATV9 at the dock of M8",
    )
    projection.delta(1, NOW_S, None)
    for more_s in (3, 4, 5):
        beat(projection, LONG_WAIT_S + more_s, ("ATV1", "ATV9"))
        assert now(projection, LONG_WAIT_S + more_s)[0].since_at_s == alert.since_at_s
        assert projection.delta(2, NOW_S, None).alerts == ()
    fold(projection, driving("ATV1", at_s=LONG_WAIT_S + 6))
    assert now(projection, LONG_WAIT_S + 6) == []


def test_three_behind_one_dock_are_one_alert_that_names_all(projection: Projection) -> None:
    of = (("ATV1", "ATV2"), ("ATV2", "ATV9"), ("ATV3", "ATV9"))
    beat(projection, LONG_WAIT_S + 2, *of)
    (jam,) = now(projection, LONG_WAIT_S + 2)
    assert (jam.id, jam.kind, jam.level, jam.place, jam.agent) == ("jam-M8", "jam", "alarm", "M8", "ATV9")
    assert jam.agents == ("ATV1", "ATV2", "ATV3")
    assert jam.cause.text == "ATV1, ATV2, ATV3 wait for ATV9 at the dock of M8"


def test_whoever_was_never_heard_and_holds_what_others_need_is_an_alarm_by_name(
    projection: Projection,
) -> None:
    of = (("ATV1", "GHOST"), ("ATV2", "ATV1"))
    beat(projection, UNHEARD_S - 1, *of)
    assert now(projection, UNHEARD_S - 1) == []
    beat(projection, UNHEARD_S + 2, *of)
    (alert,) = now(projection, UNHEARD_S + 2)
    assert (alert.kind, alert.level, alert.agent) == ("atv_unheard", "alarm", "GHOST")
    assert (alert.response, alert.agents) == ("shut_out_and_clear", ("ATV1", "ATV2"))
    assert projection.waits.names("GHOST")
    fold(projection, driving("GHOST", at_s=UNHEARD_S + 3))
    assert now(projection, UNHEARD_S + 3) == []
    assert not projection.waits.names("GHOST")


def test_a_name_for_which_nobody_waits_any_more_is_none_that_is_known(projection: Projection) -> None:
    beat(projection, UNHEARD_S + 2, ("ATV1", "GHOST"))
    assert projection.waits.names("GHOST")
    fold(projection, driving("ATV1", at_s=UNHEARD_S + 3))
    assert now(projection, UNHEARD_S + 3) == []
    assert not projection.waits.names("GHOST")


def test_a_jam_stays_the_same_when_another_one_comes_to_the_dock(projection: Projection) -> None:
    of = [("ATV1", "ATV9"), ("ATV2", "ATV9"), ("ATV3", "ATV9")]
    beat(projection, LONG_WAIT_S + 2, *of)
    (jam,) = now(projection, LONG_WAIT_S + 2)
    fold(projection, driving("ATV9", at_s=130.0), docked("ATV8", at_s=130.0))
    fold(projection, *(waiting(atv, "ATV8", at_s=130.0) for atv, _ in of))
    (again,) = now(projection, 130.0)
    assert (again.id, again.since_at_s, again.agent) == (jam.id, jam.since_at_s, "ATV8")


def test_a_circle_is_a_jam_sooner_and_names_who_waits_for_whom(projection: Projection) -> None:
    of = (("ATV1", "ATV2"), ("ATV2", "ATV3"), ("ATV3", "ATV1"), ("ATV4", "ATV1"))
    beat(projection, CIRCLE_S, *of)
    assert now(projection, CIRCLE_S) == []
    beat(projection, CIRCLE_S + 2, *of)
    (jam,) = now(projection, CIRCLE_S + 2)
    assert jam.cause.text == "ATV1, ATV2, ATV3, ATV4 wait in a circle: ATV1, for ATV2, for ATV3, for ATV1"
    assert jam.cause.wait.chain == ("ATV1", "ATV2", "ATV3")


def test_of_a_vehicle_in_worse_trouble_its_wait_is_not_told(projection: Projection) -> None:
    state = {"battery_frac": 0.02}
    for at_s in (1.0, 125.0):
        fold(projection, docked("ATV9", at_s=at_s), waiting("ATV1", "ATV9", at_s=at_s, **state))
    assert [alert.kind for alert in now(projection, 125.0)] == ["atv_battery"]


def test_idle_vehicles_that_look_for_room_ask_nothing_of_people(projection: Projection) -> None:
    idle: dict[str, Any] = {"task": None, "status": AtvStatus.IDLE}
    names = ("ATV1", "ATV2", "ATV3", "ATV4")
    for at_s in (1.0, 125.0):
        fold(projection, docked("ATV9", at_s=at_s))
        fold(projection, *(waiting(atv, "ATV9", at_s=at_s, **idle) for atv in names))
    assert now(projection, 125.0) == []
    fold(projection, waiting("ATV5", "ATV4", at_s=125.0))
    (jam,) = now(projection, 125.0)
    assert jam.agents == (*names, "ATV5")


# --- REST -------------------------------------------------------------------------------------------


@pytest.mark.anyio
async def test_waits_are_told_over_rest(house: House) -> None:
    assert await house.get("/api/waits") == {"items": [], "next_cursor": None}
    house.bus.say(waiting("ATV5", "ATV7"), docked("ATV7"))
    house.projection.look(NOW_S + 1.0)
    (wait,) = (await house.get("/api/waits"))["items"]
    assert (wait["id"], wait["text"]) == ("ATV5", "waits for ATV7 at the dock of M8")
    assert (await house.get("/api/atvs/ATV5"))["holds"] == ["c1"]
