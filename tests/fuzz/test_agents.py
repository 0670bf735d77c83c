"""No message ends an agent (invariant 8): whatever the codec lets through, in whatever situation.

After every message the agent must still be alive, must not spin, must not answer with an avalanche, and must
say nothing that its peers could not read.
"""

from __future__ import annotations

from collections.abc import Callable

import pytest
from examples import examples
from hypothesis import given, settings
from hypothesis import strategies as st
from situations import NAMES, SITUATIONS, Played
from utterances import MESSAGE_TYPES, Utterances
from variants import variants

from dray.codec import decode, encode
from dray.errors import WireError
from dray.messages import Event, Message
from dray.protocol.runtime.events import Effect, Publish, Record, Send
from dray.protocol.runtime.shutdown import CARRIER_LEAVES_WITHIN_S

# What a test hands to Hypothesis inside of itself is not seen from without.
pytestmark = pytest.mark.hypothesis

UTTERANCES = Utterances(NAMES)

SETTLE_S = 40.0
"""After the talk: longer than every question is repeated, every watch lasts and every dwell point is sought."""

MOST_EFFECTS = 400
"""Of one event: a machine that announces for every buffer to every cell of the plant makes some 100."""

Talk = list[tuple[str, Message, float]]

WAITS_S = st.sampled_from([0.0, 0.0, 0.01, 1.0, 5.0, 30.0])

TALKS = st.lists(st.tuples(UTTERANCES.sender(), UTTERANCES.any(), WAITS_S), min_size=1, max_size=10)


def listen(actor: Played, talk: Talk) -> None:
    """Let an agent hear it all, as it comes from the wire, and live on for a while."""
    actor.effects.clear()
    for sender, message, wait_s in talk:
        sender_read, read = decode(encode(sender, message))
        actor.on_message(sender_read, read, actor.now_s)
        check(actor)
        if wait_s:
            actor.run(actor.now_s + wait_s)
            check(actor)
    actor.run(actor.now_s + SETTLE_S)
    check(actor)


def check(actor: Played) -> None:
    """What it wants done can be done."""
    assert actor.busiest <= MOST_EFFECTS, f"{actor.busiest} effects of one event"
    for message in spoken(actor.effects):
        assert not fault_in(message), message
    actor.effects.clear()


def fault_in(message: Message) -> str:
    """Why its peers cannot read it; empty when they can."""
    try:
        decode(encode("ATV1", message))
    except WireError as fault:
        # Sums of absurd numbers may pass the bounds; that harms nobody, for nobody reads them.
        return "" if fault.reason.startswith(("Expected `float`", "Expected `int`")) else fault.reason
    return ""


def spoken(effects: list[Effect]) -> list[Message]:
    """All that goes over the wire, facts as the worker publishes them."""
    messages: list[Message] = []
    for effect in effects:
        if isinstance(effect, Send | Publish):
            messages.append(effect.message)
        elif isinstance(effect, Record):
            messages.append(Event(agent="ATV1", incarnation=1, number=1, at_s=0.0, fact=effect.fact))
    return messages


@pytest.mark.parametrize("kind", variants(MESSAGE_TYPES, *MESSAGE_TYPES[::3]), ids=lambda kind: kind.__name__)
def test_no_message_of_any_type_ends_an_agent_in_any_situation(kind: type[Message]) -> None:
    @settings(max_examples=examples(10))
    @given(
        st.lists(st.tuples(UTTERANCES.sender(), UTTERANCES.message(kind), WAITS_S), min_size=1, max_size=3)
    )
    def everybody_hears(talk: Talk) -> None:
        for situation in SITUATIONS:
            listen(situation(), talk)

    everybody_hears()


@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda situation: situation.__name__)
def test_no_talk_ends_an_agent(situation: Callable[[], Played]) -> None:
    @settings(max_examples=examples(15))
    @given(TALKS)
    def hears(talk: Talk) -> None:
        listen(situation(), talk)

    hears()


@pytest.mark.parametrize("situation", SITUATIONS, ids=lambda situation: situation.__name__)
def test_no_talk_keeps_an_agent_from_leaving(situation: Callable[[], Played]) -> None:
    @settings(max_examples=examples(10))
    @given(TALKS, TALKS)
    def hears_and_leaves(before: Talk, meanwhile: Talk) -> None:
        actor = situation()
        listen(actor, before)
        asked_s = actor.now_s
        actor.leave(asked_s)
        listen(actor, meanwhile)
        actor.run(asked_s + CARRIER_LEAVES_WITHIN_S)
        assert actor.agent is None

    hears_and_leaves()


@settings(max_examples=examples(60))
@given(st.tuples(UTTERANCES.sender(), UTTERANCES.any(), WAITS_S), st.sampled_from(SITUATIONS), st.data())
def test_damaged_bytes_end_no_agent(
    said: tuple[str, Message, float], situation: Callable[[], Played], data: st.DataObject
) -> None:
    sender, message, wait_s = said
    whole = bytearray(encode(sender, message))
    for _ in range(data.draw(st.integers(1, 3))):
        whole[data.draw(st.integers(0, len(whole) - 1))] = data.draw(st.sampled_from(b'0123456789-."aMS'))
    try:
        sender, message = decode(bytes(whole))
    except WireError:
        return
    listen(situation(), [(sender, message, wait_s)])
