"""The body of a storage whose dock has a controller: what vehicles say is booked, and levels are right in the end."""

from __future__ import annotations

import asyncio
import os
import subprocess
import sys
from pathlib import Path

import msgspec
import pytest
from plc import PATIENCE_S, Plc, mapping
from signals_rig import PLANT, HandClock

from dray.adapters.signals.signal import LEVEL, Edge, Quality, Sample, Signal, SignalMapping, Tag, Value
from dray.adapters.signals.store import DAMAGED_STORE, RESTS_S, KeptStore, SignalledStore
from dray.body import Book, CloseDock, DockReady, OpenDock, Refill, Report, StockChanged

SPEC = PLANT.storages["S1"]
ITEM = SPEC.stocks[0].material
ROOM = {line.material: line.capacity for line in SPEC.stocks}
ITEMS = frozenset(ROOM)
DOCK = {
    Signal.DOCK_PERMIT: Tag("permit"),
    Signal.DOCK_READY: Tag("ready"),
    Signal.DOCK_VEHICLE: Tag("vehicle"),
}


class StoreRig:
    """One storage with 100 pieces, over several lives of its agent."""

    def __init__(self, signals: dict[Signal, Tag] | None = None, **levels: Tag) -> None:
        named = {item.replace("_", "-"): tag for item, tag in levels.items()}
        self.mapping = SignalMapping(DOCK if signals is None else signals, {ITEM: 100}, levels=named)
        self.clock, self.reports = HandClock(), list[Report]()
        self.kept: KeptStore | None = None
        self.begin()

    def begin(self) -> None:
        self.body = SignalledStore(SPEC, self.mapping, self.clock, self, self.kept)
        self.body.attach(self.reports.append)
        self.body.on_link()

    def remember(self, kept: KeptStore) -> None:
        self.kept = kept

    def write(self) -> None:
        """The link would."""

    def tell(self, name: str, value: Value, quality: Quality = Quality.GOOD) -> None:
        self.body.on_sample(name, Sample(value, quality))

    def level(self, pieces: float) -> None:
        self.tell(LEVEL + ITEM, pieces)

    def heard(self) -> list[Report]:
        heard, self.reports[:] = list(self.reports), []
        return heard

    @property
    def stock(self) -> int:
        return self.body.sense().stock[ITEM]


def out(pieces: int = 40, task: str = "M8-1") -> Book:
    return Book("ATV1", ITEM, -pieces, task=task, epoch=1)


def test_a_vehicle_is_let_in_when_the_controller_is_ready_and_its_word_is_booked() -> None:
    rig = StoreRig()
    rig.body.instruct(OpenDock("ATV1", ITEM, 40))
    assert (rig.body.outputs[Signal.DOCK_PERMIT], rig.body.outputs[Signal.DOCK_VEHICLE]) == (True, "ATV1")
    assert (rig.heard(), rig.body.sense().opened) == ([], ("ATV1",))
    rig.tell(Signal.DOCK_READY, True)
    assert rig.heard() == [DockReady("ATV1")]
    rig.body.instruct(out())
    assert rig.heard() == [StockChanged(item=ITEM, change=-40, seq=1, vehicle="ATV1")]
    assert (rig.stock, rig.body.sense().opened, rig.body.outputs[Signal.DOCK_PERMIT]) == (60, (), False)


@pytest.mark.parametrize("value", ["OFF", "false", "no", 1.0])
def test_a_word_that_is_neither_true_nor_false_lets_nobody_in(value: Value) -> None:
    rig = StoreRig()
    rig.body.instruct(OpenDock("ATV1", ITEM, 40))
    rig.tell(Signal.DOCK_READY, value)
    assert rig.heard() == []


def test_a_level_that_is_said_again_and_again_is_believed() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    for _ in range(4):
        rig.level(160)
        rig.clock.pass_s(RESTS_S / 2)
    assert rig.stock == 160


def test_a_life_that_begins_anew_knows_who_is_at_the_dock_and_books_nothing_twice() -> None:
    rig = StoreRig()
    rig.body.instruct(OpenDock("ATV1", ITEM, 40))
    rig.begin()
    assert rig.body.sense().opened == ("ATV1",)
    rig.body.instruct(out())
    rig.begin()
    rig.heard()
    rig.body.instruct(out())
    assert rig.heard() == [StockChanged(item=ITEM, change=-40, seq=1, vehicle="ATV1")]
    assert (rig.stock, rig.body.sense().opened) == (60, ())


