"""What the benchmark `work` asks for; and, at length, that it is done once."""

from __future__ import annotations

import asyncio
from itertools import islice
from random import Random

import pytest

from dray.gateway.orders.csv_import import read_orders
from dray.messages import Event, TransportOrdered, TransportState, TransportWait
from dray.messages.fact import TransportProgressed
from dray.plant import default_plant
from dray.plant.file.file import shipped_plant
from dray_sim.bench.rest_work.calls import Watch, call_all, loads
from dray_sim.bench.rest_work.killing import kill_in_turn
from dray_sim.bench.rest_work.levels import file_of, order_all
from dray_sim.run.stage import Shift, Stage, play
from dray_sim.scenarios.paper.laboratory import laboratory


def test_a_file_of_orders_is_read_as_that_many_orders_without_a_fault() -> None:
    text, wanted = file_of(shipped_plant("levels"), 200)
    read, faults = read_orders(text)
    assert faults == []
    assert len({each.draft.reference for each in read}) == len(read) == 200
    assert wanted == {"gearbox": 100, "winch": 100}


def test_what_is_brought_to_a_machine_is_taken_back() -> None:
    plant = default_plant()
    drawn = list(islice(loads(plant, Random("calls")), 40))
    for bring, take in zip(drawn[::2], drawn[1::2], strict=True):
        assert bring["from"] in plant.storages_of(bring["item"])
        assert bring["item"] in plant.materials_of(bring["to"])
        assert take == bring | {"from": bring["to"], "to": bring["from"]}


def test_a_watch_tells_the_wait_for_room_from_the_wait_for_a_vehicle() -> None:
    watch = Watch()
    called = TransportOrdered(transport="T-1", source="S1", item="shaft", quantity=4, due_s=900.0)
    watch.on_message(10.0, "gateway", "M1", called)
    states = (
        (11.0, TransportState.WAITING, TransportWait.NO_ROOM, ""),
        (300.0, TransportState.WAITING, TransportWait.NO_BID, ""),
        (320.0, TransportState.ASSIGNED, None, "ATV1"),
        (340.0, TransportState.ASSIGNED, None, "ATV2"),
        (400.0, TransportState.DELIVERED, None, "ATV2"),
    )
    for number, (at_s, state, wait, carrier) in enumerate(states, 1):
        fact = TransportProgressed(
            transport="T-1",
            state=state,
            item="shaft",
            quantity=4,
            source="S1",
            destination="M1",
            wait=wait,
            carrier=carrier,
        )
        event = Event(agent="M1", incarnation=1, number=number, at_s=at_s, fact=fact)
        watch.on_message(at_s, "M1", "plant/event/M1", event)
    assert (watch.asked_s, watch.room_s, watch.won_s) == ({"T-1": 10.0}, {"T-1": 300.0}, {"T-1": 320.0})
    assert watch.ends == {"T-1": [TransportState.DELIVERED]}


def test_all_live_when_the_killing_is_over() -> None:
    async def kill(stage: Stage) -> tuple[int, set[int]]:
        kills = await kill_in_turn(
            stage, tuple(stage.plant.fleet), 60.0, 20.0, lambda: stage.now_s() >= 200.0
        )
        await asyncio.sleep(10.0)
        return kills, {stage.factory.journals[atv].incarnation for atv in stage.plant.fleet}

    told = play(Shift("kills", 0.0), laboratory(), 1, kill).result
    assert told == (4, {2, 3})


@pytest.mark.campaign
def test_what_is_asked_for_over_rest_is_done_once_and_no_login_link_is_printed(
    capsys: pytest.CaptureFixture[str],
) -> None:
    rows = asyncio.run(order_all(4, None)) + asyncio.run(call_all(9, 0, None, on_s=0.0))
    assert [(row.name, row.note) for row in rows if not row.met] == []
    assert capsys.readouterr().out == ""
