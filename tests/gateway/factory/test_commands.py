"""What a person asks of a vehicle, and what becomes of it."""

from __future__ import annotations

import asyncio
from typing import Any

import httpx
import pytest
from answers import problem, vehicle
from gateway_kit import AUTHORITY, House, gateway
from heartbeats import atv_heartbeat
from wall_clock import NOW_S

from dray.adapters.security.signing import TrustedKeys
from dray.gateway.factory.commands import STOP_VALID_S
from dray.gateway.live.projection.recent_commands import RecentCommands
from dray.gateway.live.views import CommandView
from dray.messages import (
    CommandAnswered,
    CommandKind,
    CommandRefusal,
    VehicleCommand,
    signed_words,
)
from dray.messages.base import CLOCKS_AGREE_S

pytestmark = pytest.mark.anyio

STOP = {"kind": "stop"}


async def ask(house: House, body: Any, atv: str = "ATV1") -> httpx.Response:
    return await house.client.post(f"/api/atvs/{atv}/commands", json=body)


@pytest.mark.parametrize(
    "body",
    [
        STOP,
        {"kind": "acknowledge"},
        {"kind": "resume"},
        {"kind": "set_speed", "speed_frac": 0.5},
        {"kind": "promise", "wait_s": 120.0},
        {"kind": "hand_over"},
        {"kind": "charge"},
        {"kind": "take_out", "reason": "brakes", "wait_s": 3600.0, "after_work": True},
        {"kind": "put_in"},
    ],
    ids=lambda body: body["kind"],
)
async def test_a_command_is_answered_with_the_vehicles_word(house: House, body: dict[str, Any]) -> None:
    heard = vehicle(house)
    answer = await ask(house, body)
    assert answer.status_code == 200
    (command,) = heard
    assert answer.json() == {
        "command": command.command,
        "done": True,
        "reason": None,
        "detail": "",
        "text": "",
    }
    assert command.kind is CommandKind(body["kind"])
    assert (command.speed_frac, command.wait_s) == (body.get("speed_frac"), body.get("wait_s"))
    assert (command.reason, command.after_work) == (body.get("reason", ""), body.get("after_work", False))
    assert command.issued_by == "Administrator"


async def test_a_command_is_granted_to_whoever_gave_it(house: House) -> None:
    (command,) = await heard_of(house, STOP)
    grant = command.grant
    assert grant is not None
    assert (grant.person, grant.areas, grant.everywhere) == ("admin:admin", (), True)
    assert TrustedKeys(AUTHORITY.public)(signed_words("ATV1", command, grant), grant.signature)


async def test_a_grant_ends_soon_after_its_answer_was_waited_for_and_that_of_a_stop_later(url: str) -> None:
    async with gateway(url, speed=20.0, command_timeout_s=2.0) as house:
        house.wall.now_s += 5.0
        until_s = []
        for body in ({"kind": "resume"}, STOP):
            (command,) = await heard_of(house, body)
            assert command.grant is not None
            until_s.append(command.grant.valid_until_s)
        assert until_s == [5.0 * 20 + (2.0 + CLOCKS_AGREE_S) * 20, 5.0 * 20 + STOP_VALID_S * 20]


@pytest.mark.parametrize("ahead_s", [3600.0, -3600.0])
async def test_whose_clock_is_an_hour_off_is_told_until_when_by_that_clock(
    house: House, ahead_s: float
) -> None:
    """Else nothing would stop the one, and the other would obey an old word an hour later."""
    house.wall.now_s += 7200.0
    house.bus.say(atv_heartbeat("ATV1", at_s=7200.0 + ahead_s))
    (command,) = await heard_of(house, STOP)
    assert command.grant is not None
    assert command.grant.valid_until_s == 7200.0 + ahead_s + STOP_VALID_S


async def heard_of(house: House, body: dict[str, Any]) -> list[VehicleCommand]:
    """What a vehicle hears of one request."""
    heard = vehicle(house)
    assert (await ask(house, body)).status_code == 200
    return heard


async def test_a_refused_command_is_answered_with_the_vehicles_reason(house: House) -> None:
    vehicle(house, refusal=CommandRefusal.NOT_ACKNOWLEDGED)
    answer = await ask(house, {"kind": "resume"})
    assert answer.status_code == 200
    assert answer.json()["done"] is False
    assert answer.json()["reason"] == "not_acknowledged"
    assert answer.json()["text"] == "acknowledge the stop first"


