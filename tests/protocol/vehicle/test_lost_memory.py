"""A vehicle that has lost its memory at a dock, and has left it with nothing on board, says so for as long as that is news."""

from __future__ import annotations

import pytest
from effects import committed, instructed
from rigs import VehicleRig

from dray.body import Drive
from dray.memory import WHOLE, AtvMemory
from dray.messages import AtvHeartbeat

DOCK, NEXT, AWAY = "m7", "m8", "p3"


def forgetful(load: tuple[str, int] = ("", 0), *, incarnation: int = 2) -> VehicleRig:
    """ATV1 stands at M7's dock and begins a life there without notes."""
    rig = VehicleRig(node=DOCK, incarnation=incarnation)
    rig.load = load
    rig.start()
    rig.run(rig.now_s + 1.0)
    return rig


def says(rig: VehicleRig, node: str = "", load: tuple[str, int] | None = None) -> str:
    """What it says after a while, at another node and with another load if they are given."""
    rig.node, rig.load = node or rig.node, rig.load if load is None else load
    rig.run(rig.now_s + 6.0)
    return rig.heartbeats(AtvHeartbeat)[-1].left_empty


def next_life(before: VehicleRig) -> VehicleRig:
    """The same vehicle is started again, with its notes."""
    rig = VehicleRig(node=before.node, incarnation=3)
    rig.memory, rig.load, rig.now_s = committed(before.all), before.load, before.now_s + 100.0
    rig.start()
    return rig


def test_it_says_so_once_it_has_driven_off() -> None:
    rig = forgetful()
    assert says(rig) == ""
    rig.run(rig.now_s + 60.0)
    assert instructed(rig.all, Drive)
    rig.arrive()
    assert says(rig) == DOCK


def test_it_says_so_still_with_a_load_from_elsewhere_on_board() -> None:
    rig = forgetful()
    assert says(rig, AWAY) == DOCK
    assert says(rig, NEXT, ("shaft", 24)) == DOCK


def test_a_load_that_its_body_takes_after_all_is_not_denied() -> None:
    rig = forgetful()
    assert says(rig) == ""
    # Its body has loaded for its earlier life.
    assert says(rig, load=("shaft", 24)) == ""
    assert says(rig, AWAY) == ""
    assert says(rig, load=("", 0)) == ""


def test_a_load_that_it_is_seen_to_have_only_when_it_has_left_is_not_denied() -> None:
    assert says(forgetful(), AWAY, ("shaft", 24)) == ""


def test_a_load_that_its_body_takes_between_two_lives_is_not_denied() -> None:
    before = forgetful()
    before.load = ("shaft", 24)
    assert says(next_life(before), AWAY) == ""


@pytest.mark.parametrize("to", [AWAY, ""], ids=["it has left", "it stands there"])
def test_its_next_life_says_so(to: str) -> None:
    before = forgetful()
    says(before, to)
    assert says(next_life(before), AWAY) == DOCK


def test_it_says_no_more_once_it_stands_there_again() -> None:
    rig = forgetful()
    assert says(rig, AWAY) == DOCK
    assert says(rig, DOCK) == ""
    assert says(rig, AWAY) == ""
    assert says(next_life(rig)) == ""


def test_its_first_life_has_nothing_to_forget() -> None:
    assert says(forgetful(incarnation=1), AWAY) == ""


def test_a_life_with_notes_has_forgotten_nothing() -> None:
    rig = VehicleRig(node=DOCK, incarnation=2)
    rig.memory = {WHOLE: AtvMemory()}
    rig.start()
    assert says(rig, AWAY) == ""
