"""People on duty: their agents on the bus, the calls that they are asked for, and what is told of them."""

from __future__ import annotations

import asyncio
from collections.abc import AsyncIterator, Callable
from typing import Any

import httpx
import pytest
from fake_bus import KEYS, FakeBus
from gateway_kit import PLANT, House, gateway
from heartbeats import atv_heartbeat
from msgspec.structs import replace
from sqlalchemy import select
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
from dray.plant.working_time import WeeklySpan, WorkingHours
from dray.store.tables import metadata

pytestmark = pytest.mark.anyio


class Caller:
    """A vehicle that calls, and takes whoever says to come."""

    def __init__(self, bus: FakeBus, atv: str = "ATV1") -> None:
        self.atv = atv
        self.session = bus.join(atv, self._on_message)
        self.session.subscribe(KEYS.all_operator_heartbeats)
        self.there: dict[str, OperatorHeartbeat] = {}
        self.answers: list[CallAnswered] = []
        self.promises: list[float | None] = []
        self.takes = True
        self.call = HelpCall(
            call=f"{atv}-1-1",
            caller=atv,
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
        self.session.publish(KEYS.call(self.atv), self.call)

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


async def test_who_has_gone_off_duty_by_a_word_is_told_apart_from_who_was_forgotten(
    open_house: House,
) -> None:
    """Another tab puts back on duty whom a gateway that was started again has forgotten, and nobody else."""
    browser = await on_duty(open_house)
    assert not (await browser.get("/api/duty")).json()["said_off"]
    off = (await browser.put("/api/duty", json={"state": "off"})).json()
    assert (off["state"], off["said_off"]) == ("off", True)
    on = (await browser.put("/api/duty", json={"state": "on", "helps_with": ["drive"]})).json()
    assert (on["said_off"], on["helps_with"]) == (False, ["drive"])
    never = await open_house.log_in("ben", Role.OPERATOR, "AREA1")
    assert not (await never.get("/api/duty")).json()["said_off"]


async def test_others_see_what_somebody_is_there_for_and_until_when_busy(open_house: House) -> None:
    browser = await on_duty(open_house)
    body = {"state": "on", "helps_with": ["drive", "load"], "busy_for_s": 600.0}
    own = (await browser.put("/api/duty", json=body)).json()
    assert own["busy_until_at_s"] == pytest.approx(NOW_S + 600.0, abs=1.0)
    manager = await open_house.log_in("max", Role.MANAGER)
    await until(
        lambda: any(each.helps_with for each in open_house.projection.people.on_duty(0.0)),
    )
    [seen] = (await manager.get("/api/duty")).json()["colleagues"]
    assert (seen["status"], seen["helps_with"]) == ("busy", ["drive", "load"])
    assert seen["until_at_s"] == pytest.approx(NOW_S + 600.0, abs=1.0)


async def test_who_was_not_asked_takes_a_call_of_the_own_area_and_no_other(open_house: House) -> None:
    caller = Caller(open_house.bus)
    near, far = await on_duty(open_house, "anna", "AREA1"), await on_duty(open_house, "eva", "AREA3")
    await until(lambda: len(caller.there) == 2)
    caller.ask("operator.another")
    body = {"answer": "take", "wait_s": 120}
    assert (await far.post("/api/calls/ATV1-1-1/answer", json=body)).status_code == 409
    assert (await near.post("/api/calls/ATV1-1-1/answer", json={"answer": "cannot"})).status_code == 409
    assert (await near.post("/api/calls/ATV1-1-1/answer", json=body)).json() == {"expected": True}
    assert (await near.post("/api/calls/ATV1-1-1/answer", json=body)).json() == {"expected": True}
    other = await on_duty(open_house, "ben", "AREA1")
    assert (await other.post("/api/calls/ATV1-1-1/answer", json=body)).status_code == 409


async def test_who_is_asked_elsewhere_is_told_where_that_is(open_house: House) -> None:
    caller = Caller(open_house.bus)
    far = await on_duty(open_house, "eva", "AREA3")
    await until(lambda: bool(caller.there))
    assert (await far.get("/api/duty")).json()["calls"] == []
    caller.ask(*caller.there)
    calls: list[Any] = []
    for _ in range(50):
        calls = (await far.get("/api/duty")).json()["calls"]
        if calls:
            break
    area = open_house.projection.site.plant.areas["AREA1"].name
    assert [(each["area"], each["elsewhere"], each["part"]) for each in calls] == [(area, True, "asked")]


async def test_who_takes_two_calls_is_told_that_one_expects_them_already(open_house: House) -> None:
    first, second = Caller(open_house.bus), Caller(open_house.bus, "ATV2")
    browser = await on_duty(open_house)
    await until(lambda: bool(first.there) and bool(second.there))
    for caller in (first, second):
        caller.ask(*caller.there)
    body = {"answer": "take", "wait_s": 120}
    answers = await asyncio.gather(
        *(browser.post(f"/api/calls/{caller.call.call}/answer", json=body) for caller in (first, second))
    )
    assert sorted(answer.status_code for answer in answers) == [200, 409]
    taken, missed = (first, second) if answers[0].status_code == 200 else (second, first)
    again = await browser.post(f"/api/calls/{missed.call.call}/answer", json=body)
    assert (again.status_code, again.json()["type"].rpartition(":")[2]) == (409, "expected-elsewhere")
    assert f"{taken.atv} expects you" in again.json()["detail"]
    # Whoever gives the one back may take the other.
    await browser.post(f"/api/calls/{taken.call.call}/answer", json={"answer": "decline"})
    taken.say(state=CallState.RESTING, taken_by="", until_s=None)
    now = await browser.post(f"/api/calls/{missed.call.call}/answer", json=body)
    assert now.json() == {"expected": True}


async def test_who_has_gone_off_duty_is_no_colleague_of_their_own(open_house: House) -> None:
    browser = await on_duty(open_house)
    await until(lambda: bool(list(open_house.projection.people.on_duty(0.0))))
    [heard] = open_house.projection.people.on_duty(0.0)
    off = (await browser.put("/api/duty", json={"state": "off"})).json()
    # The last that was heard of them still says that they are there.
    open_house.projection.people.fold(replace(heard, seq=heard.seq + 100), 0.0)
    again = (await browser.get("/api/duty")).json()
    for view in (off, again):
        assert (view["state"], view["colleagues"], view["areas_without"]) == ("off", [], ["AREA1"])


@pytest.mark.parametrize("state", ["off", "break"])
async def test_only_who_is_on_duty_is_busy(open_house: House, state: str) -> None:
    browser = await on_duty(open_house)
    answer = await browser.put("/api/duty", json={"state": state, "busy_for_s": 60})
    assert answer.status_code == 422
    assert "busy_for_s is given with state on" in answer.text


async def test_what_somebody_is_there_for_is_told_once(open_house: House) -> None:
    browser = await on_duty(open_house)
    body = {"state": "on", "helps_with": ["load", "drive", "load"]}
    assert (await browser.put("/api/duty", json=body)).json()["helps_with"] == ["load", "drive"]


async def test_of_a_duty_nothing_is_written_but_what_the_audit_log_has(open_house: House) -> None:
    """The code of the day stands nowhere, and the person only where people are kept, and in what they have decided."""
    caller = Caller(open_house.bus)
    browser = await on_duty(open_house)
    await until(lambda: bool(caller.there))
    code = (await browser.get("/api/duty")).json()["code"]
    caller.ask(*caller.there)
    body = {"answer": "take", "wait_s": 120}
    assert (await browser.post("/api/calls/ATV1-1-1/answer", json=body)).json() == {"expected": True}
    await browser.put("/api/duty", json={"state": "off"})
    await open_house.historian.written()
    found: dict[str, set[str]] = {code: set(), "anna": set()}
    async with open_house.store.read() as work:
        for table in metadata.sorted_tables:
            rows = str((await work._connection.execute(select(table))).all()).lower()
            for word, where in found.items():
                where.update({table.name} if word in rows else ())
    accounts = {"people", "people_areas", "secrets", "sessions", "login_links"}
    assert found[code] == set()
    assert found["anna"] - accounts == {"audit"}


async def test_where_nobody_is_by_the_working_time_of_the_area_it_is_told_when_somebody_comes(
    url: str,
) -> None:
    # The plant's clock is at midnight of UTC.
    early = WorkingHours(shifts=(WeeklySpan("06:00", "14:00"),))
    never = WorkingHours(shifts=(WeeklySpan("06:00", "14:00"),), holidays=("1970-01-01",))
    hours = {"AREA1": early, "AREA2": early, "AREA3": never}
    areas = tuple(replace(each, working_time=hours.get(each.id)) for each in PLANT.areas)
    async with gateway(url, plant=replace(PLANT, areas=areas), duty=True) as house:
        await on_duty(house, "anna", "AREA1")
        await until(lambda: len(list(house.projection.people.on_duty(0.0))) == 1)
        manager = await house.log_in("max", Role.MANAGER)
        told = (await manager.get("/api/duty")).json()
        assert told["areas_without"] == sorted({each.id for each in areas} - {"AREA1"})
        # On the holiday nobody comes before the next day; where people should be now nothing is told.
        assert told["comes_at_s"] == {"AREA2": NOW_S + 6 * 3600.0, "AREA3": NOW_S + 30 * 3600.0}
