"""What a person asks of a machine, and what becomes of it."""

from __future__ import annotations

from typing import Any

import httpx
import pytest
from gateway_kit import AUTHORITY, House
from heartbeats import machine_heartbeat
from obedient_places import obedient

from dray.adapters.security.signing import TrustedKeys
from dray.messages import (
    CommandAnswered,
    CommandRefusal,
    HelpWanted,
    MachineCommand,
    MachineCommandKind,
    MachineStatus,
    Message,
    OutOfService,
    PeopleAsBody,
    Problem,
    ProblemKind,
    UnconfirmedLoad,
    signed_words,
)

pytestmark = pytest.mark.anyio


def m1(house: House, *, refusal: CommandRefusal | None = None, detail: str = "") -> list[MachineCommand]:
    """M1 joins and obeys every command, or refuses it; the commands that it will have heard."""
    house.projection.fold(machine_heartbeat("M1"))
    return obedient(house, "M1", refusal=refusal, detail=detail)


WORD_FIELDS = ("item", "quantity", "vehicle", "sure")


async def ask(house: House, body: Any, machine: str = "M1") -> httpx.Response:
    return await house.client.post(f"/api/machines/{machine}/commands", json=body)


@pytest.mark.parametrize(
    "body",
    [
        {"kind": "promise", "wait_s": 120.0},
        {"kind": "clear_fault"},
        {"kind": "hand_over"},
        {"kind": "set_speed", "speed_frac": 0.5},
        {"kind": "restart"},
        {"kind": "update"},
        {"kind": "take_out", "reason": "bearings", "wait_s": 3600.0, "after_work": True},
        {"kind": "put_in"},
        {"kind": "fetch_goods", "task": "M1-1", "node": "c2"},
        {"kind": "write_off", "task": "M1-1"},
        {"kind": "load_there", "task": "M1-1"},
        {"kind": "load_missing", "task": "M1-1"},
        {"kind": "arrived", "item": "shaft", "quantity": 12, "vehicle": "ATV3"},
        {"kind": "taken", "item": "shaft", "quantity": 1, "sure": True},
        {"kind": "made", "quantity": 2},
        {"kind": "scrapped", "quantity": 1, "item": "pump"},
        {"kind": "stock_is", "item": "shaft", "quantity": 0},
    ],
    ids=lambda body: body["kind"],
)
async def test_a_command_is_granted_and_answered_with_the_machines_word(
    house: House, body: dict[str, Any]
) -> None:
    heard = m1(house)
    answer = await ask(house, body)
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    (command,) = heard
    assert command.kind is MachineCommandKind(body["kind"])
    assert (command.speed_frac, command.wait_s) == (body.get("speed_frac"), body.get("wait_s"))
    assert (command.task, command.node) == (body.get("task", ""), body.get("node", ""))
    assert (command.reason, command.after_work) == (body.get("reason", ""), body.get("after_work", False))
    said = (command.item, command.quantity, command.vehicle, command.sure)
    assert said == tuple(
        body.get(field, none) for field, none in zip(WORD_FIELDS, ("", 0, "", False), strict=True)
    )
    grant = command.grant
    assert grant is not None
    assert TrustedKeys(AUTHORITY.public)(signed_words("M1", command, grant), grant.signature)


async def test_a_refusal_is_told_with_its_reason(house: House) -> None:
    m1(house, refusal=CommandRefusal.FAULTY, detail="it is stuck")
    answer = (await ask(house, {"kind": "clear_fault"})).json()
    assert (answer["done"], answer["reason"]) == (False, "faulty")
    assert answer["text"] == "its sensors still report a problem: it is stuck"


@pytest.mark.parametrize(
    "body",
    [
        {"kind": "stop"},
        {"kind": "set_speed"},
        {"kind": "promise"},
        {"kind": "promise", "wait_s": 901.0},
        {"kind": "hand_over", "wait_s": 60.0},
        {"kind": "clear_fault", "reason": "done"},
        {"kind": "put_in", "after_work": True},
        {"kind": "fetch_goods", "node": "c2"},
        {"kind": "write_off"},
        {"kind": "load_missing"},
        {"kind": "write_off", "task": "M1-1", "node": "c2"},
        {"kind": "put_in", "task": "M1-1"},
        {"kind": "made"},
        {"kind": "made", "quantity": -1},
        {"kind": "made", "quantity": 1.5},
        {"kind": "made", "quantity": 10**7},
        {"kind": "made", "quantity": 1, "vehicle": "ATV3"},
        {"kind": "arrived", "quantity": 12},
        {"kind": "arrived", "quantity": 12, "item": "a/b"},
        {"kind": "stock_is", "quantity": 12, "item": "shaft", "vehicle": "ATV3"},
        {"kind": "put_in", "quantity": 1},
        {"kind": "put_in", "item": "shaft"},
        {"kind": "put_in", "sure": True},
    ],
)
async def test_what_no_machine_can_do_is_not_sent(house: House, body: dict[str, Any]) -> None:
    heard = m1(house)
    assert (await ask(house, body)).status_code == 422
    assert heard == []


