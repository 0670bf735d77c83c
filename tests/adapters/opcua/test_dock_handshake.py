"""The handshake at a dock: whatever a controller says, one vehicle at a time, and nobody on the ready of before."""

from __future__ import annotations

from hypothesis import given
from hypothesis import strategies as st

from dray.adapters.signals.dock import NEXT, DockEvent, DockHandshake, DockState


def test_every_event_has_its_place_in_every_state() -> None:
    assert {state: set(table) for state, table in NEXT.items()} == {key: set(DockEvent) for key in DockState}


def test_a_vehicle_is_let_in_when_the_controller_is_ready_and_the_next_one_when_it_is_again() -> None:
    dock = DockHandshake(answers=True)
    dock.want("ATV1")
    dock.want("ATV2")
    assert (dock.vehicle, dock.state) == ("ATV1", DockState.ASKED)
    dock.ready(is_ready=True)
    assert (dock.vehicle, dock.state) == ("ATV1", DockState.OPEN)
    dock.done("ATV1")
    assert (dock.vehicle, dock.state) == ("", DockState.CLOSING)
    dock.ready(is_ready=True)
    assert dock.state is DockState.CLOSING
    dock.ready(is_ready=False)
    assert (dock.vehicle, dock.state) == ("ATV2", DockState.ASKED)


def test_a_ready_that_nobody_has_asked_for_lets_nobody_in() -> None:
    dock = DockHandshake(answers=True)
    dock.ready(is_ready=True)
    dock.want("ATV1")
    assert dock.state is DockState.CLOSING
    dock.ready(is_ready=False)
    dock.ready(is_ready=True)
    assert (dock.vehicle, dock.state) == ("ATV1", DockState.OPEN)


def test_a_controller_that_does_not_answer_is_ready_when_it_is_asked() -> None:
    dock = DockHandshake(answers=False)
    dock.want("ATV1")
    dock.want("ATV2")
    assert (dock.vehicle, dock.state) == ("ATV1", DockState.OPEN)
    dock.done("ATV1")
    assert (dock.vehicle, dock.state) == ("ATV2", DockState.OPEN)


def test_one_that_is_no_more_in_the_queue_takes_nothing_from_the_others() -> None:
    dock = DockHandshake(answers=True)
    for vehicle in ("ATV1", "ATV2", "ATV3"):
        dock.want(vehicle)
    dock.done("ATV2")
    dock.done("ATV9")
    dock.ready(is_ready=True)
    dock.done("ATV1")
    dock.ready(is_ready=False)
    assert dock.vehicle == "ATV3"


def test_a_ready_for_the_vehicle_before_lets_nobody_in_after_a_cut_link() -> None:
    dock = DockHandshake(answers=True)
    dock.want("ATV1")
    dock.ready(is_ready=True)
    dock.lost()
    dock.done("ATV1")
    dock.want("ATV2")
    # The permit of ATV1 was not withdrawn yet, where the controller stands.
    dock.ready(is_ready=True)
    assert (dock.vehicle, dock.state) == ("", DockState.CLOSING)
    dock.ready(is_ready=False)
    dock.ready(is_ready=True)
    assert (dock.vehicle, dock.state) == ("ATV2", DockState.OPEN)


@given(
    st.lists(
        st.tuples(st.sampled_from(("want", "done", "look", "link")), st.sampled_from(("ATV1", "ATV2"))),
        max_size=40,
    )
)
def test_it_is_open_for_whom_the_controller_has_opened_whenever_the_link_was_cut(
    events: list[tuple[str, str]],
) -> None:
    dock, is_linked, told, opened_for = DockHandshake(answers=True), True, "", ""
    dock.ready(is_ready=False)
    for what, vehicle in [("want", "ATV1"), ("look", ""), *events]:
        match what:
            case "want":
                dock.want(vehicle)
            case "done":
                dock.done(vehicle)
            case "link":
                is_linked = not is_linked
                if is_linked:
                    dock.ready(is_ready=bool(opened_for))
                else:
                    dock.lost()
            case _:
                was, opened_for = opened_for, told if opened_for in ("", told) else ""
                if is_linked and bool(was) is not bool(opened_for):
                    dock.ready(is_ready=bool(opened_for))
        if is_linked:
            told = dock.vehicle
        if dock.state is DockState.OPEN:
            assert dock.vehicle == opened_for


EVENTS = st.lists(
    st.one_of(
        st.tuples(st.sampled_from(("want", "done")), st.sampled_from(("ATV1", "ATV2", "ATV3"))),
        st.tuples(st.just("ready"), st.sampled_from((True, False, None))),
    ),
    max_size=40,
)


@given(EVENTS)
def test_it_opens_for_one_who_asked_and_only_by_a_ready_that_came_since(
    events: list[tuple[str, object]],
) -> None:
    dock, waiting, let_in = DockHandshake(answers=True), list[str](), ""
    for what, about in events:
        before = dock.vehicle
        match what:
            case "want":
                dock.want(str(about))
                waiting += [] if about in waiting else [str(about)]
            case "done":
                dock.done(str(about))
                waiting = [vehicle for vehicle in waiting if vehicle != about]
                let_in = "" if let_in == about else let_in
            case _ if about is None:
                dock.lost()
            case _:
                dock.ready(is_ready=bool(about))
        if dock.state is DockState.OPEN:
            # Whoever is in was asked for before this ready came.
            assert dock.vehicle == before
            assert dock.vehicle in waiting
            assert let_in in ("", dock.vehicle)
            let_in = dock.vehicle
        assert dock.vehicle in ("", *waiting)
