"""The decisions: pure functions and state machines with no I/O, no clock and no chance.

Every agent is `handle(event, now_s) -> effects`. See `events` for both.
"""