async def test_of_a_machine_that_is_not_there_nothing_is_asked(house: House) -> None:
    assert (await ask(house, {"kind": "restart"}, "M99")).status_code == 404


async def test_its_page_tells_what_it_asks_for_and_what_it_was_told(house: House) -> None:
    beat = machine_heartbeat(
        "M1",
        2,
        status=MachineStatus.ERROR,
        problem="it is stuck",
        about_problem=Problem(kind=ProblemKind.JAM, needs_person=True),
        resettable=True,
        help=HelpWanted(until_s=62.0, promised_by="Maria"),
        out_of_service=OutOfService(by="Maria", since_s=1.0, reason="bearings"),
        speed_frac=0.5,
    )
    house.projection.fold(beat)
    seen = (await house.client.get("/api/machines/M1")).json()
    assert seen["about_problem"]["kind"] == "jam"
    assert (seen["resettable"], seen["speed_frac"]) == (True, 0.5)
    assert seen["help"]["promised_by"] == "Maria"
    assert seen["out_of_service"]["reason"] == "bearings"


async def test_a_word_that_was_not_answered_is_passed_on_again_under_its_name_and_another_command_is_not(
    house: House,
) -> None:
    heard: list[MachineCommand] = []

    def receive(_sender: str, message: Message) -> None:
        if isinstance(message, MachineCommand):
            heard.append(message)

    house.bus.join("M1", receive)
    house.projection.fold(machine_heartbeat("M1"))
    for body in (
        {"kind": "made", "quantity": 1, "command": "w1"},
        {"kind": "restart", "command": "c1"},
    ):
        for _ in range(2):
            assert (await ask(house, body)).status_code == 504
    assert [each.command for each in heard] == ["w1", "w1", "c1"]
    grant = heard[1].grant
    assert grant is not None
    assert TrustedKeys(AUTHORITY.public)(signed_words("M1", heard[1], grant), grant.signature)
    other = {"kind": "made", "quantity": 2, "command": "w1"}
    assert (await ask(house, other)).json()["type"].endswith("command-name-used")


@pytest.mark.parametrize(
    ("answers", "seen"),
    [
        ((CommandRefusal.EXPIRED, None), (200, True, None)),
        ((None, CommandRefusal.EXPIRED), (200, True, None)),
        ((CommandRefusal.EXPIRED,), (504, None, None)),
        ((CommandRefusal.EXPIRED, CommandRefusal.EXPIRED), (200, False, "expired")),
    ],
)
async def test_a_word_is_not_refused_for_a_copy_that_came_late_while_another_one_may_count(
    house: House, answers: tuple[CommandRefusal | None, ...], seen: tuple[int, bool | None, str | None]
) -> None:
    heard: list[MachineCommand] = []

    def receive(sender: str, message: Message) -> None:
        if isinstance(message, MachineCommand):
            heard.append(message)
            # The machine was held up: it reads both copies at once.
            for refusal in answers if len(heard) == 2 else ():
                answer = CommandAnswered(command=message.command, done=refusal is None, reason=refusal)
                house.bus.tell("M1", sender, answer)

    house.bus.join("M1", receive)
    house.projection.fold(machine_heartbeat("M1"))
    body = {"kind": "made", "quantity": 1, "command": "w1"}
    assert (await ask(house, body)).status_code == 504
    answer = await ask(house, body)
    told = answer.json()
    assert (answer.status_code, told.get("done"), told.get("reason")) == seen


async def test_loads_that_wait_for_peoples_words_are_told_of_a_machine_whose_body_they_are(
    house: House,
) -> None:
    house.projection.fold(machine_heartbeat("M1"))
    assert (await house.client.get("/api/machines/M1")).json()["unconfirmed"] is None
    load = UnconfirmedLoad(vehicle="ATV3", item="shaft", quantity=12)
    house.projection.fold(machine_heartbeat("M1", 2, people=PeopleAsBody(loads=(load,))))
    told = (await house.client.get("/api/machines/M1")).json()["unconfirmed"]
    assert told == [{"vehicle": "ATV3", "item": "shaft", "quantity": 12, "goes": False}]