def test_a_damaged_memory_is_no_empty_storage_and_what_levels_tell_is_counted() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    rig.kept = DAMAGED_STORE
    rig.begin()
    assert set(rig.body.sense().uncounted) == ITEMS
    rig.begin()  # Killed before anything was remembered, and again after a word of a vehicle.
    rig.body.instruct(out())
    rig.begin()
    assert set(rig.body.sense().uncounted) == ITEMS
    rig.heard()
    rig.level(70)
    rig.clock.pass_s(RESTS_S)
    assert rig.heard() == [StockChanged(item=ITEM, change=70, seq=2, counted=True)]
    assert set(rig.body.sense().uncounted) == ITEMS - {ITEM}
    rig.begin()
    assert (rig.stock, set(rig.body.sense().uncounted)) == (70, ITEMS - {ITEM})


def test_a_level_of_nothing_counts_as_well() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    rig.kept = DAMAGED_STORE
    rig.begin()
    rig.level(0)
    rig.clock.pass_s(RESTS_S)
    assert (rig.stock, ITEM in rig.body.sense().uncounted) == (0, False)


def test_what_people_bring_is_told_once_the_level_has_rested() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    for level in (100, 130, 160):
        rig.level(level)
        rig.clock.pass_s(RESTS_S - 1.0)
    assert rig.heard() == []
    rig.clock.pass_s(2.0)
    assert rig.heard() == [StockChanged(item=ITEM, change=60, seq=1)]
    assert rig.stock == 160


def shakes(rig: StoreRig, middle: int, span_s: float) -> None:
    """A sensor tells a piece more and a piece less, each second."""
    for second in range(int(span_s)):
        rig.level(middle + (0, 1, 0, -1)[second % 4])
        rig.clock.pass_s(1.0)


def test_a_level_that_shakes_by_a_piece_rests() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    shakes(rig, 160, 4 * RESTS_S)
    assert rig.heard() == [StockChanged(item=ITEM, change=60, seq=1)]
    shakes(rig, 161, 4 * RESTS_S)
    assert rig.heard() == []
    rig.level(158)
    rig.clock.pass_s(3 * RESTS_S)
    assert (rig.stock, rig.heard()) == (158, [StockChanged(item=ITEM, change=-2, seq=2)])


def test_a_level_that_shakes_by_more_does_not_rest() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    for second in range(int(4 * RESTS_S)):
        rig.level(160 + 3 * (second % 2))
        rig.clock.pass_s(1.0)
    assert rig.heard() == []


def test_a_level_that_creeps_is_followed_and_right_in_the_end() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    for level in range(100, 121):
        rig.level(level)
        rig.clock.pass_s(RESTS_S / 2 - 1.0)
    rig.clock.pass_s(3 * RESTS_S)
    assert rig.stock == 120


def test_one_material_that_moves_does_not_keep_another_from_being_counted() -> None:
    other = next(line.material for line in SPEC.stocks if line.material != ITEM)
    rig = StoreRig(**{ITEM: Tag("level"), other.replace("-", "_"): Tag("more")})
    for second in range(int(2 * RESTS_S)):
        rig.tell(LEVEL + other, 10 * second)
        rig.level(160)
        rig.clock.pass_s(1.0)
    assert rig.heard() == [StockChanged(item=ITEM, change=60, seq=1)]


@pytest.mark.parametrize("sensor_first", [True, False])
def test_what_a_vehicle_takes_is_taken_once_whoever_says_so_first(sensor_first: bool) -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    rig.level(100)
    rig.body.instruct(OpenDock("ATV1", ITEM, 40))
    rig.tell(Signal.DOCK_READY, True)
    if sensor_first:
        rig.level(60)
        rig.clock.pass_s(5 * RESTS_S)  # Its agent has not said so yet.
    rig.body.instruct(out())
    rig.tell(Signal.DOCK_READY, False)
    rig.clock.pass_s(RESTS_S / 2)
    rig.level(60)
    rig.clock.pass_s(5 * RESTS_S)
    changes = [report for report in rig.heard() if isinstance(report, StockChanged)]
    assert changes == [StockChanged(item=ITEM, change=-40, seq=1, vehicle="ATV1")]


def test_a_vehicle_that_takes_less_than_it_says_is_put_right_by_the_level() -> None:
    rig = StoreRig({}, **{ITEM: Tag("level")})
    rig.body.instruct(OpenDock("ATV1", ITEM, 40))
    rig.body.instruct(out())
    rig.level(62)
    rig.clock.pass_s(RESTS_S)
    assert rig.heard()[-1] == StockChanged(item=ITEM, change=2, seq=2)


