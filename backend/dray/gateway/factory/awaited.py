"""Commands that were sent: each known by its name, and how many wait for their answers."""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Generic, TypeVar

from dray.gateway.http.problems import Problem

PENDING = 1_000
"""Commands that wait for an answer at once: some per vehicle of the largest plant."""

PENDING_EACH = 400
"""Of one caller: all vehicles of a large plant. One caller cannot use up PENDING."""

NAMES_KEPT = 2_000
"""Commands that are known by their names when they are sent again: more than may wait at once."""

S = TypeVar("S")


class Awaited(Generic[S]):
    """Commands of one way.

    Args:
        life: begins the names of commands that their callers have not named; differs in every life of the gateway.
    """

    def __init__(self, life: str) -> None:
        self._life = life
        self._sent: OrderedDict[str, S] = OrderedDict()
        """By their names, the oldest first."""
        self._waiting: Counter[str] = Counter()
        """How many wait, by who asked."""
        self._count = 0

    def __contains__(self, name: str) -> bool:
        return name in self._sent

    def get(self, name: str) -> S | None:
        """The command of this name; None for one that was not sent, or long ago."""
        return self._sent.get(name)

    def newest_first(self) -> Iterator[tuple[str, S]]:
        """Those that are known, with their names."""
        return reversed(self._sent.items())

    def keep(self, name: str, sent: S) -> S:
        """Know it by its name from now on."""
        self._sent[name] = sent
        if len(self._sent) > NAMES_KEPT:
            self._sent.popitem(last=False)
        return sent

    def refuse_too_many(self, who: str) -> None:
        """Let nobody ask for more while so many wait.

        Raises:
            Problem: 503, too many wait, in all or of this caller.
        """
        for waiting, most in ((self._waiting.total(), PENDING), (self._waiting[who], PENDING_EACH)):
            if waiting >= most:
                raise Problem(
                    HTTPStatus.SERVICE_UNAVAILABLE,
                    "too-many-commands",
                    "Too many commands wait for an answer",
                    f"{most} vehicles were asked and have not answered yet; try again in some seconds",
                    headers={"Retry-After": "3"},
                )

    @contextmanager
    def waiting(self, who: str) -> Iterator[None]:
        """While this lasts, a caller waits for an answer."""
        self._waiting[who] += 1
        try:
            yield
        finally:
            self._waiting[who] -= 1
            if not self._waiting[who]:
                del self._waiting[who]

    def new_name(self) -> str:
        """A name that no command has: callers may have chosen one that looks like ours."""
        while True:
            self._count += 1
            name = f"{self._life}-{self._count}"
            if name not in self._sent:
                return name
