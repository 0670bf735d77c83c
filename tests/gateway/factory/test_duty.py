"""People on duty: their agents on the bus, the calls that they are asked for, and what is told of them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any

import httpx
import pytest
from fake_bus import KEYS, FakeBus
from gateway_kit import House, gateway
from heartbeats import atv_heartbeat
from msgspec.structs import replace
from wall_clock import NOW_S

from dray.gateway.access.principal import Principal, Role
from dray.gateway.factory.duty import AWAY_S, DutyRota
from dray.gateway.http.provided import provided
from dray.messages import (
    AtvStatus,
    CallAnswer,
    CallAnswered,
    CallState,
    CommandAnswered,
    CommandKind,
    DutyStatus,
    HelpCall,
    HelpWanted,
    Message,
    OperatorHeartbeat,
    VehicleCommand,
)

pytestmark = pytest.mark.anyio


class Caller:
    """A vehicle that calls, and takes whoever says to come."""

    def __init__(self, bus: FakeBus) -> None:
        self.session = bus.join("ATV1", self._on_message)
        self.session.subscribe(KEYS.all_operator_heartbeats)
        self.there: dict[str, OperatorHeartbeat] = {}
        self.answers: list[CallAnswered] = []
        self.promises: list[float | None] = []
        self.takes = True
        self.call = HelpCall(
            call="ATV1-1-1",
            caller="ATV1",
            incarnation=1,
            number=0,
            at_s=0.0,
            state=CallState.RESTING,
            since_s=0.0,
            reason="a pallet",
            x_m=30.0,
            y_m=30.0,
        )

    def say(self, **said: Any) -> None:
        self.call = replace(self.call, number=self.call.number + 1, **said)
        self.session.publish(KEYS.call("ATV1"), self.call)

    def ask(self, *operators: str) -> None:
        self.say(state=CallState.ASKING, asked=operators, until_s=20.0)

    def _on_message(self, sender: str, message: Message) -> None:
        if isinstance(message, OperatorHeartbeat):
            self.there[sender] = message
        elif isinstance(message, VehicleCommand):
            if message.kind is CommandKind.PROMISE:
                self.promises.append(message.wait_s)
            self.session.send(sender, CommandAnswered(command=message.command, done=True))
        elif isinstance(message, CallAnswered):
            self.answers.append(message)
            if message.answer is CallAnswer.TAKE and self.takes:
                self.say(state=CallState.TAKEN, taken_by=sender, turn=1, asked=(), until_s=message.wait_s)


@pytest.fixture
async def open_house(url: str) -> AsyncIterator[House]:
    async with gateway(url, duty=True) as house:
        yield house


async def until(true: Callable[[], bool]) -> None:
    """Go on when something is so; agents have their turn meanwhile."""
    for _ in range(200):
        if true():
            return
        await asyncio.sleep(0)
    raise AssertionError("it never was")


async def on_duty(
    house: House, who: str = "anna", *areas: str, role: Role = Role.OPERATOR
) -> httpx.AsyncClient:
    browser = await house.log_in(who, role, *(areas or ("AREA1",)))
    answer = await browser.put("/api/duty", json={"state": "on"})
    assert answer.status_code == 200, answer.text
    return browser


async def test_somebody_on_duty_is_told_by_a_code_and_where(open_house: House) -> None:
    caller = Caller(open_house.bus)
    browser = await on_duty(open_house)
    await until(lambda: bool(caller.there))
    [beat] = caller.there.values()
    assert (beat.areas, beat.everywhere, beat.status, beat.label) == (("AREA1",), False, DutyStatus.FREE, "")
    assert "anna" not in beat.operator.lower()
    body = (await browser.get("/api/duty")).json()
    assert (body["state"], f"operator.{body['code']}") == ("on", beat.operator)


async def test_names_are_told_where_that_is_wanted(url: str) -> None:
    async with gateway(url, duty=True, operator_names="name") as house:
        caller = Caller(house.bus)
        await on_duty(house)
        await until(lambda: bool(caller.there))
        assert [beat.label for beat in caller.there.values()] == ["Anna"]


async def test_a_person_has_one_code_whatever_the_tablet_and_another_one_tomorrow(open_house: House) -> None:
    rota = provided(open_house.app, DutyRota)
    first, other = rota.code_of("anna"), rota.code_of("ben")
    assert rota.code_of("anna") == first != other
    open_house.wall.now_s += 86_400.0
    assert rota.code_of("anna") != first


async def test_who_logs_in_for_another_area_is_there_for_that_one(open_house: House) -> None:
    caller = Caller(open_house.bus)
    browser = await on_duty(open_house)
    rota = provided(open_house.app, DutyRota)
    moved = Principal(
        kind="person", id="anna", name="Anna", scopes=frozenset(), areas=frozenset({"AREA3"}), station="M8"
    )
    rota.look(moved)
    await until(lambda: any(beat.areas == ("AREA3",) for beat in caller.there.values()))
    assert [(beat.station, len(caller.there)) for beat in caller.there.values()] == [("M8", 1)]
    await browser.aclose()


async def test_going_off_duty_says_so(open_house: House) -> None:
    caller = Caller(open_house.bus)
    browser = await on_duty(open_house)
    await until(lambda: bool(caller.there))
    await browser.put("/api/duty", json={"state": "off"})
    await until(lambda: all(beat.draining for beat in caller.there.values()))
    assert (await browser.get("/api/duty")).json()["state"] == "off"


async def test_whoever_is_asked_sees_it_takes_it_and_promises_it_to_the_vehicle(open_house: House) -> None:
    caller = Caller(open_house.bus)
    browser = await on_duty(open_house)
    await until(lambda: bool(caller.there))
    waits = HelpWanted(until_s=60.0)
    open_house.bus.say(atv_heartbeat("ATV1", status=AtvStatus.ERROR, problem="a pallet", help=waits))
    caller.ask(*caller.there)
    calls: list[Any] = []
    for _ in range(50):
        calls = (await browser.get("/api/duty")).json()["calls"]
        if calls and calls[0]["part"] == "asked":
            break
    assert [(each["caller"], each["part"]) for each in calls] == [("ATV1", "asked")]
    answer = await browser.post("/api/calls/ATV1-1-1/answer", json={"answer": "take", "wait_s": 120})
    assert (answer.status_code, answer.json()) == (200, {"expected": True})
    assert caller.promises == [120.0]
    assert caller.there[f"operator.{(await browser.get('/api/duty')).json()['code']}"].operator
    [row] = await open_house.audit(action="call.answer")
    assert "anna" in str(row)


async def test_a_call_that_is_over_is_refused_and_so_is_who_is_not_on_duty(open_house: House) -> None:
    caller = Caller(open_house.bus)
    browser = await on_duty(open_house)
    await until(lambda: bool(caller.there))
    body = {"answer": "take", "wait_s": 120}
    assert (await browser.post("/api/calls/ATV1-1-9/answer", json=body)).status_code == 409
    assert (await browser.post("/api/calls/ATV1-1-9/answer", json={"answer": "take"})).status_code == 422
    other = await open_house.log_in("ben", Role.OPERATOR, "AREA1")
    refused = await other.post("/api/calls/ATV1-1-9/answer", json=body)
    assert (refused.status_code, refused.json()["type"].rpartition(":")[2]) == (409, "not-on-duty")


async def test_a_key_is_nobody_to_be_asked(open_house: House) -> None:
    answer = await open_house.client.put("/api/duty", json={"state": "on"})
    assert answer.status_code == 409


async def test_a_gateway_without_agents_says_so(house: House) -> None:
    browser = await house.log_in("anna", Role.OPERATOR, "AREA1")
    assert (await browser.put("/api/duty", json={"state": "on"})).status_code == 503


async def test_an_operator_sees_colleagues_of_the_own_areas_only(open_house: House) -> None:
    await on_duty(open_house, "ben", "AREA1")
    await on_duty(open_house, "eva", "AREA3")
    anna = await on_duty(open_house, "anna", "AREA1")
    await until(lambda: len(list(open_house.projection.people.on_duty(0.0))) == 3)
    body = (await anna.get("/api/duty")).json()
    assert [each["areas"] for each in body["colleagues"]] == [["AREA1"]]
    manager = await open_house.log_in("max", Role.MANAGER)
    whole = (await manager.get("/api/duty")).json()
    assert len(whole["colleagues"]) == 3
    assert set(whole["areas_without"]).isdisjoint({"AREA1", "AREA3"})
    assert whole["areas_without"]


async def test_a_call_in_vain_is_an_alert_that_tells_whether_anybody_is_there(open_house: House) -> None:
    caller = Caller(open_house.bus)
    kinds: list[str] = []
    for on_duty_there, state in ((0, CallState.RESTING), (2, CallState.RESTING), (2, CallState.ASKING)):
        caller.say(state=state, on_duty=on_duty_there)
        open_house.projection.look(NOW_S)
        kinds.append(",".join(alert.kind for alert in open_house.projection.alerts.views()))
    assert kinds == ["call_nobody", "call_unanswered", ""]


async def test_a_tablet_that_asks_no_more_is_away_and_one_that_does_is_back(open_house: House) -> None:
    browser = await on_duty(open_house)
    rota = provided(open_house.app, DutyRota)
    [(_, tablet)] = rota._tablets.values()
    open_house.wall.now_s += AWAY_S + 1.0
    rota.look_away()
    assert not tablet.state.there
    await browser.get("/api/duty")
    assert tablet.state.there
