"""A load that is perhaps there and not counted: its alert, and who may say what they have seen."""

from __future__ import annotations

from typing import Any

import pytest
from alerts_kit import the_alert
from answers import problem
from facts_kit import opened, tell
from gateway_kit import House
from heartbeats import machine_heartbeat, station_heartbeat
from msgspec.structs import replace
from obedient_places import ELSEWHERE, MACHINE, STATION, area_of, obedient, places

from dray.gateway.access.principal import Role as PersonRole
from dray.gateway.live.projection import Projection
from dray.messages import (
    CommandRefusal,
    MachineCommand,
    MachineCommandKind,
    Reason,
    TaskBrief,
    Transport,
)

pytestmark = pytest.mark.anyio


def task_of(place: str) -> str:
    return f"{place}-7"


def path_of(place: str) -> str:
    return f"/api/tasks/{task_of(place)}/load"


def words(heard: list[MachineCommand]) -> list[tuple[MachineCommandKind, str]]:
    """What was said of which transport, with a grant."""
    assert all(command.grant is not None for command in heard)
    return [(command.kind, command.task) for command in heard]


def held(projection: Projection, place: str, *, fails_at: str = "") -> None:
    """A place waits for a person who looks for the housings that were to come, or at the dock where vehicles fail."""
    work = Transport(item="housing", quantity=24, sources=("S3",), destination=place, ability="tote")
    tell(projection, place, opened(task_of(place), work=work), at_s=0.0)
    brief = TaskBrief(
        task=task_of(place),
        epoch=3,
        item="housing",
        quantity=24,
        source="",
        destination=place,
        deadline_s=400.0,
        trouble=Reason.DISPUTED,
        fails_at=fails_at,
    )
    if place == MACHINE:
        projection.fold(machine_heartbeat(place, 1, tasks=(brief,)))
    else:
        projection.fold(replace(station_heartbeat(place, 1), tasks=(brief,)))


def listening(
    house: House, place: str, *, refusal: CommandRefusal | None = None, fails_at: str = ""
) -> list[MachineCommand]:
    """A place takes part; the words that it will have heard."""
    held(house.projection, place, fails_at=fails_at)
    return obedient(house, place, refusal=refusal)


@places
def test_the_alert_names_the_transport_and_asks_for_somebody_who_looks(
    projection: Projection, place: str
) -> None:
    held(projection, place)
    alert = the_alert(projection)
    assert (alert.kind, alert.agent, alert.task) == ("task_trouble", place, task_of(place))
    assert alert.cause is not None
    assert alert.cause.reason == "disputed"
    assert alert.cause.text == "perhaps there, and not counted: somebody has to look"


@places
@pytest.mark.parametrize("there", [True, False])
async def test_an_operator_of_the_place_says_what_is_there(house: House, place: str, there: bool) -> None:
    heard = listening(house, place)
    anna = await house.log_in("anna", PersonRole.OPERATOR, area_of(place))
    answer = await anna.post(path_of(place), json={"there": there})
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    kind = MachineCommandKind.LOAD_THERE if there else MachineCommandKind.LOAD_MISSING
    assert words(heard) == [(kind, task_of(place))]
    [row] = await house.audit(action="load.see")
    assert (row.who, row.target, row.result) == ("anna", task_of(place), "done")


async def test_somebody_elsewhere_may_not_and_nothing_is_said(house: House) -> None:
    heard = listening(house, MACHINE)
    ben = await house.log_in("ben", PersonRole.OPERATOR, ELSEWHERE)
    answer = await ben.post(path_of(MACHINE), json={"there": True})
    assert answer.status_code in {403, 404}
    assert heard == []


async def test_what_the_place_refuses_is_told_with_its_reason(house: House) -> None:
    listening(house, MACHINE, refusal=CommandRefusal.NOT_HELD)
    said = (await house.client.post(path_of(MACHINE), json={"there": False})).json()
    assert (said["done"], said["reason"]) == (False, "not_held")
    assert said["text"] == "nobody has to look for the load of that transport"


async def test_of_a_transport_that_nobody_knows_nothing_is_asked(house: House) -> None:
    problem(await house.client.post("/api/tasks/M1-99/load", json={"there": True}), 404, "unknown-task")


@pytest.mark.parametrize("body", [{}, {"there": "yes"}, {"there": True, "task": "M1-7"}])
async def test_what_says_nothing_is_not_sent(house: House, body: dict[str, Any]) -> None:
    heard = listening(house, MACHINE)
    assert (await house.client.post(path_of(MACHINE), json=body)).status_code == 422
    assert heard == []


# --- a dock where vehicle after vehicle fails ---

FAR = "S4"
"""A storage in another area than M1."""


@pytest.mark.parametrize("fails_at", [MACHINE, STATION])
def test_the_alert_names_the_place_where_vehicles_fail_and_no_vehicle(
    projection: Projection, fails_at: str
) -> None:
    held(projection, MACHINE, fails_at=fails_at)
    alert = the_alert(projection)
    assert (alert.kind, alert.level, alert.agent) == ("dock_fails", "alarm", fails_at)
    assert (alert.task, alert.response) == (task_of(MACHINE), "see_to_dock")
    view = projection.tasks.view(task_of(MACHINE))
    assert view is not None
    assert view.trouble is not None
    assert (view.fails_at, view.trouble.reason) == (fails_at, "dock_fails")
    assert view.trouble.text.endswith("somebody has to look at the dock")


async def test_who_is_responsible_for_the_failing_dock_sees_it_and_answers(house: House) -> None:
    heard = listening(house, MACHINE, fails_at=FAR)
    anna = await house.log_in("anna", PersonRole.OPERATOR, area_of(FAR))
    the_alert(house.projection)
    [alert] = (await anna.get("/api/alerts")).json()["items"]
    assert (alert["kind"], alert["agent"]) == ("dock_fails", FAR)
    answer = await anna.post(path_of(MACHINE), json={"there": False})
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    assert words(heard) == [(MachineCommandKind.LOAD_MISSING, task_of(MACHINE))]


async def test_who_is_responsible_for_the_destination_alone_does_not_answer_for_a_dock_elsewhere(
    house: House,
) -> None:
    heard = listening(house, MACHINE, fails_at=FAR)
    ben = await house.log_in("ben", PersonRole.OPERATOR, area_of(MACHINE))
    assert (await ben.post(path_of(MACHINE), json={"there": False})).status_code == 403
    assert heard == []


def test_the_alert_ends_with_the_answer(projection: Projection) -> None:
    held(projection, MACHINE, fails_at=MACHINE)
    projection.fold(machine_heartbeat(MACHINE, 2, tasks=()))
    brief = TaskBrief(task_of(MACHINE), 3, "housing", 24, "", MACHINE, 400.0)
    projection.fold(machine_heartbeat(MACHINE, 3, tasks=(brief,)))
    view = projection.tasks.view(task_of(MACHINE))
    assert view is not None
    assert (view.trouble, view.fails_at) == (None, "")
