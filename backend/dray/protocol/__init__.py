"""The decisions: pure functions and state machines with no I/O, no clock and no randomness.

Every agent is `handle(event, now_s) -> effects`. See `runtime.events` for both, and README.md for where a rule is kept.
"""
