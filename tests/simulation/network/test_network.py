"""The simulated network, beyond what every bus promises: chance, order, counts and the trace."""

from __future__ import annotations

import asyncio
from random import Random

import pytest
from hash_seeds import printed_by_each

from dray.errors import ProtocolViolation
from dray.messages import Handover, Message, OrderTaken
from dray_sim.clock.loop import clock, run
from dray_sim.network import subscriptions
from dray_sim.network.latency import WLAN, Latency
from dray_sim.network.sim_network import SimNetwork
from dray_sim.run.trace import Trace

NO_DELAY = Latency(base_s=0.0, mean_extra_s=0.0, cap_s=0.0)


def say(order: object) -> OrderTaken:
    return OrderTaken(order=str(order))


async def gossip(seed: int, *, codec: bool = False) -> Trace:
    """Agents that answer one another at random for a while: who speaks next hangs on every delay."""
    trace = Trace(tail=50)
    network = SimNetwork(clock(), Random(seed), codec=codec, trace=trace)
    names = [f"A{number}" for number in range(8)]
    chance = Random(0)

    def join(name: str) -> None:
        def receive(sender: str, message: Message) -> None:
            if not isinstance(message, OrderTaken) or clock().now_s() > 2.0:
                return
            session.send(chance.choice([sender, *names]), say(f"{name}.{message.order[:20]}"))
            if chance.random() < 0.3:
                session.publish(f"p/{chance.randrange(4)}", Handover(name, 1, chance.randrange(100)))

        session = network.join(name, receive)
        session.subscribe("p/*" if name < "A3" else f"p/{name[1]}")

    for name in names:
        join(name)
    starter = network.join("S", lambda *_: None)
    for name in names:
        starter.send(name, say("start"))
    await asyncio.sleep(3.0)
    return trace


# --- one seed, one run -----------------------------------------------------------------------------


def test_one_seed_gives_one_run_and_another_seed_another() -> None:
    first, second, other = (run(gossip(seed)) for seed in (1, 1, 2))
    assert sum(first.counts.values()) > 200
    assert first.hexdigest() == second.hexdigest() != other.hexdigest()
    assert list(first.tail) == list(second.tail)


def test_the_wire_format_changes_nothing() -> None:
    assert run(gossip(3)).hexdigest() == run(gossip(3, codec=True)).hexdigest()


def test_a_run_does_not_hang_on_the_hash_seed_of_the_process() -> None:
    script = (
        "import asyncio, importlib.util, sys;"
        "spec = importlib.util.spec_from_file_location('story', sys.argv[1]);"
        "story = importlib.util.module_from_spec(spec); spec.loader.exec_module(story);"
        "print(story.run(story.gossip(5)).hexdigest())"
    )
    assert printed_by_each(script, __file__) == {run(gossip(5)).hexdigest() + "\n"}


def test_a_run_without_faults_draws_the_chances_that_it_always_drew() -> None:
    # Taken before the network could fail. It changes when what is said does, not when faults do.
    assert run(gossip(4)).hexdigest() == "b71ce970e5ebacdefbba7b0855702657"


# --- delays ----------------------------------------------------------------------------------------


def test_delays_are_a_base_and_an_exponential_part_under_a_cap() -> None:
    delays_s = WLAN.quantiles()
    assert delays_s == sorted(delays_s)
    assert delays_s[0] == pytest.approx(WLAN.base_s, abs=1e-5)
    assert sum(delays_s) / len(delays_s) == pytest.approx(WLAN.base_s + WLAN.mean_extra_s, rel=0.01)
    short_cap = Latency(base_s=0.005, mean_extra_s=0.015, cap_s=0.02)
    assert max(short_cap.quantiles()) == 0.02


def test_every_receiver_of_a_publication_has_a_delay_of_its_own() -> None:
    async def main() -> dict[str, float]:
        network = SimNetwork(clock(), Random(1))
        arrivals_s: dict[str, float] = {}
        for name in "ABCDEFGH":
            session = network.join(name, lambda *_, name=name: arrivals_s.update({name: clock().now_s()}))
            session.subscribe("p/k")
        network.join("S", lambda *_: None).publish("p/k", say(1))
        await asyncio.sleep(1.0)
        return arrivals_s

    arrivals_s = run(main())
    assert len(set(arrivals_s.values())) == 8
    assert all(WLAN.base_s < at_s <= WLAN.cap_s for at_s in arrivals_s.values())


# --- order and routes ------------------------------------------------------------------------------


