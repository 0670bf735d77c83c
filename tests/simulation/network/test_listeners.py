"""Listeners hear all that happens, once."""

from __future__ import annotations

from dray.messages import Event, EventsKept, Message
from dray.messages.fact import OrderFulfilled
from dray_sim.network.listeners import Listeners


def test_what_is_told_again_to_one_that_has_missed_it_is_no_news() -> None:
    heard: list[Message] = []

    class Ear:
        def on_message(self, at_s: float, sender: str, address: str, message: Message) -> None:
            heard.append(message)

    listeners = Listeners()
    listeners.add(Ear())
    event, kept = Event("strategist", 1, 1, 2.0, OrderFulfilled("O1")), EventsKept(1, 1, 1, 1)
    listeners.on_message(2.0, "strategist", "plant/event/strategist", event)
    listeners.on_message(9.0, "strategist", ">historian", event)
    listeners.on_message(9.0, "strategist", ">historian", kept)
    assert heard == [event, kept]
