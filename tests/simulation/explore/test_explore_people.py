"""People in a run: who presses buttons at random, and who cancels or takes back."""

from __future__ import annotations

import asyncio
from contextlib import suppress
from random import Random

from dray.adapters.security.signing import SigningKey, TrustedKeys
from dray.messages import (
    CancellationTaken,
    CommandAnswered,
    CommandKind,
    Message,
    OrderCancelled,
    OrderItem,
    OrderReleased,
    OrderRevoked,
    OrderTaken,
    RevocationTaken,
    VehicleCommand,
    signed_words,
)
from dray_sim.clock.loop import JUMP, clock, run
from dray_sim.network.sim_network import SimNetwork
from dray_sim.people.demand import Order
from dray_sim.people.random.canceller import Canceller
from dray_sim.people.random.random_operator import RandomOperator
from dray_sim.people.random.revoker import Revocation, Revoker


def test_a_passerby_presses_all_buttons_and_puts_everything_right() -> None:
    said: list[VehicleCommand] = []
    key = SigningKey(bytes(32))
    trusted = TrustedKeys(key.public)

    def grant_of(command: VehicleCommand) -> str:
        grant = command.grant
        if grant is None:
            return "none"
        if not trusted(signed_words("ATV1", command, grant), grant.signature):
            return "forged"
        return "everywhere" if grant.everywhere else "an area"

    async def press() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            assert isinstance(message, VehicleCommand)
            said.append(message)
            # Every other answer is lost.
            if len(said) % 2:
                atv.send(sender, CommandAnswered(command=message.command, done=True))

        atv = network.join("ATV1", answer)
        random_operator = RandomOperator(
            network,
            clock(),
            key,
            fleet=("ATV1",),
            areas=("AREA1", "AREA2"),
            random=Random(1),
            grants=Random(1),
        )
        with suppress(TimeoutError):
            await asyncio.wait_for(random_operator.meddle(), 3600.0)
        # A vehicle is sent to charge by managers, who are not on the floor.
        assert {command.kind for command in said} == set(CommandKind) - {CommandKind.CHARGE}
        assert len({command.command for command in said}) == len(said)
        assert {grant_of(command) for command in said} == {"none", "forged", "everywhere", "an area"}
        said.clear()
        await random_operator.put_right()

    run(press(), JUMP)
    assert {grant_of(command) for command in said} == {"everywhere"}
    once = list(dict.fromkeys((command.command, command.kind, command.speed_frac) for command in said))
    assert [kind for _, kind, _ in once] == [
        CommandKind.SET_SPEED,
        CommandKind.PUT_IN,
        CommandKind.ACKNOWLEDGE,
        CommandKind.RESUME,
    ]
    assert once[0][2] == 1.0


def test_a_cancellation_is_said_until_it_is_heard() -> None:
    heard: list[str] = []

    async def cancel() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            assert isinstance(message, OrderCancelled)
            heard.append(message.order)
            if heard.count(message.order) == 3:
                strategist.send(sender, CancellationTaken(order=message.order))

        strategist = network.join("strategist", answer)
        await Canceller(network, clock()).cancel(((10.0, "D1"), (12.0, "D2")))

    run(cancel(), JUMP)
    assert sorted(heard) == ["D1"] * 3 + ["D2"] * 3


def test_an_order_is_published_again_with_what_the_strategist_says_is_outstanding() -> None:
    """And with what has arrived, which tells another strategist how much was ordered."""

    def again(first: int, second: int, *, release: int) -> OrderReleased:
        items = (OrderItem("P1", first, arrived=6 - first), OrderItem("P2", second, arrived=1 - second))
        return OrderReleased("D1", items, 900.0, release=release)

    said: list[Message] = []

    async def revoke() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            said.append(message)
            # Every other answer is lost.
            if said.count(message) < 2:
                return
            if isinstance(message, OrderRevoked):
                strategist.send(sender, RevocationTaken("D1", message.release, (5 - message.release, 0)))
            elif isinstance(message, OrderReleased):
                strategist.send(sender, OrderTaken(order="D1", release=message.release))

        strategist = network.join("strategist", answer)
        items = (OrderItem("P1", 6), OrderItem("P2", 1))
        order = Order(id="D1", at_s=0.0, items=items, due_s=900.0)
        await Revoker(network, clock()).revoke((Revocation(order, ((10.0, 50.0), (60.0, 70.0))),))
        assert clock().now_s() >= 70.0

    run(revoke(), JUMP)
    assert list(dict.fromkeys(said)) == [
        OrderRevoked("D1", 1),
        again(4, 0, release=2),
        OrderRevoked("D1", 2),
        again(3, 0, release=3),
    ]


def test_an_order_that_was_fulfilled_when_it_is_taken_back_is_not_published_again() -> None:
    said: list[Message] = []

    async def revoke() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            said.append(message)
            strategist.send(sender, RevocationTaken("D1", 1, (0,)))

        strategist = network.join("strategist", answer)
        order = Order(id="D1", at_s=0.0, items=(OrderItem("P1", 6),), due_s=900.0)
        await Revoker(network, clock()).revoke((Revocation(order, ((10.0, 20.0), (30.0, 40.0))),))

    run(revoke(), JUMP)
    assert said == [OrderRevoked("D1", 1)]


def test_an_order_that_is_cancelled_while_it_is_taken_back_is_not_published_again() -> None:
    said: list[Message] = []

    async def revoke() -> None:
        network = SimNetwork(clock(), Random(1))

        def answer(sender: str, message: Message) -> None:
            said.append(message)
            strategist.send(sender, RevocationTaken("D1", 1, (6,)))

        strategist = network.join("strategist", answer)
        order = Order(id="D1", at_s=0.0, items=(OrderItem("P1", 6),), due_s=900.0)
        revoker = Revoker(network, clock(), cancellations=((15.0, "D1"),))
        await revoker.revoke((Revocation(order, ((10.0, 20.0), (30.0, 40.0))),))

    run(revoke(), JUMP)
    assert said == [OrderRevoked("D1", 1)]
