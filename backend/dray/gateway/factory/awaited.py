"""Commands that were sent, by name, and how many wait for answers."""

from __future__ import annotations

from collections import Counter, OrderedDict
from collections.abc import Iterator
from contextlib import contextmanager
from http import HTTPStatus
from typing import Generic, TypeVar

from dray.gateway.http.problems import Problem

PENDING = 1_000
"""Maximum commands waiting for an answer: some per vehicle of the largest plant."""

PENDING_EACH = 400
"""Maximum of one caller: all vehicles of a large plant, but less than PENDING."""

NAMES_KEPT = 2_000
"""Commands remembered by name, to recognise repetitions: more than may wait at once."""

S = TypeVar("S")


class Awaited(Generic[S]):
    """Commands sent one way.

    Args:
        life: prefix of names that the gateway makes; differs in every run of the gateway.
    """

    def __init__(self, life: str) -> None:
        self._life = life
        self._sent: OrderedDict[str, S] = OrderedDict()
        """Sent commands by name, oldest first."""
        self._waiting: Counter[str] = Counter()
        """Number of waiting commands per caller."""
        self._count = 0

    def __contains__(self, name: str) -> bool:
        return name in self._sent

    def get(self, name: str) -> S | None:
        """The command of this name; None if never sent, or forgotten."""
        return self._sent.get(name)

    def newest_first(self) -> Iterator[tuple[str, S]]:
        """The remembered commands with their names."""
        return reversed(self._sent.items())

    def keep(self, name: str, sent: S) -> S:
        """Remember a command by its name."""
        self._sent[name] = sent
        if len(self._sent) > NAMES_KEPT:
            self._sent.popitem(last=False)
        return sent

    def refuse_too_many(self, who: str) -> None:
        """Refuse a new command while too many wait.

        Raises:
            Problem: 503, too many wait, in total or of this caller.
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
        """Count a waiting command of this caller within the context."""
        self._waiting[who] += 1
        try:
            yield
        finally:
            self._waiting[who] -= 1
            if not self._waiting[who]:
                del self._waiting[who]

    def new_name(self) -> str:
        """A new name: a caller may have chosen one that looks like ours."""
        while True:
            self._count += 1
            name = f"{self._life}-{self._count}"
            if name not in self._sent:
                return name
