"""Whether a message is older than the newest one of its speaker, or about its subject, by number.

A thief of a certificate can state any number, once. If that number counted for ever, the owner's own messages would be old for ever,
in all its lives: each restart raises the life by one only. So a number counts against lower ones for as long as one of these may
still be on its way. A lower one that comes later counts, and later ones are compared with it.
"""

from __future__ import annotations

from typing import Generic, TypeVar

OVERTAKES_S = 35.0
"""Time for which a message makes lower numbers old (s, plant clock): a bus with certificates accepts what was said up to 30 s ago
(`dray.adapters.security.seals.FRESH_S`), and clocks differ by some seconds. So no message is replayed as a new one."""

KEPT = 20_000
"""Maximum remembered speakers or subjects: twice the vehicles of the largest plant."""

Number = tuple[int, ...]
"""A message's number, as life and sequence; the parts that come first weigh more."""

K = TypeVar("K")


class LatestNumber:
    """The newest message of one speaker, or about one subject.

    Args:
        number: its number.
        heard_s: when it came.
    """

    __slots__ = ("heard_s", "number")

    def __init__(self, number: Number, heard_s: float) -> None:
        self.number, self.heard_s = number, heard_s

    def overtakes(self, number: Number, now_s: float) -> bool:
        """Whether it makes a message with this number old, its own included."""
        # After the clock was set back, the time counts from now.
        self.heard_s = min(self.heard_s, now_s)
        return number <= self.number and now_s - self.heard_s <= OVERTAKES_S

    def takes(self, number: Number, now_s: float) -> bool:
        """Take a message as the newest one; False if it is old."""
        if self.overtakes(number, now_s):
            return False
        self.number, self.heard_s = number, now_s
        return True

    def stands(self, number: Number, now_s: float) -> bool:
        """Take a statement that its speakers repeat as it is; False if it is old. A repetition makes lower numbers old anew."""
        if number == self.number:
            self.heard_s = now_s
            return True
        return self.takes(number, now_s)


class LatestNumbers(Generic[K]):
    """The newest message of each speaker, or about each subject.

    Args:
        kept: maximum number of them; the one heard least lately is forgotten first.
    """

    __slots__ = ("_kept", "_newest")

    def __init__(self, kept: int = KEPT) -> None:
        self._newest: dict[K, LatestNumber] = {}
        self._kept = kept

    def takes(self, of: K, number: Number, now_s: float) -> bool:
        """Take a message as the newest one; False if it is old."""
        newest = self._newest.get(of)
        if newest is not None and not newest.takes(number, now_s):
            return False
        self._put(of, newest or LatestNumber(number, now_s))
        return True

    def stands(self, of: K, number: Number, now_s: float) -> bool:
        """See `LatestNumber.stands`."""
        newest = self._newest.get(of) or LatestNumber(number, now_s)
        self._put(of, newest)
        return newest.stands(number, now_s)

    def of(self, of: K, known: Number, now_s: float, since_s: float | None = None) -> LatestNumber:
        """The newest statement about a subject.

        Args:
            of: the subject.
            known: the number of what stands, perhaps since an earlier life.
            now_s: the present time.
            since_s: when that counts as heard if it was not heard here; None for now.
        """
        newest = self._newest.get(of)
        if newest is None or newest.number != known:
            newest = LatestNumber(known, now_s if since_s is None else since_s)
        self._put(of, newest)
        return newest

    def heard_s(self, of: K) -> float | None:
        """When the newest one came; None without any."""
        newest = self._newest.get(of)
        return None if newest is None else newest.heard_s

    def forget(self, of: K) -> None:
        """Forget a speaker or subject; harmless for an unknown one."""
        self._newest.pop(of, None)

    def _put(self, of: K, newest: LatestNumber) -> None:
        self._newest.pop(of, None)
        self._newest[of] = newest
        if len(self._newest) > self._kept:
            del self._newest[next(iter(self._newest))]