async def test_a_command_that_is_not_answered_is_not_confirmed_and_not_sent_again(url: str) -> None:
    async with gateway(url, command_timeout_s=0.01) as house:
        told = problem(await ask(house, STOP), 504, "not-confirmed")
        assert "ATV1 has not answered within 0.01 s" in told["detail"]
        assert "look at it" in told["detail"]
        (command,) = house.bus.sent_to("ATV1", VehicleCommand)
        assert states(house) == ["not_confirmed"]
        # The answer comes too late for who has asked; panels still show it.
        house.bus.tell("ATV1", "gateway", CommandAnswered(command=command.command, done=True))
        assert states(house) == ["confirmed"]
        assert len(house.bus.sent_to("ATV1", VehicleCommand)) == 1


def states(house: House) -> list[str]:
    """What panels show of the commands."""
    return [command.state for command in house.projection.commands.views()]


async def test_panels_see_a_command_as_soon_as_it_is_sent_and_then_what_became_of_it(house: House) -> None:
    house.bus.say(atv_heartbeat())
    body = {"kind": "set_speed", "speed_frac": 0.5, "command": "4711"}
    asked = asyncio.create_task(ask(house, body))
    await house.bus.next_to("ATV1", VehicleCommand)
    (shown,) = house.projection.commands.views()
    assert (shown.id, shown.atv, shown.kind, shown.speed_frac) == ("4711", "ATV1", "set_speed", 0.5)
    assert (shown.by, shown.at_s, shown.state, shown.reason) == ("Administrator", NOW_S, "sent", "")
    house.bus.tell("ATV1", "gateway", CommandAnswered("4711", False, CommandRefusal.FAULTY, "wheel"))
    assert (await asked).json() == {
        "command": "4711",
        "done": False,
        "reason": "faulty",
        "detail": "wheel",
        "text": "its sensors still report a problem: wheel",
    }
    (shown,) = house.projection.commands.views()
    assert (shown.state, shown.reason, shown.detail) == ("refused", "faulty", "wheel")


async def test_a_command_that_is_sent_again_by_its_name_is_given_once(house: House) -> None:
    heard = vehicle(house)
    answers = [(await ask(house, STOP | {"command": "c-1"})).json() for _ in range(2)]
    assert answers[0] == answers[1]
    assert len(heard) == 1
    assert states(house) == ["confirmed"]


@pytest.mark.parametrize(
    ("body", "atv"), [({"kind": "resume", "command": "c-1"}, "ATV1"), (STOP | {"command": "c-1"}, "ATV2")]
)
async def test_a_name_stands_for_one_command(house: House, body: dict[str, Any], atv: str) -> None:
    heard = vehicle(house)
    assert (await ask(house, STOP | {"command": "c-1"})).status_code == 200
    told = problem(await ask(house, body, atv), 409, "command-name-used")
    assert "choose a name that is used once" in told["detail"]
    assert len(heard) == 1


@pytest.mark.parametrize("name", ["", "a/b", "a b", "a" * 65])
async def test_a_name_that_could_not_be_said_is_refused(house: House, name: str) -> None:
    problem(await ask(house, STOP | {"command": name}), 422, "unusable-fields")
    assert house.bus.sent == []


async def test_a_name_like_one_of_ours_takes_no_command_away(house: House) -> None:
    heard = vehicle(house)
    await ask(house, STOP)
    start, _, number = heard[0].command.rpartition("-")
    await ask(house, STOP | {"command": f"{start}-{int(number) + 1}"})
    for _ in range(2):
        assert (await ask(house, STOP)).status_code == 200
    assert len({command.command for command in heard}) == 4


