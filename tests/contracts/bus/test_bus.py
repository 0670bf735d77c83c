"""The conformance suite of `dray.ports.Bus`: every bus delivers, in order, to whoever listens, and knows who comes and goes."""

from __future__ import annotations

import pytest
from buses import World

from dray.messages import Message, OrderTaken
from dray.ports import Session


class Peer:
    """An agent that remembers what it has heard, as (sender, order)."""

    def __init__(self, world: World, name: str, *subscriptions: str, life: int = 0) -> None:
        self.heard: list[tuple[str, str]] = []
        self.session: Session = world.bus.join(name, self._receive, life)
        for key in subscriptions:
            self.session.subscribe(key)

    def _receive(self, sender: str, message: Message) -> None:
        assert isinstance(message, OrderTaken)
        self.heard.append((sender, message.order))


def say(order: int | str) -> OrderTaken:
    return OrderTaken(order=str(order))


# --- delivery ---------------------------------------------------------------------------------------


async def test_a_publication_reaches_all_that_listen_on_its_key(world: World) -> None:
    first, second, other = Peer(world, "A", "p/k"), Peer(world, "B", "p/k"), Peer(world, "C", "p/other")
    speaker = Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    await world.settle()
    assert first.heard == second.heard == [("S", "1")]
    assert other.heard == speaker.heard == []


@pytest.mark.parametrize(
    ("pattern", "key", "matches"),
    [
        ("p/hb/atv/A1", "p/hb/atv/A1", True),
        ("p/hb/atv/A1", "p/hb/atv/A11", False),
        ("p/hb/atv/A1", "p/hb/atv", False),
        ("p/event/*", "p/event/M1", True),
        ("p/event/*", "p/event/M1/x", False),
        ("p/event/*", "p/event", False),
        ("p/*/atv", "p/hb/atv", True),
        ("p/*/atv", "p/hb/machine", False),
        ("p/hb/**", "p/hb/atv/A1", True),
        ("p/hb/**", "p/hb/machine/M1", True),
        ("p/hb/**", "p/hb", True),
        ("p/hb/**", "p/hbx/atv", False),
        ("p/**/A1", "p/A1", True),
        ("p/**/A1", "p/hb/atv/A1", True),
        ("p/**/A1", "p/hb/atv/A2", False),
        ("**", "p/hb/atv/A1", True),
        ("p.q/*", "p.q/a", True),
        ("p.q/*", "pxq/a", False),
    ],
)
async def test_one_star_is_one_chunk_and_two_are_any_number(
    world: World, pattern: str, key: str, matches: bool
) -> None:
    own = key.rpartition("/")[2]  # Some keys are one agent's alone.
    listener, speaker = Peer(world, "L", pattern), Peer(world, own)
    await world.settle()
    speaker.session.publish(key, say(1))
    await world.settle()
    assert listener.heard == ([(own, "1")] if matches else [])


async def test_what_is_sent_reaches_one_agent_alone(world: World) -> None:
    receiver, eavesdropper = Peer(world, "A"), Peer(world, "B", "**", "p/agent/A")
    speaker = Peer(world, "S")
    await world.settle()
    speaker.session.send("A", say(1))
    await world.settle()
    assert receiver.heard == [("S", "1")]
    assert eavesdropper.heard == []


async def test_sending_to_an_unknown_agent_is_silence(world: World) -> None:
    speaker = Peer(world, "S")
    speaker.session.send("nobody", say(1))
    await world.settle()
    assert speaker.heard == []


async def test_an_agent_hears_itself_when_it_subscribes(world: World) -> None:
    deaf, listening = Peer(world, "A"), Peer(world, "B", "p/k")
    await world.settle()
    deaf.session.publish("p/k", say(1))
    listening.session.publish("p/k", say(2))
    await world.settle()
    assert deaf.heard == []
    assert sorted(listening.heard) == [("A", "1"), ("B", "2")]


async def test_nothing_is_received_inside_a_call(world: World) -> None:
    peer = Peer(world, "A", "p/k")
    await world.settle()
    peer.session.publish("p/k", say(1))
    peer.session.send("A", say(2))
    assert peer.heard == []
    await world.settle()
    assert len(peer.heard) == 2


async def test_a_message_arrives_as_it_was_said(world: World) -> None:
    heard: list[Message] = []
    world.bus.join("A", lambda _, message: heard.append(message))
    speaker = Peer(world, "S")
    await world.settle()
    speaker.session.send("A", say("o-7"))
    await world.settle()
    assert heard == [say("o-7")]


# --- order ------------------------------------------------------------------------------------------


async def test_publications_of_one_agent_arrive_in_the_order_said(world: World) -> None:
    listeners = [Peer(world, "A", "p/k"), Peer(world, "B", "p/*")]
    speaker = Peer(world, "S")
    await world.settle()
    for number in range(300):
        speaker.session.publish("p/k", say(number))
    await world.settle()
    for listener in listeners:
        assert listener.heard == [("S", str(number)) for number in range(300)]


async def test_what_one_agent_sends_to_another_arrives_in_the_order_said(world: World) -> None:
    receiver, speakers = Peer(world, "A"), [Peer(world, "S"), Peer(world, "T")]
    await world.settle()
    for number in range(300):
        for speaker in speakers:
            speaker.session.send("A", say(number))
    await world.settle()
    for name in ("S", "T"):
        assert [order for sender, order in receiver.heard if sender == name] == [str(n) for n in range(300)]


