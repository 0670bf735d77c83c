"""What `dray plant ready` finds of docks and the gate: which of them shake hands with vehicles, and which mapping cannot be used."""

from __future__ import annotations

from pathlib import Path

import pytest
from ready_kit import WORKSHOP, answers, heard, picture, seen

from dray.cli.runtime.ready.answers import Alert
from dray.cli.runtime.ready.docks import docks
from dray.cli.runtime.ready.finding import Verdict
from dray.messages.keys import GATE

BY_PEOPLE = tuple(heard(each, unconfirmed=()) for each in WORKSHOP.machines)

COUNTER = "url: opc.tcp://saw\nsignals:\n  pieces: {node: ns=2;s=Good}\n"
SAFE = COUNTER + "  dock_permit: {node: ns=2;s=Here}\n  dock_ready: {node: ns=2;s=Safe}\n"
LABELS = (
    "url: opc.tcp://gate\nsignals:\n  pieces: {node: ns=2;s=In}\n  goal: {node: ns=2;s=Label}\n"
    "  admitted: {node: ns=2;s=Admitted}\n  admitted_goal: {node: ns=2;s=For}\n"
)
SCALES = (
    "signals:\n  dock_permit: {topic: a}\n  dock_ready: {topic: b}\nlevels: {paint: {topic: b, path: c}}\n"
)


def test_of_a_dock_of_which_nobody_knows_it_cannot_be_told() -> None:
    found = docks(WORKSHOP, None, None)
    assert seen(found, Verdict.UNKNOWN, "unknown: SAW, DRILL, BENCH, RACK, PAINT, gate")
    some = answers(picture(machines=(heard("SAW"), *BY_PEOPLE[1:])))
    found = docks(WORKSHOP, None, some)
    assert seen(
        found, Verdict.UNKNOWN, "unknown: SAW, RACK, PAINT, gate; without a handshake: DRILL, BENCH (people"
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
    (tmp_path / "gate.yaml").write_text(LABELS)
    told = answers(picture(machines=(heard("SAW"), heard("DRILL"), BY_PEOPLE[2])))
    found = docks(WORKSHOP, tmp_path, told)
    assert found.verdict is Verdict.OK
    assert found.seen.split("; ") == [
        "with a handshake: SAW, RACK, PAINT",
        "without a handshake: DRILL (vehicles load as soon as they stand there)",
        "without a handshake: BENCH (people and vehicles report loads)",
        "the gate counts by its mapping",
    ]


def test_storages_and_the_gate_that_people_work_are_told_as_machines_are() -> None:
    stations = tuple(heard(each, unconfirmed=()) for each in (*WORKSHOP.stores, GATE))
    found = docks(WORKSHOP, None, answers(picture(machines=BY_PEOPLE, stations=stations)))
    assert found.verdict is Verdict.OK
    assert found.seen.split("; ") == [
        "without a handshake: SAW, DRILL, BENCH, RACK, PAINT (people and vehicles report loads)",
        "people count at the gate",
    ]


def test_a_switch_for_a_level_is_told(tmp_path: Path) -> None:
    item = WORKSHOP.stores["RACK"].stocks[0].material
    switch = f"levels: {{{item}: {{topic: b, path: low, at_least: 2, invert: true}}}}\n"
    (tmp_path / "RACK.yaml").write_text("signals: {dock_permit: {topic: a}}\n" + switch)
    assert f"with a switch for a level: RACK ({item})" in docks(WORKSHOP, tmp_path, None).seen


def test_a_late_dock_hides_no_mapping_that_cannot_be_used(tmp_path: Path) -> None:
    (tmp_path / "SAW.yaml").write_text("signals: 3")
    late = Alert("dock_not_ready", "DRILL", ("CART1",))
    found = docks(WORKSHOP, tmp_path, answers(picture(alerts=(late,))))
    assert seen(found, Verdict.MISSING, "the dock is not ready: DRILL; a mapping cannot be used: ")
    assert "SAW.yaml" in found.seen


@pytest.mark.parametrize(
    ("place", "text", "said"),
    [
        ("SAW", "signals: 3", "SAW.yaml"),
        ("SAW", "url: opc.tcp://saw\nsignals: {}", "`pieces` is missing"),
        ("RACK", COUNTER, "a storage has"),
        ("RACK", SCALES.replace("paint", "gold"), "levels.gold: this is not kept there"),
        ("gate", "signals: 3", "gate.yaml"),
        ("gate", COUNTER, "`goal` is missing"),
        ("gate", LABELS.replace("admitted:", "dock_permit:"), "vehicles ask nobody at the gate"),
        ("gate", LABELS.replace("  admitted: {node: ns=2;s=Admitted}\n", ""), "`admitted` is missing"),
        ("gate", LABELS.replace("pieces: {node: ns=2;s=In}", "pieces: {topic: in}"), "needs a `node`"),
    ],
)
def test_a_mapping_that_cannot_be_used_is_missing(tmp_path: Path, place: str, text: str, said: str) -> None:
    (tmp_path / f"{place}.yaml").write_text(text)
    assert seen(docks(WORKSHOP, tmp_path, None), Verdict.MISSING, said)