def test_panels_show_the_last_commands_only(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.gateway.live.projection.recent_commands.RECENT_KEPT", 2)
    given = RecentCommands()
    for name in ("c-1", "c-2", "c-3"):
        given.put(CommandView(id=name, atv="ATV3", kind="stop", by="Management", at_s=NOW_S), ())
    assert [command.id for command in given.views()] == ["c-2", "c-3"]
    assert list(given.changes.take_gone()) == ["command:c-1"]


async def test_only_the_vehicle_itself_can_answer_and_only_once(house: House) -> None:
    asked = asyncio.create_task(ask(house, STOP))
    command = (await house.bus.next_to("ATV1", VehicleCommand)).command
    house.bus.tell("ATV2", "gateway", CommandAnswered(command=command, done=True))
    house.bus.tell("ATV1", "gateway", CommandAnswered(command="gateway.1-99", done=True))
    house.bus.tell("ATV1", "gateway", CommandAnswered(command=command, done=False, detail="mine"))
    house.bus.tell("ATV1", "gateway", CommandAnswered(command=command, done=True, detail="doubled"))
    assert (await asked).json()["detail"] == "mine"
    assert house.peer.ignored == 3


async def test_commands_at_the_same_time_get_their_own_answers(house: House) -> None:
    asked = [asyncio.create_task(ask(house, STOP, atv)) for atv in ("ATV1", "ATV2", "ATV1")]
    first = await house.bus.next_to("ATV1", VehicleCommand)
    third = await house.bus.next_to("ATV1", VehicleCommand, after=1)
    second = await house.bus.next_to("ATV2", VehicleCommand)
    for atv, command in (("ATV1", third), ("ATV2", second), ("ATV1", first)):
        house.bus.tell(atv, "gateway", CommandAnswered(command.command, done=True, detail=command.command))
    answers = [(await one).json() for one in asked]
    assert all(answer["detail"] == answer["command"] for answer in answers)
    assert len({answer["command"] for answer in answers}) == 3


async def test_commands_of_two_lives_have_different_names(url: str) -> None:
    names = set()
    for incarnation in (1, 2):
        async with gateway(url, incarnation=incarnation) as house:
            vehicle(house)
            names.add((await ask(house, STOP)).json()["command"])
    assert len(names) == 2


async def test_an_unknown_vehicle_is_not_found_and_nothing_sent(house: House) -> None:
    told = problem(await ask(house, STOP, "ATV99"), 404, "unknown-atv")
    assert "ATV99" in told["detail"]
    assert house.bus.sent == []


async def test_a_vehicle_that_only_was_heard_can_be_stopped(house: House) -> None:
    house.bus.say(atv_heartbeat("ATV99"))
    vehicle(house, "ATV99")
    assert (await ask(house, STOP, "ATV99")).json()["done"] is True


async def test_too_many_waiting_commands_are_refused(house: House, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("dray.gateway.factory.awaited.PENDING", 1)
    asked = asyncio.create_task(ask(house, STOP))
    command = (await house.bus.next_to("ATV1", VehicleCommand)).command
    answer = await ask(house, STOP, "ATV2")
    problem(answer, 503, "too-many-commands")
    assert int(answer.headers["retry-after"]) > 0
    house.bus.tell("ATV1", "gateway", CommandAnswered(command, done=True))
    assert (await asked).status_code == 200


@pytest.mark.parametrize(
    ("body", "field"),
    [
        ({"kind": "set_speed"}, "body"),
        ({"kind": "set_speed", "speed_frac": None}, "body"),
        ({"kind": "stop", "speed_frac": 0.5}, "body"),
        ({"kind": "set_speed", "speed_frac": 0}, "speed_frac"),
        ({"kind": "set_speed", "speed_frac": -0.5}, "speed_frac"),
        ({"kind": "set_speed", "speed_frac": 1.01}, "speed_frac"),
        ({"kind": "set_speed", "speed_frac": "0.5"}, "speed_frac"),
        ({"kind": "set_speed", "speed_frac": True}, "speed_frac"),
        ({"kind": "promise"}, "body"),
        ({"kind": "stop", "wait_s": 60.0}, "body"),
        ({"kind": "promise", "wait_s": 0}, "wait_s"),
        ({"kind": "promise", "wait_s": 900.5}, "wait_s"),
        ({"kind": "fly"}, "kind"),
        ({"kind": None}, "kind"),
        ({}, "kind"),
        ({"kind": "stop", "why": "because"}, "why"),
        ([], "body"),
    ],
    ids=repr,
)
async def test_a_command_that_means_nothing_is_refused_and_not_sent(
    house: House, body: Any, field: str
) -> None:
    told = problem(await ask(house, body), 422, "unusable-fields")
    assert told["errors"][0]["field"] == field
    assert house.bus.sent == []


async def test_a_speed_that_json_does_not_know_is_refused(house: House) -> None:
    for number in ("NaN", "Infinity", "1e999"):
        answer = await house.client.post(
            "/api/atvs/ATV1/commands",
            content=f'{{"kind": "set_speed", "speed_frac": {number}}}',
            headers={"Content-Type": "application/json"},
        )
        assert problem(answer, 422, "unusable-fields")["errors"][0]["field"] == "speed_frac"


async def test_a_command_is_called_json_and_comes_from_our_own_page(house: House) -> None:
    path = "/api/atvs/ATV1/commands"
    problem(await house.client.post(path, content='{"kind": "stop"}'), 415, "not-called-json")
    answer = await house.client.post(path, json=STOP, headers={"Origin": "http://evil.test"})
    problem(answer, 403, "other-origin")
    assert house.bus.sent == []
