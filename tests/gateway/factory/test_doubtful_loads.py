"""A load of which nobody can tell whether it lies at a place: its alert and its end, and who may answer."""

from __future__ import annotations

import pytest
from alerts_kit import alerts, the_alert
from gateway_kit import House
from heartbeats import machine_heartbeat, station_heartbeat
from msgspec.structs import replace
from obedient_places import ELSEWHERE, FLOOR, MACHINE, area_of, obedient, places

from dray.gateway.access.principal import Role as PersonRole
from dray.gateway.live.projection import Projection
from dray.messages import (
    CommandRefusal,
    DoubtfulLoad,
    MachineCommand,
    MachineCommandKind,
    MachineHeartbeat,
    StationHeartbeat,
)

pytestmark = pytest.mark.anyio

NAME = "M1.2-load-1"
DOUBT = DoubtfulLoad(NAME, "ATV5", "housing", 24)


def heartbeat(place: str, seq: int = 1) -> MachineHeartbeat | StationHeartbeat:
    return machine_heartbeat(place, seq) if place == MACHINE else station_heartbeat(place, seq)


def asks(projection: Projection, place: str, *doubts: DoubtfulLoad, seq: int = 1) -> None:
    """A place asks for these loads."""
    projection.fold(replace(heartbeat(place, seq), doubts=doubts))


def path_of(place: str) -> str:
    return f"/api/{'machines' if place == MACHINE else 'stations'}/{place}/commands"


def listening(house: House, place: str, *, refusal: CommandRefusal | None = None) -> list[MachineCommand]:
    """A place takes part; the words that it will have heard."""
    asks(house.projection, place, DOUBT)
    return obedient(house, place, refusal=refusal)


@places
def test_the_alert_names_item_and_pieces_and_asks_to_count_until_somebody_has(
    projection: Projection, place: str
) -> None:
    asks(projection, place, DOUBT)
    alert = the_alert(projection)
    assert (alert.kind, alert.level, alert.agent) == ("load_doubtful", "warning", place)
    assert (alert.response, alert.id) == ("count_stock", f"load_doubtful-{NAME}")
    assert alert.doubt is not None
    assert (alert.doubt.item, alert.doubt.quantity, alert.doubt.vehicle) == ("housing", 24, "ATV5")
    assert alert.doubt.name == FLOOR.materials["housing"].name
    asks(projection, place, seq=2)
    assert alerts(projection) == []


@places
def test_each_load_has_an_alert_of_its_own(projection: Projection, place: str) -> None:
    asks(projection, place, DOUBT, replace(DOUBT, load="M1-load-2", brought=True))
    assert len(alerts(projection)) == 2


@places
def test_the_place_shows_what_is_to_be_counted(projection: Projection, place: str) -> None:
    asks(projection, place, DOUBT)
    view = projection.machines.view(place) if place == MACHINE else projection.stations.view(place)
    assert view is not None
    [doubt] = view.doubts
    assert (doubt.load, doubt.vehicle, doubt.item, doubt.quantity, doubt.brought) == (
        *(NAME, "ATV5", "housing"),
        *(24, False),
    )


@places
@pytest.mark.parametrize("kind", [MachineCommandKind.LOAD_THERE, MachineCommandKind.LOAD_MISSING])
async def test_an_operator_of_the_place_says_what_is_there(
    house: House, place: str, kind: MachineCommandKind
) -> None:
    heard = listening(house, place)
    anna = await house.log_in("anna", PersonRole.OPERATOR, area_of(place))
    answer = await anna.post(path_of(place), json={"kind": kind.value, "task": NAME})
    assert (answer.status_code, answer.json()["done"]) == (200, True)
    [command] = heard
    assert (command.kind, command.task) == (kind, NAME)
    assert command.grant is not None


@places
async def test_somebody_elsewhere_may_not_and_nothing_is_said(house: House, place: str) -> None:
    heard = listening(house, place)
    ben = await house.log_in("ben", PersonRole.OPERATOR, ELSEWHERE)
    answer = await ben.post(path_of(place), json={"kind": "load_there", "task": NAME})
    assert answer.status_code in {403, 404}
    assert heard == []


@places
async def test_what_the_place_refuses_is_told_with_its_reason(house: House, place: str) -> None:
    listening(house, place, refusal=CommandRefusal.DOCK_OPEN)
    said = (await house.client.post(path_of(place), json={"kind": "load_there", "task": NAME})).json()
    assert (said["done"], said["reason"]) == (False, "dock_open")


@places
async def test_an_answer_without_a_load_is_not_sent(house: House, place: str) -> None:
    heard = listening(house, place)
    assert (await house.client.post(path_of(place), json={"kind": "load_there"})).status_code == 422
    assert heard == []