@pytest.mark.parametrize(
    ("value", "quality"),
    [
        (50, Quality.BAD),
        (50, Quality.UNCERTAIN),
        (-3, Quality.GOOD),
        (float("nan"), Quality.GOOD),
        (True, Quality.GOOD),
        ("many", Quality.GOOD),
    ],
)
def test_what_is_no_level_changes_nothing(value: Value, quality: Quality) -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    rig.level(40)
    rig.tell(LEVEL + ITEM, value, quality)
    rig.clock.pass_s(RESTS_S)
    assert (rig.heard(), rig.stock) == ([], 100)


def test_a_level_of_before_the_link_was_lost_counts_no_more() -> None:
    rig = StoreRig(**{ITEM: Tag("level")})
    rig.level(40)
    rig.body.on_link_lost("cut")
    rig.clock.pass_s(RESTS_S)
    assert (rig.heard(), rig.stock) == ([], 100)
    assert rig.body.away_since_s is not None


def test_nobody_is_let_in_by_a_controller_that_is_away() -> None:
    rig = StoreRig()
    rig.body.instruct(OpenDock("ATV1", ITEM, 40))
    rig.body.on_link_lost("cut")
    rig.body.on_link()
    assert rig.heard() == []
    rig.tell(Signal.DOCK_READY, True, Quality.UNCERTAIN)
    assert rig.heard() == []
    rig.body.instruct(CloseDock("ATV1"))
    rig.tell(Signal.DOCK_READY, True)
    rig.body.instruct(Refill(ITEM))
    assert rig.heard() == []


