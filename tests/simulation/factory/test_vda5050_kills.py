"""Kills and restarts of agents, vehicles and brokers behind a proxy that spoils messages: all work is done, and once."""

from __future__ import annotations

import json
from itertools import pairwise
from random import Random

import pytest

from dray.plant import default_plant
from dray_sim.clock.loop import VirtualClock
from dray_sim.vda5050.kills import Outcome, play
from dray_sim.vda5050.proxy import LATEST_S, Proxy

KILLS = 60
"""`dray sim vehicles --kills 200` plays more; its figures are in docs/vehicles.md."""


@pytest.mark.campaign
# 2: a vehicle loses its power on a lane, near the node behind it, and its agent its memory. 4: an order whose horizon is left.
@pytest.mark.parametrize(("seed", "traffic"), [(2, True), (4, True)])
def test_every_task_is_delivered_once_and_no_action_is_carried_out_twice(seed: int, traffic: bool) -> None:
    outcome = play(default_plant(), seed, KILLS, traffic=traffic)
    assert outcome.failures == []
    assert sum(outcome.kills.values()) == KILLS
    assert outcome.outcomes["delivered"] >= 15
    assert outcome.actions >= 30
    assert all(
        outcome.messages[what] for what in ("dropped", "doubled", "delayed", "spoilt", "lost with a broker")
    )


def passed(seed: int, count: int) -> tuple[list[bytes], Proxy]:
    time, heard = VirtualClock(), list[bytes]()
    proxy = Proxy(time, Random(seed))
    for number in range(count):
        time.call_at(
            0.1 * number, lambda number=number: proxy.carry("A", b'{"number": %d}' % number, heard.append)
        )
    while time.heap:
        time.time_s, _, callback, args = min(time.heap)
        time.heap.remove(min(time.heap))
        callback(*args)
    return heard, proxy


def test_a_proxy_does_all_of_it_and_the_same_by_the_same_seed() -> None:
    heard, proxy = passed(7, 2000)
    assert passed(7, 2000)[0] == heard
    assert len(heard) == 2000 - proxy.did["dropped"] + proxy.did["doubled"]
    read = []
    for data in heard:
        try:
            read.append(json.loads(data)["number"])
        except ValueError:
            continue
    # What is spoilt is never another message that can be read.
    assert set(read) <= set(range(2000))
    assert read != sorted(read)
    assert max(before - after for before, after in pairwise(read)) <= LATEST_S / 0.1 + 1
    assert len(heard) - len(read) >= proxy.did["spoilt"] > 0


def test_what_has_not_held_is_named() -> None:
    outcome = Outcome(opened={"t1", "t2"}, closed={"t1": ["delivered"]}, twice=["a7"], broken="invariant 3")
    assert outcome.failures == ["invariant 3", "action a7 was carried out twice", "task t2 has not ended"]
