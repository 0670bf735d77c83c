"""Faults of a lean world, drawn from a seed: deaf and dead vehicles, replicas that die or forget, a torn wire."""

from __future__ import annotations

from random import Random

from dray_sim.bench.traffic.run import World

SHORT_S, LONG_S = 3.0, 60.0
"""Shortest and longest fault; durations are uniform on a logarithmic scale."""


def draw_faults(
    world: World, seed: int, *, gap_s: float = 30.0, from_s: float = 20.0, until_s: float
) -> None:
    """Let faults begin as they come, `gap_s` apart on average; all are over by `until_s`."""
    random = Random(f"faults/{seed}")
    kinds = (_deafen, _deafen, _stop, _restart, _kill_replica, _kill_replica, _forget, _tear)
    at_s = from_s
    while (at_s := at_s + random.expovariate(1.0 / gap_s)) < until_s - LONG_S:
        lasts_s = SHORT_S * (LONG_S / SHORT_S) ** random.random()
        random.choice(kinds)(world, random, at_s, lasts_s)


def _deafen(world: World, random: Random, at_s: float, lasts_s: float) -> None:
    """Let a vehicle neither receive nor send."""
    atv = random.choice(sorted(world.pilots))
    world.clock.call_at(at_s, world.air.deaf.add, atv)
    world.clock.call_at(at_s + lasts_s, world.air.deaf.discard, atv)


def _stop(world: World, random: Random, at_s: float, lasts_s: float) -> None:
    """A vehicle is switched off where it is."""
    pilot = world.pilots[random.choice(sorted(world.pilots))]

    def stop() -> None:
        if not pilot.off:
            pilot.die()
            world.clock.call_at(at_s + lasts_s, pilot.revive)

    world.clock.call_at(at_s, stop)


def _restart(world: World, random: Random, at_s: float, _lasts_s: float) -> None:
    """A vehicle's software is started anew, without its memory."""
    pilot = world.pilots[random.choice(sorted(world.pilots))]

    def restart() -> None:
        if not pilot.off:
            pilot.restart()

    world.clock.call_at(at_s, restart)


def _kill_replica(world: World, random: Random, at_s: float, lasts_s: float) -> None:
    """Kill a machine, and restart it with its persisted state."""
    _take_down(world, random, at_s, lasts_s, forget=False)


def _forget(world: World, random: Random, at_s: float, lasts_s: float) -> None:
    """A machine dies, and comes back without its memory."""
    _take_down(world, random, at_s, lasts_s, forget=True)


def _take_down(world: World, random: Random, at_s: float, lasts_s: float, *, forget: bool) -> None:
    machine = world.machines[random.choice(sorted(world.machines))]

    def die() -> None:
        if not machine.off:
            machine.die()
            world.clock.call_at(at_s + lasts_s, lambda: machine.revive(forget=forget))

    world.clock.call_at(at_s, die)


def _tear(world: World, random: Random, at_s: float, lasts_s: float) -> None:
    """The network falls into two parts, machines and vehicles alike."""
    names = sorted((*world.machines, *world.pilots))
    apart = {name for name in names if random.random() < 0.4}

    def tear() -> None:
        world.air.parts = dict.fromkeys(apart, 1)

    def mend() -> None:
        world.air.parts = {}

    world.clock.call_at(at_s, tear)
    world.clock.call_at(at_s + lasts_s, mend)
