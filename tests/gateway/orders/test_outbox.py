"""The outbox: said until answered, and never more than is outstanding."""

from __future__ import annotations

import asyncio
import logging
from collections.abc import Awaitable, Callable
from typing import Any

import pytest
from fake_bus import FakeBus
from gateway_kit import OTHER_PRODUCT, PRODUCT, gateway
from heartbeats import events
from wall_clock import NOW_S

from dray.gateway.live.timescale import TimeScale
from dray.gateway.orders.outbox import NO_DUE_S, PAUSE_S, SAID_A_TURN, STRATEGIST, TURN_S, Outbox, Reminders
from dray.messages import CancellationTaken, Message, OrderCancelled, OrderReleased, OrderTaken
from dray.messages.fact import GoalContracted, GoodsDelivered, OrderAccepted
from dray.store.orders.orders import Item, Order
from dray.store.orders.progress import OrderStatus
from dray_sim.clock.loop import run

SPEED = 10.0
"""Plant seconds per wall second."""

PAUSES_S = (0.5, 1.0, 2.0, 4.0, 8.0, 15.0, 15.0)
"""How long a reminder waits before each of its first repetitions."""


def order(name: str = "O-1", *lines: tuple[int, int], due_at_s: float | None = NOW_S + 60.0) -> Order:
    """A released order; `lines` are the quantity ordered and what of it is delivered."""
    return Order(
        id=name,
        status=OrderStatus.RELEASED,
        releases=1,
        customer="Customer",
        token="token",
        items=tuple(Item("P1", quantity, done, done) for quantity, done in lines or ((4, 0),)),
        created_at_s=NOW_S,
        due_at_s=due_at_s,
    )


class Stage:
    """A outbox in virtual time that begins at 0, which is `NOW_S` on the wall."""

    def __init__(self) -> None:
        self.said: list[tuple[float, Message]] = []
        self.outbox = Outbox(
            send=self._on_message,
            time=TimeScale(0.0, NOW_S, SPEED),
            wall_s=lambda: NOW_S + self.now_s,
            products={"P1"},
        )

    @property
    def now_s(self) -> float:
        return asyncio.get_running_loop().time()

    @property
    def times_s(self) -> list[float]:
        """When something was said."""
        return [at_s for at_s, _ in self.said]

    @property
    def last(self) -> Any:
        return self.said[-1][1]

    def _on_message(self, to: str, message: Message) -> None:
        assert to == STRATEGIST
        self.said.append((self.now_s, message))


def play(scene: Callable[[Stage], Awaitable[None]]) -> Stage:
    """Play a scene in virtual time beside the running outbox."""
    stage = Stage()

    async def main() -> None:
        running = asyncio.create_task(stage.outbox.run())
        await scene(stage)
        running.cancel()

    run(main())
    return stage


def moments_s(*pauses_s: float) -> list[float]:
    """The moments that lie so far apart, from 0 on."""
    moments = [0.0]
    for pause_s in pauses_s:
        moments.append(moments[-1] + pause_s)
    return moments


# --- releasing -----------------------------------------------------------------------------------


def test_an_order_is_sent_at_once_and_then_with_growing_pauses() -> None:
    async def nobody_answers(stage: Stage) -> None:
        stage.outbox.release(order())
        await asyncio.sleep(sum(PAUSES_S) + 0.1)

    stage = play(nobody_answers)
    assert stage.times_s == pytest.approx(moments_s(*PAUSES_S))
    assert {type(message) for _, message in stage.said} == {OrderReleased}


def test_an_order_that_was_taken_is_sent_no_more() -> None:
    async def answers_to_the_third(stage: Stage) -> None:
        stage.outbox.release(order())
        await asyncio.sleep(2.0)
        stage.outbox.answered(OrderTaken("O-1"))
        await asyncio.sleep(3600.0)

    assert play(answers_to_the_third).times_s == pytest.approx([0.0, 0.5, 1.5])


