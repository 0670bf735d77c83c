"""Lets the tests here import the kits of the protocol's tests and of the properties'."""

from __future__ import annotations

import sys
from pathlib import Path

from examples import examples
from hypothesis import settings

TESTS = Path(__file__).parents[1]
sys.path[:0] = [str(TESTS / room) for room in ("fuzz", "properties/kits", "protocol/kits")]

# As in `tests/properties`: no deadline, and the same examples for everybody.
settings.register_profile("dray", deadline=None, derandomize=True, max_examples=examples(300))
settings.load_profile("dray")
