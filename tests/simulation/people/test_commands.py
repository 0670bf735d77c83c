"""People in a running factory: what a stop, an acknowledge and a resume do (paper, case 5)."""

from __future__ import annotations

import asyncio
from random import Random

import pytest

from dray.adapters.security.signing import SigningKey
from dray.messages import CommandAnswered, CommandKind, CommandRefusal, Message, VehicleCommand
from dray.plant import default_plant
from dray_sim.checks.invariants import Invariants
from dray_sim.clock.loop import clock, run
from dray_sim.factory.sim_factory import SimFactory
from dray_sim.network.listeners import Listeners
from dray_sim.people import demand
from dray_sim.people.order_client import OrderClient

ANSWER_S = 10.0
"""Virtual: long enough on this network that a missing answer is a fault."""


class Tablet:
    """Somebody who does as the test says."""

    def __init__(self, factory: SimFactory) -> None:
        self._factory = factory
        self._session = factory.bus.join("tablet", self._on_message)
        self._answers: dict[str, asyncio.Future[CommandAnswered]] = {}

    async def order(self, atv: str, kind: CommandKind, speed_frac: float | None = None) -> CommandAnswered:
        name = f"c{len(self._answers)}"
        self._answers[name] = asyncio.get_running_loop().create_future()
        command = VehicleCommand(command=name, kind=kind, speed_frac=speed_frac)
        until_s = self._factory.clock.now_s() + ANSWER_S
        granted = self._factory.authority.grant(
            atv, command, person="tablet", areas=None, valid_until_s=until_s
        )
        self._session.send(atv, granted)
        return await asyncio.wait_for(self._answers[name], ANSWER_S)

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, CommandAnswered):
            self._answers[message.command].set_result(message)


async def _stop_everybody_once(seed: int) -> tuple[Invariants, int]:
    listeners = Listeners()
    plant = default_plant()
    factory = SimFactory(plant, clock(), seed=seed, listener=listeners)
    checks = Invariants(factory)
    listeners.add(checks)
    orders = demand.orders(plant, Random(seed), load=0.9, until_s=3600.0)
    chance, tablet = Random(seed), Tablet(factory)
    stops = 0
    async with asyncio.TaskGroup() as group:
        life = group.create_task(factory.run())
        customers = group.create_task(OrderClient(factory.bus, factory.clock).place(orders))
        await asyncio.sleep(300.0)
        for atv in list(factory.vehicles) * 3:
            assert (await tablet.order(atv, CommandKind.STOP)).done
            await asyncio.sleep(chance.uniform(0.0, 60.0))
            early = await tablet.order(atv, CommandKind.RESUME)
            assert not early.done
            assert "acknowledge" in early.reason
            await asyncio.sleep(chance.uniform(0.0, 30.0))
            assert (await tablet.order(atv, CommandKind.ACKNOWLEDGE)).done
            await asyncio.sleep(chance.uniform(0.0, 30.0))
            assert (await tablet.order(atv, CommandKind.RESUME)).done
            assert (await tablet.order(atv, CommandKind.SET_SPEED, chance.uniform(0.3, 1.0))).done
            stops += 1
        await asyncio.sleep(600.0)
        life.cancel()
        customers.cancel()
    checks.check_end(factory.clock.now_s())
    return checks, stops


@pytest.mark.slow
def test_stops_in_the_middle_of_everything_break_nothing() -> None:
    checks, stops = run(_stop_everybody_once(seed=3))
    assert stops == 24
    assert checks.broken is None


def test_a_speed_of_nothing_is_refused() -> None:
    async def main() -> CommandAnswered:
        factory = SimFactory(default_plant(), clock(), seed=1)
        tablet = Tablet(factory)
        life = asyncio.create_task(factory.run())
        await asyncio.sleep(1.0)
        answer = await tablet.order("ATV1", CommandKind.SET_SPEED, 0.0)
        life.cancel()
        return answer

    answer = run(main())
    assert not answer.done
    assert answer.reason is CommandRefusal.SPEED_OUT_OF_RANGE


# --- past the gateway, on the bus itself -------------------------------------------------------------


async def _answer_to(areas: tuple[str, ...] | None, key: SigningKey | None) -> tuple[CommandAnswered, bool]:
    """What a vehicle in AREA2 answers to a stop, and whether it is held then.

    Args:
        areas: for which the stop is granted; None for no grant at all.
        key: who has signed the grant; None for the plant's own authority.
    """
    factory = SimFactory(default_plant(), clock(), seed=1)
    answers: asyncio.Queue[Message] = asyncio.Queue()
    session = factory.bus.join("somebody", lambda _sender, message: answers.put_nowait(message))
    life = asyncio.create_task(factory.run())
    await asyncio.sleep(1.0)
    stop = VehicleCommand(command="c1", kind=CommandKind.STOP, issued_by="the manager")
    if areas is not None:
        until_s = factory.clock.now_s() + ANSWER_S
        stop = (key or factory.authority).grant(
            "ATV1", stop, person="manager", areas=areas, valid_until_s=until_s
        )
    session.send("ATV1", stop)
    answer = await asyncio.wait_for(answers.get(), ANSWER_S)
    held = factory.vehicles["ATV1"].sense().held
    life.cancel()
    assert isinstance(answer, CommandAnswered)
    return answer, held


def test_a_granted_command_needs_no_gateway() -> None:
    answer, held = run(_answer_to(("AREA2",), None))
    assert (answer.done, held) == (True, True)


@pytest.mark.parametrize(
    ("areas", "key", "why"),
    [
        (None, None, CommandRefusal.NOT_GRANTED),
        (("AREA4",), None, CommandRefusal.NOT_HERE),
        ((), None, CommandRefusal.NOT_HERE),
        (("AREA2",), SigningKey(bytes(32)), CommandRefusal.NOT_TRUSTED),
    ],
    ids=["bare", "for another area", "for no area", "forged"],
)
def test_what_was_not_granted_for_here_moves_nothing(
    areas: tuple[str, ...] | None, key: SigningKey | None, why: str
) -> None:
    answer, held = run(_answer_to(areas, key))
    assert (answer.done, answer.reason, held) == (False, why, False)
