"""In the calm at the end of a trial everything has to come to its end."""

from __future__ import annotations

import msgspec
import pytest
from trial_kit import PLANT, TASK, closed, event, heartbeat, opened

from dray.messages import CancellationTaken, Message, OrderReleased, Production, RevocationTaken
from dray.messages.fact import Fact, OrderFulfilled, PieceMade
from dray_sim.checks.bounds import HELP_S, NOTICE_S, Patience
from dray_sim.checks.broken import InvariantBroken
from dray_sim.checks.liveness import Calm
from dray_sim.people.habits import Habits


class Watched:
    """A calm with a clock of its own."""

    def __init__(self, habits: Habits | None = None) -> None:
        self.patience = Patience(PLANT, habits)
        self.calm = Calm(self.patience)
        self.now_s = 0.0

    def say(self, sender: str, said: Fact | Message) -> None:
        message = event(sender, said) if isinstance(said, Fact) else said
        assert isinstance(message, Message)
        self.calm.hear(self.now_s, sender, "*", message)

    def wait(self, seconds: float) -> None:
        """Let time pass; M1 makes pieces of something else all the while."""
        until_s = self.now_s + seconds
        while self.now_s < until_s:
            self.now_s = min(self.now_s + 5.0, until_s)
            self.say("M1", heartbeat("ATV8"))


def test_before_the_calm_nothing_is_asked() -> None:
    watched = Watched()
    watched.say("M8", opened())
    watched.wait(10_000.0)
    assert not watched.calm.over.is_set()


def test_a_task_that_nobody_serves_is_noticed() -> None:
    watched = Watched()
    watched.say("M8", opened())
    watched.wait(100.0)
    watched.calm.begin(watched.now_s)
    bound_s = watched.patience.task_s("shaft", 0)
    watched.wait(bound_s - 10.0)
    with pytest.raises(InvariantBroken, match="M8-1 did not end"):
        watched.wait(20.0)


def test_a_task_waits_longer_while_others_are_served() -> None:
    watched = Watched()
    watched.calm.begin(0.0)
    watched.say("M8", opened())
    for number in range(8):
        watched.wait(watched.patience.transport_s / 4)
        watched.say("M2", opened(f"M2-{number}"))
        watched.say("M2", closed(f"M2-{number}"))
    assert watched.now_s > watched.patience.transport_s
    with pytest.raises(InvariantBroken, match="M8-1 did not end"):
        watched.wait(watched.patience.task_s("shaft", 8))


def test_an_order_for_which_nothing_happens_is_noticed() -> None:
    watched = Watched()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.calm.begin(0.0)
    watched.wait(watched.patience.stall_s - 10.0)
    watched.say("M1", PieceMade(goal="D1-1", product="pump-p3", made=1))
    watched.wait(watched.patience.stall_s - 10.0)
    with pytest.raises(InvariantBroken, match=r"nothing came forward .* D1"):
        watched.wait(20.0)


def test_the_calm_is_over_when_everything_has_ended() -> None:
    watched = Watched()
    watched.say("desk", OrderReleased(order="D1", items=(), due_s=0.0))
    watched.say("M8", opened())
    watched.say("strategist", opened("D1-1", Production(product="pump-p3", quantity=1, order="D1", item=0)))
    watched.calm.begin(0.0)
    watched.wait(10.0)
    assert not watched.calm.over.is_set()
    watched.say("M8", closed())
    watched.wait(10.0)
    assert not watched.calm.over.is_set()
    watched.say("strategist", OrderFulfilled(order="D1"))
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_an_order_that_is_cancelled_needs_nothing_any_more() -> None:
    watched = Watched()
    released = OrderReleased(order="D1", items=(), due_s=0.0)
    watched.say("desk", released)
    watched.calm.begin(0.0)
    watched.say("strategist", CancellationTaken(order="D1"))
    watched.say("desk", released)
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_an_order_that_is_taken_back_needs_nothing_until_it_is_released_again() -> None:
    watched = Watched()
    released = OrderReleased(order="D1", items=(), due_s=0.0)
    watched.say("desk", released)
    watched.calm.begin(0.0)
    watched.say("strategist", RevocationTaken("D1", 1, (3,)))
    watched.say("desk", released)
    watched.wait(10.0)
    assert watched.calm.over.is_set()
    watched.say("revision", msgspec.structs.replace(released, release=2))
    watched.say("strategist", RevocationTaken("D1", 1, (3,)))
    watched.wait(10.0)
    assert not watched.calm.over.is_set()
    watched.say("strategist", OrderFulfilled(order="D1"))
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_a_vehicle_that_works_on_for_nobody_is_noticed() -> None:
    watched = Watched()
    watched.calm.begin(0.0)
    watched.say("M8", opened())
    watched.say("M8", closed())
    watched.say("ATV2", heartbeat("ATV2", TASK))
    watched.wait(100.0)
    assert not watched.calm.over.is_set()
    with pytest.raises(InvariantBroken, match="ATV2 still works for M8-1"):
        watched.wait(watched.patience.settle_s + watched.patience.transport_s)


def test_a_vehicle_that_ends_its_work_is_free() -> None:
    watched = Watched()
    watched.calm.begin(0.0)
    watched.say("M8", opened())
    watched.say("M8", closed())
    watched.say("ATV2", heartbeat("ATV2", TASK))
    watched.say("ATV2", heartbeat("ATV2"))
    watched.wait(10.0)
    assert watched.calm.over.is_set()


def test_people_make_everything_slower() -> None:
    alone, helped = Patience(PLANT, None), Patience(PLANT, Habits())
    assert alone.settle_s == NOTICE_S + HELP_S
    assert helped.settle_s > alone.settle_s
    assert helped.transport_s == alone.transport_s
    assert helped.stall_s - alone.stall_s == pytest.approx(helped.settle_s - alone.settle_s)


def test_a_task_for_few_vehicles_may_wait_longer() -> None:
    patience = Patience(PLANT, None)
    kinds = [PLANT.vehicle_types[spec.type] for spec in PLANT.fleet.values()]
    assert any("pallet" not in kind.abilities for kind in kinds)
    assert patience.task_s("housing", 0) == patience.task_s("shaft", 0)
    assert patience.task_s("housing", 5) > patience.task_s("shaft", 5)
