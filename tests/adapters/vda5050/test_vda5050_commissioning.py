"""Commissioning, against three kinds of vehicles; and dialogues as files, played again."""

from __future__ import annotations

import re
from pathlib import Path
from typing import Any

import msgspec
import pytest
from vda_rig import FLOWING, PROFILE, Rig
from yard import HOLD, LIGHT, PICK, PLANT, TO_CORNER, UNHOLD, Yard, drive

from dray.adapters.vda5050.commissioning import Commissioning, Wanted
from dray.adapters.vda5050.dialogue import Head, Recorder, first_difference, read_dialogue, replay
from dray.adapters.vda5050.profile import Profile, parse_profile, write_profile
from dray.errors import SettingsError
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.vda5050.misbehaviour import Misbehaviour

ALL = Wanted(drive="", station="S1", item="shaft", quantity=20)


def commissioned(profile: Profile, quirks: Misbehaviour, wanted: Wanted, **options: Any) -> Commissioning:
    async def play() -> Commissioning:
        yard = Yard()
        yard.clock = clock()
        rig = Rig(profile, quirks, yard=yard, **options)
        done = Commissioning(rig.body, PLANT, LIGHT, profile, rig.clock, wanted)
        async for _ in done.run():
            pass
        return done

    return run(play(), JUMP)


def marks(done: Commissioning) -> dict[str, bool | None]:
    return {step.name: step.passed for step in done.steps}


def test_a_vehicle_that_behaves_passes_every_step() -> None:
    for profile in (PROFILE, msgspec.structs.replace(FLOWING, version="3.0")):
        done = commissioned(profile, Misbehaviour(), ALL)
        steps = (
            "connection",
            "state",
            "factsheet",
            "names",
            "position",
            "ready",
            "drive",
            "pause",
            "back",
            "cancel",
            "pick",
            "drop",
        )
        assert marks(done) == dict.fromkeys(steps, True)
        assert "ok   drive        from west to middle in" in done.report()


def test_without_leave_nothing_moves() -> None:
    done = commissioned(PROFILE, Misbehaviour(), Wanted())
    assert done.passed
    assert [step.name for step in done.steps if step.passed is None] == [
        "drive",
        "pause",
        "back",
        "cancel",
        "pick",
        "drop",
    ]


def test_what_a_vehicle_cannot_do_goes_into_the_profile_that_is_suggested() -> None:
    quirks = Misbehaviour(no_action_at_last_node=True, no_loads=True, ignores_pause=True)
    plain = msgspec.structs.replace(PROFILE, map=Profile().map)
    done = commissioned(plain, quirks, ALL)
    assert marks(done)["pause"] is False
    assert "try a profile with pause: false" in done.report()
    suggested = done.suggested()
    assert (suggested.load, suggested.action_node_twice, suggested.map.id) == ("none", True, "hall")
    assert parse_profile(write_profile(suggested).encode(), "suggested") == suggested
    assert "    action_node_twice: true" in done.report()


@pytest.mark.parametrize("version", ["2.1", "3.0"])
def test_a_battery_that_counts_to_1_is_named_and_its_scale_is_suggested(version: Any) -> None:
    profile = msgspec.structs.replace(PROFILE, version=version)
    done = commissioned(profile, Misbehaviour(battery_of_1=True), Wanted())
    assert "battery not known: 0.9 may be of 1, not of 100; then battery_scale: fraction" in done.report()
    suggested = done.suggested()
    assert suggested.battery_scale == "fraction"
    again = commissioned(suggested, Misbehaviour(battery_of_1=True), Wanted())
    assert "battery 90 %" in again.report()


THREE_KINDS = {
    "2.0, which keeps what it shows, tells no load and needs a node twice": (
        msgspec.structs.replace(PROFILE, version="2.0"),
        Misbehaviour(
            keeps_node_states=True,
            no_loads=True,
            no_action_at_last_node=True,
            doubles_states=True,
            no_zone=True,
        ),
    ),
    "2.1, which forgets a finished order, is busy after it, and cancels slowly": (
        FLOWING,
        Misbehaviour(forgets_finished_order=True, busy_after_s=2.0, cancel_s=6.0, lingering_warnings=True),
    ),
    "3.0, which loses what is said first, and numbers as text": (
        msgspec.structs.replace(FLOWING, version="3.0", horizon=2),
        Misbehaviour(
            ignores_first_orders=1, ignores_instant_actions=1, numbers_as_text=True, says_offline=True
        ),
    ),
}


@pytest.mark.parametrize("kind", THREE_KINDS)
def test_three_kinds_of_vehicles_are_walked_through_all_of_it(kind: str) -> None:
    profile, quirks = THREE_KINDS[kind]
    done = commissioned(profile, quirks, ALL)
    assert [step.line for step in done.steps if not step.passed] == []
    cancelled = next(step.text for step in done.steps if step.name == "cancel")
    assert re.fullmatch(
        r"cancelled after [\d.]+ s, [\d.]+ m before middle; it went on from there, and back", cancelled
    )
    assert float(cancelled.split(" m before")[0].split()[-1]) > PROFILE.node_m