def test_a_strategist_who_was_away_for_hours_gets_the_order_within_seconds() -> None:
    async def away(stage: Stage) -> None:
        stage.outbox.release(order())
        await asyncio.sleep(7 * 3600.0)

    stage = play(away)
    assert 7 * 3600.0 - stage.times_s[-1] <= PAUSE_S[1]


def test_every_order_has_its_own_pauses() -> None:
    async def one_after_the_other(stage: Stage) -> None:
        stage.outbox.release(order("O-1"))
        await asyncio.sleep(5.0)
        stage.outbox.release(order("O-2"))
        await asyncio.sleep(0.6)
        stage.outbox.answered(OrderTaken("O-1"))
        await asyncio.sleep(1.0)

    stage = play(one_after_the_other)
    second = [
        at_s for at_s, message in stage.said if isinstance(message, OrderReleased) and message.order == "O-2"
    ]
    assert second == pytest.approx([5.0, 5.5, 6.5])


def test_an_answer_about_another_order_and_the_same_answer_again_change_nothing() -> None:
    async def strange_answers(stage: Stage) -> None:
        stage.outbox.release(order())
        stage.outbox.answered(OrderTaken("O-9"))
        stage.outbox.answered(CancellationTaken("O-1"))
        await asyncio.sleep(0.6)
        for _ in range(2):
            stage.outbox.answered(OrderTaken("O-1"))
        await asyncio.sleep(60.0)

    assert play(strange_answers).times_s == pytest.approx([0.0, 0.5])


def test_times_are_told_on_the_plants_clock_and_an_order_is_due_when_it_is_wanted() -> None:
    async def release(stage: Stage) -> None:
        await asyncio.sleep(30.0)
        stage.outbox.release(order(due_at_s=NOW_S + 60.0))
        stage.outbox.release(order("O-2", due_at_s=None))
        (urgent := order("O-3")).wanted_at_s = NOW_S + 20.0
        stage.outbox.release(urgent)

    due_s = [message.due_s for _, message in play(release).said if isinstance(message, OrderReleased)]
    assert due_s == pytest.approx([60.0 * SPEED, 30.0 * SPEED + NO_DUE_S, 20.0 * SPEED])


def test_only_what_is_outstanding_is_ordered_and_every_item_keeps_its_place() -> None:
    async def release(stage: Stage) -> None:
        stage.outbox.ask([order("O-1", (4, 1), (2, 2), (3, 0))])

    (message,) = [message for _, message in play(release).said]
    assert isinstance(message, OrderReleased)
    assert [item.quantity for item in message.items] == [3, 0, 3]


def test_an_order_for_which_an_answer_is_awaited_is_not_asked_for_once_more() -> None:
    async def ask_again(stage: Stage) -> None:
        stage.outbox.ask([order("O-1"), order("O-2")])
        stage.outbox.cancel("O-2")
        stage.outbox.answered(OrderTaken("O-1"))
        stage.outbox.ask([order("O-1"), order("O-2"), order("O-3")])

    said = [(type(message), getattr(message, "order", "")) for _, message in play(ask_again).said]
    assert said[3:] == [(OrderReleased, "O-1"), (OrderReleased, "O-3")]


def test_an_order_for_what_this_plant_does_not_make_is_not_sent_and_named_once(
    caplog: pytest.LogCaptureFixture,
) -> None:
    strange = order()
    strange.items = (Item("P9", 1),)

    async def release(stage: Stage) -> None:
        for _time in range(3):
            stage.outbox.ask([strange, order("O-2")])
            stage.outbox.answered(OrderTaken("O-2"))
        await asyncio.sleep(0.1)

    with caplog.at_level(logging.ERROR):
        stage = play(release)
    assert [message.order for _, message in stage.said if isinstance(message, OrderReleased)] == ["O-2"] * 3
    assert [record.getMessage() for record in caplog.records] == [
        "order O-1 waits: this plant does not make P9"
    ]


# --- cancelling ----------------------------------------------------------------------------------


