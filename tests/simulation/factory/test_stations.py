"""A scarce material holds up who needs it, and nobody else."""

from __future__ import annotations

import msgspec
import pytest
from variants import variants

from dray.messages import (
    Accepted,
    AtvHeartbeat,
    AtvStatus,
    Brief,
    MachineHeartbeat,
    Message,
    Phase,
    Pose,
    Resigned,
    Role,
    StationHeartbeat,
    StockLevel,
)
from dray.plant import Plant, default_plant
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.fault_attribution import FaultAttribution
from dray_sim.checks.invariants import PromisedLiesThere
from dray_sim.checks.waiting import BEYOND_S, NobodyWaitsInVain
from dray_sim.run.evidence import HELD
from dray_sim.run.stage import Shift, Stage, play

SCARCE = "bearing"
"""Of the default plant: gear units and motors need it, pumps do not."""

LOT = 5

HOUR_S = 3600.0


def short_plant() -> Plant:
    """The default plant, with one material in one storage that holds a single small lot."""
    file = default_plant().file
    [*others] = file.storages[1:]
    first = file.storages[0]
    stocks = tuple(
        msgspec.structs.replace(kept, capacity=LOT) if kept.material == SCARCE else kept
        for kept in first.stocks
    )
    storages = (
        msgspec.structs.replace(first, stocks=stocks),
        *(
            msgspec.structs.replace(
                each, stocks=tuple(kept for kept in each.stocks if kept.material != SCARCE)
            )
            for each in others
        ),
    )
    materials = tuple(
        msgspec.structs.replace(each, lot=LOT) if each.id == SCARCE else each for each in file.materials
    )
    return Plant(msgspec.structs.replace(file, storages=storages, materials=materials))


PLANT = short_plant()


class _Ear:
    """What vehicles and machines say of a shortage."""

    def __init__(self) -> None:
        self.standing_s: dict[str, float] = {}
        """Since when a vehicle stands at the storage and loads, or waits there."""
        self.longest_s = 0.0
        self.waits: dict[str, None] = {}
        """What machines have said they wait for."""
        self.given_back: list[str] = []

    def on_message(self, at_s: float, sender: str, _address: str, message: Message) -> None:
        if type(message) is AtvHeartbeat:
            if message.task is not None and message.task.phase is Phase.LOADING:
                since_s = self.standing_s.setdefault(sender, at_s)
                self.longest_s = max(self.longest_s, at_s - since_s)
            else:
                self.standing_s.pop(sender, None)
        elif type(message) is MachineHeartbeat:
            self.waits |= {wait.told(wait.item): None for wait in message.waits}
        elif type(message) is Resigned:
            self.given_back.append(message.reason)


def ordering(stage: Stage, listener: _Ear) -> None:
    """More gear units than there are bearings for, and then pumps, which need none."""
    stage.listeners.add(listener)
    for _ in range(6):
        stage.order("gear-unit-g1", 40)
    stage.order("pump-p3", 24)


@pytest.mark.slow
@pytest.mark.parametrize("seed", [1, pytest.param(2, marks=pytest.mark.slow)])
def test_a_scarce_material_holds_up_who_needs_it_and_nobody_else(seed: int) -> None:
    listener = _Ear()

    async def script(stage: Stage) -> list[str]:
        ordering(stage, listener)
        await stage.until_s(HOUR_S)
        return [order.items[0].product for order in stage.undelivered()]

    played = play(Shift(name="short", duration_s=HOUR_S, stock_frac=(0.0, 0.1)), PLANT, seed, script)
    assert played.invariants == HELD
    assert played.result is not None
    assert "pump-p3" not in played.result
    assert set(played.result) == {"gear-unit-g1"}, "there are not as many bearings"
    slowest_s = max(kind.load_s for kind in PLANT.vehicle_types.values())
    assert listener.longest_s < slowest_s + 20.0, "nobody waits at the storage"
    assert f"{SCARCE} (storage S1 has none)" in listener.waits


@pytest.mark.parametrize("loses_journal", variants([False, True]))
def test_a_station_that_is_away_for_a_while_costs_no_order(loses_journal: bool) -> None:
    listener = _Ear()

    async def script(stage: Stage) -> float:
        stage.listeners.add(listener)
        for product in ("gear-unit-g1", "motor-e4", "pump-p3"):
            stage.order(product, 24)
        for _ in range(6):
            await stage.until_s(stage.now_s() + 45.0)
            for storage in stage.plant.storages:
                if loses_journal:
                    stage.factory.lose_journal(storage)
                else:
                    stage.factory.crash(storage)
            await stage.until_s(stage.now_s() + 20.0)
            for storage in stage.plant.storages:
                stage.factory.restart(storage)
        return await stage.settle(HOUR_S)

    played = play(
        Shift(name="away", duration_s=2 * HOUR_S, stock_frac=(0.0, 0.1)), default_plant(), 4, script
    )
    assert played.invariants == HELD
    assert played.result is not None
    assert played.result < HOUR_S
    assert any("answer" in told for told in listener.waits) or listener.given_back == []


def accepted(finish_s: float) -> Accepted:
    return Accepted(task="M1-1", epoch=1, role=Role.PRIMARY, finish_s=finish_s)


def waiting() -> AtvHeartbeat:
    """ATV1 stands at the storage and waits."""
    brief = Brief(task="M1-1", epoch=1, role=Role.PRIMARY, coordinator="M1", phase=Phase.LOADING, item=SCARCE)
    return AtvHeartbeat(
        atv="ATV1",
        incarnation=1,
        seq=1,
        at_s=0.0,
        status=AtvStatus.WORKING,
        pose=Pose(x_m=0.0, y_m=0.0, heading_rad=0.0),
        node="s1",
        speed_mps=0.0,
        battery_frac=0.9,
        task=brief,
    )


def test_a_promise_of_what_is_not_there_is_found() -> None:
    level = StockLevel(item=SCARCE, level=4, capacity=5, promised=5)
    beat = StationHeartbeat(station="S1", incarnation=1, seq=1, at_s=0.0, stocks=(level,))
    with pytest.raises(InvariantBroken, match="S1 has promised 5 of the 4 bearing"):
        PromisedLiesThere().on_message(1.0, "S1", "", beat)


def test_a_vehicle_that_waits_in_vain_is_found() -> None:
    listener = NobodyWaitsInVain(FaultAttribution(), ("S1",))
    listener.on_message(0.0, "ATV1", ">M1", accepted(finish_s=100.0))
    listener.on_message(100.0, "ATV1", "", waiting())
    listener.on_message(100.0 + BEYOND_S, "ATV1", "", waiting())
    with pytest.raises(InvariantBroken, match="ATV1 is loading for M1-1 121 s after its promise"):
        listener.on_message(101.0 + BEYOND_S, "ATV1", "", waiting())
