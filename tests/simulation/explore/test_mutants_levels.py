"""The search finds who counts parts or bad pieces wrong, and a storage that opens for two; see `test_mutants`."""

from __future__ import annotations

import pytest
from mutants import Find, Mutant

from dray.messages import AtvHeartbeat, Docked
from dray.protocol.machine.cycle import Cycle
from dray.protocol.machine.supply import Supply
from dray.protocol.strategist.part_stock import PartStock
from dray.protocol.transports.issuing import Issuing
from dray.protocol.transports.reservations import Ask
from dray_sim.explore.run import draw


def that_counts_a_part_on_its_way_and_in_stock(patch: pytest.MonkeyPatch) -> None:
    """A strategist goes on counting what a vehicle had on board, after it has put it down."""
    on_vehicle = PartStock.on_vehicle

    def keep(self: PartStock, sender: str, heartbeat: AtvHeartbeat, now_s: float) -> None:
        if heartbeat.load:
            on_vehicle(self, sender, heartbeat, now_s)
        elif sender in self._lies:
            self._lies[sender] = now_s, self._lies[sender][1]

    patch.setattr(PartStock, "on_vehicle", keep)


def that_tells_of_goods_in_buffers_too(patch: pytest.MonkeyPatch) -> None:
    """A machine has a buffer for the parts that it makes itself, and tells of them there and as goods."""
    take_count = Supply.take_count

    def provide(self: Supply, stock: dict[str, int], seq: int) -> None:
        take_count(self, stock, seq)
        for item in stock:
            if item in self._plant.materials:
                self._provide(item, 1)

    patch.setattr(Supply, "take_count", provide)


def that_takes_bad_pieces_for_good_ones(patch: pytest.MonkeyPatch) -> None:
    """A machine does not look at whether a piece is bad."""
    done = Cycle.done

    def take(self: Cycle, product: str, seq: int, *, bad: bool = False) -> None:
        done(self, product, seq)

    patch.setattr(Cycle, "done", take)


def with_storages_that_open_for_two(patch: pytest.MonkeyPatch) -> None:
    """A station lets the next carrier of a task in, and the one before it fetch its load as well."""

    def open_too(self: Issuing, vehicle: str, docked: Docked, ask: Ask, now_s: float) -> None:
        ask.vehicle, ask.opened, ask.epoch = vehicle, docked.epoch, max(ask.epoch, docked.epoch)
        self._book.renew(ask, now_s)
        self._door.open(vehicle, docked, ask.item, ask.quantity, now_s, comes=False)
        self._changed(now_s)

    patch.setattr(Issuing, "_open", open_too)


@pytest.mark.campaign
@pytest.mark.parametrize(
    ("mutant", "profile", "first", "finding"),
    [
        pytest.param(
            that_counts_a_part_on_its_way_and_in_stock, "levels", 0, "invariant 2", id="on-its-way-and-there"
        ),
        pytest.param(that_tells_of_goods_in_buffers_too, "levels", 0, "invariant 2", id="goods-in-buffers"),
        pytest.param(that_takes_bad_pieces_for_good_ones, "levels", 0, "invariant 4", id="bad-as-good"),
        pytest.param(with_storages_that_open_for_two, "deaths", 5, "invariant 24", id="open-for-two"),
    ],
)
def test_the_search_finds_a_mutant_of_parts(
    mutant: Mutant, profile: str, first: int, finding: str, find: Find
) -> None:
    find(mutant, lambda seed: draw(seed, profile), first, finding)