def test_a_cancellation_takes_the_place_of_the_order_and_is_repeated() -> None:
    async def cancel(stage: Stage) -> None:
        stage.outbox.release(order())
        await asyncio.sleep(3.0)
        stage.outbox.cancel("O-1")
        await asyncio.sleep(2.0)
        stage.outbox.answered(OrderTaken("O-1"))
        await asyncio.sleep(2.0)
        stage.outbox.answered(CancellationTaken("O-1"))
        await asyncio.sleep(60.0)

    stage = play(cancel)
    after = [(at_s, type(message)) for at_s, message in stage.said if at_s >= 3.0]
    assert [at_s for at_s, _ in after] == pytest.approx([3.0, 3.5, 4.5, 6.5])
    assert {kind for _, kind in after} == {OrderCancelled}


def test_a_strategist_who_was_away_for_hours_hears_of_a_cancellation_within_seconds() -> None:
    async def cancel(stage: Stage) -> None:
        stage.outbox.cancel("O-1")
        await asyncio.sleep(7 * 3600.0)

    stage = play(cancel)
    assert 7 * 3600.0 - stage.times_s[-1] <= PAUSE_S[1]


def test_nothing_is_left_in_memory_when_all_is_answered() -> None:
    reminders = Reminders()
    message = OrderCancelled(order="O-1")
    reminders.add("O-1", message, 0.0)
    assert "O-1" in reminders
    assert not reminders.answered(OrderTaken("O-1"))
    assert reminders.due(PAUSE_S[0]) == [message]
    assert reminders.answered(CancellationTaken("O-1"))
    assert not reminders.answered(CancellationTaken("O-1"))
    assert "O-1" not in reminders
    assert reminders.next_s() is None
    assert reminders.due(1e9) == []


def test_ten_thousand_orders_are_said_as_fast_as_an_inbox_takes_them_and_none_is_left_out() -> None:
    async def scene(stage: Stage) -> None:
        stage.outbox.ask(order(f"O-{number}") for number in range(10_000))
        await asyncio.sleep(60.0)

    stage = play(scene)
    for second in range(60):
        assert sum(second <= at_s < second + 1.0 for at_s in stage.times_s) <= SAID_A_TURN
    firsts = [message.order for _, message in stage.said if isinstance(message, OrderReleased)]
    assert len(set(firsts)) == 10_000
    assert len(stage.said) <= 60 * SAID_A_TURN


def test_what_is_answered_makes_room_and_a_single_order_is_said_at_once() -> None:
    async def scene(stage: Stage) -> None:
        stage.outbox.ask(order(f"O-{number}") for number in range(SAID_A_TURN))
        assert len(stage.said) == SAID_A_TURN
        for _, message in list(stage.said):
            assert isinstance(message, OrderReleased)
            stage.outbox.answered(OrderTaken(message.order, message.release))
        await asyncio.sleep(TURN_S)
        stage.outbox.release(order("O-new"))
        assert stage.last.order == "O-new"

    assert len(play(scene).said) == SAID_A_TURN + 1


# --- over a restart ------------------------------------------------------------------------------


def made_by(goal: str, name: str, item: int, product: str, quantity: int) -> GoalContracted:
    return GoalContracted(
        goal=goal, order=name, item=item, product=product, quantity=quantity, machine="M1", finish_s=900.0
    )


def arrived(goal: str, name: str, item: int, product: str, count: int) -> GoodsDelivered:
    return GoodsDelivered(goal=goal, order=name, item=item, product=product, quantity=count, delivered=count)


TWO_LINES = [{"product": PRODUCT, "quantity": 5}, {"product": OTHER_PRODUCT, "quantity": 2}]


