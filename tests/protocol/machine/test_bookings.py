"""What a body that does not count is told (`transports.bookings`): again by the next life, until it has answered."""

from __future__ import annotations

from effects import instructed
from m7 import handover, unloading
from next_life import next_life

from dray.body import Book, StockChanged
from dray.memory import DepartureMemory
from dray.protocol.runtime.life import Life
from dray.protocol.transports.bookings import Bookings

LOAD = DepartureMemory("ATV2", "M7-1", 1, "housing", 24)
BROUGHT = [Book("ATV2", "housing", 24, task="M7-1", epoch=1)]


def test_what_is_booked_is_told_again_by_the_next_life_until_the_body_has_answered() -> None:
    first = unloading()
    assert instructed(first.on_message("ATV2", handover()), Book) == BROUGHT
    second = next_life(first)
    assert instructed(second.all, Book) == BROUGHT
    second.stocked("housing", 24, "ATV2")
    assert instructed(next_life(second).all, Book) == []


def test_a_word_that_is_said_again_before_its_answer_is_told_once() -> None:
    life = Life()
    bookings = Bookings(life)
    bookings.say(LOAD)
    bookings.say(LOAD)
    assert instructed(life.effects, Book) == BROUGHT


def test_a_body_that_has_answered_one_word_of_a_vehicle_has_not_answered_the_next() -> None:
    bookings = Bookings(Life())
    taken = DepartureMemory("ATV2", "M7-2", 1, "housing", -6)
    bookings.say(LOAD)
    bookings.say(taken)
    bookings.on_stock_changed(StockChanged("housing", 24, 1, "ATV2"))
    assert bookings.memories() == (taken,)
    bookings.on_stock_changed(StockChanged("housing", -6, 2, "ATV2"))
    assert bookings.memories() == ()
