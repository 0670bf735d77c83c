"""Reports on the bus which vehicles people have carried away, and where they put them back; in service a gateway does so.

A report is repeated until the vehicle is heard. The leader of its table confirms that a returning vehicle's place is
kept; nobody puts the vehicle down before.
"""

from __future__ import annotations

import asyncio
from collections.abc import Iterable
from dataclasses import dataclass

from dray.adapters.security.signing import SigningKey
from dray.messages import AtvHeartbeat, Event, Message, Removal, Removals
from dray.messages.fact import PlaceKept
from dray.messages.floor.removal import MAX_REMOVALS
from dray.messages.keys import Keys
from dray.ports import Bus, Clock
from dray.protocol.liveness.suspicion import IDLE_INTERVAL_S, gone_s

NAME = "floor-office"
"""Its name on the bus, and the person in whose name it speaks by default."""

SAY_EVERY_S = 2.0
"""Between two times that the words are said."""

GRANT_S = 60.0
"""Validity of a report that was said once."""

KEPT_WITHIN_S = gone_s(IDLE_INTERVAL_S) + 30.0
"""Longest time until a place is kept: a vehicle must have been silent for so long, and the answer takes a little. A
place that is not kept by then is held by a vehicle that does not leave, so another place is asked for."""


CARELESS_S = 2.0
"""A vehicle that was heard this recently is present, even if a report says that it is away."""


@dataclass(frozen=True, slots=True)
class Word:
    """A word that is said until the vehicle is heard."""

    number: int
    heard: tuple[int, int]
    node: str
    person: str
    areas: tuple[str, ...] | None
    at_s: float
    """When it was said first."""


class FloorOffice:
    """The floor office of one factory.

    Args:
        bus: joined at once.
        clock: the plant's clock.
        keys: the plant's keys.
        authority: signs the words.

    Attributes:
        heard: vehicle -> its newest heartbeat.
    """

    def __init__(self, bus: Bus, clock: Clock, keys: Keys, authority: SigningKey) -> None:
        self.heard: dict[str, AtvHeartbeat] = {}
        self._session = bus.join(NAME, self._on_message)
        self._session.subscribe(keys.all_atv_heartbeats)
        self._session.subscribe(keys.all_events)
        self._clock, self._key, self._authority = clock, keys.removals, authority
        self._numbers: dict[str, int] = {}
        self._words: dict[str, Word] = {}
        self._ended: dict[str, Word] = {}
        """Last report of each vehicle that is back."""
        self._heard_s: dict[str, float] = {}
        self._kept: set[tuple[str, int]] = set()
        self._news = asyncio.Event()

    async def run(self) -> None:
        """Repeat the valid reports until cancelled."""
        while True:
            self._say(self._words)
            await asyncio.sleep(SAY_EVERY_S)

    def carry_away(self, atv: str, person: str = NAME, areas: tuple[str, ...] | None = None) -> None:
        """A vehicle is off the floor: say so."""
        self._begin(atv, "", person, areas)

    async def put_back(
        self, atv: str, node: str, person: str = NAME, areas: tuple[str, ...] | None = None
    ) -> bool:
        """Have a place kept for a vehicle that is off the floor; True when it is, and the vehicle may be put down there."""
        number = self._begin(atv, node, person, areas)
        until_s = self._clock.now_s() + KEPT_WITHIN_S
        while (atv, number) not in self._kept:
            left_s = until_s - self._clock.now_s()
            if left_s <= 0.0:
                return False
            self._news.clear()
            await asyncio.wait({asyncio.ensure_future(self._news.wait())}, timeout=left_s)
        return True

    def say_carelessly(self, atv: str) -> None:
        """Report once that a vehicle was carried away though it is heard; and repeat the last report of one that is back.

        No agent should believe it.
        """
        last = self.heard.get(atv)
        if atv in self._words or last is None:
            return
        if atv in self._ended:
            self._publish([self._signed(atv, self._ended[atv])])
        now_s = self._clock.now_s()
        if now_s - self._heard_s[atv] > CARELESS_S:
            return
        word = Word(self._numbers.get(atv, 0) + 1, (last.incarnation, last.seq), "", NAME, None, now_s)
        self._numbers[atv] = word.number
        self._publish([self._signed(atv, word)])

    def _begin(self, atv: str, node: str, person: str, areas: tuple[str, ...] | None) -> int:
        last = self.heard.get(atv)
        heard = (last.incarnation, last.seq) if last is not None else (0, 0)
        number = self._numbers[atv] = self._numbers.get(atv, 0) + 1
        self._words[atv] = Word(number, heard, node, person, areas, self._clock.now_s())
        self._say([atv])
        return number

    def _say(self, atvs: Iterable[str]) -> None:
        self._publish([self._signed(atv, self._words[atv]) for atv in atvs])

    def _publish(self, removals: list[Removal]) -> None:
        for first in range(0, len(removals), MAX_REMOVALS):
            self._session.publish(self._key, Removals(removals=tuple(removals[first : first + MAX_REMOVALS])))

    def _signed(self, atv: str, word: Word) -> Removal:
        now_s = self._clock.now_s()
        return self._authority.remove(
            atv,
            word.number,
            heard=word.heard,
            node=word.node,
            person=word.person,
            areas=word.areas,
            reported_s=word.at_s,
            now_s=now_s,
            valid_until_s=now_s + GRANT_S,
        )

    def _on_message(self, _sender: str, message: Message) -> None:
        if isinstance(message, AtvHeartbeat):
            said = (message.incarnation, message.seq)
            last = self.heard.get(message.atv)
            if last is None or said > (last.incarnation, last.seq):
                self.heard[message.atv] = message
                self._heard_s[message.atv] = self._clock.now_s()
            word = self._words.get(message.atv)
            if word is not None and said > word.heard:
                self._ended[message.atv] = self._words.pop(message.atv)
        elif isinstance(message, Event) and isinstance(message.fact, PlaceKept):
            self._kept.add((message.fact.atv, message.fact.number))
            self._news.set()
