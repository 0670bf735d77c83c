"""Lets the tests here import their kits and those of the protocol; makes every run the same."""

from __future__ import annotations

import sys
from pathlib import Path

from examples import examples
from hypothesis import settings

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / room) for room in ("properties/kits", "protocol/kits")]

# No deadline: a slow machine is no failure. The same examples for everybody: a failure that one run
# finds is found by the next one, too.
settings.register_profile("dray", deadline=None, derandomize=True, max_examples=examples(300))
settings.load_profile("dray")
