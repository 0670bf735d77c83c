"""Whether a message is older than the newest one of its sender, by life and number.

A thief of the sender's certificate can state any life and number, once. If that number counted for ever, the sender's own messages
would be old for ever, in all its lives: each restart raises the life by one only. So a number counts against lower ones for as
long as one of these may still be on its way.
"""

from __future__ import annotations

OVERTAKES_S = 35.0
"""Time for which a message makes lower numbers old (s): a bus with certificates accepts what was said up to 30 s ago
(`dray.adapters.security.seals.FRESH_S`), and clocks differ by some seconds. So no message is replayed as a new one."""


def is_overtaken(said: tuple[int, int], newest: tuple[int, int], heard_s: float, now_s: float) -> bool:
    """Whether a newer message has overtaken this one.

    Args:
        said: the message's life and number.
        newest: those of the newest message of the same sender.
        heard_s: when that one came.
        now_s: the present time.
    """
    return said <= newest and now_s - heard_s <= OVERTAKES_S
