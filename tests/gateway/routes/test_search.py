"""Words that lists are searched for: each once, and with the names of products and materials as long as these are few."""

from __future__ import annotations

from dray.gateway.routes.search import MOST_NAMED, MOST_WORDS, sought
from dray.store.database.searching import Sought

NAMES = {"g1": "gear unit", "g2": "gear wheel", "p1": "pump"}


def test_a_word_is_looked_for_with_what_is_called_so() -> None:
    assert list(sought("Gear pump", NAMES)) == [Sought("Gear", ("g1", "g2")), Sought("pump", ("p1",))]


def test_a_word_that_is_said_again_is_looked_for_once() -> None:
    assert [word.text.casefold() for word in sought("pump Pump PUMP gear", NAMES)] == ["pump", "gear"]
    assert len(list(sought(" ".join(map(str, range(100))), NAMES))) == MOST_WORDS


def test_a_word_that_stands_in_very_many_names_is_looked_for_by_itself() -> None:
    names = NAMES | {f"b{number}": "bracket" for number in range(MOST_NAMED - 2)}
    assert [len(word.named) for word in sought("gear bracket pump", names)] == [2, MOST_NAMED - 2, 0]
    assert [len(word.named) for word in sought("pump gear bracket", names)] == [1, 2, 0]
