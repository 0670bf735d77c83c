"""One vehicle at a dock (`transports.visit`): what a heartbeat, or its next request, tells of its load. Each row is a story of its own."""

from __future__ import annotations

import pytest
from msgspec.structs import replace

from dray.memory import DepartureMemory
from dray.messages import Docked, Phase
from dray.protocol.transports.visit import Sighting, Stage, Visit

LIFE = 3
TAKES = DepartureMemory("CART", "T1", 1, "shaft", -6)
BRINGS = DepartureMemory("CART", "T1", 1, "shaft", 6)
RETURNS = replace(BRINGS, returns=True)
ENDED = replace(TAKES, ended=True)
UNNAMED_TAKES = DepartureMemory("CART", item="shaft", change=-6)
UNNAMED_BRINGS = DepartureMemory("CART", item="shaft", change=6)

HERE = Sighting(
    is_here=True,
    names_task=False,
    phase=None,
    has_load=False,
    is_empty=True,
    left_empty=False,
    life=LIFE,
    was_heard=False,
)
"""It stands at the dock without a task and empty, and was not heard for a while."""
ELSEWHERE = HERE._replace(is_here=False)
OTHER_TASK = HERE._replace(phase=Phase.APPROACHING)
LOADED = HERE._replace(has_load=True, is_empty=False)


def visit(load: DepartureMemory, stage: Stage = Stage.INSIDE, *, named_in: int = 0) -> Visit:
    one = Visit(load, stage)
    one.named_in = named_in
    return one


@pytest.mark.parametrize(
    ("one", "seen", "is_here_still"),
    [
        pytest.param(
            visit(TAKES, Stage.WAITS),
            ELSEWHERE._replace(names_task=True, phase=Phase.APPROACHING),
            True,
            id="its heartbeat is of before it came",
        ),
        pytest.param(
            visit(TAKES, Stage.LEAVING),
            ELSEWHERE._replace(names_task=True, phase=Phase.APPROACHING),
            False,
            id="it may load no more, and drives off before it has heard so",
        ),
        pytest.param(visit(TAKES), HERE, True, id="its body may go on loading without its agent's memory"),
        pytest.param(
            visit(TAKES, named_in=LIFE), HERE, False, id="the life that named the task has ended it"
        ),
        pytest.param(visit(TAKES), LOADED, False, id="it has loaded"),
        pytest.param(visit(TAKES, Stage.WAITS), LOADED, True, id="what it has on board is not from here"),
        pytest.param(visit(TAKES, Stage.GONE), HERE, False, id="it comes by after it was heard elsewhere"),
        pytest.param(visit(TAKES), OTHER_TASK, False, id="it works for another task after a silence"),
        pytest.param(
            visit(TAKES), OTHER_TASK._replace(was_heard=True), True, id="it was given another task, and loads"
        ),
        pytest.param(visit(UNNAMED_TAKES), OTHER_TASK, True, id="its task may be the one it was let in for"),
        pytest.param(
            visit(ENDED), OTHER_TASK, True, id="it had ended its task before, and may load all the same"
        ),
        pytest.param(visit(BRINGS), HERE, False, id="it stands here empty: its load is down"),
        pytest.param(visit(UNNAMED_BRINGS), HERE, True, id="it may still report what it has brought"),
        pytest.param(visit(UNNAMED_BRINGS), ELSEWHERE, False, id="it has left"),
        pytest.param(
            visit(UNNAMED_BRINGS),
            HERE._replace(phase=Phase.UNLOADING),
            True,
            id="it unloads, for what it was let in perhaps",
        ),
        pytest.param(
            visit(BRINGS), HERE._replace(phase=Phase.UNLOADING), False, id="it unloads for another task"
        ),
        pytest.param(
            visit(BRINGS), LOADED._replace(phase=Phase.RETURNING), True, id="it brings back what it has found"
        ),
    ],
)
def test_whether_it_is_here_still(one: Visit, seen: Sighting, *, is_here_still: bool) -> None:
    assert one.is_here_still(seen) is is_here_still


