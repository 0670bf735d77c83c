"""The simulated WLAN: links in trouble, networks that have fallen apart, and agents that are cut off."""

from __future__ import annotations

import asyncio
from random import Random

import pytest

from dray.messages import Message, OrderTaken, Pose
from dray_sim.clock.loop import clock, run
from dray_sim.faults import LinkTrouble, NetworkFault, Partition, RadioCut, WlanCut
from dray_sim.network.latency import WLAN, Latency
from dray_sim.network.sim_network import NO_WLAN, SimNetwork, SimSession
from dray_sim.network.wlan import APART, HELD_UP_S, LOST

NO_DELAY = Latency(base_s=0.0, mean_extra_s=0.0, cap_s=0.0)
HERE = Pose(0.0, 0.0, 0.0)


def say(order: object) -> OrderTaken:
    return OrderTaken(order=str(order))


# --- links in trouble ------------------------------------------------------------------------------

NUMBERS = 4000
"""Messages in a statistic: a share of 0.2 then lies within 0.02 of what is expected, three times in a thousand not."""


class Talk:
    """Two agents, A who talks and B who listens, and what has become of it."""

    def __init__(self, *faults: NetworkFault, latency: Latency = NO_DELAY, seed: int = 1) -> None:
        self.network = SimNetwork(clock(), Random(seed), latency, chance=Random(seed))
        self.arrivals: list[tuple[float, int]] = []
        self.network.join("B", self._on_message).subscribe("p/k")
        self.session = self.network.join("A", lambda *_: None)
        for fault in faults:
            self.network.begin(fault)

    def _on_message(self, _sender: str, message: Message) -> None:
        assert isinstance(message, OrderTaken)
        self.arrivals.append((clock().now_s(), int(message.order)))

    async def say(self, count: int = NUMBERS, gap_s: float = 0.1) -> list[int]:
        """Say the numbers, every other one published; which arrived, in the order of arrival."""
        for number in range(count):
            if number % 2:
                self.session.publish("p/k", say(number))
            else:
                self.session.send("B", say(number))
            await asyncio.sleep(gap_s)
        await asyncio.sleep(20.0)
        return [number for _, number in self.arrivals]


def test_a_fault_that_has_ended_leaves_no_trace_behind() -> None:
    async def main(faulty: bool) -> list[float]:
        talk = Talk(latency=WLAN)
        if faulty:
            for fault in (WlanCut("C"), LinkTrouble(loss_frac=0.5, jitter_s=1.0), Partition((("A",),))):
                talk.network.begin(fault)
                talk.network.end(fault)
        await talk.say(100)
        return [at_s for at_s, _ in talk.arrivals]

    assert run(main(True)) == run(main(False))


def test_a_fault_shifts_no_chance_of_the_links_that_it_does_not_touch() -> None:
    async def main(*faults: NetworkFault) -> list[float]:
        talk = Talk(*faults, latency=WLAN)
        await talk.say(100)
        return [at_s for at_s, _ in talk.arrivals]

    elsewhere = (LinkTrouble(sender="X*", loss_frac=1.0), WlanCut("Y"), Partition((("Z",),)), RadioCut("A"))
    assert run(main(*elsewhere)) == run(main())


def test_a_lossy_link_loses_its_share() -> None:
    async def main() -> None:
        talk = Talk(LinkTrouble(sender="A", receiver="B", loss_frac=0.2))
        arrived = await talk.say()
        assert 1.0 - len(arrived) / NUMBERS == pytest.approx(0.2, abs=0.02)
        assert arrived == sorted(set(arrived))
        assert talk.network.lost == {LOST: NUMBERS - len(arrived)}

    run(main())


def test_two_lossy_troubles_of_one_link_add_up() -> None:
    async def main() -> None:
        talk = Talk(LinkTrouble(sender="A", loss_frac=0.3), LinkTrouble(receiver="*", loss_frac=0.4))
        arrived = await talk.say()
        assert len(arrived) / NUMBERS == pytest.approx(0.7 * 0.6, abs=0.025)

    run(main())


@pytest.mark.parametrize(
    ("sender", "receiver", "strikes"),
    [
        ("A", "B", True),
        ("*", "*", True),
        ("A*", "*B", True),
        ("*A*", "B", True),
        ("B", "A", False),
        ("a", "B", False),
        ("AA*", "B", False),
        (".", "B", False),
        ("[A]", "B", False),
    ],
)
def test_a_pattern_names_the_links_that_suffer(sender: str, receiver: str, strikes: bool) -> None:
    async def main() -> None:
        arrived = await Talk(LinkTrouble(sender=sender, receiver=receiver, loss_frac=1.0)).say(4)
        assert arrived == ([] if strikes else [0, 1, 2, 3])

    run(main())


def test_latency_and_jitter_delay_and_keep_the_order() -> None:
    async def main() -> None:
        talk = Talk(LinkTrouble(latency_s=2.0, jitter_s=1.0))
        arrived = await talk.say(gap_s=2.0)
        delays_s = [at_s - 2.0 * number for at_s, number in talk.arrivals]
        assert arrived == list(range(NUMBERS))
        assert all(2.0 <= delay_s <= 3.0 for delay_s in delays_s)
        assert sum(delays_s) / NUMBERS == pytest.approx(2.5, abs=0.02)

    run(main())


def test_jitter_beyond_the_gap_between_messages_keeps_the_order_too() -> None:
    async def main() -> None:
        assert await Talk(LinkTrouble(jitter_s=3.0)).say(500) == list(range(500))

    run(main())