def test_receivers_hear_in_the_order_of_joining_however_they_subscribed() -> None:
    async def main() -> str:
        network = SimNetwork(clock(), Random(1), NO_DELAY)
        heard: list[str] = []
        sessions = {name: network.join(name, lambda *_, name=name: heard.append(name)) for name in "ABCD"}
        for name, key in (("D", "p/k"), ("B", "**"), ("C", "p/*"), ("A", "p/k")):
            sessions[name].subscribe(key)
        sessions["A"].publish("p/k", say(1))
        await asyncio.sleep(1.0)
        return "".join(heard)

    assert run(main()) == "ABCD"


def test_overlapping_subscriptions_hear_once() -> None:
    async def main() -> int:
        network = SimNetwork(clock(), Random(1))
        heard: list[str] = []
        session = network.join("A", lambda sender, _: heard.append(sender))
        for key in ("p/k", "p/*", "**"):
            session.subscribe(key)
        session.publish("p/k", say(1))
        await asyncio.sleep(1.0)
        return len(heard)

    assert run(main()) == 1


def test_publishing_on_a_wildcard_is_our_own_bug() -> None:
    async def main() -> None:
        network = SimNetwork(clock(), Random(1))
        with pytest.raises(ProtocolViolation, match=r"'p/\*'"):
            network.join("A", lambda *_: None).publish("p/*", say(1))

    run(main())


def test_no_more_keys_are_remembered_than_the_bound(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(subscriptions, "MAX_KEYS", 10)

    async def main() -> int:
        network = SimNetwork(clock(), Random(1))
        heard: list[str] = []
        session = network.join("A", lambda sender, _: heard.append(sender))
        session.subscribe("p/**")
        for number in range(100):
            session.publish(f"p/{number}", say(number))
            assert len(network._subscriptions.found) <= 10
        await asyncio.sleep(1.0)
        return len(heard)

    assert run(main()) == 100


def test_who_leaves_leaves_nothing_behind() -> None:
    async def main() -> None:
        network = SimNetwork(clock(), Random(1))
        session = network.join("A", lambda *_: None)
        for key in ("p/k", "p/*", "**"):
            session.subscribe(key)
        session.leave()
        assert not network._subscriptions
        assert not network._sessions

    run(main())


def test_deliveries_and_misses_are_counted() -> None:
    async def main() -> None:
        network = SimNetwork(clock(), Random(1))
        receiver, leaving = (network.join(name, lambda *_: None) for name in "AB")
        receiver.send("A", say("arrives"))
        receiver.send("nobody", say("finds nobody"))
        receiver.send("B", say("arrives too late"))
        leaving.leave()
        leaving.send("A", say("is not said any more"))
        await asyncio.sleep(1.0)
        assert (network.delivered, network.missed) == (1, 3)

    run(main())


# --- the trace -------------------------------------------------------------------------------------


def test_the_trace_tells_apart_when_who_to_whom_and_what() -> None:
    utterances = [
        (1.0, "A", "p/k", say(1)),
        (1.5, "A", "p/k", say(1)),
        (1.0, "B", "p/k", say(1)),
        (1.0, "A", "p/kk", say(1)),
        (1.0, "A", ">p/k", say(1)),
        (1.0, "A", "p/k", say(2)),
    ]
    digests = set()
    for utterance in utterances:
        trace = Trace()
        trace.on_message(*utterance)
        digests.add(trace.hexdigest())
    assert len(digests) == len(utterances)


def test_the_trace_keeps_the_last_utterances_and_counts_all() -> None:
    trace = Trace(tail=2)
    for number in range(3):
        trace.on_message(number / 2, "A", ">B", say(number))
    trace.on_message(2.0, "B", "p/k", Handover("t", 1, 5))
    assert [str(utterance) for utterance in trace.tail] == [
        "    1.000000 s  A >B  OrderTaken(order='2', release=1, fulfilled=False, change=0, quantities=())",
        "    2.000000 s  B p/k  Handover(task='t', epoch=1, quantity=5)",
    ]
    assert trace.counts_by_name() == {"OrderTaken": 3, "Handover": 1}


def test_a_message_is_traced_though_nobody_listens() -> None:
    async def main() -> Trace:
        trace = Trace()
        network = SimNetwork(clock(), Random(1), trace=trace)
        network.join("A", lambda *_: None).publish("p/k", say(1))
        return trace

    assert run(main()).counts == {OrderTaken: 1}
