"""Each load at a dock is booked once, whoever is silent, forgets or is started again, and the dock opens again.

In the end all are heard, and whoever is asked answers (`dock_world`).
"""

from __future__ import annotations

from typing import Any

from dock_world import CART, DockWorld
from examples import examples
from hypothesis import example, given, settings
from hypothesis import strategies as st

STEPS = (
    "asks",
    "is_ready",
    "moves",
    "tells",
    "is_silent",
    "restarts",
    "forgets",
    "gives_back",
    "leaves",
    "works_elsewhere",
    "loads_elsewhere",
    "comes_back",
    "machine_restarts",
    "machine_forgets",
)


def story(*steps: str, takes: bool, counts: bool = False, is_own: bool = False) -> dict[str, Any]:
    """An example at a dock that takes time to open."""
    return {"steps": [*steps], "takes": takes, "answers": True, "counts": counts, "is_own": is_own}


@given(
    steps=st.lists(st.sampled_from(STEPS), max_size=14),
    takes=st.booleans(),
    answers=st.booleans(),
    counts=st.sampled_from((False, False, True)),
    is_own=st.booleans(),
)
@example(**story("forgets", "machine_restarts", takes=True))
@example(**story("forgets", takes=True, counts=True))
@example(**story("is_ready", "tells", "machine_restarts", "tells", "gives_back", takes=False))
@example(**story("is_ready", "moves", "machine_forgets", "tells", takes=False))
@example(**story("is_ready", "moves", "machine_forgets", "leaves", "tells", takes=True))
@example(**story("is_ready", "moves", "forgets", "machine_forgets", "tells", takes=False))
@example(**story("machine_restarts", "gives_back", "leaves", takes=True, is_own=True))
@settings(max_examples=examples(300))
def test_a_load_is_booked_once_and_the_dock_opens_again(
    steps: list[str], *, takes: bool, answers: bool, counts: bool, is_own: bool
) -> None:
    world = DockWorld(takes=takes, answers=answers, counts=counts, is_own=takes and is_own)
    for step in steps:
        getattr(world, step)()
    world.settle()
    moved = sum(world.moved.values())
    assert CART not in world.opened or world.is_here
    assert abs(world.booked) <= world.pieces * world.loads, "a load is booked twice"
    if not (world.lost_notes or world.was_let_in):
        assert world.booked == 0, "what is booked was never moved"
    if world.is_own:
        # Nobody can be asked for it: in doubt it is booked out.
        assert world.lost_notes or world.booked <= moved, "what was taken is promised"
    elif not world.lost_notes and (takes or not world.is_forgotten):
        assert world.booked == moved
    elif not takes and answers and not counts:
        assert world.booked == moved, (
            "the body remembers whom it let in, and the vehicle tells, or has left empty"
        )
    elif not takes:
        assert world.booked in (0, moved), "what does not lie there is booked in"
    elif answers:
        assert world.booked <= moved, "what was taken is promised"