def test_a_doubling_link_delivers_its_share_twice_and_the_first_copy_in_order() -> None:
    async def main() -> None:
        talk = Talk(LinkTrouble(duplicate_frac=0.2))
        arrived = await talk.say()
        assert (len(arrived) - NUMBERS) / NUMBERS == pytest.approx(0.2, abs=0.02)
        assert talk.network.wlan.doubled == len(arrived) - NUMBERS
        firsts = list(dict.fromkeys(arrived))
        assert firsts == list(range(NUMBERS))

    run(main())


def test_a_reordering_link_lets_later_messages_overtake_and_loses_none() -> None:
    async def main() -> None:
        talk = Talk(LinkTrouble(reorder_frac=0.2))
        arrived = await talk.say()
        late = [at_s - 0.1 * number for at_s, number in talk.arrivals if at_s > 0.1 * number + 0.05]
        assert sorted(arrived) == list(range(NUMBERS))
        assert arrived != sorted(arrived)
        assert talk.network.wlan.held_up / NUMBERS == pytest.approx(0.2, abs=0.02)
        assert max(late) <= HELD_UP_S + 0.01

    run(main())


def test_an_agents_own_words_reach_itself_whatever_is_wrong() -> None:
    async def main() -> None:
        faults = (LinkTrouble(loss_frac=1.0), WlanCut("A"), Partition((("A",), ("B",))))
        network = SimNetwork(clock(), Random(1))
        network.equip("A", lambda: HERE, lambda *_: None)
        heard: list[str] = []
        session = network.join("A", lambda sender, _: heard.append(sender))
        session.subscribe("p/k")
        for fault in faults:
            network.begin(fault)
        session.publish("p/k", say(1))
        session.send("A", say(2))
        await asyncio.sleep(10.0)
        assert heard == ["A", "A"]

    run(main())


# --- partitions ------------------------------------------------------------------------------------


def groups_of(*faults: Partition) -> list[str]:
    """Who hears A1, A2, B1, B2 and C, each as a row of names."""

    async def main() -> list[str]:
        network = SimNetwork(clock(), Random(1))
        heard: dict[str, list[str]] = {name: [] for name in ("A1", "A2", "B1", "B2", "C")}

        def join(name: str) -> SimSession:
            session = network.join(name, lambda sender, _: heard[sender].append(name))
            session.subscribe("p/k")
            return session

        sessions = [join(name) for name in heard]
        for fault in faults:
            network.begin(fault)
        for session in sessions:
            session.publish("p/k", say(1))
        await asyncio.sleep(1.0)
        return [" ".join(sorted(names)) for names in heard.values()]

    return run(main())


def test_only_agents_of_one_group_hear_one_another_and_the_unnamed_are_one_more() -> None:
    assert groups_of(Partition((("A1", "B1"),))) == ["A1 B1", "A2 B2 C", "A1 B1", "A2 B2 C", "A2 B2 C"]
    assert groups_of(Partition((("A*",), ("B*",)))) == ["A1 A2", "A1 A2", "B1 B2", "B1 B2", "C"]


def test_an_agent_is_in_the_first_group_that_names_it() -> None:
    assert groups_of(Partition((("A1",), ("A*", "C")))) == ["A1", "A2 C", "B1 B2", "B1 B2", "A2 C"]


def test_two_partitions_cut_both_ways() -> None:
    both = groups_of(Partition((("A*",),)), Partition((("*1",),)))
    assert both == ["A1", "A2", "B1", "B2 C", "B2 C"]


def test_a_partition_is_counted_and_can_be_healed() -> None:
    async def main() -> None:
        apart = Partition((("A",),))
        talk = Talk(apart)
        assert await talk.say(4) == []
        assert talk.network.lost == {APART: 4}
        talk.network.end(apart)
        assert await talk.say(2) == [0, 1]

    run(main())


# --- WLAN, switched --------------------------------------------------------------------------------


def test_a_wired_agent_whose_cable_is_pulled_is_neither_heard_nor_hears() -> None:
    for cut in ("A", "B"):

        async def main(cut: str = cut) -> None:
            talk = Talk(WlanCut(cut))
            assert await talk.say(4) == []
            assert talk.network.lost == {NO_WLAN: 4}
            talk.network.end(WlanCut(cut))
            assert await talk.say(2) == [0, 1]

        run(main())


def test_the_same_fault_begun_twice_must_end_twice() -> None:
    async def main() -> None:
        talk = Talk(WlanCut("A"), WlanCut("A"))
        talk.network.end(WlanCut("A"))
        assert await talk.say(2) == []
        talk.network.end(WlanCut("A"))
        assert await talk.say(2) == [0, 1]
        with pytest.raises(ValueError, match="not in list"):
            talk.network.end(WlanCut("A"))

    run(main())


def test_what_is_under_way_when_a_link_fails_still_arrives() -> None:
    async def main() -> None:
        talk = Talk(latency=Latency(base_s=1.0, mean_extra_s=0.0, cap_s=1.0))
        talk.session.send("B", say(1))
        talk.network.begin(WlanCut("A"))
        talk.network.begin(LinkTrouble(loss_frac=1.0))
        await asyncio.sleep(2.0)
        assert talk.arrivals == [(1.0, 1)]

    run(main())


def test_what_a_person_has_plugged_in_stays_so_when_the_fault_ends() -> None:
    async def main() -> None:
        network = SimNetwork(clock(), Random(1), NO_DELAY)
        cut = WlanCut("A")
        network.begin(cut)
        network.begin(cut)
        assert network.plug_in("A")
        assert not network.plug_in("A"), "nothing is left to be put right"
        network.end(cut)
        network.end(cut)
        with pytest.raises(ValueError, match="not in list"):
            network.end(cut)

    run(main())