@pytest.mark.parametrize(
    ("said", "why"),
    [
        (SignalMapping({Signal.PIECES: Tag("x")}), "signals.pieces: a storage has dock_ready"),
        (SignalMapping({}, {"gold": 1}), "stock.gold: this is not kept there"),
        (SignalMapping({}, levels={"gold": Tag("x")}), "levels.gold: this is not kept there"),
        (SignalMapping({}, levels={ITEM: Tag("x", at_least=9999)}), "no more than .* fit in there"),
    ],
)
def test_a_mapping_that_is_no_storages_is_refused(said: SignalMapping, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        said.check_store(ROOM)


@pytest.mark.parametrize(
    ("tag", "why"),
    [
        (Tag("x", edge=Edge.RISING), "a level has no edge"),
        (Tag("x", invert=True), "is not inverted"),
        (Tag("x", at_least=20, scale=0.45), "a switch .* is on or off, and not scaled"),
    ],
)
def test_a_level_is_no_pulse_and_a_switch_no_number(tag: Tag, why: str) -> None:
    with pytest.raises(ValueError, match=why):
        SignalMapping({}, levels={ITEM: tag})


def test_only_a_level_is_a_switch_of_so_many_pieces() -> None:
    with pytest.raises(ValueError, match="only a switch of `levels`"):
        SignalMapping({Signal.DOCK_PERMIT: Tag("x", at_least=20)})


def switched(kept: KeptStore | None = None, *, at_least: int = 120, invert: bool = False) -> StoreRig:
    """A storage with 100 pieces, as it is kept, and a switch."""
    rig = StoreRig(**{ITEM: Tag("switch", at_least=at_least, invert=invert)})
    if kept is not None:
        rig.kept = kept
        rig.begin()
    return rig


@pytest.mark.parametrize(
    ("at_least", "value", "stock"),
    [(120, True, 120), (120, False, 100), (60, True, 100), (60, False, 59), (1, 0, 0), (120, 1, 120)],
)
def test_a_switch_bounds_the_stock_and_leaves_it_where_it_agrees(
    at_least: int, value: Value, stock: int
) -> None:
    rig = switched(at_least=at_least)
    rig.tell(LEVEL + ITEM, value)
    rig.clock.pass_s(RESTS_S)
    assert rig.stock == stock
    changed = [StockChanged(item=ITEM, change=stock - 100, seq=1)] if stock != 100 else []
    assert rig.heard() == changed


def test_a_switch_that_is_on_while_little_lies_there_is_inverted() -> None:
    rig = switched(at_least=60, invert=True)
    rig.tell(LEVEL + ITEM, False)
    rig.clock.pass_s(RESTS_S)
    assert rig.stock == 100
    rig.tell(LEVEL + ITEM, True)
    rig.clock.pass_s(RESTS_S)
    assert rig.stock == 59


def test_a_body_tells_which_levels_its_controller_measures() -> None:
    assert StoreRig(**{ITEM: Tag("level")}).body.sense().measured == (ITEM,)
    for unmeasured in (StoreRig(), switched()):
        assert unmeasured.body.sense().measured == ()


def test_a_switch_that_flickers_counts_nothing_and_one_that_rests_again_does() -> None:
    rig = switched()
    for second in range(int(4 * RESTS_S)):
        rig.tell(LEVEL + ITEM, second % 2 == 0)
        rig.clock.pass_s(1.0)
    assert rig.heard() == []
    rig.tell(LEVEL + ITEM, True)
    rig.clock.pass_s(RESTS_S)
    assert rig.stock == 120


def test_a_switch_counts_nothing_while_a_vehicle_is_at_the_dock_and_is_looked_at_after_it() -> None:
    rig = switched(at_least=90)
    rig.tell(LEVEL + ITEM, True)
    rig.clock.pass_s(RESTS_S)
    rig.body.instruct(OpenDock("ATV1", ITEM, 40))
    rig.tell(Signal.DOCK_READY, True)
    rig.tell(LEVEL + ITEM, False)
    rig.clock.pass_s(3 * RESTS_S)
    assert rig.stock == 100
    rig.body.instruct(out())
    rig.tell(Signal.DOCK_READY, False)
    rig.clock.pass_s(RESTS_S)
    assert rig.stock == 60
    rig.tell(LEVEL + ITEM, True)
    rig.clock.pass_s(RESTS_S)
    assert rig.stock == 90


def test_a_bound_is_no_count_of_what_nobody_has_counted_but_an_empty_place_is() -> None:
    rig = switched(DAMAGED_STORE)
    for value in (True, False):
        rig.tell(LEVEL + ITEM, value)
        rig.clock.pass_s(RESTS_S)
    assert (rig.heard(), ITEM in rig.body.sense().uncounted) == ([], True)
    rig = switched(DAMAGED_STORE, at_least=1)
    rig.tell(LEVEL + ITEM, False)
    rig.clock.pass_s(RESTS_S)
    assert (rig.stock, ITEM in rig.body.sense().uncounted) == (0, False)


@pytest.mark.parametrize("value", [47, 1.0, "ON", -1])
def test_what_is_neither_yes_nor_no_is_no_switch(value: Value) -> None:
    rig = switched()
    rig.tell(LEVEL + ITEM, value)
    rig.clock.pass_s(RESTS_S)
    assert (rig.stock, rig.heard()) == (100, [])


HURRIED = """
from dray.__main__ import main
from dray.cli.runtime.bodies import signals

signals.SILENT_S, signals.rests_s = 2.0, lambda _speed: 1.0
main()
"""
"""The command, which takes a level after a second of rest instead of ten, and gives its controller up after two seconds of silence instead of ten."""


def test_the_station_of_a_real_storage_begins_and_takes_its_level_and_ends_when_it_is_away(
    tmp_path: Path,
) -> None:
    async def story() -> None:
        async with Plc(pieces=70) as plc:
            nodes = mapping((Signal.PIECES, Signal.DOCK_PERMIT, Signal.DOCK_READY))
            said = {"url": plc.url, "levels": {ITEM: nodes.pop("pieces")}, "signals": nodes}
            file = tmp_path / "s1.yaml"
            file.write_bytes(msgspec.yaml.encode(said))
            process = await asyncio.create_subprocess_exec(
                *(sys.executable, "-c", HURRIED, "agent", "station", "S1"),
                *("--body", "opcua", "--mapping", str(file)),
                stdout=subprocess.PIPE,
                stderr=subprocess.PIPE,
                env={**os.environ, "DRAY_BUS_PLAIN": "true", "DRAY_JOURNAL_FOLDER": str(tmp_path)},
                cwd=tmp_path,
            )
            assert process.stdout is not None
            assert (await process.stdout.readline()).decode() == "S1 is ready\n"
            kept = tmp_path / "S1.store.json"
            async with asyncio.timeout(PATIENCE_S):
                stock = None
                while stock != 70:
                    await asyncio.sleep(0.1)
                    stock = read(kept).stock[ITEM] if kept.exists() else None
        _, told = await process.communicate()
        assert (process.returncode, "the body of S1" in told.decode()) == (1, True), told.decode()

    asyncio.run(asyncio.wait_for(story(), 3 * PATIENCE_S))


def read(file: Path) -> KeptStore:
    return msgspec.json.decode(file.read_bytes(), type=KeptStore)