@pytest.mark.parametrize(
    ("one", "seen", "has_moved"),
    [
        pytest.param(visit(TAKES), ELSEWHERE, None, id="nobody can tell after a silence"),
        pytest.param(
            visit(TAKES), ELSEWHERE._replace(was_heard=True), False, id="it left empty a moment ago"
        ),
        pytest.param(visit(ENDED), ELSEWHERE, False, id="it had ended its task before"),
        pytest.param(
            visit(TAKES, named_in=LIFE),
            HERE,
            False,
            id="it stands here empty, and has ended its task in a silence",
        ),
        pytest.param(visit(TAKES), LOADED._replace(is_here=False), True, id="it has such a load, from here"),
        pytest.param(
            visit(ENDED),
            LOADED._replace(is_here=False),
            False,
            id="it had ended its task: its load is from elsewhere",
        ),
        pytest.param(
            visit(TAKES, Stage.GONE),
            LOADED,
            None,
            id="it was elsewhere without such a load, and has it from there",
        ),
        pytest.param(visit(BRINGS), HERE, True, id="it stands here empty"),
        pytest.param(visit(BRINGS), LOADED, False, id="it stands here with its load"),
        pytest.param(visit(BRINGS), ELSEWHERE, None, id="it may have lost its load elsewhere"),
        pytest.param(visit(BRINGS), OTHER_TASK, None, id="it works for another task after a silence"),
        pytest.param(
            visit(UNNAMED_BRINGS),
            OTHER_TASK,
            True,
            id="its task is the one that it was let in for perhaps, and it is empty",
        ),
        pytest.param(
            visit(UNNAMED_BRINGS),
            HERE._replace(is_here=False, phase=Phase.RETURNING),
            False,
            id="it brings its load back",
        ),
        pytest.param(visit(BRINGS), ELSEWHERE._replace(left_empty=True), True, id="it has left empty"),
        pytest.param(
            visit(TAKES), ELSEWHERE._replace(left_empty=True), False, id="it has left without a load"
        ),
    ],
)
def test_whether_it_has_moved_its_load(one: Visit, seen: Sighting, has_moved: bool | None) -> None:
    assert one.has_moved(seen) is has_moved


@pytest.mark.parametrize(
    ("load", "item", "unloads", "was_heard", "has_moved"),
    [
        pytest.param(BRINGS, "shaft", True, True, False, id="it still has to unload"),
        pytest.param(BRINGS, "bar", False, True, True, id="it was heard until it came for another load"),
        pytest.param(BRINGS, "bar", False, False, None, id="it was silent until it came for another load"),
        pytest.param(TAKES, "shaft", True, True, True, id="it unloads here what it has taken here"),
        pytest.param(TAKES, "bar", True, False, None, id="it unloads something else after a silence"),
        pytest.param(TAKES, "bar", False, True, False, id="it was heard until it asked for another load"),
        pytest.param(ENDED, "bar", False, False, False, id="it had ended its task before"),
    ],
)
def test_what_its_next_request_tells(
    load: DepartureMemory, item: str, has_moved: bool | None, *, unloads: bool, was_heard: bool
) -> None:
    docked = Docked("T2", 1, "LATHE1", item, 4)
    assert visit(load).has_moved_before(docked, unloads=unloads, was_heard=was_heard) is has_moved


@pytest.mark.parametrize(
    ("load", "item", "unloads", "may_be"),
    [
        pytest.param(UNNAMED_TAKES, "shaft", False, True, id="the same item"),
        pytest.param(UNNAMED_TAKES, "", False, True, id="any item"),
        pytest.param(
            DepartureMemory("CART"), "bar", False, True, id="nothing is remembered but that it was let in"
        ),
        pytest.param(UNNAMED_TAKES, "bar", False, False, id="another item"),
        pytest.param(UNNAMED_TAKES, "shaft", True, False, id="it unloads"),
        pytest.param(UNNAMED_BRINGS, "shaft", False, False, id="it has brought something"),
        pytest.param(TAKES, "shaft", False, False, id="it was let in for a task that is known"),
    ],
)
def test_whether_a_request_may_be_for_what_an_earlier_life_let_it_in(
    load: DepartureMemory, item: str, *, unloads: bool, may_be: bool
) -> None:
    assert visit(load).may_be_for(Docked("T2", 1, "LATHE1", item, 4), unloads=unloads) is may_be


@pytest.mark.parametrize(
    ("load", "before", "after"),
    [
        pytest.param(BRINGS, Stage.WAITS, Stage.LEAVING, id="an earlier life has opened the dock"),
        pytest.param(
            RETURNS, Stage.WAITS, Stage.WAITS, id="the dock was never opened for what it brings back"
        ),
        pytest.param(BRINGS, Stage.INSIDE, Stage.INSIDE, id="its permission stands"),
    ],
)
def test_a_load_that_is_said_to_be_down_was_let_in(
    load: DepartureMemory, before: Stage, after: Stage
) -> None:
    one = visit(load, before)
    one.note_down()
    assert one.stage is after


@pytest.mark.parametrize(
    ("before", "after"),
    [
        (Stage.WAITS, Stage.WAITS),
        (Stage.INSIDE, Stage.INSIDE),
        (Stage.LEAVING, Stage.INSIDE),
        (Stage.GONE, Stage.WAITS),
    ],
)
def test_who_comes_again_for_the_same_load_is_let_in_anew_once_it_was_elsewhere(
    before: Stage, after: Stage
) -> None:
    assert before.renewed is after
