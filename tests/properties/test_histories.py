"""Whatever is lost, late or doubled, and whoever starts anew: in the end all that an agent keeps is stored.

The model is one agent with a journal, a bus that loses, doubles and delays, a thief of the agent's certificate that names far lives and
numbers, and a database. A historian that starts anew knows only what is in the database.
"""

from __future__ import annotations

from collections import deque
from itertools import groupby

from hypothesis import given
from hypothesis import strategies as st

from dray.messages import EventsAsked, EventsKept
from dray.messages.base import COUNT_MAX
from dray.messages.history import EVENTS_PER_ANSWER, HISTORY_KEPT, LIVES_TOLD, LifeKept
from dray.store.history.gaps import LIVES, Gaps, Known

AGENT = "ATV1"

EVENTS_KEPT = 400
"""Events in the agent's journal: fewer than some runs tell."""

LIVES_MOST = 30
"""Lives of one run: an answer tells of all that are kept."""

WITHIN_S = 900.0
"""After the last trouble, everything is stored: the longest pause between two questions is a minute."""

Key = tuple[int, int]
"""Life and number."""

Said = Key | int | EventsKept | EventsAsked
"""An event, a heartbeat with its life, an answer, a question."""

TROUBLE = [
    "restart",
    "historian",
    "deliver",
    "deliver",
    "deliver",
    "ask",
    "lose",
    "double",
    "tell",
    "wait",
    "away",
]

STEPS = st.tuples(st.sampled_from(TROUBLE), st.integers(0, 40))

FORGED = st.tuples(st.sampled_from(["thief"]), st.integers(0, 40))


class World:
    """One agent, the bus, and a historian.

    Args:
        tells_lives: whether the agent's answers tell of its earlier lives.
    """

    def __init__(self, *, tells_lives: bool) -> None:
        self.tells_lives = tells_lives
        self.now_s = 0.0
        self.life, self.told = 1, 0
        self.journal: deque[Key] = deque(maxlen=EVENTS_KEPT)
        self.way: list[Said] = []
        self.written: set[Key] = set()
        self.unwritten: set[Key] = set()
        self.gaps = Gaps(agents=[AGENT])

    def step(self, what: str, how: int) -> None:
        match what:
            case "tell":
                self.tell(how)
            case "restart":
                self.restart()
            case "away":
                # Some lives, and nobody listens.
                for _ in range(how % 8):
                    self.tell(how % 5)
                    self.restart()
                self.way.clear()
                self.begin_historian()
            case "historian":
                self.begin_historian()
            case "ask":
                self.ask()
            case "wait":
                self.wait(float(how))
            case "thief":
                further = (0, 0, 1, 3, COUNT_MAX - self.life)[how % 5]
                number = (
                    (self.told + 5_000, COUNT_MAX)[how % 2] if not further else (1, 5_000, COUNT_MAX)[how % 3]
                )
                self.way.append((self.life + further, number))
            case _ if self.way:
                said = self.way[how % len(self.way)]
                if what != "double":
                    self.way.remove(said)
                if what != "lose":
                    self.deliver(said)

    def tell(self, count: int) -> None:
        for _ in range(count):
            self.told += 1
            self.journal.append((self.life, self.told))
            self.way.append((self.life, self.told))

    def restart(self) -> None:
        if self.life < LIVES_MOST:
            self.life, self.told = self.life + 1, 0
            self.way.append(self.life)

    def wait(self, for_s: float) -> None:
        self.now_s += for_s
        self.written |= self.unwritten
        self.unwritten.clear()
        self.way.append(self.life)

    def begin_historian(self) -> None:
        """What is not written yet is lost, and all that was known beside the database."""
        self.unwritten.clear()
        lives = [
            (life, {number for _, number in each})
            for life, each in groupby(sorted(self.written), lambda key: key[0])
        ]
        known: list[Known] = []
        for life, there in lives[-LIVES:]:
            last = max(there)
            start = max(1, last - HISTORY_KEPT + 1)
            missing = tuple(each for each in range(start, last + 1) if each not in there)
            known.append(Known(AGENT, life, last, missing, is_first_asked=not known and len(lives) > LIVES))
        self.gaps = Gaps(known, self.now_s, [AGENT])

    def ask(self) -> None:
        self.way += [question for _, question in self.gaps.due(self.now_s)]

    def deliver(self, said: Said) -> None:
        match said:
            case EventsAsked():
                self.way += self.answer(said)
            case EventsKept():
                self.gaps.answered(AGENT, said, self.now_s)
            case int():
                self.gaps.note_alive(AGENT, said, self.now_s)
            case life, number:
                self.gaps.note(AGENT, life, number, self.now_s)
                self.unwritten.add((life, number))

    def answer(self, asked: EventsAsked) -> list[Said]:
        """As `dray.worker` does."""
        lives = {
            life: [number for _, number in each] for life, each in groupby(self.journal, lambda key: key[0])
        }
        kept = lives.get(asked.incarnation, [])
        wanted = [number for number in kept if asked.first <= number <= asked.last][:EVENTS_PER_ANSWER]
        earlier = tuple(LifeKept(life, each[0], each[-1]) for life, each in lives.items() if life < self.life)
        first, last = (kept[0], kept[-1]) if kept else (1, 0)
        told = earlier[-LIVES_TOLD:] if self.tells_lives else None
        answer = EventsKept(
            incarnation=asked.incarnation, first=first, last=last, life=self.life, earlier=told
        )
        return [*((asked.incarnation, number) for number in wanted), answer]

    def settle(self) -> set[Key]:
        """Nothing is lost any more; returns what the agent keeps and the database lacks."""
        for said in self.way:
            if isinstance(said, EventsKept | tuple):
                self.deliver(said)
        self.way.clear()
        until_s = self.now_s + WITHIN_S
        while self.now_s < until_s and not self.written.issuperset(self.journal):
            self.wait(1.0)
            self.ask()
            while self.way:
                self.deliver(self.way.pop(0))
        return set(self.journal) - self.written


@given(st.lists(STEPS | FORGED, max_size=60))
def test_all_that_an_agent_keeps_is_stored_in_the_end(steps: list[tuple[str, int]]) -> None:
    world = World(tells_lives=True)
    for what, how in steps:
        world.step(what, how)
    assert world.settle() == set()


@given(st.lists(STEPS, max_size=60))
def test_it_is_stored_too_when_answers_do_not_tell_of_earlier_lives(steps: list[tuple[str, int]]) -> None:
    world = World(tells_lives=False)
    for what, how in steps:
        world.step(what, how)
    assert world.settle() == set()