def test_a_vehicle_that_does_not_cancel_is_found_out() -> None:
    done = commissioned(PROFILE, Misbehaviour(cancel_s=1e6), ALL)
    assert marks(done)["cancel"] is False
    assert not done.passed


def test_a_vehicle_that_cannot_read_instant_actions_gets_the_older_name_of_their_list() -> None:
    async def play() -> Commissioning:
        yard = Yard()
        yard.clock = clock()
        rig = Rig(PROFILE, yard=yard)
        done = Commissioning(rig.body, PLANT, LIGHT, PROFILE, rig.clock, Wanted())
        rig.vehicle.condition.errors.append(
            ("validationError", "WARNING", "required", {"topic": "instantActions"})
        )
        async for _ in done.run():
            pass
        return done

    done = run(play(), JUMP)
    assert done.passed
    assert done.suggested().instant_actions == "instantActions"


@pytest.mark.parametrize(
    ("quirks", "options", "name", "words"),
    [
        (Misbehaviour(), {"linked": False}, "connection", "the broker has not answered yet"),
        (
            Misbehaviour(ignores_instant_actions=99, silent_until_asked=True),
            {},
            "state",
            "see its manufacturer",
        ),
    ],
)
def test_the_first_step_that_fails_ends_it_and_says_why(
    quirks: Misbehaviour, options: dict[str, Any], name: str, words: str
) -> None:
    done = commissioned(PROFILE, quirks, ALL, **options)
    assert done.steps[-1].name == name
    assert done.steps[-1].passed is False
    assert words in done.steps[-1].text


def test_a_factsheet_that_differs_from_the_plant_file_is_said() -> None:
    yard_type = msgspec.structs.replace(LIGHT, max_speed_mps=2.0)

    async def play() -> Commissioning:
        yard = Yard()
        yard.clock = clock()
        rig = Rig(PROFILE, yard=yard)
        done = Commissioning(rig.body, PLANT, yard_type, PROFILE, rig.clock, Wanted())
        async for _ in done.run():
            pass
        return done

    done = run(play(), JUMP)
    assert marks(done)["factsheet"] is False
    assert "max_speed_mps of type light is 2, its factsheet says 1" in done.report()


def recorded(path: Path, profile: Profile = PROFILE) -> Rig:
    rig = Rig(profile, linked=False)
    recorder = Recorder(path, Head("ATV1", PLANT.id, LIGHT.id, profile, life=rig.lives))
    rig.body.record = recorder.write
    rig.link()
    rig.run(1.0)
    rig.do(PICK, for_s=60.0)
    rig.do(drive(*TO_CORNER, order=6), for_s=5.0)
    rig.do(HOLD, for_s=5.0)
    rig.give("state", b"{spoilt")
    rig.do(UNHOLD, for_s=20.0)
    rig.vehicle.restart()
    rig.run(20.0)
    recorder.close()
    return rig


def test_a_dialogue_that_is_played_again_says_the_same(tmp_path: Path) -> None:
    path = tmp_path / "deep" / "d.jsonl"
    rig = recorded(path)
    head, lines = read_dialogue(path)
    played = list(replay(head, lines, PLANT))
    assert first_difference(lines, played) is None
    told = [line.about for line in played if line.effect == "Tell"]
    assert told == [type(report).__name__ for report in rig.heard]
    assert sum(line.effect == "Say" for line in played) == len(rig.said("order")) + len(
        rig.said("instantActions")
    )


def test_another_profile_shows_where_it_speaks_otherwise(tmp_path: Path) -> None:
    path = tmp_path / "d.jsonl"
    recorded(path)
    head, lines = read_dialogue(path)
    difference = first_difference(lines, list(replay(head, lines, PLANT, FLOWING)))
    assert difference is not None
    recorded_line, now = difference
    assert recorded_line is not None
    assert now is not None
    assert (recorded_line.about, now.about) == ("order", "order") or recorded_line.effect == now.effect


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("", "is empty"),
        ("{", ":1: no line of a dialogue"),
        (
            '{"agent": "A", "plant": "p", "type": "t", "profile": {}}\n{"at_s": "x"}',
            ":2: no line of a dialogue",
        ),
        (
            '{"agent": "A", "plant": "p", "type": "t", "profile": {}}\n{"at_s": 1, "event": "Instructed", "about": "Fly"}',
            ":2: no line of a dialogue: 'Fly'",
        ),
    ],
)
def test_what_is_no_dialogue_is_said_by_its_line(tmp_path: Path, text: str, words: str) -> None:
    path = tmp_path / "d.jsonl"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(SettingsError, match=words):
        read_dialogue(path)


def test_a_plant_without_that_type_of_vehicle_is_said(tmp_path: Path) -> None:
    head = Head("ATV1", "elsewhere", "heavy", PROFILE)
    with pytest.raises(SettingsError, match="no vehicle type 'heavy'; the dialogue is of plant elsewhere"):
        list(replay(head, [], PLANT))