@pytest.mark.anyio
async def test_after_a_restart_a_delivered_piece_is_never_ordered_again(url: str) -> None:
    async with gateway(url) as house:
        name = (await house.place(items=TWO_LINES))["id"]
        await house.say(
            [
                *events(
                    "strategist",
                    OrderAccepted(order=name, goals=("G1", "G2")),
                    made_by("G1", name, 0, PRODUCT, 5),
                    made_by("G2", name, 1, OTHER_PRODUCT, 2),
                ),
                *events("M1", arrived("G1", name, 0, PRODUCT, 3), arrived("G2", name, 1, OTHER_PRODUCT, 2)),
            ]
        )
    async with gateway(url, incarnation=2) as house:
        again = await house.bus.next_to(STRATEGIST, OrderReleased)
        assert [(item.product, item.quantity) for item in again.items] == [(PRODUCT, 2), (OTHER_PRODUCT, 0)]
        await house.say(
            [
                *events(
                    "strategist",
                    OrderAccepted(order=name, goals=("Gr2",)),
                    made_by("Gr2", name, 0, PRODUCT, 2),
                    life=2,
                ),
                *events("M1", arrived("Gr2", name, 0, PRODUCT, 2), life=2),
            ]
        )
        assert (await house.get(f"/api/orders/{name}"))["status"] == "delivered"
    async with gateway(url, incarnation=3) as house:
        assert house.bus.sent_to(STRATEGIST, OrderReleased) == []


@pytest.mark.anyio
async def test_events_that_come_twice_and_over_a_restart_change_no_quantity(url: str) -> None:
    async with gateway(url) as house:
        name = (await house.place())["id"]
        told = [
            *events("strategist", made_by("G1", name, 0, PRODUCT, 5)),
            *events("M1", arrived("G1", name, 0, PRODUCT, 1), arrived("G1", name, 0, PRODUCT, 3)),
        ]
        await house.say([*told, *reversed(told)])
    async with gateway(url, incarnation=2) as house:
        await house.say(told)
        again = await house.bus.next_to(STRATEGIST, OrderReleased)
        assert [item.quantity for item in again.items] == [2]
        assert (await house.get(f"/api/orders/{name}"))["items"][0]["delivered"] == 3


@pytest.mark.anyio
async def test_stored_cancelled_and_delivered_orders_are_not_sent_at_the_start(url: str) -> None:
    async with gateway(url) as house:
        await house.place(release=False)
        cancelled = (await house.place())["id"]
        assert (await house.client.post(f"/api/orders/{cancelled}/cancel")).status_code == 200
        delivered = (await house.place())["id"]
        await house.say(events("M1", arrived("G1", delivered, 0, PRODUCT, 5)))
        still_open = (await house.place())["id"]
    async with gateway(url, incarnation=2) as house:
        assert [message.order for message in house.bus.sent_to(STRATEGIST, OrderReleased)] == [still_open]


@pytest.mark.anyio
async def test_open_orders_are_sent_oldest_first_to_whoever_is_there_already(url: str) -> None:
    async with gateway(url) as house:
        names = []
        for _ in range(3):
            names.append((await house.place())["id"])
            house.wall.now_s += 1.0
    bus = FakeBus()
    given = bus.strategist()
    async with gateway(url, bus=bus, incarnation=2):
        assert [message.order for message in given] == names


@pytest.mark.anyio
async def test_the_word_of_the_strategist_ends_the_reminders(url: str) -> None:
    async with gateway(url) as house:
        reminders = house.outbox._reminders
        name = (await house.place())["id"]
        house.bus.tell("ATV1", "gateway", OrderTaken(order=name))
        assert name in reminders
        house.bus.tell(STRATEGIST, "gateway", OrderTaken(order=name))
        assert name not in reminders
        assert (await house.client.post(f"/api/orders/{name}/cancel")).status_code == 200
        house.bus.tell("ATV1", "gateway", CancellationTaken(order=name))
        assert name in reminders
        house.bus.tell(STRATEGIST, "gateway", CancellationTaken(order=name))
        assert name not in reminders


def test_what_was_answered_leaves_nothing_behind_when_its_time_has_come() -> None:
    reminders = Reminders()
    for number in range(1000):
        reminders.add(f"O-{number}", OrderReleased(order=f"O-{number}", items=(), due_s=0.0, release=1), 0.0)
    for number in range(1, 1000):
        assert reminders.answered(OrderTaken(order=f"O-{number}", release=1))
    assert reminders.next_s() == 0.0
    assert [message.order for message in reminders.due(0.0)] == ["O-0"]  # type: ignore[attr-defined]
    assert len(reminders._queue) == 1
    assert reminders.next_s() == PAUSE_S[0]
