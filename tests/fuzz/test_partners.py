"""Whoever is no party to a contract changes nothing by what he says of it.

Every situation is played twice, and one of the two agents hears strangers who know all about it: they say every word that
may be said of a contract, of every task, epoch, role and award that there may be. What the agent does at that moment is
to count the message, or to tell the stranger that he is wrong; and from then on both do the same, to the last effect.
"""

from __future__ import annotations

from collections.abc import Callable, Iterator
from itertools import product
from typing import get_args

import pytest
from situations import SITUATIONS, TASKS, WAREHOUSE, Played, machine_in_its_second_life
from spoken import production, transport

from dray.messages import (
    Accepted,
    Award,
    Confirmed,
    Declined,
    Docked,
    DockHeld,
    DockOpened,
    GoalClosed,
    GoalRevised,
    Handover,
    HandoverAccepted,
    Message,
    Reason,
    Refusal,
    Release,
    Resigned,
    Role,
    StockReserved,
    StockShort,
    Superseded,
    TakenOver,
    Withdrawn,
)
from dray.protocol.contract_net.parties import Word, contract_of
from dray.protocol.runtime.events import Ignore, Send
from dray.protocol.transports.transports import RECOVERY_WAIT_S

SETTLE_S = 60.0
"""Longer than everything that a word could set off at once."""

STRANGERS = ("ATV7", "M5", "strategist-2")
"""Parties to nothing."""

EPOCHS = (1, 2, 3)
NUMBERS = (0, 1, 2, 3, 1_000_001)
WORKS = (transport(), production())
STATIONS = ("M7", "M8", "S3", WAREHOUSE)


def words() -> Iterator[Message]:
    """All that the parties to a contract may say of it, an award to somebody new left out: that makes a contract."""
    for task, epoch in product(TASKS, EPOCHS):
        yield Confirmed(task=task, epoch=epoch, arrived=24)
        yield HandoverAccepted(task=task, epoch=epoch)
        yield Superseded(task=task, epoch=epoch)
        yield Withdrawn(task=task, epoch=epoch, reason=Reason.NOT_NEEDED)
        yield GoalClosed(goal=task)
        yield GoalRevised(task=task, epoch=epoch, quantity=1, deadline_s=100.0)
        yield Handover(task=task, epoch=epoch, quantity=24)
        for primary in ("ATV1", "ATV2"):
            yield TakenOver(task=task, epoch=epoch, primary=primary, finish_s=100.0, source="S3")
        for station in STATIONS:
            yield Docked(task=task, epoch=epoch, station=station)
            yield StockReserved(task=task, epoch=epoch, item="housing", quantity=24)
            yield StockShort(task=task, epoch=epoch, item="housing", free=0)
            yield DockOpened(task=task, epoch=epoch, station=station)
            yield DockHeld(task=task, epoch=epoch, station=station, reason="no room")
        for role in Role:
            yield Resigned(task=task, epoch=epoch, role=role, reason=Reason.STOPPED)
            for number in NUMBERS:
                yield Release(task=task, epoch=epoch, role=role, reason=Reason.NO_ANSWER, number=number)
                yield Accepted(task=task, epoch=epoch, role=role, finish_s=100.0, number=number)
                yield Declined(task=task, epoch=epoch, role=role, reason=Refusal.BUSY, number=number)


def at_rest(situation: Callable[[], Played]) -> Played:
    """A situation in which nothing is left to be done at that moment, and nobody is taken at his word any more.

    For ten seconds of its life a machine believes whoever says that he carries a task of which it does not know that.
    """
    actor = situation()
    actor.run(actor.now_s + (RECOVERY_WAIT_S if situation is machine_in_its_second_life else 0.0))
    return actor


def told(actor: Played, stranger: str, message: Message) -> None:
    """Let a stranger say something: it is counted, or he is told that he is wrong."""
    actor.effects.clear()
    actor._steps = 0  # There is no limit to what strangers may say at one moment.
    actor.on_message(stranger, message, actor.now_s)
    for effect in actor.effects:
        assert isinstance(effect, Ignore) or (isinstance(effect, Send) and effect.to == stranger), (
            stranger,
            message,
            effect,
        )


def from_now_on(actor: Played) -> list[str]:
    """All that an agent does from this moment on, in any order: what is due at one instant is done in either."""
    actor.effects.clear()
    actor._steps = 0
    actor.run(actor.now_s + SETTLE_S)
    return sorted(map(repr, actor.effects))


@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda situation: situation.__name__)
def test_what_strangers_say_of_a_contract_changes_nothing(situation: Callable[[], Played]) -> None:
    actor, undisturbed = at_rest(situation), at_rest(situation)
    for stranger, word in product(STRANGERS, words()):
        told(actor, stranger, word)
    assert from_now_on(actor) == from_now_on(undisturbed)


@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda situation: situation.__name__)
def test_nor_does_a_stranger_s_award_of_what_was_given_already(situation: Callable[[], Played]) -> None:
    actor, undisturbed = at_rest(situation), at_rest(situation)
    assert actor.agent is not None
    given = [Award(task, 9, role, work, 3600.0) for task, role in product(TASKS, Role) for work in WORKS]
    for award in given:
        contract = contract_of(award)
        assert contract is not None
        given_by = getattr(actor.agent, "_coordinator_of", lambda *_: "")
        if given_by(*contract):
            told(actor, STRANGERS[1], award)
    assert from_now_on(actor) == from_now_on(undisturbed)


def test_every_word_of_a_coordinator_is_tried() -> None:
    assert {type(word) for word in words()} >= {*get_args(Word)} - {Award}
