"""What an agent knows of obstacles, whatever it hears."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dray.messages.floor.obstacle import FORGOTTEN_AT_MOST_S, FORGOTTEN_S, MOST, MOST_OF_ONE
from dray.protocol.closures.obstacles import Obstacles

NODES = st.sampled_from([f"n{number}" for number in range(12)])
ATVS = st.sampled_from([f"ATV{number}" for number in range(15)])
STEPS = st.lists(
    st.tuples(
        st.sampled_from(["meet", "hear", "clear", "look"]),
        NODES,
        NODES,
        ATVS,
        st.floats(0.0, FORGOTTEN_AT_MOST_S),
        st.floats(0.0, 300.0),
    ),
    max_size=80,
)


@given(STEPS)
def test_nothing_is_counted_on_for_ever_or_beyond_the_bounds(
    steps: list[tuple[str, str, str, str, float, float]],
) -> None:
    obstacles, now_s = Obstacles(), 0.0
    for what, start, end, by, for_s, later_s in steps:
        now_s += later_s
        if what == "meet":
            assert FORGOTTEN_S <= obstacles.meet(start, end, by, now_s) <= FORGOTTEN_AT_MOST_S
        elif what == "hear":
            obstacles.on_reported(start, end, by, for_s, now_s)
        elif what == "clear":
            obstacles.clear(start, end)
            assert not obstacles.is_on(end, start)
        else:
            obstacles.look(now_s)
            assert obstacles.ends_s > now_s
        known = obstacles.known
        assert len(known) <= MOST
        assert all(sum(one.by == by for one in known.values()) <= MOST_OF_ONE for by in {by})
        assert all(one.until_s <= now_s + FORGOTTEN_AT_MOST_S for one in known.values())
        assert {(b, a) for a, b in obstacles.lanes} == obstacles.lanes
    assert obstacles.look(now_s + FORGOTTEN_AT_MOST_S) or not obstacles.lanes
    assert not obstacles.lanes


def test_what_is_still_there_is_counted_on_for_longer_each_time_until_it_was_gone() -> None:
    obstacles = Obstacles()
    spans_s = [obstacles.meet("a", "b", "ATV1", 1000.0 * number) for number in range(6)]
    assert spans_s == [60.0, 120.0, 240.0, 480.0, 600.0, 600.0]
    obstacles.clear("b", "a")
    assert obstacles.meet("b", "a", "ATV1", 9000.0) == 60.0