# --- subscriptions ----------------------------------------------------------------------------------


async def test_subscribing_twice_is_once(world: World) -> None:
    listener, speaker = Peer(world, "A", "p/k", "p/k", "p/x/*", "p/x/*"), Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    speaker.session.publish("p/x/y", say(2))
    await world.settle()
    assert sorted(listener.heard) == [("S", "1"), ("S", "2")]
    listener.session.unsubscribe("p/k")
    await world.settle()
    speaker.session.publish("p/k", say(3))
    await world.settle()
    assert len(listener.heard) == 2


async def test_a_subscription_begins_when_it_is_made(world: World) -> None:
    listener, speaker = Peer(world, "A"), Peer(world, "S")
    speaker.session.publish("p/k", say(1))
    await world.settle()
    listener.session.subscribe("p/k")
    await world.settle()
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert listener.heard == [("S", "2")]


@pytest.mark.parametrize("pattern", ["p/k", "p/*", "**"])
async def test_an_unsubscribed_agent_hears_it_no_longer(world: World, pattern: str) -> None:
    leaving, staying, speaker = Peer(world, "A", pattern), Peer(world, "B", pattern), Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    await world.settle()
    leaving.session.unsubscribe(pattern)
    leaving.session.unsubscribe("p/never/subscribed")
    await world.settle()
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert leaving.heard == [("S", "1")]
    assert staying.heard == [("S", "1"), ("S", "2")]


# --- coming and going -------------------------------------------------------------------------------


async def test_nothing_is_received_after_leaving_not_even_what_is_under_way(world: World) -> None:
    leaving, staying, speaker = Peer(world, "A", "p/k"), Peer(world, "B", "p/k"), Peer(world, "S")
    await world.settle()
    speaker.session.publish("p/k", say(1))
    speaker.session.send("A", say(2))
    leaving.session.leave()
    await world.settle()
    speaker.session.send("A", say(3))
    await world.settle()
    assert leaving.heard == []
    assert staying.heard == [("S", "1")]


async def test_who_has_left_says_nothing_any_more_and_may_leave_twice(world: World) -> None:
    listener, leaving = Peer(world, "A", "p/k"), Peer(world, "S")
    await world.settle()
    leaving.session.leave()
    leaving.session.leave()
    leaving.session.publish("p/k", say(1))
    leaving.session.send("A", say(2))
    leaving.session.subscribe("p/k")
    leaving.session.unsubscribe("p/k")
    await world.settle()
    assert listener.heard == leaving.heard == []


async def test_a_later_life_replaces_an_earlier_one(world: World) -> None:
    before, speaker = Peer(world, "A", "p/k", life=1), Peer(world, "S")
    await world.settle()
    after = Peer(world, "A", life=2)
    await world.settle()
    speaker.session.send("A", say(1))
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert before.heard == []
    assert after.heard == [("S", "1")]


async def test_later_lives_are_reached_from_where_earlier_ones_were(world: World) -> None:
    """Where there are three sessions, every fourth agent is in the first one again."""
    first, _, _, speaker = Peer(world, "A", life=1), Peer(world, "B"), Peer(world, "C"), Peer(world, "S")
    await world.settle()
    second, other = Peer(world, "A", life=2), Peer(world, "T")
    await world.settle()
    speaker.session.send("A", say(1))
    other.session.send("A", say(2))
    await world.settle()
    assert sorted(second.heard) == [("S", "1"), ("T", "2")]
    third = Peer(world, "A", life=3)
    await world.settle()
    speaker.session.send("A", say(3))
    other.session.send("A", say(4))
    await world.settle()
    assert sorted(third.heard) == [("S", "3"), ("T", "4")]
    assert first.heard == []
    assert len(second.heard) == 2


async def test_an_earlier_life_that_joins_late_is_nobody(world: World) -> None:
    late, speaker = Peer(world, "A", life=2), Peer(world, "S")
    await world.settle()
    early = Peer(world, "A", "p/k", life=1)
    await world.settle()
    early.session.send("S", say("of the dead"))
    speaker.session.send("A", say(1))
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert early.heard == speaker.heard == []
    assert late.heard == [("S", "1")]


async def test_the_end_of_a_replaced_session_does_not_touch_its_successor(world: World) -> None:
    before, speaker = Peer(world, "A", life=1), Peer(world, "S")
    after = Peer(world, "A", "p/k", life=2)
    before.session.leave()
    await world.settle()
    speaker.session.send("A", say(1))
    speaker.session.publish("p/k", say(2))
    await world.settle()
    assert before.heard == []
    assert sorted(after.heard) == [("S", "1"), ("S", "2")]


async def test_many_agents_may_come_and_go(world: World) -> None:
    speaker = Peer(world, "S")
    for round_number in range(20):
        peers = [Peer(world, f"A{number}", "p/k", life=round_number + 1) for number in range(10)]
        await world.settle()
        speaker.session.publish("p/k", say(round_number))
        await world.settle()
        assert all(peer.heard == [("S", str(round_number))] for peer in peers)
        for peer in peers[::2]:
            peer.session.leave()
