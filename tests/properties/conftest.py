"""Lets the tests here import the kit of the protocol's tests, and makes every run the same."""

from __future__ import annotations

import sys
from pathlib import Path

from hypothesis import settings

sys.path.insert(0, str(Path(__file__).parents[1] / "protocol"))

# No deadline: a slow machine is no failure. The same examples for everybody: a failure that one run
# finds is found by the next one, too.
settings.register_profile("dray", deadline=None, derandomize=True, max_examples=300)
settings.load_profile("dray")
