"""What `dray plant ready` finds of docks: which of them shake hands with vehicles, and which mapping cannot be used."""

from __future__ import annotations

from pathlib import Path

import pytest
from ready_kit import WORKSHOP, answers, heard, picture, seen

from dray.cli.runtime.ready.answers import Alert
from dray.cli.runtime.ready.docks import docks
from dray.cli.runtime.ready.finding import Verdict

BY_PEOPLE = tuple(heard(each, unconfirmed=()) for each in WORKSHOP.machines)

COUNTER = "url: opc.tcp://saw\nsignals:\n  pieces: {node: ns=2;s=Good}\n"
SAFE = COUNTER + "  dock_permit: {node: ns=2;s=Here}\n  dock_ready: {node: ns=2;s=Safe}\n"
SCALES = (
    "signals:\n  dock_permit: {topic: a}\n  dock_ready: {topic: b}\nlevels: {paint: {topic: b, path: c}}\n"
)


def test_of_a_dock_of_which_nobody_knows_it_cannot_be_told() -> None:
    found = docks(WORKSHOP, None, None)
    assert seen(found, Verdict.UNKNOWN, "unknown: SAW, DRILL, BENCH, RACK, PAINT")
    some = answers(picture(machines=(heard("SAW"), *BY_PEOPLE[1:])))
    found = docks(WORKSHOP, None, some)
    assert seen(
        found, Verdict.UNKNOWN, "unknown: SAW, RACK, PAINT; without a handshake: DRILL, BENCH (people"
    )


def test_a_dock_that_does_not_get_ready_for_a_vehicle_is_missing() -> None:
    late = Alert("dock_not_ready", "DRILL", ("CART1",))
    assert seen(docks(WORKSHOP, None, answers(picture(alerts=(late,)))), Verdict.MISSING, "DRILL")


def test_mappings_tell_which_docks_shake_hands(tmp_path: Path) -> None:
    stores = {store: [each.material for each in spec.stocks] for store, spec in WORKSHOP.stores.items()}
    for store, items in stores.items():
        (tmp_path / f"{store}.yaml").write_text(SCALES.replace("paint", items[0]))
    (tmp_path / "SAW.yaml").write_text(SAFE)
    (tmp_path / "DRILL.yaml").write_text(COUNTER)
    told = answers(picture(machines=(heard("SAW"), heard("DRILL"), BY_PEOPLE[2])))
    found = docks(WORKSHOP, tmp_path, told)
    assert found.verdict is Verdict.OK
    assert found.seen.split("; ") == [
        "with a handshake: SAW, RACK, PAINT",
        "without a handshake: DRILL (vehicles load as soon as they stand there)",
        "without a handshake: BENCH (people and vehicles report loads)",
    ]


@pytest.mark.parametrize(
    ("place", "text", "said"),
    [
        ("SAW", "signals: 3", "SAW.yaml"),
        ("SAW", "url: opc.tcp://saw\nsignals: {}", "`pieces` is missing"),
        ("RACK", COUNTER, "a storage has"),
        ("RACK", SCALES.replace("paint", "gold"), "levels.gold: this is not kept there"),
    ],
)
def test_a_mapping_that_cannot_be_used_is_missing(tmp_path: Path, place: str, text: str, said: str) -> None:
    (tmp_path / f"{place}.yaml").write_text(text)
    assert seen(docks(WORKSHOP, tmp_path, None), Verdict.MISSING, said)
